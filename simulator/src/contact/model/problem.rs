//! The reduced contact problem that every method solves.
//!
//! `docs/contact.md`, section 2, in floor axes (z = floor normal). The motions m of the F sole
//! frames depend on the sole wrenches w through
//!
//! ```text
//! m = b + W w        W = J M^-1 J^T (6F x 6F)
//! ```
//!
//! At the acceleration level `m` are accelerations and `b = a0`. At the velocity level `m` are
//! velocities after an impulse `w`, and `b` those before. Per sole the order is linear 3, angular 3
//! for motions and force 3, moment 3 for wrenches, both at the sole's reference point. Vertex i of
//! a sole moves with `m_lin + m_ang x r_i + c_i`, where `c_i` is the centripetal term
//! `omega x (omega x r_i)` at the acceleration level and zero at the velocity level.

use crate::contact::model::state::{Pattern, SoleState};
use crate::contact::model::turning::Turning;
use nalgebra::{Vector2, Vector3};

/// Level of a [`Problem`]: the meaning of its motions and wrenches.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Level {
    /// Accelerations and forces.
    Acceleration,
    /// Velocities and impulses.
    Velocity,
}

/// The tolerances of a scenario, `contact.md` section 4.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Tolerances {
    /// Distance tolerance d, m.
    pub distance: f64,
    /// Velocity tolerance v_t, m/s.
    pub velocity: f64,
    /// Acceleration tolerance a_t, m/s^2.
    pub acceleration: f64,
    /// Speed below which a sliding vertex counts as at rest, m/s: the resolution of the integrator.
    pub rest: f64,
}

impl Default for Tolerances {
    fn default() -> Self {
        Tolerances { distance: 1e-3, velocity: 0.1, acceleration: 0.1, rest: 1e-7 }
    }
}

/// Height up to which a vertex touches the floor, m: above rounding of positions of a few metres,
/// far below any tolerance.
pub const TOUCHING: f64 = 1e-10;

/// Greatest acceleration of an unclamped touching vertex into the floor with located events, m/s^2.
const SINKING: f64 = 1e-3;

/// Height, in distance tolerances, up to which a vertex belongs to a pattern within d. The fourth
/// vertex of a rectangle is at most three times as high as the others.
const FARTHER: f64 = 3.0;

/// The same height, m, for soles of many vertices that land flat.
const FLAT: f64 = 1e-8;

impl Tolerances {
    /// Tolerances of methods with located events. Every vertex meets the floor in its own event, so
    /// none is clamped above the floor. The downward acceleration covers rounding only.
    pub fn with_located_events(self) -> Self {
        Tolerances { distance: self.distance.min(TOUCHING), acceleration: self.acceleration.min(SINKING), ..self }
    }
}

/// One vertex of a sole.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Vertex {
    /// Position relative to the sole's reference point, floor axes, m.
    pub r: Vector3<f64>,
    /// Centripetal term c_i (zero at the velocity level).
    pub bias: Vector3<f64>,
    /// Height above the floor, m.
    pub height: f64,
    /// Velocity, floor axes, m/s.
    pub velocity: Vector3<f64>,
    /// Static friction coefficient of the floor under it.
    pub mu_s: f64,
    /// Kinetic friction coefficient of the floor under it, at vanishing speed.
    pub mu_k: f64,
    /// Increase of the kinetic coefficient with the slip speed, s/m.
    pub viscous: f64,
    /// Unit direction in which it slides or begins to slide; zero when it has none.
    pub direction: Vector2<f64>,
    /// True if the velocity gives `direction`. False if a sliding state must find it from the
    /// resulting motion (slip onset, impact).
    pub moving: bool,
    /// Slides, but counts as at rest: it also moves along the normal, slowly, and clamping it changes
    /// its velocity.
    pub settles: bool,
    /// At the velocity level: whether this vertex may meet the floor (in this impact, or before the
    /// end of this step).
    pub near: bool,
    /// Leaves the other body, or another vertex touches in its place: it may touch, but no state clamps it.
    pub leaves: bool,
}

impl Vertex {
    /// Coefficient of its sliding friction at its present speed: `mu_k + viscous |t|`.
    pub fn slip_mu(&self) -> f64 {
        if self.viscous == 0.0 { self.mu_k } else { self.mu_k + self.viscous * self.velocity.xy().norm() }
    }

    /// Coefficient of its static friction. A velocity-level problem sees the speed before its impulse, at which
    /// the sliding friction that stops a vertex may be greater than the static friction that holds it.
    pub fn stick_mu(&self, level: Level) -> f64 {
        match level {
            Level::Velocity if self.viscous != 0.0 => self.mu_s.max(self.slip_mu()),
            _ => self.mu_s,
        }
    }

    /// Whether it is at most d above the floor.
    pub fn is_near(&self, tol: &Tolerances) -> bool {
        self.height <= tol.distance
    }

    /// Whether it is in the tolerance band: near the floor, with a normal velocity of at most v_t.
    pub fn is_in_band(&self, tol: &Tolerances) -> bool {
        self.is_near(tol) && self.velocity.z.abs() <= tol.velocity && !self.leaves
    }

    /// Whether it meets the floor at the problem's level: touches it, or comes near it in this
    /// impact or step.
    pub fn meets_floor(&self, level: Level) -> bool {
        match level {
            Level::Velocity => self.near,
            Level::Acceleration => self.height <= TOUCHING,
        }
    }
}

/// One sole.
#[derive(Clone, PartialEq, Debug)]
pub struct SoleProblem {
    /// Its vertices in order around the polygon.
    pub vertices: Vec<Vertex>,
    /// Length that relates moments to forces: the greatest vertex distance from the reference
    /// point, m.
    pub radius: f64,
    /// Index of its body. Soles of one body do not move relative to each other.
    pub body: usize,
    /// Reference point relative to the floor's origin, floor axes, m.
    pub position: Vector3<f64>,
    /// Target motion along clamped normals: of the reference point, and about x and y (restitution,
    /// gap closing).
    pub target: Vector3<f64>,
    /// Its torsional and rolling friction, of a sole with one vertex.
    pub turning: Turning,
}

impl SoleProblem {
    /// Vertices that may be clamped, one bit each: those within d of the floor, and where these are no
    /// pattern, such as three of four, the others of the smallest pattern that covers them, unless
    /// clearly higher.
    pub fn clampable(&self, tol: &Tolerances) -> u64 {
        let k = self.vertices.len();
        let near = |i: usize| self.vertices[i].is_near(tol) && !self.vertices[i].leaves;
        let state = SoleState::fixed(Pattern::covering(k, near));
        let limit = (FARTHER * tol.distance).max(FLAT);
        let is_low = |i: usize| self.vertices[i].height <= limit && !self.vertices[i].leaves;
        (0..k).filter(|&i| state.clamps(i, k) && is_low(i)).fold(0, |set, i| set | 1 << i)
    }

    /// Target normal motion of vertex `i`: `(target_lin + target_ang x r_i) . n`.
    pub fn vertex_target(&self, i: usize) -> f64 {
        let r = &self.vertices[i].r;
        self.target.x + self.target.y * r.y - self.target.z * r.x
    }
}

/// A reduced contact problem, see the module for its equations.
#[derive(Clone, PartialEq, Debug)]
pub struct Problem {
    /// Accelerations or velocities.
    pub level: Level,
    /// W, 6F x 6F, symmetric.
    pub w: Vec<f64>,
    /// b, 6F.
    pub b: Vec<f64>,
    /// Soles, in the order of the rows.
    pub soles: Vec<SoleProblem>,
    /// Typical load, N or N s (the robot's weight or momentum): the scale of rounding and margins.
    pub scale: f64,
    /// Length of the step over which impulses are spread, s; zero without a step.
    pub step: f64,
}

impl Problem {
    /// An empty problem for soles with these numbers of vertices.
    pub fn new(vertices: &[usize]) -> Self {
        let n = 6 * vertices.len();
        Problem {
            level: Level::Acceleration,
            w: vec![0.0; n * n],
            b: vec![0.0; n],
            soles: vertices
                .iter()
                .enumerate()
                .map(|(s, &k)| SoleProblem {
                    vertices: vec![Vertex::default(); k],
                    radius: 1.0,
                    body: s,
                    position: Vector3::zeros(),
                    target: Vector3::zeros(),
                    turning: Turning::default(),
                })
                .collect(),
            scale: 1.0,
            step: 0.0,
        }
    }

    /// Number of unknowns of the wrench vector, 6F.
    pub fn dim(&self) -> usize {
        self.b.len()
    }

    /// Sole and index of every vertex.
    pub fn vertex_indices(&self) -> impl Iterator<Item = (usize, usize)> {
        self.soles.iter().enumerate().flat_map(|(s, sole)| (0..sole.vertices.len()).map(move |i| (s, i)))
    }

    /// Sets the sliding directions of all vertices, by sole and vertex.
    pub fn set_directions(&mut self, directions: &[Vec<Vector2<f64>>]) {
        for (sole, directions) in self.soles.iter_mut().zip(directions) {
            sole.vertices.iter_mut().zip(directions).for_each(|(v, d)| v.direction = *d);
        }
    }

    /// Motion of a vertex when the sole frames move with `motion` (6F).
    pub fn vertex_motion(&self, motion: &[f64], sole: usize, vertex: usize) -> Vector3<f64> {
        let m = &motion[6 * sole..6 * sole + 6];
        let v = &self.soles[sole].vertices[vertex];
        Vector3::new(m[0], m[1], m[2]) + Vector3::new(m[3], m[4], m[5]).cross(&v.r) + v.bias
    }
}
