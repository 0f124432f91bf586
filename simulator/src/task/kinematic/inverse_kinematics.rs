//! Whole-body inverse kinematics: from sole poses, centre of mass and root orientation to joint
//! positions and velocities.
//!
//! ```text
//! e(q) = [ sole positions and rotations; centre of mass; root rotation ]  (goal less plan, rotations as rotation vectors)
//! dv   = z + W J^T (J W J^T + mu 1)^-1 (e - J z),   q := q (+) dv        until |e| is small
//! ```
//!
//! with J = -de/dv over the base's six velocities and the joints used, W the mobilities of these
//! velocities, z a preferred motion (only its component in the goal's null space remains) and mu a
//! damping that vanishes with the error, so that the iteration is Newton's near the goal and
//! bounded far from it. Sources: [Nakamura 1986, equation 21] (damping), [Sugihara 2011, equation
//! 19] (damping by the error).
//!
//! The base's velocities are unknowns like those of the joints: the motion of the root follows from
//! the same equations.

use super::{Goal, PlannedRobot, Rates};
use crate::dynamics::{Motion, crba, jacobian};
use crate::linalg::cholesky::Symmetric;
use crate::robot::Model;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

/// Greatest remaining error at convergence, m and rad.
const CLOSE: f64 = 1e-11;
/// Limit on iterations.
const MOST_STEPS: usize = 40;
/// Longest step of any unknown, m or rad.
const LONGEST: f64 = 0.2;
/// Limit on rounds of locking joints in one step.
const MOST_LOCKED: usize = 4;
/// Damping per squared error, and its minimum.
const DAMPING: (f64, f64) = (1e-2, 1e-14);

/// The joints that move, and the parts of the goal that count.
#[derive(Clone, Debug)]
pub struct Unknowns {
    /// Mobility W of each joint, 0 for fixed joints.
    pub mobility: Vec<f64>,
    /// Axes of the centre of mass that count: 3, or 2 for the horizontal ones.
    pub com_axes: usize,
    /// Whether the root's orientation counts.
    pub root: bool,
}

/// Error when a goal cannot be reached.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unreachable {
    /// Too far for the legs.
    #[error("the legs do not reach the goal: the remaining error is {error:.3e} m or rad")]
    TooFar {
        /// Greatest remaining error.
        error: f64,
    },
    /// A joint would leave its range.
    #[error("joint `{joint}` would need position {position:.4}, its range is {lower:.4} to {upper:.4}")]
    Limit {
        /// The joint.
        joint: String,
        /// Position it would need, rad or m.
        position: f64,
        /// Lower end of its range.
        lower: f64,
        /// Upper end of its range.
        upper: f64,
    },
}

/// The solver: scratch of fixed size.
#[derive(Clone, Debug)]
pub struct InverseKinematics {
    unknowns: Unknowns,
    /// Index into `v` and mobility of each unknown.
    columns: Vec<(usize, f64)>,
    /// W with 0 for locked unknowns.
    weights: Vec<f64>,
    rows: usize,
    /// J, row-major, `rows` x unknowns.
    jacobian: Vec<f64>,
    com_jacobian: Vec<f64>,
    system: Symmetric,
    error: Vec<f64>,
    /// Motion of all velocities, length nv.
    motion: Vec<f64>,
    /// Preferred motion z, length nv; zero unless set. [`InverseKinematics::advance`] overwrites
    /// the entries of locked joints.
    pub preferred: Vec<f64>,
    /// Unknowns that follow only their preferred motion.
    locked: Vec<bool>,
}

impl InverseKinematics {
    /// For a robot with a floating base and soles; `unknowns.mobility` has one number per joint.
    pub fn new(model: &Model, planned: &PlannedRobot, unknowns: Unknowns) -> Self {
        let nb = model.nb();
        let base = (0..nb).map(|k| (k, 1.0));
        let moved = unknowns.mobility.iter().enumerate().filter(|(_, w)| **w > 0.0);
        let columns: Vec<_> = base.chain(moved.map(|(j, w)| (nb + j, *w))).collect();
        let soles: usize = planned.feet.iter().map(|f| if f.flat { 6 } else { 3 }).sum();
        let rows = soles + unknowns.com_axes + if unknowns.root { 3 } else { 0 };
        InverseKinematics {
            jacobian: vec![0.0; rows * columns.len()],
            com_jacobian: vec![0.0; 3 * model.nv()],
            system: Symmetric::zeros(rows),
            error: vec![0.0; rows],
            motion: vec![0.0; model.nv()],
            preferred: vec![0.0; model.nv()],
            locked: vec![false; columns.len()],
            weights: vec![0.0; columns.len()],
            unknowns,
            columns,
            rows,
        }
    }

    /// Uses only the leg joints, equally mobile, and the whole goal.
    pub fn of_legs(model: &Model, planned: &PlannedRobot) -> Self {
        let mut mobility = vec![0.0; model.nj()];
        super::planned_robot::leg_joints(model).into_iter().for_each(|j| mobility[j] = 1.0);
        InverseKinematics::new(model, planned, Unknowns { mobility, com_axes: 3, root: true })
    }

    /// The joints that it moves.
    pub fn joints(&self) -> impl Iterator<Item = usize> + '_ {
        self.unknowns.mobility.iter().enumerate().filter(|(_, w)| **w > 0.0).map(|(j, _)| j)
    }

    /// Moves the plan to the goal and sets its velocity to that of the goal's rates.
    ///
    /// # Errors
    /// [`Unreachable`]; the plan is then in an intermediate posture.
    pub fn solve(
        &mut self,
        model: &Model,
        planned: &mut PlannedRobot,
        goal: &Goal,
        rates: &Rates,
    ) -> Result<(), Unreachable> {
        planned.update(model);
        let mut error = self.residual(planned, goal);
        for _ in 0..MOST_STEPS {
            if error < CLOSE {
                self.check_limits(model, planned)?;
                self.follow(model, planned, rates);
                return Ok(());
            }
            self.assemble(model, planned);
            self.step(DAMPING.0 * error * error);
            let longest = self.motion.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            let part = (LONGEST / longest).min(1.0);
            self.motion.iter_mut().for_each(|x| *x *= part);
            planned.state.displace(&self.motion);
            planned.update(model);
            error = self.residual(planned, goal);
        }
        Err(Unreachable::TooFar { error })
    }

    /// Takes one step towards the goal within `period` seconds, without iteration: the remaining
    /// error is of second order in the step. Joints stop at their limits and the others compensate.
    /// The plan's velocity is that of the step.
    pub fn advance(&mut self, model: &Model, planned: &mut PlannedRobot, goal: &Goal, period: f64) {
        planned.update(model);
        self.assemble(model, planned);
        self.locked.fill(false);
        for _ in 0..MOST_LOCKED {
            let error = self.residual(planned, goal);
            self.step(DAMPING.0 * error * error);
            if !self.lock(model, planned) {
                break;
            }
        }
        self.locked.fill(false);
        planned.state.displace(&self.motion);
        for (joint, q) in model.joints.iter().zip(&mut planned.state.joints) {
            // A joint may exceed its limit by rounding, or if too many others are at their limits.
            *q = q.max(joint.lower).min(joint.upper);
        }
        planned.state.v.iter_mut().zip(&self.motion).for_each(|(v, d)| *v = d / period);
        planned.update(model);
    }

    /// Locks joints that the motion takes beyond a limit at that limit. Returns whether there are
    /// any.
    fn lock(&mut self, model: &Model, planned: &PlannedRobot) -> bool {
        let nb = model.nb();
        let mut any = false;
        for (c, &(k, _)) in self.columns.iter().enumerate().filter(|(_, (k, _))| *k >= nb) {
            let (joint, q) = (&model.joints[k - nb], planned.state.joints[k - nb]);
            let there = (q + self.motion[k]).max(joint.lower).min(joint.upper);
            if !self.locked[c] && there != q + self.motion[k] {
                self.locked[c] = true;
                self.preferred[k] = there - q;
                any = true;
            }
        }
        any
    }

    /// One velocity step: sets the plan's velocity so that its goal moves with `rates`.
    pub fn follow(&mut self, model: &Model, planned: &mut PlannedRobot, rates: &Rates) {
        self.assemble(model, planned);
        self.fill(planned, |s| rates.soles[s], rates.com, rates.root);
        self.step(0.0);
        planned.state.v.copy_from_slice(&self.motion);
    }

    /// Checks that all joints used are within their ranges.
    ///
    /// # Errors
    /// The first joint that is not.
    pub fn check_limits(&self, model: &Model, planned: &PlannedRobot) -> Result<(), Unreachable> {
        let outside = |&j: &usize| {
            let (joint, q) = (&model.joints[j], planned.state.joints[j]);
            q < joint.lower - CLOSE || q > joint.upper + CLOSE
        };
        match self.joints().find(outside) {
            Some(j) => {
                let joint = &model.joints[j];
                Err(Unreachable::Limit {
                    joint: joint.name.clone(),
                    position: planned.state.joints[j],
                    lower: joint.lower,
                    upper: joint.upper,
                })
            }
            None => Ok(()),
        }
    }

    /// Computes the error and returns its greatest component.
    fn residual(&mut self, planned: &PlannedRobot, goal: &Goal) -> f64 {
        let turn = |to: &UnitQuaternion<f64>, from: &UnitQuaternion<f64>| (to * from.inverse()).scaled_axis();
        let apart = |to: &Isometry3<f64>, from: &Isometry3<f64>| {
            Motion::new(to.translation.vector - from.translation.vector, turn(&to.rotation, &from.rotation))
        };
        let (com, root) = (goal.com - planned.com(), turn(&goal.root, &planned.state.rotation));
        self.fill(planned, |s| apart(&goal.soles[s], &planned.sole(s)), com, root);
        self.error.iter().fold(0.0, |m: f64, x| m.max(x.abs()))
    }

    /// Assembles the right-hand side.
    fn fill(&mut self, planned: &PlannedRobot, sole: impl Fn(usize) -> Motion, com: Vector3<f64>, root: Vector3<f64>) {
        let mut at = 0;
        let mut put = |x: &[f64]| {
            self.error[at..at + x.len()].copy_from_slice(x);
            at += x.len();
        };
        for (s, foot) in planned.feet.iter().enumerate() {
            let m = sole(s);
            put(m.linear.as_slice());
            if foot.flat {
                put(m.angular.as_slice());
            }
        }
        put(&com.as_slice()[..self.unknowns.com_axes]);
        if self.unknowns.root {
            put(root.as_slice());
        }
    }

    /// Assembles J.
    fn assemble(&mut self, model: &Model, planned: &mut PlannedRobot) {
        crba::mass_matrix(model, &mut planned.ws);
        jacobian::center_of_mass(&planned.ws, &mut self.com_jacobian);
        let n = self.columns.len();
        self.jacobian.fill(0.0);
        let mut row = 0;
        for foot in &planned.feet {
            let point = planned.ws.point(foot.link, &foot.center);
            let support = planned.ws.support(foot.link);
            for (c, &(k, _)) in self.columns.iter().enumerate().filter(|(_, (k, _))| support.contains(k)) {
                let m = jacobian::column(&planned.ws, k, &point);
                let parts = m.linear.iter().chain(m.angular.iter()).take(if foot.flat { 6 } else { 3 });
                parts.enumerate().for_each(|(r, x)| self.jacobian[(row + r) * n + c] = *x);
            }
            row += if foot.flat { 6 } else { 3 };
        }
        for (c, &(k, _)) in self.columns.iter().enumerate() {
            for a in 0..self.unknowns.com_axes {
                self.jacobian[(row + a) * n + c] = self.com_jacobian[3 * k + a];
            }
        }
        row += self.unknowns.com_axes;
        if self.unknowns.root {
            (0..3).for_each(|a| self.jacobian[(row + a) * n + 3 + a] = 1.0);
        }
    }

    /// `motion = z + W J^T (J W J^T + mu 1)^-1 (error - J z)`.
    fn step(&mut self, mu: f64) {
        let n = self.columns.len();
        for ((weight, locked), (_, w)) in self.weights.iter_mut().zip(&self.locked).zip(&self.columns) {
            *weight = if *locked { 0.0 } else { *w };
        }
        let row = |i: usize| &self.jacobian[i * n..(i + 1) * n];
        for i in 0..self.rows {
            for j in 0..=i {
                let products = row(i).iter().zip(row(j)).zip(&self.weights).map(|((x, y), w)| w * x * y);
                self.system.entries[i * self.rows + j] = products.sum();
            }
            self.system.entries[i * self.rows + i] += mu.max(DAMPING.1);
            let along = row(i).iter().zip(&self.columns).map(|(x, (k, _))| x * self.preferred[*k]);
            self.error[i] -= along.sum::<f64>();
        }
        self.motion.copy_from_slice(&self.preferred);
        if !self.system.factorize() {
            return;
        }
        self.system.solve(&mut self.error);
        for (c, (&(k, _), w)) in self.columns.iter().zip(&self.weights).enumerate() {
            let sum: f64 = (0..self.rows).map(|i| self.jacobian[i * n + c] * self.error[i]).sum();
            self.motion[k] += w * sum;
        }
    }
}
