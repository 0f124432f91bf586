//! Claims about changes: exact probabilities of wrong verdicts, and verdicts of the program.

use std::fs;

use serde_json::Value;
use stiction::results::claims::{ChangeClaim, GroupChanges, Judgement, judge_changes};
use stiction::scenario::ClaimSpec;
use stiction::statistics::probability as binomial;

use crate::cli::Place;

const ALPHA: f64 = 0.05;

/// True if changes of these signs have the verdict.
fn has(claim: &ChangeClaim, above: impl Iterator<Item = bool>, verdict: Judgement) -> bool {
    let changes = above.map(|above| Some(if above { 1.0 } else { -1.0 })).collect();
    let group = GroupChanges { changes, ..GroupChanges::default() };
    judge_changes(claim, &[group])[0].verdict == verdict
}

/// Probability of the verdict, where each change is above the limit with the probability `above`: over
/// all sequences of few pairs, by the number of changes above for more.
fn probability(claim: &ChangeClaim, pairs: usize, above: f64, verdict: Judgement) -> f64 {
    let of = |ones: usize| above.powi(ones as i32) * (1.0 - above).powi((pairs - ones) as i32);
    if pairs > 7 {
        let shown = (0..=pairs).filter(|ones| has(claim, (0..pairs).map(|i| i < *ones), verdict));
        return shown.map(|ones| binomial(pairs, ones, above)).sum();
    }
    let sequences = (0..1_u32 << pairs).filter(|signs| has(claim, (0..pairs).map(|i| signs >> i & 1 == 1), verdict));
    sequences.map(|signs| of(signs.count_ones() as usize)).sum()
}

#[test]
fn verdicts_are_wrong_at_most_as_often_as_stated() {
    let mut greatest: f64 = 0.0;
    for quantile in [0.5, 0.8] {
        let change = Some("steps".to_owned());
        let spec = ClaimSpec { change, quantile: Some(quantile), at_most: Some(0.0), ..ClaimSpec::default() };
        let claim = ChangeClaim { scenario: "s".into(), claim: spec };
        for pairs in [1, 2, 4, 5, 6, 7, 8, 11, 20, 29] {
            // The quantile is above the limit if more changes are above it than this share.
            let border = 1.0 - quantile;
            for part in [0.0, 0.3, 1.0] {
                let (false_, true_) = (border + (1.0 - border) * part, border * (1.0 - part));
                let holds = probability(&claim, pairs, false_, Judgement::Holds);
                let fails = probability(&claim, pairs, true_, Judgement::Fails);
                // Rounding of the sum.
                assert!(holds <= ALPHA * (1.0 + 1e-12), "{quantile} {pairs} {part}: {holds}");
                assert!(fails <= ALPHA * (1.0 + 1e-12), "{quantile} {pairs} {part}: {fails}");
                greatest = greatest.max(holds).max(fails);
            }
        }
    }
    assert!(greatest > 0.8 * ALPHA, "some case comes close to what is allowed: {greatest}");
}

/// A block slides from random speeds: its distance is v^2 / (2 mu g).
const SLIDE: &str = "base = { linear_velocity = [1, 0, 0] }\n[sweep.random]\nsamples = 8\n\
    \"robot.base.linear_velocity.0\" = { uniform = [0.5, 1.0] }\n\
    [sweep.grid]\n\"contact.method\" = [\"exact\", \"one-step\"]\n";

/// At most 10 % and 40 % farther at 0.5 m/s (0.0255 m), in all pairs.
fn claims(limits: &[(&str, f64)]) -> String {
    let claim = |(name, limit): &(&str, f64)| {
        format!(
            "[[claim]]\nname = \"{name}\"\nchange = \"final_base_x\"\nat_most = {limit}\nper = [\"contact.method\"]\n"
        )
    };
    limits.iter().map(claim).collect()
}

fn run(place: &Place, friction: &str, output: &str, more: &[&str]) -> crate::cli::Done {
    let friction = format!("floor.friction={friction}");
    let arguments = ["s.toml", "--set", "duration=0.5", "--set", &friction, "--no-log", "-o", output];
    place.runner(&[&arguments, more].concat())
}

#[test]
fn a_batch_says_that_a_claim_needs_a_baseline_and_a_comparison_judges_it() {
    let place = Place::new();
    place.block("s.toml", &format!("{SLIDE}{}", claims(&[("little", 1e-5), ("more", 0.1)])));
    let done = run(&place, "0.5", "a", &["--strict"]).exits(0);
    assert!(
        done.stderr.contains("note: `claim.0` needs a baseline: this command does not judge it"),
        "{}",
        done.stderr
    );
    assert!(done.stderr.contains("`runner compare --baseline BASE RESULTS` does"), "{}", done.stderr);
    run(&place, "0.4", "b", &[]).exits(0);
    let judge = |a: &str, b: &str, code: i32| -> Vec<(String, String, String)> {
        let done = place.runner(&["compare", "--baseline", a, b, "--format", "json", "--absolute", "inf"]).exits(code);
        let compared: Value = serde_json::from_str(&done.stdout).unwrap();
        let text = |claim: &Value, name: &str| claim[name].as_str().unwrap().to_owned();
        let claims = compared["results"][0]["claims"].as_array().unwrap().clone();
        claims.iter().map(|c| (text(c, "claim"), text(c, "group"), text(c, "verdict"))).collect()
    };
    let expected = |little: &str, more: &str| -> Vec<(String, String, String)> {
        let each = |name: &str, verdict: &str| {
            ["exact", "one-step"].map(|m| (name.to_owned(), format!("contact.method={m}"), verdict.to_owned()))
        };
        [each("little", little), each("more", more)].concat()
    };
    assert_eq!(judge("a", "b", 1), expected("fails", "holds"));
    assert_eq!(judge("b", "a", 0), expected("holds", "holds"), "less far is no change beyond the limit");
    assert_eq!(judge("a", "a", 0), expected("holds", "holds"));
    // Against a history, with the same verdicts.
    place.runner(&["compare", "--baseline", "h", "--append", "a"]).exits(0);
    assert_eq!(judge("h", "b", 1), expected("fails", "holds"));
    // The old form judges no claim.
    place.runner(&["compare", "a", "b", "--absolute", "inf"]).exits(0);
    let text = place.runner(&["compare", "--baseline", "a", "b", "--absolute", "inf"]).exits(1).stdout;
    let statement = "median of the change of final_base_x against the baseline at most 0.00001";
    assert!(
        text.lines().any(|line| line.trim_start().starts_with("fails  s: little [") && line.contains(statement)),
        "{text}"
    );
    assert!(text.contains("8 of 8 pairs"), "{text}");
}

#[test]
fn few_pairs_are_undecided_and_missing_runs_count_for_both_sides() {
    let place = Place::new();
    place.block("s.toml", &format!("{SLIDE}{}", claims(&[("more", 0.1)])));
    run(&place, "0.5", "a", &[]).exits(0);
    run(&place, "0.4", "b", &[]).exits(0);
    let rows = fs::read_to_string(place.path("a/summary.csv")).unwrap();
    let compare = |runs: usize, code: i32| -> Value {
        // Header, and the first runs of the baseline.
        place.write("part/summary.csv", rows.lines().take(1 + runs).collect::<Vec<_>>().join("\n") + "\n");
        // Runs of only one of the results are a difference; values are not.
        let arguments = ["compare", "--baseline", "part", "b", "--absolute", "inf", "--format", "json"];
        let compared: Value = serde_json::from_str(&place.runner(&arguments).exits(code).stdout).unwrap();
        compared["results"][0]["claims"][0].clone()
    };
    // 8 pairs per method. 7 of 8 show it: 9 / 256 = 0.035; 6 of 8 do not: 37 / 256.
    let (all, one_less, two_less) = (compare(16, 0), compare(14, 1), compare(12, 1));
    let of = |claim: &Value| (claim["verdict"].as_str().unwrap().to_owned(), claim["used"].as_u64().unwrap());
    assert_eq!(of(&all), ("holds".to_owned(), 8));
    assert_eq!(of(&one_less), ("holds".to_owned(), 7));
    assert_eq!(of(&two_less), ("undecided".to_owned(), 6));
    assert_eq!(two_less["planned"], 8);
    // Undecided alone has its own code.
    let few = ["--set", "sweep.random.samples=4"];
    let done = run(&place, "0.5", "few-a", &few).exits(0);
    assert!(
        done.stderr.contains("`claim.0` cannot hold with 4 pairs of runs each: it needs at least 5"),
        "{}",
        done.stderr
    );
    run(&place, "0.4", "few-b", &few).exits(0);
    place.runner(&["compare", "--baseline", "few-a", "few-b", "--absolute", "inf"]).exits(5);
}

#[test]
fn merged_shards_have_the_claims_of_the_whole() {
    let place = Place::new();
    let plain = "[[claim]]\nname = \"passes\"\nshare = { outcome = \"passed\" }\nat_least = 0.5\n";
    place.block("s.toml", &format!("{SLIDE}{}{plain}", claims(&[("more", 0.1)])));
    run(&place, "0.5", "whole", &[]).exits(0);
    for part in ["1/2", "2/2"] {
        run(&place, "0.5", &format!("part{}", &part[..1]), &["--shard", part]).exits(0);
    }
    place.runner(&["merge", "part1", "part2", "-o", "merged"]).exits(0);
    let text = |folder: &str| fs::read_to_string(place.path(folder).join("claims.json")).unwrap();
    assert_eq!(text("merged"), text("whole"));
    let file: Value = serde_json::from_str(&text("whole")).unwrap();
    assert_eq!((file["claims"].as_array().unwrap().len(), file["changes"].as_array().unwrap().len()), (1, 1));
    // Claims of the batch are kept with the history, and a changed verdict is a difference.
    place.runner(&["compare", "--baseline", "h", "--append", "whole"]).exits(0);
    let strict = ["--set", "claim.1.share={ metric = \"final_base_x\", max = 0.0 }"];
    run(&place, "0.5", "strict", &strict).exits(1);
    let done = place.runner(&["compare", "--baseline", "h", "strict"]).exits(1);
    assert!(done.stdout.contains("claim: s: passes: holds in A, fails in B"), "{}", done.stdout);
}
