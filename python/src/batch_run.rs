//! Batches of runs, as `runner run` executes them.

use std::num::NonZero;
use std::path::PathBuf;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stiction::Options;
use stiction::batch::{Batch, BatchStarted, Message, MessageWriter, Progress, Severity, simulate};
use stiction::report::batch_page;
use stiction::sim::Problems;

use crate::errors;
use crate::scenario_file::{ScenarioFile, Selected};
use crate::values::{of_json, option};

/// Time between checks for signals, such as that of Ctrl-C.
const PATIENCE: Duration = Duration::from_millis(50);

/// Executes all runs of scenarios and writes their results. `on_message` receives the messages of
/// `--message-format json` as dictionaries.
#[pyfunction]
#[pyo3(signature = (files, overrides, filter, options, on_message=None))]
pub fn run<'py>(
    py: Python<'py>,
    files: Vec<PyRef<'py, ScenarioFile>>,
    overrides: Vec<(String, Bound<'py, PyAny>)>,
    filter: Option<String>,
    options: &Bound<'py, PyDict>,
    on_message: Option<Py<PyAny>>,
) -> PyResult<()> {
    errors::check_fork(py)?;
    let filtered = filter.is_some();
    let selected = Selected::new(&files, &overrides, filter, option(options, "max_runs")?)?;
    let options = batch_options(options)?;
    let (plan, findings) = selected.plan(py)?;
    if plan.runs() == 0 {
        let why = if filtered { "the filter holds for no run" } else { "the scenarios expand to no runs" };
        return Err(errors::nothing_selected(py, why));
    }
    let tell = |message: &str| match &on_message {
        Some(function) => function.call1(py, (of_json(py, message)?,)).map(|_| ()),
        None => Ok(()),
    };
    for finding in findings.iter().filter(|finding| finding.severity() == Severity::Warning) {
        tell(&Message::Diagnostic(finding.into()).line())?;
    }
    let jobs = options.jobs.min(plan.runs() + plan.references());
    let started = Message::BatchStarted(BatchStarted { jobs, ..BatchStarted::new(&plan, &options) });
    let batch = Batch::new(plan, options.clone(), batch_page).map_err(|error| errors::of_batch(py, &error))?;
    tell(&started.line())?;
    let interrupter = batch.interrupter();
    let (sender, messages) = channel::<String>();
    let messages = Mutex::new(messages);
    let (done, raised) = py.detach(|| {
        // Uncontended: what is used without the interpreter's lock must be shareable.
        let messages = messages.into_inner().unwrap_or_else(PoisonError::into_inner);
        std::thread::scope(|scope| {
            let worker = scope.spawn(move || {
                // The receiver lives until this thread has ended.
                let mut writer = MessageWriter::new(&options, |line| drop(sender.send(line)));
                batch.run_with_listener(Progress::Silent, &mut writer, &simulate)
            });
            let mut raised = None;
            loop {
                let called = match messages.recv_timeout(PATIENCE) {
                    Ok(message) => on_message
                        .as_ref()
                        .map_or(Ok(()), |f| Python::attach(|py| f.call1(py, (of_json(py, &message)?,)).map(|_| ()))),
                    Err(RecvTimeoutError::Timeout) => Python::attach(|py| py.check_signals()),
                    Err(RecvTimeoutError::Disconnected) => break,
                };
                if let Err(error) = called
                    && raised.is_none()
                {
                    raised = Some(error);
                    // Start no more runs, and cancel active ones.
                    interrupter.interrupt();
                    interrupter.interrupt();
                }
            }
            (worker.join(), raised)
        })
    });
    if let Some(error) = raised {
        return Err(error);
    }
    match done {
        Ok(report) => report.map(|_| ()).map_err(|error| errors::of_batch(py, &error)),
        Err(_) => Err(PyRuntimeError::new_err("the batch ended by an internal error")),
    }
}

fn batch_options(given: &Bound<'_, PyDict>) -> PyResult<Options> {
    let positive = |name: &str| -> PyResult<Option<NonZero<usize>>> {
        let wrong = || PyValueError::new_err(format!("{name}: expected a number of at least 1"));
        let number: Option<i64> = option(given, name)?;
        let checked = |n: i64| usize::try_from(n).ok().and_then(NonZero::new).ok_or_else(wrong);
        number.map(checked).transpose()
    };
    let seconds = |name: &str| -> PyResult<Option<Duration>> {
        let wrong = |s: f64| PyValueError::new_err(format!("{name}: found {s} s, expected a time above 0 s"));
        let time: Option<f64> = option(given, name)?;
        let checked =
            |s: f64| Duration::try_from_secs_f64(s).ok().filter(|time| !time.is_zero()).ok_or_else(|| wrong(s));
        time.map(checked).transpose()
    };
    let default = Options::default();
    Ok(Options {
        output: option::<PathBuf>(given, "output")?.unwrap_or(default.output),
        jobs: positive("jobs")?.map_or(default.jobs, NonZero::get),
        log: option(given, "log")?.unwrap_or(true),
        timeout: seconds("timeout")?,
        max_fail: positive("max_fail")?,
        slow: seconds("slow")?,
        problems: Problems::None,
        timing: option(given, "timing")?.unwrap_or(true),
        resume: option(given, "resume")?.unwrap_or(false),
    })
}
