//! The verdict on a finished run.

use crate::record::{SummaryRow, metric};
use crate::scenario::Expect;
use crate::sim::Outcome;

/// Holds a run against its expectations.
///
/// A run that reached its end or was stopped by a rule is `failed` when an expectation does not hold. One that ended
/// in another way keeps that outcome, unless an expectation names it: then that was what should happen, and the other
/// expectations are looked at. A cancelled run is not judged. Returns the row with its verdict, and whether the run
/// ended as it should.
pub(super) fn judge(mut row: SummaryRow, expectations: &[Expect]) -> (SummaryRow, bool) {
    let word = row.outcome.name();
    let named = expectations.iter().any(|e| e.outcome.is_some_and(|o| o.name() == word));
    let judged = named || matches!(row.outcome, Outcome::Passed | Outcome::Fallen);
    if !judged {
        return (row, false);
    }
    let broken = expectations.iter().filter_map(|e| e.judge(word, |name| metric(&row, name)).err());
    let words: Vec<String> = Some(row.message.clone()).filter(|m| !m.is_empty()).into_iter().chain(broken).collect();
    let held = words.len() == usize::from(!row.message.is_empty());
    if !held {
        row.outcome = Outcome::Failed;
        row.message = words.join("; ");
    }
    (row, held)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::ExpectedOutcome;
    use crate::sim::Metrics;

    fn row(outcome: Outcome, message: &str) -> SummaryRow {
        SummaryRow {
            scenario: "s".into(),
            key: "k".into(),
            outcome,
            message: message.into(),
            method: "exact".into(),
            integrator: "dopri5".into(),
            seed: 1,
            parameters: Vec::new(),
            metrics: Metrics { impacts: 3, ..Metrics::default() },
            wall_s: 1.0,
            cpu_s: 1.0,
            real_time_factor: 1.0,
        }
    }

    fn at_most(max: f64) -> Expect {
        Expect { metric: Some("impacts".into()), max: Some(max), ..Expect::default() }
    }

    fn ends(outcome: ExpectedOutcome) -> Expect {
        Expect { outcome: Some(outcome), ..Expect::default() }
    }

    /// Outcome, expectations, and what comes of them.
    #[test]
    fn verdicts() {
        use Outcome::*;
        let table: &[(Outcome, &[Expect], Outcome, bool)] = &[
            (Passed, &[], Passed, true),
            (Passed, &[at_most(3.0)], Passed, true),
            (Passed, &[at_most(2.0)], Failed, false),
            (Passed, &[ends(ExpectedOutcome::Fallen)], Failed, false),
            (Fallen, &[], Fallen, true),
            (Fallen, &[at_most(2.0)], Failed, false),
            (Fallen, &[ends(ExpectedOutcome::Passed)], Failed, false),
            (Fallen, &[ends(ExpectedOutcome::Fallen)], Fallen, true),
            (Diverged, &[], Diverged, false),
            (Diverged, &[at_most(2.0)], Diverged, false),
            (Diverged, &[ends(ExpectedOutcome::Diverged)], Diverged, true),
            (Diverged, &[ends(ExpectedOutcome::Diverged), at_most(2.0)], Failed, false),
            (TimedOut, &[ends(ExpectedOutcome::Passed)], TimedOut, false),
            (Error, &[], Error, false),
            (Cancelled, &[at_most(2.0)], Cancelled, false),
        ];
        for (i, (outcome, expectations, wanted, accepted)) in table.iter().enumerate() {
            let (judged, held) = judge(row(*outcome, ""), expectations);
            assert_eq!((judged.outcome, held), (*wanted, *accepted), "row {i}");
        }
    }

    #[test]
    fn words_say_what_happened_and_what_did_not_hold() {
        let (judged, _) = judge(row(Outcome::Fallen, "base low"), &[at_most(2.0), at_most(1.0)]);
        assert_eq!(judged.message, "base low; impacts is 3, above 2; impacts is 3, above 1");
        assert_eq!(judge(row(Outcome::Fallen, "base low"), &[]).0.message, "base low");
    }
}
