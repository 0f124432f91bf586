//! Distances of single pairs, with starts stored by the caller, for searches that drop pairs as
//! they proceed.

use super::gjk::{self, Nearest, Outcome, Warm};
use super::posed_bodies::PosedBodies;
use crate::collision::kinematics::LinkPose;
use crate::collision::spatial::Body;

/// Workspace of such a search.
#[derive(Clone, Debug)]
pub struct PairDistance(PosedBodies);

impl PairDistance {
    /// For these bodies.
    pub fn new(bodies: &[Body]) -> Self {
        Self(PosedBodies::new(bodies))
    }

    /// Moves the bodies to a posture; one pose per link.
    pub fn set_poses(&mut self, bodies: &[Body], poses: &[LinkPose]) {
        self.0.set_poses(bodies, poses);
    }

    /// Moves two bodies only.
    pub fn set_pair_poses(&mut self, bodies: &[Body], pair: [usize; 2], poses: &[LinkPose]) {
        pair.iter().for_each(|&i| self.0.set_body_pose(bodies, i, poses));
    }

    /// The distance of two bodies, m, if it is below `limit`; 0 when they overlap.
    pub fn below(&self, bodies: &[Body], pair: [usize; 2], warm: &mut Warm, limit: f64) -> Option<f64> {
        if f64::from(self.0.gap_squared(pair)) >= limit * limit {
            return None;
        }
        let [a, b] = self.0.posed(bodies, pair);
        let distance = match gjk::distance(&a, &b, warm, limit) {
            Outcome::Beyond => return None,
            Outcome::Apart { v, .. } => v.norm(),
            Outcome::Overlap { .. } => 0.0,
        };
        (distance < limit).then_some(distance)
    }

    /// The nearest points of two bodies; `None` when they overlap.
    pub fn points(&self, bodies: &[Body], pair: [usize; 2], warm: &mut Warm) -> Option<Nearest> {
        let [a, b] = self.0.posed(bodies, pair);
        match gjk::distance(&a, &b, warm, f64::INFINITY) {
            Outcome::Apart { v, simplex } => Some(gjk::nearest(&a, &b, &v, &simplex)),
            _ => None,
        }
    }

    /// Penetration depth of two overlapping bodies, m; `None` when they are apart.
    pub fn depth(&self, bodies: &[Body], pair: [usize; 2]) -> Option<f64> {
        let [a, b] = self.0.posed(bodies, pair);
        match gjk::distance(&a, &b, &mut Warm::COLD.clone(), 0.0) {
            Outcome::Overlap { simplex } => Some(super::epa::Epa::default().depth(&a, &b, &simplex).depth),
            _ => None,
        }
    }
}
