//! The verdicts of a batch do not depend on threads, interruptions, shards or other runs.

use std::fs;

use serde_json::Value;

use crate::cli::Place;

/// A block slides for 0.02 s from a random speed of 0.5 to 1.5 m/s: x = v t - mu g t^2 / 2 with mu =
/// 0.5, so that x is uniform from 9 to 29 mm.
pub const BLOCK: &str = "base = { linear_velocity = [1, 0, 0] }\n\
    [log]\nrate = 0\n\
    [integrator]\nmethod = \"semi-implicit\"\nstep = 1e-3\n\
    [sweep.random]\nsamples = 80\n\"robot.base.linear_velocity.0\" = { uniform = [0.5, 1.5] }\n\
    [sweep.grid]\n\"contact.method\" = [\"exact\", \"one-step\"]\n";

/// Each form, decided early: true shares are 0.9, 0.1 and 0.95; paired differences are rounding.
pub const EARLY: &str = "[[claim]]\nname = \"slow\"\nshare = { metric = \"final_base_x\", max = 0.027 }\nat_least = 0.6\nearly = true\n\
    per = [\"contact.method\"]\n\
    [[claim]]\nname = \"rarely fast\"\nshare = { metric = \"final_base_x\", min = 0.027 }\nat_most = 0.5\nearly = true\n\
    per = [\"contact.method\"]\n\
    [[claim]]\nname = \"median\"\nquantile = 0.5\nmetric = \"final_base_x\"\nat_most = 0.028\nearly = true\nper = [\"contact.method\"]\n\
    [[claim]]\nname = \"same\"\ndifference = \"final_base_x\"\nbetween = { \"contact.method\" = [\"one-step\", \"exact\"] }\n\
    at_most = 1e-6\nearly = true\n";

const SHORT: [&str; 2] = ["--set", "duration=0.02"];

pub fn run(place: &Place, output: &str, arguments: &[&str]) -> crate::cli::Done {
    place.runner(&[&["claims.toml", "-o", output][..], &SHORT, arguments].concat())
}

pub fn text(place: &Place, output: &str) -> String {
    fs::read_to_string(place.path(output).join("claims.json")).unwrap()
}

/// Name, verdict and number of units that count.
pub fn verdicts(place: &Place, output: &str) -> Vec<(String, String, u64)> {
    let file: Value = serde_json::from_str(&text(place, output)).unwrap();
    let claim = |c: &Value| {
        let name = format!("{} {}", c["claim"].as_str().unwrap(), c["group"].as_str().unwrap());
        (name.trim_end().to_owned(), c["verdict"].as_str().unwrap().to_owned(), c["used"].as_u64().unwrap())
    };
    file["claims"].as_array().unwrap().iter().map(claim).collect()
}

fn runs(place: &Place, output: &str) -> usize {
    place.summary(output).rows.len()
}

#[test]
fn a_batch_ends_early_with_the_same_verdicts_for_any_number_of_threads() {
    let place = Place::new();
    place.block("claims.toml", &format!("{BLOCK}{EARLY}"));
    let done = run(&place, "one", &["-j", "1"]).exits(0);
    let all = verdicts(&place, "one");
    assert_eq!(all.len(), 7, "{all:?}");
    assert!(all.iter().all(|(_, verdict, used)| verdict == "holds" && (1..80).contains(used)), "{all:?}");
    // One thread runs what counts, and the runs of the last pair.
    let last = all.iter().map(|(_, _, used)| *used as usize).max().unwrap();
    let ran = runs(&place, "one");
    assert!((2 * last - 1..=2 * last).contains(&ran), "{ran} runs, {last} count");
    assert!(done.stdout.contains(&format!("{} runs not started, since their claims", 160 - ran)), "{}", done.stdout);
    for threads in ["2", "5"] {
        run(&place, threads, &["-j", threads]).exits(0);
        assert_eq!(text(&place, threads), text(&place, "one"));
        // Runs that other threads did while one that counts was not finished are kept, but do not count.
        assert!((ran..=160).contains(&runs(&place, threads)));
    }
    // All runs give the same verdicts: those after the decision do not count.
    place.block(
        "claims.toml",
        &format!("{BLOCK}{EARLY}[[claim]]\nname = \"all\"\nshare = {{ outcome = \"passed\" }}\nat_least = 0.9\n"),
    );
    run(&place, "all", &["-j", "2"]).exits(0);
    assert_eq!(runs(&place, "all"), 160);
    assert_eq!(verdicts(&place, "all")[..7], all);
}

#[test]
fn merged_shards_give_the_verdicts_of_one_batch() {
    let place = Place::new();
    place.block("claims.toml", &format!("{BLOCK}{EARLY}"));
    run(&place, "whole", &["-j", "1"]).exits(0);
    for filter in [&[][..], &["--filter", "robot.base.linear_velocity.0 > 0.6"]] {
        run(&place, "whole", &[filter, &["-j", "1"]].concat()).exits(0);
        let names = ["part-1", "part-2", "part-3"];
        for (i, name) in names.iter().enumerate() {
            let shard = format!("{}/3", i + 1);
            // A part knows no other runs: it ends without a verdict, after all of its own.
            run(&place, name, &[filter, &["--shard", &shard, "-j", "2"]].concat()).exits(0);
            assert!(!place.path(name).join("claims.json").exists());
        }
        let done = place.runner(&[&["merge"], &names[..], &["-o", "merged"]].concat()).exits(0);
        assert_eq!(text(&place, "merged"), text(&place, "whole"));
        assert!(done.stdout.contains("slow [contact.method=exact]"), "{}", done.stdout);
        assert!(runs(&place, "merged") > runs(&place, "whole"), "the parts ran all of their runs");
        for name in names.iter().chain(&["merged"]) {
            fs::remove_dir_all(place.path(name)).unwrap();
        }
    }
}

/// What an interrupted batch leaves is the records of some runs. Here they are those that a filter selects.
#[test]
fn a_resumed_batch_gives_the_same_verdicts_whatever_runs_exist() {
    let place = Place::new();
    place.block("claims.toml", &format!("{BLOCK}{EARLY}"));
    run(&place, "whole", &["-j", "1"]).exits(0);
    let speed = "robot.base.linear_velocity.0";
    let filters = [
        format!("{speed} < 0.55"),
        format!("{speed} < 1.0 and contact.method == \"one-step\""),
        format!("{speed} > 0.8"),
        "contact.method == \"exact\"".to_owned(),
    ];
    for (i, filter) in filters.iter().enumerate() {
        let output = format!("part-{i}");
        // The claims of a part may be undecided.
        let done = run(&place, &output, &["--filter", filter, "-j", "2"]);
        assert!([Some(0), Some(5)].contains(&done.code), "{}", done.stderr);
        let existing = runs(&place, &output);
        assert!((1..160).contains(&existing), "{existing} of {filter}");
        let done = run(&place, &output, &["--resume", "-j", "2"]).exits(0);
        assert!(done.stderr.contains("done already"), "{}", done.stderr);
        assert_eq!(text(&place, &output), text(&place, "whole"), "{filter}");
    }
    // A claim is not part of the key of a run: another limit is judged by the runs that exist.
    let before = runs(&place, "whole");
    let done = run(&place, "whole", &["--resume", "--set", "claim.0.at_least=0.55"]).exits(0);
    assert!(done.stderr.contains(&format!("resumed: {before} runs done already")), "{}", done.stderr);
    assert_eq!(runs(&place, "whole"), before);
}

#[test]
fn runs_without_a_result_count_against_the_claim() {
    let place = Place::new();
    // A tenth of the blocks is too fast to be plausible, and diverges.
    let sweep = "base = { linear_velocity = [1, 0, 0] }\n[log]\nrate = 0\n[sweep]\nrandom = { samples = 60, \
        \"robot.base.linear_velocity.0\" = { choice = [1.0, 1e7] }, \"floor.friction\" = { uniform = [0.1, 1.0] } }\n";
    let claims = "[[claim]]\nname = \"low\"\nshare = { metric = \"final_base_x\", max = 1e9 }\nat_least = 0.9\n\
        [[claim]]\nname = \"not high\"\nshare = { metric = \"final_base_x\", min = 1e9 }\nat_most = 0.1\n\
        [[claim]]\nname = \"diverges\"\nshare = { outcome = \"diverged\" }\nat_least = 0.2\n\
        [[claim]]\nname = \"median\"\nquantile = 0.9\nmetric = \"final_base_x\"\nat_most = 1e9\n";
    place.block("claims.toml", &format!("{sweep}{claims}"));
    run(&place, "results", &[]).exits(3);
    let diverged = place.summary("results").column("outcome").iter().filter(|o| **o == "diverged").count();
    assert!((15..45).contains(&diverged), "{diverged} of 60");
    let found: Vec<String> = verdicts(&place, "results").into_iter().map(|(_, verdict, _)| verdict).collect();
    assert_eq!(found, ["fails", "fails", "holds", "fails"]);
    let file: Value = serde_json::from_str(&text(&place, "results")).unwrap();
    let without: Vec<u64> =
        file["claims"].as_array().unwrap().iter().map(|c| c["without_value"].as_u64().unwrap()).collect();
    assert_eq!(without, [diverged as u64, diverged as u64, 0, diverged as u64]);
    // The share is the rest of the runs, not all of those with a result.
    assert_eq!(file["claims"][0]["estimate"].as_f64().unwrap(), (60 - diverged) as f64 / 60.0);
    assert_eq!(file["claims"][3]["estimate"], "inf");
}
