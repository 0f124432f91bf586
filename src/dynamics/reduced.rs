//! The contact problem reduced to the sole frames: `a = a0 + W w` with
//!
//! ```text
//! W = J M^-1 J^T,   a0 = J M^-1 (tau - h) + Jdot v
//! ```
//!
//! for F soles (or other polygons that may touch), each with a frame at its reference point (the
//! centroid of its vertices, fixed in the link), in floor axes. Rows of a sole: acceleration p'' of the reference point, then angular
//! acceleration. `w` stacks the soles' wrenches: force, then moment about the reference point.
//! `tau` contains all generalised forces except those of contact.
//!
//! With M = L^T L and Y = L^-T J^T: W = Y^T Y and a0 = Y^T L^-T (tau - h) + Jdot v. A sole's
//! columns of Y are nonzero on its support chain only, and two chains share a leading part, so both
//! are short contiguous sums.

use super::factor;
use super::jacobian::classical;
use super::spatial::Motion;
use super::workspace::Workspace;
use crate::robot::{LinkId, Model, Sole, SoleId};
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;

/// The reduced problem of one evaluation, allocated once for a list of soles.
#[derive(Clone, Debug)]
pub struct Reduced {
    /// Number of soles F.
    pub n: usize,
    /// W, symmetric, 6F x 6F, stored whole: entry (i, j) at `i + 6F j`.
    pub w: Vec<f64>,
    /// Acceleration without contact wrenches, 6F.
    pub a0: Vec<f64>,
    /// J v, 6F.
    pub velocity: Vec<f64>,
    /// Generalised acceleration without contact wrenches, `M^-1 (tau - h)`, nv.
    pub free: Vec<f64>,
    /// Reference points in the world, m, one per sole.
    pub reference: Vec<Vector3<f64>>,
    /// Orientation of the carrying links, floor axes from the link's internal frame, one per sole.
    pub orientation: Vec<Matrix3<f64>>,
    /// Velocities whose motion is prescribed, ascending; contact moves only the others. See
    /// [`assemble`].
    pub prescribed: Vec<usize>,
    /// Vertices relative to their sole's reference point, floor axes, m; one sole after the other,
    /// see [`Reduced::vertices`].
    pub arms: Vec<Vector3<f64>>,
    vertex_start: Vec<usize>,
    /// Carrying links, one per sole.
    links: Vec<LinkId>,
    /// Reference points in the links' internal frames.
    local: Vec<Vector3<f64>>,
    /// Vertices relative to their reference points in the links' internal frames, as `arms`.
    local_arms: Vec<Vector3<f64>>,
    /// Y: for each sole and each velocity of its support chain, six numbers.
    y: Vec<[f64; 6]>,
    y_start: Vec<usize>,
    /// Position of the row of L of each of these velocities among its entries.
    rows: Vec<usize>,
    half: Vec<f64>,
}

impl Reduced {
    /// Allocates for the soles of a model.
    pub fn new(model: &Model, ws: &Workspace) -> Self {
        Self::of_soles(&model.soles, ws)
    }

    /// Allocates for these soles.
    pub fn of_soles(soles: &[Sole], ws: &Workspace) -> Self {
        let n = soles.len();
        let mut vertex_start = vec![0];
        let mut y_start = vec![0];
        let (mut local, mut local_arms, mut rows) = (Vec::new(), Vec::new(), Vec::new());
        for sole in soles {
            rows.extend(ws.support(sole.link).iter().map(|&k| ws.factor.pattern().start(k)));
            vertex_start.push(vertex_start[vertex_start.len() - 1] + sole.vertices.len());
            y_start.push(y_start[y_start.len() - 1] + ws.support(sole.link).len());
            let centroid = sole.centroid();
            local_arms.extend(sole.vertices.iter().map(|vertex| vertex - centroid));
            local.push(centroid);
        }
        Reduced {
            n,
            w: vec![0.0; 36 * n * n],
            a0: vec![0.0; 6 * n],
            velocity: vec![0.0; 6 * n],
            free: vec![0.0; ws.nv()],
            reference: vec![Vector3::zeros(); n],
            orientation: vec![Matrix3::identity(); n],
            prescribed: Vec::with_capacity(ws.nv()),
            arms: vec![Vector3::zeros(); vertex_start[n]],
            vertex_start,
            links: soles.iter().map(|sole| sole.link).collect(),
            local,
            local_arms,
            y: vec![[0.0; 6]; y_start[n]],
            y_start,
            rows,
            half: vec![0.0; ws.nv()],
        }
    }

    /// The same for other soles, with the same prescribed velocities.
    pub fn with_soles(&self, soles: &[Sole], ws: &Workspace) -> Self {
        Reduced { prescribed: self.prescribed.clone(), ..Self::of_soles(soles, ws) }
    }

    /// Range of a sole's vertices in `arms`.
    #[inline(always)]
    pub fn vertex_range(&self, sole: SoleId) -> Range<usize> {
        self.vertex_start[sole.0]..self.vertex_start[sole.0 + 1]
    }

    /// A sole's vertices relative to its reference point, floor axes, m.
    #[inline(always)]
    pub fn vertices(&self, sole: SoleId) -> &[Vector3<f64>] {
        &self.arms[self.vertex_range(sole)]
    }

    /// The 6 x 6 block of W between two soles: entry (r, c) at `[c][r]`.
    #[inline]
    pub fn block(&self, row: SoleId, column: SoleId) -> [[f64; 6]; 6] {
        let size = 6 * self.n;
        std::array::from_fn(|c| std::array::from_fn(|r| self.w[6 * row.0 + r + size * (6 * column.0 + c)]))
    }
}

/// Fills `out` for the state in the workspace. `floor` turns floor axes into world axes; `tau`
/// (length nv) is the generalised force of actuators, joint friction and external forces. Needs
/// [`super::prepare`].
///
/// With velocities k in `out.prescribed` at given accelerations a_k the free velocities f obey
///
/// ```text
/// M_ff a_f = tau_f - M_fk a_k - h_f + J_f^T w
/// ```
///
/// The caller factorises by [`factor::factorize_prescribed`], subtracts `M_fk a_k` from tau and
/// writes `h_k + a_k` into its prescribed entries. Their contribution to a0 is then correct, and
/// that to W, [`apply`] and Y is removed.
pub fn assemble(ws: &Workspace, floor: &Matrix3<f64>, tau: &[f64], out: &mut Reduced) {
    geometry(ws, floor, out);
    assemble_with_geometry(ws, floor, tau, out);
}

/// As [`assemble`], where `out` has the [`geometry`] of the state in the workspace already.
pub fn assemble_with_geometry(ws: &Workspace, floor: &Matrix3<f64>, tau: &[f64], out: &mut Reduced) {
    for ((half, tau), h) in out.half.iter_mut().zip(tau).zip(&ws.bias) {
        *half = tau - h;
    }
    factor::solve_lt(&ws.factor, &mut out.half);
    out.free.copy_from_slice(&out.half);
    factor::solve_l(&ws.factor, &mut out.free);

    for s in 0..out.n {
        half_solve(ws, floor, s, out);
        free_motion(ws, floor, s, out);
        remove_prescribed(ws, s, out);
        for other in 0..=s {
            block(ws, s, other, out);
        }
    }
}

/// Poses and velocities of the soles: the part of [`assemble`] that needs no forces. Needs
/// `kinematics::update`.
pub fn geometry(ws: &Workspace, floor: &Matrix3<f64>, out: &mut Reduced) {
    let to_floor = floor.transpose();
    for s in 0..out.n {
        let link = &ws.links[out.links[s].0];
        let r = link.origin + link.rotation * out.local[s];
        out.reference[s] = ws.position + r;
        let turn = to_floor * link.rotation;
        out.orientation[s] = turn;
        let range = out.vertex_range(SoleId(s));
        for (arm, local) in out.arms[range.clone()].iter_mut().zip(&out.local_arms[range]) {
            *arm = turn * local;
        }
        let velocity = Motion::new(link.velocity.at(&r), link.velocity.angular);
        write_in_floor_axes(&to_floor, &velocity, &mut out.velocity[6 * s..6 * s + 6]);
    }
}

/// Y of one sole: its Jacobian columns, then L^-T along the support chain.
fn half_solve(ws: &Workspace, floor: &Matrix3<f64>, s: usize, out: &mut Reduced) {
    let to_floor = floor.transpose();
    let chain = ws.support(out.links[s]);
    let r = out.reference[s] - ws.position;
    let y = &mut out.y[out.y_start[s]..out.y_start[s + 1]];
    for (y, &k) in y.iter_mut().zip(chain) {
        let axis = &ws.axes[k];
        write_in_floor_axes(&to_floor, &Motion::new(axis.at(&r), axis.angular), y);
    }
    let rows = &out.rows[out.y_start[s]..out.y_start[s + 1]];
    let l = ws.factor.entries();
    for e in (0..chain.len()).rev() {
        let (above, below) = y.split_at_mut(e + 1);
        // The sum stays in registers.
        let mut sum = above[e];
        for (x, row) in below.iter().zip(&rows[e + 1..]).rev() {
            let l = l[row + e];
            sum.iter_mut().zip(x).for_each(|(sum, x)| *sum -= l * x);
        }
        let inverse = l[rows[e] + e];
        above[e] = sum.map(|x| x * inverse);
    }
}

/// Rows of `a0`: Y^T L^-T (tau - h), and Jdot v from the link's acceleration at vdot = 0.
fn free_motion(ws: &Workspace, floor: &Matrix3<f64>, s: usize, out: &mut Reduced) {
    let link = &ws.links[out.links[s].0];
    let r = out.reference[s] - ws.position;
    let a0 = &mut out.a0[6 * s..6 * s + 6];
    write_in_floor_axes(&floor.transpose(), &classical(&link.drift, &link.velocity, &r), a0);
    let mut sum: [f64; 6] = std::array::from_fn(|i| a0[i]);
    let y = &out.y[out.y_start[s]..out.y_start[s + 1]];
    for (y, &k) in y.iter().zip(ws.support(out.links[s])) {
        let half = out.half[k];
        sum.iter_mut().zip(y).for_each(|(a, y)| *a += y * half);
    }
    a0.copy_from_slice(&sum);
}

/// Removes the prescribed velocities from Y of one sole.
fn remove_prescribed(ws: &Workspace, s: usize, out: &mut Reduced) {
    let chain = ws.support(out.links[s]);
    for k in &out.prescribed {
        if let Ok(e) = chain.binary_search(k) {
            out.y[out.y_start[s] + e] = [0.0; 6];
        }
    }
}

/// Generalised force of sole wrenches on velocity `k`, `(J^T w)_k`; `w` has length 6F. Needs
/// [`geometry`].
pub fn load(ws: &Workspace, floor: &Matrix3<f64>, reduced: &Reduced, w: &[f64], k: usize) -> f64 {
    let mut sum = 0.0;
    for (s, link) in reduced.links.iter().enumerate() {
        if ws.support(*link).binary_search(&k).is_ok() {
            let vector = |at: usize| floor * Vector3::new(w[6 * s + at], w[6 * s + at + 1], w[6 * s + at + 2]);
            let axis = &ws.axes[k];
            let r = reduced.reference[s] - ws.position;
            sum += axis.at(&r).dot(&vector(0)) + axis.angular.dot(&vector(3));
        }
    }
    sum
}

/// Block (s, other) of W and its mirror image.
fn block(ws: &Workspace, s: usize, other: usize, out: &mut Reduced) {
    let (a, b) = (ws.support(out.links[s]), ws.support(out.links[other]));
    let shared = a.iter().zip(b).take_while(|(i, j)| i == j).count();
    let ya = &out.y[out.y_start[s]..][..shared];
    let yb = &out.y[out.y_start[other]..][..shared];
    let size = 6 * out.n;
    // Three columns at a time stay in registers.
    for first in [0, 3] {
        let mut sum = [[0.0; 6]; 3];
        for (ya, yb) in ya.iter().zip(yb) {
            for (column, &b) in sum.iter_mut().zip(&yb[first..]) {
                for (x, &a) in column.iter_mut().zip(ya) {
                    *x += a * b;
                }
            }
        }
        for (c, column) in sum.iter().enumerate().map(|(c, column)| (6 * other + first + c, column)) {
            out.w[6 * s + size * c..][..6].copy_from_slice(column);
            // A block on the diagonal is its own mirror image.
            if s != other {
                column.iter().enumerate().for_each(|(r, x)| out.w[c + size * (6 * s + r)] = *x);
            }
        }
    }
}

/// Adds `M^-1 J^T w` to `out`, of length nv: accelerations for wrenches `w`, velocity jumps for
/// impulses. `w` has length 6F. Needs [`assemble`].
pub fn apply(ws: &Workspace, reduced: &mut Reduced, w: &[f64], out: &mut [f64]) {
    reduced.half.fill(0.0);
    for (s, link) in reduced.links.iter().enumerate() {
        let w = &w[6 * s..6 * s + 6];
        let y = &reduced.y[reduced.y_start[s]..reduced.y_start[s + 1]];
        for (y, &k) in y.iter().zip(ws.support(*link)) {
            reduced.half[k] += y.iter().zip(w).map(|(y, w)| y * w).sum::<f64>();
        }
    }
    factor::solve_l(&ws.factor, &mut reduced.half);
    for (out, x) in out.iter_mut().zip(&reduced.half) {
        *out += x;
    }
}

#[inline(always)]
fn write_in_floor_axes(to_floor: &Matrix3<f64>, m: &Motion, out: &mut [f64]) {
    out[..3].copy_from_slice((to_floor * m.linear).as_slice());
    out[3..6].copy_from_slice((to_floor * m.angular).as_slice());
}
