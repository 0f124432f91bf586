//! Verdicts in exit codes, messages, JUnit XML, report and terminal, and warnings before the runs.

use std::fs;

use roxmltree::{Document, Node};
use serde_json::Value;

use super::batches::{BLOCK, run, text, verdicts};
use crate::cli::Place;

/// True shares of x up to 27 mm: 0.9. One claim of each verdict, about 80 runs.
const HOLDS: &str = "[[claim]]\nname = \"holds\"\nshare = { metric = \"final_base_x\", max = 0.027 }\nat_least = 0.7\nper = [\"contact.method\"]\n";
const FAILS: &str = "[[claim]]\nname = \"fails\"\nshare = { metric = \"final_base_x\", max = 0.015 }\nat_least = 0.7\nper = [\"contact.method\"]\n";
const OPEN: &str = "[[claim]]\nname = \"open\"\nshare = { metric = \"final_base_x\", max = 0.027 }\nat_least = 0.9\nper = [\"contact.method\"]\n";
/// One method: one verdict for each claim.
const EXACT: [&str; 2] = ["--set", "contact.method=exact"];

fn place(claims: &[&str]) -> Place {
    let place = Place::new();
    place.block("claims.toml", &format!("{BLOCK}{}", claims.concat()));
    place
}

#[test]
fn exit_codes_follow_the_verdicts() {
    for (claims, code) in [
        (&[HOLDS][..], 0),
        (&[HOLDS, OPEN], 5),
        (&[HOLDS, FAILS], 1),
        (&[OPEN, FAILS], 1),
        // A failed expectation has the code of a failed claim, and precedes an undecided one.
        (&[OPEN, "[[expect]]\nmetric = \"final_base_x\"\nmax = 0.015\n"], 1),
    ] {
        let place = place(claims);
        run(&place, "results", &EXACT).exits(code);
        run(&place, "part", &[&EXACT[..], &["--shard", "1/2"]].concat());
        run(&place, "other", &[&EXACT[..], &["--shard", "2/2"]].concat());
        place.runner(&["merge", "part", "other", "-o", "merged"]).exits(code);
        assert_eq!(text(&place, "merged"), text(&place, "results"));
    }
}

#[test]
fn messages_have_one_line_per_claim_and_count_them() {
    let place = place(&[HOLDS, FAILS, OPEN]);
    let done = run(&place, "results", &[&EXACT[..], &["--message-format", "json"]].concat()).exits(1);
    let lines: Vec<Value> = done.stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let judged: Vec<&Value> = lines.iter().filter(|line| line["event"] == "claim-judged").collect();
    let names: Vec<&str> = judged.iter().map(|line| line["claim"].as_str().unwrap()).collect();
    assert_eq!(names, ["holds", "fails", "open"]);
    for line in &judged {
        let verdict = if line["claim"] == "open" { "undecided".into() } else { line["claim"].clone() };
        assert_eq!(line["verdict"], verdict);
        assert_eq!(
            (&line["used"], &line["planned"], &line["group"]),
            (&80.into(), &80.into(), &"contact.method=exact".into())
        );
        let number = |name: &str| line[name].as_f64().unwrap();
        assert!(number("lower") < number("estimate") && number("estimate") < number("upper"), "{line}");
    }
    // After the runs, before the last line.
    assert!(lines[lines.len() - 4..lines.len() - 1].iter().all(|line| line["event"] == "claim-judged"));
    let last = lines.last().unwrap();
    assert_eq!(last["claims"], serde_json::json!({ "holds": 1, "fails": 1, "undecided": 1 }));
    assert!(last["files"].as_array().unwrap().iter().any(|file| file == "results/claims.json"), "{last}");
}

#[test]
fn each_claim_is_a_case_of_its_scenario() {
    let early = OPEN.replace("open", "early").replace("at_least = 0.9", "at_least = 0.5\nearly = true");
    let place = place(&[&early]);
    run(&place, "results", &[&EXACT[..], &["-j", "1", "--junit", "early.xml"]].concat()).exits(0);
    let xml = fs::read_to_string(place.path("early.xml")).unwrap();
    let document = Document::parse(&xml).unwrap();
    let skipped: Vec<Node> = document.descendants().filter(|n| n.has_tag_name("skipped")).collect();
    let used = verdicts(&place, "results")[0].2 as usize;
    assert!(used < 80);
    assert_eq!(skipped.len(), 80 - used);
    assert!(skipped.iter().all(|n| n.attribute("message") == Some("not needed: its claims are decided")));

    place.block("claims.toml", &format!("{BLOCK}{HOLDS}{FAILS}{OPEN}"));
    run(&place, "results", &[&EXACT[..], &["--junit", "all.xml"]].concat()).exits(1);
    let xml = fs::read_to_string(place.path("all.xml")).unwrap();
    let document = Document::parse(&xml).unwrap();
    let suite = document.descendants().find(|n| n.has_tag_name("testsuite")).unwrap();
    let counts = ["tests", "failures", "errors", "skipped"].map(|name| suite.attribute(name).unwrap().to_owned());
    assert_eq!(counts, ["83", "1", "0", "1"]);
    let case = |name: &str| {
        let is = |n: &Node| n.has_tag_name("testcase") && n.attribute("name") == Some(name);
        document.descendants().find(is).unwrap_or_else(|| panic!("{name}"))
    };
    let child = |name: &str, tag: &str| case(name).children().find(|n| n.has_tag_name(tag));
    assert!(child("claim: holds [contact.method=exact]", "failure").is_none());
    let failure = child("claim: fails [contact.method=exact]", "failure").unwrap();
    assert_eq!(failure.attribute("type"), Some("claim"));
    assert!(failure.attribute("message").unwrap().starts_with("fails: share of runs with final_base_x at most 0.015"));
    let open = child("claim: open [contact.method=exact]", "skipped").unwrap();
    assert!(open.attribute("message").unwrap().starts_with("undecided: "));
}

#[test]
fn the_report_shows_the_claims_and_is_rewritten_with_them() {
    let place = place(&[HOLDS, FAILS, OPEN]);
    run(&place, "results", &[]).exits(1);
    let page = fs::read_to_string(place.path("results/report.html")).unwrap();
    assert!(page.contains("<section id=\"claims\">"));
    assert_eq!(page.matches(": share and bounds over the runs\"").count(), 6);
    for verdict in ["claim-holds", "claim-fails", "claim-undecided"] {
        assert!(page.contains(verdict), "{verdict}");
    }
    let done = place.runner(&["report", "results", "-o", "again.html"]).exits(0);
    assert!(done.stdout.contains("again.html"));
    let again = fs::read_to_string(place.path("again.html")).unwrap();
    let section = |page: &str| {
        let from = page.find("<section id=\"claims\">").unwrap();
        page[from..from + page[from..].find("</section>").unwrap()].to_owned()
    };
    assert_eq!(section(&page), section(&again));
    // The next batch begins without the file.
    place.block("claims.toml", BLOCK);
    run(&place, "results", &[]).exits(0);
    assert!(!place.path("results/claims.json").exists());
    assert!(!fs::read_to_string(place.path("results/report.html")).unwrap().contains("<section id=\"claims\">"));
}

#[test]
fn an_interrupted_batch_judges_only_what_the_missing_runs_cannot_change() {
    // Every run counts as failed, so that the batch ends after some: 50 of 80 are below the share.
    let expect = "[[expect]]\nmetric = \"final_base_x\"\nmax = 0.0\n";
    let never = FAILS.replace("max = 0.015", "max = 0.0");
    let place = place(&[HOLDS, &never, expect]);
    run(&place, "results", &[&EXACT[..], &["-j", "1", "--max-fail", "50"]].concat()).exits(1);
    let found = verdicts(&place, "results");
    let of = |name: &str| {
        found.iter().find(|(n, ..)| n.starts_with(name)).map(|(_, verdict, used)| (verdict.as_str(), *used))
    };
    // None of 50 counts: even if the other 30 of 80 did, the share would be refuted. Of the other
    // claim, 30 failures could still follow.
    assert_eq!(of("fails"), Some(("fails", 50)));
    assert_eq!(of("holds"), Some(("undecided", 50)));
}

#[test]
fn checks_warn_of_claims_that_cannot_hold_or_count_dependent_runs() {
    let check = |sweep: &str, claim: &str| {
        let place = Place::new();
        place.block(
            "claims.toml",
            &format!("base = {{ linear_velocity = [1, 0, 0] }}\n{sweep}\n[[claim]]\nname = \"c\"\n{claim}\n"),
        );
        let done = place.runner(&["check", "claims.toml"]).exits(0);
        place.runner(&["check", "--strict", "claims.toml"]).exits(if done.stderr.contains("warning") { 2 } else { 0 });
        done.stderr
    };
    let passed = "share = { outcome = \"passed\" }";
    let repeat = |n: u32| format!("[sweep]\nrepeat = {n}");
    // 0.99^298 > 0.05 >= 0.99^299.
    let few = check(&repeat(298), &format!("{passed}\nat_least = 0.99"));
    assert!(few.contains("`claim.0` cannot hold with 298 runs: it needs at least 299"), "{few}");
    assert!(few.contains("claims.toml:9:12"), "{few}");
    assert_eq!(check(&repeat(299), &format!("{passed}\nat_least = 0.99")), "");
    let early = check(&repeat(42), &format!("{passed}\nat_least = 0.9\nearly = true"));
    assert!(early.contains("with 42 runs: it needs at least 43"), "{early}");
    assert!(early.contains("without `early` it needs at least 29"), "{early}");
    let pairs = check(
        "[sweep]\nrepeat = 4\ngrid = { \"contact.method\" = [\"exact\", \"one-step\"] }",
        "difference = \"impacts\"\nbetween = { \"contact.method\" = [\"exact\", \"one-step\"] }\nat_most = 0",
    );
    assert!(pairs.contains("cannot hold with 4 pairs of runs: it needs at least 5"), "{pairs}");

    let grid = "[sweep]\nrepeat = 99\ngrid = { \"contact.method\" = [\"exact\", \"one-step\"] }";
    let shared = check(grid, &format!("{passed}\nat_least = 0.9"));
    assert!(shared.contains("not independent: each value of `contact.method` has the same samples"), "{shared}");
    assert_eq!(check(grid, &format!("{passed}\nat_least = 0.9\nper = [\"contact.method\"]")), "");
    let fixed = check(
        "[sweep]\ngrid = { \"floor.friction\" = { linspace = [0.1, 1.0, 99] } }",
        &format!("{passed}\nat_least = 0.9"),
    );
    assert!(fixed.contains("takes the values of `floor.friction`, which are not random"), "{fixed}");
    let spread =
        "[sweep]\nrandom = { samples = 99, sampling = \"lhs\", \"floor.friction\" = { uniform = [0.1, 1.0] } }";
    let spread = check(spread, &format!("{passed}\nat_least = 0.9"));
    assert!(spread.contains("spread evenly"), "{spread}");
}

#[test]
fn compare_lists_changed_verdicts() {
    let place = place(&[HOLDS, OPEN]);
    run(&place, "a", &EXACT).exits(5);
    // The same runs, with limits that they decide otherwise.
    let changed = ["--set", "claim.0.at_least=0.97", "--set", "claim.1.at_least=0.8"];
    run(&place, "b", &[&EXACT[..], &changed].concat()).exits(1);
    let done = place.runner(&["compare", "a", "b"]).exits(1);
    let lines: Vec<&str> = done.stdout.lines().filter(|line| line.starts_with("claim: ")).collect();
    let expected = [
        "claim: claims: holds [contact.method=exact]: holds in A, fails in B",
        "claim: claims: open [contact.method=exact]: undecided in A, holds in B",
    ];
    assert_eq!(lines, expected, "{}", done.stdout);
    let json = place.runner(&["compare", "a", "b", "--format", "json"]).exits(1).stdout;
    let changes: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(changes["claims"].as_array().unwrap().len(), 2);
    assert_eq!(changes["beyond"], serde_json::json!([]));
    place.runner(&["compare", "a", "a"]).exits(0);
}
