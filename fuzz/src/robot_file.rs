//! Robot files (TOML), next to the repository's URDFs.

use stiction::robot;

use super::{tree, urdf};

/// Reads the text of a robot file.
pub fn take(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    urdf::inspect(robot::parse(&tree::root().join("robots/hoap2/fuzzed.toml"), text, None));
}
