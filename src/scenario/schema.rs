//! The format as a JSON Schema, for editors and other programs.

use super::scenario::Scenario;

/// JSON Schema (draft 2020-12) of a scenario file, made from the types that read it. Units stand in the descriptions.
pub fn schema() -> serde_json::Value {
    let mut schema = schemars::schema_for!(Scenario).to_value();
    // The one thing without a default; the type has one only so that reading can go on after an error.
    if let Some(robot) = schema.pointer_mut("/properties/robot").and_then(|r| r.as_object_mut()) {
        robot.remove("default");
    }
    schema
}
