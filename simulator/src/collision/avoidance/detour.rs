//! Method 4: an intermediate posture from which the path to the goal is free.
//!
//! Let g be the gradient of the pair's distance at the first posture of the proposed motion that is
//! too near, over the joints that are stopped short of their goals (n the normal from A to B, a and
//! b the nearest points, z_k and o_k axis and origin of joint k),
//!
//! ```text
//! g_k = n . (z_k x (b - o_k))  for a joint that carries B,   - n . (z_k x (a - o_k))  for one that carries A
//! ```
//!
//! and u its unit vector. The remaining motion e is diverted past the obstacle and away from it,
//!
//! ```text
//! m = c + k (e - min(0, e . u) u) + w u,   e = goal - c
//! ```
//!
//! for several k and w, c being the current posture. The first m that can be reached, and from
//! which the goal can be reached, becomes the joints' target until they arrive, until the direct
//! path is free, or for [`PATIENCE`] cycles.

use super::candidate::Robot;
use super::joint_path::JointPath;
use super::planner::Planner;
use crate::collision::Proximity;
use crate::robot::JointKind;

/// Cycles for which a detour is followed.
const PATIENCE: u32 = 10;

/// Detours tried: (w, k), rad or m and relative.
const TRIES: [(f64, f64); 8] =
    [(0.15, 1.0), (0.3, 1.0), (0.6, 1.0), (0.3, 0.5), (0.6, 0.5), (0.3, 0.0), (0.6, 0.0), (1.0, 0.0)];

/// Samples of the proposed motion among which the first too near one is searched.
const SAMPLES: usize = 8;

/// A joint this near to its intermediate position has arrived, rad or m.
const ARRIVED: f64 = 0.01;

/// An intermediate posture, and scratch to find one.
pub(super) struct Detour {
    posture: Vec<f64>,
    joints: Vec<bool>,
    /// Remaining cycles; 0 when no detour is followed.
    remaining: u32,
    gradient: Vec<f64>,
    toward: Vec<f64>,
}

impl Detour {
    /// Without a detour.
    pub fn new(joints: usize) -> Self {
        let zero = vec![0.0; joints];
        Detour {
            posture: zero.clone(),
            joints: vec![false; joints],
            remaining: 0,
            gradient: zero.clone(),
            toward: zero,
        }
    }

    /// Whether a detour is followed.
    pub fn is_active(&self) -> bool {
        self.remaining > 0
    }

    /// Ends the detour: the direct path is free.
    pub fn end(&mut self) {
        self.remaining = 0;
    }

    /// Continues the detour, or searches one around the blocking pair `first`.
    pub fn pursue(&mut self, planner: &mut Planner, robot: Robot, first: usize) {
        if self.is_active() {
            self.follow(planner, robot);
        }
        if !self.is_active() {
            self.search(planner, robot, first);
        }
    }

    fn follow(&mut self, planner: &mut Planner, robot: Robot) {
        self.remaining -= 1;
        let arrived = |j: usize| !self.joints[j] || (planner.candidate.anchor[j] - self.posture[j]).abs() < ARRIVED;
        if (0..self.joints.len()).all(arrived) {
            self.remaining = 0;
            return;
        }
        // Joints stopped since the detour began stay; joints no longer stopped move to their goals.
        for ((marked, stopped), part) in planner.marked.iter_mut().zip(&planner.stopped).zip(&self.joints) {
            *marked = *stopped && *part;
        }
        if !self.leads_to_goal(planner, robot) {
            planner.undo_marked();
            self.end();
        }
    }

    fn search(&mut self, planner: &mut Planner, robot: Robot, pair: usize) {
        let n = planner.stopped.len();
        planner.mark_movable();
        self.joints.copy_from_slice(&planner.marked);
        if !self.find_gradient(planner, robot, pair) {
            return;
        }
        let mut against = 0.0;
        for j in 0..n {
            let toward = if self.joints[j] { planner.goal[j] - planner.candidate.anchor[j] } else { 0.0 };
            self.toward[j] = toward;
            against += toward * self.gradient[j];
        }
        let against = against.min(0.0);
        for (away, along) in TRIES {
            for j in 0..n {
                let (limits, u) = (&planner.settings.limits[j], self.gradient[j]);
                let step = along * (self.toward[j] - against * u) + away * u;
                self.posture[j] = (planner.candidate.anchor[j] + step).clamp(limits.lower, limits.upper);
            }
            planner.marked.copy_from_slice(&self.joints);
            if self.leads_to_goal(planner, robot) {
                self.remaining = PATIENCE;
                return;
            }
            planner.undo_marked();
        }
    }

    /// Tries the intermediate posture. Returns whether it can be reached and the goal can be
    /// reached from it.
    fn leads_to_goal(&self, planner: &mut Planner, robot: Robot) -> bool {
        planner.try_marked(robot, |planner, j| planner.path_to_rest(j, self.posture[j]))
            && planner.goal_is_reachable(robot)
    }

    /// Sets the unit gradient of a pair's distance over the joints of the detour, where the
    /// proposed motion first comes too near. Returns false if these joints cannot change the
    /// distance.
    fn find_gradient(&mut self, planner: &mut Planner, robot: Robot, pair: usize) -> bool {
        let nearest = first_too_near(planner, robot, pair);
        let gradient = &mut self.gradient;
        gradient.fill(0.0);
        let poses = planner.candidate.prover.poses();
        for lever in robot.levers.of(pair).iter().filter(|l| self.joints[l.joint]) {
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
}

/// Nearest points of a pair at the first sample of the proposed motion within the margin, or at the
/// nearest sample if there is none.
fn first_too_near(planner: &mut Planner, robot: Robot, pair: usize) -> Proximity {
    let (candidate, proposed) = (&mut planner.candidate, &planner.proposed);
    let begin = candidate.begin;
    let end = proposed.iter().map(JointPath::end).fold(begin, f64::max);
    let mut nearest: Option<(f64, Proximity)> = None;
    for k in 1..=SAMPLES {
        let t = begin + (end - begin) * k as f64 / SAMPLES as f64;
        let found = candidate.proximity_at(robot, proposed, t, pair);
        if nearest.is_none_or(|(_, n)| found.distance < n.distance) {
            nearest = Some((t, found));
        }
        if found.distance <= robot.margin {
            break;
        }
    }
    let (t, found) = nearest.expect("there are samples");
    // The poses are those of the last sample: restore those of the nearest one.
    candidate.proximity_at(robot, proposed, t, pair);
    found
}
