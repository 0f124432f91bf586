//! The contact problem by points, for the time-stepping methods.
//!
//! Every vertex that may meet the floor is a point of its own, with an impulse p_c and a velocity
//! v_c (normal and two tangential components, floor axes). With J_c the motion of the point when
//! its sole moves,
//!
//! ```text
//! v_c = J_c m + c_c      m = b + sum_d (W J_d^T) p_d      block (c, d): J_c W J_d^T
//! ```
//!
//! W J^T is stored, not the blocks: W has rank 6 per sole, while a sole of four vertices has twelve
//! impulses, so their matrix would be larger and singular.

use crate::contact::model::problem::Problem;
use crate::contact::model::solution::{Solution, wrench_at};
use crate::contact::model::state::{Mode, Pattern, SoleState, States};
use nalgebra::{Matrix3, Vector3};

/// Fraction of the greatest normal impulse below which a point counts as unloaded.
const UNLOADED: f64 = 1e-9;

/// One vertex that may meet the floor.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Index of the sole.
    pub sole: usize,
    /// Index of the vertex.
    pub vertex: usize,
    /// Position from the sole's reference point, m.
    pub r: Vector3<f64>,
    /// Motion that no wrench causes, in addition to that of the sole's frame.
    pub bias: Vector3<f64>,
    /// Least normal velocity at the end, m/s.
    pub target: f64,
    /// Kinetic friction coefficient; impulses over a step use one coefficient only.
    pub mu: f64,
}

impl Point {
    /// Velocity when its sole moves with `m`, six numbers.
    pub fn velocity(&self, m: &[f64]) -> Vector3<f64> {
        self.frame_velocity(m) + self.bias
    }

    fn frame_velocity(&self, m: &[f64]) -> Vector3<f64> {
        let r = &self.r;
        Vector3::new(m[0] + m[4] * r.z - m[5] * r.y, m[1] + m[5] * r.x - m[3] * r.z, m[2] + m[3] * r.y - m[4] * r.x)
    }
}

/// The points of a problem; allocated once.
#[derive(Clone, Debug)]
pub struct Points {
    list: Vec<Point>,
    /// W J^T, three columns for each point, each 6F long.
    columns: Vec<f64>,
    dim: usize,
}

impl Points {
    /// Reserves memory for all vertices of problems of this size.
    pub fn new(p: &Problem) -> Self {
        let most = p.soles.iter().map(|s| s.vertices.len()).sum();
        Points { list: Vec::with_capacity(most), columns: vec![0.0; 3 * most * p.dim()], dim: p.dim() }
    }

    /// Collects the vertices that may meet the floor. A vertex below the floor is raised with at
    /// most `push_out`, m/s.
    pub fn gather(&mut self, p: &Problem, push_out: f64) {
        self.list.clear();
        for (s, sole) in p.soles.iter().enumerate() {
            for (i, v) in sole.vertices.iter().enumerate() {
                if v.meets_floor(p.level) {
                    let target = sole.vertex_target(i).min(push_out);
                    self.list.push(Point { sole: s, vertex: i, r: v.r, bias: v.bias, target, mu: v.slip_mu() });
                }
            }
        }
        for (c, point) in self.list.iter().enumerate() {
            let columns = &mut self.columns[3 * c * self.dim..][..3 * self.dim];
            // W is symmetric: its rows are its columns. Six numbers of a sole stay in registers.
            let w = |k: usize| p.w[(6 * point.sole + k) * self.dim..][..self.dim].as_chunks::<6>().0;
            for (axis, column) in columns.chunks_exact_mut(self.dim).enumerate() {
                // Moments of a unit force along the axis: none about the axis itself.
                let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
                let (about_i, about_j) = (point.r[j], -point.r[i]);
                let terms = w(axis).iter().zip(w(3 + i)).zip(w(3 + j));
                for (x, ((force, turn_i), turn_j)) in column.as_chunks_mut::<6>().0.iter_mut().zip(terms) {
                    *x = std::array::from_fn(|r| force[r] + turn_i[r] * about_i + turn_j[r] * about_j);
                }
            }
        }
    }

    /// The points.
    pub fn list(&self) -> &[Point] {
        &self.list
    }

    /// Velocity of point `c` when the sole frames move with `motion`.
    pub fn velocity(&self, c: usize, motion: &[f64]) -> Vector3<f64> {
        let point = &self.list[c];
        point.velocity(&motion[6 * point.sole..6 * point.sole + 6])
    }

    fn frame_velocity(&self, c: usize, motion: &[f64]) -> Vector3<f64> {
        let point = &self.list[c];
        point.frame_velocity(&motion[6 * point.sole..6 * point.sole + 6])
    }

    /// Adds the response of the motions to an impulse at point `c`.
    pub fn add_response(&self, c: usize, impulse: &Vector3<f64>, motion: &mut [f64]) {
        let column = |axis: usize| self.column(c, axis).as_chunks::<6>().0.iter();
        for (((m, x), y), z) in motion.as_chunks_mut::<6>().0.iter_mut().zip(column(0)).zip(column(1)).zip(column(2)) {
            *m = std::array::from_fn(|r| m[r] + x[r] * impulse.x + y[r] * impulse.y + z[r] * impulse.z);
        }
    }

    /// Response of the motions (6F) to a unit impulse at point `c` along an axis.
    pub fn column(&self, c: usize, axis: usize) -> &[f64] {
        &self.columns[(3 * c + axis) * self.dim..][..self.dim]
    }

    /// Response of the velocity of point `c` to an impulse at point `d`.
    pub fn block(&self, c: usize, d: usize) -> Matrix3<f64> {
        let column = |axis: usize| self.frame_velocity(c, self.column(d, axis));
        Matrix3::from_columns(&[column(0), column(1), column(2)])
    }

    /// Writes impulses into a solution: wrenches, motions and vertex forces.
    pub fn write_solution(&self, p: &Problem, impulses: &[Vector3<f64>], out: &mut Solution) {
        out.wrench.fill(0.0);
        out.motion.copy_from_slice(&p.b);
        out.normal.iter_mut().for_each(|n| n.fill(0.0));
        out.tangent.iter_mut().for_each(|t| t.fill(Default::default()));
        out.inside.fill(true);
        for (c, (point, impulse)) in self.list.iter().zip(impulses).enumerate() {
            let six = wrench_at(&point.r, impulse);
            let sole = &mut out.wrench[6 * point.sole..6 * point.sole + 6];
            sole.iter_mut().zip(six).for_each(|(w, x)| *w += x);
            self.add_response(c, impulse, &mut out.motion);
            out.normal[point.sole][point.vertex] = impulse.z;
            out.tangent[point.sole][point.vertex] = impulse.xy();
        }
    }

    /// The states that correspond to the impulses: the smallest pattern that clamps every loaded
    /// vertex. It sticks if no loaded vertex `slips`, and pivots if all but one slip.
    pub fn states(&self, p: &Problem, out: &Solution, slips: impl Fn(usize) -> bool) -> States {
        let greatest = out.normal.iter().flatten().copied().fold(0.0, f64::max);
        let mut states = States::default();
        for (s, sole) in p.soles.iter().enumerate() {
            let loaded = |i: usize| out.normal[s][i] > UNLOADED * greatest;
            let pattern = Pattern::covering(sole.vertices.len(), loaded);
            let (mut holding, mut held, mut slipping) = (None, 0, 0);
            for (c, point) in self.list.iter().enumerate().filter(|(_, x)| x.sole == s && loaded(x.vertex)) {
                if slips(c) {
                    slipping += 1;
                } else {
                    (holding, held) = (Some(point.vertex as u8), held + 1);
                }
            }
            let mode = match holding {
                _ if slipping == 0 => Mode::Static,
                Some(vertex) if held == 1 => Mode::Pivoting(vertex),
                _ => Mode::Sliding,
            };
            states[s] = SoleState { pattern, mode };
        }
        states
    }
}
