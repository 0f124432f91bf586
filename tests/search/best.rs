//! Best values against closed forms.

use super::{assert_same_however_run, numbers, run, searches};
use crate::cli::Place;

/// Time of flight, s.
const T: f64 = 0.2;

/// Acceleration of the block by force and gravity, m/s^2: (1, -2, 0) N on 1 kg.
const A: [f64; 3] = [1.0, -2.0, -9.81];

/// The block in the air, with a constant force at its centre.
fn thrown(search: &str) -> Place {
    let place = Place::new();
    let robot = "[robot]\nmodel = \"block/block.toml\"\n\
        base = { position = [0, 0, 10], linear_velocity = [0, 0, 0] }\n";
    let force = "[[force]]\ntype = \"push\"\nlink = \"block\"\nforce = [1, -2, 0]\nduration = 1\n\
        profile = \"constant\"\n";
    place.write("s.toml", format!("duration = {T}\n{robot}[log]\nrate = 0\n{force}{search}"));
    place
}

fn over(key: &str, ends: [f64; 2], tolerance: f64) -> String {
    format!("\"robot.base.linear_velocity.{key}\" = {{ between = {ends:?}, tolerance = {tolerance} }}\n")
}

/// After T the block is displaced by v T + A T^2 / 2, which is least for v = -A T / 2.
#[test]
fn the_throw_that_returns_is_found() {
    let keys = [over("0", [-1.0, 1.0], 1e-3), over("1", [-1.0, 1.0], 1e-3), over("2", [0.0, 3.0], 1e-3)];
    for count in 1..=3 {
        let search = "[search]\nminimize = \"final_base_shift_m\"\nruns = 900\n[search.over]\n".to_owned();
        let place = thrown(&(search + &keys[..count].concat()));
        run(&place, "results", &[]).exits(0);
        let found = &searches(&place, "results")[0];
        assert_eq!(found["verdict"], "found");
        let at = numbers(&found["best"]["at"]);
        for (i, v) in at.iter().enumerate() {
            // Half a step: the shift is a distance, least at the nearest position of the lattice.
            assert!((v + A[i] * T / 2.0).abs() <= 0.5e-3 + 1e-9, "{count} {i} {v}");
        }
        let velocity = |i: usize| at.get(i).copied().unwrap_or(0.0);
        let shift = (0..3).map(|i| (velocity(i) * T + A[i] * T * T / 2.0).powi(2)).sum::<f64>().sqrt();
        // The error of the integration of a polynomial of second degree.
        assert!((found["best"]["value"].as_f64().unwrap() - shift).abs() < 1e-9);
        let probes = found["probes"].as_array().unwrap();
        let probe = probes.iter().find(|probe| probe["at"] == found["best"]["at"]).unwrap();
        assert_eq!(probe["run"], found["best"]["run"]);
    }
}

/// z = v t - g t^2 / 2 is greatest at t = v / g.
#[test]
fn the_highest_point_of_a_throw_is_found() {
    let search = "[search]\nmaximize = \"final_base_z\"\nruns = 200\nseed = 7\npopulation = 6\n\
        over = { duration = { between = [0.01, 0.6], tolerance = 1e-4 } }\n";
    let place = thrown(&search.replace("duration =", "\"duration\" ="));
    let v = 2.0;
    run(&place, "results", &["--set", "robot.base.linear_velocity.2=2.0"]).exits(0);
    let found = &searches(&place, "results")[0];
    assert_eq!((&found["verdict"], &found["search"]), (&"found".into(), &"maximum".into()));
    let t = found["best"]["at"][0].as_f64().unwrap();
    // Two positions of the lattice may be equally near.
    assert!((t - v / 9.81).abs() <= 1e-4, "{t}");
    let height = found["best"]["value"].as_f64().unwrap();
    assert!((height - (10.0 + v * v / (2.0 * 9.81))).abs() < 1e-7, "{height}");
    // No other run is higher.
    let probes = found["probes"].as_array().unwrap();
    assert!(probes.iter().all(|probe| probe["value"].as_f64().unwrap() <= height));
}

#[test]
fn the_results_do_not_depend_on_threads_or_interruptions() {
    let keys = over("0", [-1.0, 1.0], 0.01) + &over("1", [-1.0, 1.0], 0.01);
    let sweep = "[sweep.grid]\n\"force.0.force.0\" = [0.0, 2.0, 4.0]\n";
    let place =
        thrown(&format!("[search]\nminimize = \"final_base_shift_m\"\nruns = 200\n[search.over]\n{keys}{sweep}"));
    assert_same_however_run(&place, 4);
    // v = -a T / 2 for each force.
    for (search, force) in searches(&place, "one").iter().zip([0.0, 2.0, 4.0]) {
        let best = numbers(&search["best"]["at"]);
        assert!((best[0] + force * T / 2.0).abs() <= 0.005 + 1e-9 && (best[1] - 0.2).abs() <= 0.005 + 1e-9, "{search}");
    }
    let table = std::fs::read_to_string(place.path("one/searches.csv")).unwrap();
    assert!(table.starts_with("scenario,force.0.force.0,search,subject,over,verdict,"), "{table}");
    assert_eq!(table.lines().count(), 4);
}

#[test]
fn runs_that_do_not_meet_the_requirement_are_not_chosen() {
    // Throws to the right end at x >= 0 alone, so that the best one is at the border.
    let search = "[search]\nminimize = \"final_base_shift_m\"\nruns = 200\n\
        require = { metric = \"final_base_x\", min = 0.05 }\n[search.over]\n";
    let place = thrown(&(search.to_owned() + &over("0", [-1.0, 1.0], 1e-3)));
    run(&place, "results", &[]).exits(0);
    let found = &searches(&place, "results")[0];
    let v = found["best"]["at"][0].as_f64().unwrap();
    let border = (0.05 - A[0] * T * T / 2.0) / T;
    assert!(v >= border - 1e-9 && v <= border + 1e-3, "{v} {border}");
    let chosen = |probe: &&serde_json::Value| !probe["value"].is_null();
    let probes = found["probes"].as_array().unwrap();
    assert!(probes.iter().filter(chosen).all(|probe| probe["at"][0].as_f64().unwrap() >= border - 1e-9));
    assert!(probes.iter().any(|probe| probe["value"].is_null()));

    let none = thrown(&(search.replace("0.05", "9.0") + &over("0", [-1.0, 1.0], 1e-3)));
    let done = run(&none, "results", &[]).exits(5);
    assert_eq!(searches(&none, "results")[0]["verdict"], "no-value");
    assert!(done.stdout.contains("no run has a value"), "{}", done.stdout);

    let few = search.replace("200", "5").replace("require", "# require");
    let few = thrown(&(few + &over("0", [-1.0, 1.0], 1e-3)));
    run(&few, "results", &[]).exits(5);
    assert_eq!(searches(&few, "results")[0]["verdict"], "unconverged");
}

/// Runs that end too early have not moved far, but say nothing of the whole throw.
#[test]
fn runs_that_do_not_end_are_not_chosen() {
    let search = "[search]\nminimize = \"final_base_shift_m\"\nruns = 60\n[search.over]\n";
    let script = "[[force]]\ntype = \"script\"\nfile = \"limit.luau\"\n";
    let place = thrown(&format!("{script}{search}{}", over("0", [0.5, 1.0], 0.01)));
    place.write(
        "limit.luau",
        "function run(robot) if robot.base.linear_velocity[1] > 0.75 then error(\"too fast\") end return {} end\n",
    );
    run(&place, "results", &[]).exits(3);
    let found = &searches(&place, "results")[0];
    let at = found["best"]["at"][0].as_f64().unwrap();
    // The slowest one; the force adds 0.2 m/s.
    assert_eq!(at, 0.5, "{found}");
    let probes = found["probes"].as_array().unwrap();
    assert!(probes.iter().all(|p| p["value"].is_null() == (p["outcome"] != "passed")), "{found}");
    assert!(probes.iter().any(|p| p["value"].is_null()), "{found}");
}

/// The study's velocity follows from both braking and sliding back with constant accelerations.
#[test]
fn a_box_returns_to_its_start() {
    let place = Place::new();
    let scenario = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/studies/slide-and-return.toml");
    place.runner(&[scenario, "-o", "results"]).exits(0);
    let found = &searches(&place, "results")[0];
    assert_eq!(found["verdict"], "found");
    let (braked, back): (f64, f64) = (3.0 + 0.2 * 9.81, 3.0 - 0.2 * 9.81);
    let v = back.sqrt() / (1.0 / braked.sqrt() + back.sqrt() / braked);
    let at = numbers(&found["best"]["at"]);
    // A step of the lattice.
    assert!((at[0] - v).abs() <= 1e-4 && at[1].abs() <= 1e-4, "{at:?} {v}");
}
