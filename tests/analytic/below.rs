//! A start below the floor is an error of the scenario.

use super::support::{root, run, setup};
use stiction::assemble;
use stiction::robot;
use stiction::scenario;

/// The errors of the only run of a scenario.
fn errors(text: &str) -> Option<String> {
    let file = scenario::parse(&root().join("test.toml"), text).unwrap_or_else(|e| panic!("{e}"));
    let runs = file.expand(&[]).unwrap_or_else(|e| panic!("{e}"));
    let robot = robot::load(&runs[0].resolve(&runs[0].scenario.robot.model)).unwrap_or_else(|e| panic!("{e}"));
    assemble::setup(&runs[0], &robot).err().map(|e| e.to_string())
}

/// The error of a start that is refused.
#[track_caller]
fn refused(text: &str) -> String {
    errors(text).unwrap_or_else(|| panic!("accepted:\n{text}"))
}

/// Accepts a start.
#[track_caller]
fn accepted(text: &str) {
    setup(text);
}

/// The block, a box of 0.2 x 0.2 x 0.1 m, with this base and `more` settings.
fn block(contact: &str, base: &str, more: &str) -> String {
    format!(
        "duration = 0.1\nrobot = {{ model = \"robots/block/block.toml\", contact = \"{contact}\", base = {{ {base} }} }}\n{more}"
    )
}

#[test]
fn a_link_below_the_floor_is_refused_with_the_height_at_which_it_touches() {
    let on_side = |z: f64| block("bodies", &format!("position = [0, 0, {z}], rpy = [\"90 deg\", 0, 0]"), "");
    let error = refused(&on_side(0.07));
    assert!(error.contains("link `block` starts 0.0300 m below the floor, with the base at z = 0.07 m"), "{error}");
    assert!(error.contains("just touches the floor with `base.position` z = 0.100000"), "{error}");
    assert!(error.contains("test.toml:2:"), "{error}");
    // Rounding of decimals.
    accepted(&on_side(0.1 - 0.9e-6));
    assert!(refused(&on_side(0.1 - 1.1e-6)).contains("1.1e-6 m below"));
    // On a slope of 60 degrees the base rises by twice the depth.
    let slope = "floor = { rpy = [0, \"60 deg\", 0] }\n";
    let error = refused(&block("bodies", "position = [0, 0, 0.06], rpy = [0, \"60 deg\", 0]", slope));
    assert!(
        error.contains("sole `bottom` of link `block` starts 0.0200 m") && error.contains("z = 0.100000"),
        "{error}"
    );
    // Over a floor that is turned upside down there is no such height.
    let error = refused(&block("bodies", "position = [0, 0, 1]", "floor = { rpy = [\"180 deg\", 0, 0] }\n"));
    assert!(error.contains("start farther from the floor"), "{error}");
}

/// The proposed height of HOAP-2, lowered and lying, is accepted and a hundred times the tolerance
/// below it is not.
#[test]
fn the_proposed_height_is_accepted() {
    for rpy in ["[0, 0, 0]", "[0, \"90 deg\", 0]", "[0.3, -1.1, 0.4]"] {
        let text = |z: f64| {
            format!(
                "duration = 0.01\nrobot = {{ model = \"robots/hoap2/hoap2.toml\", contact = \"bodies\", base = {{ position = [0, 0, {z}], rpy = {rpy} }} }}\n"
            )
        };
        let error = refused(&text(0.01));
        let proposed = error.split("z = ").last().and_then(|rest| rest.split_whitespace().next());
        let z: f64 = proposed.and_then(|z| z.parse().ok()).unwrap_or_else(|| panic!("{error}"));
        accepted(&text(z));
        run(&text(z));
        // A sole may be a millimetre deep.
        refused(&text(z - 1.1e-3));
    }
}

#[test]
fn soles_may_start_in_their_band_and_with_imposed_states() {
    let at = |z: f64, more: &str| block("soles", &format!("position = [0, 0, {z}]"), more);
    accepted(&at(0.049, ""));
    let error = refused(&at(0.048, ""));
    assert!(error.contains("sole `bottom` of link `block` starts 0.0020 m below the floor"), "{error}");
    assert!(error.contains("z = 0.050000; `stop.sunk_link = \"ignore\"` allows this start"), "{error}");
    accepted(&at(0.048, "stop.sunk_link = \"ignore\"\n"));
    accepted(&at(0.048, "contact.distance_tolerance = 0.01\n"));
    let forced = "contact.forced = [{ sole = \"bottom\", state = \"free\", from = 0, to = 0.05 }]\n";
    accepted(&at(0.048, forced));
    refused(&at(0.048, &forced.replace("from = 0", "from = 0.01")));
    // With all links touching there is no such exception.
    refused(&block("bodies", "position = [0, 0, 0.048]", "stop.sunk_link = \"ignore\"\n"));
}

/// Upside down its upper face is the deepest, and without the sole it would only end as `fallen`.
#[test]
fn a_link_that_would_end_the_run_at_once_is_refused() {
    let at = |z: f64, more: &str| block("soles", &format!("position = [0, 0, {z}], rpy = [\"180 deg\", 0, 0]"), more);
    let error = refused(&at(0.03, ""));
    assert!(error.contains("link `block` starts 0.0200 m below the floor"), "{error}");
    accepted(&at(0.0495, ""));
    accepted(&at(0.03, "stop.sunk_link = \"ignore\"\n"));
    // Without soles the floor has no meaning.
    accepted("robot = { model = \"robots/block/block.toml\", soles = [], base = { position = [0, 0, -1] } }\n");
    refused("robot = { model = \"robots/block/block.toml\", soles = [], contact = \"bodies\" }\n");
}
