//! Torsional and rolling friction of a point contact.
//!
//! The two bodies touch in a small area around the point. Its pressure carries a moment tau about the point,
//! with limits in proportion to the normal force N ([Contensou 1962], [Leine 2008]; the lengths
//! are those of MuJoCo [Todorov 2012], `condim` 4 and 6):
//!
//! ```text
//! torsion  |tau_n| <= mu_t N          omega_n = 0  or  tau_n = -mu_t N sign(omega_n)
//! rolling  |tau_t| <= mu_r N          omega_t = 0  or  tau_t = -mu_r N omega_t / |omega_t|
//! ```
//!
//! omega is the angular velocity of the first body relative to the second, n the contact's normal, t its plane.
//! Both are set-valued at zero, as Coulomb's law is: at rest the moments are what holds the bodies. They follow
//! from conditions on the angular motion, as the force of a static vertex does. The three limits of friction
//! are independent of each other (`docs/contact.md`, section 21).
//!
//! A held component of omega keeps its value along axes that turn with the contact, `m_ang + beta = 0`, m the
//! motion of the contact frame:
//!
//! ```text
//! omega' along axes that turn with Omega = n x n'    m_ang + omega x Omega      beta = omega x (n x n')
//! ```
//!
//! A spin Omega_n of the axes would change held components only where omega_t is held, and then omega = omega_n n has
//! no product with it.

use crate::contact::model::problem::{Level, Problem, SoleProblem};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::States;
use nalgebra::{Vector2, Vector3};

/// Which components of the relative angular velocity friction holds, and how the others turn.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct TurningMode {
    /// Whether the torsional moment is what holds omega_n.
    pub holds_spin: bool,
    /// Whether the rolling moment is what holds omega_t.
    pub holds_roll: bool,
    /// Direction of components that are not held: unit vector of omega_t in x and y, sign of omega_n in z.
    /// Zero: without friction.
    pub direction: Vector3<f64>,
}

impl Default for TurningMode {
    fn default() -> Self {
        TurningMode { holds_spin: true, holds_roll: true, direction: Vector3::zeros() }
    }
}

/// Limits, motion and mode of a contact.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Turning {
    /// mu_t, m; zero: no torsional friction.
    pub torsional: f64,
    /// mu_r, m; zero: no rolling friction.
    pub rolling: f64,
    /// Relative angular velocity omega, contact axes, rad/s.
    pub velocity: Vector3<f64>,
    /// The term beta of its rate; zero at the velocity level.
    pub bias: Vector3<f64>,
    /// Whether omega_n gives its direction.
    pub spins: bool,
    /// Whether omega_t gives its direction.
    pub rolls: bool,
    /// What is held.
    pub mode: TurningMode,
}

/// Change of the relative angular velocity above which moments count as driven, relative to the drive: the
/// error of event location.
const ONSET: f64 = 1e-7;

/// Greatest angle, rad, between a rolling moment and the motion that it opposes.
const ALIGNED: f64 = 1e-8;

impl Turning {
    /// Whether a torsional moment may hold omega_n.
    pub fn holds_spin(&self) -> bool {
        self.torsional > 0.0 && self.mode.holds_spin
    }

    /// Whether a rolling moment may hold omega_t.
    pub fn holds_roll(&self) -> bool {
        self.rolling > 0.0 && self.mode.holds_roll
    }

    /// Moment of the components that are not held, per newton of normal force.
    pub fn slip_moment(&self) -> Vector3<f64> {
        let roll = if self.holds_roll() { 0.0 } else { -self.rolling };
        let spin = if self.holds_spin() { 0.0 } else { -self.torsional };
        let d = &self.mode.direction;
        Vector3::new(roll * d.x, roll * d.y, spin * d.z)
    }

    /// Sets the directions that the velocity gives; the other components are held.
    pub fn begin(&mut self) {
        let t = self.velocity.xy().try_normalize(0.0).filter(|_| self.rolls).unwrap_or_default();
        let spin = if self.spins { self.velocity.z.signum() } else { 0.0 };
        let direction = Vector3::new(t.x, t.y, spin);
        self.mode = TurningMode { holds_spin: !self.spins, holds_roll: !self.rolls, direction };
    }

    /// Distances of held moments from their limits, as normal forces, N: torsion, rolling. Infinite where
    /// nothing is held.
    pub fn margins(&self, normal: f64, moment: &Vector3<f64>) -> [f64; 2] {
        let spin = if self.holds_spin() { normal - moment.z.abs() / self.torsional } else { f64::INFINITY };
        let roll = if self.holds_roll() { normal - moment.xy().norm() / self.rolling } else { f64::INFINITY };
        [spin, roll]
    }
}

impl SoleProblem {
    /// Its torsional and rolling friction, which only a single vertex has.
    pub fn turning(&self) -> Option<&Turning> {
        let is_point = self.vertices.len() == 1 && (self.turning.torsional > 0.0 || self.turning.rolling > 0.0);
        is_point.then_some(&self.turning)
    }
}

impl Problem {
    /// Whether a contact has torsional or rolling friction.
    pub fn has_turning(&self) -> bool {
        self.soles.iter().any(|sole| sole.turning().is_some())
    }

    /// Clamped contacts with torsional or rolling friction.
    pub fn turning<'a>(&'a self, states: &'a States) -> impl Iterator<Item = (usize, &'a Turning)> {
        let clamped = |s: &usize| states[*s].normal_rows() > 0;
        (0..self.soles.len()).filter(clamped).filter_map(|s| Some((s, self.soles[s].turning()?)))
    }

    /// Sets the modes of all contacts.
    pub fn set_turning_modes(&mut self, modes: &[TurningMode]) {
        self.soles.iter_mut().zip(modes).for_each(|(sole, mode)| sole.turning.mode = *mode);
    }

    /// Lets all components move without friction.
    pub fn free_turning(&mut self) {
        let free = TurningMode { holds_spin: false, holds_roll: false, direction: Vector3::zeros() };
        self.soles.iter_mut().for_each(|sole| sole.turning.mode = free);
    }

    /// Lets turning components move without friction; held ones stay held.
    pub fn clear_turning_directions(&mut self) {
        self.soles.iter_mut().for_each(|sole| sole.turning.mode.direction = Vector3::zeros());
    }

    /// Rate of the relative angular velocity of contact `s`, or at the velocity level that velocity.
    pub fn turning_motion(&self, motion: &[f64], s: usize) -> Vector3<f64> {
        Vector3::from_column_slice(&motion[6 * s + 3..6 * s + 6]) + self.soles[s].turning.bias
    }

    /// A scale of the turning motion of contact `s` under moments of this size.
    pub fn turning_drive(&self, s: usize, moment: f64) -> f64 {
        let n = self.dim();
        let response = (3..6).map(|axis| self.w[(6 * s + axis) * n + 6 * s + axis]).fold(0.0, f64::max);
        response * moment + self.b[6 * s + 3..6 * s + 6].iter().map(|b| b.abs()).fold(0.0, f64::max)
    }
}

/// Moment about the vertex of contact `s`, N m or N m s: what its wrench has besides the force.
pub fn moment(p: &Problem, s: usize, solution: &Solution) -> Vector3<f64> {
    let w = &solution.wrench[6 * s..6 * s + 6];
    Vector3::new(w[3], w[4], w[5]) - p.soles[s].vertices[0].r.cross(&Vector3::new(w[0], w[1], w[2]))
}

/// What is wrong with the mode of a contact.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum TurningFault {
    /// The torsional moment is beyond its limit.
    Spin,
    /// The rolling moment is beyond its limit.
    Roll,
    /// The torsional moment drives the motion that it should oppose.
    DrivenSpin,
    /// The rolling moment does not oppose the motion: sine and cosine of the angle from its direction to the
    /// motion, times the motion.
    Direction(f64, f64),
}

/// The first fault of the mode of contact `s`. Held moments need at least `least` newtons of margin, and `doubtful`
/// ones, which an event has found at their limit, at least `clear`.
pub fn fault(
    p: &Problem,
    s: usize,
    solution: &Solution,
    doubtful: bool,
    [least, clear]: [f64; 2],
) -> Option<TurningFault> {
    let turning = p.soles[s].turning()?;
    let normal = solution.normal[s][0].max(0.0);
    let (moment, motion) = (moment(p, s, solution), p.turning_motion(&solution.motion, s));
    let floor = if doubtful && p.level == Level::Acceleration { clear } else { least };
    let [spin, roll] = turning.margins(normal, &moment);
    if spin < floor {
        return Some(TurningFault::Spin);
    }
    if roll < floor {
        return Some(TurningFault::Roll);
    }
    let d = &turning.mode.direction;
    let drives = |limit: f64| ONSET * p.turning_drive(s, limit * normal);
    let is_open_spin = turning.torsional > 0.0 && !turning.holds_spin() && !turning.spins;
    if is_open_spin && motion.z * d.z < -drives(turning.torsional) {
        return Some(TurningFault::DrivenSpin);
    }
    let is_open_roll = turning.rolling > 0.0 && !turning.holds_roll() && !turning.rolls;
    let t = motion.xy();
    if is_open_roll && t.norm() > drives(turning.rolling) {
        let (sine, cosine) = (d.xy().perp(&t), d.xy().dot(&t));
        if cosine < 0.0 || sine.abs() > ALIGNED * t.norm() {
            return Some(TurningFault::Direction(sine, cosine));
        }
    }
    None
}

/// Violation of the limits by the moments of contact `s` as a normal force, N, and the deviation of their power
/// from maximum dissipation, W. Held velocities over their levers as a speed, m/s.
pub fn residual(p: &Problem, s: usize, solution: &Solution) -> Option<[f64; 3]> {
    let turning = p.soles[s].turning()?;
    let (n, tau, omega) = (solution.normal[s][0].max(0.0), moment(p, s, solution), &turning.velocity);
    let part = |limit: f64, holds: bool, power: f64, size: f64, speed: f64| {
        if limit == 0.0 {
            return [0.0; 3];
        }
        let gap = if holds { 0.0 } else { (limit * n * speed + power).abs() };
        [(size / limit - n).max(0.0), gap, if holds { limit * speed } else { 0.0 }]
    };
    let across = |v: &Vector3<f64>| -> Vector2<f64> { v.xy() };
    let spin = part(turning.torsional, turning.holds_spin(), tau.z * omega.z, tau.z.abs(), omega.z.abs());
    let power = across(&tau).dot(&across(omega));
    let roll = part(turning.rolling, turning.holds_roll(), power, across(&tau).norm(), across(omega).norm());
    Some([0, 1, 2].map(|i| spin[i].max(roll[i])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn margins_are_normal_forces_and_only_of_what_is_held() {
        let mut turning = Turning { torsional: 0.01, rolling: 0.002, ..Turning::default() };
        let moment = Vector3::new(3e-3, 4e-3, -0.02);
        let [spin, roll] = turning.margins(5.0, &moment);
        assert!((spin - 3.0).abs() < 1e-15 && (roll - 2.5).abs() < 1e-15);
        (turning.velocity, turning.spins) = (Vector3::new(0.0, 0.0, -2.0), true);
        turning.begin();
        assert_eq!(turning.margins(5.0, &moment)[0], f64::INFINITY);
        assert_eq!(turning.slip_moment(), Vector3::new(0.0, 0.0, 0.01), "against the spin");
    }
}
