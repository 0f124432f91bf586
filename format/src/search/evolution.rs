//! Finds the least value of a function of several keys.
//!
//! Covariance matrix adaptation [Hansen 2016], whose equation numbers are given below, on the unit cube:
//! a generation of lambda positions
//!
//! ```text
//! x_k = m + sigma B D z_k,  z_k ~ N(0, I),  C = B D^2 B^T       (38 - 40)
//! ```
//!
//! is sorted by value, and the mean m, the step size sigma and the covariance C follow from the best mu of
//! them, with the weights w_i and the paths p_sigma and p_c:
//!
//! ```text
//! m       <- m + sigma y_w,  y_w = sum w_i y_i                  (41, 42)
//! p_sigma <- (1 - c_sigma) p_sigma + sqrt(c_sigma (2 - c_sigma) mu_eff) C^(-1/2) y_w      (43)
//! sigma   <- sigma exp(c_sigma / d_sigma (|p_sigma| / E|N(0, I)| - 1))                    (44)
//! p_c     <- (1 - c_c) p_c + h_sigma sqrt(c_c (2 - c_c) mu_eff) y_w                       (45)
//! C       <- (1 - c_1 - c_mu + (1 - h_sigma) c_1 c_c (2 - c_c)) C + c_1 p_c p_c^T
//!            + c_mu sum w_i y_i y_i^T                           (47)
//! ```
//!
//! with positive weights alone. Only the order of the values is used. Positions outside of the cube are
//! drawn again. Each is probed at the nearest position of the lattice.
//!
//! When the positions no longer differ on the lattice, all neighbours of the best one, a step away along
//! one key or two, are probed, and the search continues from a better one until there is none. What it
//! ends with is therefore a minimum among its neighbours.

// Products are of a matrix with a vector, in one order on every processor; others are written out.
#![allow(clippy::disallowed_types)]

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use std::collections::{BTreeMap, BTreeSet};

use super::Position;
use crate::math;
use crate::random::Stream;

/// Step size at the beginning, as a fraction of the ranges.
const SIGMA: f64 = 0.3;

/// Number of times that a position outside of the cube is drawn again before it is moved to its side.
const DRAWS: usize = 100;

/// Number of generations without a new position on the lattice after which neighbours are probed.
const STALE: u32 = 3;

/// What is done next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Generations,
    Neighbours,
    Ended,
}

/// The values at some positions of a lattice.
#[derive(Clone, Debug)]
pub struct Evolution {
    /// Number of steps of the lattice, by key.
    steps: Vec<u64>,
    /// Greatest number of probes.
    most: usize,
    values: BTreeMap<Position, f64>,
    stream: Stream,
    strategy: Strategy,
    /// The present generation: steps y_k, and positions of the lattice.
    generation: Vec<(DVector<f64>, Position)>,
    stale: u32,
    stage: Stage,
}

/// The distribution, and its constants.
#[derive(Clone, Debug)]
struct Strategy {
    mean: DVector<f64>,
    sigma: f64,
    covariance: DMatrix<f64>,
    path_sigma: DVector<f64>,
    path_c: DVector<f64>,
    generations: i32,
    weights: Vec<f64>,
    mu_eff: f64,
    c_sigma: f64,
    d_sigma: f64,
    c_c: f64,
    c_1: f64,
    c_mu: f64,
    /// E|N(0, I)|.
    expected: f64,
}

/// The usual number of positions of a generation for a number of keys (table 1).
pub fn population_for(keys: usize) -> usize {
    4 + (3.0 * math::ln(keys as f64)).floor() as usize
}

impl Evolution {
    /// Begins at a position of the lattice, with at most `most` probes and `population` (at least 2)
    /// positions in each generation.
    pub fn new(steps: Vec<u64>, start: &[u64], (most, population): (usize, usize), seed: u64) -> Self {
        let mean = steps.iter().zip(start).map(|(steps, at)| *at as f64 / *steps as f64);
        let strategy = Strategy::new(DVector::from_iterator(steps.len(), mean), population);
        let mut first = Evolution {
            steps,
            most,
            values: BTreeMap::new(),
            stream: Stream::new(seed, &["search"]),
            strategy,
            generation: Vec::new(),
            stale: 0,
            stage: Stage::Generations,
        };
        first.generation = first.draw(population);
        // The start itself is one of the first positions.
        let zero = DVector::zeros(first.steps.len());
        first.generation[0] = (zero, start.to_vec());
        first
    }

    /// Number of values.
    pub fn probes(&self) -> usize {
        self.values.len()
    }

    /// Adds the value at a position; one that must not be chosen is infinite.
    pub fn add(&mut self, at: &[u64], value: f64) {
        self.values.insert(at.to_vec(), if value.is_nan() { f64::INFINITY } else { value });
    }

    /// The best position and its value, the lowest position of several; none without a finite value.
    pub fn best(&self) -> Option<(&Position, f64)> {
        let finite = self.values.iter().filter(|(_, value)| value.is_finite());
        let first_least = finite.min_by(|(_, a), (_, b)| a.total_cmp(b));
        first_least.map(|(at, value)| (at, *value))
    }

    /// True if no neighbour of the best position is better, all of which were probed.
    pub fn is_minimum(&self) -> bool {
        self.stage == Stage::Ended && self.best().is_some()
    }

    /// The next positions to probe, in ascending order; none at the end. Their values must all be added
    /// before the next call.
    pub fn next_positions(&mut self) -> Vec<Position> {
        loop {
            let wanted: BTreeSet<Position> = match self.stage {
                Stage::Generations => self.generation.iter().map(|(_, at)| at.clone()).collect(),
                Stage::Neighbours => self.neighbours(),
                Stage::Ended => return Vec::new(),
            };
            let wanted: Vec<Position> = wanted.into_iter().filter(|at| !self.values.contains_key(at)).collect();
            if !wanted.is_empty() {
                self.stale = 0;
                // A part of a generation or of the neighbours shows nothing.
                return if wanted.len() <= self.most.saturating_sub(self.probes()) { wanted } else { Vec::new() };
            }
            match self.stage {
                Stage::Generations => self.end_generation(),
                // All are known, so that the best of all is better than they are.
                _ => self.stage = Stage::Ended,
            }
        }
    }

    /// Adapts the distribution to the values of a generation, and draws the next one.
    fn end_generation(&mut self) {
        let mut order: Vec<usize> = (0..self.generation.len()).collect();
        // Stable: equal values stay in the order in which they were drawn.
        order.sort_by(|a, b| self.value(*a).total_cmp(&self.value(*b)));
        let steps: Vec<&DVector<f64>> = order.iter().map(|i| &self.generation[*i].0).collect();
        self.strategy.adapt(&steps);
        self.stale += 1;
        let is_narrow =
            self.steps.iter().zip(self.strategy.deviations()).all(|(n, deviation)| *n as f64 * deviation < 0.5);
        if self.stale >= STALE || is_narrow {
            self.stage = if self.best().is_some() { Stage::Neighbours } else { Stage::Ended };
        } else {
            self.generation = self.draw(self.generation.len());
        }
    }

    fn value(&self, at: usize) -> f64 {
        self.values.get(&self.generation[at].1).copied().unwrap_or(f64::INFINITY)
    }

    /// Draws positions, with their steps from the mean in units of sigma.
    fn draw(&mut self, count: usize) -> Vec<(DVector<f64>, Position)> {
        let root = self.strategy.root();
        let Strategy { mean, sigma, .. } = &self.strategy;
        let stream = &mut self.stream;
        let mut one = || {
            let mut x = mean.clone();
            for _ in 0..DRAWS {
                let z = DVector::from_fn(mean.len(), |_, _| stream.normal());
                x = mean + &root * z * *sigma;
                if x.iter().all(|x| (0.0..=1.0).contains(x)) {
                    break;
                }
            }
            x.apply(|x| *x = x.clamp(0.0, 1.0));
            let at = x.iter().zip(&self.steps).map(|(x, steps)| (x * *steps as f64).round() as u64).collect();
            ((x - mean) / *sigma, at)
        };
        (0..count).map(|_| one()).collect()
    }

    /// The positions a step away from the best one along one key or two.
    fn neighbours(&self) -> BTreeSet<Position> {
        let Some((best, _)) = self.best() else { return BTreeSet::new() };
        let along = |at: &Position, i: usize| {
            let moved = |to: u64| {
                let mut at = at.clone();
                at[i] = to;
                at
            };
            let below = at[i].checked_sub(1).map(moved);
            let above = (at[i] < self.steps[i]).then(|| moved(at[i] + 1));
            below.into_iter().chain(above).collect::<Vec<_>>()
        };
        let mut all = BTreeSet::new();
        for i in 0..best.len() {
            let one = along(best, i);
            all.extend(one.iter().flat_map(|at| (0..i).flat_map(move |j| along(at, j))).collect::<Vec<_>>());
            all.extend(one);
        }
        all
    }
}

impl Strategy {
    fn new(mean: DVector<f64>, population: usize) -> Self {
        let n = mean.len() as f64;
        let parents = (population / 2).max(1);
        let raw = |i: usize| math::ln((population as f64 + 1.0) / 2.0) - math::ln(i as f64);
        let sum: f64 = (1..=parents).map(raw).sum();
        let weights: Vec<f64> = (1..=parents).map(|i| raw(i) / sum).collect();
        let mu_eff = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
        // Table 1.
        let c_sigma = (mu_eff + 2.0) / (n + mu_eff + 5.0);
        let c_1 = 2.0 / ((n + 1.3) * (n + 1.3) + mu_eff);
        let c_mu = 2.0 * (0.25 + mu_eff + 1.0 / mu_eff - 2.0) / ((n + 2.0) * (n + 2.0) + mu_eff);
        let zero = DVector::zeros(mean.len());
        Strategy {
            sigma: SIGMA,
            covariance: DMatrix::identity(mean.len(), mean.len()),
            path_sigma: zero.clone(),
            path_c: zero,
            generations: 0,
            weights,
            mu_eff,
            c_sigma,
            d_sigma: 1.0 + 2.0 * (((mu_eff - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + c_sigma,
            c_c: (4.0 + mu_eff / n) / (n + 4.0 + 2.0 * mu_eff / n),
            c_1,
            c_mu: c_mu.min(1.0 - c_1),
            expected: n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n)),
            mean,
        }
    }

    /// B D.
    fn root(&self) -> DMatrix<f64> {
        let (mut vectors, lengths) = self.axes();
        vectors.column_iter_mut().zip(lengths.iter()).for_each(|(mut column, length)| column *= *length);
        vectors
    }

    /// B, and the diagonal of D.
    fn axes(&self) -> (DMatrix<f64>, DVector<f64>) {
        let SymmetricEigen { eigenvectors, eigenvalues } = self.covariance.clone().symmetric_eigen();
        (eigenvectors, eigenvalues.map(|value| value.max(1e-20).sqrt()))
    }

    /// Standard deviations of the positions, by key.
    fn deviations(&self) -> Vec<f64> {
        self.covariance.diagonal().iter().map(|variance| self.sigma * variance.sqrt()).collect()
    }

    /// Adapts to the steps y of a generation, the best first.
    fn adapt(&mut self, steps: &[&DVector<f64>]) {
        let n = self.mean.len();
        let best = || self.weights.iter().zip(steps);
        let y_w = best().fold(DVector::zeros(n), |sum, (w, y)| sum + *y * *w);
        let rank_mu = |i: usize, j: usize| best().map(|(w, y)| w * y[i] * y[j]).sum::<f64>();
        let rank_mu = DMatrix::from_fn(n, n, rank_mu);
        let (vectors, lengths) = self.axes();
        let whitened = &vectors * vectors.tr_mul(&y_w).component_div(&lengths);
        let Strategy { c_sigma, c_c, c_1, c_mu, mu_eff, .. } = *self;
        self.mean += &y_w * self.sigma;
        self.path_sigma *= 1.0 - c_sigma;
        self.path_sigma += whitened * (c_sigma * (2.0 - c_sigma) * mu_eff).sqrt();
        self.generations += 1;
        let length = self.path_sigma.norm();
        let settled = (1.0 - math::powi(1.0 - c_sigma, 2 * self.generations)).sqrt();
        let is_short = length / settled < (1.4 + 2.0 / (n as f64 + 1.0)) * self.expected;
        self.path_c *= 1.0 - c_c;
        if is_short {
            self.path_c += y_w * (c_c * (2.0 - c_c) * mu_eff).sqrt();
        }
        let lost = if is_short { 0.0 } else { c_1 * c_c * (2.0 - c_c) };
        self.covariance *= 1.0 - c_1 - c_mu + lost;
        let path = &self.path_c;
        self.covariance += DMatrix::from_fn(n, n, |i, j| c_1 * path[i] * path[j] + c_mu * rank_mu[(i, j)]);
        self.sigma *= math::exp((c_sigma / self.d_sigma * (length / self.expected - 1.0)).min(1.0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Searches to the end; `f` is of fractions of the ranges.
    fn search(steps: &[u64], most: usize, seed: u64, f: impl Fn(&[f64]) -> f64) -> Evolution {
        let start: Vec<u64> = steps.iter().map(|n| n / 2).collect();
        let population = population_for(steps.len());
        let mut evolution = Evolution::new(steps.to_vec(), &start, (most, population), seed);
        loop {
            let next = evolution.next_positions();
            if next.is_empty() {
                return evolution;
            }
            for at in next {
                assert!(at.iter().zip(steps).all(|(at, n)| at <= n) && !evolution.values.contains_key(&at));
                let x: Vec<f64> = at.iter().zip(steps).map(|(at, n)| *at as f64 / *n as f64).collect();
                evolution.add(&at, f(&x));
            }
            assert!(evolution.probes() <= most);
        }
    }

    #[test]
    fn populations_are_those_of_the_source() {
        assert_eq!([1, 2, 3, 4, 5, 6].map(population_for), [4, 6, 7, 8, 8, 9]);
    }

    #[test]
    fn minima_of_known_functions_are_found_on_the_lattice() {
        let bowl = |x: &[f64]| x.iter().enumerate().map(|(i, x)| (x - 0.25).powi(2) * (1 + 9 * i) as f64).sum::<f64>();
        for seed in 0..5 {
            for n in 1..=6 {
                let found = search(&vec![1000; n], 4000, seed, bowl);
                assert!(found.is_minimum());
                assert_eq!(found.best().unwrap().0, &vec![250; n]);
            }
            // A curved valley: Rosenbrock's on [-2, 2]^2, whose minimum is at (1, 1).
            let valley = |x: &[f64]| {
                let (x, y) = (4.0 * x[0] - 2.0, 4.0 * x[1] - 2.0);
                100.0 * (y - x * x).powi(2) + (1.0 - x).powi(2)
            };
            // A step is 1e-4, across which the valley is wide.
            let found = search(&[40_000, 40_000], 4000, seed, valley);
            let best = found.best().unwrap();
            assert!(found.is_minimum() && best.1 < 1e-6, "{best:?}");
        }
    }

    #[test]
    fn a_minimum_at_a_corner_is_found() {
        let found = search(&[100, 1000], 1000, 3, |x| x[0] - 2.0 * x[1]);
        assert!(found.is_minimum());
        assert_eq!(found.best().unwrap().0, &vec![0, 1000]);
    }

    #[test]
    fn only_the_order_of_the_values_counts() {
        let bowl = |x: &[f64]| (x[0] - 0.3).powi(2) + 5.0 * (x[1] - 0.6).powi(2);
        let (plain, other) =
            (search(&[500; 2], 300, 1, bowl), search(&[500; 2], 300, 1, |x| bowl(x).sqrt() * 7.0 - 3.0));
        assert!(plain.values.keys().eq(other.values.keys()));
    }

    #[test]
    fn the_covariance_becomes_the_inverse_of_the_curvature() {
        // On a fine lattice the axes of C are those of the ellipses, and its eigenvalues their squares.
        let rotated = |x: &[f64]| {
            let (u, v) = (0.6 * (x[0] - 0.5) + 0.8 * (x[1] - 0.5), 0.8 * (x[0] - 0.5) - 0.6 * (x[1] - 0.5));
            u * u + 100.0 * v * v
        };
        let found = search(&[1 << 40; 2], 600, 2, rotated);
        let c = &found.strategy.covariance;
        let along = |a: [f64; 2], b: [f64; 2]| {
            (0..2).map(|i| (0..2).map(|j| a[i] * c[(i, j)] * b[j]).sum::<f64>()).sum::<f64>()
        };
        let (u, v) = ([0.6, 0.8], [0.8, -0.6]);
        let ratio = along(u, u) / along(v, v);
        // Its random error is large: it follows the last tens of generations.
        assert!((20.0..500.0).contains(&ratio), "{ratio}");
        assert!(along(u, v).abs() < 0.3 * (along(u, u) * along(v, v)).sqrt());
    }

    #[test]
    fn the_best_differs_from_its_neighbours_along_two_keys() {
        // A valley along the diagonal, so steep that a step along one key alone is worse.
        let valley = |x: &[f64]| 1e3 * (x[0] - x[1]).abs() + x[0] + x[1];
        for seed in 0..20 {
            let found = search(&[40; 2], 4000, seed, valley);
            assert!(found.is_minimum());
            assert_eq!(found.best().unwrap().0, &vec![0, 0], "{seed}");
        }
    }

    #[test]
    fn values_that_are_no_numbers_are_the_worst() {
        let mut evolution = Evolution::new(vec![10], &[5], (10, 4), 0);
        for (at, nan) in [(1, f64::NAN), (2, -f64::NAN)] {
            evolution.add(&[at], nan);
            assert_eq!(evolution.values[&vec![at]], f64::INFINITY);
        }
    }

    #[test]
    fn the_distribution_adapts_as_in_the_source() {
        // Values of tests/oracles/make_evolution.py. The second generation has h_sigma = 0.
        let generations = [
            (
                [[1.0, 0.5], [-0.25, 1.0]],
                [
                    0.726561072474774,
                    0.429375571010091,
                    0.278877573699847,
                    0.946524986577749,
                    0.108424416997398,
                    0.883975794427374,
                ],
            ),
            (
                [[3.0, 2.5], [2.0, 3.5]],
                [
                    1.50857920711204,
                    1.18118409172198,
                    0.564098631862241,
                    1.26157866511035,
                    0.448318612171848,
                    1.17043392168284,
                ],
            ),
        ];
        let mut strategy = Strategy::new(DVector::from_vec(vec![0.5, 0.25]), 4);
        for (steps, expected) in generations {
            let steps = steps.map(|step| DVector::from_row_slice(&step));
            strategy.adapt(&steps.iter().collect::<Vec<_>>());
            let Strategy { mean, sigma, covariance: c, .. } = &strategy;
            let found = [mean[0], mean[1], *sigma, c[(0, 0)], c[(0, 1)], c[(1, 1)]];
            for (found, expected) in found.iter().zip(expected) {
                // The frozen values have 15 digits.
                assert!((found - expected).abs() < 1e-14, "{found} {expected}");
            }
        }
    }

    #[test]
    fn without_enough_probes_or_values_there_is_no_minimum() {
        let few = search(&[1000; 3], 20, 0, |x| x.iter().sum());
        assert!(!few.is_minimum() && few.probes() <= 20 && few.best().is_some());
        let none = search(&[10; 2], 500, 0, |_| f64::NAN);
        assert!(none.best().is_none());
        // A constant function ends by its neighbours.
        assert!(search(&[50; 2], 2000, 0, |_| 1.0).is_minimum());
    }
}
