//! Results of a fit, and the warnings about them.

use serde::Serialize;

use crate::fit::least_squares::Minimum;

/// How a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// At a minimum.
    Converged,
    /// Where residuals jump.
    Stalled,
    /// After the greatest number of iterations.
    MaxIterations,
}

/// Whether data agree with a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Agreement {
    /// They do.
    Agrees,
    /// They do not.
    Differs,
    /// Not tested: their own residuals are the estimate of the noise.
    Untested,
}

/// A fitted parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterResult {
    /// Its first key, and the number of others.
    pub name: String,
    /// Its keys.
    pub keys: Vec<String>,
    /// Its unit; `1` without dimension, empty where it is not known.
    pub unit: String,
    /// First estimate.
    pub start: f64,
    /// The estimate.
    pub estimate: f64,
    /// Its standard error; none if it is not determined or at a bound.
    pub standard_error: Option<f64>,
    /// Its interval.
    pub interval: Option<[f64; 2]>,
    /// `min` or `max`, if the estimate is at a bound.
    pub at_bound: Option<&'static str>,
    /// Whether the data determine it.
    pub determined: bool,
}

/// A direction that the data do not determine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Direction {
    /// The direction in words.
    pub text: String,
    /// Relative change of each parameter, in their order; the direction has length 1.
    pub weights: Vec<f64>,
    /// Its singular value over the greatest.
    pub relative_size: f64,
}

/// A signal of a data set.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChannelResult {
    /// Column of `runner export`.
    pub column: String,
    /// Number of values.
    pub values: usize,
    /// Standard deviation of the noise, in the column's unit.
    pub sigma: f64,
    /// Root mean square of simulated minus measured, in the column's unit.
    pub rms: f64,
    /// The simulated values at the instants of the data.
    #[serde(skip)]
    pub fitted: Vec<f64>,
}

/// A data set with the fitted parameters.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DataResult {
    /// Its name.
    pub name: String,
    /// Checked, not fitted.
    pub hold_out: bool,
    /// Number of values.
    pub values: usize,
    /// Sum of the squares of residuals over noise.
    pub chi_square: f64,
    /// Root mean square of residuals over noise.
    pub rms: f64,
    /// Probability of greater residuals by noise alone; none if not tested.
    pub p_value: Option<f64>,
    /// Whether it agrees with the noise.
    pub agreement: Agreement,
    /// Correlation of consecutive residuals.
    pub autocorrelation: f64,
    /// Its signals.
    pub signals: Vec<ChannelResult>,
}

/// The result of a fit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Name of the fit.
    pub fit: String,
    /// Path of the scenario, as written.
    pub scenario: String,
    /// How the search ended.
    pub status: Status,
    /// Iterations.
    pub iterations: u32,
    /// Runs of the scenario.
    pub runs: usize,
    /// Whether the noise was given.
    pub noise_given: bool,
    /// Confidence of the intervals.
    pub confidence: f64,
    /// The parameters.
    pub parameters: Vec<ParameterResult>,
    /// Correlation of each two parameters; none where one is not determined or at a bound.
    pub correlation: Vec<Vec<Option<f64>>>,
    /// Directions that the data do not determine.
    pub not_determined: Vec<Direction>,
    /// Number of fitted values.
    pub values: usize,
    /// Sum of the squares of residuals over noise.
    pub chi_square: f64,
    /// Values less determined directions.
    pub degrees_of_freedom: usize,
    /// Quotient of the last two.
    pub reduced_chi_square: f64,
    /// Whether the fitted data agree with the given noise.
    pub agreement: Agreement,
    /// Probability of a greater sum by noise alone; none without given noise.
    pub p_value: Option<f64>,
    /// The data sets.
    pub data: Vec<DataResult>,
    /// Warnings.
    pub warnings: Vec<String>,
}

impl Estimate {
    /// True if the search did not converge.
    pub fn is_unfinished(&self) -> bool {
        self.status != Status::Converged
    }

    /// True if a data set disagrees.
    pub fn differs(&self) -> bool {
        self.agreement == Agreement::Differs || self.data.iter().any(|data| data.agreement == Agreement::Differs)
    }

    /// True if a parameter is not determined or at a bound.
    pub fn is_undetermined(&self) -> bool {
        self.parameters.iter().any(|parameter| !parameter.determined || parameter.at_bound.is_some())
    }
}

/// Warnings about a result.
pub fn warnings(estimate: &Estimate, found: &Minimum) -> Vec<String> {
    let mut all = Vec::new();
    match estimate.status {
        Status::Converged => {}
        Status::Stalled => all.push(format!(
            "no step decreases the residuals, although their gradient is not 0 (cosine {:.1e}): they jump, as where \
             contacts change in another order; try other first estimates or shorter data",
            found.cosine
        )),
        Status::MaxIterations => {
            all.push(format!(
                "not converged after {} iterations; `max_iterations` can allow more",
                estimate.iterations
            ));
        }
    }
    if found.failed > 0 {
        all.push(format!("{} trial values were passed over because their runs failed", found.failed));
    }
    all.extend(estimate.not_determined.iter().map(|direction| direction.text.clone()));
    for parameter in &estimate.parameters {
        if let Some(bound) = parameter.at_bound {
            let name = &parameter.name;
            all.push(format!("`{name}` is at its bound `{bound}`, {}: it has no interval", parameter.estimate));
        }
    }
    for data in estimate.data.iter().filter(|data| !data.hold_out) {
        // Five standard errors of the correlation of independent residuals.
        if data.rms > 0.1 && data.values > 20 && data.autocorrelation > 5.0 / (data.values as f64).sqrt() {
            all.push(format!(
                "consecutive residuals of `{}` are correlated ({:.2}): the model lacks something, and the intervals \
                 are too narrow",
                data.name, data.autocorrelation
            ));
        }
    }
    all
}
