//! Solves a fit: estimates with intervals, what the data determine, and checks against the noise.
//!
//! Without a `sigma` the noise of each signal is estimated from its residuals and the fit is repeated
//! until the estimates of noise no longer change:
//!
//! ```text
//! sigma_k^2 = sum of squares of signal k / (n_k (1 - p / n))
//! ```
//!
//! Intervals are `estimate +- t standard_error` on the parameter's scale, with the quantile `t` of
//! the normal distribution where `sigma` is given, of Student's with n - p degrees of freedom where
//! it is estimated.

// Products are of a matrix with a vector, or of two vectors: nalgebra adds them in one order on every processor.
#![allow(clippy::disallowed_types)]

use std::sync::atomic::Ordering;

use nalgebra::DMatrix;

use crate::fit::experiment::Experiment;
use crate::fit::format::Scale;
use crate::fit::identifiability::{Axis, Determined, describe, determine};
use crate::fit::least_squares::{self, End, Minimum, Model, SearchError};
use crate::fit::problem::{Fit, Parameter, Weighted, difference, is_angle};
use crate::fit::results::{
    Agreement, ChannelResult, DataResult, Direction, Estimate, ParameterResult, Status, warnings,
};
use crate::math;
use crate::statistics::{chi_square_tail, f_tail, normal_quantile, student_quantile};

/// Rounds of estimating the noise.
const MAX_ROUNDS: usize = 20;

/// Relative change of an estimated noise that ends the rounds.
const NOISE_TOLERANCE: f64 = 1e-3;

/// Noise below this part of a signal's greatest value is rounding.
const ROUNDING: f64 = 1e-15;

/// Why a fit has no result.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    /// It was interrupted.
    #[error("interrupted")]
    Interrupted,
    /// No run succeeds where one is needed.
    #[error("{0}")]
    Run(String),
}

impl Fit {
    /// Finds the parameters.
    ///
    /// # Errors
    /// The fit is interrupted, or the runs at the first estimates or around an estimate fail.
    pub fn solve(&self) -> Result<Estimate, FitError> {
        let spec = &self.file.spec;
        let given: Option<Vec<f64>> = spec.signal.iter().map(|signal| signal.sigma).collect();
        let start: Vec<f64> = self.parameters.iter().map(|p| p.scaled(p.start)).collect();
        let mut weighted = Weighted::new(self, given.clone().unwrap_or_else(|| self.spreads()));
        let mut found = self.minimum(&weighted, &start)?;
        let mut iterations = found.iterations;
        if given.is_none() {
            for _ in 0..MAX_ROUNDS {
                let before = std::mem::take(&mut weighted.sigma);
                weighted.sigma = self.estimated_noise(&before, &found.r);
                let change = before.iter().zip(&weighted.sigma).map(|(a, b)| (b / a - 1.0).abs()).fold(0.0, f64::max);
                // The weight of a single signal does not matter.
                if change < NOISE_TOLERANCE || weighted.sigma.len() == 1 {
                    break;
                }
                found = self.minimum(&weighted, &found.u)?;
                iterations += found.iterations;
            }
            found.r = weighted.residuals(std::slice::from_ref(&found.u)).ok().and_then(|mut all| all.pop()?).ok_or(
                // The same run has just succeeded.
                FitError::Interrupted,
            )?;
        }
        self.judge(&weighted, Minimum { iterations, ..found }, given.is_some())
    }

    fn minimum(&self, weighted: &Weighted, start: &[f64]) -> Result<Minimum, FitError> {
        let most = self.file.spec.max_iterations;
        least_squares::minimize(weighted, start, most).map_err(|error| self.explain(error, weighted, start))
    }

    fn explain(&self, error: SearchError, weighted: &Weighted, start: &[f64]) -> FitError {
        match error {
            SearchError::Interrupted => FitError::Interrupted,
            SearchError::Column(index) => FitError::Run(format!(
                "no run succeeds with `{}` slightly smaller or greater than its estimate",
                self.parameters[index].name
            )),
            SearchError::Start => {
                let keys = self.key_values(&weighted.values(start));
                let fitted = self.experiments.iter().filter(|e| !e.hold_out);
                let mut errors = fitted.filter_map(|e| e.simulate(&keys, &self.cancel).err());
                let reason = errors.next().unwrap_or_else(|| "a residual is not finite".into());
                FitError::Run(format!("with the first estimates {reason}"))
            }
        }
    }

    /// Standard deviation of the data of each signal, as a first weight.
    fn spreads(&self) -> Vec<f64> {
        let spread = |signal: usize| {
            let channels = self.experiments.iter().filter(|e| !e.hold_out).flat_map(|e| &e.recording.channels);
            let (mut sum, mut count) = (0.0, 0);
            for channel in channels.filter(|channel| channel.signal == signal) {
                let values = || channel.values.iter().filter(|value| value.is_finite());
                let mean = values().sum::<f64>() / values().count().max(1) as f64;
                sum += values().map(|value| (value - mean) * (value - mean)).sum::<f64>();
                count += values().count();
            }
            let spread = (sum / count.max(1) as f64).sqrt();
            if spread > 0.0 { spread } else { 1.0 }
        };
        (0..self.file.spec.signal.len()).map(spread).collect()
    }

    /// The noise of each signal by the residuals `r` over the noise `before`.
    fn estimated_noise(&self, before: &[f64], r: &[f64]) -> Vec<f64> {
        let mut sums = vec![(0.0, 0_usize, 0.0_f64); before.len()];
        let mut rest = r.iter();
        for channel in self.experiments.iter().filter(|e| !e.hold_out).flat_map(|e| &e.recording.channels) {
            let (sum, count, greatest) = &mut sums[channel.signal];
            for value in channel.values.iter().filter(|value| value.is_finite()) {
                let residual = rest.next().copied().unwrap_or(0.0) * before[channel.signal];
                *sum += residual * residual;
                *count += 1;
                *greatest = greatest.max(value.abs());
            }
        }
        let share = 1.0 - self.parameters.len() as f64 / r.len() as f64;
        let noise = |(sum, count, greatest): (f64, usize, f64)| {
            let rounding = ROUNDING * if greatest > 0.0 { greatest } else { 1.0 };
            (sum / (count.max(1) as f64 * share)).sqrt().max(rounding)
        };
        sums.into_iter().map(noise).collect()
    }

    /// The result at a minimum.
    fn judge(&self, weighted: &Weighted, found: Minimum, noise_given: bool) -> Result<Estimate, FitError> {
        let spec = &self.file.spec;
        let local = self.linearize(weighted, &found)?;
        let chi_square: f64 = found.r.iter().map(|r| r * r).sum();
        let degrees_of_freedom = found.r.len() - (local.free.len() - local.determined.blind.len());
        let quantile = match noise_given {
            true => normal_quantile(spec.confidence),
            false => student_quantile(spec.confidence, degrees_of_freedom as f64),
        };
        let p_value = noise_given.then(|| chi_square_tail(chi_square, degrees_of_freedom as f64));
        let reduced = if degrees_of_freedom > 0 { chi_square / degrees_of_freedom as f64 } else { 0.0 };
        let data = self.data_results(weighted, &local.values, (reduced, degrees_of_freedom), noise_given)?;
        let all = 0..local.values.len();
        let mut estimate = Estimate {
            fit: self.file.name(),
            scenario: spec.scenario.clone(),
            status: match found.end {
                End::Converged => Status::Converged,
                End::Stalled => Status::Stalled,
                End::Iterations => Status::MaxIterations,
            },
            iterations: found.iterations,
            runs: weighted.runs.load(Ordering::Relaxed) + data.iter().filter(|d| d.hold_out).count(),
            noise_given,
            confidence: spec.confidence,
            parameters: all.clone().map(|k| local.parameter(&self.parameters[k], k, quantile)).collect(),
            correlation: all.clone().map(|a| all.clone().map(|b| local.correlation(a, b)).collect()).collect(),
            not_determined: local.directions(&self.parameters),
            values: found.r.len(),
            chi_square,
            degrees_of_freedom,
            reduced_chi_square: reduced,
            agreement: agreement(p_value, spec.significance),
            p_value,
            data,
            warnings: Vec::new(),
        };
        estimate.warnings = warnings(&estimate, &found);
        Ok(estimate)
    }

    /// What the residuals around a minimum determine. Parameters at bounds are fixed there.
    fn linearize(&self, weighted: &Weighted, found: &Minimum) -> Result<Local, FitError> {
        let jacobian = |factor: f64| {
            let made = least_squares::jacobian(weighted, &found.u, &found.r, factor);
            made.map_err(|error| self.explain(error, weighted, &found.u))
        };
        let (coarse, fine) = (jacobian(1.0)?, jacobian(0.5)?);
        let values = weighted.values(&found.u);
        let at_bound: Vec<_> = found.u.iter().zip(weighted.bounds()).map(|(u, bounds)| bound(*u, *bounds)).collect();
        let free: Vec<usize> = (0..values.len()).filter(|k| at_bound[*k].is_none()).collect();
        let relative: Vec<(f64, f64)> = self.parameters.iter().zip(&values).map(|(p, v)| p.relative(*v)).collect();
        let scaled =
            |j: &DMatrix<f64>| DMatrix::from_fn(j.nrows(), free.len(), |i, k| j[(i, free[k])] * relative[free[k]].0);
        let range = |k: &usize| (weighted.bounds()[*k].1 - weighted.bounds()[*k].0) / relative[*k].0;
        let ranges: Vec<f64> = free.iter().map(range).collect();
        let (fine, coarse) = (scaled(&fine), scaled(&coarse));
        let determined = determine(&fine, (&fine - &coarse).norm(), &ranges);
        let sizes = relative.into_iter().map(|(_, size)| size).collect();
        Ok(Local { values, sizes, at_bound, free, determined })
    }

    /// The data with the fitted parameters.
    fn data_results(
        &self,
        weighted: &Weighted,
        values: &[f64],
        fitted: (f64, usize),
        noise_given: bool,
    ) -> Result<Vec<DataResult>, FitError> {
        let keys = self.key_values(values);
        let mut results = Vec::new();
        for experiment in &self.experiments {
            let columns = experiment.simulate(&keys, &self.cancel);
            let columns = match columns {
                Ok(columns) => columns,
                Err(_) if self.cancel.load(Ordering::Relaxed) => return Err(FitError::Interrupted),
                Err(reason) => return Err(FitError::Run(format!("with the fitted values {reason}"))),
            };
            results.push(self.data_result(weighted, experiment, &columns, fitted, noise_given));
        }
        Ok(results)
    }

    fn data_result(
        &self,
        weighted: &Weighted,
        experiment: &Experiment,
        columns: &[Vec<f64>],
        (reduced, freedom): (f64, usize),
        noise_given: bool,
    ) -> DataResult {
        let spec = &self.file.spec;
        let r = weighted.residuals_of(experiment, columns);
        let count = r.len() as f64;
        let chi_square: f64 = r.iter().map(|r| r * r).sum();
        let tested = experiment.hold_out || noise_given;
        // A fit without any residual leaves no noise to test against.
        let p_value = match (tested, noise_given) {
            (false, _) => None,
            (true, true) => Some(chi_square_tail(chi_square, count)),
            (true, false) if reduced > 0.0 => Some(f_tail(chi_square / count / reduced, count, freedom as f64)),
            (true, false) => None,
        };
        let agreement = match spec.hold_out_ratio.filter(|_| experiment.hold_out) {
            Some(ratio) if (chi_square / count).sqrt() <= ratio * reduced.sqrt() => Agreement::Agrees,
            Some(_) => Agreement::Differs,
            None => agreement(p_value, spec.significance),
        };
        let channels = experiment.recording.channels.iter().zip(columns);
        let signals = channels.map(|(channel, fitted)| {
            let pairs = channel.values.iter().zip(fitted).filter(|(measured, _)| measured.is_finite());
            let apart: Vec<f64> = pairs.map(|(a, b)| difference(*b, *a, is_angle(&channel.column))).collect();
            let rms = (apart.iter().map(|x| x * x).sum::<f64>() / apart.len().max(1) as f64).sqrt();
            let (column, sigma) = (channel.column.clone(), weighted.sigma[channel.signal]);
            ChannelResult { column, values: apart.len(), sigma, rms, fitted: fitted.clone() }
        });
        DataResult {
            name: experiment.name.clone(),
            hold_out: experiment.hold_out,
            values: r.len(),
            chi_square,
            rms: (chi_square / count).sqrt(),
            p_value,
            agreement,
            autocorrelation: autocorrelation(experiment, &r),
            signals: signals.collect(),
        }
    }
}

/// The parameters at a minimum with what is determined around it.
struct Local {
    values: Vec<f64>,
    /// The change of each value that is a relative one of 1.
    sizes: Vec<f64>,
    at_bound: Vec<Option<&'static str>>,
    /// Parameters that are not at bounds.
    free: Vec<usize>,
    /// In relative changes of the free parameters.
    determined: Determined,
}

impl Local {
    /// Index among the free parameters.
    fn place(&self, k: usize) -> Option<usize> {
        self.free.iter().position(|other| *other == k)
    }

    fn parameter(&self, parameter: &Parameter, k: usize, quantile: f64) -> ParameterResult {
        let place = self.place(k);
        let is_determined = place.is_none_or(|at| self.determined.parameters[at]);
        let error = place.filter(|_| is_determined).map(|at| self.determined.covariance[(at, at)].sqrt());
        let (value, size) = (self.values[k], self.sizes[k]);
        let interval = error.map(|error| match parameter.scale {
            Scale::Linear => [value - quantile * error * size, value + quantile * error * size],
            Scale::Log => [value * math::exp(-quantile * error), value * math::exp(quantile * error)],
        });
        ParameterResult {
            name: parameter.name.clone(),
            keys: parameter.keys.clone(),
            unit: parameter.unit.clone(),
            start: parameter.start,
            estimate: value,
            standard_error: error.map(|error| error * size),
            interval,
            at_bound: self.at_bound[k],
            determined: is_determined,
        }
    }

    fn correlation(&self, a: usize, b: usize) -> Option<f64> {
        let (i, j) = (self.place(a)?, self.place(b)?);
        let c = &self.determined.covariance;
        let are_determined = self.determined.parameters[i] && self.determined.parameters[j];
        are_determined.then(|| if i == j { 1.0 } else { c[(i, j)] / (c[(i, i)] * c[(j, j)]).sqrt() })
    }

    /// The directions that are not determined.
    fn directions(&self, parameters: &[Parameter]) -> Vec<Direction> {
        let axis = |k: &usize| {
            let Parameter { name, unit, .. } = &parameters[*k];
            let is_negative = self.values[*k] < 0.0;
            Axis { name: name.clone(), unit: unit.clone(), scale: self.sizes[*k], is_negative }
        };
        let axes: Vec<Axis> = self.free.iter().map(axis).collect();
        let direction = |(blind, size): &(Vec<f64>, f64)| {
            let mut weights = vec![0.0; self.values.len()];
            self.free.iter().zip(blind).for_each(|(k, part)| weights[*k] = *part);
            let greatest = self.determined.greatest;
            let relative_size = if greatest > 0.0 { size / greatest } else { 0.0 };
            Direction { text: describe(blind, &axes), weights, relative_size }
        };
        self.determined.blind.iter().map(direction).collect()
    }
}

fn agreement(p_value: Option<f64>, significance: f64) -> Agreement {
    match p_value {
        None => Agreement::Untested,
        Some(p) if p >= significance => Agreement::Agrees,
        Some(_) => Agreement::Differs,
    }
}

fn bound(u: f64, (low, high): (f64, f64)) -> Option<&'static str> {
    if u <= low {
        Some("min")
    } else if u >= high {
        Some("max")
    } else {
        None
    }
}

/// Correlation of consecutive residuals of the same channel.
fn autocorrelation(experiment: &Experiment, r: &[f64]) -> f64 {
    let (mut products, mut squares, mut from) = (0.0, 0.0, 0);
    for channel in &experiment.recording.channels {
        let count = channel.values.iter().filter(|value| value.is_finite()).count();
        let own = &r[from..from + count];
        products += own.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>();
        squares += own.iter().map(|x| x * x).sum::<f64>();
        from += count;
    }
    if squares > 0.0 { products / squares } else { 0.0 }
}
