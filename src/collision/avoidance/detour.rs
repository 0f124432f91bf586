//! Method 4: an intermediate posture from which the way to the goal is free.
//!
//! At the first posture x of the wanted motion that is too near, with the gradient of the pair's distance d over the joints
//! that are stopped short of their goals (n the normal from A to B, a and b the nearest points, z_k and o_k axis and origin of joint k)
//!
//! ```text
//! g_k = n . (z_k x (b - o_k))  for a joint that carries B,   - n . (z_k x (a - o_k))  for one that carries A
//! ```
//!
//! and its unit vector u, the motion e still wanted is led past the obstacle and away from it,
//!
//! ```text
//! m = c + k (e - min(0, e . u) u) + w u,   e = goal - c
//! ```
//!
//! for several k and w, c being where the joints are. The first m that can be reached, and from which the goal can, becomes the
//! joints' target until they are there, until the direct way is free, or for [`PATIENCE`] cycles.

use super::avoider::Avoider;
use super::candidate::Robot;
use super::joint_path::JointPath;
use super::methods::soonest;
use crate::collision::Proximity;
use crate::motion::spline::TrajectoryPoint;
use crate::robot::JointKind;

/// Cycles for which a detour is followed.
const PATIENCE: u32 = 10;

/// Detours tried: (w, k), rad or m and of the way.
const TRIES: [(f64, f64); 8] =
    [(0.15, 1.0), (0.3, 1.0), (0.6, 1.0), (0.3, 0.5), (0.6, 0.5), (0.3, 0.0), (0.6, 0.0), (1.0, 0.0)];

/// Samples of the wanted motion among which the first too near one is looked for.
const SAMPLES: usize = 8;

/// A joint this near to its intermediate position is there, rad or m.
const THERE: f64 = 0.01;

/// An intermediate posture, and scratch to find one.
pub(super) struct Detour {
    posture: Vec<f64>,
    joints: Vec<bool>,
    left: u32,
    gradient: Vec<f64>,
    toward: Vec<f64>,
}

impl Detour {
    /// None yet.
    pub fn new(joints: usize) -> Self {
        let zero = vec![0.0; joints];
        Detour { posture: zero.clone(), joints: vec![false; joints], left: 0, gradient: zero.clone(), toward: zero }
    }

    /// Is it followed?
    pub fn is_on(&self) -> bool {
        self.left > 0
    }

    /// The direct way is free.
    pub fn end(&mut self) {
        self.left = 0;
    }
}

impl Avoider {
    /// Goes on with a detour, or looks for one around the pair `first` that is in the way.
    pub(super) fn go_around(&mut self, robot: Robot, first: usize) {
        if self.detour.is_on() {
            self.follow(robot);
        }
        if !self.detour.is_on() {
            self.search(robot, first);
        }
    }

    fn follow(&mut self, robot: Robot) {
        let Detour { posture, joints, left, .. } = &mut self.detour;
        *left -= 1;
        let arrived = |j: usize| !joints[j] || (self.candidate.anchor[j] - posture[j]).abs() < THERE;
        if (0..joints.len()).all(arrived) {
            *left = 0;
            return;
        }
        // Joints that are in the way only now stay, those that no longer are go where they are wanted.
        for ((marked, stopped), part) in self.marked.iter_mut().zip(&self.stopped).zip(joints) {
            *marked = *stopped && *part;
        }
        let reached = self.try_marked(robot, |avoider, j| avoider.path_to_rest(j, avoider.detour.posture[j]));
        if !reached || !self.goal_is_reachable(robot) {
            self.undo_marked();
            self.detour.end();
        }
    }

    fn search(&mut self, robot: Robot, pair: usize) {
        let n = self.stopped.len();
        self.mark_movable();
        self.detour.joints.copy_from_slice(&self.marked);
        if !self.find_gradient(robot, pair) {
            return;
        }
        let mut against = 0.0;
        for j in 0..n {
            let toward = if self.detour.joints[j] { self.goal[j] - self.candidate.anchor[j] } else { 0.0 };
            self.detour.toward[j] = toward;
            against += toward * self.detour.gradient[j];
        }
        let against = against.min(0.0);
        for (away, along) in TRIES {
            for j in 0..n {
                let (limits, u) = (&self.settings.limits[j], self.detour.gradient[j]);
                let step = along * (self.detour.toward[j] - against * u) + away * u;
                self.detour.posture[j] = (self.candidate.anchor[j] + step).clamp(limits.lower, limits.upper);
            }
            self.marked.copy_from_slice(&self.detour.joints);
            let reached = self.try_marked(robot, |avoider, j| avoider.path_to_rest(j, avoider.detour.posture[j]));
            if reached && self.goal_is_reachable(robot) {
                self.detour.left = PATIENCE;
                return;
            }
            self.undo_marked();
        }
    }

    /// Can the goal be reached from where the candidate ends?
    fn goal_is_reachable(&mut self, robot: Robot) -> bool {
        let (rate, begin) = (1.0 / self.settings.rate, self.candidate.begin);
        for (j, limits) in self.settings.limits.iter().enumerate() {
            let from = TrajectoryPoint { q: self.candidate.paths[j].rest(), v: 0.0, a: 0.0 };
            if self.candidate.uncontrolled[j] {
                self.continuation[j] = JointPath::resting(from.q);
                continue;
            }
            let target = TrajectoryPoint { q: self.goal[j], v: 0.0, a: 0.0 };
            let on = soonest(from, begin, rate, limits, |_| target);
            self.continuation[j] = on.unwrap_or(JointPath::resting(from.q));
        }
        self.candidate.is_free(robot, &self.continuation)
    }

    /// The unit gradient of a pair's distance over the joints to be moved where the wanted motion first comes too near; false when
    /// they cannot change it.
    fn find_gradient(&mut self, robot: Robot, pair: usize) -> bool {
        let nearest = self.first_too_near(robot, pair);
        let gradient = &mut self.detour.gradient;
        gradient.fill(0.0);
        let poses = self.candidate.prover.poses();
        for lever in robot.levers.of(pair).iter().filter(|l| self.detour.joints[l.joint]) {
            let pose = &poses[lever.joint + 1];
            let axis = pose.rotation.column(2).into_owned();
            let (point, sign) = if lever.second { (nearest.on_b, 1.0) } else { (nearest.on_a, -1.0) };
            let rate = match robot.model.joints[lever.joint].kind {
                JointKind::Prismatic => nearest.normal.dot(&axis),
                _ => nearest.normal.dot(&axis.cross(&(point - pose.origin))),
            };
            gradient[lever.joint] = sign * rate;
        }
        let norm = gradient.iter().map(|g| g * g).sum::<f64>().sqrt();
        gradient.iter_mut().for_each(|g| *g /= norm);
        norm > 1e-9
    }

    /// Nearest points of a pair at the first sample of the wanted motion within the margin, or else at the nearest one.
    fn first_too_near(&mut self, robot: Robot, pair: usize) -> Proximity {
        let end = self.proposed.iter().map(JointPath::end).fold(self.candidate.begin, f64::max);
        let mut nearest: Option<(f64, Proximity)> = None;
        for k in 1..=SAMPLES {
            let t = self.candidate.begin + (end - self.candidate.begin) * k as f64 / SAMPLES as f64;
            let found = self.candidate.proximity_at(robot, &self.proposed, t, pair);
            let nearer = nearest.is_none_or(|(_, n)| found.distance < n.distance);
            if nearer {
                nearest = Some((t, found));
            }
            if found.distance <= robot.margin {
                break;
            }
        }
        let (t, found) = nearest.expect("there are samples");
        // Poses are those of the last sample: go back to the nearest.
        self.candidate.proximity_at(robot, &self.proposed, t, pair);
        found
    }
}
