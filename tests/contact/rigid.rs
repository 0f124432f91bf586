//! One rigid body on a convex sole as a reduced contact problem: W and b from mass, inertia and
//! centre of mass; and its proptest strategy.

use nalgebra::{Matrix3, UnitQuaternion, Vector2, Vector3};
use proptest::prelude::*;
use stiction::contact::model::problem::{Level, Problem, Tolerances};
use stiction::contact::model::state::{Pattern, SoleState, States};
use stiction::contact::search::judge::Rules;

pub const G: f64 = 9.81;

/// A body above its sole, in floor axes. The sole's reference point is the mean of its vertices.
#[derive(Clone, Debug)]
pub struct Rigid {
    /// Vertices of the sole, in order.
    pub sole: Vec<Vector2<f64>>,
    /// Mass, kg.
    pub mass: f64,
    /// Inertia about the centre of mass.
    pub inertia: Matrix3<f64>,
    /// Centre of mass.
    pub com: Vector3<f64>,
    /// Friction coefficients, static and kinetic.
    pub mu: [f64; 2],
}

impl Rigid {
    /// Reference point of the sole.
    pub fn reference(&self) -> Vector3<f64> {
        let mean = self.sole.iter().sum::<Vector2<f64>>() / self.sole.len() as f64;
        Vector3::new(mean.x, mean.y, 0.0)
    }

    /// Motion of the reference point (linear, angular) for a wrench at the centre of mass.
    fn response(&self, force: &Vector3<f64>, moment: &Vector3<f64>) -> [f64; 6] {
        let angular = self.inertia.try_inverse().expect("a body") * moment;
        let linear = force / self.mass + angular.cross(&(self.reference() - self.com));
        [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
    }

    /// The problem at rest on the floor, with `b` the response to a load at the centre of mass.
    pub fn problem(&self, level: Level, force: &Vector3<f64>, moment: &Vector3<f64>) -> Problem {
        let mut p = Problem::new(&[self.sole.len()]);
        p.level = level;
        p.scale = self.mass * G;
        let reference = self.reference();
        for c in 0..6 {
            let mut w = [0.0; 6];
            w[c] = 1.0;
            let (f, m) = (Vector3::new(w[0], w[1], w[2]), Vector3::new(w[3], w[4], w[5]));
            let column = self.response(&f, &(m + (reference - self.com).cross(&f)));
            (0..6).for_each(|r| p.w[6 * r + c] = column[r]);
        }
        p.b.copy_from_slice(&self.response(force, moment));
        let sole = &mut p.soles[0];
        for (v, place) in sole.vertices.iter_mut().zip(&self.sole) {
            v.r = Vector3::new(place.x, place.y, 0.0) - reference;
            (v.mu_s, v.mu_k) = (self.mu[0], self.mu[1]);
            v.near = true;
        }
        let radius = sole.vertices.iter().map(|v| v.r.norm()).fold(0.0, f64::max);
        sole.radius = if radius > 0.0 { radius } else { 1.0 };
        p
    }

    /// Kinetic energy for a motion of the reference point.
    pub fn energy(&self, motion: &[f64]) -> f64 {
        let (linear, angular) =
            (Vector3::new(motion[0], motion[1], motion[2]), Vector3::new(motion[3], motion[4], motion[5]));
        let com = linear + angular.cross(&(self.com - self.reference()));
        0.5 * (self.mass * com.norm_squared() + angular.dot(&(self.inertia * angular)))
    }

    /// Motion of the reference point for a velocity of the centre of mass and an angular velocity.
    pub fn motion(&self, com: &Vector3<f64>, angular: &Vector3<f64>) -> [f64; 6] {
        let linear = com + angular.cross(&(self.reference() - self.com));
        [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
    }

    /// The same body with its vertices renumbered by `shift`.
    pub fn renumbered(&self, shift: usize) -> Rigid {
        let mut other = self.clone();
        other.sole.rotate_left(shift % self.sole.len());
        other
    }
}

/// Rules with tolerances too small to affect the choice of state.
pub fn rules() -> Rules {
    let tolerances = Tolerances { distance: 1e-8, velocity: 1e-8, acceleration: 1e-8, rest: 1e-10 };
    Rules::new(tolerances, States::default())
}

/// Three numbers in -1..1.
pub fn triple() -> impl Strategy<Value = Vector3<f64>> {
    [-1.0..1.0f64, -1.0..1.0, -1.0..1.0].prop_map(Vector3::from)
}

/// Bodies on soles with a number of vertices in this range: points on an ellipse at angles that are
/// never close, the centre of mass above it.
pub fn body_on(fewest: usize, most: usize) -> impl Strategy<Value = Rigid> {
    let sole = (fewest..=most).prop_flat_map(|k| {
        (proptest::collection::vec(0.1..0.9f64, k), 0.3..1.0f64, 0.0..6.3f64).prop_map(move |(at, flat, turn)| {
            let (s, c) = turn.sin_cos();
            let vertex = |(i, a): (usize, &f64)| {
                let angle = (i as f64 + a) * std::f64::consts::TAU / at.len() as f64;
                let (x, y) = (0.1 * angle.cos(), 0.1 * flat * angle.sin());
                Vector2::new(c * x - s * y, s * x + c * y)
            };
            at.iter().enumerate().map(vertex).collect::<Vec<_>>()
        })
    });
    let shape = ([0.05..0.2f64, 0.05..0.2, 0.05..0.2], triple());
    (sole, 0.2..20.0f64, shape, triple(), 0.02..0.15f64, (0.05..1.0f64, 0.3..1.0f64)).prop_map(
        |(sole, mass, (half, turn), side, height, (mu, share))| {
            // A box of these half lengths, rotated.
            let [a, b, c] = half.map(|x| x * x * mass / 3.0);
            let turn = UnitQuaternion::from_scaled_axis(turn * 3.0).to_rotation_matrix();
            let inertia = turn * Matrix3::from_diagonal(&Vector3::new(b + c, a + c, a + b)) * turn.transpose();
            let com = Vector3::new(0.06 * side.x, 0.06 * side.y, height);
            Rigid { sole, mass, inertia, com, mu: [mu, mu * share] }
        },
    )
}

/// The static state of all vertices of a sole.
pub fn stuck(k: usize) -> SoleState {
    SoleState::fixed(SoleState::patterns(k).last().unwrap_or(Pattern::Free))
}
