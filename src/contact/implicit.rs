//! Sliding directions that are not known beforehand: slip onset and impact.
//!
//! Where a sliding vertex has no velocity yet, its friction opposes the motion that results:
//! `u_i = t_i(s) / |t_i(s)|`, with `t_i` the tangential motion of vertex i under the sole's tangential motion `s`, and
//! `s = G(s)` the one that the candidate solve gives with these directions (`contact.md` section 5). For fixed normal
//! forces this is the optimality condition of a strictly convex function of s, smooth but where a vertex stands still;
//! such a vertex is a pivot and a state of its own. Solved by fixed-point steps, then damped Newton steps on
//! `s - G(s)` with a difference Jacobian, to 1e-10 of the frictionless motion.

use super::candidate::{Kernel, Solution};
use super::problem::Problem;
use super::state::{MAX_SOLES, Mode, States};
use nalgebra::{Vector2, Vector3};

/// Tangential motions of all soles: that of the mean of the clamped vertices, and the yaw motion times the radius.
type Slips = [Vector3<f64>; MAX_SOLES];

/// Residual asked for, relative to the motion without friction.
const TOLERANCE: f64 = 1e-10;

/// Does this state leave any direction to be found?
pub fn is_implicit(p: &Problem, states: &States, s: usize) -> bool {
    let sole = &p.soles[s];
    let k = sole.vertices.len();
    states[s].is_dynamic()
        && (0..k)
            .any(|i| states[s].clamps(i, k) && states[s].mode != Mode::Pivoting(i as u8) && !sole.vertices[i].moving)
}

/// Solves a candidate, finding the implicit directions, which are left in the problem. `hint` is a first guess of the
/// slip of each sole, zero where there is none; `thorough` looks over all directions when the guesses lead nowhere.
/// False when no consistent directions were found.
pub fn solve(
    kernel: &mut Kernel,
    p: &mut Problem,
    states: &States,
    hint: &Slips,
    thorough: bool,
    out: &mut Solution,
) -> bool {
    let mut which = [0usize; MAX_SOLES];
    let mut count = 0;
    for s in (0..p.soles.len()).filter(|&s| is_implicit(p, states, s)) {
        which[count] = s;
        count += 1;
    }
    if count == 0 {
        kernel.solve(p, states, out);
        return true;
    }
    let which = &which[..count];
    // Without friction on the implicit vertices: the drive, and a first guess.
    let zero = [Vector3::zeros(); MAX_SOLES];
    point(p, states, which, &zero);
    kernel.solve(p, states, out);
    let drive = read(p, states, which, out);
    let size = norm(which, &drive);
    if size == 0.0 {
        return false;
    }
    let effort = (size, if thorough { 30 } else { 5 });
    for guess in [*hint, drive] {
        if norm(which, &guess) > 0.0 && iterate(kernel, p, states, which, guess, effort, out) {
            return true;
        }
    }
    if let [s] = *which
        && let Mode::Pivoting(j) = states[s].mode
    {
        // About a pivot only the sense of rotation is open.
        let radius = p.soles[s].radius;
        let r = p.soles[s].vertices[j as usize].r - centre(p, states, s);
        for turn in [1.0, -1.0] {
            let mut guess = zero;
            guess[s] = Vector3::new(r.y * turn, -r.x * turn, turn * radius);
            if iterate(kernel, p, states, which, guess, effort, out) {
                return true;
            }
        }
    }
    thorough && scan(kernel, p, states, which, hint, size, out)
}

/// Looks over a grid of slip directions for the ones that come closest to themselves and starts from those, one
/// implicit sole at a time with the others on their hints.
fn scan(
    kernel: &mut Kernel,
    p: &mut Problem,
    states: &States,
    which: &[usize],
    hint: &Slips,
    drive: f64,
    out: &mut Solution,
) -> bool {
    const STARTS: usize = 3;
    for &s in which {
        let mut best = [(f64::INFINITY, Vector3::zeros()); STARTS];
        let turns = states[s].normal_rows() > 1;
        for direction in directions().filter(|d| turns || d.z == 0.0) {
            let mut guess = *hint;
            guess[s] = direction;
            let image = evaluate(kernel, p, states, which, &guess, out)[s];
            let size = image.norm();
            let mismatch = if size > 0.0 { (image / size - direction).norm() } else { 2.0 };
            if mismatch < best[STARTS - 1].0 {
                best[STARTS - 1] = (mismatch, direction * size);
                best.sort_by(|a, b| a.0.total_cmp(&b.0));
            }
        }
        for (_, start) in best {
            let mut guess = *hint;
            guess[s] = start;
            if iterate(kernel, p, states, which, guess, (drive, 15), out) {
                return true;
            }
        }
    }
    false
}

/// Directions spread over the unit sphere: translations, the two pure turns and what lies between.
fn directions() -> impl Iterator<Item = Vector3<f64>> {
    (-4..=4).flat_map(|level| {
        let turn = f64::from(level) / 4.0;
        let across = (1.0 - turn * turn).sqrt();
        let count = if across > 0.0 { 12 } else { 1 };
        (0..count).map(move |i| {
            let angle = f64::from(i) * std::f64::consts::TAU / 12.0;
            Vector3::new(across * angle.cos(), across * angle.sin(), turn)
        })
    })
}

fn norm(which: &[usize], s: &Slips) -> f64 {
    which.iter().map(|&i| s[i].norm_squared()).sum::<f64>().sqrt()
}

fn subtract(which: &[usize], a: &Slips, b: &Slips) -> Slips {
    let mut d = [Vector3::zeros(); MAX_SOLES];
    which.iter().for_each(|&s| d[s] = a[s] - b[s]);
    d
}

/// Mean of the clamped vertices, relative to the reference point: where the slip of a sole is taken. Motions of other
/// points contain rotations that the pattern leaves free and that no friction opposes.
fn centre(p: &Problem, states: &States, s: usize) -> Vector3<f64> {
    let sole = &p.soles[s];
    let k = sole.vertices.len();
    let clamped = || sole.vertices.iter().enumerate().filter(|(i, _)| states[s].clamps(*i, k));
    clamped().map(|(_, v)| v.r).sum::<Vector3<f64>>() / clamped().count() as f64
}

/// Tangential motion of a vertex at `r` under the slip of its sole, taken at `centre`.
fn tangential(slip: &Vector3<f64>, r: &Vector3<f64>, centre: &Vector3<f64>, radius: f64) -> Vector2<f64> {
    let d = r - centre;
    slip.xy() + Vector2::new(-d.y, d.x) * (slip.z / radius)
}

fn read(p: &Problem, states: &States, which: &[usize], out: &Solution) -> Slips {
    let mut slips = [Vector3::zeros(); MAX_SOLES];
    for &s in which {
        let sole = &p.soles[s];
        let m = &out.motion[6 * s..6 * s + 6];
        let (linear, angular) = (Vector3::new(m[0], m[1], m[2]), Vector3::new(m[3], m[4], m[5]));
        let k = sole.vertices.len();
        let clamped = || sole.vertices.iter().enumerate().filter(|(i, _)| states[s].clamps(*i, k));
        let bias = clamped().map(|(_, v)| v.bias).sum::<Vector3<f64>>() / clamped().count() as f64;
        let t = linear + angular.cross(&centre(p, states, s)) + bias;
        // A vertex turns freely.
        let turn = if states[s].normal_rows() > 1 { m[5] * sole.radius } else { 0.0 };
        slips[s] = Vector3::new(t.x, t.y, turn);
    }
    slips
}

/// Sets the implicit directions from the slips; a vertex that stands still gets none.
fn point(p: &mut Problem, states: &States, which: &[usize], slips: &Slips) {
    for &s in which {
        let centre = centre(p, states, s);
        let sole = &mut p.soles[s];
        let (k, radius) = (sole.vertices.len(), sole.radius);
        let slip = &slips[s];
        for (i, v) in sole.vertices.iter_mut().enumerate().filter(|(i, v)| states[s].clamps(*i, k) && !v.moving) {
            if states[s].mode == Mode::Pivoting(i as u8) {
                continue;
            }
            let t = tangential(slip, &v.r, &centre, radius);
            let speed = t.norm();
            v.direction = if speed > 1e-14 * slip.norm() { t / speed } else { Vector2::zeros() };
        }
    }
}

/// The candidate solve with directions from `slips`: G of the module comment.
fn evaluate(
    kernel: &mut Kernel,
    p: &mut Problem,
    states: &States,
    which: &[usize],
    slips: &Slips,
    out: &mut Solution,
) -> Slips {
    point(p, states, which, slips);
    kernel.solve(p, states, out);
    read(p, states, which, out)
}

fn iterate(
    kernel: &mut Kernel,
    p: &mut Problem,
    states: &States,
    which: &[usize],
    mut slips: Slips,
    (drive, rounds): (f64, usize),
    out: &mut Solution,
) -> bool {
    let mut image = evaluate(kernel, p, states, which, &slips, out);
    // A load at the very limit of its capacity does not accelerate yet; the directions are then those of the guess.
    if norm(which, &image) <= 1e-9 * drive {
        return true;
    }
    for round in 0..rounds {
        let residual = subtract(which, &slips, &image);
        let size = norm(which, &residual);
        if size <= TOLERANCE * drive {
            return opposes(p, states, which, &image);
        }
        // A fixed-point step where it helps, else a Newton step, each only as far as the residual falls.
        let fixed_point = round < 4 && descend(kernel, p, states, which, (&mut slips, &mut image), &residual, 0.5, out);
        if !fixed_point {
            let step = newton_step(kernel, p, states, which, &slips, &residual, out);
            if !descend(kernel, p, states, which, (&mut slips, &mut image), &step, 1.0, out) {
                return false;
            }
        }
    }
    false
}

/// Goes along `-step` as far as the residual falls below `share` of its size (any fall will do for a share of 1, with
/// shorter and shorter steps); false when it does not.
#[expect(clippy::too_many_arguments)]
fn descend(
    kernel: &mut Kernel,
    p: &mut Problem,
    states: &States,
    which: &[usize],
    (slips, image): (&mut Slips, &mut Slips),
    step: &Slips,
    share: f64,
    out: &mut Solution,
) -> bool {
    let size = norm(which, &subtract(which, slips, image));
    let mut t = 1.0;
    while t > 1e-3 {
        let mut trial = *slips;
        which.iter().for_each(|&s| trial[s] -= step[s] * t);
        let trial_image = evaluate(kernel, p, states, which, &trial, out);
        let wanted = if share < 1.0 { share } else { 1.0 - 1e-4 * t };
        if norm(which, &subtract(which, &trial, &trial_image)) < size * wanted {
            (*slips, *image) = (trial, trial_image);
            return true;
        }
        if share < 1.0 {
            return false;
        }
        t *= 0.5;
    }
    false
}

/// After convergence: every implicit vertex really moves along its direction (or not at all).
fn opposes(p: &Problem, states: &States, which: &[usize], slips: &Slips) -> bool {
    which.iter().all(|&s| {
        let centre = centre(p, states, s);
        let sole = &p.soles[s];
        let k = sole.vertices.len();
        sole.vertices.iter().enumerate().filter(|(i, v)| states[s].clamps(*i, k) && !v.moving).all(|(_, v)| {
            let t = tangential(&slips[s], &v.r, &centre, sole.radius);
            t.dot(&v.direction) >= -TOLERANCE * slips[s].norm()
        })
    })
}

/// Newton step on `s - G(s)`, all implicit soles at once, with a central-difference Jacobian.
fn newton_step(
    kernel: &mut Kernel,
    p: &mut Problem,
    states: &States,
    which: &[usize],
    slips: &Slips,
    residual: &Slips,
    out: &mut Solution,
) -> Slips {
    const MAX: usize = 3 * MAX_SOLES;
    let n = 3 * which.len();
    let h = 1e-6 * norm(which, slips);
    let mut a = [0.0; MAX * MAX];
    let mut b = [0.0; MAX];
    for (c, &s) in which.iter().enumerate() {
        for axis in 0..3 {
            let (mut plus, mut minus) = (*slips, *slips);
            plus[s][axis] += h;
            minus[s][axis] -= h;
            let above = evaluate(kernel, p, states, which, &plus, out);
            let below = evaluate(kernel, p, states, which, &minus, out);
            for (r, &t) in which.iter().enumerate() {
                for row in 0..3 {
                    let identity = f64::from(u8::from(s == t && axis == row));
                    a[(3 * r + row) * n + 3 * c + axis] = identity - (above[t][row] - below[t][row]) / (2.0 * h);
                }
            }
        }
    }
    for (r, &t) in which.iter().enumerate() {
        (0..3).for_each(|row| b[3 * r + row] = residual[t][row]);
    }
    kernel.linear.solve(&mut a[..n * n], &mut b[..n]);
    let mut step = [Vector3::zeros(); MAX_SOLES];
    which.iter().enumerate().for_each(|(r, &s)| step[s] = Vector3::new(b[3 * r], b[3 * r + 1], b[3 * r + 2]));
    step
}
