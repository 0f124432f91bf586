//! The penalty method: springs and dampers in place of a rigid floor, with regularised friction.
//!
//! Every vertex by itself, with delta = -height its depth and u its velocity (u_n along the normal, u_t along the floor):
//!
//! ```text
//! N = max(0, k delta - c u_n)  where delta > 0, else 0        t = -mu_k N u_t / sqrt(|u_t|^2 + s^2)
//! ```
//!
//! The normal force is that of Kelvin and Voigt, clipped where it would pull: it is linear while a vertex pushes, so depth
//! and oscillation have closed forms and `damping` has the unit of a damper. (Hunt and Crossley, *J. Appl. Mech.* 42,
//! 1975, let the damping grow with the depth, which takes away the jump `-c u_n` at touch-down, but then a robot that
//! rests deeper is damped more.) The friction is Coulomb's with a slope at zero speed, smooth everywhere; it is sliding
//! friction, so it takes mu_k, and nothing sticks: a load of the part r of mu_k N creeps at `s r / sqrt(1 - r^2)`.
//!
//! The springs hold `k delta^2 / 2`. What the floor takes out of the normal motion beside that,
//! `(N - k delta) (-u_n) >= 0`, is lost: c u_n^2 while it pushes, and what the spring gives back to nobody after it has
//! let go.
//!
//! Which vertices are in the floor is held while a step is integrated, so that its equations are smooth; where one enters
//! or leaves it is an event. Fixed steps at the velocity level are implicit: see [`step`].

mod step;

use crate::contact::methods::exact::covering;
use crate::contact::methods::method::{Manner, Method, Question, Stored};
use crate::contact::model::problem::{Problem, Vertex};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{Pattern, SoleState, States};
use crate::contact::search::candidate::wrench_at;
use crate::contact::search::judge::Verdict;
use crate::contact::search::select::Selection;
use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};
use step::Step;

/// What the springs are like.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PenaltyParameters {
    /// Stiffness k of each vertex, N/m.
    pub stiffness: f64,
    /// Damping c of each vertex, N s/m.
    pub damping: f64,
    /// Speed s below which friction has not its full size, m/s.
    pub slip_velocity: f64,
}

impl Default for PenaltyParameters {
    /// For robots of some kg: see `docs/contact.md` section 11.
    fn default() -> Self {
        PenaltyParameters { stiffness: 1e5, damping: 300.0, slip_velocity: 1e-3 }
    }
}

impl PenaltyParameters {
    /// Normal force on a vertex in the floor, N.
    fn normal(&self, v: &Vertex) -> f64 {
        (-self.stiffness * v.height - self.damping * v.velocity.z).max(0.0)
    }

    /// What the law makes of a slip: its direction, and less than that where it is slow.
    fn slip(&self, velocity: &Vector2<f64>) -> Vector2<f64> {
        velocity / velocity.norm().hypot(self.slip_velocity)
    }
}

/// See the module.
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

    /// The pattern of the vertices that carry something, sticking while all of those slip slower than the slip velocity.
    fn label(&self, p: &Problem, out: &Solution, slip: impl Fn(usize, usize) -> Vector2<f64>) -> States {
        let mut states = States::default();
        for (s, sole) in p.soles.iter().enumerate() {
            let carries = |i: &usize| out.normal[s][*i] > 0.0;
            let pattern = covering(sole.vertices.len(), |i| carries(&i));
            let fastest = (0..sole.vertices.len()).filter(carries).map(|i| slip(s, i).norm()).fold(0.0, f64::max);
            let sticks = pattern == Pattern::Free || fastest < self.law.slip_velocity;
            states[s] = if sticks { SoleState::fixed(pattern) } else { SoleState::sliding(pattern) };
        }
        states
    }
}

/// Half the width of the floor's surface, m: within it a vertex is in the floor if it goes down. Far above the rounding of
/// heights; the springs give 1e-7 N there.
pub const SURFACE: f64 = 1e-12;

/// Is a vertex in the floor?
pub fn is_inside(v: &Vertex) -> bool {
    v.height < -SURFACE || v.height <= SURFACE && v.velocity.z < 0.0
}

/// It tries no candidates and claims nothing: its errors show in the residuals.
fn labelled(states: States) -> Selection {
    let verdict = Verdict { levels: [0.0; 3], rank: [0; 5], action: 0.0, faults: Default::default() };
    Selection { states, tested: 0, consistent: true, verdict }
}

/// Fills wrenches and motions from the vertices' forces.
fn gather(p: &Problem, out: &mut Solution) {
    for (s, sole) in p.soles.iter().enumerate() {
        let wrench = &mut out.wrench[6 * s..6 * s + 6];
        wrench.fill(0.0);
        for ((v, n), t) in sole.vertices.iter().zip(&out.normal[s]).zip(&out.tangent[s]) {
            let one = wrench_at(&v.r, &Vector3::new(t.x, t.y, *n));
            wrench.iter_mut().zip(one).for_each(|(a, b)| *a += b);
        }
    }
    let n = p.dim();
    for (i, m) in out.motion.iter_mut().enumerate() {
        *m = p.b[i] + p.w[i * n..(i + 1) * n].iter().zip(&out.wrench).map(|(w, f)| w * f).sum::<f64>();
    }
}

impl Method for Penalty {
    fn manner(&self) -> Manner {
        Manner::Compliant
    }

    fn select(&mut self, p: &mut Problem, question: &Question, out: &mut Solution) -> Selection {
        let vertices = p.soles.iter().flat_map(|s| &s.vertices);
        self.inside.iter_mut().zip(vertices).for_each(|(inside, v)| *inside = is_inside(v));
        self.respond(p, &question.rules.previous, out);
        labelled(self.label(p, out, |s, i| p.soles[s].vertices[i].velocity.xy()))
    }

    /// Impulses of a step. Without a step there are none: nothing jumps.
    fn impulse(&mut self, p: &mut Problem, _: &Question, out: &mut Solution) -> Selection {
        let dt = p.step;
        self.step.solve(p, dt, out);
        gather(p, out);
        let mut inside = self.inside.iter_mut();
        for (s, sole) in p.soles.iter().enumerate() {
            for (i, v) in sole.vertices.iter().enumerate() {
                let after = v.height + dt * p.vertex_motion(&out.motion, s, i).z;
                inside.next().into_iter().for_each(|x| *x = after < 0.0);
            }
        }
        labelled(self.label(p, out, |s, i| p.vertex_motion(&out.motion, s, i).xy()))
    }

    fn respond(&mut self, p: &Problem, _: &States, out: &mut Solution) {
        let mut inside = self.inside.iter();
        for (s, sole) in p.soles.iter().enumerate() {
            for (i, v) in sole.vertices.iter().enumerate() {
                let n = if inside.next() == Some(&true) { self.law.normal(v) } else { 0.0 };
                out.normal[s][i] = n;
                out.tangent[s][i] = self.law.slip(&v.velocity.xy()) * (-v.mu_k * n);
            }
        }
        gather(p, out);
    }

    fn stored(&self, p: &Problem) -> Stored {
        let mut stored = Stored::default();
        for v in p.soles.iter().flat_map(|s| &s.vertices).filter(|v| v.height < 0.0) {
            stored.energy += 0.5 * self.law.stiffness * v.height * v.height;
            stored.power += self.law.stiffness * v.height * v.velocity.z;
        }
        stored
    }
}
