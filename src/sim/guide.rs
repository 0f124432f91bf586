//! Motions of kinematic joints: prescribed from one control tick to the next.
//!
//! ```text
//! q(t0 + s T) = q0 + (q1 - q0) (3 s^2 - 2 s^3) + T qd0 s (1 - s)^2 - T qd1 s^2 (1 - s)
//! ```
//!
//! the cubic of a tick of length T from the present position and velocity (q0, qd0) to those that the commands foretell
//! for the next tick (q1, qd1). What they foretell: two commands a and b in a row that belong to one smooth motion,
//! `|dq - T (qd_a + qd_b) / 2| <= T |dqd| / 5` with dqd the change of velocity between them or that before, if greater, are
//! continued by the cubic through both; else the last one by its own velocity, `(q_des + T qd_des, qd_des)`. If no tick
//! follows the joint goes to its command and rests there.
//!
//! So position and velocity are continuous, commands that are polynomials of third degree in time are met exactly from
//! the third tick on, others with an error of order T^4, and a command that jumps is caught up within one tick.

use crate::dynamics::State;
use crate::robot::{DriveMode, Model};
use crate::task::Command;

/// How far two commands may be from one smooth motion, relative to the way that the change of velocity makes in a tick. At
/// an inflection the deviation is 1/12 of the change that the jerk j makes, j T, and the greater of two changes in a row
/// at least half of that.
const SMOOTH: f64 = 0.2;

/// Position, velocity and acceleration of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Motion {
    pub q: f64,
    pub qd: f64,
    pub qdd: f64,
}

/// The way of one joint between two instants.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Path {
    /// From, to, s.
    span: (f64, f64),
    from: Motion,
    to: Motion,
}

impl Path {
    /// The motion at time `t`; `within` tells which side of the path's end it belongs to.
    fn at(&self, t: f64, within: f64) -> Motion {
        let (begin, end) = self.span;
        if within >= end {
            return Motion { q: self.to.q + self.to.qd * (t - end), qd: self.to.qd, qdd: 0.0 };
        }
        let (length, way) = (end - begin, self.to.q - self.from.q);
        let s = ((t - begin) / length).clamp(0.0, 1.0);
        let (v0, v1, mean) = (self.from.qd, self.to.qd, way / length);
        let r = 1.0 - s;
        Motion {
            q: if s == 1.0 {
                self.to.q
            } else {
                self.from.q + way * s * s * (3.0 - 2.0 * s) + length * s * r * (v0 * r - v1 * s)
            },
            qd: mean * 6.0 * s * r + v0 * r * (1.0 - 3.0 * s) + v1 * s * (3.0 * s - 2.0),
            qdd: (mean * 6.0 * (1.0 - 2.0 * s) + v0 * (6.0 * s - 4.0) + v1 * (6.0 * s - 2.0)) / length,
        }
    }
}

/// The prescribed motions of one run.
#[derive(Clone, Debug, Default)]
pub(super) struct Guide {
    /// By joint; none for joints with dynamics.
    paths: Vec<Option<Path>>,
    /// The joints with a path.
    joints: Vec<usize>,
    /// The last command of each joint and its time; its acceleration is that since the command before.
    told: Vec<(f64, Motion)>,
    /// Where all paths end, s.
    end: f64,
}

impl Guide {
    /// For a robot of `nj` joints, none of them guided yet.
    pub fn new(nj: usize) -> Self {
        Guide {
            paths: vec![None; nj],
            joints: Vec::with_capacity(nj),
            told: vec![(f64::NEG_INFINITY, Motion::default()); nj],
            end: f64::NEG_INFINITY,
        }
    }

    /// The joints whose motion is prescribed, in ascending order.
    pub fn joints(&self) -> &[usize] {
        &self.joints
    }

    /// Takes up the command of a tick at the state's time, `period` seconds long; the next one comes at `next` if at all.
    pub fn plan(&mut self, model: &Model, command: &Command, state: &State, period: f64, next: Option<f64>) {
        let (now, nb) = (state.time, model.nb());
        let next = next.filter(|t| *t < now + 1.5 * period && *t > now);
        let end = next.unwrap_or(now + period);
        self.joints.clear();
        for j in 0..self.paths.len() {
            if command.mode[j] != DriveMode::Kinematic {
                self.paths[j] = None;
                self.told[j].0 = f64::NEG_INFINITY;
                continue;
            }
            self.joints.push(j);
            // A path goes on as it was; a velocity-level step has left its mean in the state.
            let before = self.paths[j].map(|p| p.at(now, now - 0.5 * period));
            let here = Motion { q: state.joints[j], qd: state.v[nb + j], qdd: 0.0 };
            let from = before.filter(|m| m.q == here.q).unwrap_or(here);
            let asked = Motion { q: command.position[j], qd: command.velocity[j], qdd: 0.0 };
            let (when, last) = std::mem::replace(&mut self.told[j], (now, asked));
            let follows = when > now - 1.5 * period && when < now;
            if follows {
                self.told[j].1.qdd = (asked.qd - last.qd) / (now - when);
            }
            let to = match next {
                None => Motion { qd: 0.0, ..asked },
                Some(_) if follows => foretell(&last, &asked, now - when, end - now),
                Some(_) => Motion { q: asked.q + asked.qd * (end - now), ..asked },
            };
            self.paths[j] = Some(Path { span: (now, end), from, to });
        }
        self.end = end;
    }

    /// An instant after `t` at which accelerations jump, s.
    pub fn corner(&self, t: f64) -> Option<f64> {
        (!self.joints.is_empty() && self.end > t).then_some(self.end)
    }

    /// Do prescribed accelerations jump at `t`?
    pub fn ends(&self, t: f64) -> bool {
        !self.joints.is_empty() && self.end == t
    }

    /// The prescribed motion of a joint that has one; `within` as for forces.
    pub fn at(&self, joint: usize, t: f64, within: f64) -> Motion {
        self.paths[joint].map_or(Motion::default(), |p| p.at(t, within))
    }
}

/// What commands `a` and, `before` seconds later, `b` foretell for `ahead` seconds after that.
fn foretell(a: &Motion, b: &Motion, before: f64, ahead: f64) -> Motion {
    let bend = b.q - a.q - before * 0.5 * (a.qd + b.qd);
    let change = (b.qd - a.qd).abs().max(a.qdd.abs() * before);
    if bend.abs() > SMOOTH * before * change {
        return Motion { q: b.q + b.qd * ahead, ..*b };
    }
    // The cubic about b: acceleration and jerk from what the velocities and the bend say.
    let jerk = -12.0 * bend / before.powi(3);
    let acceleration = (b.qd - a.qd) / before + 0.5 * jerk * before;
    Motion {
        q: b.q + ahead * (b.qd + ahead * (0.5 * acceleration + ahead * jerk / 6.0)),
        qd: b.qd + ahead * (acceleration + 0.5 * ahead * jerk),
        qdd: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_the_cubic_of_its_ends() {
        // q = 1 + 2 t - 3 t^2 + 4 t^3 from t = 0.5 to 0.7.
        let truth = |t: f64| Motion {
            q: 1.0 + t * (2.0 + t * (-3.0 + 4.0 * t)),
            qd: 2.0 + t * (-6.0 + 12.0 * t),
            qdd: -6.0 + 24.0 * t,
        };
        let path = Path { span: (0.5, 0.7), from: truth(0.5), to: truth(0.7) };
        for t in [0.5, 0.53, 0.61, 0.7] {
            let (m, x) = (path.at(t, 0.6), truth(t));
            // Rounding of q (about 2) over T^2 in the acceleration.
            assert!((m.q - x.q).abs() < 1e-15 * 4.0 && (m.qd - x.qd).abs() < 1e-13, "{m:?} {x:?}");
            assert!((m.qdd - x.qdd).abs() < 1e-12, "{m:?} {x:?}");
        }
        // The other side of its end: at rest or on at its last velocity, without acceleration.
        assert_eq!(path.at(0.7, 0.71), Motion { qdd: 0.0, ..truth(0.7) });
    }

    #[test]
    fn two_commands_foretell_the_cubic_through_both() {
        let truth =
            |t: f64| Motion { q: 1.0 + t * (2.0 + t * (-3.0 + 4.0 * t)), qd: 2.0 + t * (-6.0 + 12.0 * t), qdd: 0.0 };
        let (a, b) = (truth(0.5), truth(0.51));
        let (found, x) = (foretell(&a, &b, 0.01, 0.01), truth(0.52));
        // The bend is known to 1e-16 of 1, and comes back five and twelve hundred times as large.
        assert!((found.q - x.q).abs() < 1e-14 && (found.qd - x.qd).abs() < 1e-12, "{found:?} {x:?}");
        // A jump of the position alone is no smooth motion: the last command counts as it is.
        let jumped = Motion { q: 3.0, qd: 0.0, qdd: 0.0 };
        assert_eq!(foretell(&Motion { q: 1.0, ..jumped }, &jumped, 0.01, 0.01), jumped);
        // Nor is the start of a ramp.
        let (rest, ramp) = (Motion::default(), Motion { q: 0.0, qd: 2.0, qdd: 0.0 });
        assert_eq!(foretell(&rest, &ramp, 0.01, 0.01), Motion { q: 0.02, ..ramp });
        // An inflection is: t^3 from -0.004 to 0.006 changes its velocity by hardly anything.
        let inflects = |t: f64| Motion { q: t * t * t, qd: 3.0 * t * t, qdd: 6.0 * (t - 0.005) };
        let (found, x) = (foretell(&inflects(-0.004), &inflects(0.006), 0.01, 0.01), inflects(0.016));
        assert!((found.q - x.q).abs() < 1e-17 && (found.qd - x.qd).abs() < 1e-15, "{found:?} {x:?}");
    }
}
