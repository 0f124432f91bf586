//! Searches for the pairs of bodies that can meet within the joint ranges, by random postures and
//! descents.
//!
//! Each joint is drawn at the lower end of its range in a quarter of the postures, at the upper end
//! in a quarter, and otherwise uniformly, since bodies far apart are closest at the ends. From the
//! closest posture of a pair, and from further random ones, descents follow the gradient of the
//! distance d with normal n from a, A's nearest point, to b, B's, within the ranges:
//!
//! ```text
//! dd/dq_k = n . (z_k x (b - o_k))  for a joint above B,   - n . (z_k x (a - o_k))  for one above A      (sliding: n . z_k)
//! ```
//!
//! A pair that never comes within [`Search::margin`] counts as unable to meet. This is evidence,
//! not proof.

use super::body::Body;
use super::link_tree::joints_between;
use crate::collision::detection::{Nearest, PairDistance, Warm};
use crate::collision::kinematics::{LinkPose, link_pose, link_poses};
use crate::random::Stream;
use crate::robot::{JointId, JointKind, LinkId, Model};

/// Effort of the search.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Search {
    /// Random postures.
    pub postures: usize,
    /// Descents for each remaining pair.
    pub descents: usize,
    /// Steps in each.
    pub steps: usize,
    /// Pairs that come this close can meet, m.
    pub margin: f64,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl Default for Search {
    fn default() -> Self {
        Self { postures: 1000, descents: 20, steps: 60, margin: 0.01, seed: 1 }
    }
}

/// The least distance found for each pair of bodies, m; for a pair that comes within the margin,
/// the first below it.
pub(super) fn closest_found(model: &Model, bodies: &[Body], pairs: &[[usize; 2]], search: &Search) -> Vec<f64> {
    let mut sampler = Sampler::new(model, search.seed, "reach");
    let mut descent =
        Descent { model, bodies, poses: vec![LinkPose::IDENTITY; model.links.len()], near: PairDistance::new(bodies) };
    let mut found: Vec<Found> = pairs
        .iter()
        .map(|&bodies| Found { bodies, distance: f64::INFINITY, posture: model.home.clone(), warm: Warm::COLD })
        .collect();
    for k in 0..=search.postures {
        let q = if k == 0 { model.home.clone() } else { sampler.posture(model) };
        descent.set_posture(&q);
        for f in found.iter_mut().filter(|f| f.distance > search.margin) {
            if descent.improves(f) {
                f.posture.copy_from_slice(&q);
            }
        }
    }
    for f in found.iter_mut().filter(|f| f.distance > search.margin) {
        // The poses of common ancestors of both bodies are arbitrary.
        descent.poses.fill(LinkPose::IDENTITY);
        let chain = Chain::new(model, f.bodies.map(|b| bodies[b].link));
        for k in 0..search.descents {
            let start = if k == 0 { f.posture.clone() } else { sampler.posture(model) };
            descend(&mut descent, &sampler.ranges, f, start, &chain, search);
        }
    }
    found.iter().map(|f| f.distance).collect()
}

/// The joints between two links.
struct Chain {
    joints: Vec<JointId>,
    /// For each: 1 when it moves the second link, -1 when it moves the first.
    sign: Vec<f64>,
}

impl Chain {
    fn new(model: &Model, [a, b]: [LinkId; 2]) -> Self {
        let joints = joints_between(model, a, b);
        let above_b = joints_between(model, LinkId(0), b);
        let sign = joints.iter().map(|j| if above_b.contains(j) { 1.0 } else { -1.0 }).collect();
        Self { joints, sign }
    }
}

struct Found {
    bodies: [usize; 2],
    distance: f64,
    posture: Vec<f64>,
    warm: Warm,
}

/// One posture under descent.
struct Descent<'a> {
    model: &'a Model,
    bodies: &'a [Body],
    poses: Vec<LinkPose>,
    near: PairDistance,
}

impl Descent<'_> {
    fn set_posture(&mut self, q: &[f64]) {
        link_poses(self.model, q, &mut self.poses);
        self.near.set_poses(self.bodies, &self.poses);
    }

    fn set_chain(&mut self, chain: &Chain, q: &[f64]) {
        for joint in &chain.joints {
            link_pose(self.model, joint.0 + 1, q[joint.0], &mut self.poses);
        }
    }

    /// The nearest points of a pair with the joints between its bodies at `q`; `None` when they
    /// overlap.
    fn nearest_points(&mut self, f: &mut Found, chain: &Chain, q: &[f64]) -> Option<Nearest> {
        self.set_chain(chain, q);
        self.near.set_pair_poses(self.bodies, f.bodies, &self.poses);
        self.near.points(self.bodies, f.bodies, &mut f.warm)
    }

    /// Stores the distance of the pair if it is the least so far. Returns whether it is.
    fn improves(&mut self, f: &mut Found) -> bool {
        let found = self.near.below(self.bodies, f.bodies, &mut f.warm, f.distance);
        f.distance = found.unwrap_or(f.distance);
        found.is_some()
    }
}

/// Moves the joints between the two bodies from `q` on to bring them closer.
fn descend(descent: &mut Descent, ranges: &[[f64; 2]], f: &mut Found, mut q: Vec<f64>, chain: &Chain, search: &Search) {
    let mut next = q.clone();
    let Some(mut here) = descent.nearest_points(f, chain, &q) else { return f.distance = 0.0 };
    let mut step = 0.3;
    for _ in 0..search.steps {
        f.distance = f.distance.min(here.distance);
        if f.distance <= search.margin || step < 1e-4 {
            return;
        }
        // Each joint moves in proportion to its range, the steepest by `step` of it.
        let slopes = chain.joints.iter().zip(&chain.sign).map(|(joint, sign)| {
            let pose = &descent.poses[joint.0 + 1];
            let (z, point) = (pose.rotation.column(2).into_owned(), if *sign > 0.0 { here.on_b } else { here.on_a });
            let rate = match descent.model.joints[joint.0].kind {
                JointKind::Prismatic => here.normal.dot(&z),
                _ => here.normal.dot(&z.cross(&(point - pose.origin))),
            };
            sign * rate * (ranges[joint.0][1] - ranges[joint.0][0])
        });
        let slopes: Vec<f64> = slopes.collect();
        let can_move = |(joint, slope): (&JointId, &f64)| {
            let end = ranges[joint.0][usize::from(*slope < 0.0)];
            if q[joint.0] == end { 0.0 } else { slope.abs() }
        };
        let steepest = chain.joints.iter().zip(&slopes).map(can_move).fold(0.0, f64::max);
        if steepest == 0.0 {
            return;
        }
        for (joint, slope) in chain.joints.iter().zip(&slopes) {
            let [lower, upper] = ranges[joint.0];
            next[joint.0] = (q[joint.0] - step * (upper - lower) * slope / steepest).clamp(lower, upper);
        }
        match descent.nearest_points(f, chain, &next) {
            None => return f.distance = 0.0,
            Some(there) if there.distance < here.distance => {
                (here, step) = (there, (1.5 * step).min(0.5));
                q.copy_from_slice(&next);
            }
            Some(_) => {
                step *= 0.4;
                // The poses are those of the final posture.
                descent.set_chain(chain, &q);
            }
        }
    }
}

/// Draws postures within the joint ranges.
pub(super) struct Sampler {
    stream: Stream,
    ranges: Vec<[f64; 2]>,
}

impl Sampler {
    pub(super) fn new(model: &Model, seed: u64, purpose: &str) -> Self {
        let ranges = model.joints.iter().zip(&model.home).map(|(joint, home)| {
            // A continuous joint is drawn within one turn; an unlimited sliding joint, within a
            // metre of home.
            let reach = if joint.kind == JointKind::Prismatic { 1.0 } else { std::f64::consts::PI };
            let end = |limit: f64, otherwise: f64| if limit.is_finite() { limit } else { otherwise };
            [end(joint.lower, home - reach), end(joint.upper, home + reach)]
        });
        Self { stream: Stream::new(seed, &["collision", purpose]), ranges: ranges.collect() }
    }

    /// A random posture.
    pub(super) fn posture(&mut self, model: &Model) -> Vec<f64> {
        let mut q = model.home.clone();
        for (q, [lower, upper]) in q.iter_mut().zip(&self.ranges) {
            *q = match self.stream.below(4) {
                0 => *lower,
                1 => *upper,
                _ => lower + (upper - lower) * self.stream.unit(),
            };
        }
        q
    }
}
