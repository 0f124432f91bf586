//! The JSON Schema agrees with the reader.

use std::collections::BTreeSet;

use serde_json::Value;
use stiction::scenario::{METRICS, schema};

use super::{FULL, SMALLEST, file, runs};

fn keys(value: &Value) -> BTreeSet<String> {
    value.as_object().map(|o| o.keys().cloned().collect()).unwrap_or_default()
}

#[test]
fn every_key_of_the_schema_is_known_to_the_reader() {
    let known = keys(&schema()["properties"]);
    // The reader lists the known keys for a key that is similar to none.
    let wrong = file(&format!("xyzzyxyzzyxyzzy = 1\n{SMALLEST}")).unwrap().expand(&[]).unwrap_err();
    let help = wrong.0[0].help.clone().unwrap();
    let listed: BTreeSet<String> = help.split('`').skip(1).step_by(2).map(str::to_owned).collect();
    assert_eq!(known, listed);
}

#[test]
fn resolved_scenarios_have_only_keys_of_the_schema() {
    let schema = schema();
    for run in runs(FULL) {
        let value: Value = serde_json::to_value(toml::from_str::<toml::Table>(&run.resolved_toml).unwrap()).unwrap();
        for key in keys(&value) {
            let mut node = &schema["properties"][&key];
            assert!(!node.is_null(), "{key}");
            if let Some(reference) = node["$ref"].as_str().or(node["anyOf"][0]["$ref"].as_str()) {
                node = schema.pointer(reference.trim_start_matches('#')).unwrap();
            }
            let known = keys(&node["properties"]);
            assert!(value[&key].as_object().is_none() || keys(&value[&key]).is_subset(&known), "{key}");
        }
    }
}

#[test]
fn the_schema_is_as_strict_as_the_reader() {
    let schema = schema();
    assert_eq!(schema["required"], serde_json::json!(["robot"]));
    assert_eq!(schema["properties"]["robot"].get("default"), None);
    assert_eq!(schema["$defs"]["RobotSpec"]["required"], serde_json::json!(["model"]));
    for (name, definition) in schema["$defs"].as_object().unwrap() {
        if definition["properties"].is_object() {
            assert_eq!(definition["additionalProperties"], false, "{name}");
        }
    }
    assert_eq!(schema["properties"]["duration"]["exclusiveMinimum"], 0);
    assert_eq!(
        schema["$defs"]["Expect"]["properties"]["metric"]["anyOf"][0]["enum"].as_array().unwrap().len(),
        METRICS.len()
    );
}

#[test]
fn every_field_is_described_and_defaults_are_those_of_the_reader() {
    let schema = schema();
    let definitions = schema["$defs"].as_object().unwrap().iter().map(|(name, d)| (name.as_str(), d));
    for (name, definition) in definitions.chain([("Scenario", &schema)]) {
        for (key, property) in definition["properties"].as_object().into_iter().flatten() {
            assert!(property["description"].is_string(), "{name}.{key}");
        }
    }
    let smallest = &runs(SMALLEST)[0];
    let value: Value = serde_json::to_value(toml::from_str::<toml::Table>(&smallest.resolved_toml).unwrap()).unwrap();
    for key in ["duration", "seed", "gravity", "floor", "contact", "integrator", "control", "log"] {
        assert_eq!(schema["properties"][key]["default"], value[key], "{key}");
    }
}
