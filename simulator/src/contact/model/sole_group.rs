//! Joint friction capacity of several static soles on one body.
//!
//! The split of a load over sticking soles of one rigid body is statically indeterminate. Whether
//! they hold is not: they can only slip together. The capacity of the group is that of a face
//! ([`crate::contact::model::friction_capacity::face`]) whose points are all clamped vertices. Some
//! split carries a tangential force F and yaw moment tau if and only if for every planar slip
//! twist (v, w) of the body `F . v + tau w <= sum mu_s N_i |v + w z x r_i|`.
//!
//! The normal forces are those of the least-norm solution (see [`crate::linalg::linear`]).

use crate::contact::model::friction_capacity;
use crate::contact::model::problem::Problem;
use crate::contact::model::solution::Solution;
use crate::contact::model::state::States;
use crate::contact::model::turning::moment;
use nalgebra::Vector2;
use smallvec::SmallVec;

/// Vertices of a group up to which nothing is allocated.
const INLINE: usize = 128;

/// Friction margin of the static soles of one body together.
#[derive(Clone, Copy, Debug)]
pub struct GroupMargin {
    /// Margin, N.
    pub margin: f64,
    /// Velocity of the floor's origin in the twist of least margin, against the friction carried,
    /// and yaw rate.
    linear: Vector2<f64>,
    turn: f64,
}

impl GroupMargin {
    /// The twist as slip of sole `s`: velocity of its reference point, and yaw rate times its
    /// radius.
    pub fn slip(&self, p: &Problem, s: usize) -> friction_capacity::Slip {
        let (r, radius) = (&p.soles[s].position, p.soles[s].radius);
        let v = self.linear + Vector2::new(-r.y, r.x) * self.turn;
        friction_capacity::Slip::new(v.x, v.y, self.turn * radius)
    }
}

/// The static soles on the body of sole `s`.
pub fn members<'a>(p: &'a Problem, states: &'a States, s: usize) -> impl Iterator<Item = usize> + 'a {
    (0..p.soles.len()).filter(move |&t| states[t].is_static() && p.soles[t].body == p.soles[s].body)
}

/// Whether the static sole `s` shares its body with other static soles.
pub fn is_shared(p: &Problem, states: &States, s: usize) -> bool {
    states[s].is_static() && members(p, states, s).nth(1).is_some()
}

/// Margin of the group of sole `s`. Needs the normal forces of the vertices.
pub fn group_margin(p: &Problem, states: &States, s: usize, solution: &Solution) -> GroupMargin {
    let mut points = SmallVec::<[(f64, Vector2<f64>); INLINE]>::new();
    let (mut force, mut yaw) = (Vector2::zeros(), 0.0);
    let mut middle = Vector2::zeros();
    for t in members(p, states, s) {
        let sole = &p.soles[t];
        let k = sole.vertices.len();
        let w = &solution.wrench[6 * t..6 * t + 6];
        let f = Vector2::new(w[0], w[1]);
        force += f;
        yaw += w[5] + sole.position.xy().perp(&f);
        if sole.turning().is_some() {
            yaw -= moment(p, t, solution).z;
        }
        for (i, v) in sole.vertices.iter().enumerate().filter(|(i, _)| states[t].clamps(*i, k)) {
            let position = sole.position.xy() + v.r.xy();
            points.push((v.stick_mu(p.level) * solution.normal[t][i].max(0.0), position));
            middle += position;
        }
    }
    // Moments about the mean of the points avoid cancellation far from the floor's origin.
    middle /= points.len() as f64;
    yaw -= middle.perp(&force);
    points.iter_mut().for_each(|(_, position)| *position -= middle);
    let radius = points.iter().map(|(_, r)| r.norm()).fold(0.0, f64::max);
    let (margin, slip) = friction_capacity::face(&points, &force, yaw, radius);
    let turn = -slip.z / radius;
    let linear = -slip.xy() - Vector2::new(-middle.y, middle.x) * turn;
    GroupMargin { margin, linear, turn }
}
