//! Writes the results of a fit into a folder: `fit.json`, `fitted.toml`, `fit.html`.

use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use crate::files::{RecordError, atomic};
use crate::fit::experiment::Experiment;
use crate::fit::problem::{Fit, difference, is_angle};
use crate::fit::results::{Agreement, DataResult, Estimate, Status};
use crate::fit::summary_text::{note, rounded, verdict};
use crate::report::{FitPage, FittedSignal, PlainTable, write_fit_page};

/// Beginning of a file of fitted values.
const FITTED: &str = "# Values fitted by `runner fit`";

/// Paths of the results.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ResultFiles {
    /// All results.
    pub json: PathBuf,
    /// The fitted values by key.
    pub fitted: PathBuf,
    /// The page.
    pub page: PathBuf,
}

/// Writes the results into `folder`, which is created if needed.
///
/// # Errors
/// A file cannot be written, or is there and not a result of a fit.
pub fn write(folder: &Path, fit: &Fit, estimate: &Estimate) -> Result<ResultFiles, RecordError> {
    let files = ResultFiles {
        json: folder.join("fit.json"),
        fitted: folder.join("fitted.toml"),
        page: folder.join("fit.html"),
    };
    refuse_other(&files.json, "{\n  \"fit\"")?;
    refuse_other(&files.fitted, FITTED)?;
    let json = serde_json::to_string_pretty(estimate)
        .map_err(|error| RecordError::io(&files.json)(std::io::Error::other(error)))?;
    for (path, text) in [(&files.json, json + "\n"), (&files.fitted, fitted_values(estimate))] {
        atomic::write(path, |out| out.write_all(text.as_bytes()).map_err(RecordError::io(path)))?;
    }
    write_fit_page(&files.page, &page(fit, estimate))?;
    Ok(files)
}

/// Refuses to replace a file that does not begin as one of a fit.
fn refuse_other(path: &Path, beginning: &str) -> Result<(), RecordError> {
    match std::fs::read(path) {
        Ok(bytes) if !bytes.starts_with(beginning.as_bytes()) => {
            let message = "it is no result of a fit and is not replaced";
            Err(RecordError::io(path)(std::io::Error::new(ErrorKind::AlreadyExists, message)))
        }
        _ => Ok(()),
    }
}

/// The fitted values as keys in quotes, as `--set-from` reads them.
fn fitted_values(estimate: &Estimate) -> String {
    let mut text = format!("{FITTED} from `{}`, for `--set-from`.\n", estimate.fit);
    for parameter in &estimate.parameters {
        let comment = match (parameter.standard_error, parameter.interval) {
            (Some(error), Some([low, high])) => format!(
                "standard error {error:.3e}, {} % from {} to {}",
                100.0 * estimate.confidence,
                rounded(low, Some(error)),
                rounded(high, Some(error))
            ),
            _ => note(parameter),
        };
        let unit = if parameter.unit.is_empty() { String::new() } else { format!("{}; ", parameter.unit) };
        text += &format!("\n# {unit}{comment}\n");
        for key in &parameter.keys {
            text += &format!("{} = {}\n", toml::Value::String(key.clone()), toml::Value::Float(parameter.estimate));
        }
    }
    text
}

fn page(fit: &Fit, estimate: &Estimate) -> FitPage {
    let status = match estimate.status {
        Status::Converged => ("passed", "converged"),
        Status::Stalled => ("failed", "stalled"),
        Status::MaxIterations => ("failed", "not converged"),
    };
    let mut chips = vec![status];
    match estimate.agreement {
        Agreement::Agrees => chips.push(("passed", "residuals agree with the noise")),
        Agreement::Differs => chips.push(("failed", "residuals exceed the noise")),
        Agreement::Untested => {}
    }
    if estimate.is_undetermined() {
        chips.push(("failed", "not all parameters are determined"));
    }
    for data in estimate.data.iter().filter(|data| data.hold_out) {
        match data.agreement {
            Agreement::Agrees => chips.push(("passed", "held-out data agree")),
            Agreement::Differs => chips.push(("failed", "held-out data differ")),
            Agreement::Untested => {}
        }
    }
    chips.dedup();
    let experiments = fit.experiments.iter().zip(&estimate.data);
    FitPage {
        title: estimate.fit.clone(),
        description: fit.file.spec.description.clone(),
        chips: chips.into_iter().map(|(class, text)| (class.to_owned(), text.to_owned())).collect(),
        warnings: estimate.warnings.clone(),
        tables: tables(estimate),
        signals: experiments.flat_map(|(experiment, data)| signals(experiment, data)).collect(),
    }
}

fn signals<'a>(experiment: &'a Experiment, data: &'a DataResult) -> impl Iterator<Item = FittedSignal> + 'a {
    let times = &experiment.recording.times;
    experiment.recording.channels.iter().zip(&data.signals).map(move |(channel, result)| {
        let finite = |(time, value): (&f64, &f64)| value.is_finite().then_some((*time, *value));
        let role = if data.hold_out { ", held out" } else { "" };
        let is_angle = is_angle(&channel.column);
        let pairs = channel.values.iter().zip(&result.fitted).map(|(a, b)| difference(*b, *a, is_angle) / result.sigma);
        let pairs: Vec<f64> = pairs.collect();
        FittedSignal {
            title: format!("{}: {}{role}", data.name, channel.column),
            label: channel.column.clone(),
            measured: times.iter().zip(&channel.values).filter_map(finite).collect(),
            fitted: times.iter().zip(&result.fitted).filter_map(finite).collect(),
            residuals: times.iter().zip(&pairs).filter_map(finite).collect(),
        }
    })
}

fn tables(estimate: &Estimate) -> Vec<PlainTable> {
    let head = |names: &[(&str, bool)]| names.iter().map(|(name, number)| ((*name).to_owned(), *number)).collect();
    let dash = || "–".to_owned();
    let level = format!("{} % from", 100.0 * estimate.confidence);
    let parameters = estimate.parameters.iter().map(|p| {
        let end = |k: usize| p.interval.map_or_else(dash, |i| rounded(i[k], p.standard_error));
        let error = p.standard_error.map_or_else(dash, |error| format!("{error:.2e}"));
        let start = p.start.to_string();
        let estimate = rounded(p.estimate, p.standard_error);
        vec![p.name.clone(), p.unit.clone(), start, estimate, error, end(0), end(1), note(p)]
    });
    let number = (String::new(), false);
    let names = estimate.parameters.iter().map(|p| (p.name.clone(), true));
    let correlation = estimate.parameters.iter().zip(&estimate.correlation).map(|(p, row)| {
        let cells = row.iter().map(|c| c.map_or_else(dash, |c| format!("{c:.3}")));
        std::iter::once(p.name.clone()).chain(cells).collect()
    });
    let data = estimate.data.iter().flat_map(|data| {
        let role = if data.hold_out { "held out" } else { "fitted" };
        let p = data.p_value.map_or_else(dash, |p| format!("{p:.4}"));
        let verdict = verdict(data.agreement).to_owned();
        let own = vec![
            data.name.clone(),
            role.to_owned(),
            "all".to_owned(),
            data.values.to_string(),
            String::new(),
            String::new(),
            format!("{:.4}", data.rms),
            p,
            verdict,
        ];
        let signals = data.signals.iter().map(|s| {
            let (rms, sigma) = (format!("{:.3e}", s.rms), format!("{:.3e}", s.sigma));
            let ratio = format!("{:.4}", s.rms / s.sigma);
            let (name, values) = (s.column.clone(), s.values.to_string());
            vec![String::new(), String::new(), name, values, rms, sigma, ratio, String::new(), String::new()]
        });
        std::iter::once(own).chain(signals).collect::<Vec<_>>()
    });
    let total = vec![
        estimate.values.to_string(),
        estimate.degrees_of_freedom.to_string(),
        format!("{:.6}", estimate.chi_square),
        format!("{:.6}", estimate.reduced_chi_square),
        estimate.p_value.map_or_else(dash, |p| format!("{p:.4}")),
        estimate.iterations.to_string(),
        estimate.runs.to_string(),
    ];
    vec![
        PlainTable {
            title: "Parameters".into(),
            head: head(&[
                ("parameter", false),
                ("unit", false),
                ("start", true),
                ("estimate", true),
                ("standard error", true),
                (&level, true),
                ("to", true),
                ("", false),
            ]),
            rows: parameters.collect(),
        },
        PlainTable {
            title: "Correlation".into(),
            head: std::iter::once(number).chain(names).collect(),
            rows: correlation.collect(),
        },
        PlainTable {
            title: "Fit".into(),
            head: head(&[
                ("values", true),
                ("degrees of freedom", true),
                ("chi-square", true),
                ("reduced", true),
                ("p", true),
                ("iterations", true),
                ("runs", true),
            ]),
            rows: vec![total],
        },
        PlainTable {
            title: "Data".into(),
            head: head(&[
                ("data", false),
                ("use", false),
                ("signal", false),
                ("values", true),
                ("rms", true),
                ("sigma", true),
                ("rms / sigma", true),
                ("p", true),
                ("verdict", false),
            ]),
            rows: data.collect(),
        },
    ]
}
