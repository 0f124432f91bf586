//! A summary is of the batch that ran last, or there is none.

use super::{ARGUMENTS, ENDS, batch};
use crate::cli::Place;

const SUMMARY: [&str; 3] = ["summary.csv", "summary.parquet", "report.html"];

#[test]
fn a_batch_that_ends_before_its_first_run_leaves_no_summary_of_an_earlier_one() {
    let place = batch();
    place.runner(&ARGUMENTS).exits(ENDS);
    assert!(SUMMARY.iter().all(|name| place.path("results").join(name).is_file()));
    // No room for the line of the first run that ends.
    let limited = format!("trap '' XFSZ; ulimit -f 0; exec \"$0\" {}", ARGUMENTS.join(" "));
    let done = place.shell(&limited);
    assert_eq!(done.code, Some(3), "{}", done.stderr);
    for name in SUMMARY {
        assert!(!place.path("results").join(name).exists(), "{name} is that of the batch before");
    }
}

#[test]
fn two_programs_do_not_write_into_one_folder() {
    let place = Place::new();
    place.block("s.toml", "");
    std::fs::create_dir(place.path("results")).unwrap();
    let _held = stiction::results::RunsLog::append(&place.path("results/runs.jsonl")).unwrap();
    place.write("results/summary.csv", "theirs");
    for more in [&[][..], &["--resume"]] {
        let done = place.runner(&[&["s.toml"][..], more].concat()).exits(2);
        assert!(done.stderr.contains("another runner is writing these results"), "{}", done.stderr);
    }
    assert_eq!(std::fs::read_to_string(place.path("results/summary.csv")).unwrap(), "theirs");
}
