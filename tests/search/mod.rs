//! Searches: boundaries and best values against closed forms; the same runs for threads, shards and
//! interruptions.

mod best;
mod lines;

use std::fs;

use serde_json::Value;

use crate::cli::{Done, Place};

/// A block slides for 0.02 s from a speed v with mu = 0.5: x = v t - mu g t^2 / 2, so that 15 mm need
/// v = 0.79905 m/s.
const BLOCK: &str = "[log]\nrate = 0\n\
    [integrator]\nmethod = \"semi-implicit\"\nstep = 1e-3\n";

const SEARCH: &str =
    "[search]\nover = { \"robot.base.linear_velocity.0\" = { between = [0.5, 1.5], tolerance = 1e-3 } }\n";

const FAR: &str = "boundary = { metric = \"final_base_x\", min = 0.015 }\n";

/// Six cells, in two groups if the friction is followed.
const CELLS: &str = "[sweep.grid]\n\"contact.method\" = [\"exact\", \"one-step\"]\n\
    \"floor.friction\" = [0.4, 0.5, 0.6]\n";

fn place(parts: &[&str]) -> Place {
    let place = Place::new();
    write(&place, &parts.concat());
    place
}

fn write(place: &Place, parts: &str) {
    let robot = "[robot]\nmodel = \"block/block.toml\"\nbase = { linear_velocity = [1, 0, 0] }\n";
    place.write("s.toml", format!("duration = 0.02\n{robot}{BLOCK}{parts}"));
}

fn run(place: &Place, output: &str, arguments: &[&str]) -> Done {
    place.runner(&[&["s.toml", "-o", output][..], arguments].concat())
}

fn text(place: &Place, output: &str) -> String {
    fs::read_to_string(place.path(output).join("searches.json")).unwrap()
}

fn searches(place: &Place, output: &str) -> Vec<Value> {
    let file: Value = serde_json::from_str(&text(place, output)).unwrap();
    file["searches"].as_array().unwrap().clone()
}

/// The ends of the interval that a search found.
fn interval(search: &Value) -> [f64; 2] {
    ["lower", "upper"].map(|end| search["interval"][end].as_f64().unwrap())
}

fn numbers(list: &Value) -> Vec<f64> {
    list.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

/// Asserts that one thread, two, two shards, and results of which every n-th run was lost give the same searches,
/// in the folders `one` and `two`. Returns what the resumed batch printed.
fn assert_same_however_run(place: &Place, nth: usize) -> Done {
    run(place, "one", &["-j", "1"]).exits(0);
    run(place, "two", &["-j", "2"]).exits(0);
    assert_eq!(text(place, "one"), text(place, "two"));
    for part in ["1/2", "2/2"] {
        run(place, &format!("part-{}", &part[..1]), &["--shard", part]).exits(0);
    }
    place.runner(&["merge", "part-1", "part-2", "-o", "merged"]).exits(0);
    assert_eq!(text(place, "one"), text(place, "merged"));
    let folders = fs::read_dir(place.path("two/s")).unwrap().map(|entry| entry.unwrap().path());
    for folder in folders.step_by(nth) {
        fs::remove_dir_all(folder).unwrap();
    }
    let done = run(place, "two", &["--resume"]).exits(0);
    assert_eq!(text(place, "one"), text(place, "two"));
    done
}

#[test]
fn a_block_slips_at_mu_m_g() {
    let place = Place::new();
    let scenario = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/studies/breakaway-force.toml");
    place.runner(&[scenario, "-o", "results"]).exits(0);
    let found = searches(&place, "results");
    // mu_s m g of the block and the brick, two headings each.
    let truths = [0.5 * 1.0 * 9.81, 0.5 * 1.0 * 9.81, 0.8 * 2.5 * 9.81, 0.8 * 2.5 * 9.81];
    assert_eq!(found.len(), truths.len());
    for (boundary, truth) in found.iter().zip(truths) {
        let [lower, upper] = interval(boundary);
        assert_eq!(boundary["interval"]["holds_above"], true);
        assert!(upper - lower <= 1e-10 * (1.0 + 1e-3), "{boundary}");
        assert!((lower - truth).abs() <= 1e-9 * truth && (upper - truth).abs() <= 1e-9 * truth, "{boundary}");
    }
}

#[test]
fn the_results_depend_on_neither_threads_nor_shards_nor_interruptions() {
    for follow in ["", "follow = [\"floor.friction\"]\n"] {
        let place = place(&[SEARCH, FAR, follow, CELLS]);
        let done = assert_same_however_run(&place, 3);
        assert!(done.stderr.contains("runs done already"), "{}", done.stderr);
        let again = run(&place, "two", &["--resume"]).exits(0);
        assert!(!again.stderr.contains("for the first time"), "{}", again.stderr);
        // v = x / t + mu g t / 2
        for boundary in searches(&place, "one") {
            let friction = boundary["parameters"]["floor.friction"].as_f64().unwrap();
            let truth = 0.015 / 0.02 + friction * 9.81 * 0.02 / 2.0;
            let [lower, upper] = interval(&boundary);
            let middle = 0.5 * (lower + upper);
            // Half of the tolerance, and the error of first order of a step of 1 ms.
            assert!((middle - truth).abs() <= 0.5e-3 + friction * 9.81 * 1e-3 / 2.0, "{truth} {boundary}");
        }
    }
}

#[test]
fn following_takes_fewer_runs() {
    let count = |follow: &str| {
        let place = place(&[SEARCH, FAR, follow, CELLS]);
        run(&place, "results", &[]).exits(0);
        searches(&place, "results").iter().map(|boundary| boundary["runs"].as_u64().unwrap()).sum::<u64>()
    };
    let (alone, followed) = (count(""), count("follow = [\"floor.friction\", \"contact.method\"]\n"));
    assert!(followed < alone, "{followed} and {alone}");
}

#[test]
fn a_probe_is_the_run_of_a_sweep() {
    let place = place(&[SEARCH, FAR]);
    run(&place, "results", &[]).exits(0);
    let found = searches(&place, "results");
    let probes = found[0]["probes"].as_array().unwrap();
    assert!(probes.len() > 5);
    for probe in probes {
        let value = format!("robot.base.linear_velocity.0={}", probe["at"][0]);
        let other = Place::new();
        write(&other, "");
        let listed = other.runner(&["list", "s.toml", "--set", &value]).exits(0);
        assert!(listed.stdout.contains(probe["run"].as_str().unwrap()), "{probe}: {}", listed.stdout);
    }
}

#[test]
fn a_boundary_that_moved_is_a_difference() {
    let place = place(&[SEARCH, FAR, CELLS]);
    run(&place, "a", &[]).exits(0);
    run(&place, "again", &[]).exits(0);
    let same = place.runner(&["compare", "a", "again"]).exits(0);
    assert!(!same.stdout.contains("search:"), "{}", same.stdout);
    // With 1 ms more, 36 mm/s less reach the same distance.
    run(&place, "b", &["--set", "duration=0.021"]).exits(0);
    let changed = place.runner(&["compare", "a", "b"]).exits(1);
    let search = "search: s contact.method=exact floor.friction=0.4: final_base_x at least 0.015 over \
        robot.base.linear_velocity.0: found 0.";
    assert_eq!(changed.stdout.matches("search: s ").count(), 6, "{}", changed.stdout);
    assert!(changed.stdout.contains(search), "{}", changed.stdout);
    let json = place.runner(&["compare", "a", "b", "--format", "json"]).exits(1);
    let json: Value = serde_json::from_str(&json.stdout).unwrap();
    assert_eq!(json["searches"].as_array().unwrap().len(), 6);
}

#[test]
fn verdicts_without_a_boundary_have_an_exit_code() {
    let never = place(&[SEARCH, "boundary = { outcome = \"fallen\" }\n"]);
    run(&never, "results", &[]).exits(5);
    let found = searches(&never, "results");
    assert_eq!(
        (&found[0]["verdict"], &found[0]["runs"]),
        (&"no-boundary".into(), &found[0]["probes"].as_array().unwrap().len().into())
    );
    let values: Vec<f64> =
        found[0]["probes"].as_array().unwrap().iter().map(|p| p["at"][0].as_f64().unwrap()).collect();
    assert!(values.contains(&0.5) && values.contains(&1.5), "{values:?}");

    // The condition holds between two speeds.
    let twice = place(&[SEARCH, "check = 9\nboundary = { metric = \"final_base_x\", min = 0.012, max = 0.02 }\n"]);
    run(&twice, "results", &[]).exits(5);
    let found = searches(&twice, "results");
    assert_eq!(found[0]["verdict"], "not-monotone");
    assert_eq!(found[0]["interval"]["changes"].as_array().unwrap().len(), 2);
}

#[test]
fn a_run_that_says_nothing_ends_its_search() {
    let failing = "[[expect]]\nmetric = \"final_base_x\"\nmax = 0.0\n";
    let place = place(&[SEARCH, "boundary = { outcome = \"fallen\" }\n", failing]);
    run(&place, "results", &[]).exits(1);
    let found = searches(&place, "results");
    assert_eq!((&found[0]["verdict"], &found[0]["runs"]), (&"error".into(), &1.into()));
    assert!(found[0]["message"].as_str().unwrap().contains("ended as failed"), "{}", found[0]);
}

#[test]
fn errors_name_key_and_value() {
    let over = |ends: &str, tolerance: &str| {
        let key = "\"robot.base.linear_velocity.0\"";
        format!("[search]\n{FAR}over = {{ {key} = {{ between = {ends}, tolerance = {tolerance} }} }}\n")
    };
    let of = |key: &str| format!("[search]\n{FAR}over = {{ {key} = {{ between = [0, 1], tolerance = 0.1 }} }}\n");
    let two = ["a", "b"].map(|key| format!("{key} = {{ between = [0, 1], tolerance = 0.1 }}")).join(", ");
    let three = ["a", "b", "c"].map(|key| format!("{key} = {{ between = [0, 1], tolerance = 0.1 }}")).join(", ");
    for (text, message) in [
        ("[search]\nover = {}\n".to_owned(), "`search` lacks the key `boundary`, `minimize` or `maximize`"),
        (format!("[search]\n{FAR}"), "`search` lacks the key `over`"),
        (format!("{SEARCH}{FAR}minimize = \"impacts\"\n"), "`search` must have one of `boundary`, `minimize`"),
        (format!("[search]\n{FAR}over = {{ {three} }}\n"), "must have at most 2 keys with `boundary`, not 3"),
        (over("[1, 0]", "0.1"), "`between` of `search.over` must be two numbers in ascending order, not 1 and 0"),
        (over("[0, 1]", "0"), "`tolerance` of `search.over` must be greater than 0"),
        (over("[0, 1]", "1e-15"), "`tolerance` of `search.over` must be at least 1e-12"),
        (over("[0, 1]", "0.1, logarithmic = true"), "must be positive with `logarithmic`, not 0"),
        (over("[1, 2]", "1.5, logarithmic = true"), "less than the ratio of `between` less 1, 1, not 1.5"),
        (over("[0, 1, 2]", "0.1"), "array of length 2"),
        (
            format!("{SEARCH}boundary = {{ metric = \"final_base_x\" }}\n"),
            "`search.boundary` needs `value` and `tolerance`",
        ),
        (format!("{SEARCH}{FAR}follow = [\"seed\"]\n"), "`search.follow.0` names `seed`, which is not swept"),
        (
            format!("{SEARCH}{FAR}[sweep.grid]\n\"robot.base.linear_velocity.0\" = [0.5, 1.0]\n"),
            "which is swept: a key is either swept or searched",
        ),
        (of("\"robot.model\""), "not a number"),
        (of("\"search.check\""), "which cannot be searched"),
        (format!("{SEARCH}minimize = \"impacts\"\n"), "`search` lacks the key `runs`"),
        (format!("{SEARCH}minimize = \"impact\"\nruns = 9\n"), "names no numeric column of the summary: `impact`"),
        (format!("{SEARCH}minimize = \"impacts\"\nruns = 0\n"), "`search.runs` must be at least 1, not 0"),
        (format!("{SEARCH}minimize = \"impacts\"\nruns = 9\npopulation = 3\n"), "must be at least 4, not 3"),
        (format!("{SEARCH}minimize = \"impacts\"\nruns = 9\ncheck = 3\n"), "it is for a boundary over one key"),
        (format!("{SEARCH}{FAR}runs = 9\n"), "it is for two keys, or `minimize` or `maximize`"),
        (
            format!("[search]\n{FAR}squares = 7\nruns = 9\nover = {{ {two} }}\n"),
            "must be a power of two from 4 to 1024, not 7",
        ),
        (format!("{SEARCH}{FAR}require = {{ outcome = \"passed\" }}\n"), "it is for `minimize` or `maximize`"),
    ] {
        let place = place(&[&text]);
        let done = place.runner(&["check", "s.toml"]).exits(2);
        assert!(done.stderr.contains(message), "{message}\n{}", done.stderr);
    }
    let place = place(&[SEARCH, FAR, CELLS]);
    let done = run(&place, "results", &["--filter", "robot.base.linear_velocity.0 > 1"]).exits(2);
    assert!(done.stderr.contains("cannot select runs"), "{}", done.stderr);
    run(&place, "results", &["--filter", "floor.friction == 0.4"]).exits(0);
    assert_eq!(searches(&place, "results").len(), 2);
}
