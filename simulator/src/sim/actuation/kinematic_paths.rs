//! Paths from one control tick to the next: the prescribed motion of kinematic joints and, if commands are
//! interpolated, the desired motion of position servos.
//!
//! ```text
//! q(t0 + s T) = q0 + (q1 - q0) (3 s^2 - 2 s^3) + T qd0 s (1 - s)^2 - T qd1 s^2 (1 - s)
//! ```
//!
//! is the cubic of a tick of length T from the present position and velocity (q0, qd0), of a servo those
//! that its last path has reached, to those extrapolated from the commands for the next tick (q1, qd1).
//! Two successive commands a and b belong to one smooth motion if
//! `|dq - T (qd_a + qd_b) / 2| <= T |dqd| / 5`, where dqd is the change of velocity between them or the
//! one before, if greater; then the cubic through both is continued. Otherwise the last command is continued by
//! its own velocity,
//! `(q_des + T qd_des, qd_des)`. If no tick follows, the joint moves to its command and rests
//! there.
//!
//! Position and velocity are therefore continuous. Commands that are cubic polynomials in time are
//! followed exactly from the third tick on, others with an error of order T^4. A command that jumps
//! is reached within one tick.
//!
//! Where the commands are known ahead (`Interpolation::Continuous`), the path is the polynomial of degree 7 with
//! their positions and velocities at four instants, the ends and thirds of a span of many ticks:
//!
//! ```text
//! q(s) = sum_k c_k N_k(s),   N_k = product of the first k of s, s, s - 1/3, s - 1/3, s - 2/3, s - 2/3, s - 1
//! ```
//!
//! with the divided differences c_k. The span is as long as the polynomial agrees with the commands between
//! these instants, near the middle, where its error is greatest, and at least a tick. A tick with a kink has the cubic.

use crate::dynamics::State;
use crate::math;
use crate::robot::{DriveMode, Model};
use crate::task::Command;
use std::array;

/// What position servos follow between two control ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// The last command.
    #[default]
    Hold,
    /// The cubic of the last two commands.
    Cubic,
    /// The commands as functions of time where they are known ahead, otherwise the cubic.
    Continuous,
}

/// Ticks whose commands are known ahead.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// Time of the last of them, s.
    pub end: f64,
    /// Their number.
    pub ticks: u64,
    /// Are the commands smooth until then?
    pub is_smooth: bool,
}

/// Instants of a span at which commands are computed ahead, as parts of it: the nodes, then one near the middle between
/// each two. No oscillation of less than 10 000 periods in a span has the same phase at all of them.
pub const INSTANTS: [f64; 6] = [1.0 / 3.0, 2.0 / 3.0, 1.0, 0.1571, 0.4877, 0.8263];

/// The nodes of the polynomial, each with its velocity.
const NODES: [f64; 4] = [0.0, INSTANTS[0], INSTANTS[1], 1.0];

/// Greatest deviation of a polynomial from the commands, relative to their change over the span, and to their
/// greatest velocity.
const ACCURATE: (f64, f64) = (1e-10, 1e-9);

/// Greatest jump of the acceleration between two spans of one smooth motion, relative to the velocity per length of the
/// span: that of polynomials which are as accurate as [`ACCURATE`] says. The end of a ramp jumps by 0.01 or more.
const JOINED: f64 = 1e-6;

/// Rounding of positions, rad or m.
const ROUNDING: f64 = 1e-14;

/// Greatest deviation of two commands from one smooth motion, relative to the distance that the
/// change of velocity covers in a tick. At an inflection the deviation is 1/12 of the change j T
/// due to the jerk j, and the greater of two successive changes is at least half of j T.
const SMOOTH: f64 = 0.2;

/// Position, velocity and acceleration of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointMotion {
    /// Position, rad or m.
    pub q: f64,
    /// Velocity.
    pub qd: f64,
    /// Acceleration.
    pub qdd: f64,
}

/// The path of one joint between two instants.
#[derive(Clone, Copy, Debug, PartialEq)]
struct JointPath {
    /// Start and end, s.
    span: (f64, f64),
    from: JointMotion,
    to: JointMotion,
    /// Divided differences of the polynomial; none: the cubic.
    polynomial: Option<[f64; 8]>,
}

/// Divided differences on [`NODES`] of motions with these positions, and velocities times the length of the span.
fn divided_differences(motions: &[(f64, f64); 4]) -> [f64; 8] {
    let at = |k: usize| NODES[k / 2];
    let mut c: [f64; 8] = array::from_fn(|k| motions[k / 2].0);
    for order in 1..8 {
        for k in (order..8).rev() {
            c[k] =
                if order == 1 && k % 2 == 1 { motions[k / 2].1 } else { (c[k] - c[k - 1]) / (at(k) - at(k - order)) };
        }
    }
    c
}

/// Value and derivatives at s of a polynomial with these divided differences.
fn evaluate(c: &[f64; 8], s: f64) -> (f64, f64, f64) {
    let (mut p, mut p1, mut p2) = (c[7], 0.0, 0.0);
    for k in (0..7).rev() {
        let x = s - NODES[k / 2];
        p2 = p2 * x + 2.0 * p1;
        p1 = p1 * x + p;
        p = p * x + c[k];
    }
    (p, p1, p2)
}

impl JointPath {
    /// The motion at time `t`. `within`, a time inside the present smooth piece, selects the side
    /// of the path's end.
    fn at(&self, t: f64, within: f64) -> JointMotion {
        let (begin, end) = self.span;
        if within >= end {
            return JointMotion { q: self.to.q + self.to.qd * (t - end), qd: self.to.qd, qdd: 0.0 };
        }
        let (length, distance) = (end - begin, self.to.q - self.from.q);
        let s = ((t - begin) / length).clamp(0.0, 1.0);
        if let Some(c) = &self.polynomial {
            if s == 1.0 {
                return JointMotion { qdd: evaluate(c, s).2 / (length * length), ..self.to };
            }
            let (q, rate, bend) = evaluate(c, s);
            return JointMotion { q, qd: rate / length, qdd: bend / (length * length) };
        }
        let (v0, v1, mean) = (self.from.qd, self.to.qd, distance / length);
        let r = 1.0 - s;
        JointMotion {
            q: if s == 1.0 {
                self.to.q
            } else {
                self.from.q + distance * s * s * (3.0 - 2.0 * s) + length * s * r * (v0 * r - v1 * s)
            },
            qd: mean * 6.0 * s * r + v0 * r * (1.0 - 3.0 * s) + v1 * s * (3.0 * s - 2.0),
            qdd: (mean * 6.0 * (1.0 - 2.0 * s) + v0 * (6.0 * s - 4.0) + v1 * (6.0 * s - 2.0)) / length,
        }
    }
}

/// The prescribed motions of one run.
#[derive(Clone, Debug, Default)]
pub struct KinematicPaths {
    /// By joint; none for those that follow their commands as they are.
    paths: Vec<Option<JointPath>>,
    /// The kinematic joints.
    joints: Vec<usize>,
    /// Joints whose servo follows a path.
    tracked: Vec<usize>,
    interpolation: Interpolation,
    /// The last command of each joint and its time; the acceleration is the mean since the previous
    /// command.
    commands: Vec<(f64, JointMotion)>,
    /// End of all paths, s.
    end: f64,
    /// Do the present paths continue the last ones with their accelerations?
    is_joined: bool,
}

impl KinematicPaths {
    /// Paths of a robot with `nj` joints, none of them kinematic yet.
    pub fn new(nj: usize, interpolation: Interpolation) -> Self {
        KinematicPaths {
            paths: vec![None; nj],
            joints: Vec::with_capacity(nj),
            tracked: Vec::with_capacity(nj),
            interpolation,
            commands: vec![(f64::NEG_INFINITY, JointMotion::default()); nj],
            end: f64::NEG_INFINITY,
            is_joined: false,
        }
    }

    /// The joints whose motion is prescribed, in ascending order.
    pub fn joints(&self) -> &[usize] {
        &self.joints
    }

    /// The joints whose servo follows a path, in ascending order.
    pub fn tracked(&self) -> &[usize] {
        &self.tracked
    }

    /// The commands that drives follow: those of the tick, or interpolated ones.
    pub fn followed<'a>(&self, held: &'a Command, interpolated: &'a Command) -> &'a Command {
        if self.tracked.is_empty() { held } else { interpolated }
    }

    /// Are ticks left out whose commands are known ahead?
    pub fn looks_ahead(&self) -> bool {
        self.interpolation == Interpolation::Continuous
    }

    /// Plans the paths of a tick of length `period` that begins at the state's time. `next` is the
    /// time of the next command, if there is one.
    pub fn plan(&mut self, model: &Model, command: &Command, state: &State, period: f64, next: Option<f64>) {
        let now = state.time;
        let next = next.filter(|t| *t < now + 1.5 * period && *t > now);
        let end = next.unwrap_or(now + period);
        self.joints.clear();
        self.tracked.clear();
        for j in 0..self.paths.len() {
            if !self.has_path(command, j) {
                self.paths[j] = None;
                self.commands[j].0 = f64::NEG_INFINITY;
                continue;
            }
            let command_now = JointMotion { q: command.position[j], qd: command.velocity[j], qdd: 0.0 };
            let from = self.start(j, (model, state), command, now - 0.5 * period);
            if command.mode[j] == DriveMode::Kinematic {
                self.joints.push(j)
            } else {
                self.tracked.push(j)
            }
            let (last_time, last) = std::mem::replace(&mut self.commands[j], (now, command_now));
            let follows = last_time > now - 1.5 * period && last_time < now;
            if follows {
                self.commands[j].1.qdd = (command_now.qd - last.qd) / (now - last_time);
            }
            let to = match next {
                None => JointMotion { qd: 0.0, ..command_now },
                Some(_) if follows => extrapolate(&last, &command_now, now - last_time, end - now),
                Some(_) => JointMotion { q: command_now.q + command_now.qd * (end - now), ..command_now },
            };
            self.paths[j] = Some(JointPath { span: (now, end), from, to, polynomial: None });
        }
        self.end = end;
        self.is_joined = false;
    }

    /// Plans paths over a span, from the present `command` on. `ahead` are the commands at [`INSTANTS`] and one tick
    /// before the end. Returns whether the paths agree with them and continue the present ones; otherwise nothing
    /// has changed. Those of a single tick need not.
    pub fn plan_ahead(&mut self, at: (&Model, &State), command: &Command, span: &Span, ahead: &[Command; 7]) -> bool {
        let (now, nj) = (at.1.time, self.paths.len());
        let (length, tick) = (span.end - now, (span.end - now) / span.ticks as f64);
        let motion = |a: &Command, j: usize| JointMotion { q: a.position[j], qd: a.velocity[j], qdd: 0.0 };
        let continues = |paths: &Self, j: usize| {
            let (from, to) = (paths.start(j, at, command, now - 0.5 * tick), motion(command, j));
            (from.q, from.qd) == (to.q, to.qd)
        };
        let follows = |j: usize| match self.has_path(command, j) {
            true => continues(self, j) && (rests(command, ahead, j) || agrees(command, ahead, j, length)),
            false => is_held(command, ahead, j),
        };
        if span.ticks > 1 && !(0..nj).all(follows) {
            return false;
        }
        self.is_joined = span.ticks > 1;
        self.joints.clear();
        self.tracked.clear();
        for j in 0..nj {
            if !self.has_path(command, j) {
                self.paths[j] = None;
                self.commands[j].0 = f64::NEG_INFINITY;
                // Its command may have jumped.
                self.is_joined &= command.mode[j] == DriveMode::Passive;
                continue;
            }
            let is_smooth = span.is_smooth && continues(self, j) && !rests(command, ahead, j);
            let polynomial = is_smooth.then(|| divided_differences(&nodes(command, ahead, j, length)));
            let from = self.start(j, at, command, now - 0.5 * tick);
            if command.mode[j] == DriveMode::Kinematic {
                self.joints.push(j)
            } else {
                self.tracked.push(j)
            }
            let path = JointPath { span: (now, span.end), from, to: motion(&ahead[2], j), polynomial };
            let before = self.paths[j].replace(path).map(|path| path.at(now, now - 0.5 * tick));
            let after = path.at(now, now + 0.5 * tick);
            let fastest = ahead.iter().map(|a| a.velocity[j].abs()).fold(after.qd.abs(), f64::max);
            self.is_joined &= before.is_some_and(|b| (after.qdd - b.qdd).abs() * length <= JOINED * fastest);
            self.commands[j] = (span.end - tick, motion(if span.ticks > 1 { &ahead[6] } else { command }, j));
        }
        self.end = span.end;
        true
    }

    /// Where the path of a joint begins; `before`: a time within the present one.
    fn start(&self, j: usize, (model, state): (&Model, &State), command: &Command, before: f64) -> JointMotion {
        let before = self.paths[j].map(|p| p.at(state.time, before));
        if command.mode[j] == DriveMode::Kinematic {
            // The path continues; a velocity-level step leaves the mean velocity in the state.
            let here = JointMotion { q: state.joints[j], qd: state.v[model.nb() + j], qdd: 0.0 };
            before.filter(|m| m.q == here.q).unwrap_or(here)
        } else {
            before.unwrap_or(JointMotion { q: command.position[j], qd: command.velocity[j], qdd: 0.0 })
        }
    }

    fn has_path(&self, command: &Command, j: usize) -> bool {
        matches!(command.mode[j], DriveMode::Kinematic)
            || (self.interpolation != Interpolation::Hold && matches!(command.mode[j], DriveMode::Position))
    }

    /// An instant after `t` at which accelerations of paths jump, s.
    pub fn corner(&self, t: f64) -> Option<f64> {
        (self.are_any() && self.end > t).then_some(self.end)
    }

    /// Do the paths from `t` on continue those before with their accelerations?
    pub fn are_joined(&self, t: f64) -> bool {
        self.is_joined && self.end > t
    }

    /// Do accelerations of paths jump at `t`?
    pub fn ends(&self, t: f64) -> bool {
        self.are_any() && self.end == t
    }

    fn are_any(&self) -> bool {
        !self.joints.is_empty() || !self.tracked.is_empty()
    }

    /// The motion of a joint along its path; `within` as for forces.
    pub fn at(&self, joint: usize, t: f64, within: f64) -> JointMotion {
        self.paths[joint].as_ref().map_or(JointMotion::default(), |p| p.at(t, within))
    }
}

/// Positions of a joint at the nodes, and velocities there times the length of the span.
fn nodes(command: &Command, ahead: &[Command; 7], j: usize, length: f64) -> [(f64, f64); 4] {
    [command, &ahead[0], &ahead[1], &ahead[2]].map(|at| (at.position[j], length * at.velocity[j]))
}

/// Does the command of a joint without a path stay as it is? Efforts and gains do.
fn is_held(command: &Command, ahead: &[Command; 7], j: usize) -> bool {
    match command.mode[j] {
        DriveMode::Passive | DriveMode::Force => true,
        DriveMode::Velocity => ahead.iter().all(|at| at.velocity[j] == command.velocity[j]),
        DriveMode::Position | DriveMode::Kinematic => rests(command, ahead, j),
    }
}

/// Is the command of a joint a position at which it stays?
fn rests(command: &Command, ahead: &[Command; 7], j: usize) -> bool {
    let is_same = |at: &Command| at.position[j] == command.position[j] && at.velocity[j] == command.velocity[j];
    command.velocity[j] == 0.0 && ahead.iter().all(is_same)
}

/// Does the polynomial of a joint agree with its commands?
fn agrees(command: &Command, ahead: &[Command; 7], j: usize, length: f64) -> bool {
    let nodes = nodes(command, ahead, j, length);
    let c = divided_differences(&nodes);
    let change = nodes.iter().map(|(q, _)| (q - nodes[0].0).abs()).fold(0.0, f64::max);
    let fastest = nodes.iter().map(|(_, qd)| qd.abs()).fold(0.0, f64::max);
    let rounding = ROUNDING * (1.0 + nodes[0].0.abs() + change);
    INSTANTS.iter().zip(ahead).skip(3).all(|(s, at)| {
        let (q, qd, _) = evaluate(&c, *s);
        (q - at.position[j]).abs() <= ACCURATE.0 * change + rounding
            && (qd - length * at.velocity[j]).abs() <= ACCURATE.1 * fastest + 16.0 * rounding
    })
}

/// Extrapolates command `a` and, `before` seconds later, command `b` by `ahead` seconds.
fn extrapolate(a: &JointMotion, b: &JointMotion, before: f64, ahead: f64) -> JointMotion {
    let bend = b.q - a.q - before * 0.5 * (a.qd + b.qd);
    let change = (b.qd - a.qd).abs().max(a.qdd.abs() * before);
    if bend.abs() > SMOOTH * before * change {
        return JointMotion { q: b.q + b.qd * ahead, ..*b };
    }
    // The cubic about b: acceleration and jerk follow from the velocities and the bend.
    let jerk = -12.0 * bend / math::powi(before, 3);
    let acceleration = (b.qd - a.qd) / before + 0.5 * jerk * before;
    JointMotion {
        q: b.q + ahead * (b.qd + ahead * (0.5 * acceleration + ahead * jerk / 6.0)),
        qd: b.qd + ahead * (acceleration + 0.5 * ahead * jerk),
        qdd: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::parse;

    #[test]
    fn path_is_the_cubic_of_its_ends() {
        // q = 1 + 2 t - 3 t^2 + 4 t^3 from t = 0.5 to 0.7.
        let truth = |t: f64| JointMotion {
            q: 1.0 + t * (2.0 + t * (-3.0 + 4.0 * t)),
            qd: 2.0 + t * (-6.0 + 12.0 * t),
            qdd: -6.0 + 24.0 * t,
        };
        let path = JointPath { span: (0.5, 0.7), from: truth(0.5), to: truth(0.7), polynomial: None };
        for t in [0.5, 0.53, 0.61, 0.7] {
            let (m, x) = (path.at(t, 0.6), truth(t));
            // Rounding of q (about 2) over T^2 in the acceleration.
            assert!((m.q - x.q).abs() < 1e-15 * 4.0 && (m.qd - x.qd).abs() < 1e-13, "{m:?} {x:?}");
            assert!((m.qdd - x.qdd).abs() < 1e-12, "{m:?} {x:?}");
        }
        // Beyond its end: constant velocity, no acceleration.
        assert_eq!(path.at(0.7, 0.71), JointMotion { qdd: 0.0, ..truth(0.7) });
    }

    #[test]
    fn polynomial_of_degree_7_is_met_with_its_derivatives() {
        // About the middle of a span of 0.1 s from 0.3 s on: x = 20 (t - 0.35), in [-1, 1].
        let truth = |t: f64| {
            let x = 20.0 * (t - 0.35);
            let (mut p, mut p1, mut p2) = (0.0, 0.0, 0.0);
            for c in [0.7, -0.4, 0.9, 0.3, -0.8, 0.5, 0.2, 1.1] {
                (p2, p1, p) = (p2 * x + 2.0 * p1, p1 * x + p, p * x + c);
            }
            JointMotion { q: p, qd: 20.0 * p1, qdd: 400.0 * p2 }
        };
        let span = (0.3, 0.4);
        let at = |s: f64| truth(span.0 + s * 0.1);
        let differences = divided_differences(&NODES.map(|s| (at(s).q, 0.1 * at(s).qd)));
        let path = JointPath { span, from: at(0.0), to: at(1.0), polynomial: Some(differences) };
        for s in [0.0, 0.05, 1.0 / 3.0, 0.5, 0.8, 1.0] {
            let (m, x) = (path.at(span.0 + s * 0.1, 0.35), at(s));
            // Divided differences amplify rounding by some 3^7; derivatives are per 0.1 s.
            assert!((m.q - x.q).abs() < 1e-13 && (m.qd - x.qd).abs() < 1e-11, "{m:?} {x:?}");
            assert!((m.qdd - x.qdd).abs() < 2e-9, "{m:?} {x:?}");
        }
    }

    #[test]
    fn spans_are_joined_where_accelerations_continue() {
        let link = |name: &str| {
            format!(
                "<link name=\"{name}\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" \
                 ixz=\"0\" iyz=\"0\"/></inertial></link>"
            )
        };
        let text = format!(
            "<robot name=\"r\">{}{}<joint name=\"j\" type=\"continuous\"><parent link=\"a\"/><child link=\"b\"/>\
             <axis xyz=\"0 0 1\"/></joint></robot>",
            link("a"),
            link("b")
        );
        let model = parse("r.urdf".as_ref(), text, None).unwrap().model;
        let hold = Command { mode: vec![DriveMode::Position], ..Command::hold(&model, &[0.0]) };
        // A motion with another acceleration from 0.02 s on, rad/s^2.
        let at = |t: f64, jump: f64| {
            let after = (t - 0.02).max(0.0);
            let q = math::sin(3.0 * t) + 0.5 * jump * after * after;
            Command { position: vec![q], velocity: vec![3.0 * math::cos(3.0 * t) + jump * after], ..hold.clone() }
        };
        for (jump, joined) in [(0.0, true), (1e-5, true), (1e-3, false), (-50.0, false)] {
            let mut paths = KinematicPaths::new(1, Interpolation::Continuous);
            let mut state = State::home(&model);
            for (begin, is_joined) in [(0.0, false), (0.02, joined), (0.04, true)] {
                state.time = begin;
                let span = Span { end: begin + 0.02, ticks: 20, is_smooth: true };
                let instant = |k: usize| begin + INSTANTS.get(k).map_or(0.019, |s| 0.02 * s);
                let ahead = array::from_fn(|k| at(instant(k), jump));
                assert!(paths.plan_ahead((&model, &state), &at(begin, jump), &span, &ahead), "{jump} {begin}");
                assert_eq!(paths.are_joined(begin), is_joined, "{jump} {begin}");
            }
            // The last one ends.
            assert!(!paths.are_joined(0.06));
        }
    }

    #[test]
    fn two_smooth_commands_extrapolate_the_cubic_through_both() {
        let truth = |t: f64| JointMotion {
            q: 1.0 + t * (2.0 + t * (-3.0 + 4.0 * t)),
            qd: 2.0 + t * (-6.0 + 12.0 * t),
            qdd: 0.0,
        };
        let (a, b) = (truth(0.5), truth(0.51));
        let (found, x) = (extrapolate(&a, &b, 0.01, 0.01), truth(0.52));
        // The bend has an error of 1e-16 relative to 1, amplified by 5 (q) and 1200 (qd).
        assert!((found.q - x.q).abs() < 1e-14 && (found.qd - x.qd).abs() < 1e-12, "{found:?} {x:?}");
        // A jump of the position alone is no smooth motion: the last command holds.
        let jumped = JointMotion { q: 3.0, qd: 0.0, qdd: 0.0 };
        assert_eq!(extrapolate(&JointMotion { q: 1.0, ..jumped }, &jumped, 0.01, 0.01), jumped);
        // Neither is the start of a ramp.
        let (rest, ramp) = (JointMotion::default(), JointMotion { q: 0.0, qd: 2.0, qdd: 0.0 });
        assert_eq!(extrapolate(&rest, &ramp, 0.01, 0.01), JointMotion { q: 0.02, ..ramp });
        // An inflection is smooth: t^3 from -0.004 to 0.006 hardly changes its velocity.
        let inflects = |t: f64| JointMotion { q: t * t * t, qd: 3.0 * t * t, qdd: 6.0 * (t - 0.005) };
        let (found, x) = (extrapolate(&inflects(-0.004), &inflects(0.006), 0.01, 0.01), inflects(0.016));
        assert!((found.q - x.q).abs() < 1e-17 && (found.qd - x.qd).abs() < 1e-15, "{found:?} {x:?}");
    }
}
