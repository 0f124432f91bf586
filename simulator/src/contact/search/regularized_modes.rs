//! Finds which vertices stick and which slip, for given clamped patterns, by regularized friction.
//!
//! The friction law gets a small viscosity e, `u_i = t_i / sqrt(|t_i|^2 + e^2)`, with t_i the
//! tangential motion of vertex i and `-mu_k N_i u_i` its friction. The solution is followed as e
//! goes to zero (a homotopy): vertices that slip keep a motion, vertices that stick follow e. At
//! every e the equations `s = G(s)` of [`crate::contact::search::sliding_directions`] are smooth.
//! Newton steps with the candidate solve's own Jacobian follow the path, in shorter strides where
//! it bends. The modes found are then judged without viscosity.

use crate::contact::model::problem::Problem;
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{Mode, Pattern, SoleState, States};
use crate::contact::search::candidate::CandidateSolver;
use crate::contact::search::sliding_directions::{DirectionFinder, DirectionSearch, is_implicit};
use crate::contact::search::slips::{
    SlipPoints, Slips, means, norm, open_vertices, read_slips, set_directions, slip_point, soles_where, subtract,
    tangential,
};
use nalgebra::Vector3;

/// Viscosity at which the path ends, relative to the frictionless motion.
const LEAST: f64 = 1e-12;

/// Factors of the viscosity per stride: the default, and the shortest stride.
const PACE: f64 = 0.2;
const SHORTEST: f64 = 0.9;

/// Viscosity from which the path may end early.
const ENOUGH: f64 = 1e-8;

/// Rounding of a candidate solve, relative to the frictionless motion.
const ROUNDING: f64 = 3e-14;

impl DirectionFinder {
    /// Follows the slips of the clamped patterns of `states` as the viscosity goes to zero. `None`
    /// if the path cannot be followed.
    pub fn regularized_modes(
        &mut self,
        solver: &mut CandidateSolver,
        p: &mut Problem,
        states: &States,
        out: &mut Solution,
    ) -> Option<RegularizedSlips> {
        let mut all = states.clone();
        for s in (0..p.soles.len()).filter(|&s| states[s].pattern != Pattern::Free) {
            all[s] = SoleState::sliding(states[s].pattern);
        }
        let which = &soles_where(p, |s| is_implicit(p, &all, s))[..];
        if which.is_empty() {
            return Some(RegularizedSlips {
                all,
                slips: Slips::default(),
                at_points: Slips::default(),
                points: means(),
                viscosity: 0.0,
            });
        }
        set_directions(p, &all, which, &means(), &Slips::default(), 0.0);
        solver.solve(p, &all, out);
        let mut slips = read_slips(p, &all, which, &means(), &out.motion, true);
        let drive = norm(which, &slips);
        let mut search =
            DirectionSearch { finder: self, solver, p, states: &all, which, points: means(), drive, viscosity: drive };
        let mut reached: Option<RegularizedSlips> = None;
        let mut factor: f64 = PACE;
        while search.viscosity > LEAST * drive {
            let start = (slips.clone(), search.points.clone());
            search.move_points(&mut slips);
            if let Some(found) = search.converge(slips, out) {
                slips = found;
                let at_means = read_slips(search.p, &all, which, &means(), &out.motion, true);
                reached = Some(RegularizedSlips {
                    all: all.clone(),
                    slips: at_means,
                    at_points: slips.clone(),
                    points: search.points.clone(),
                    viscosity: search.viscosity,
                });
                factor = (factor * factor).max(PACE);
            } else {
                // Retry from the last point with a shorter stride. Rounding ends the path where
                // vertices stick.
                (slips, search.points) = start;
                let last = reached.as_ref()?.viscosity;
                if last <= ENOUGH * drive || factor > SHORTEST {
                    break;
                }
                factor = factor.sqrt();
                search.viscosity = last;
            }
            search.viscosity *= factor;
        }
        reached.filter(|r| r.viscosity <= ENOUGH * drive)
    }
}

/// Slips at the least viscosity reached.
pub struct RegularizedSlips {
    /// The clamped patterns, all sliding.
    all: States,
    /// Slips of the soles, at the means of their vertices.
    pub slips: Slips,
    /// The same at `points`.
    at_points: Slips,
    points: SlipPoints,
    viscosity: f64,
}

impl RegularizedSlips {
    /// Modes of the soles; vertices that move at most `threshold` times the viscosity stick.
    pub fn modes(&self, p: &Problem, threshold: f64) -> States {
        let mut modes = self.all.clone();
        for (s, sole) in p.soles.iter().enumerate().filter(|(s, _)| self.all[*s].pattern != Pattern::Free) {
            let k = sole.vertices.len();
            let centre = slip_point(p, &self.all, s, self.points[s]).0;
            let sticks = |i: &usize| {
                let speed = tangential(&self.at_points[s], &sole.vertices[*i].r, &centre, sole.radius).norm();
                !sole.vertices[*i].moving && speed <= threshold * self.viscosity
            };
            let clamped = || (0..k).filter(|&i| self.all[s].clamps(i, k));
            if clamped().all(|i| sticks(&i)) {
                modes[s].mode = Mode::Static;
            } else if let Some(j) = clamped().find(sticks)
                && self.all[s].normal_rows() > 1
            {
                modes[s].mode = Mode::Pivoting(j as u8);
            }
        }
        modes
    }
}

impl DirectionSearch<'_> {
    /// Moves the slip point of each sole to its slowest open vertex, if that is slow.
    fn move_points(&mut self, slips: &mut Slips) {
        for &s in self.which {
            let centre = slip_point(self.p, self.states, s, self.points[s]).0;
            let sole = &self.p.soles[s];
            let motion = |i: usize| tangential(&slips[s], &sole.vertices[i].r, &centre, sole.radius);
            let slowest =
                open_vertices(self.p, self.states, s).min_by(|&i, &j| motion(i).norm().total_cmp(&motion(j).norm()));
            let Some(i) = slowest else { continue };
            let t = motion(i);
            if self.points[s] != Some(i as u8) && t.norm() < 0.1 * slips[s].norm() {
                slips[s] = Vector3::new(t.x, t.y, slips[s].z);
                self.points[s] = Some(i as u8);
            }
        }
    }

    /// Newton steps at the current viscosity, to a residual of a tenth of it.
    fn converge(&mut self, mut slips: Slips, out: &mut Solution) -> Option<Slips> {
        let mut image = self.evaluate(&slips, out);
        for _ in 0..40 {
            let residual = subtract(self.which, &slips, &image);
            if norm(self.which, &residual) <= (0.1 * self.viscosity).max(ROUNDING * self.drive) {
                return Some(slips);
            }
            let step = self.newton_step(&slips, &residual, out);
            if !self.descend((&mut slips, &mut image), &step, 1.0, out) {
                return None;
            }
        }
        None
    }
}
