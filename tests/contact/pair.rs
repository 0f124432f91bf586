//! Two bodies, each on a sole, connected by a joint: W and b from the bodies alone.
//!
//! Free bodies have `W = diag(W_1, W_2)`. A joint keeps `C m = 0` (relative motion of the two
//! bodies at the anchor) by forces `-C^T l`, so that (Gauss) `m = P (b + W w)` with
//! `P = 1 - W C^T (C W C^T)^-1 C`.

use super::rigid::{Rigid, body_on, triple};
use nalgebra::{DMatrix, DVector, Vector3};
use proptest::prelude::*;
use stiction::contact::model::problem::{Level, Problem};

/// Connection of two bodies.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Joint {
    /// No connection.
    Apart,
    /// A massless rod between one point of each.
    Rod,
    /// One common point.
    Ball,
    /// One common axis.
    Hinge,
    /// Two soles on one rigid body.
    Weld,
}

/// Two bodies. The reference of the second sole is at `apart` from the first, the joint at
/// `anchor`.
#[derive(Clone, Debug)]
pub struct Pair {
    pub bodies: [Rigid; 2],
    pub apart: Vector3<f64>,
    pub anchor: Vector3<f64>,
    pub axis: Vector3<f64>,
    pub joint: Joint,
}

impl Pair {
    /// Matrix C of the module page, one row of 12 per condition.
    fn conditions(&self) -> DMatrix<f64> {
        let row = |linear: Vector3<f64>, angular: Vector3<f64>| {
            // Motion of the anchor along `linear` plus rotation along `angular`, of the first body
            // less the second.
            let mut row = Vec::with_capacity(12);
            for (sign, arm) in [(1.0, self.anchor), (-1.0, self.anchor - self.apart)] {
                row.extend_from_slice((linear * sign).as_slice());
                row.extend_from_slice(((arm.cross(&linear) + angular) * sign).as_slice());
            }
            row
        };
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        let zero = Vector3::zeros();
        let points = axes.iter().map(|a| row(*a, zero));
        let rows: Vec<Vec<f64>> = match self.joint {
            Joint::Apart => vec![],
            Joint::Rod => vec![row(self.axis.normalize(), zero)],
            Joint::Ball => points.collect(),
            Joint::Hinge => {
                let helper = if self.axis.x.abs() < 0.5 * self.axis.norm() { axes[0] } else { axes[1] };
                let one = self.axis.cross(&helper).normalize();
                let two = self.axis.cross(&one).normalize();
                points.chain([row(zero, one), row(zero, two)]).collect()
            }
            Joint::Weld => points.chain(axes.iter().map(|a| row(zero, *a))).collect(),
        };
        DMatrix::from_fn(rows.len(), 12, |i, j| rows[i][j])
    }

    /// The problem of both soles for loads at the centres of mass, at rest on the floor.
    pub fn problem(&self, level: Level, loads: &[(Vector3<f64>, Vector3<f64>); 2]) -> Problem {
        let parts = [0, 1].map(|i| self.bodies[i].problem(level, &loads[i].0, &loads[i].1));
        let mut w = DMatrix::zeros(12, 12);
        let mut b = DVector::zeros(12);
        for (i, part) in parts.iter().enumerate() {
            for r in 0..6 {
                b[6 * i + r] = part.b[r];
                (0..6).for_each(|c| w[(6 * i + r, 6 * i + c)] = part.w[6 * r + c]);
            }
        }
        let mut p = Problem::new(&[self.bodies[0].sole.len(), self.bodies[1].sole.len()]);
        p.level = level;
        p.scale = parts[0].scale + parts[1].scale;
        p.soles = parts.map(|part| part.soles[0].clone()).into();
        p.soles[1].body = usize::from(self.joint != Joint::Weld);
        p.soles[1].position = self.apart;
        self.join(&w, &mut b);
        let joined = self.joined(&w);
        for r in 0..12 {
            p.b[r] = b[r];
            (0..12).for_each(|c| p.w[12 * r + c] = 0.5 * (joined[(r, c)] + joined[(c, r)]));
        }
        p
    }

    fn multipliers(&self, w: &DMatrix<f64>, right: &DMatrix<f64>) -> DMatrix<f64> {
        let c = self.conditions();
        let inner = &c * w * c.transpose();
        // A welded pair has six independent conditions, none redundant.
        w * c.transpose() * inner.cholesky().expect("independent conditions").solve(&(&c * right))
    }

    fn joined(&self, w: &DMatrix<f64>) -> DMatrix<f64> {
        if self.joint == Joint::Apart { w.clone() } else { w - self.multipliers(w, w) }
    }

    fn join(&self, w: &DMatrix<f64>, motion: &mut DVector<f64>) {
        if self.joint != Joint::Apart {
            let m = DMatrix::from_column_slice(12, 1, motion.as_slice());
            *motion -= self.multipliers(w, &m).column(0);
        }
    }

    /// Velocities before an impact: both centres of mass with `com`, angular velocities `spin`,
    /// projected onto the joint's constraint.
    pub fn falling(&self, com: &[Vector3<f64>; 2], spin: &[Vector3<f64>; 2]) -> Problem {
        let rest = [(Vector3::zeros(), Vector3::zeros()); 2];
        let mut p = self.problem(Level::Velocity, &rest);
        let free = [0, 1].map(|i| self.bodies[i].problem(Level::Velocity, &rest[i].0, &rest[i].1));
        let mut w = DMatrix::zeros(12, 12);
        for (i, part) in free.iter().enumerate() {
            (0..36).for_each(|n| w[(6 * i + n / 6, 6 * i + n % 6)] = part.w[n]);
        }
        let mut b = DVector::from_iterator(12, (0..2).flat_map(|i| self.bodies[i].motion(&com[i], &spin[i])));
        self.join(&w, &mut b);
        p.b.copy_from_slice(b.as_slice());
        let before = p.b.clone();
        for s in 0..2 {
            for i in 0..p.soles[s].vertices.len() {
                p.soles[s].vertices[i].velocity = p.vertex_motion(&before, s, i);
            }
        }
        p
    }

    /// Kinetic energy of both bodies.
    pub fn energy(&self, motion: &[f64]) -> f64 {
        self.bodies[0].energy(&motion[..6]) + self.bodies[1].energy(&motion[6..])
    }

    /// The same pair with its soles in the opposite order.
    pub fn swapped(&self) -> Pair {
        let [a, b] = self.bodies.clone();
        Pair { bodies: [b, a], apart: -self.apart, anchor: self.anchor - self.apart, ..self.clone() }
    }
}

/// Every joint.
pub const JOINTS: &[Joint] = &[Joint::Apart, Joint::Rod, Joint::Ball, Joint::Hinge, Joint::Weld];

/// Pairs on soles of 1 to 8 vertices, with one of these joints.
pub fn pair(joints: &'static [Joint]) -> impl Strategy<Value = Pair> {
    let joint = proptest::sample::select(joints);
    ([body_on(1, 8), body_on(1, 8)], triple(), triple(), triple(), joint).prop_map(
        |(bodies, apart, anchor, axis, joint)| {
            let side = if apart.x < 0.0 { -1.0 } else { 1.0 };
            Pair {
                bodies,
                apart: Vector3::new(0.25 * side + 0.1 * apart.x, 0.2 * apart.y, 0.0),
                anchor: Vector3::new(0.2 * anchor.x, 0.2 * anchor.y, 0.3 + 0.2 * anchor.z),
                axis: if axis.norm() > 0.1 { axis } else { Vector3::y() },
                joint,
            }
        },
    )
}
