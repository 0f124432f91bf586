//! A fit: data with their runs, parameters on their scales, and weighted residuals.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::batch::{Finding, Findings};
use crate::fit::experiment::Experiment;
use crate::fit::fit_file::FitFile;
use crate::fit::format::Scale;
use crate::fit::least_squares::{Interrupted, Model};
use crate::fit::recording::Recording;
use crate::fit::units;
use crate::math;
use crate::scenario::IntegratorMethod;
use crate::text::plural::plural;

/// A fit whose data, scenarios and robots are loaded and checked.
#[derive(Clone)]
pub struct Fit {
    /// The fit file.
    pub file: FitFile,
    /// The data, in the order of the file.
    pub experiments: Vec<Experiment>,
    /// The parameters, in the order of the file.
    pub parameters: Vec<Parameter>,
    /// Set to interrupt the fit.
    pub cancel: Arc<AtomicBool>,
}

/// A parameter on its scale.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Its first key, and the number of others.
    pub name: String,
    /// Its keys.
    pub keys: Vec<String>,
    /// Its unit; `1` without dimension, empty where it is not known.
    pub unit: String,
    /// First estimate.
    pub start: f64,
    /// Least and greatest value.
    pub bounds: (f64, f64),
    /// Scale of its steps.
    pub scale: Scale,
    /// The value that 1 on the linear scale is.
    typical: f64,
    /// Step of the differences, as a part of the value.
    step: f64,
}

/// Part of the range that is typical of a parameter which starts at 0.
const TYPICAL: f64 = 0.01;

impl Parameter {
    /// The value on the scale of the search.
    pub fn scaled(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => value / self.typical,
            Scale::Log => math::ln(value),
        }
    }

    /// The value of a scaled one.
    pub fn value(&self, scaled: f64) -> f64 {
        let value = match self.scale {
            Scale::Linear => scaled * self.typical,
            Scale::Log => math::exp(scaled),
        };
        value.clamp(self.bounds.0, self.bounds.1)
    }

    /// The change of the scaled value for a relative change of 1 of the value, and that change of the
    /// value; of a value near 0 for its range.
    pub fn relative(&self, value: f64) -> (f64, f64) {
        let range = self.bounds.1 - self.bounds.0;
        match self.scale {
            Scale::Log => (1.0, value),
            Scale::Linear if value.abs() >= 1e-3 * range => (value.abs() / self.typical, value.abs()),
            Scale::Linear => (range / self.typical, range),
        }
    }

    /// The step of the differences on the scale.
    fn difference(&self, scaled: f64) -> f64 {
        match self.scale {
            Scale::Linear => self.step * scaled.abs().max(0.1),
            Scale::Log => self.step,
        }
    }
}

impl Fit {
    /// Reads a fit file with its data and checks its scenarios at the first estimates.
    ///
    /// # Errors
    /// All errors that can be found.
    pub fn load(path: &Path) -> Result<Self, Findings> {
        let file = FitFile::load(path).map_err(|errors| {
            let mut findings = Findings::default();
            findings.extend(errors);
            findings
        })?;
        Self::of_file(file)
    }

    /// Reads the data of a fit file.
    ///
    /// # Errors
    /// See [`Fit::load`].
    pub fn of_file(file: FitFile) -> Result<Self, Findings> {
        let starts = file.spec.parameter.iter();
        let starts: Vec<(String, f64)> =
            starts.flat_map(|p| p.key.all().iter().map(|key| (key.clone(), p.start))).collect();
        let (mut experiments, mut findings) = (Vec::new(), Findings::default());
        for index in 0..file.spec.data.len() {
            match Experiment::load(&file, index, &starts) {
                Ok(experiment) => experiments.push(experiment),
                Err(errors) => errors.iter().for_each(|finding| findings.push(finding.clone())),
            }
        }
        if findings.errors() > 0 {
            return Err(findings);
        }
        let values: usize = experiments.iter().filter(|e| !e.hold_out).map(|e| e.recording.points()).sum();
        if values <= file.spec.parameter.len() {
            let parameters = plural(file.spec.parameter.len(), "parameter");
            let message = format!("{} cannot determine {parameters}", plural(values, "value"));
            findings.push(Finding::Scenario(file.error_at("data", message, None)));
            return Err(findings);
        }
        let parameters = (0..file.spec.parameter.len()).map(|i| parameter(&file, &experiments[0], i)).collect();
        Ok(Fit { file, experiments, parameters, cancel: Arc::default() })
    }

    /// The keys of all parameters with these values.
    pub fn key_values(&self, values: &[f64]) -> Vec<(String, f64)> {
        let each = self.parameters.iter().zip(values);
        each.flat_map(|(parameter, value)| parameter.keys.iter().map(|key| (key.clone(), *value))).collect()
    }

    /// What the data would be for these values of parameters, without noise.
    ///
    /// # Errors
    /// A run fails.
    pub fn simulated(&self, values: &[f64]) -> Result<Vec<Recording>, String> {
        let keys = self.key_values(values);
        let simulate = |experiment: &Experiment| {
            let columns = experiment.simulate(&keys, &self.cancel)?;
            let mut recording = experiment.recording.clone();
            for (channel, column) in recording.channels.iter_mut().zip(columns) {
                let measured = channel.values.iter().zip(column);
                channel.values = measured.map(|(old, new)| if old.is_finite() { new } else { f64::NAN }).collect();
            }
            Ok(recording)
        };
        self.experiments.par_iter().map(simulate).collect()
    }
}

fn parameter(file: &FitFile, experiment: &Experiment, index: usize) -> Parameter {
    let spec = &file.spec.parameter[index];
    let known = units::unit(&spec.key.all()[0], experiment.model());
    let typical = if spec.start == 0.0 { TYPICAL * (spec.max - spec.min) } else { spec.start.abs() };
    Parameter {
        name: spec.key.name(),
        keys: spec.key.all().to_vec(),
        unit: spec.unit.clone().unwrap_or_else(|| known.to_owned()),
        start: spec.start,
        bounds: (spec.min, spec.max),
        scale: spec.scale,
        typical,
        step: spec.step.unwrap_or_else(|| difference_step(experiment)),
    }
}

/// The cube root of the relative error of a run, at which the errors of a central difference by the
/// run's error and by its own order are equal. Runs with fixed steps have equal steps on both sides,
/// so rounding alone counts.
fn difference_step(experiment: &Experiment) -> f64 {
    let integrator = experiment.integrator();
    let error = match integrator.method {
        IntegratorMethod::Rk4 | IntegratorMethod::SemiImplicit => 1e-12,
        _ => integrator.relative_tolerance,
    };
    math::cbrt(error).clamp(1e-5, 1e-2)
}

/// Residuals over the noise of each signal.
pub struct Weighted<'a> {
    fit: &'a Fit,
    bounds: Vec<(f64, f64)>,
    /// Standard deviation of each signal's noise.
    pub sigma: Vec<f64>,
    /// Runs so far.
    pub runs: AtomicUsize,
}

impl<'a> Weighted<'a> {
    /// Residuals of a fit with this noise of each signal.
    pub fn new(fit: &'a Fit, sigma: Vec<f64>) -> Self {
        let scaled = |p: &Parameter| (p.scaled(p.bounds.0), p.scaled(p.bounds.1));
        Weighted { fit, bounds: fit.parameters.iter().map(scaled).collect(), sigma, runs: AtomicUsize::new(0) }
    }

    /// The values of scaled parameters.
    pub fn values(&self, scaled: &[f64]) -> Vec<f64> {
        self.fit.parameters.iter().zip(scaled).map(|(parameter, u)| parameter.value(*u)).collect()
    }

    /// The residuals of an experiment for its simulated columns.
    pub fn residuals_of(&self, experiment: &Experiment, columns: &[Vec<f64>]) -> Vec<f64> {
        let channels = experiment.recording.channels.iter().zip(columns);
        let all = channels.flat_map(|(channel, column)| {
            let (sigma, is_angle) = (self.sigma[channel.signal], is_angle(&channel.column));
            let finite = channel.values.iter().zip(column).filter(|(measured, _)| measured.is_finite());
            finite.map(move |(measured, value)| difference(*value, *measured, is_angle) / sigma)
        });
        all.collect()
    }
}

/// True for an angle that jumps by a full turn.
pub fn is_angle(column: &str) -> bool {
    column.ends_with("roll_rad") || column.ends_with("yaw_rad")
}

/// Simulated minus measured.
pub fn difference(simulated: f64, measured: f64, is_angle: bool) -> f64 {
    let apart = simulated - measured;
    let turn = std::f64::consts::TAU;
    if is_angle && apart.abs() > 0.5 * turn { apart - turn * (apart / turn).round() } else { apart }
}

impl Model for Weighted<'_> {
    fn residuals(&self, points: &[Vec<f64>]) -> Result<Vec<Option<Vec<f64>>>, Interrupted> {
        let fitted: Vec<&Experiment> = self.fit.experiments.iter().filter(|e| !e.hold_out).collect();
        let keys: Vec<_> = points.iter().map(|point| self.fit.key_values(&self.values(point))).collect();
        let jobs: Vec<(usize, &Experiment)> =
            (0..points.len()).flat_map(|point| fitted.iter().map(move |experiment| (point, *experiment))).collect();
        self.runs.fetch_add(jobs.len(), Ordering::Relaxed);
        let run = |(point, experiment): &(usize, &Experiment)| {
            let columns = experiment.simulate(&keys[*point], &self.fit.cancel).ok()?;
            Some(self.residuals_of(experiment, &columns)).filter(|all| all.iter().all(|r| r.is_finite()))
        };
        let parts: Vec<Option<Vec<f64>>> = jobs.par_iter().map(run).collect();
        if self.fit.cancel.load(Ordering::Relaxed) {
            return Err(Interrupted);
        }
        let joined = parts.chunks(fitted.len()).map(|parts| {
            let parts: Option<Vec<&[f64]>> = parts.iter().map(Option::as_deref).collect();
            parts.map(|parts| parts.concat())
        });
        Ok(joined.collect())
    }

    fn steps(&self, at: &[f64]) -> Vec<f64> {
        self.fit.parameters.iter().zip(at).map(|(parameter, u)| parameter.difference(*u)).collect()
    }

    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }
}
