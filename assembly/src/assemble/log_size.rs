//! Estimates the size of a run's log from its rate, duration and robot, and limits it.
//!
//! Bytes per logged instant were measured on logs of a block, HOAP-2, CB-i and a quadruped: some 30 per joint for
//! its state, 300 per sole, and at instants for viewers 55 per joint.

use crate::robot::Model;
use crate::scenario::{Diagnostic, LogTopic, Run, Severity};
use crate::sim::Setup;

/// Log of a run above which a warning is given, bytes.
const LARGE: f64 = 1e9;

/// Greatest log of a run at a high rate, bytes.
const MAX_LOG: f64 = 1e11;

/// Rate above which a log that is too large is refused, Hz. At lower rates it grows so slowly that
/// runs with a very long duration, which are ended from outside, remain possible.
const HIGH_RATE: f64 = 1e4;

/// Greatest motion of a reference, which is kept in memory, bytes.
const MAX_REFERENCE: f64 = 4e9;

/// Size of a run's log, bytes, about.
fn log_bytes(run: &Run, model: &Model) -> f64 {
    let (joints, soles) = (model.nj() as f64, model.soles.len() as f64);
    let log = &run.scenario.log;
    let for_viewers = (log.viewer_rate / log.rate).min(1.0);
    let of_topic = |topic: &LogTopic| match topic {
        LogTopic::State => 30.0 * joints,
        LogTopic::Contact => 300.0 * soles,
        LogTopic::Scene => 55.0 * joints * for_viewers,
    };
    log.rate * run.scenario.end() * (250.0 + log.topics.iter().map(of_topic).sum::<f64>())
}

/// Size of the motion of a run's reference, bytes; 0 without one.
fn reference_bytes(run: &Run, model: &Model) -> f64 {
    if run.reference.is_none() {
        return 0.0;
    }
    let numbers = 8.0 + model.nj() as f64 + 3.0 * model.soles.len() as f64;
    run.scenario.log.rate * run.scenario.end() * 8.0 * numbers
}

/// A number of bytes as text, to two digits.
fn size(bytes: f64) -> String {
    let units = [(1e12, "TB"), (1e9, "GB")];
    let (unit, name) = units.into_iter().find(|(unit, _)| bytes >= *unit).unwrap_or((1e6, "MB"));
    let value = bytes / unit;
    if value < 10.0 { format!("{value:.1} {name}") } else { format!("{value:.0} {name}") }
}

/// Refuses a log, or a reference in memory, that is too large.
pub(super) fn check(run: &Run, model: &Model, errors: &mut Vec<Diagnostic>) {
    let (rate, end) = (run.scenario.log.rate, run.scenario.end());
    let (log, reference) = (log_bytes(run, model), reference_bytes(run, model));
    let (what, bytes, limit) = if reference > MAX_REFERENCE {
        ("samples of the reference that take", reference, MAX_REFERENCE)
    } else if log > MAX_LOG && rate > HIGH_RATE {
        ("a log of", log, MAX_LOG)
    } else {
        return;
    };
    let (bytes, limit) = (size(bytes), size(limit));
    let message =
        format!("`log.rate` = {rate} Hz over {end} s makes {what} about {bytes}, at most {limit} are allowed");
    errors.push(run.error_at("log.rate", message, Some("reduce `log.rate`, or `duration`".into())));
}

/// A warning of a run with a large log.
pub fn warning(run: &Run, setup: &Setup) -> Option<Diagnostic> {
    let bytes = log_bytes(run, &setup.model);
    (bytes > LARGE).then(|| {
        let (rate, end) = (run.scenario.log.rate, run.scenario.end());
        let message = format!("`log.rate` = {rate} Hz makes a log of about {} in {end} s", size(bytes));
        let mut warning = run.error_at("log.rate", message, None);
        warning.severity = Severity::Warning;
        warning
    })
}

#[cfg(test)]
mod tests {
    use super::size;

    #[test]
    fn sizes_have_two_digits() {
        let cases = [(2.5e12, "2.5 TB"), (1e15, "1000 TB"), (1e11, "100 GB"), (3.4e9, "3.4 GB"), (9e8, "900 MB")];
        for (bytes, text) in cases {
            assert_eq!(size(bytes), text);
        }
    }
}
