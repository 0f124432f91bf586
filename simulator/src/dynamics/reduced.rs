//! The contact problem reduced to the contact frames: `a = a0 + W w` with
//!
//! ```text
//! W = J M^-1 J^T,   a0 = J M^-1 (tau - h) + Jdot v
//! ```
//!
//! for F contacts. M is block diagonal over the mechanisms, the robot first, and all vectors of
//! velocities are stacked in that order. A contact has a frame (axes with z along its normal, and a
//! reference point) and one or two sides: its motion is that of the first side's link at the
//! reference point, less that of the second side's link. Rows of a contact: acceleration p'' of the
//! reference point, then angular acceleration. `w` stacks the wrenches on the first sides: force, then
//! moment about the reference point. `tau` contains all generalised forces except those of contact.
//!
//! A sole (or another polygon fixed to a link) has one side, floor axes, and its centroid as reference
//! point. The contact of a pair of bodies has axes and reference point that its geometry gives; its
//! rows of `Jdot v` have the acceleration of the links' origins only, and the terms of points that move
//! belong to its vertices ([`crate::contact::model::problem::Vertex::bias`]).
//!
//! With M = L^T L and Y = L^-T J^T: W = Y^T Y and a0 = Y^T L^-T (tau - h) + Jdot v. A side's
//! columns of Y are nonzero on its support chain only, and two chains share a leading part, so both
//! are short contiguous sums.

mod blocks;
mod conditions;
mod responses;

use super::factor;
use super::jacobian::classical;
use super::spatial::Motion;
use super::workspace::Workspace;
use crate::robot::{LinkId, Model, Sole, SoleId};
use blocks::{Block, Term};
use conditions::Conditions;
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;

pub use responses::{add_efforts, add_point_row, advance, apply, free, load, multipliers};

/// The workspaces of all mechanisms of a problem.
#[derive(Clone, Copy)]
pub struct Mechanisms<'a> {
    /// The robot.
    pub robot: &'a Workspace,
    /// Objects, in the order of their velocities.
    pub objects: &'a [Workspace],
}

impl<'a> From<&'a Workspace> for Mechanisms<'a> {
    fn from(robot: &'a Workspace) -> Self {
        Mechanisms { robot, objects: &[] }
    }
}

impl<'a> Mechanisms<'a> {
    /// The workspace of mechanism `m`; 0 is the robot.
    #[inline(always)]
    pub fn get(&self, m: usize) -> &'a Workspace {
        if m == 0 { self.robot } else { &self.objects[m - 1] }
    }

    /// Number of mechanisms.
    pub fn number(&self) -> usize {
        1 + self.objects.len()
    }

    /// Number of velocities.
    pub fn nv(&self) -> usize {
        (0..self.number()).map(|m| self.get(m).nv()).sum()
    }
}

/// A link of a mechanism; mechanism 0 is the robot.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct BodyId {
    /// Mechanism.
    pub mechanism: usize,
    /// Link.
    pub link: LinkId,
}

/// A contact of the reduced problem.
#[derive(Clone, Copy, Debug)]
pub enum ContactFrame<'a> {
    /// A polygon fixed to a link of the robot, on the floor.
    Sole(&'a Sole),
    /// A pair of bodies; without the second one it is a contact with the world.
    Pair(BodyId, Option<BodyId>),
}

/// One side of a contact: a link whose motion counts with a sign.
#[derive(Clone, Debug)]
struct Side {
    body: BodyId,
    sign: f64,
    /// First entry in `y`; one per velocity of the link's support chain.
    start: usize,
    length: usize,
    /// First velocity of the mechanism.
    offset: usize,
}

/// The reduced problem of one evaluation, allocated once for a list of contacts.
#[derive(Clone, Debug)]
pub struct Reduced {
    /// Number of contacts F.
    pub n: usize,
    /// W, symmetric, 6F x 6F, stored whole: entry (i, j) at `i + 6F j`.
    pub w: Vec<f64>,
    /// Acceleration without contact wrenches, 6F.
    pub a0: Vec<f64>,
    /// J v, 6F.
    pub velocity: Vec<f64>,
    /// Reference points in the world, m, one per contact. Those of pairs are given by
    /// [`Reduced::set_frame`].
    pub reference: Vec<Vector3<f64>>,
    /// Contact axes in the world, one per contact.
    pub axes: Vec<Matrix3<f64>>,
    /// Velocities of the robot whose motion is prescribed, ascending; contact moves only the others.
    /// See [`assemble`].
    pub prescribed: Vec<usize>,
    /// Vertices relative to their sole's reference point, floor axes, m; one sole after the other,
    /// see [`Reduced::vertices`].
    pub arms: Vec<Vector3<f64>>,
    vertex_start: Vec<usize>,
    /// Soles' reference points in the links' internal frames; `None` for pairs.
    local: Vec<Option<Vector3<f64>>>,
    /// Vertices relative to their reference points in the links' internal frames, as `arms`.
    local_arms: Vec<Vector3<f64>>,
    /// Sides of all contacts, and the first of each.
    sides: Vec<Side>,
    side_start: Vec<usize>,
    /// Blocks of W that are not always zero, by contact, and the first of each contact.
    blocks: Vec<Block>,
    block_start: Vec<usize>,
    terms: Vec<Term>,
    /// Y: for each side and each velocity of its support chain, six numbers.
    y: Vec<[f64; 6]>,
    /// Position of the row of L of each of these velocities among its entries.
    rows: Vec<usize>,
    /// `L^-T (tau - h)` of all mechanisms, within the conditions of couplings and loops.
    half: Vec<f64>,
    /// Scratch for generalised forces, and for two at once.
    scratch: Vec<f64>,
    pair: Vec<[f64; 2]>,
    conditions: Conditions,
    /// First velocity of each mechanism, and the number of all.
    offsets: Vec<usize>,
}

impl Reduced {
    /// Allocates for the soles of a model.
    pub fn new(model: &Model, ws: &Workspace) -> Self {
        Self::of_contacts(model.soles.iter().map(ContactFrame::Sole), ws.into())
    }

    /// Allocates for these contacts.
    pub fn of_contacts<'a>(contacts: impl Iterator<Item = ContactFrame<'a>>, ws: Mechanisms) -> Self {
        let mut offsets = vec![0];
        (0..ws.number()).for_each(|m| offsets.push(offsets[m] + ws.get(m).nv()));
        let nv = offsets[ws.number()];
        let mut out = Reduced {
            n: 0,
            w: Vec::new(),
            a0: Vec::new(),
            velocity: Vec::new(),
            reference: Vec::new(),
            axes: Vec::new(),
            prescribed: Vec::with_capacity(ws.robot.nv()),
            arms: Vec::new(),
            vertex_start: vec![0],
            local: Vec::new(),
            local_arms: Vec::new(),
            sides: Vec::new(),
            side_start: vec![0],
            blocks: Vec::new(),
            block_start: vec![0],
            terms: Vec::new(),
            y: Vec::new(),
            rows: Vec::new(),
            half: vec![0.0; nv],
            scratch: vec![0.0; nv],
            pair: vec![[0.0; 2]; nv],
            conditions: Conditions::new(ws),
            offsets,
        };
        for contact in contacts {
            match contact {
                ContactFrame::Sole(sole) => {
                    let centroid = sole.centroid();
                    out.local_arms.extend(sole.vertices.iter().map(|vertex| vertex - centroid));
                    out.local.push(Some(centroid));
                    out.add_side(BodyId { mechanism: 0, link: sole.link }, 1.0, ws);
                }
                ContactFrame::Pair(first, second) => {
                    out.local.push(None);
                    out.add_side(first, 1.0, ws);
                    second.into_iter().for_each(|second| out.add_side(second, -1.0, ws));
                }
            }
            out.vertex_start.push(out.local_arms.len());
            out.side_start.push(out.sides.len());
            out.add_blocks(ws);
            out.n += 1;
        }
        let n = out.n;
        (out.w, out.a0, out.velocity) = (vec![0.0; 36 * n * n], vec![0.0; 6 * n], vec![0.0; 6 * n]);
        (out.reference, out.axes) = (vec![Vector3::zeros(); n], vec![Matrix3::identity(); n]);
        out.arms = vec![Vector3::zeros(); out.local_arms.len()];
        out.conditions.add_sides(out.sides.iter().map(|side| side.body.mechanism));
        out
    }

    fn add_side(&mut self, body: BodyId, sign: f64, ws: Mechanisms) {
        let of = ws.get(body.mechanism);
        let chain = of.coupled(body.link);
        self.rows.extend(of.support(body.link).iter().map(|&k| of.factor.pattern().start(k)));
        self.rows.resize(self.y.len() + chain.len(), 0);
        let offset = self.offsets[body.mechanism];
        self.sides.push(Side { body, sign, start: self.y.len(), length: chain.len(), offset });
        self.y.resize(self.y.len() + chain.len(), [0.0; 6]);
    }

    /// The same for other contacts, with the same prescribed velocities.
    pub fn with_contacts<'a>(&self, contacts: impl Iterator<Item = ContactFrame<'a>>, ws: Mechanisms) -> Self {
        Reduced { prescribed: self.prescribed.clone(), ..Self::of_contacts(contacts, ws) }
    }

    /// Sets axes and reference point of the contact of a pair.
    pub fn set_frame(&mut self, contact: usize, axes: &Matrix3<f64>, reference: &Vector3<f64>) {
        (self.axes[contact], self.reference[contact]) = (*axes, *reference);
    }

    /// Range of a sole's vertices in `arms`.
    #[inline(always)]
    pub fn vertex_range(&self, sole: SoleId) -> Range<usize> {
        self.vertex_start[sole.0]..self.vertex_start[sole.0 + 1]
    }

    /// A sole's vertices relative to its reference point, floor axes, m; none for pairs.
    #[inline(always)]
    pub fn vertices(&self, sole: SoleId) -> &[Vector3<f64>] {
        &self.arms[self.vertex_range(sole)]
    }

    /// The 6 x 6 block of W between two contacts: entry (r, c) at `[c][r]`.
    #[inline]
    pub fn block(&self, row: SoleId, column: SoleId) -> [[f64; 6]; 6] {
        let size = 6 * self.n;
        std::array::from_fn(|c| std::array::from_fn(|r| self.w[6 * row.0 + r + size * (6 * column.0 + c)]))
    }

    /// Makes all accelerations other than a number, where M could not be factorised.
    pub fn fail(&mut self) {
        self.half.fill(f64::NAN);
    }

    /// The links of a contact's sides.
    pub fn bodies(&self, contact: usize) -> impl Iterator<Item = BodyId> {
        self.sides[self.sides(contact)].iter().map(|side| side.body)
    }

    /// First velocity of mechanism `m`.
    pub fn offset(&self, m: usize) -> usize {
        self.offsets[m]
    }

    /// The velocities of mechanism `m`.
    fn mechanism(&self, m: usize) -> Range<usize> {
        self.offsets[m]..self.offsets[m + 1]
    }

    #[inline(always)]
    fn sides(&self, contact: usize) -> Range<usize> {
        self.side_start[contact]..self.side_start[contact + 1]
    }
}

/// Fills `out` for the states in the workspaces. `floor` turns floor axes into world axes; `tau` (all
/// mechanisms) is the generalised force of actuators, joint friction and external forces. Needs
/// [`super::prepare`], and the frames of pairs.
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
pub fn assemble<'a>(ws: impl Into<Mechanisms<'a>>, floor: &Matrix3<f64>, tau: &[f64], out: &mut Reduced) {
    let ws = ws.into();
    geometry(ws, floor, out);
    assemble_with_geometry(ws, tau, out);
}

/// As [`assemble`], where `out` has the [`geometry`] of the states in the workspaces already.
pub fn assemble_with_geometry<'a>(ws: impl Into<Mechanisms<'a>>, tau: &[f64], out: &mut Reduced) {
    let ws = ws.into();
    for m in 0..ws.number() {
        let (of, range) = (ws.get(m), out.mechanism(m));
        let half = &mut out.half[range.clone()];
        for ((half, tau), h) in half.iter_mut().zip(&tau[range]).zip(&of.bias) {
            *half = tau - h;
        }
        factor::solve_lt(&of.factor, half);
        if of.constraints.number() > 0 {
            out.conditions.constrain(m, of, half);
        }
    }
    for s in 0..out.n {
        for side in out.sides(s) {
            half_solve(ws, s, side, out);
        }
        free_motion(ws, s, out);
        remove_prescribed(ws, s, out);
        blocks::multiply(s, out);
    }
}

/// Poses and velocities of the contacts: the part of [`assemble`] that needs no forces. Needs
/// `kinematics::update`, and the frames of pairs.
pub fn geometry<'a>(ws: impl Into<Mechanisms<'a>>, floor: &Matrix3<f64>, out: &mut Reduced) {
    let ws = ws.into();
    let to_floor = floor.transpose();
    for s in 0..out.n {
        let Some(local) = out.local[s] else {
            relative_velocity(ws, s, out);
            continue;
        };
        let link = &ws.robot.links[out.sides[out.side_start[s]].body.link.0];
        let r = link.origin + link.rotation * local;
        out.reference[s] = ws.robot.position + r;
        out.axes[s] = *floor;
        let turn = to_floor * link.rotation;
        let range = out.vertex_range(SoleId(s));
        for (arm, local) in out.arms[range.clone()].iter_mut().zip(&out.local_arms[range]) {
            *arm = turn * local;
        }
        let velocity = Motion::new(link.velocity.at(&r), link.velocity.angular);
        write_in_axes(&to_floor, &velocity, &mut out.velocity[6 * s..6 * s + 6]);
    }
}

/// Velocity of the first side's link at the reference point of a pair, less that of the second's.
fn relative_velocity(ws: Mechanisms, s: usize, out: &mut Reduced) {
    let mut velocity = Motion::ZERO;
    for side in &out.sides[out.sides(s)] {
        let of = ws.get(side.body.mechanism);
        let twist = &of.links[side.body.link.0].velocity;
        let r = out.reference[s] - of.position;
        velocity += Motion::new(twist.at(&r), twist.angular).scaled(side.sign);
    }
    write_in_axes(&out.axes[s].transpose(), &velocity, &mut out.velocity[6 * s..6 * s + 6]);
}

/// Y of one side: its Jacobian columns, then L^-T along the support chain.
fn half_solve(ws: Mechanisms, s: usize, side_index: usize, out: &mut Reduced) {
    let to_contact = out.axes[s].transpose();
    let side = &out.sides[side_index];
    let of = ws.get(side.body.mechanism);
    let chain = of.support(side.body.link);
    let r = out.reference[s] - of.position;
    let y = &mut out.y[side.start..side.start + chain.len()];
    let (of_base, of_joints) = y.split_at_mut(of.nb.min(chain.len()));
    if let Some(of_base) = of_base.first_chunk_mut() {
        *of_base = base_columns(&to_contact, &r);
    }
    for (y, &k) in of_joints.iter_mut().zip(&chain[of_base.len()..]) {
        let axis = &of.axes[k];
        write_in_axes(&to_contact, &Motion::new(axis.at(&r), axis.angular), y);
    }
    if side.sign < 0.0 {
        y.iter_mut().flatten().for_each(|y| *y = -*y);
    }
    let rows = &out.rows[side.start..side.start + chain.len()];
    let l = of.factor.entries();
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
    if of.constraints.number() > 0 {
        let y = &mut out.y[side.start..side.start + side.length];
        // From the support chain to all velocities, of which it is an ascending part.
        y[chain.len()..].fill([0.0; 6]);
        for (e, &k) in chain.iter().enumerate().rev() {
            y.swap(e, k);
        }
        out.conditions.project(side_index, side.body.mechanism, &of.constraints, y);
    }
}

/// Jacobian columns of a floating base, whose axes are the unit vectors e_k: `(e_k, 0)`, then `(e_k x r, e_k)`.
#[inline(always)]
fn base_columns(to_contact: &Matrix3<f64>, r: &Vector3<f64>) -> [[f64; 6]; 6] {
    let [x, y, z] = [0, 1, 2].map(|k| Vector3::from(to_contact.column(k)));
    let column = |linear: Vector3<f64>, angular: Vector3<f64>| Motion::new(linear, angular).to_array();
    let still = Vector3::zeros();
    [
        column(x, still),
        column(y, still),
        column(z, still),
        column(z * r.y - y * r.z, x),
        column(x * r.z - z * r.x, y),
        column(y * r.x - x * r.y, z),
    ]
}

/// Rows of `a0`: Y^T L^-T (tau - h), and Jdot v from the links' accelerations at vdot = 0.
fn free_motion(ws: Mechanisms, s: usize, out: &mut Reduced) {
    let mut products = Motion::ZERO;
    for side in &out.sides[out.sides(s)] {
        let of = ws.get(side.body.mechanism);
        let link = &of.links[side.body.link.0];
        let r = out.reference[s] - of.position;
        products = match out.local[s] {
            Some(_) => classical(&link.drift, &link.velocity, &r),
            // Of the link's origin; that of points relative to it belongs to the vertices.
            None => {
                let origin = classical(&link.drift, &link.velocity, &link.origin);
                let turn = link.drift.angular.cross(&(r - link.origin));
                products + Motion::new(origin.linear + turn, link.drift.angular).scaled(side.sign)
            }
        };
    }
    let sides = out.sides(s);
    let a0 = &mut out.a0[6 * s..6 * s + 6];
    write_in_axes(&out.axes[s].transpose(), &products, a0);
    let mut sum: [f64; 6] = std::array::from_fn(|i| a0[i]);
    for side_index in sides {
        let side = &out.sides[side_index];
        if ws.get(side.body.mechanism).constraints.number() > 0 {
            sum.iter_mut().zip(&out.conditions.constrained[side_index]).for_each(|(a, x)| *a += x);
        }
        let y = &out.y[side.start..side.start + side.length];
        for (y, &k) in y.iter().zip(ws.get(side.body.mechanism).coupled(side.body.link)) {
            let half = out.half[side.offset + k];
            sum.iter_mut().zip(y).for_each(|(a, y)| *a += y * half);
        }
    }
    a0.copy_from_slice(&sum);
}

/// Removes the prescribed velocities of the robot from Y of one contact.
fn remove_prescribed(ws: Mechanisms, s: usize, out: &mut Reduced) {
    if out.prescribed.is_empty() {
        return;
    }
    for side in &out.sides[out.sides(s)] {
        if side.body.mechanism != 0 {
            continue;
        }
        let chain = ws.robot.coupled(side.body.link);
        for k in &out.prescribed {
            if let Ok(e) = chain.binary_search(k) {
                out.y[side.start + e] = [0.0; 6];
            }
        }
    }
}

#[inline(always)]
fn write_in_axes(to_contact: &Matrix3<f64>, m: &Motion, out: &mut [f64]) {
    out[..3].copy_from_slice((to_contact * m.linear).as_slice());
    out[3..6].copy_from_slice((to_contact * m.angular).as_slice());
}
