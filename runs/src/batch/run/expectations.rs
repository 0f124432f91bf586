//! Evaluates the expectations of a finished run.

use crate::results::{SummaryRow, Verdict, metric};
use crate::scenario::Expect;
use crate::sim::Outcome;

/// Evaluates a run against its expectations.
///
/// A run that reached its end or was stopped by a rule is `failed` if an expectation does not hold.
/// Any other outcome stays and is refused, unless an expectation names it: then the other
/// expectations are evaluated too. A cancelled run is not evaluated. Returns the row with its
/// verdicts, and whether the run was accepted.
pub(in crate::batch) fn evaluate(mut row: SummaryRow, expectations: &[Expect]) -> (SummaryRow, bool) {
    let outcome = row.outcome.name();
    let named = expectations.iter().any(|e| e.outcome.is_some_and(|o| o.name() == outcome));
    if !named && !matches!(row.outcome, Outcome::Passed | Outcome::Fallen) {
        return (row, false);
    }
    row.verdicts = expectations.iter().map(|e| verdict(e, &row)).collect();
    let broken = row.verdicts.iter().filter(|v| !v.held).map(|v| v.message.clone());
    let reasons: Vec<String> = Some(row.message.clone()).filter(|m| !m.is_empty()).into_iter().chain(broken).collect();
    let held = row.verdicts.iter().all(|v| v.held);
    if !held {
        row.outcome = Outcome::Failed;
        row.message = reasons.join("; ");
    }
    (row, held)
}

/// Evaluates one expectation.
fn verdict(expect: &Expect, row: &SummaryRow) -> Verdict {
    let judged = expect.judge(row.outcome.name(), |name| metric(row, name));
    let measured = expect.metric.as_deref().and_then(|name| metric(row, name));
    Verdict {
        metric: expect.metric.clone().unwrap_or_else(|| "outcome".into()),
        measured,
        truth: expect.value,
        allowed: expect.allowed(),
        min: expect.min,
        max: expect.max,
        error: measured.map(|x| expect.error(x)),
        held: judged.is_ok(),
        message: judged.err().map_or_else(String::new, |violation| violation.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::Comparison;
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
            verdicts: Vec::new(),
            metrics: Metrics { impacts: 3, ..Metrics::default() },
            comparison: Comparison::default(),
            wall_s: 1.0,
            cpu_s: 1.0,
            real_time_factor: 1.0,
            repeats: None,
            avoidance: None,
        }
    }

    fn at_most(max: f64) -> Expect {
        Expect { metric: Some("impacts".into()), max: Some(max), ..Expect::default() }
    }

    fn ends(outcome: ExpectedOutcome) -> Expect {
        Expect { outcome: Some(outcome), ..Expect::default() }
    }

    /// Outcome, expectations, resulting outcome, accepted.
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
        for (i, (outcome, expectations, expected, accepted)) in table.iter().enumerate() {
            let (judged, held) = evaluate(row(*outcome, ""), expectations);
            assert_eq!((judged.outcome, held), (*expected, *accepted), "row {i}");
        }
    }

    #[test]
    fn messages_give_the_outcome_and_the_failed_expectations() {
        let (judged, _) = evaluate(row(Outcome::Fallen, "base low"), &[at_most(2.0), at_most(1.0)]);
        assert_eq!(judged.message, "base low; impacts is 3, above 2; impacts is 3, above 1");
        assert_eq!(evaluate(row(Outcome::Fallen, "base low"), &[]).0.message, "base low");
    }

    #[test]
    fn verdicts_have_measured_and_expected_values() {
        let near = Expect {
            metric: Some("impacts".into()),
            value: Some(4.0),
            tolerance: Some(0.5),
            relative_tolerance: Some(0.25),
            ..Expect::default()
        };
        let (judged, held) = evaluate(row(Outcome::Passed, ""), &[near, at_most(1.0), ends(ExpectedOutcome::Passed)]);
        assert!(!held);
        let [value, limit, outcome] = judged.verdicts.as_slice() else { panic!("{:?}", judged.verdicts) };
        assert_eq!((value.measured, value.truth, value.allowed), (Some(3.0), Some(4.0), Some(1.5)));
        assert_eq!((value.error, value.held, value.message.as_str()), (Some(-1.0), true, ""));
        assert_eq!((limit.measured, limit.truth, limit.max, limit.error), (Some(3.0), None, Some(1.0), Some(2.0)));
        assert_eq!((limit.held, limit.message.as_str()), (false, "impacts is 3, above 1"));
        assert_eq!((outcome.metric.as_str(), outcome.measured, outcome.held), ("outcome", None, true));
        assert!(evaluate(row(Outcome::Diverged, ""), &[at_most(1.0)]).0.verdicts.is_empty(), "not evaluated");
    }
}
