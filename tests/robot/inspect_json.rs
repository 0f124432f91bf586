//! JSON output of `runner inspect`.

use std::path::Path;

use serde_json::Value;
use stiction::dynamics::{self, State, Workspace};
use stiction::robot::{Robot, inspect_json, load};

use super::shipped;

fn robots() -> Vec<Robot> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/robot/mjcf");
    let mut robots: Vec<Robot> =
        ["arm.xml", "biped.xml", "shapes.xml"].iter().map(|name| load(&own.join(name)).unwrap()).collect();
    robots.push(shipped("hoap2/hoap2.toml"));
    robots
}

#[test]
fn the_mass_matrix_is_that_of_the_dynamics_at_home() {
    for robot in robots() {
        let model = &robot.model;
        let json = inspect_json(&robot);
        let state = State::home(model);
        let mut ws = Workspace::new(model);
        dynamics::prepare(model, &state, &nalgebra::Vector3::zeros(), &mut ws).unwrap();
        let rows = json["mass_matrix"].as_array().unwrap();
        assert_eq!(rows.len(), model.nv());
        for (i, row) in rows.iter().enumerate() {
            for (j, entry) in row.as_array().unwrap()[..=i].iter().enumerate() {
                let (got, truth) = (entry.as_f64().unwrap(), ws.mass.get(i, j));
                // Rounding of sums over some ten links.
                assert!((got - truth).abs() < 1e-12 * ws.mass.get(0, 0).max(1.0), "{}: {got} {truth}", model.name);
            }
        }
    }
}

#[test]
fn all_parts_of_the_model_are_in_the_json() {
    let robots = robots();
    let json = inspect_json(&robots[0]);
    let names = |key: &str| -> Vec<String> {
        json[key].as_array().unwrap().iter().map(|entry| entry["name"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(names("joints")[..2], ["lift", "turn"]);
    assert_eq!(names("links")[0], "pedestal");
    assert_eq!(names("loops"), ["loop", "tied", "tied by a pose", "by sites", "to world"]);
    assert_eq!(json["couplings"][0]["leader"], "elbow");
    assert_eq!(json["sensors"]["imu"][0]["name"], "tool");
    assert_eq!(json["joints"][1]["drive"]["mode"], "position");
    assert_eq!(json["joints"][1]["upper"], Value::Null);
    assert_eq!(json["uncollided_pairs"][0][1], "hand");
    assert!(json["notices"].as_array().unwrap().iter().any(|n| n["severity"] == "note"));
    let text = stiction::robot::inspect(&robots[0]);
    for line in ["couplings (1)", "follower             = ", "loops (5)", "to world             weld: link b at"] {
        assert!(text.contains(line), "{line} is not in\n{text}");
    }
}
