//! Tests of `[compare]`: errors against closed forms, and shared and failed references.

use std::fs;
use std::path::PathBuf;

use stiction::results::RunRecord;

use super::{Place, Table};

const G: f64 = 9.81;

/// Mean of a function of time over the instants of a 200 Hz log from 0 to `end`, both included.
fn mean(end: f64, f: impl Fn(f64) -> f64) -> f64 {
    let n = (end * 200.0).round() as usize;
    (0..=n).map(|k| f(k as f64 / 200.0)).sum::<f64>() / (n + 1) as f64
}

#[track_caller]
fn assert_near(found: f64, expected: f64, relative: f64) {
    assert!((found - expected).abs() <= relative * expected.abs(), "{found:e}, not {expected:e}");
}

/// Record files of the references of a scenario.
fn references(place: &Place, results: &str, scenario: &str) -> Vec<PathBuf> {
    let folder = fs::read_dir(place.path(results).join(scenario).join("references"));
    folder.map_or(Vec::new(), |entries| entries.map(|e| e.unwrap().path().join("run.json")).collect())
}

/// A block in free fall. The error of semi-implicit Euler is `g h t / 2` at the end of each step h,
/// and that of the cubic dense output is the same in the middle of a step.
#[test]
fn fixed_step_error_in_free_fall_equals_its_closed_form() {
    let place = Place::new();
    place.block(
        "fall.toml",
        "base = { position = [0, 0, 5], linear_velocity = [3, 0, 0] }
[contact]
method = \"one-step\"
[integrator]
method = \"semi-implicit\"
[compare]
reference = { \"contact.method\" = \"exact\", \"integrator.method\" = \"dopri5\", \"integrator.step\" = 1e-3 }
[sweep.grid]
\"integrator.step\" = [1e-2, 5e-3, 1e-3, 1e-4, 0.7e-3, 3.1e-3]
",
    );
    place.runner(&["fall.toml", "--set", "duration=0.5", "--no-log"]).exits(0);
    let table = place.summary("results");
    let steps = table.numbers("integrator.step");
    let found = table.numbers("error_position_rms_m");
    let closed = |step: f64| G * step / 2.0 * mean(0.5, |t| t * t).sqrt();
    for (step, found) in steps.iter().zip(&found).take(4) {
        // Rounding of positions of 5 m is 1e-15 in each of some thousand steps.
        assert_near(*found, closed(*step), 1e-9);
    }
    for (step, found) in steps.iter().zip(&found).skip(4) {
        // These steps do not end at the instants. Within a step the cubic deviates from the line by
        // at most 0.0962 g h^2 / 2. A state of the wrong step would be off by up to v h = 3 h.
        let difference = (found - closed(*step)).abs();
        let deviation = 0.0963 * G * step * step / 2.0;
        assert!(difference < deviation, "{step}: {difference:e}, {deviation:e}");
        assert!(deviation < 0.01 * closed(*step) && 3.0 * step > closed(*step));
    }
    for (step, found) in steps.iter().zip(table.numbers("error_final_position_m")).take(4) {
        assert_near(found, G * step * 0.5 / 2.0, 1e-9);
    }
    assert_eq!(table.numbers("error_final_rotation_rad"), [0.0; 6]);
    assert_eq!(table.numbers("error_force_rms_N"), [0.0; 6], "no contact");
    assert_eq!(table.numbers("contact_state_agreement"), [1.0; 6]);
    assert_eq!(table.column("error_joint_rms_rad"), [""; 6], "a block has no joints");
    assert_eq!(references(&place, "results", "fall").len(), 1, "all runs share one reference");
}

/// A double pendulum with adaptive steps: the dense output is as accurate as the step ends. Errors
/// grow with time, so the mean over all instants is below the error at the end. The end itself is
/// no sample of the dense output.
#[test]
fn dense_output_is_as_accurate_as_step_ends() {
    let place = Place::new();
    let urdf = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/pendulum/pendulum.urdf");
    place.write(
        "swing.toml",
        format!(
            "duration = 1
[robot]
model = {urdf:?}
soles = []
joint_default = {{ mode = \"passive\" }}
posture = {{ shoulder = 0.3, elbow = 0.4 }}
[integrator]
absolute_tolerance = 1e-14
[compare]
reference = {{ \"integrator.relative_tolerance\" = 1e-14 }}
[sweep.grid]
\"log.rate\" = [777, 1]
\"integrator.relative_tolerance\" = [1e-4, 1e-8, 1e-11]
"
        ),
    );
    place.runner(&["swing.toml", "--no-log"]).exits(0);
    let found = place.summary("results").numbers("error_joint_rms_rad");
    for (dense, ends) in found[..3].iter().zip(&found[3..]) {
        // At 1 Hz there are two instants: the start, without error, and the end.
        let end = ends * 2.0f64.sqrt();
        assert!(*dense < end && *dense > 0.1 * end, "{dense:e}, {end:e}");
    }
    assert!(found[0] > 1e-9 && found[2] < 1e-11, "{found:?}");
}

/// A block slides on floors with different friction. Positions differ by `(mu' - mu) g t^2 / 2`,
/// forces by `(mu' - mu) m g`.
#[test]
fn errors_between_two_frictions_equal_their_closed_form() {
    let place = Place::new();
    place.block(
        "slide.toml",
        "base = { linear_velocity = [2, 0, 0] }
[floor]
friction = 0.2
[integrator]
relative_tolerance = 1e-12
absolute_tolerance = 1e-13
[compare]
reference = { \"floor.friction\" = 0.4 }
[sweep.grid]
duration = [0.4, 1.4]
",
    );
    place.runner(&["slide.toml"]).exits(0);
    let table = place.summary("results");
    // Errors: the tolerance of the integrator, and an event located to 1e-13 of a step.
    assert_near(table.numbers("error_position_rms_m")[0], 0.1 * G * mean(0.4, |t| t.powi(4)).sqrt(), 1e-9);
    assert_near(table.numbers("error_force_rms_N")[0], 0.2 * G, 1e-9);
    assert_eq!(table.numbers("contact_state_agreement")[0], 1.0);
    // On the rougher floor the block rests from 2 / (0.4 g), on the other from 2 / (0.2 g).
    let (early, late) = (2.0 / (0.4 * G), 2.0 / (0.2 * G));
    let agreement = mean(1.4, |t| f64::from(t < early || t >= late));
    assert_near(table.numbers("contact_state_agreement")[1], agreement, 1e-12);
    let difference = |t: f64| {
        let at = |mu: f64| {
            let t = t.min(2.0 / (mu * G));
            2.0 * t - mu * G * t * t / 2.0
        };
        at(0.2) - at(0.4)
    };
    assert_near(table.numbers("error_position_rms_m")[1], mean(1.4, |t| difference(t).powi(2)).sqrt(), 1e-9);
    assert_near(table.numbers("error_final_position_m")[1], difference(1.4), 1e-9);
    let squares = |t: f64| {
        let force = |mu: f64| if t < 2.0 / (mu * G) { mu * G } else { 0.0 };
        (force(0.2) - force(0.4)).powi(2)
    };
    assert_near(table.numbers("error_force_rms_N")[1], mean(1.4, squares).sqrt(), 1e-9);
}

/// Without gravity, a straight rotating double pendulum keeps its rate and stays straight. One of
/// two joints differs by `0.5 t`.
#[test]
fn joints_are_compared_by_mean_square() {
    let place = Place::new();
    let urdf = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/pendulum/pendulum.urdf");
    place.write(
        "turn.toml",
        format!(
            "duration = 1\ngravity = [0, 0, 0]
[robot]
model = {urdf:?}
soles = []
joint_default = {{ mode = \"passive\" }}
velocity = {{ shoulder = 1.5 }}
[log]
rate = 0
[compare]
reference = {{ \"robot.velocity.shoulder\" = 1.0 }}
"
        ),
    );
    place.runner(&["turn.toml"]).exits(0);
    let table = place.summary("results");
    // Tolerance: rounding of the sum of steps.
    assert_near(table.numbers("error_joint_rms_rad")[0], (0.25 * mean(1.0, |t| t * t) / 2.0).sqrt(), 1e-12);
    assert_eq!(table.column("error_force_rms_N"), [""], "no soles");
    assert_eq!(table.column("contact_state_agreement"), [""]);
    let record = RunRecord::read(&place.path("results/turn").join(table.column("key")[0]).join("run.json")).unwrap();
    assert_eq!((record.comparison.instants, record.comparison.until_s), (201, Some(1.0)), "200 Hz without a log");
}

/// The thrown block hits the floor, tumbles and rests: every kind of event.
const THROWN: &str = "base = { position = [0, 0, 0.3], rpy = [0.3, 0.2, 0.1], linear_velocity = [1, 0.3, 0] }\n";

#[test]
fn a_run_equal_to_its_reference_has_no_error() {
    let place = Place::new();
    let text = format!(
        "{THROWN}[stop]\nfallen = {{ below = 0.06 }}\n[compare]\nreference = {{}}
[[sweep.zip]]
\"contact.method\" = [\"exact\", \"one-step\", \"one-step\"]
\"integrator.method\" = [\"dopri5\", \"dopri5\", \"semi-implicit\"]
"
    );
    place.block("own.toml", &text);
    let done = place.runner(&["own.toml", "--set", "duration=0.8"]).exits(0);
    let table = place.summary("results");
    for column in ["error_position_rms_m", "error_force_rms_N", "error_final_position_m", "error_final_rotation_rad"] {
        assert_eq!(table.column(column), ["0.0"; 3], "{column}");
    }
    assert_eq!(table.column("contact_state_agreement"), ["1.0"; 3]);
    assert!(table.numbers("state_changes").iter().all(|n| *n > 0.0));
    assert_eq!(references(&place, "results", "own").len(), 3);
    // Fallen runs are compared up to their end.
    let fallen = table.column("outcome").iter().filter(|o| **o == "fallen").count();
    assert!(fallen > 0 && done.stdout.matches(": compared up to ").count() == fallen, "{}", done.stdout);
}

#[test]
fn comparison_changes_no_other_column() {
    let place = Place::new();
    let grid = "[sweep.grid]\n\"contact.method\" = [\"exact\", \"one-step\"]\n\"integrator.method\" = [\"dopri5\", \"semi-implicit\"]\n";
    place.block("s.toml", format!("{THROWN}[log]\nrate = 333\n{grid}").as_str());
    let compare = ["--set", "compare.reference.seed=7", "--set", "compare.truth.impacts=1"];
    for (extra, output) in [(&[][..], "alone"), (&compare, "compared")] {
        place.runner(&[&["s.toml", "--set", "duration=0.8", "-o", output, "--no-log"], extra].concat()).exits(0);
    }
    let (alone, compared) = (place.summary("alone"), place.summary("compared"));
    let new = |name: &str| name.starts_with("error_") || name == "contact_state_agreement";
    let differ = ["key", "wall_s", "cpu_s", "real_time_factor"];
    for name in alone.header.iter().filter(|name| !new(name) && !differ.contains(&name.as_str())) {
        assert_eq!(alone.column(name), compared.column(name), "{name}");
    }
    assert_eq!(alone.column("error_position_rms_m"), [""; 4]);
    assert_eq!(compared.column("error_position_rms_m"), ["0.0"; 4], "the seed changes nothing");
    let impacts = compared.numbers("impacts");
    let errors: Vec<f64> = impacts.iter().map(|n| (n - 1.0).abs()).collect();
    assert_eq!(compared.numbers("error_impacts"), errors);
    assert_ne!(alone.column("key"), compared.column("key"));
}

#[test]
fn truths_can_be_swept_and_their_errors_are_columns() {
    let place = Place::new();
    place.block(
        "t.toml",
        "[compare]\ntruth = { final_base_z = 1, first_slip_s = 0 }\n[[sweep.zip]]
\"floor.friction\" = [0.2, 0.4]
\"compare.truth.final_base_z\" = [0.25, -0.5]
",
    );
    let done = place.runner(&["t.toml", "--set", "duration=0.1"]).exits(0);
    let table = place.summary("results");
    let z = table.numbers("final_base_z");
    let expected = [(z[0] - 0.25).abs(), (z[1] + 0.5).abs()];
    assert_eq!(table.numbers("error_final_base_z"), expected);
    assert_eq!(table.column("error_first_slip_s"), ["", ""], "the block never slips");
    assert_eq!(table.header.last().unwrap(), "error_first_slip_s");
    assert!(!done.stdout.contains("compare.truth"), "truths do not distinguish runs: {}", done.stdout);
    assert_eq!(references(&place, "results", "t").len(), 0);
}

const SHARED: &str = "[contact]
method = \"one-step\"
[compare]
reference = { \"contact.method\" = \"exact\", \"integrator.method\" = \"dopri5\", \"integrator.step\" = 1e-3 }
[sweep.grid]
\"floor.friction\" = [0.2, 0.4]
\"integrator.method\" = [\"semi-implicit\", \"dopri5\"]
\"integrator.step\" = [1e-3, 2e-3]
";

#[test]
fn a_shared_reference_runs_once() {
    let place = Place::new();
    place.block("a.toml", &format!("{THROWN}{SHARED}")).block("b.toml", &format!("{THROWN}{SHARED}"));
    let done = place.runner(&["a.toml", "b.toml", "--set", "duration=0.2", "-j", "1", "--no-log", "-v"]).exits(0);
    assert!(done.stderr.contains("16 runs and 2 reference runs, 1 in parallel"), "{}", done.stderr);
    assert!(done.stderr.contains("[18/18] "), "{}", done.stderr);
    let records = references(&place, "results", "a");
    assert_eq!(
        (records.len(), references(&place, "results", "b").len()),
        (2, 0),
        "references are in the folder of the first scenario that needs them"
    );
    for path in &records {
        let record = RunRecord::read(path).unwrap();
        assert_eq!((record.method.as_str(), record.integrator.as_str()), ("exact", "dopri5"));
        assert!(done.stdout.contains(&record.key), "its file is listed: {}", done.stdout);
    }
    let table = place.summary("results");
    assert_eq!(table.rows.len(), 16, "references have no row");
    let lines = fs::read_to_string(place.path("results/runs.jsonl")).unwrap();
    assert_eq!(lines.lines().count(), 16);
    let found = table.column("error_position_rms_m");
    assert!(found.iter().all(|e| !e.is_empty()), "{found:?}");
    assert_eq!(found[..8], found[8..], "equal runs of two files");
    // With two threads and another order of ending.
    place.runner(&["b.toml", "a.toml", "--set", "duration=0.2", "-j", "2", "--no-log", "-o", "two"]).exits(0);
    let swapped = place.summary("two");
    let results = |t: &Table| -> Vec<String> {
        ["key", "error_position_rms_m", "error_force_rms_N", "contact_state_agreement", "error_final_rotation_rad"]
            .iter()
            .flat_map(|name| t.column(name)[..8].iter().map(|cell| (*cell).to_owned()).collect::<Vec<_>>())
            .collect()
    };
    assert_eq!(results(&swapped), results(&table));
    let done = place.runner(&["check", "a.toml", "b.toml"]).exits(0);
    assert!(done.stdout.contains("16 runs and 2 reference runs"), "{}", done.stdout);
    let listed = place.runner(&["list", "a.toml", "--format", "json"]).exits(0);
    let listed: serde_json::Value = serde_json::from_str(&listed.stdout).unwrap();
    assert!(listed.as_array().unwrap().iter().all(|run| run["reference"].as_str().is_some_and(|key| key.len() == 16)));
}

#[test]
fn a_failed_reference_is_reported_and_its_runs_continue() {
    let place = Place::new();
    place.block(
        "s.toml",
        "[compare]\nreference = { \"robot.base.linear_velocity\" = [1e7, 0, 0] }\n[sweep]\nrepeat = 3\n",
    );
    let done = place.runner(&["s.toml", "--set", "duration=0.1", "--set", "compare.reference.seed=1"]).exits(3);
    let table = place.summary("results");
    assert_eq!(table.column("outcome"), ["passed"; 3]);
    assert_eq!(table.column("error_position_rms_m"), [""; 3]);
    assert_eq!(done.stdout.matches("not compared: its reference ").count(), 3, "{}", done.stdout);
    assert!(done.stdout.contains("diverged s reference ") && done.stdout.contains("velocity of base is "));
    // The reference runs first and is the first failure.
    let done = place.runner(&["s.toml", "--fail-fast", "-j", "1", "-o", "fast"]).exits(3);
    assert!(done.stdout.contains("3 runs not started"), "{}", done.stdout);
}

#[test]
fn runs_are_compared_up_to_the_end_of_a_shorter_reference() {
    let place = Place::new();
    // Free fall from 1 m: the reference ends below 0.9 m, the run at 0.3 s.
    place.block(
        "s.toml",
        "base = { position = [0, 0, 1] }\n[compare]\nreference = { \"stop.fallen\" = { below = 0.9 } }\n",
    );
    let done = place.runner(&["s.toml", "--set", "duration=0.3", "--no-log"]).exits(0);
    // A fall of 0.1 m takes sqrt(0.2 / g) = 0.1428 s. A step of at most 0.01 s may end later.
    let table = place.summary("results");
    let record = RunRecord::read(&place.path("results/s").join(table.column("key")[0]).join("run.json")).unwrap();
    let until = record.comparison.until_s.unwrap();
    assert!((0.14..=0.155).contains(&until), "{until}");
    assert_eq!(record.comparison.instants, (until * 200.0).round() as u64 + 1);
    assert_eq!(table.numbers("error_position_rms_m"), [0.0]);
    assert!(done.stdout.contains(&format!("compared up to {until} s")), "{}", done.stdout);
}

#[test]
fn expectations_can_check_errors() {
    let place = Place::new();
    place.block(
        "s.toml",
        "base = { linear_velocity = [2, 0, 0] }\n[floor]\nfriction = 0.2
[compare]
reference = { \"floor.friction\" = 0.4 }
[[expect]]
metric = \"error_position_rms_m\"
max = 1e-3
[[expect]]
metric = \"contact_state_agreement\"
min = 1
",
    );
    let done = place.runner(&["s.toml", "--set", "duration=0.4"]).exits(1);
    assert!(done.stdout.contains("1 of 2 expectations held"), "{}", done.stdout);
}

#[test]
fn timing_repetitions_change_no_key() {
    let place = Place::new();
    place.block("s.toml", "[compare]\ntiming_repeats = 3\n[sweep.grid]\n\"floor.friction\" = [0.2, 0.4]\n");
    let done = place.runner(&["s.toml", "--set", "duration=0.2", "-o", "timed"]).exits(0);
    assert!(done.stderr.contains("then 6 repetitions one at a time for timing"), "{}", done.stderr);
    assert!(done.stderr.contains("timing: repetition 3 of 3, 2 one at a time"), "{}", done.stderr);
    let timed = place.summary("timed");
    let times = |name: &str| timed.numbers(&format!("timing_{name}_s"));
    for kind in ["wall", "cpu"] {
        let (min, median) = (times(&format!("{kind}_min")), times(&format!("{kind}_median")));
        assert!(min.iter().zip(&median).all(|(min, median)| 0.0 < *min && min <= median), "{kind} {min:?} {median:?}");
    }
    let record = RunRecord::read(&place.path("timed/s").join(timed.column("key")[1]).join("run.json")).unwrap();
    let repeats = record.timing.repeats.unwrap();
    assert_eq!((repeats.count, repeats.wall_min_s), (3, times("wall_min")[1]));
    let done = place.runner(&["s.toml", "--set", "duration=0.2", "-o", "not", "--no-timing"]).exits(0);
    assert!(!done.stderr.contains("timing"), "{}", done.stderr);
    let untimed = place.summary("not");
    assert_eq!(untimed.column("timing_wall_min_s"), ["", ""]);
    assert_eq!(untimed.column("key"), timed.column("key"));
    let more = ["s.toml", "--set", "duration=0.2", "--set", "compare.timing_repeats=1", "-o", "more"];
    place.runner(&more).exits(0);
    assert_eq!(place.summary("more").column("key"), timed.column("key"));
}
