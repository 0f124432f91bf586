//! Joint commands from a goal, for the tasks that plan positions.

use super::{Goal, InverseKinematics, NotPlannable, PlannedRobot, Rates, Unreachable, feed_forward, planned_robot};
use crate::motion::minimum_jerk::minimum_jerk;
use crate::robot::Model;
use crate::task::{Command, Context};
use nalgebra::{UnitQuaternion, Vector2, Vector3};

/// The planned robot, its goal, and the inverse kinematics between them.
#[derive(Clone, Debug)]
pub struct PosturePlanner {
    /// The planned robot.
    pub planned: PlannedRobot,
    /// Its goal.
    pub goal: Goal,
    /// Velocity of the goal.
    pub rates: Rates,
    inverse: InverseKinematics,
    joints: Vec<usize>,
    /// Joints that get efforts: all that carry a sole.
    carrying: Vec<usize>,
    efforts: Vec<f64>,
    /// Centre of mass and root at the start.
    from: (Vector3<f64>, UnitQuaternion<f64>),
}

impl PosturePlanner {
    /// For a robot that [`planned_robot::check`] accepts; moves its leg joints.
    pub fn new(model: &Model) -> Self {
        let planned = PlannedRobot::new(model);
        let inverse = InverseKinematics::of_legs(model, &planned);
        let joints = inverse.joints().collect();
        let goal = planned.goal();
        let from = (goal.com, goal.root);
        let (carrying, efforts) = (planned_robot::carrying_joints(model), vec![0.0; model.nj()]);
        PosturePlanner {
            rates: Rates::zero(planned.feet.len()),
            planned,
            goal,
            inverse,
            joints,
            carrying,
            efforts,
            from,
        }
    }

    /// Starts from a command, with the present plan as the goal.
    ///
    /// # Errors
    /// A leg joint does not follow positions.
    pub fn begin(&mut self, context: &Context, command: &Command) -> Result<(), NotPlannable> {
        planned_robot::check_driven(context.model, command, &self.joints)?;
        self.planned.stand_as_commanded(context, command);
        self.goal = self.planned.goal();
        self.rates = Rates::zero(self.planned.feet.len());
        self.from = (self.goal.com, self.goal.root);
        Ok(())
    }

    /// Moves the goal's centre of mass and root from their start to `com` and `root`, `t` seconds
    /// into a minimum-jerk move of `duration` seconds.
    pub fn approach(&mut self, t: f64, duration: f64, com: Vector3<f64>, root: UnitQuaternion<f64>) {
        let (progress, rate) = minimum_jerk(t, duration);
        let shift = com - self.from.0;
        self.goal.com = self.from.0 + shift * progress;
        self.rates.com = shift * rate;
        let turn = (root * self.from.1.inverse()).scaled_axis();
        self.goal.root = UnitQuaternion::from_scaled_axis(turn * progress) * self.from.1;
        self.rates.root = turn * rate;
    }

    /// Writes the joint positions that meet the goal. Other joints keep their commands.
    ///
    /// # Errors
    /// [`Unreachable`]; the command is then unchanged.
    pub fn write_joints(&mut self, context: &Context, command: &mut Command) -> Result<(), Unreachable> {
        let model = context.model;
        for (j, q) in self.planned.state.joints.iter_mut().enumerate() {
            if !self.joints.contains(&j) {
                *q = command.position[j];
            }
        }
        self.inverse.solve(model, &mut self.planned, &self.goal, &self.rates)?;
        for &j in &self.joints {
            command.position[j] = self.planned.state.joints[j];
            command.velocity[j] = self.planned.state.v[model.nb() + j];
        }
        Ok(())
    }

    /// Blends the efforts of the carrying joints from their commands (`part` 0) to those of the
    /// motion (1), see [`feed_forward`]. Needs [`PosturePlanner::write_joints`].
    pub fn add_feed_forward(
        &mut self,
        context: &Context,
        command: &mut Command,
        acceleration: &Vector3<f64>,
        zmp: &Vector2<f64>,
        part: f64,
    ) {
        self.planned.update(context.model);
        let (planned, efforts) = (&mut self.planned, &mut self.efforts);
        feed_forward::efforts(context.model, planned, &context.gravity, acceleration, zmp, efforts);
        for &j in &self.carrying {
            command.effort[j] = (1.0 - part) * command.effort[j] + part * self.efforts[j];
        }
    }
}
