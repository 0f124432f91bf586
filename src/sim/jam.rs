//! Painleve: sliding that no finite force continues, ended by an impulse in no time.
//!
//! Where vertices slide, their normal accelerations answer the normal forces N with the friction these bring along,
//!
//! ```text
//! a_i = b_i + sum_j K_ij N_j        K_ij = e_i . W (e_j - mu_k t_j)
//! ```
//!
//! `e_i` is the wrench of one newton along the normal at vertex i, `t_j` that of one newton along the slip `u_j`, W the
//! inverse inertia seen by the soles with the sticking ones held. For one vertex K is `A_nn - mu_k u . A_nt`. While
//! `x . K x > 0` for every load `x >= 0` (K strictly copositive) forces `N >= 0`, `a >= 0`, `N . a = 0` exist for any b
//! (Cottle, Pang, Stone, *The linear complementarity problem*, theorem 3.8.5). When it is not, a load drives the vertices
//! that carry it into the floor, harder the more the floor pushes (Painleve 1895). Two cases for one vertex:
//!
//! - b < 0, *inconsistent*: neither sliding nor lift-off is possible. A jam.
//! - b > 0, *indeterminate*: sliding under load and lift-off are both possible. Lift-off clamps less and is taken; the
//!   search has found it, so this file is not asked.
//!
//! The jam is an impact without collision (Lecornu 1905; Genot and Brogliato, *Eur. J. Mech. A* 18, 1999): with the normal
//! impulse p as its clock, `dv/dp = A (-mu_k u, 1)`, the vertex is driven into the floor while its slip falls to zero; from
//! then on it sticks, within the cone, and the floor stops it: the impulse `-A^-1 v` in all, v = (slip, 0). For a plane
//! problem its tangential part is `A_nn / |A_nt|` times the normal one, less than mu_k just because K < 0. The velocities
//! after it are those of the plastic impact law of the other impacts for a vanishing approach,
//!
//! ```text
//! v+ = v + d a0 + W p       d -> 0
//! ```
//!
//! (a time step of length d; Stewart, *Arch. Rational Mech. Anal.* 145, 1998, shows that its limit is the solution), which
//! always has an answer: either p is of the order of d and a finite force exists, or it is not and is the jam. That law
//! says as well what all the other vertices do, in three dimensions and with several soles: which are stopped, which slip
//! on another way and which let go. Nothing is pulled, and energy falls: its change is
//! `p . (v+ + v) / 2 = p . v+ - p . W p / 2`, where normal impulses do no work on `v+_n = 0` and friction opposes `v+_t`.
//!
//! In a plane sliding reaches the limit K = 0 by its own motion only where b vanishes too, with a force `-b / K` that may grow beyond
//! any bound while its impulse stays finite (Genot and Brogliato's singular point). The steps end short of it. What is left
//! of that impulse changes no normal velocity, as K = 0; it goes on until b = 0, and the vertex lets go. In space the slip
//! may also turn until K = 0, in no time as the force grows; the impulse then turns it further, K < 0, and that is a jam
//! ([`Simulation::burst`]).

use super::drive::{Drive, take_biases};
use super::error::Stop;
use super::report::Observer;
use super::simulation::Simulation;
use crate::contact::methods::method::Question;
use crate::contact::model::problem::{Level, Problem};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{Pattern, SoleState, States};
use nalgebra::{Vector2, Vector3};

/// Approach that stands for a vanishing one, relative to the greatest speed: a thousand times what the velocity level
/// calls an approach.
const APPROACH: f64 = 1e-7;
/// Most that the step d may change any velocity, relative to the greatest.
const DISTURBANCE: f64 = 1e-4;
/// Part of its slip that a vertex must lose at least for the impulse to be one of no time, well above `DISTURBANCE`.
const LOSS: f64 = 1e-2;
/// Part of the coefficient without friction below which the normal coefficient is at its limit. It goes there as the root
/// of the time left at worst, so steps of 1e-13 s end within some 1e-6 of it.
const LIMIT: f64 = 1e-3;
/// Acceleration away from the floor, relative to the greatest, that says a vertex leaves it.
const LEAVES: f64 = 1e-11;
/// Fall of the coefficient, in the same unit, that tells a slip that turns from one that keeps its direction.
const TURN: f64 = 1e-7;

impl Simulation {
    /// Ends sliding that no finite force continues by an impulse. False when that is not what is wrong. Needs a free
    /// evaluation at the plant's state, for which no state was found valid.
    pub(super) fn jam(&mut self, observer: &mut dyn Observer) -> Result<bool, Stop> {
        // Fixed steps solve the velocity-level problem anyway, and a method that does not search finds no fault.
        if !self.plant.method.locates_events() {
            return Ok(false);
        }
        let Some(drive) = self.least_drive().filter(|d| d.value <= 0.0) else { return Ok(false) };
        // What the search has left is still wanted if this is none.
        let left = (self.plant.problem.clone(), self.plant.solution.clone());
        let struck = self.strike(&drive, observer)?;
        if !struck {
            (self.plant.problem, self.plant.solution) = left;
        }
        Ok(struck)
    }

    /// The impulse of a jam, if there is one.
    fn strike(&mut self, drive: &Drive, observer: &mut dyn Observer) -> Result<bool, Stop> {
        let Some(states) = self.stop_at_once(drive) else { return Ok(false) };
        let jump = self.plant.kick(&self.projection.wrench);
        let loss = -jump.contact;
        self.take(jump);
        let what = format!("no finite force; slip ended by an impulse, energy lost {loss:.6e} J");
        self.tell_jam(drive, &what, observer)?;
        self.adopt(states, observer)?;
        self.plant.evaluate_free();
        Ok(true)
    }

    fn tell_jam(&mut self, drive: &Drive, what: &str, observer: &mut dyn Observer) -> Result<(), Stop> {
        self.metrics.jams += 1;
        let (s, i) = drive.at;
        let message = format!("vertex {i}: normal coefficient {:.6e} 1/kg, {what}", drive.value);
        let sole = self.plant.model.soles[s].name.clone();
        self.event(observer, "jam", &sole, &message)
    }

    /// Ends a step that cannot be taken since the force on a sliding vertex grows without bound. False when that is not
    /// why. Needs a free evaluation.
    pub(super) fn burst(&mut self, observer: &mut dyn Observer) -> Result<bool, Stop> {
        let Some(drive) = self.least_drive().filter(|d| d.value <= LIMIT * d.smooth) else { return Ok(false) };
        let (s, i) = drive.at;
        let start = self.plant.state.v.clone();
        let slip = self.plant.problem.soles[s].vertices[i].velocity.xy();
        if self.turns_into_floor(&drive) {
            return self.strike(&drive, observer);
        }
        let mut kicked = |size: f64| {
            let plant = &mut self.plant;
            plant.state.v.copy_from_slice(&start);
            plant.evaluate_free();
            let jump = plant.kick(&scaled(&drive.wrench, size));
            plant.evaluate_free();
            // Beyond rounding, or sliding with K nearly zero would be found again.
            let size = plant.problem.b.iter().fold(0.0, |m: f64, b| m.max(b.abs()));
            let leaves = plant.problem.vertex_motion(&plant.problem.b, s, i).z >= LEAVES * size;
            (leaves, plant.problem.soles[s].vertices[i].velocity.xy().dot(&slip) > 0.0, jump)
        };
        // The impulse that would stop the slip bounds the search.
        let mut most = self.tolerances.rest;
        while kicked(most).1 && !kicked(most).0 {
            most *= 2.0;
        }
        let (mut low, mut high) = (0.0, most);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            let (leaves, slips, _) = kicked(middle);
            if leaves || !slips { high = middle } else { low = middle }
        }
        let (leaves, _, jump) = kicked(high);
        self.take(jump);
        let end = if leaves { "until it lets go" } else { "until it stops" };
        let what =
            format!("force without bound; an impulse of {high:.6e} N s {end}, energy lost {:.6e} J", -jump.contact);
        self.tell_jam(&drive, &what, observer)?;
        Ok(true)
    }

    /// Does an impulse along this load turn the slip of its vertex so that K falls further?
    fn turns_into_floor(&mut self, drive: &Drive) -> bool {
        let (s, i) = drive.at;
        let start = self.plant.state.v.clone();
        let slip = |sim: &Self| sim.plant.problem.soles[s].vertices[i].velocity.xy();
        let before = slip(self);
        let falls = |sim: &mut Self, size: f64| {
            sim.plant.kick(&scaled(&drive.wrench, size));
            sim.plant.evaluate_free();
            let found = ((slip(sim) - before).norm(), sim.least_drive());
            sim.plant.state.v.copy_from_slice(&start);
            sim.plant.evaluate_free();
            found
        };
        // By a hundredth of the slip.
        let size = self.tolerances.rest;
        let size = 0.01 * before.norm() * size / falls(self, size).0;
        falls(self, size).1.is_some_and(|after| after.value < drive.value - TURN * drive.smooth)
    }

    /// The limit of the module comment: leaves its impulses in `self.projection` and returns the states. None when finite
    /// forces do, or when the velocity level has no answer either.
    fn stop_at_once(&mut self, drive: &Drive) -> Option<States> {
        let tol = self.tolerances;
        let rules = self.rules();
        let forced = self.forced(self.plant.state.time);
        let plant = &mut self.plant;
        let p = &mut plant.problem;
        let vertices =
            || p.soles.iter().enumerate().flat_map(|(s, sole)| (0..sole.vertices.len()).map(move |i| (s, i)));
        let near = |&(s, i): &(usize, usize)| p.soles[s].vertices[i].height <= tol.distance;
        let pressing = vertices().filter(near).map(|(s, i)| -p.vertex_motion(&p.b, s, i).z).fold(0.0, f64::max);
        let fastest = vertices().map(|(s, i)| p.soles[s].vertices[i].velocity.norm()).fold(1.0, f64::max);
        let greatest = vertices().map(|(s, i)| p.vertex_motion(&p.b, s, i).norm()).fold(0.0, f64::max);
        if pressing == 0.0 {
            return None;
        }
        let d = (APPROACH / pressing).min(DISTURBANCE / greatest) * fastest;
        p.level = Level::Velocity;
        for (b, v) in p.b.iter_mut().zip(&plant.reduced.velocity) {
            *b = v + d * *b;
        }
        take_biases(p, d);
        for sole in &mut p.soles {
            sole.target = Vector3::zeros();
            for v in &mut sole.vertices {
                (v.moving, v.direction, v.near) = (false, Vector2::zeros(), v.height <= tol.distance);
            }
        }
        let allowed = |s: usize, state: SoleState| forced[s].is_none_or(|f: SoleState| f.pattern == state.pattern);
        // Several answers may be valid. What jams together stops together, if it can.
        let together = |s: usize, state: SoleState| {
            let k = drive.loaded[s].len();
            allowed(s, state) && (0..k).all(|i| !drive.loaded[s][i] || state.clamps(i, k))
        };
        let question = Question { rules: &rules, event: true, allowed: &together };
        let mut selection = plant.method.impulse(p, &question, &mut plant.solution);
        let mut tested = selection.tested;
        if !selection.consistent {
            p.soles.iter_mut().flat_map(|s| &mut s.vertices).for_each(|v| v.direction = Vector2::zeros());
            let question = Question { rules: &rules, event: true, allowed: &allowed };
            selection = plant.method.impulse(p, &question, &mut plant.solution);
            tested += selection.tested;
        }
        selection.tested = tested;
        let stopped = loses_slip(p, &selection.states, &plant.solution, tol.rest);
        // Once more without the approach, for the impulse of the limit itself.
        p.b.copy_from_slice(&plant.reduced.velocity);
        take_biases(p, 0.0);
        plant.method.respond(p, &selection.states, &mut self.projection);
        if difference(&self.projection.wrench, &plant.solution.wrench) > LOSS {
            // Where a vertex slips on along a direction in which K vanishes, only the approach tells how far.
            self.projection.wrench.copy_from_slice(&plant.solution.wrench);
        }
        self.count(&selection);
        if selection.consistent && stopped {
            return Some(selection.states);
        }
        self.plant.evaluate_free();
        None
    }
}

fn scaled(wrench: &[f64], factor: f64) -> Vec<f64> {
    wrench.iter().map(|w| w * factor).collect()
}

/// Does a sliding vertex that stays clamped lose a part of its slip?
fn loses_slip(p: &Problem, states: &States, after: &Solution, rest: f64) -> bool {
    p.soles.iter().enumerate().filter(|(s, _)| states[*s].pattern != Pattern::Free).any(|(s, sole)| {
        let k = sole.vertices.len();
        sole.vertices.iter().enumerate().filter(|(i, _)| states[s].clamps(*i, k)).any(|(i, v)| {
            let slip = v.velocity.xy();
            let change = (p.vertex_motion(&after.motion, s, i).xy() - slip).norm();
            slip.norm() > rest && change > LOSS * slip.norm()
        })
    })
}

/// Greatest difference, relative to the greatest entry of `b`.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    let size = b.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    a.iter().zip(b).fold(0.0, |m: f64, (x, y)| m.max((x - y).abs())) / size
}
