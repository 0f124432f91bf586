//! Compares a recorded run with its re-run.

use crate::files::names;
use crate::replay::difference::Difference;
use crate::replay::input_change::InputChange;
use crate::replay::recorded_run::RecordedRun;
use crate::replay::rerun::Rerun;
use crate::replay::{compare_logs, compare_records};

/// The first difference of the logs and the first of the records; none if both are the same to the
/// last bit.
///
/// Not compared are wall-clock times, swept parameters (a re-run is not swept), and what changed
/// inputs change by themselves: hashes, key, program, and the texts attached to the log.
pub fn compare(recorded: &RecordedRun, rerun: &Rerun) -> Vec<Difference> {
    let inputs_changed = rerun.changes.iter().any(InputChange::affects_result);
    let terminated = recorded.terminated_externally();
    let logs = match (&recorded.log, &rerun.run.log) {
        (Some(then), Some(now)) => compare_logs::compare(then, now, inputs_changed, terminated),
        (None, _) if recorded.record.log.is_some() => Some(Difference {
            file: names::LOG,
            position: "the log is missing, although the record has its hash".into(),
            values: None,
            more: 0,
        }),
        _ => None,
    };
    // The metrics of a run that was terminated externally are those of that moment.
    let records = (!terminated).then(|| compare_records::compare(&recorded.record, &rerun.run.record)).flatten();
    logs.into_iter().chain(records).collect()
}
