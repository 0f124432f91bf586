//! Finds sliding directions that the velocities do not give: slip onset and impact.
//!
//! Where a sliding vertex has no velocity yet, its friction opposes the resulting motion:
//! `u_i = t_i(s) / |t_i(s)|`, with `t_i` the tangential motion of vertex i under the sole's
//! tangential motion `s`, and `s = G(s)` the motion that the candidate solve gives with these
//! directions (`docs/contact.md`, section 5). For fixed normal forces this is the optimality
//! condition of a strictly convex function of s, smooth except where a vertex is at rest; such a
//! vertex is a pivot, with its own state. Fixed-point steps and damped Newton steps on `s - G(s)`
//! solve it to 1e-10 of the frictionless motion. The Jacobian is that of the candidate solve
//! itself: a slip `ds` turns the friction of vertex i by `-mu_k N_i du_i`,
//! `du_i = (1 - u_i u_i^T) dt_i / |t_i|`, and the motions respond to that small wrench under the
//! candidate's conditions.
//!
//! A single open direction is an angle, found by a scan over all angles.
//! [`crate::contact::search::regularized_modes`] finds which vertices stick and which slip.

use crate::contact::model::per_sole::PerSole;
use crate::contact::model::problem::Problem;
use crate::contact::model::solution::{Solution, wrench_at};
use crate::contact::model::state::{Mode, States};
use crate::contact::search::MANY;
use crate::contact::search::candidate::CandidateSolver;
use crate::contact::search::condensed::Condensed;
use crate::contact::search::slips::{
    AT_REST, SlipPoints, Slips, means, norm, only_open_vertex, open_vertices, read_slips, set_directions, shift_slips,
    slip_point, slip_points, soles_where, subtract, tangential,
};
use crate::linalg::linear::Linear;
use crate::math;
use nalgebra::{Vector2, Vector3};

/// Slip, relative to the frictionless motion, up to which a load at its limit counts as not yet
/// accelerating: the error of event location.
const ONSET_SLIP: f64 = 1e-7;

/// Tolerance of the residual, relative to the frictionless motion.
const TOLERANCE: f64 = 1e-10;

/// Difference of motions, relative to the frictionless one, up to which two solutions are the same.
const SAME: f64 = 1e3 * TOLERANCE;

/// Steps from one first guess, and from one that should be near.
const ROUNDS: usize = 12;
const FEW_ROUNDS: usize = 5;

/// Whether this state leaves any sliding direction undetermined.
pub fn is_implicit(p: &Problem, states: &States, s: usize) -> bool {
    states[s].is_dynamic() && open_vertices(p, states, s).next().is_some()
}

/// Slip onset of a sole whose friction load has just reached its limit.
#[derive(Clone, Copy, Debug)]
pub struct Onset {
    /// Vertices that begin to slip, one bit each.
    pub vertices: u64,
    /// Direction of slip of each vertex.
    pub directions: [Vector2<f64>; 64],
}

impl Default for Onset {
    fn default() -> Self {
        Onset { vertices: 0, directions: [Vector2::zeros(); 64] }
    }
}

impl Onset {
    /// Marks vertex `i` as slipping against the friction that it carries.
    pub fn against(&mut self, i: usize, friction: &Vector2<f64>) {
        if let Some(u) = friction.try_normalize(0.0) {
            self.vertices |= 1 << i;
            self.directions[i] = -u;
        }
    }
}

/// Solver for undetermined sliding directions, with its scratch.
#[derive(Clone, Debug)]
pub struct DirectionFinder {
    linear: Linear,
    jacobian: Vec<f64>,
    /// Newton step, 3F.
    step: Vec<f64>,
    motion: Vec<f64>,
    condensed: Condensed,
    /// Size of the slips without friction in the last search.
    drive: f64,
    /// Whether to try more than the first guesses, and for long.
    pub(super) thorough: bool,
}

impl DirectionFinder {
    /// Allocates for problems of this size.
    pub fn new(p: &Problem) -> Self {
        let n = 3 * p.soles.len();
        DirectionFinder {
            linear: Linear::new(n),
            jacobian: vec![0.0; n * n],
            step: vec![0.0; n],
            motion: vec![0.0; p.dim()],
            condensed: Condensed::new(p),
            drive: 0.0,
            thorough: true,
        }
    }

    /// Solves a candidate and leaves the directions found in the problem.
    ///
    /// `hints` are first guesses of the slip of each sole, zero where there is none. `onset`
    /// describes soles whose load has just reached its limit and which do not accelerate yet.
    /// Returns false if no consistent directions were found.
    pub fn solve(
        &mut self,
        solver: &mut CandidateSolver,
        p: &mut Problem,
        states: &States,
        hints: &[Slips],
        onset: &[Onset],
        out: &mut Solution,
    ) -> bool {
        let limit = (0..p.soles.len()).any(|s| onset[s].vertices != 0 && is_implicit(p, states, s));
        if limit && self.solve_at_limit(solver, p, states, hints, onset, out) {
            return true;
        }
        self.find(solver, p, states, hints, out)
    }

    /// Lets loads at their limit slip along `onset`, to first order without motion, and solves for
    /// all other directions. Returns whether consistent directions were found.
    fn solve_at_limit(
        &mut self,
        solver: &mut CandidateSolver,
        p: &mut Problem,
        states: &States,
        hints: &[Slips],
        onset: &[Onset],
        out: &mut Solution,
    ) -> bool {
        let mut starting = PerSole::<u64>::default();
        for s in (0..p.soles.len()).filter(|&s| is_implicit(p, states, s)) {
            starting[s] = open_vertices(p, states, s).fold(0, |set, i| set | 1 << i) & onset[s].vertices;
        }
        for (s, sole) in p.soles.iter_mut().enumerate() {
            for (i, v) in sole.vertices.iter_mut().enumerate().filter(|(i, _)| starting[s] >> i & 1 == 1) {
                v.direction = onset[s].directions[i];
                v.moving = true;
            }
        }
        let found = self.find(solver, p, states, hints, out);
        let drive =
            (0..p.soles.len()).map(|s| Vector3::from_column_slice(&p.b[6 * s..6 * s + 3]).norm()).fold(0.0, f64::max);
        let mut still = true;
        for s in 0..p.soles.len() {
            for i in (0..p.soles[s].vertices.len()).filter(|i| starting[s] >> i & 1 == 1) {
                still &= p.vertex_motion(&out.motion, s, i).xy().norm() <= ONSET_SLIP * drive;
                p.soles[s].vertices[i].moving = false;
            }
        }
        found && still
    }

    /// Finds the directions of all open vertices.
    fn find(
        &mut self,
        solver: &mut CandidateSolver,
        p: &mut Problem,
        states: &States,
        hints: &[Slips],
        out: &mut Solution,
    ) -> bool {
        let which = &soles_where(p, |s| is_implicit(p, states, s))[..];
        if which.is_empty() {
            solver.solve(p, states, out);
            return true;
        }
        if p.soles.len() > MANY
            && self.condensed.condense(solver, p, states, out)
            && let Some(found) = self.find_condensed(solver, p, states, hints, out)
        {
            return found;
        }
        self.search(solver, p, states, which, hints, out)
    }

    /// As [`search`](Self::search), on the condensed problem, and from there on the whole one. `None` if that has
    /// another motion: the normal forces of sliding soles are indeterminate.
    fn find_condensed(
        &mut self,
        solver: &mut CandidateSolver,
        p: &mut Problem,
        states: &States,
        hints: &[Slips],
        out: &mut Solution,
    ) -> Option<bool> {
        let which = &soles_where(p, |s| is_implicit(p, states, s))[..];
        let mut condensed = std::mem::take(&mut self.condensed);
        condensed.exchange(p);
        let found = self.search(solver, p, &condensed.loose, which, hints, out);
        let points = slip_points(p, states, which);
        let slips = read_slips(p, states, which, &points, &out.motion, true);
        condensed.exchange(p);
        self.condensed = condensed;
        if !found {
            solver.solve(p, states, out);
            return Some(false);
        }
        let drive = self.drive;
        let mut search = DirectionSearch { finder: self, solver, p, states, which, points, drive, viscosity: 0.0 };
        let image = search.evaluate(&slips, out);
        let is_same = norm(which, &subtract(which, &slips, &image)) <= SAME * drive;
        (is_same && search.iterate(slips, FEW_ROUNDS, out)).then_some(true)
    }

    /// Searches the directions of all open vertices, of the soles `which`.
    fn search(
        &mut self,
        solver: &mut CandidateSolver,
        p: &mut Problem,
        states: &States,
        which: &[usize],
        hints: &[Slips],
        out: &mut Solution,
    ) -> bool {
        // The motion without friction on these vertices is the drive, and a first guess.
        set_directions(p, states, which, &means(), &Slips::default(), 0.0);
        solver.solve(p, states, out);
        let points = slip_points(p, states, which);
        let drive = read_slips(p, states, which, &points, &out.motion, true);
        let size = norm(which, &drive);
        self.drive = size;
        let mut search = DirectionSearch {
            finder: self,
            solver,
            p,
            states,
            which,
            points: points.clone(),
            drive: size,
            viscosity: 0.0,
        };
        if search.drive == 0.0 {
            return false;
        }
        let (thorough, rounds) = if search.finder.thorough { (true, ROUNDS) } else { (false, FEW_ROUNDS) };
        for hint in hints {
            let guess = shift_slips(search.p, states, which, &points, hint);
            if norm(which, &guess) > 0.0 && search.iterate(guess, rounds, out) {
                return true;
            }
        }
        if !thorough {
            return false;
        }
        if search.iterate(drive, rounds, out) {
            return true;
        }
        if let [s] = *which {
            if let Mode::Pivoting(j) = states[s].mode {
                // About a pivot only the sense of rotation is undetermined.
                let radius = search.p.soles[s].radius;
                let r = search.p.soles[s].vertices[j as usize].r - slip_point(search.p, states, s, None).0;
                for turn in [1.0, -1.0] {
                    let mut guess = Slips::default();
                    guess[s] = Vector3::new(r.y * turn, -r.x * turn, turn * radius);
                    let guess = shift_slips(search.p, states, which, &points, &guess);
                    if search.iterate(guess, rounds, out) {
                        return true;
                    }
                }
            }
            if let Some(i) = only_open_vertex(search.p, states, s) {
                return search.scan_angles(s, i, out);
            }
        }
        false
    }
}

/// Search for the directions of one candidate.
pub(super) struct DirectionSearch<'a> {
    pub(super) finder: &'a mut DirectionFinder,
    pub(super) solver: &'a mut CandidateSolver,
    pub(super) p: &'a mut Problem,
    pub(super) states: &'a States,
    /// Soles with undetermined directions.
    pub(super) which: &'a [usize],
    /// Points at which their slips are measured.
    pub(super) points: SlipPoints,
    /// Size of the slips without friction.
    pub(super) drive: f64,
    /// Viscosity e of [`crate::contact::search::regularized_modes`]; zero without regularization.
    pub(super) viscosity: f64,
}

impl DirectionSearch<'_> {
    /// Solves the candidate with directions from `slips`: the map G of the module.
    pub(super) fn evaluate(&mut self, slips: &Slips, out: &mut Solution) -> Slips {
        set_directions(self.p, self.states, self.which, &self.points, slips, self.viscosity);
        self.solver.solve(self.p, self.states, out);
        read_slips(self.p, self.states, self.which, &self.points, &out.motion, true)
    }

    /// Scans the one undetermined direction, of vertex `i`, for angles at which friction opposes
    /// the resulting motion. Chooses the first (from +x) at which the floor pushes.
    fn scan_angles(&mut self, s: usize, i: usize, out: &mut Solution) -> bool {
        const STEPS: usize = 48;
        let mut across = |search: &mut Self, angle: f64| {
            let mut slips = Slips::default();
            slips[s] = Vector3::new(math::cos(angle), math::sin(angle), 0.0);
            let image = search.evaluate(&slips, out);
            let (centre, sole) = (slip_point(search.p, search.states, s, search.points[s]).0, &search.p.soles[s]);
            let t = tangential(&image[s], &sole.vertices[i].r, &centre, sole.radius);
            let u = slips[s].xy();
            (u.perp(&t), u.dot(&t) > 0.0 && out.normal[s][i] >= 0.0)
        };
        let step = std::f64::consts::TAU / STEPS as f64;
        let mut left = (0.0, across(self, 0.0));
        for k in 1..=STEPS {
            let angle = k as f64 * step;
            let right = (angle, across(self, angle));
            let (mut a, mut b) = (left, right);
            left = right;
            if (a.1.0 < 0.0) == (b.1.0 < 0.0) || !(a.1.1 || b.1.1) {
                continue;
            }
            for _ in 0..60 {
                let middle = 0.5 * (a.0 + b.0);
                let value = (middle, across(self, middle));
                if (value.1.0 < 0.0) == (a.1.0 < 0.0) { a = value } else { b = value }
            }
            let best = if a.1.0.abs() < b.1.0.abs() { a } else { b };
            // A jump through a pole changes sign as well.
            if best.1.0.abs() <= 1e3 * TOLERANCE * self.drive && across(self, best.0).1 {
                return true;
            }
        }
        false
    }

    fn iterate(&mut self, mut slips: Slips, rounds: usize, out: &mut Solution) -> bool {
        let mut image = self.evaluate(&slips, out);
        // A load at the limit of its capacity does not accelerate yet; the directions of the guess
        // remain.
        if norm(self.which, &image) <= 0.01 * ONSET_SLIP * self.drive {
            return true;
        }
        for round in 0..rounds {
            let residual = subtract(self.which, &slips, &image);
            let size = norm(self.which, &residual);
            if size <= TOLERANCE * self.drive {
                return self.opposes(&image);
            }
            // A fixed-point step where it helps, else a Newton step, each limited by descent of the
            // residual.
            let fixed_point = round < 2 && self.descend((&mut slips, &mut image), &residual, 0.3, out);
            if !fixed_point {
                let step = self.newton_step(&slips, &residual, out);
                if !self.descend((&mut slips, &mut image), &step, 1.0, out) {
                    return false;
                }
            }
        }
        false
    }

    /// Moves along `-step` if the residual falls below `share` of its size. A share of 1 accepts
    /// any decrease and halves the step until there is one. Returns false without a decrease. On
    /// return the solver has solved at the slips.
    pub(super) fn descend(
        &mut self,
        (slips, image): (&mut Slips, &mut Slips),
        step: &Slips,
        share: f64,
        out: &mut Solution,
    ) -> bool {
        let size = norm(self.which, &subtract(self.which, slips, image));
        let mut t = 1.0;
        while t > 1e-3 {
            let mut trial = slips.clone();
            self.which.iter().for_each(|&s| trial[s] -= step[s] * t);
            let trial_image = self.evaluate(&trial, out);
            let target = if share < 1.0 { share } else { 1.0 - 1e-4 * t };
            if norm(self.which, &subtract(self.which, &trial, &trial_image)) < size * target {
                (*slips, *image) = (trial, trial_image);
                return true;
            }
            if share < 1.0 {
                break;
            }
            t *= 0.5;
        }
        self.evaluate(slips, out);
        false
    }

    /// Checks after convergence that every open vertex moves along its direction or rests.
    fn opposes(&self, slips: &Slips) -> bool {
        self.which.iter().all(|&s| {
            let centre = slip_point(self.p, self.states, s, self.points[s]).0;
            let sole = &self.p.soles[s];
            open_vertices(self.p, self.states, s).all(|i| {
                let v = &sole.vertices[i];
                let t = tangential(&slips[s], &v.r, &centre, sole.radius);
                t.dot(&v.direction) >= -TOLERANCE * slips[s].norm()
            })
        })
    }

    /// Newton step on `s - G(s)` for all soles of `which`, at the last evaluation of the solver.
    pub(super) fn newton_step(&mut self, slips: &Slips, residual: &Slips, out: &Solution) -> Slips {
        let n = 3 * self.which.len();
        let a = &mut self.finder.jacobian[..n * n];
        for (c, &s) in self.which.iter().enumerate() {
            let centre = slip_point(self.p, self.states, s, self.points[s]).0;
            let sole = &self.p.soles[s];
            for axis in 0..3 {
                let mut unit = Vector3::zeros();
                unit[axis] = 1.0;
                let mut six = [0.0; 6];
                for i in open_vertices(self.p, self.states, s) {
                    let v = &sole.vertices[i];
                    let t = tangential(&slips[s], &v.r, &centre, sole.radius);
                    let speed = math::hypot(t.norm(), self.viscosity);
                    if speed <= AT_REST * slips[s].norm() {
                        continue;
                    }
                    // With |u| < 1 this is also the derivative of t / sqrt(|t|^2 + e^2).
                    let u = t / speed;
                    let dt = tangential(&unit, &v.r, &centre, sole.radius);
                    let df = (dt - u * u.dot(&dt)) * (-v.slip_mu() * out.normal[s][i] / speed);
                    let more = wrench_at(&v.r, &Vector3::new(df.x, df.y, 0.0));
                    six.iter_mut().zip(more).for_each(|(x, y)| *x += y);
                }
                self.solver.response(self.p, s, &six, &mut self.finder.motion);
                let change = read_slips(self.p, self.states, self.which, &self.points, &self.finder.motion, false);
                for (r, &t) in self.which.iter().enumerate() {
                    for row in 0..3 {
                        let identity = f64::from(u8::from(s == t && axis == row));
                        a[(3 * r + row) * n + 3 * c + axis] = identity - change[t][row];
                    }
                }
            }
        }
        let b = &mut self.finder.step[..n];
        for (r, &t) in self.which.iter().enumerate() {
            (0..3).for_each(|row| b[3 * r + row] = residual[t][row]);
        }
        self.finder.linear.solve(a, b);
        let mut step = Slips::default();
        for (r, &s) in self.which.iter().enumerate() {
            step[s] = Vector3::new(b[3 * r], b[3 * r + 1], b[3 * r + 2]);
        }
        step
    }
}
