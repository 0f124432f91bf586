//! Painleve's paradox: sliding that no finite force can continue. An impulse ends it at an instant:
//! a *jam*.
//!
//! Where vertices slide, their normal accelerations depend on the normal forces N and on the
//! friction that these cause:
//!
//! ```text
//! a_i = b_i + sum_j K_ij N_j        K_ij = e_i . W (e_j - mu_k t_j)
//! ```
//!
//! `e_i` is the wrench of one newton along the normal at vertex i, `t_j` that of one newton along
//! the slip `u_j`, W the inverse inertia seen by the soles with the sticking ones held. For one
//! vertex K is `A_nn - mu_k u . A_nt`. While `x . K x > 0` for every load `x >= 0` (K strictly
//! copositive, see [`super::copositivity`]), forces with the complementarity `N >= 0`, `a >= 0`,
//! `N . a = 0` exist for any b ([Cottle 1992], theorem 3.8.5). When it is not, a load accelerates
//! the vertices that carry it into the floor, the more the harder the floor pushes ([Painleve
//! 1895]). Two cases for one vertex:
//!
//! - b < 0, *inconsistent*: neither sliding nor lift-off is possible. A jam.
//! - b > 0, *indeterminate*: sliding under load and lift-off are both possible. Lift-off clamps
//!   less and is chosen; the search finds it without this module.
//!
//! The jam is an impact without collision ([Lecornu 1905]; [Genot 1999]). With the normal impulse p
//! as its clock, `dv/dp = A (-mu_k u, 1)`, the vertex is driven into the floor while its slip falls
//! to zero. From then on it sticks, within the friction cone, and the floor stops it: the impulse
//! is `-A^-1 v` in total, v = (slip, 0). In a plane problem its tangential part is `A_nn / |A_nt|`
//! times the normal one, less than mu_k because K < 0. The velocities after it are those of the
//! plastic impact law of the other impacts for a vanishing approach,
//!
//! ```text
//! v+ = v + d a0 + W p       d -> 0
//! ```
//!
//! (a time step of length d; [Stewart 1998] shows that its limit is the solution). It always has a
//! solution: if p is of the order of d a finite force exists, otherwise p is the jam. The same law
//! gives the motion of all other vertices, in three dimensions and with several soles: which stop,
//! which slip in another direction and which lift off. No vertex is pulled, and energy
//! falls: its change is `p . (v+ + v) / 2 = p . v+ - p . W p / 2`, where normal impulses do no work
//! on `v+_n = 0` and friction opposes `v+_t`.
//!
//! In a plane, sliding reaches the limit K = 0 by its own motion only where b vanishes too, with a
//! force `-b / K` that may grow beyond any bound while its impulse stays finite (the singular point
//! of [Genot 1999]). The steps end before that point. The rest of that impulse changes no normal
//! velocity, as K = 0; it lasts until b = 0, and the vertex lifts off. In space the slip may also
//! turn until K = 0, at an instant as the force grows. The impulse then turns it further, K < 0,
//! which is a jam.

use super::copositivity::{SlidingLoad, scale_biases};
use crate::contact::methods::contact_method::{ContactSolver, SelectionInput};
use crate::contact::model::problem::{Level, Problem};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{Pattern, SoleState, States};
use crate::contact::search::judge::Rules;
use crate::contact::search::select::Selection;
use nalgebra::{Vector2, Vector3};

/// Approach that represents a vanishing one, relative to the greatest speed: a thousand times the
/// least approach of the velocity level.
const APPROACH: f64 = 1e-7;
/// Greatest change of any velocity by the step d, relative to the greatest velocity.
const DISTURBANCE: f64 = 1e-4;
/// Least fraction of its slip that a vertex loses in a jam, well above `DISTURBANCE`.
const LOSS: f64 = 1e-2;
/// Fraction of the coefficient without friction below which the normal coefficient is at its limit.
/// At worst it approaches the limit as the square root of the remaining time, so steps of 1e-13 s
/// end within some 1e-6 of it.
const LIMIT: f64 = 1e-3;
/// Fall of the coefficient, in the same unit, that distinguishes a slip that turns from one that
/// keeps its direction.
const TURN: f64 = 1e-7;

impl SlidingLoad {
    /// Whether the load drives its vertices into the floor, for any free accelerations.
    pub(crate) fn drives_into_floor(&self) -> bool {
        self.value <= 0.0
    }

    /// Whether the normal coefficient is so near its limit that steps cannot resolve the force.
    pub(crate) fn is_at_limit(&self) -> bool {
        self.value <= LIMIT * self.smooth
    }

    /// Whether the normal coefficient falls from this load to `after`, by a small turn of the slip.
    pub(crate) fn falls_to(&self, after: &SlidingLoad) -> bool {
        after.value < self.value - TURN * self.smooth
    }
}

/// The jam of a sliding load: the velocity-level problem in the limit `d -> 0` of the module's
/// equation.
///
/// `p` contains the free accelerations and `velocity` the motions of the soles (6F). `input`
/// is that of an event. Leaves the solution for a small d in `solution` and the
/// impulses of the limit in `impulses`. The second value is the selection for the statistics,
/// `None` if no vertex presses on the floor. The first is its states, `None` if finite forces exist
/// or the velocity level has no solution either. The problem is then left at the velocity level.
pub(crate) fn jam(
    p: &mut Problem,
    method: &mut dyn ContactSolver,
    velocity: &[f64],
    load: &SlidingLoad,
    input: &SelectionInput,
    (solution, impulses): (&mut Solution, &mut Solution),
) -> (Option<States>, Option<Selection>) {
    let tol = input.rules.tolerances;
    let near = |&(s, i): &(usize, usize)| p.soles[s].vertices[i].is_near(&tol);
    let pressing = p.vertex_indices().filter(near).map(|(s, i)| -p.vertex_motion(&p.b, s, i).z).fold(0.0, f64::max);
    let fastest = p.vertex_indices().map(|(s, i)| p.soles[s].vertices[i].velocity.norm()).fold(1.0, f64::max);
    let greatest = p.vertex_indices().map(|(s, i)| p.vertex_motion(&p.b, s, i).norm()).fold(0.0, f64::max);
    if pressing == 0.0 {
        return (None, None);
    }
    let d = (APPROACH / pressing).min(DISTURBANCE / greatest) * fastest;
    p.level = Level::Velocity;
    for (b, v) in p.b.iter_mut().zip(velocity) {
        *b = v + d * *b;
    }
    scale_biases(p, d);
    for sole in &mut p.soles {
        sole.target = Vector3::zeros();
        (sole.turning.spins, sole.turning.rolls) = (false, false);
        for v in &mut sole.vertices {
            (v.moving, v.direction, v.near) = (false, Vector2::zeros(), v.is_near(&tol));
        }
    }
    // Several solutions may be valid. Prefer one in which vertices that jam together stop together.
    let together = |s: usize, state: SoleState| {
        let k = load.loaded[s].len();
        (input.allowed)(s, state) && (0..k).all(|i| !load.loaded[s][i] || state.clamps(i, k))
    };
    let preferring = Rules { exhaustive: false, ..input.rules.clone() };
    let preferred = SelectionInput { rules: &preferring, allowed: &together, ..*input };
    let mut selection = method.impulse(p, &preferred, solution);
    let mut tested = selection.tested;
    if !selection.consistent {
        p.soles.iter_mut().flat_map(|s| &mut s.vertices).for_each(|v| v.direction = Vector2::zeros());
        selection = method.impulse(p, input, solution);
        tested += selection.tested;
    }
    selection.tested = tested;
    let stopped = loses_slip(p, &selection.states, solution, tol.rest);
    // Solve again without the approach, for the impulse of the limit itself.
    p.b.copy_from_slice(velocity);
    scale_biases(p, 0.0);
    method.respond(p, &selection.states, impulses);
    if difference(&impulses.wrench, &solution.wrench) > LOSS {
        // Where a vertex keeps slipping in a direction in which K vanishes, only the approach
        // determines how far.
        impulses.wrench.copy_from_slice(&solution.wrench);
    }
    let states = (selection.consistent && stopped).then(|| selection.states.clone());
    (states, Some(selection))
}

/// Whether a sliding vertex that stays clamped loses a part of its slip.
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
