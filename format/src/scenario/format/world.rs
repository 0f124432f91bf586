//! `[world]`: bodies from a world file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Bodies from a world file, which are added to `[[terrain]]` and `[[object]]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WorldSpec {
    /// An SDFormat file (`.sdf`, `.world`) or MJCF file (`.xml`, `.mjcf`), relative to the scenario file.
    pub file: String,
    /// Names of models that are left out: `*` matches any characters, `?` one.
    #[serde(default)]
    pub ignore: Vec<String>,
}
