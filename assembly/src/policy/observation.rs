//! Terms of an observation.
//!
//! ```text
//! y = max(-c, min(c, s x + o))
//! ```
//!
//! with the quantity x, scale s, offset o and greatest magnitude c, in double precision. The
//! network receives y rounded to the nearest number of single precision (ties to even).

use crate::math;
use crate::task::{Context, Needs};
use nalgebra::Vector3;

/// A quantity that a network observes.
#[derive(Clone, Debug, PartialEq)]
pub enum Quantity {
    /// Velocity of the base's origin, base axes, m/s.
    LinearVelocity,
    /// Angular velocity of the base, base axes, rad/s.
    AngularVelocity,
    /// Direction of gravity, base axes; zero without gravity.
    Gravity,
    /// Orientation of the base, w, x, y, z with w at least 0.
    Orientation,
    /// Height of the base's origin above the floor plane, m.
    Height,
    /// Given numbers from the first index on, so many.
    Command(usize, usize),
    /// Positions of joints less the second numbers, rad or m.
    JointPositions(Vec<(usize, f64)>),
    /// Velocities of joints, rad/s or m/s.
    JointVelocities(Vec<usize>),
    /// The last output, of so many numbers.
    PreviousAction(usize),
    /// Force on each of these soles, base axes, N.
    SoleForces(Vec<usize>),
    /// 1 for each of these soles with at least this normal force, N, else 0.
    Contacts(Vec<usize>, f64),
    /// Sine of `2 pi t / period + phase`: period, s, and phase, rad.
    Sine(f64, f64),
    /// Cosine of the same.
    Cosine(f64, f64),
}

impl Quantity {
    /// Number of numbers.
    pub fn width(&self) -> usize {
        match self {
            Quantity::LinearVelocity | Quantity::AngularVelocity | Quantity::Gravity => 3,
            Quantity::Orientation => 4,
            Quantity::Height | Quantity::Sine(..) | Quantity::Cosine(..) => 1,
            Quantity::Command(_, count) | Quantity::PreviousAction(count) => *count,
            Quantity::JointPositions(joints) => joints.len(),
            Quantity::JointVelocities(joints) => joints.len(),
            Quantity::SoleForces(soles) => 3 * soles.len(),
            Quantity::Contacts(soles, _) => soles.len(),
        }
    }

    /// Parts of the augmented data that it reads.
    pub fn needs(&self) -> Needs {
        match self {
            Quantity::SoleForces(_) | Quantity::Contacts(..) => Needs::LOADS,
            _ => Needs::NONE,
        }
    }

    /// Passes its numbers in order to `put`.
    fn read(&self, now: &Observed, mut put: impl FnMut(f64)) {
        let context = now.context;
        let state = context.state;
        let to_base = |v: Vector3<f64>| state.rotation.inverse_transform_vector(&v);
        let floating = context.model.nb() == 6;
        let velocity = |from: usize| match floating {
            true => to_base(Vector3::new(state.v[from], state.v[from + 1], state.v[from + 2])),
            false => Vector3::zeros(),
        };
        let angle = |period: f64, phase: f64| std::f64::consts::TAU * (now.since / period) + phase;
        match self {
            Quantity::LinearVelocity => velocity(0).iter().for_each(|x| put(*x)),
            Quantity::AngularVelocity => velocity(3).iter().for_each(|x| put(*x)),
            Quantity::Gravity => {
                let down = context.gravity.try_normalize(0.0).unwrap_or_default();
                to_base(down).iter().for_each(|x| put(*x));
            }
            Quantity::Orientation => {
                let q = state.rotation.quaternion();
                let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
                [q.w, q.i, q.j, q.k].into_iter().for_each(|x| put(sign * x));
            }
            Quantity::Height => put(context.floor.height(&state.position)),
            Quantity::Command(from, count) => now.command[*from..from + count].iter().for_each(|x| put(*x)),
            Quantity::JointPositions(joints) => joints.iter().for_each(|(j, zero)| put(state.joints[*j] - zero)),
            Quantity::JointVelocities(joints) => joints.iter().for_each(|j| put(state.rates()[*j])),
            Quantity::PreviousAction(_) => now.previous.iter().for_each(|x| put(f64::from(*x))),
            Quantity::SoleForces(soles) => {
                let forces = soles.iter().map(|s| to_base(context.sensed.soles[*s].force));
                forces.for_each(|force| force.iter().for_each(|x| put(*x)));
            }
            Quantity::Contacts(soles, threshold) => {
                let normal = |s: &usize| context.floor.to_plane(&context.sensed.soles[*s].force).z;
                soles.iter().for_each(|s| put(if normal(s) >= *threshold { 1.0 } else { 0.0 }));
            }
            Quantity::Sine(period, phase) => put(math::sin(angle(*period, *phase))),
            Quantity::Cosine(period, phase) => put(math::cos(angle(*period, *phase))),
        }
    }
}

/// What the quantities depend on.
pub(super) struct Observed<'a> {
    /// The robot.
    pub context: &'a Context<'a>,
    /// Time since the start of the task, s.
    pub since: f64,
    /// The given numbers.
    pub command: &'a [f64],
    /// The last output.
    pub previous: &'a [f32],
}

/// A term of an observation.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// The quantity.
    pub quantity: Quantity,
    /// Factors, one for each number.
    pub scale: Vec<f64>,
    /// Summands, one for each number.
    pub offset: Vec<f64>,
    /// Greatest magnitude.
    pub clip: f64,
}

impl Term {
    /// Writes its numbers.
    pub(super) fn write(&self, now: &Observed, to: &mut [f32]) {
        let mut i = 0;
        self.quantity.read(now, |x| {
            let y = self.scale[i] * x + self.offset[i];
            to[i] = y.clamp(-self.clip, self.clip) as f32;
            i += 1;
        });
    }
}
