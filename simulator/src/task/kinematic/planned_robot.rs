//! The robot as planned by a task: a state with its kinematics and soles.

use super::Goal;
use crate::dynamics::{State, Workspace, body, kinematics};
use crate::math;
use crate::robot::{Base, DriveMode, LinkId, Model, SoleId};
use crate::task::{Command, Context};
use nalgebra::{Isometry3, Rotation3, UnitQuaternion, Vector3};

/// Error when a robot cannot be planned by its soles and centre of mass.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NotPlannable {
    /// The base is fixed.
    #[error("the robot `{0}` has a fixed base")]
    FixedBase(String),
    /// There is no sole to stand on.
    #[error("the robot `{0}` has no sole")]
    NoSole(String),
    /// The task requires two feet on separate legs.
    #[error("the robot `{robot}` has {soles} soles; the task requires 2, on separate legs")]
    NotTwoFeet {
        /// Name of the robot.
        robot: String,
        /// Number of its soles.
        soles: usize,
    },
    /// A joint that must follow positions does not.
    #[error("the joint `{0}` does not follow positions: the mode of its drive is not `position` or `kinematic`")]
    NotDriven(String),
}

/// A sole as a target of inverse kinematics.
#[derive(Clone, Debug)]
pub struct Foot {
    /// Index of the sole in the model.
    pub sole: SoleId,
    /// The link that carries it.
    pub link: LinkId,
    /// Centroid of its vertices in the link's internal frame, m.
    pub center: Vector3<f64>,
    /// Whether its orientation counts: it has more than one vertex.
    pub flat: bool,
}

/// A planned state with its kinematics.
#[derive(Clone, Debug)]
pub struct PlannedRobot {
    /// Configuration and velocity.
    pub state: State,
    /// Kinematics of `state` after [`PlannedRobot::update`].
    pub ws: Workspace,
    /// The soles.
    pub feet: Vec<Foot>,
}

/// Leg joints: those that move some sole, but not all of several. Joints that carry all soles (a
/// waist above the legs of a robot whose root is its torso) do not count.
pub fn leg_joints(model: &Model) -> Vec<usize> {
    let ws = Workspace::new(model);
    let nb = model.nb();
    let moves = |j: usize| model.soles.iter().filter(|s| ws.support(s.link).contains(&(nb + j))).count();
    let most = if model.soles.len() > 1 { model.soles.len() - 1 } else { 1 };
    (0..model.nj()).filter(|&j| (1..=most).contains(&moves(j))).collect()
}

/// Joints that move some sole: the legs and the joints that carry them.
pub fn carrying_joints(model: &Model) -> Vec<usize> {
    let ws = Workspace::new(model);
    let nb = model.nb();
    let carries = |j: usize| model.soles.iter().any(|s| ws.support(s.link).contains(&(nb + j)));
    (0..model.nj()).filter(|&j| carries(j)).collect()
}

/// Checks that a robot can be planned.
///
/// # Errors
/// A fixed base or no sole.
pub fn check(model: &Model) -> Result<(), NotPlannable> {
    if model.base == Base::Fixed {
        return Err(NotPlannable::FixedBase(model.name.clone()));
    }
    if model.soles.is_empty() {
        return Err(NotPlannable::NoSole(model.name.clone()));
    }
    Ok(())
}

/// Checks for two soles on separate legs.
///
/// # Errors
/// As [`check`], or another number of legs.
pub fn check_biped(model: &Model) -> Result<(), NotPlannable> {
    check(model)?;
    if model.soles.len() != 2 || model.soles[0].link == model.soles[1].link {
        return Err(NotPlannable::NotTwoFeet { robot: model.name.clone(), soles: model.soles.len() });
    }
    Ok(())
}

/// Checks that the joints of a command follow positions.
///
/// # Errors
/// The first joint that does not.
pub fn check_driven(model: &Model, command: &Command, joints: &[usize]) -> Result<(), NotPlannable> {
    let idle = |j: &&usize| !matches!(command.mode[**j], DriveMode::Position | DriveMode::Kinematic);
    match joints.iter().find(idle) {
        Some(&j) => Err(NotPlannable::NotDriven(model.joints[j].name.clone())),
        None => Ok(()),
    }
}

impl PlannedRobot {
    /// In the home posture, on all soles.
    pub fn new(model: &Model) -> Self {
        let all: Vec<_> = (0..model.soles.len()).map(SoleId).collect();
        PlannedRobot::on(model, &all)
    }

    /// In the home posture, on these soles.
    pub fn on(model: &Model, soles: &[SoleId]) -> Self {
        let foot = |&id: &SoleId| {
            let sole = &model.soles[id.0];
            Foot { sole: id, link: sole.link, center: sole.centroid(), flat: sole.vertices.len() > 1 }
        };
        let feet = soles.iter().map(foot).collect();
        PlannedRobot { state: State::home(model), ws: Workspace::new(model), feet }
    }

    /// Updates the kinematics to `state`.
    pub fn update(&mut self, model: &Model) {
        kinematics::update(model, &self.state, &mut self.ws);
    }

    /// Sets the plan to rest, with the joints at their commanded positions and the soles, on
    /// average, at their estimated poses: the posture of the robot without sag.
    pub fn stand_as_commanded(&mut self, context: &Context, command: &Command) {
        let model = context.model;
        self.state.copy_from(context.state);
        self.state.v.fill(0.0);
        self.update(model);
        let (there, lean) = self.middle();
        self.state.joints.copy_from_slice(&command.position);
        self.update(model);
        let (here, own) = self.middle();
        // Rotate and shift the robot so that the middle of the soles does not move.
        let turn = lean * own.inverse();
        self.state.position = there + turn * (self.state.position - here);
        self.state.rotation = turn * self.state.rotation;
        self.update(model);
    }

    /// Mean of the sole centroids, and of the orientations of the soles that are flat.
    fn middle(&self) -> (Vector3<f64>, UnitQuaternion<f64>) {
        let flat = (0..self.feet.len()).filter(|&s| self.feet[s].flat).map(|s| self.sole(s).rotation);
        let first = flat.clone().next().unwrap_or_else(UnitQuaternion::identity);
        let count = flat.clone().count().max(1) as f64;
        // Small differences add as rotation vectors.
        let mean = flat.map(|r| (r * first.inverse()).scaled_axis()).sum::<Vector3<f64>>() / count;
        (self.support(), UnitQuaternion::from_scaled_axis(mean) * first)
    }

    /// Pose of a sole: its centroid and the orientation of its link.
    pub fn sole(&self, s: usize) -> Isometry3<f64> {
        let foot = &self.feet[s];
        let rotation = Rotation3::from_matrix_unchecked(self.ws.links[foot.link.0].rotation);
        let position = self.ws.point(foot.link, &foot.center);
        Isometry3::from_parts(position.into(), UnitQuaternion::from_rotation_matrix(&rotation))
    }

    /// Unit vector out of a sole's upper side; none for soles of fewer than three vertices.
    pub fn normal(&self, model: &Model, s: usize) -> Option<Vector3<f64>> {
        let [a, b, c, ..] = model.soles[self.feet[s].sole.0].vertices[..] else { return None };
        let normal = (b - a).cross(&(c - a)).normalize();
        Some(self.ws.links[self.feet[s].link.0].rotation * normal)
    }

    /// Centre of mass, m.
    pub fn com(&self) -> Vector3<f64> {
        body::center_of_mass(&self.ws)
    }

    /// Mean of the sole centroids, m.
    pub fn support(&self) -> Vector3<f64> {
        let n = self.feet.len();
        (0..n).map(|s| self.sole(s).translation.vector).sum::<Vector3<f64>>() / n as f64
    }

    /// The heading of an orientation: its rotation about the world's z axis only.
    pub fn upright(rotation: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
        let forward = rotation * Vector3::x();
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), math::atan2(forward.y, forward.x))
    }

    /// The goal met by the present plan.
    pub fn goal(&self) -> Goal {
        Goal { soles: (0..self.feet.len()).map(|s| self.sole(s)).collect(), com: self.com(), root: self.state.rotation }
    }
}
