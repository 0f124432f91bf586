//! Exceptions of the package. Python code defines their classes; this module raises them.

use std::sync::OnceLock;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use stiction::batch::{BatchError, DiagnosticMessage, Finding, Findings, Severity};
use stiction::sim::RunError;

/// An exception of `stiction/_errors.py` with these arguments.
fn exception<'py, A>(py: Python<'py>, class: &str, arguments: A) -> PyErr
where
    A: pyo3::call::PyCallArgs<'py>,
{
    let made = py.import("stiction._errors").and_then(|module| module.getattr(class)?.call1(arguments));
    made.map_or_else(|error| error, PyErr::from_value)
}

/// A diagnostic as a dictionary.
pub fn diagnostic<'py>(py: Python<'py>, finding: &Finding) -> PyResult<Bound<'py, PyDict>> {
    let message = DiagnosticMessage::from(finding);
    let values = PyDict::new(py);
    values.set_item("severity", message.severity)?;
    values.set_item("message", message.message)?;
    values.set_item("file", message.file)?;
    values.set_item("line", message.line)?;
    values.set_item("column", message.column)?;
    values.set_item("key", message.key)?;
    values.set_item("help", message.help)?;
    values.set_item("rendered", message.rendered)?;
    Ok(values)
}

/// Errors of scenarios and robots.
pub fn of_findings(py: Python<'_>, findings: &Findings) -> PyErr {
    let errors: Vec<&Finding> = findings.iter().filter(|finding| finding.severity() == Severity::Error).collect();
    let text = errors.iter().map(|finding| finding.render(false)).collect::<Vec<_>>().join("\n");
    let class = if matches!(errors.first(), Some(Finding::Robot { .. })) { "RobotError" } else { "ScenarioError" };
    let diagnostics: PyResult<Vec<_>> = errors.iter().map(|finding| diagnostic(py, finding)).collect();
    match diagnostics {
        Ok(diagnostics) => exception(py, class, (text, diagnostics)),
        Err(error) => error,
    }
}

/// Scenarios of which no run is left.
pub fn nothing_selected(py: Python<'_>, why: &str) -> PyErr {
    exception(py, "ScenarioError", (format!("nothing selected: {why}"),))
}

/// Why a run ended early, with its time, s.
pub fn of_run(py: Python<'_>, error: &RunError, time: Option<f64>) -> PyErr {
    exception(py, "RunError", (error.message.as_str(), error.outcome.name(), time))
}

/// A use of a simulation that is not possible.
pub fn refused(py: Python<'_>, message: &str) -> PyErr {
    exception(py, "RunError", (message, "error", None::<f64>))
}

/// A log that cannot be read, or has no such column.
pub fn of_log(py: Python<'_>, error: impl ToString) -> PyErr {
    exception(py, "LogError", (error.to_string(),))
}

/// Results that cannot be read or written.
pub fn of_results(py: Python<'_>, error: impl ToString) -> PyErr {
    exception(py, "ResultsError", (error.to_string(),))
}

/// A batch that failed as a whole.
pub fn of_batch(py: Python<'_>, error: &BatchError) -> PyErr {
    of_results(py, error)
}

/// Refuses work on threads that a fork of the process has lost.
pub fn check_fork(py: Python<'_>) -> PyResult<()> {
    static PROCESS: OnceLock<u32> = OnceLock::new();
    match *PROCESS.get_or_init(std::process::id) == std::process::id() {
        true => Ok(()),
        false => {
            let why = "this process was forked from one that has run scenarios, whose threads it lacks: start processes \
                       by `multiprocessing.get_context(\"spawn\")`";
            Err(of_results(py, why))
        }
    }
}
