//! Boundaries over two keys against curves in closed form.

use serde_json::Value;

use super::{assert_same_however_run, numbers, run, searches};
use crate::cli::Place;

/// The block with a constant force at the floor, which slips it exactly if its size exceeds mu m g.
fn pushed(search: &str) -> Place {
    let place = Place::new();
    let force = "[[force]]\ntype = \"push\"\nlink = \"block\"\npoint = [0, 0, -0.05]\nforce = [0, 0, 0]\n\
        start = 0.001\nduration = 0.004\nprofile = \"constant\"\n";
    let robot = "[robot]\nmodel = \"block/block.toml\"\n[floor]\nfriction = 0.5\n";
    place.write("s.toml", format!("duration = 0.005\n{robot}[log]\nrate = 0\n{force}{search}"));
    place
}

const CIRCLE: &str = "[search]\nboundary = { metric = \"first_slip_s\", min = 0.0 }\nsquares = 16\nruns = 900\n\
    [search.over]\n\"force.0.force.0\" = { between = [-8, 8], tolerance = 1e-3 }\n\
    \"force.0.force.1\" = { between = [-7.5, 8], tolerance = 1e-3 }\n";

#[test]
fn the_breakaway_force_is_a_circle() {
    let place = pushed(CIRCLE);
    run(&place, "results", &[]).exits(0);
    let found = &searches(&place, "results")[0];
    assert_eq!(found["verdict"], "found");
    let lines = found["lines"].as_array().unwrap();
    assert_eq!(lines.len(), 1);
    let points = lines[0].as_array().unwrap();
    assert_eq!(points.first(), points.last());
    assert!(points.len() > 30, "{}", points.len());
    // mu m g; the acceleration at which the search for contact states begins to see motion is far less than
    // the steps of the lattice.
    let limit = 0.5 * 9.81;
    for point in points {
        let [lower, upper] = ["lower", "upper"].map(|end| numbers(&point[end]));
        let outside = |at: &[f64]| at[0].hypot(at[1]) > limit;
        assert_eq!((outside(&lower), outside(&upper)), (point["holds_above"] == false, point["holds_above"] == true));
        let step = (upper[0] - lower[0]).max(upper[1] - lower[1]);
        assert!(step > 0.0 && step <= 1e-3, "{point}");
    }
    for probe in found["probes"].as_array().unwrap() {
        let at = numbers(&probe["at"]);
        assert_eq!(probe["holds"], at[0].hypot(at[1]) > limit, "{probe}");
    }
    let table = std::fs::read_to_string(place.path("results/boundary-lines.csv")).unwrap();
    assert_eq!(table.lines().count(), points.len() + 1);
    let report = std::fs::read_to_string(place.path("results/report.html")).unwrap();
    assert!(report.contains("first_slip_s at least 0 over force.0.force.0, force.0.force.1"));
}

#[test]
fn the_results_do_not_depend_on_threads_or_interruptions() {
    let place = pushed(&CIRCLE.replace("1e-3", "0.1"));
    assert_same_however_run(&place, 4);
}

#[test]
fn too_few_runs_are_no_result() {
    let place = pushed(&CIRCLE.replace("900", "200"));
    let done = run(&place, "results", &[]).exits(5);
    let found = &searches(&place, "results")[0];
    assert_eq!((&found["verdict"], &found["lines"]), (&"unconverged".into(), &Value::Null));
    assert!(done.stdout.contains("runs do not suffice"), "{}", done.stdout);
    assert!(found["runs"].as_u64().unwrap() <= 200);

    let none = pushed(&CIRCLE.replace("min = 0.0", "min = 9.0"));
    run(&none, "results", &[]).exits(5);
    let found = &searches(&none, "results")[0];
    assert_eq!((&found["verdict"], &found["runs"]), (&"no-boundary".into(), &81.into()));
}
