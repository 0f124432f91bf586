//! Slips: tangential motions of sliding soles, and the directions of friction that they give.

use crate::contact::model::per_sole::{PerSole, SoleIndices};
use crate::contact::model::problem::Problem;
use crate::contact::model::state::{Mode, States};
use crate::math;
use nalgebra::{Vector2, Vector3};

/// Tangential motions of all soles: that of the mean of the clamped vertices, and the yaw motion
/// times the radius.
pub type Slips = PerSole<Vector3<f64>>;

/// Slip of a vertex, relative to that of its sole, below which the vertex is at rest.
pub(super) const AT_REST: f64 = 1e-14;

/// Clamped vertices of sole `s` whose sliding direction is undetermined.
pub(super) fn open_vertices<'a>(p: &'a Problem, states: &'a States, s: usize) -> impl Iterator<Item = usize> + 'a {
    let sole = &p.soles[s];
    let k = sole.vertices.len();
    (0..k).filter(move |&i| {
        states[s].clamps(i, k) && states[s].mode != Mode::Pivoting(i as u8) && !sole.vertices[i].moving
    })
}

/// The only such vertex; `None` if there is none or several.
pub(super) fn only_open_vertex(p: &Problem, states: &States, s: usize) -> Option<usize> {
    let mut open = open_vertices(p, states, s);
    open.next().filter(|_| open.next().is_none())
}

/// The soles for which `condition` holds.
pub(super) fn soles_where(p: &Problem, condition: impl Fn(usize) -> bool) -> SoleIndices {
    (0..p.soles.len()).filter(|&s| condition(s)).collect()
}

pub(super) fn norm(which: &[usize], s: &Slips) -> f64 {
    which.iter().map(|&i| s[i].norm_squared()).sum::<f64>().sqrt()
}

pub(super) fn subtract(which: &[usize], a: &Slips, b: &Slips) -> Slips {
    let mut d = Slips::default();
    which.iter().for_each(|&s| d[s] = a[s] - b[s]);
    d
}

/// Point at which the slip of each sole is measured: the mean of its clamped vertices, or one of
/// them.
///
/// Motions of other points contain rotations that the pattern leaves free and that no friction
/// opposes. A vertex that hardly moves while its sole turns must be the point itself; otherwise
/// rounding of the others' motion hides its own.
pub type SlipPoints = PerSole<Option<u8>>;

/// The mean of the clamped vertices for every sole.
pub(super) fn means() -> SlipPoints {
    SlipPoints::default()
}

/// Slip points of a candidate: the only vertex with an undetermined direction, or the mean.
pub(super) fn slip_points(p: &Problem, states: &States, which: &[usize]) -> SlipPoints {
    let mut points = means();
    which.iter().for_each(|&s| points[s] = only_open_vertex(p, states, s).map(|i| i as u8));
    points
}

/// Converts slips measured at the means to slips at `points`.
pub(super) fn shift_slips(p: &Problem, states: &States, which: &[usize], points: &SlipPoints, slips: &Slips) -> Slips {
    let mut moved = slips.clone();
    for &s in which.iter().filter(|&&s| slips[s] != Vector3::zeros()) {
        let (from, to) = (slip_point(p, states, s, None), slip_point(p, states, s, points[s]));
        let t = tangential(&slips[s], &to.0, &from.0, p.soles[s].radius) + (to.1 - from.1).xy();
        moved[s] = Vector3::new(t.x, t.y, slips[s].z);
    }
    moved
}

/// Position of a slip point relative to the reference point, and its centripetal term.
pub(super) fn slip_point(p: &Problem, states: &States, s: usize, at: Option<u8>) -> (Vector3<f64>, Vector3<f64>) {
    let sole = &p.soles[s];
    if let Some(i) = at {
        let v = &sole.vertices[i as usize];
        return (v.r, v.bias);
    }
    let k = sole.vertices.len();
    let (mut r, mut bias, mut count) = (Vector3::zeros(), Vector3::zeros(), 0.0);
    for (_, v) in sole.vertices.iter().enumerate().filter(|(i, _)| states[s].clamps(*i, k)) {
        r += v.r;
        bias += v.bias;
        count += 1.0;
    }
    (r / count, bias / count)
}

/// Tangential motion of a vertex at `r` under the slip of its sole, measured at `centre`.
pub(super) fn tangential(slip: &Vector3<f64>, r: &Vector3<f64>, centre: &Vector3<f64>, radius: f64) -> Vector2<f64> {
    let d = r - centre;
    slip.xy() + Vector2::new(-d.y, d.x) * (slip.z / radius)
}

/// Slips of the sliding soles under the sole motions `motion` (6F).
pub fn slips(p: &Problem, states: &States, motion: &[f64]) -> Slips {
    let which = soles_where(p, |s| states[s].is_dynamic());
    read_slips(p, states, &which, &means(), motion, true)
}

/// Slips of the sliding soles with the present velocities of their vertices.
pub fn slips_of_velocities(p: &Problem, states: &States) -> Slips {
    let mut slips = Slips::default();
    for (s, sole) in p.soles.iter().enumerate().filter(|(s, _)| states[*s].is_dynamic()) {
        let k = sole.vertices.len();
        let centre = slip_point(p, states, s, None).0;
        let (mut mean, mut turn, mut spread, mut count) = (Vector2::zeros(), 0.0, 0.0, 0.0);
        for v in sole.vertices.iter().enumerate().filter(|(i, _)| states[s].clamps(*i, k)).map(|(_, v)| v) {
            let d = (v.r - centre).xy();
            mean += v.velocity.xy();
            turn += d.perp(&v.velocity.xy());
            spread += d.norm_squared();
            count += 1.0;
        }
        let turn = if spread > 0.0 { turn / spread * sole.radius } else { 0.0 };
        slips[s] = Vector3::new(mean.x / count, mean.y / count, turn);
    }
    slips
}

/// Slips of the sole motions `motion` (6F). With `whole` false `motion` is a change of motion,
/// without centripetal part.
pub(super) fn read_slips(
    p: &Problem,
    states: &States,
    which: &[usize],
    points: &SlipPoints,
    motion: &[f64],
    whole: bool,
) -> Slips {
    let mut slips = Slips::default();
    for &s in which {
        let sole = &p.soles[s];
        let m = &motion[6 * s..6 * s + 6];
        let (linear, angular) = (Vector3::new(m[0], m[1], m[2]), Vector3::new(m[3], m[4], m[5]));
        let (at, bias) = slip_point(p, states, s, points[s]);
        let t = linear + angular.cross(&at) + if whole { bias } else { Vector3::zeros() };
        // A single vertex turns without friction.
        let turn = if states[s].normal_rows() > 1 { m[5] * sole.radius } else { 0.0 };
        slips[s] = Vector3::new(t.x, t.y, turn);
    }
    slips
}

/// Sets the undetermined directions from the slips; a vertex at rest gets none.
pub(super) fn set_directions(
    p: &mut Problem,
    states: &States,
    which: &[usize],
    points: &SlipPoints,
    slips: &Slips,
    viscosity: f64,
) {
    for &s in which {
        let centre = slip_point(p, states, s, points[s]).0;
        let sole = &mut p.soles[s];
        let (k, radius) = (sole.vertices.len(), sole.radius);
        let slip = &slips[s];
        for (i, v) in sole.vertices.iter_mut().enumerate().filter(|(i, v)| states[s].clamps(*i, k) && !v.moving) {
            if states[s].mode == Mode::Pivoting(i as u8) {
                continue;
            }
            let t = tangential(slip, &v.r, &centre, radius);
            let speed = math::hypot(t.norm(), viscosity);
            v.direction = if speed > AT_REST * slip.norm() { t / speed } else { Vector2::zeros() };
        }
    }
}
