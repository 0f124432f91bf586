//! Tasks that plan: inverse kinematics, gait and balance by identities, closed forms and frozen values.

mod balance;
mod gait;
mod handing;
mod inverse;
mod motion;

use crate::robot::shipped;
use stiction::robot::Model;
use stiction::task::kinematic::Figure;

/// HOAP-2 in its home posture.
fn hoap2() -> (Model, Figure) {
    let model = shipped("hoap2/hoap2.toml").model;
    let mut figure = Figure::new(&model);
    figure.update(&model);
    (model, figure)
}
