//! JUnit XML for continuous integration: a suite per scenario, a case per run and claim.

use crate::files::{RecordError, atomic};
use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};
use std::io::Write;
use std::path::Path;
use std::time::Duration;

/// One run, or one claim, as a test case.
#[derive(Clone, Debug, PartialEq)]
pub struct JunitCase {
    /// Its suite.
    pub suite: String,
    /// Its name, unique in the suite.
    pub name: String,
    /// Wall-clock time; none when it was not started.
    pub time: Option<Duration>,
    /// Its status.
    pub status: JunitStatus,
    /// Named properties.
    pub properties: Vec<(&'static str, String)>,
    /// Lines of further output.
    pub output: Vec<String>,
}

/// Status of a test case.
#[derive(Clone, Debug, PartialEq)]
pub enum JunitStatus {
    /// As expected.
    Passed,
    /// It finished, against an expectation, or it is a claim that fails.
    Failed {
        /// Kind of failure.
        kind: &'static str,
        /// One line.
        message: String,
        /// All lines.
        detail: String,
    },
    /// It did not finish.
    Error {
        /// Kind of error.
        kind: String,
        /// One line.
        message: String,
    },
    /// It has no result.
    Skipped {
        /// Reason.
        message: String,
    },
}

/// Writes cases, grouped by suite in the given order. `time` is the total time.
///
/// # Errors
/// The file cannot be written.
pub fn write_junit(path: &Path, cases: &[JunitCase], time: Duration) -> Result<(), RecordError> {
    // Suites are found by unchanged names, since cleaned names may coincide.
    let mut suites: Vec<(&str, TestSuite)> = Vec::new();
    let mut last = 0;
    for case in cases {
        let is = |suite: &(&str, TestSuite)| suite.0 == case.suite;
        if !suites.get(last).is_some_and(is) {
            last = suites.iter().position(is).unwrap_or(suites.len());
        }
        if last == suites.len() {
            suites.push((&case.suite, TestSuite::new(clean(&case.suite))));
        }
        let suite = &mut suites[last].1;
        let total = suite.time.unwrap_or_default() + case.time.unwrap_or_default();
        suite.add_test_case(test_case(case)).set_time(total);
    }
    let mut report = Report::new("stiction");
    report.set_time(time).add_test_suites(suites.into_iter().map(|(_, suite)| suite));
    let text =
        report.to_string().map_err(|source| RecordError::Junit { path: path.to_owned(), source: source.into() })?;
    atomic::write_named(path, atomic::OutputKind::Junit, |out| {
        out.write_all(text.as_bytes()).map_err(RecordError::io(path))
    })
}

fn test_case(case: &JunitCase) -> TestCase {
    let status = match &case.status {
        JunitStatus::Passed => TestCaseStatus::success(),
        JunitStatus::Failed { kind, message, detail } => {
            let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
            status.set_type(*kind).set_message(clean(message)).set_description(clean(detail));
            status
        }
        JunitStatus::Error { kind, message } => {
            let mut status = TestCaseStatus::non_success(NonSuccessKind::Error);
            status.set_type(clean(kind)).set_message(clean(message)).set_description(clean(message));
            status
        }
        JunitStatus::Skipped { message } => {
            let mut status = TestCaseStatus::skipped();
            status.set_message(clean(message));
            status
        }
    };
    let mut out = TestCase::new(clean(&case.name), status);
    out.set_classname(clean(&case.suite));
    if let Some(time) = case.time {
        out.set_time(time);
    }
    for (name, value) in &case.properties {
        out.add_property((*name, clean(value).as_str()));
    }
    if !case.output.is_empty() {
        out.set_system_out(clean(&case.output.join("\n")));
    }
    out
}

/// Removes the two characters that XML forbids and the writer does not remove.
fn clean(text: &str) -> String {
    text.replace(['\u{fffe}', '\u{ffff}'], "")
}
