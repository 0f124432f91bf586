//! The log does not change the motion: it only evaluates between the ends of steps.

use crate::cli::{Place, Table};
use crate::support::same::is_time;

/// Cells of the rows, without times, the key, evaluations, which include those for the log, and the
/// distances from the reference, which are sampled at the rate of the log.
fn cells(table: &Table) -> Vec<Vec<(String, String)>> {
    const OTHER: [&str; 3] = ["key", "evaluations", "contact_state_agreement"];
    let compared = |name: &str| {
        !is_time(name) && !OTHER.contains(&name) && !name.starts_with("log.") && !name.starts_with("error_")
    };
    let row = |row: &Vec<String>| {
        let cells = table.header.iter().cloned().zip(row.iter().cloned());
        cells.filter(|(name, _)| compared(name)).collect()
    };
    table.rows.iter().map(row).collect()
}

/// A humanoid that lands, rocks, and is pushed, with contact states chosen after each step: each choice
/// begins with the forces of the last one, also where instants of the log lie between the two.
#[test]
fn a_log_does_not_change_the_choice_of_states() {
    let place = Place::new();
    let study = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/studies/contact-tolerances.toml");
    let run = |rate: &str, output: &str| {
        let rate = format!("log.rate={rate}");
        let filter = ["--filter", "contact.events == \"step\" and contact.method == \"exact\""];
        // A run whose choices differ may take minutes.
        let options = ["--set", &rate, "--timeout", "60", "-o", output];
        place.runner(&[&[study][..], &filter, &options].concat()).exits(0);
        cells(&place.summary(output))
    };
    let without = run("0", "without");
    assert!(without.len() >= 2);
    for rate in ["100", "1000", "1300"] {
        assert_eq!(run(rate, rate), without, "{rate}");
    }
}
