//! Scenarios from files, texts and dictionaries.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping};
use stiction::batch::{Filter, Finding, Findings, Overrides, Plan, prepare_loaded};
use stiction::scenario::{self, DEFAULT_MAX_RUNS};
use stiction::text::Diagnostics;

use crate::errors;
use crate::values::{of_json, overrides, to_text};

/// A scenario whose text is read, with overrides of its own.
#[pyclass(frozen, module = "stiction._native")]
pub struct ScenarioFile {
    file: scenario::ScenarioFile,
    text: String,
    overrides: Overrides,
}

#[pymethods]
impl ScenarioFile {
    /// Reads a scenario file.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let file = scenario::load(&path).map_err(|found| of_diagnostics(py, found))?;
        let text = file.text.clone();
        Ok(ScenarioFile { file, text, overrides: Vec::new() })
    }

    /// Reads a scenario from TOML text. Relative paths in it start at the folder of `path`, whose stem is
    /// its name.
    #[staticmethod]
    fn parse(py: Python<'_>, path: PathBuf, text: String) -> PyResult<Self> {
        let file = scenario::parse(&path, text.as_str()).map_err(|found| of_diagnostics(py, found))?;
        Ok(ScenarioFile { file, text, overrides: Vec::new() })
    }

    /// A scenario with the keys and values of a dictionary.
    #[staticmethod]
    fn from_dict(py: Python<'_>, path: PathBuf, values: &Bound<'_, PyMapping>) -> PyResult<Self> {
        Self::parse(py, path, to_text(values)?)
    }

    /// A copy with further overrides, as by `--set`.
    fn with_overrides(&self, overrides: Vec<(String, Bound<'_, PyAny>)>) -> PyResult<Self> {
        let mut all = self.overrides.clone();
        all.extend(crate::values::overrides(&overrides)?);
        Ok(ScenarioFile { file: self.file.clone(), text: self.text.clone(), overrides: all })
    }

    /// Name of the scenario.
    #[getter]
    fn name(&self) -> String {
        self.file.name()
    }

    /// Its path.
    #[getter]
    fn path(&self) -> PathBuf {
        self.file.path.clone()
    }

    /// Its TOML text.
    #[getter]
    fn text(&self) -> &str {
        &self.text
    }
}

/// What a call selects of scenarios.
pub struct Selected {
    files: Vec<(scenario::ScenarioFile, Overrides)>,
    filter: Option<String>,
    max_runs: usize,
}

impl Selected {
    /// Files with the overrides of the call after their own.
    pub fn new(
        files: &[PyRef<'_, ScenarioFile>],
        more: &[(String, Bound<'_, PyAny>)],
        filter: Option<String>,
        max_runs: Option<usize>,
    ) -> PyResult<Self> {
        let more = overrides(more)?;
        let with_all =
            |file: &PyRef<'_, ScenarioFile>| (file.file.clone(), file.overrides.iter().chain(&more).cloned().collect());
        let files = files.iter().map(with_all).collect();
        Ok(Selected { files, filter, max_runs: max_runs.unwrap_or(DEFAULT_MAX_RUNS) })
    }

    /// Checks everything and plans the runs. Ok and Err have all findings.
    fn prepare(&self) -> Result<(Plan, Findings), Findings> {
        let of_filter = |wrong| {
            let mut findings = Findings::default();
            findings.push(Finding::Scenario(wrong));
            findings
        };
        let filter = self.filter.as_deref().map(Filter::parse).transpose().map_err(of_filter)?;
        let pairs = self.files.iter().map(|(file, overrides)| (file, overrides));
        let (mut plan, findings) = prepare_loaded(pairs, self.max_runs)?;
        if let Some(filter) = &filter {
            plan.select(filter).map_err(of_filter)?;
        }
        Ok((plan, findings))
    }

    /// The plan, with its warnings and notes.
    ///
    /// # Errors
    /// `ScenarioError` or `RobotError`.
    pub fn plan(&self, py: Python<'_>) -> PyResult<(Plan, Findings)> {
        py.detach(|| self.prepare()).map_err(|findings| errors::of_findings(py, &findings))
    }
}

fn of_diagnostics(py: Python<'_>, found: Diagnostics) -> PyErr {
    let mut findings = Findings::default();
    findings.extend(found);
    errors::of_findings(py, &findings)
}

/// The runs that scenarios expand to, as dictionaries.
#[pyfunction]
#[pyo3(signature = (files, overrides, filter=None, max_runs=None))]
pub fn runs<'py>(
    py: Python<'py>,
    files: Vec<PyRef<'py, ScenarioFile>>,
    overrides: Vec<(String, Bound<'py, PyAny>)>,
    filter: Option<String>,
    max_runs: Option<usize>,
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let (plan, _) = Selected::new(&files, &overrides, filter, max_runs)?.plan(py)?;
    let of_job = |job: stiction::batch::Job| {
        let values = PyDict::new(py);
        let parameters = PyDict::new(py);
        for (name, value) in job.parameters() {
            let text = serde_json::to_string(&value).unwrap_or_default();
            parameters.set_item(name, of_json(py, &text)?)?;
        }
        values.set_item("scenario", &job.run.name)?;
        values.set_item("key", &job.key)?;
        values.set_item("label", &job.label)?;
        values.set_item("seed", job.run.scenario.seed)?;
        values.set_item("parameters", parameters)?;
        Ok(values)
    };
    plan.jobs().map(of_job).collect()
}

/// All errors, warnings and notes of scenarios, as dictionaries.
#[pyfunction]
#[pyo3(signature = (files, overrides, filter=None))]
pub fn check<'py>(
    py: Python<'py>,
    files: Vec<PyRef<'py, ScenarioFile>>,
    overrides: Vec<(String, Bound<'py, PyAny>)>,
    filter: Option<String>,
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let selected = Selected::new(&files, &overrides, filter, None)?;
    let found = match py.detach(|| selected.prepare()) {
        Ok((_, findings)) | Err(findings) => findings,
    };
    found.iter().map(|finding| errors::diagnostic(py, finding)).collect()
}
