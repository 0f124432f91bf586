//! Bounds on the change of two bodies' distance by joint motion.
//!
//! Rotating joint k by dq moves each point that it carries by at most r |dq|, with r the greatest
//! distance of such a point from the joint's axis. The distance of two bodies changes by at most
//! the motion of one relative to the other. In any posture r is at most
//!
//! ```text
//! L_k = greatest distance of a corner from the carried body's link origin + offsets (and slides) of the links in between
//! ```
//!
//! and 1 for a sliding joint. About a given posture m, with the body's centre c and radius R and
//! the joints j between k and the body displaced from m by t_j, a smaller bound holds:
//!
//! ```text
//! r_k = |z_k x (c - o_k)| + R + sum over j of min(L_j, r_j) t_j,      |d(q) - d(m)| <= sum over k of min(L_k, r_k) t_k
//! ```
//!
//! One test of a posture thus proves a neighbourhood free.

use crate::collision::kinematics::LinkPose;
use crate::collision::{CollisionModel, Pair};
use crate::robot::{JointKind, LinkId, Model};
use nalgebra::Vector3;

/// One joint between the bodies of a pair.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Lever {
    pub joint: usize,
    /// L_k, m/rad or 1.
    pub length: f64,
    /// Whether it carries the second body.
    pub second: bool,
    slides: bool,
}

#[derive(Clone, Debug)]
struct Sphere {
    link: usize,
    center: Vector3<f64>,
    radius: f64,
}

/// The joints between the bodies of each pair: those that carry the first body, from the body
/// towards the root, then those of the second.
#[derive(Clone, Debug, Default)]
pub(super) struct Levers {
    all: Vec<Lever>,
    /// The levers of pair i are `all[first[i]..first[i + 1]]`.
    first: Vec<usize>,
    spheres: Vec<Sphere>,
    bodies: Vec<[usize; 2]>,
}

impl Levers {
    pub fn new(model: &Model, collision: &CollisionModel) -> Self {
        let (mut all, mut first) = (Vec::new(), vec![0]);
        for pair in &collision.pairs {
            all.extend(pair_levers(model, collision, pair));
            first.push(all.len());
        }
        let sphere = |body: &crate::collision::Body| {
            let corners = &body.polytope.vertices;
            let low = corners.iter().fold(Vector3::repeat(f64::INFINITY), |a, b| a.inf(b));
            let high = corners.iter().fold(Vector3::repeat(f64::NEG_INFINITY), |a, b| a.sup(b));
            let center = 0.5 * (low + high);
            let radius = corners.iter().map(|v| (v - center).norm()).fold(0.0, f64::max);
            Sphere { link: body.link.0, center, radius }
        };
        Levers {
            all,
            first,
            spheres: collision.bodies.iter().map(sphere).collect(),
            bodies: collision.pairs.iter().map(|p| p.bodies).collect(),
        }
    }

    pub fn of(&self, pair: usize) -> &[Lever] {
        &self.all[self.first[pair]..self.first[pair + 1]]
    }

    /// Number of levers of all pairs.
    pub fn count(&self) -> usize {
        self.all.len()
    }

    /// Greatest change of a pair's distance in any posture when each joint moves by `travel`, m.
    pub fn change(&self, pair: usize, travel: &[f64]) -> f64 {
        // A lever beyond an unlimited slide is infinite.
        let moving = self.of(pair).iter().filter(|lever| travel[lever.joint] > 0.0);
        moving.map(|lever| lever.length * travel[lever.joint]).sum()
    }

    /// Sets the entries of a pair in `radii`: for each lever the greatest distance of the carried
    /// body from the axis in a posture.
    pub fn measure(&self, pair: usize, poses: &[LinkPose], radii: &mut [f64]) {
        let bodies = self.bodies[pair].map(|b| &self.spheres[b]);
        let centers = bodies.map(|s| poses[s.link].point(&s.center));
        for (lever, radius) in self.of(pair).iter().zip(&mut radii[self.first[pair]..]) {
            let (pose, side) = (&poses[lever.joint + 1], usize::from(lever.second));
            let axis = pose.rotation.column(2);
            *radius = if lever.slides {
                1.0
            } else {
                axis.cross(&(centers[side] - pose.origin)).norm() + bodies[side].radius
            };
        }
    }

    /// Greatest change of a pair's distance when each joint moves by `travel` from the posture of
    /// `radii`, m.
    pub fn change_from(&self, pair: usize, radii: &[f64], travel: &[f64]) -> f64 {
        let (mut change, mut moved, mut second) = (0.0, 0.0, false);
        for (lever, radius) in self.of(pair).iter().zip(&radii[self.first[pair]..]) {
            if lever.second != second {
                (moved, second) = (0.0, true);
            }
            let t = travel[lever.joint];
            if t == 0.0 {
                continue;
            }
            let radius = if lever.slides { 1.0 } else { radius + moved };
            let part = lever.length.min(radius) * t;
            change += part;
            moved += part;
        }
        change
    }
}

/// For each joint the greatest change of any monitored pair's distance per motion of the joint, in
/// any posture, m/rad, or 1 for a sliding joint.
pub fn levers(model: &Model, collision: &CollisionModel) -> Vec<f64> {
    let mut greatest = vec![0.0f64; model.nj()];
    for lever in Levers::new(model, collision).all {
        greatest[lever.joint] = greatest[lever.joint].max(lever.length);
    }
    greatest
}

fn pair_levers(model: &Model, collision: &CollisionModel, pair: &Pair) -> Vec<Lever> {
    let mut all = Vec::new();
    for (k, body) in pair.bodies.into_iter().enumerate() {
        let body = &collision.bodies[body];
        // From the body's origin to its farthest corner.
        let mut length = body.polytope.vertices.iter().map(|v| v.norm()).fold(0.0, f64::max);
        let mut link = body.link;
        while let Some(parent) = model.links[link.0].parent {
            let j = link.0 - 1;
            let joint = &model.joints[j];
            let slides = joint.kind == JointKind::Prismatic;
            if pair.joints.iter().any(|joint| joint.0 == j) {
                all.push(Lever { joint: j, length: if slides { 1.0 } else { length }, second: k == 1, slides });
            }
            // Measured from the next joint.
            length += model.links[link.0].offset.norm();
            if slides {
                length += joint.lower.abs().max(joint.upper.abs());
            }
            link = LinkId(parent.0);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::{Detector, link_poses};
    use crate::random::Stream;

    #[test]
    fn an_unlimited_slide_at_rest_does_not_block() {
        let folder = tempfile::tempdir().expect("a folder");
        let inertial = "<inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>";
        let body = |name: &str| {
            format!(
                "<link name=\"{name}\">{inertial}<collision><geometry><box size=\"0.2 0.2 0.2\"/></geometry></collision></link>"
            )
        };
        let joint = |name: &str, kind: &str, parent: &str, child: &str, x: f64| {
            format!(
                "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>
                 <origin xyz=\"{x} 0 0\"/><axis xyz=\"0 0 1\"/><limit effort=\"1\" velocity=\"1\"/></joint>"
            )
        };
        let text = format!(
            "<robot name=\"r\">{}{}{}{}{}{}{}</robot>",
            body("root"),
            body("arm"),
            body("rail"),
            body("hand"),
            joint("turn", "continuous", "root", "arm", 0.5),
            joint("slide", "prismatic", "arm", "rail", 0.5),
            joint("twist", "continuous", "rail", "hand", 0.5)
        );
        let path = folder.path().join("r.urdf");
        std::fs::write(&path, text).expect("written");
        let mut robot = crate::robot::load(&path).expect("it is one");
        for joint in robot.model.joints.iter_mut().filter(|j| j.kind == JointKind::Prismatic) {
            (joint.lower, joint.upper) = (f64::NEG_INFINITY, f64::INFINITY);
        }
        let collision = CollisionModel::every_pair(&robot.model, &robot.self_collision);
        let levers = Levers::new(&robot.model, &collision);
        let mut poses = vec![LinkPose::IDENTITY; robot.model.links.len()];
        link_poses(&robot.model, &[0.0; 3], &mut poses);
        let mut radii = vec![0.0; levers.count()];
        let pair = collision.pairs.iter().position(|p| p.joints.len() == 3).expect("root and hand");
        levers.measure(pair, &poses, &mut radii);
        // The hand's corners are sqrt(0.03) from its middle, which is 1 m from the first axis.
        let near = 0.03f64.sqrt();
        assert!((levers.change_from(pair, &radii, &[0.1, 0.0, 0.0]) - 0.1 * (1.0 + near)).abs() < 1e-12);
        assert!((levers.change(pair, &[0.0, 0.0, 0.1]) - 0.1 * near).abs() < 1e-12);
        // Sliding by 0.2 m makes it longer by as much.
        assert!((levers.change_from(pair, &radii, &[0.1, 0.2, 0.0]) - (0.2 + 0.1 * (1.2 + near))).abs() < 1e-12);
    }

    #[test]
    fn distances_change_by_at_most_the_bound() {
        let robot = crate::robot::load(std::path::Path::new("../robots/cbi/cbi.toml")).expect("our own robot");
        let (model, mut r) = (&robot.model, Stream::new(5, &["levers"]));
        let collision = CollisionModel::every_pair(model, &robot.self_collision);
        let levers = Levers::new(model, &collision);
        let mut detector = Detector::new(&collision);
        let mut poses = vec![LinkPose::IDENTITY; model.links.len()];
        let mut radii = vec![0.0; levers.count()];
        let (mut tightest, mut coarse) = (0.0f64, 0.0f64);
        for step in [1e-3, 1e-2, 0.1, 1.0] {
            for _ in 0..100 {
                let q: Vec<f64> = model.joints.iter().map(|j| j.lower + (j.upper - j.lower) * r.unit()).collect();
                let one = r.below(model.nj() as u64) as usize;
                let moves_alone = r.below(2) == 0;
                let travel: Vec<f64> =
                    (0..model.nj()).map(|j| if moves_alone && j != one { 0.0 } else { step * r.unit() }).collect();
                let there: Vec<f64> =
                    q.iter().zip(&travel).map(|(q, t)| if r.below(2) == 0 { q + t } else { q - t }).collect();
                link_poses(model, &there, &mut poses);
                detector.set_poses(&collision, &poses);
                let far: Vec<f64> = detector.distances(&collision).iter().map(|p| p.distance).collect();
                link_poses(model, &q, &mut poses);
                detector.set_poses(&collision, &poses);
                let near: Vec<f64> = detector.distances(&collision).iter().map(|p| p.distance).collect();
                for pair in 0..collision.pairs.len() {
                    levers.measure(pair, &poses, &mut radii);
                    let bound = levers.change_from(pair, &radii, &travel);
                    assert!(bound <= levers.change(pair, &travel) * (1.0 + 1e-12));
                    // Distances are good to 1e-12 m apart and 1e-10 m in depth.
                    let change = (far[pair] - near[pair]).abs();
                    assert!(change <= bound + 1e-9, "{pair}: {change} {bound}");
                    if bound > 0.0 {
                        tightest = tightest.max(change / bound);
                        coarse = coarse.max(change / levers.change(pair, &travel));
                    }
                }
            }
        }
        // The bound is nearly attained.
        assert!(tightest > 0.9 && coarse > 0.7, "{tightest} {coarse}");
    }
}
