//! MJCF files, next to the repository's own: read as robots and as worlds.

use stiction::robot::{self, InertiaPolicy};

use super::{tree, urdf};

/// Reads the text of an MJCF file, unchanged and, if that fails, with inertias repaired.
pub fn take(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let path = tree::root().join("tests/robot/mjcf/fuzzed.xml");
    let robot = robot::parse(&path, text, None);
    if robot.is_err() {
        urdf::inspect(robot::parse(&path, text, Some(InertiaPolicy::Repair)));
    }
    urdf::inspect(robot);
}
