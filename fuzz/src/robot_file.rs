//! Robot files (TOML), beside the repository's URDFs.

use stiction::robot;

use super::{tree, urdf};

/// Takes the text of a robot file.
pub fn take(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    urdf::look(robot::parse(&tree::root().join("robots/hoap2/fuzzed.toml"), text, None));
}
