//! URDF: read, checked, repaired, made into a model.

use stiction::robot::{self, InertiaPolicy, Robot, RobotError};

use super::tree;

/// Takes the text of a URDF; once as it is, and once with inertias repaired.
pub fn take(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let path = tree::root().join("robots/fuzzed/fuzzed.urdf");
    let robot = robot::parse(&path, text, None);
    if robot.is_err() {
        look(robot::parse(&path, text, Some(InertiaPolicy::Repair)));
    }
    look(robot);
}

/// What `runner inspect` shows, or the error.
pub fn look(robot: Result<Robot, RobotError>) {
    match robot {
        Ok(robot) => {
            for notice in &robot.notices {
                let _ = notice.to_string();
            }
            let _ = robot::inspect(&robot);
            let finite = |x: f64| x.is_finite();
            assert!(robot.model.links.iter().all(|link| finite(link.mass)), "a mass is not finite");
        }
        Err(error) => {
            let _ = (error.to_string(), error.render(true));
        }
    }
}
