//! Tasks that plan: inverse kinematics, gait and balance against identities, closed forms and
//! recorded values.

mod balance;
mod gait;
mod handing;
mod inverse;
mod motion;

use crate::robot::shipped;
use stiction::robot::Model;
use stiction::task::kinematic::PlannedRobot;

/// HOAP-2 in its home posture.
fn hoap2() -> (Model, PlannedRobot) {
    let model = shipped("hoap2/hoap2.toml").model;
    let mut planned = PlannedRobot::new(&model);
    planned.update(&model);
    (model, planned)
}
