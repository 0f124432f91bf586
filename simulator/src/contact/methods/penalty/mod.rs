//! The penalty method: springs and dampers in place of a rigid floor, with regularised friction.
//!
//! At every vertex, with delta = -height its depth and u its velocity (u_n along the normal, u_t
//! along the floor):
//!
//! ```text
//! N = max(0, k delta - c u_n)  where delta > 0, else 0        t = -mu_k N u_t / sqrt(|u_t|^2 + s^2)
//! ```
//!
//! The normal force is that of Kelvin and Voigt, clipped where it would pull. It is linear while a
//! vertex pushes, so depth and oscillation have closed forms and `damping` has the unit of a
//! damper. ([Hunt 1975] lets the damping grow with the depth, which removes the jump `-c u_n` at
//! touch-down, but damps a robot that rests deeper more.) The friction is Coulomb's with a slope at
//! zero speed, smooth everywhere. It is sliding friction with mu_k, and no vertex sticks: under a
//! tangential load of r mu_k N it creeps at `s r / sqrt(1 - r^2)`.
//!
//! The springs store `k delta^2 / 2`. The rest of the energy that the floor absorbs from the normal
//! motion, `(N - k delta) (-u_n) >= 0`, is lost: c u_n^2 while it pushes, and the remaining energy
//! of the spring when contact ends.
//!
//! The set of vertices in the floor is held while a step is integrated, so that its equations are
//! smooth; entering or leaving the floor is an event. Fixed steps at the velocity level are
//! implicit, see `step.rs`.

mod step;

use crate::contact::methods::contact_method::{ContactSolver, Scheme, SelectionInput, StoredEnergy, VertexSlopes};
use crate::contact::methods::registry::MethodDescriptor;
use crate::contact::model::problem::{Problem, Vertex};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{Pattern, SoleState, States};
use crate::contact::search::select::Selection;
use crate::math;
use crate::text::quantity::{json, non_negative, positive};
use nalgebra::{Matrix2, Vector2, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use step::Step;

/// Descriptor for scenarios and reports.
pub const DESCRIPTOR: MethodDescriptor = MethodDescriptor {
    name: "penalty",
    doc: "Springs and dampers under every vertex, regularised friction.",
    only_semi_implicit: None,
    restitution: false,
    unforced: Some("clamps no vertices"),
    momentless: Some("gives vertices forces alone"),
    colour: "#00795A",
    is_configured: |parameters| parameters.penalty != PenaltyParameters::default(),
    unknowns: None,
    solver: |parameters, p| Box::new(Penalty::new(p, parameters.penalty)),
};

/// Parameters of method `penalty`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PenaltyParameters {
    /// Stiffness of the floor under each vertex, N/m.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub stiffness: f64,
    /// Damping of the floor under each vertex, N s/m.
    #[serde(deserialize_with = "non_negative")]
    #[schemars(with = "json::NonNegative")]
    pub damping: f64,
    /// Speed below which friction is less than its full size, m/s.
    #[serde(deserialize_with = "positive")]
    #[schemars(with = "json::Positive")]
    pub slip_velocity: f64,
}

impl Default for PenaltyParameters {
    /// Values for robots of some kg, see `docs/contact.md` section 11.
    fn default() -> Self {
        PenaltyParameters { stiffness: 1e5, damping: 300.0, slip_velocity: 1e-3 }
    }
}

impl PenaltyParameters {
    /// Normal force on a vertex in the floor, N.
    fn normal(&self, v: &Vertex) -> f64 {
        (-self.stiffness * v.height - self.damping * v.velocity.z).max(0.0)
    }

    /// Regularised direction of a slip: a unit vector, shorter where the slip is slow.
    fn slip(&self, velocity: &Vector2<f64>) -> Vector2<f64> {
        velocity / math::hypot(velocity.norm(), self.slip_velocity)
    }

    /// Derivative of that direction by the velocity.
    fn turn(&self, velocity: &Vector2<f64>) -> Matrix2<f64> {
        let slip = self.slip(velocity);
        (Matrix2::identity() - slip * slip.transpose()) / math::hypot(velocity.norm(), self.slip_velocity)
    }

    /// Slopes of the force on a vertex in the floor. The normal force has none where it is clipped.
    fn slopes(&self, v: &Vertex) -> VertexSlopes {
        let normal = self.normal(v);
        let mut slopes = VertexSlopes::default();
        if v.height < 0.0 {
            slopes.power = [self.stiffness * v.velocity.z, self.stiffness * v.height];
        }
        if normal > 0.0 {
            let slip = v.velocity.xy();
            // Forces per newton of normal force.
            let per_load = self.slip(&slip) * -v.slip_mu();
            let per_load = Vector3::new(per_load.x, per_load.y, 1.0);
            slopes.by_height = per_load * -self.stiffness;
            slopes.by_velocity.set_column(2, &(per_load * -self.damping));
            slopes.by_velocity.fixed_view_mut::<2, 2>(0, 0).copy_from(&(self.turn(&slip) * (-v.slip_mu() * normal)));
            if v.viscous != 0.0 {
                let direction = slip.try_normalize(0.0).unwrap_or_default();
                let growth = self.slip(&slip) * direction.transpose() * (v.viscous * normal);
                let mut tangential = slopes.by_velocity.fixed_view_mut::<2, 2>(0, 0);
                tangential -= growth;
            }
        }
        slopes
    }
}

/// Solver of the method.
#[derive(Clone)]
pub struct Penalty {
    law: PenaltyParameters,
    /// Which vertices are in the floor, all soles in a row.
    inside: Vec<bool>,
    step: Step,
}

impl Penalty {
    /// For problems of this size.
    pub fn new(p: &Problem, law: PenaltyParameters) -> Self {
        let k = p.soles.iter().map(|s| s.vertices.len()).sum();
        Penalty { law, inside: vec![false; k], step: Step::new(p, law) }
    }

    /// The pattern of the loaded vertices, sticking while all of them slip slower than the slip
    /// velocity.
    fn states(&self, p: &Problem, out: &Solution, slip: impl Fn(usize, usize) -> Vector2<f64>) -> States {
        let mut states = States::default();
        for (s, sole) in p.soles.iter().enumerate() {
            let carries = |i: &usize| out.normal[s][*i] > 0.0;
            let pattern = Pattern::covering(sole.vertices.len(), |i| carries(&i));
            let fastest = (0..sole.vertices.len()).filter(carries).map(|i| slip(s, i).norm()).fold(0.0, f64::max);
            let sticks = pattern == Pattern::Free || fastest < self.law.slip_velocity;
            states[s] = if sticks { SoleState::fixed(pattern) } else { SoleState::sliding(pattern) };
        }
        states
    }
}

/// Half the width of the floor's surface, m: within it a vertex is in the floor if it moves down.
/// It is far above the rounding of heights; the springs give 1e-7 N there.
pub const SURFACE: f64 = 1e-12;

/// Is a vertex in the floor?
pub fn is_inside(v: &Vertex) -> bool {
    v.height < -SURFACE || v.height <= SURFACE && v.velocity.z < 0.0
}

impl ContactSolver for Penalty {
    fn copy(&self) -> Option<Box<dyn ContactSolver>> {
        Some(Box::new(self.clone()))
    }

    fn scheme(&self) -> Scheme {
        Scheme::Compliant
    }

    fn select(&mut self, p: &mut Problem, input: &SelectionInput, out: &mut Solution) -> Selection {
        let vertices = p.soles.iter().flat_map(|s| &s.vertices);
        self.inside.iter_mut().zip(vertices).for_each(|(inside, v)| *inside = is_inside(v));
        self.respond(p, &input.rules.previous, out);
        Selection::unchecked(self.states(p, out, |s, i| p.soles[s].vertices[i].velocity.xy()))
    }

    /// Impulses of a step; zero without a step, as velocities do not jump.
    fn impulse(&mut self, p: &mut Problem, _: &SelectionInput, out: &mut Solution) -> Selection {
        let dt = p.step;
        self.step.solve(p, dt, out);
        out.gather_vertex_forces(p);
        let mut inside = self.inside.iter_mut();
        for (s, sole) in p.soles.iter().enumerate() {
            for (i, v) in sole.vertices.iter().enumerate() {
                let after = v.height + dt * p.vertex_motion(&out.motion, s, i).z;
                inside.next().into_iter().for_each(|x| *x = after < 0.0);
            }
        }
        Selection::unchecked(self.states(p, out, |s, i| p.vertex_motion(&out.motion, s, i).xy()))
    }

    fn respond(&mut self, p: &Problem, _: &States, out: &mut Solution) {
        let mut inside = self.inside.iter();
        for (s, sole) in p.soles.iter().enumerate() {
            for (i, v) in sole.vertices.iter().enumerate() {
                let n = if inside.next() == Some(&true) { self.law.normal(v) } else { 0.0 };
                out.normal[s][i] = n;
                out.tangent[s][i] = self.law.slip(&v.velocity.xy()) * (-v.slip_mu() * n);
            }
        }
        out.gather_vertex_forces(p);
    }

    fn stored(&self, p: &Problem) -> StoredEnergy {
        let mut stored = StoredEnergy::default();
        let vertices = p.soles.iter().flat_map(|s| &s.vertices);
        for (v, inside) in vertices.zip(&self.inside).filter(|(v, _)| v.height < 0.0) {
            stored.energy += 0.5 * self.law.stiffness * v.height * v.height;
            // Stages of a step that ends at a touch-down may be below it; the forces there are zero, too.
            if *inside {
                stored.power += self.law.stiffness * v.height * v.velocity.z;
            }
        }
        stored
    }

    fn slopes(&self, p: &Problem, each: &mut dyn FnMut(usize, usize, VertexSlopes)) {
        for ((s, i), _) in p.vertex_indices().zip(&self.inside).filter(|(_, inside)| **inside) {
            each(s, i, self.law.slopes(&p.soles[s].vertices[i]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_difference_quotients_of_the_forces() {
        let law = PenaltyParameters::default();
        let mut p = Problem::new(&[1]);
        let v = &mut p.soles[0].vertices[0];
        (v.height, v.mu_k, v.velocity) = (-1e-4, 0.6, Vector3::new(4e-4, -7e-4, 2e-3));
        let mut penalty = Penalty::new(&p, law);
        penalty.inside[0] = true;
        let mut out = Solution::new(&p);
        let mut evaluate = |p: &Problem| {
            penalty.respond(p, &States::default(), &mut out);
            let (t, power) = (out.tangent[0][0], penalty.stored(p).power);
            (Vector3::new(t.x, t.y, out.normal[0][0]), power)
        };
        let vertex = p.soles[0].vertices[0];
        let slopes = law.slopes(&vertex);
        // Central differences: truncation of second order, 1e-6 of the scale of each argument.
        let mut quotient = |d: f64, change: &dyn Fn(&mut Vertex, f64)| {
            let [(above, power_above), (below, power_below)] = [d, -d].map(|d| {
                p.soles[0].vertices[0] = vertex;
                change(&mut p.soles[0].vertices[0], d);
                evaluate(&p)
            });
            ((above - below) / (2.0 * d), (power_above - power_below) / (2.0 * d))
        };
        let close = |a: Vector3<f64>, b: Vector3<f64>| (a - b).norm() < 1e-5 * b.norm();
        let (by_height, power) = quotient(1e-7, &|v, d| v.height += d);
        assert!(close(by_height, slopes.by_height), "{by_height} {}", slopes.by_height);
        assert!((power - slopes.power[0]).abs() < 1e-5 * power.abs());
        for k in 0..3 {
            let (by_velocity, power) = quotient(1e-6, &|v, d| v.velocity[k] += d);
            assert!(close(by_velocity, slopes.by_velocity.column(k).into()), "{k} {by_velocity}");
            let expected = if k == 2 { slopes.power[1] } else { 0.0 };
            assert!((power - expected).abs() <= 1e-5 * expected.abs(), "{k} {power}");
        }
    }
}
