//! Levenberg-Marquardt with bounds, on residuals that may jump.
//!
//! ```text
//! minimize F(u) = |r(u)|^2 / 2,  lower <= u <= upper
//! (J^T J + lambda D^2) s = -J^T r,   u' = clamp(u + s)
//! ```
//!
//! - `D` has the greatest norms of the columns of `J` so far [Marquardt 1963], [Moré 1978].
//! - `lambda` follows the ratio of actual to predicted decrease [Nielsen 1999].
//! - A parameter at a bound whose gradient points outwards is held for the step, and so is one without
//!   effect.
//! - `J` is by central differences, one-sided at bounds and where a run fails. All points of a Jacobian
//!   are evaluated together.
//! - Where no step decreases `F` although the gradient is not 0, as when contact events of other
//!   runs jump into the residuals, `J` is computed once more with steps of a quarter. If that does
//!   not help either, the search ends as [`End::Stalled`].

// Products are of a matrix with a vector, or of two vectors: nalgebra adds them in one order on every processor.
#![allow(clippy::disallowed_types)]

use nalgebra::{DMatrix, DVector};

/// Residuals, and the steps of their differences.
pub trait Model {
    /// Residuals at each point; none where the run fails.
    ///
    /// # Errors
    /// The evaluation was interrupted.
    fn residuals(&self, points: &[Vec<f64>]) -> Result<Vec<Option<Vec<f64>>>, Interrupted>;
    /// Step of the differences of each parameter at a point.
    fn steps(&self, at: &[f64]) -> Vec<f64>;
    /// Least and greatest value of each parameter.
    fn bounds(&self) -> &[(f64, f64)];
}

/// The evaluation was interrupted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interrupted;

/// How a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// At a minimum, within rounding or the error of the differences.
    Converged,
    /// No step decreases the residuals although their gradient is not 0.
    Stalled,
    /// After the greatest number of iterations.
    Iterations,
}

/// A point with its residuals.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// The parameters.
    pub u: Vec<f64>,
    /// The residuals.
    pub r: Vec<f64>,
    /// How the search ended.
    pub end: End,
    /// Iterations.
    pub iterations: u32,
    /// Greatest cosine between the residuals and a column of the Jacobian, of free parameters.
    pub cosine: f64,
    /// Trial points whose runs failed.
    pub failed: usize,
}

/// Steps below this part of a parameter end the search.
const STEP_TOLERANCE: f64 = 1e-10;
/// Predicted relative decreases of `F` below this end the search.
const DECREASE_TOLERANCE: f64 = 1e-10;
/// A cosine below this is one of a minimum, whose Jacobian has errors.
const COSINE_TOLERANCE: f64 = 1e-3;
/// Trials of an iteration.
const MAX_TRIALS: usize = 25;

/// Columns that cannot be computed: no run near the point succeeds.
#[derive(Clone, Debug, PartialEq)]
pub enum SearchError {
    /// The run at the start fails.
    Start,
    /// The runs on both sides of this parameter fail.
    Column(usize),
    /// Interrupted.
    Interrupted,
}

impl From<Interrupted> for SearchError {
    fn from(_: Interrupted) -> Self {
        SearchError::Interrupted
    }
}

/// The Jacobian at a point by differences with steps that are scaled by `factor`.
///
/// # Errors
/// See [`SearchError`].
pub fn jacobian(model: &dyn Model, u: &[f64], r: &[f64], factor: f64) -> Result<DMatrix<f64>, SearchError> {
    let steps = model.steps(u);
    let mut points = Vec::with_capacity(2 * u.len());
    for (j, h) in steps.iter().enumerate() {
        let (low, high) = model.bounds()[j];
        for side in [-1.0, 1.0] {
            let mut point = u.to_vec();
            point[j] = (u[j] + side * factor * h).clamp(low, high);
            points.push(point);
        }
    }
    let values = model.residuals(&points)?;
    let mut matrix = DMatrix::zeros(r.len(), u.len());
    for j in 0..u.len() {
        let side = |k: usize| {
            let moved = points[2 * j + k][j] != u[j];
            values[2 * j + k].as_deref().filter(|_| moved).map(|r| (points[2 * j + k][j], r))
        };
        let here = (u[j], r);
        let (low, high) = match (side(0), side(1)) {
            (None, None) => return Err(SearchError::Column(j)),
            (low, high) => (low.unwrap_or(here), high.unwrap_or(here)),
        };
        let width = high.0 - low.0;
        for i in 0..r.len() {
            matrix[(i, j)] = (high.1[i] - low.1[i]) / width;
        }
    }
    Ok(matrix)
}

/// Searches the minimum from `start`, which is moved into the bounds.
///
/// # Errors
/// See [`SearchError`].
pub fn minimize(model: &dyn Model, start: &[f64], max_iterations: u32) -> Result<Minimum, SearchError> {
    let bounds = model.bounds();
    let mut u: Vec<f64> = start.iter().zip(bounds).map(|(u, (low, high))| u.clamp(*low, *high)).collect();
    let mut r = model.residuals(std::slice::from_ref(&u))?.pop().flatten().ok_or(SearchError::Start)?;
    let (mut lambda, mut raise, mut factor) = (1e-3, 2.0, 1.0);
    let mut scale = vec![0.0_f64; u.len()];
    let (mut cosine, mut failed) = (0.0, 0);
    for iteration in 1..=max_iterations {
        let j = jacobian(model, &u, &r, factor)?;
        let residual = DVector::from_column_slice(&r);
        let gradient = j.tr_mul(&residual);
        let norms: Vec<f64> = j.column_iter().map(|column| column.norm()).collect();
        scale.iter_mut().zip(&norms).for_each(|(scale, norm)| *scale = scale.max(*norm));
        let is_free = |k: &usize| norms[*k] > 0.0 && !is_held(u[*k], bounds[*k], gradient[*k]);
        let free: Vec<usize> = (0..u.len()).filter(is_free).collect();
        let norm = residual.norm();
        let part = |k: &usize| if norm > 0.0 { gradient[*k].abs() / (norms[*k] * norm) } else { 0.0 };
        cosine = free.iter().map(part).fold(0.0, f64::max);
        let done = |u: Vec<f64>, r: Vec<f64>, end: End, failed: usize| {
            Ok(Minimum { u, r, end, iterations: iteration, cosine, failed })
        };
        if norm == 0.0 || free.is_empty() {
            return done(u, r, End::Converged, failed);
        }
        let small = Normal::new(&j, &residual, &free, &scale);
        let mut accepted = false;
        for _ in 0..MAX_TRIALS {
            let room: Vec<(f64, f64)> = free.iter().map(|k| (bounds[*k].0 - u[*k], bounds[*k].1 - u[*k])).collect();
            let step = small.step(lambda, &room);
            let predicted = small.decrease(&step);
            let mut trial = u.clone();
            for (k, s) in free.iter().zip(step.iter()) {
                trial[*k] = (u[*k] + s).clamp(bounds[*k].0, bounds[*k].1);
            }
            let tiny = free.iter().all(|k| (trial[*k] - u[*k]).abs() <= STEP_TOLERANCE * u[*k].abs().max(0.1));
            // A step that is only short because of its damping shows nothing.
            if (tiny || predicted.abs() <= DECREASE_TOLERANCE * 0.5 * norm * norm) && lambda <= 1.0 {
                return done(u, r, End::Converged, failed);
            }
            if tiny {
                break;
            }
            // A step that ends at bounds may lead upwards.
            let value = match predicted > 0.0 {
                true => model.residuals(std::slice::from_ref(&trial))?.pop().flatten(),
                false => None,
            };
            failed += usize::from(value.is_none() && predicted > 0.0);
            let decrease = value.as_ref().map(|value| 0.5 * (norm * norm - value.iter().map(|x| x * x).sum::<f64>()));
            let ratio = decrease.map_or(f64::NEG_INFINITY, |decrease| decrease / predicted);
            if ratio > 1e-4
                && let Some(value) = value
            {
                let bent = 2.0 * ratio - 1.0;
                lambda *= (1.0 - bent * bent * bent).clamp(0.1, 1.0);
                (u, r, raise, accepted) = (trial, value, 2.0, true);
                break;
            }
            lambda *= raise;
            raise *= 2.0;
        }
        if accepted {
            factor = 1.0;
        } else if cosine <= COSINE_TOLERANCE {
            return done(u, r, End::Converged, failed);
        } else if factor == 1.0 {
            (factor, lambda, raise) = (0.25, 1e-3, 2.0);
        } else {
            return done(u, r, End::Stalled, failed);
        }
    }
    Ok(Minimum { u, r, end: End::Iterations, iterations: max_iterations, cosine, failed })
}

/// True for a parameter at a bound whose gradient points outwards.
pub fn is_held(u: f64, (low, high): (f64, f64), gradient: f64) -> bool {
    (u <= low && gradient >= 0.0) || (u >= high && gradient <= 0.0)
}

/// The normal equations of the free parameters, by the triangular factor of the Jacobian.
struct Normal {
    triangle: DMatrix<f64>,
    right: DVector<f64>,
    scale: Vec<f64>,
}

impl Normal {
    fn new(j: &DMatrix<f64>, residual: &DVector<f64>, free: &[usize], scale: &[f64]) -> Self {
        let rows = j.nrows().max(free.len());
        let columns = DMatrix::from_fn(rows, free.len(), |i, k| if i < j.nrows() { j[(i, free[k])] } else { 0.0 });
        let mut right = DVector::from_fn(rows, |i, _| if i < j.nrows() { -residual[i] } else { 0.0 });
        let qr = columns.qr();
        qr.q_tr_mul(&mut right);
        let scale = free.iter().map(|k| if scale[*k] > 0.0 { scale[*k] } else { 1.0 }).collect();
        Normal { triangle: qr.r(), right: right.rows(0, free.len()).into_owned(), scale }
    }

    /// The damped step within `room`, the distances to the bounds. Parameters whose step would leave it
    /// move to their bounds, and the others are solved for again.
    fn step(&self, lambda: f64, room: &[(f64, f64)]) -> DVector<f64> {
        let p = self.scale.len();
        let mut step = DVector::zeros(p);
        let mut open: Vec<usize> = (0..p).collect();
        while !open.is_empty() {
            let rest = &self.right - &self.triangle * &step;
            let root = lambda.sqrt();
            let stacked = DMatrix::from_fn(p + open.len(), open.len(), |i, k| match i {
                i if i < p => self.triangle[(i, open[k])],
                i if i - p == k => root * self.scale[open[k]],
                _ => 0.0,
            });
            let mut right = DVector::from_fn(p + open.len(), |i, _| if i < p { rest[i] } else { 0.0 });
            let qr = stacked.qr();
            qr.q_tr_mul(&mut right);
            let right = right.rows(0, open.len()).into_owned();
            let solved = qr.r().solve_upper_triangular(&right).unwrap_or_else(|| DVector::zeros(open.len()));
            let outside: Vec<bool> = open
                .iter()
                .zip(solved.iter())
                .map(|(k, s)| {
                    let (low, high) = room[*k];
                    let out = *s < low || *s > high;
                    if out {
                        step[*k] = s.clamp(low, high);
                    }
                    out
                })
                .collect();
            if !outside.contains(&true) {
                open.iter().zip(solved.iter()).for_each(|(k, s)| step[*k] = *s);
                break;
            }
            let mut outside = outside.into_iter();
            open.retain(|_| outside.next() == Some(false));
        }
        step
    }

    /// The decrease of `F` that a step has for linear residuals.
    fn decrease(&self, step: &DVector<f64>) -> f64 {
        let moved = &self.triangle * step;
        self.right.dot(&moved) - 0.5 * moved.norm_squared()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Curve<F> {
        bounds: Vec<(f64, f64)>,
        residuals: F,
    }

    impl<F: Fn(&[f64]) -> Option<Vec<f64>>> Model for Curve<F> {
        fn residuals(&self, points: &[Vec<f64>]) -> Result<Vec<Option<Vec<f64>>>, Interrupted> {
            Ok(points.iter().map(|point| (self.residuals)(point)).collect())
        }

        fn steps(&self, at: &[f64]) -> Vec<f64> {
            at.iter().map(|u| 1e-5 * u.abs().max(0.1)).collect()
        }

        fn bounds(&self) -> &[(f64, f64)] {
            &self.bounds
        }
    }

    #[test]
    fn the_valley_of_rosenbrock_is_followed_to_its_minimum() {
        let residuals = |u: &[f64]| Some(vec![10.0 * (u[1] - u[0] * u[0]), 1.0 - u[0]]);
        let model = Curve { bounds: vec![(-5.0, 5.0); 2], residuals };
        let found = minimize(&model, &[-1.2, 1.0], 100).unwrap();
        assert_eq!(found.end, End::Converged);
        // The last step is below 1e-10; differences of a quadratic are exact up to rounding.
        assert!((found.u[0] - 1.0).abs() < 1e-9 && (found.u[1] - 1.0).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn the_minimum_at_a_bound_is_that_of_the_other_parameters() {
        // Without bounds (3, -1).
        let residuals = |u: &[f64]| Some(vec![u[0] - 3.0, u[0] + u[1] - 2.0, u[1] + 1.0]);
        let model = Curve { bounds: vec![(0.0, 2.0), (-5.0, 5.0)], residuals };
        let found = minimize(&model, &[1.0, 4.0], 100).unwrap();
        assert_eq!((found.end, found.u[0]), (End::Converged, 2.0));
        // At u0 = 2, u1^2 + (u1 + 1)^2 is least at -1/2; predicted decreases of 1e-10 end the search.
        assert!((found.u[1] + 0.5).abs() < 1e-5, "{found:?}");
    }

    #[test]
    fn runs_that_fail_shorten_the_step() {
        // ln fails below 0, where the first full step from 20 leads.
        let residuals = |u: &[f64]| (u[0] > 0.0).then(|| vec![u[0].ln()]);
        let model = Curve { bounds: vec![(-100.0, 100.0)], residuals };
        let found = minimize(&model, &[20.0], 100).unwrap();
        assert!(found.failed > 0 && (found.u[0] - 1.0).abs() < 1e-9, "{found:?}");
        assert_eq!(minimize(&model, &[-1.0], 100).unwrap_err(), SearchError::Start);
    }

    #[test]
    fn a_jump_beside_the_minimum_of_a_piece_stalls() {
        // The residual falls towards 1 but jumps up there.
        let residuals = |u: &[f64]| Some(vec![if u[0] < 1.0 { 3.0 - u[0] } else { 9.0 }]);
        let model = Curve { bounds: vec![(-10.0, 10.0)], residuals };
        let found = minimize(&model, &[0.0], 100).unwrap();
        assert!(found.end != End::Converged && found.u[0] < 1.0 && found.cosine > 0.5, "{found:?}");
    }

    #[test]
    fn a_parameter_without_effect_stays() {
        let model = Curve { bounds: vec![(0.0, 5.0); 2], residuals: |u: &[f64]| Some(vec![u[0] - 2.0, 1.0]) };
        let found = minimize(&model, &[1.0, 3.0], 100).unwrap();
        assert_eq!((found.end, found.u[1]), (End::Converged, 3.0));
        // Predicted decreases of 1e-10 of the rest, 1 / 2, end the search.
        assert!((found.u[0] - 2.0).abs() < 1e-5, "{found:?}");
    }
}
