//! URDF: parsed, checked, repaired, converted to a model.

use stiction::convert::{self, RobotFormat};
use stiction::robot::{self, InertiaPolicy, Robot, RobotError};

use super::tree;

/// Reads the text of a URDF, unchanged and, if that fails, with inertias repaired.
pub fn take(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let path = tree::root().join("robots/fuzzed/fuzzed.urdf");
    let robot = robot::parse(&path, text, None);
    if robot.is_err() {
        inspect(robot::parse(&path, text, Some(InertiaPolicy::Repair)));
    }
    inspect(robot);
}

/// Renders the output of `runner inspect`, or the error.
pub fn inspect(robot: Result<Robot, RobotError>) {
    match robot {
        Ok(robot) => {
            for notice in &robot.notices {
                let _ = notice.to_string();
            }
            let _ = robot::inspect(&robot);
            let _ = convert::description(&robot.model);
            for format in [RobotFormat::Urdf, RobotFormat::Mjcf] {
                let _ = convert::convert(&robot.model, format, "meshes");
            }
            let finite = |x: f64| x.is_finite();
            assert!(robot.model.links.iter().all(|link| finite(link.mass)), "a mass is not finite");
        }
        Err(error) => {
            let _ = (error.to_string(), error.render(true));
        }
    }
}
