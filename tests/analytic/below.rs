//! A start below the floor is an error of the scenario; without a position floor and terrain give the height.

use crate::support::runs::{root, run, setup};
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
    // Without soles the floor has no meaning if only these touch.
    let no_soles = |contact: &str, base: &str| {
        format!(
            "robot = {{ model = \"robots/block/block.toml\", soles = [], contact = \"{contact}\", base = {{ {base} }} }}\n"
        )
    };
    accepted(&no_soles("soles", "position = [0, 0, -1]"));
    refused(&no_soles("bodies", "position = [0, 0, -1]"));
    accepted(&no_soles("bodies", ""));
}

/// A rod of 0.5 m on a block of 0.2 m, which is fixed half in the floor.
#[test]
fn the_root_of_a_fixed_base_may_be_in_the_floor_and_no_other_link() {
    let folder = tempfile::tempdir().unwrap();
    let link = |name: &str, z: f64, size: &str| {
        format!(
            r#"<link name="{name}"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
            <collision><origin xyz="0 0 {z}"/><geometry><box size="{size}"/></geometry></collision></link>"#
        )
    };
    let urdf = format!(
        r#"<robot name="crane"><link name="world"/>{}{}<joint name="weld" type="fixed"><parent link="world"/><child link="foot"/></joint>
        <joint name="hinge" type="revolute"><parent link="foot"/><child link="rod"/><axis xyz="0 1 0"/>
        <limit lower="-3.2" upper="3.2" effort="10" velocity="10"/></joint></robot>"#,
        link("foot", 0.0, "0.2 0.2 0.2"),
        link("rod", 0.3, "0.02 0.02 0.5"),
    );
    std::fs::write(folder.path().join("crane.urdf"), urdf).unwrap();
    let crane = |angle: f64, more: &str| {
        let path = folder.path().join("crane.urdf");
        format!("duration = 0.01\n{more}robot = {{ model = {path:?}, posture = {{ hinge = {angle} }} }}\n")
    };
    accepted(&crane(0.0, ""));
    let error = refused(&crane(3.0, ""));
    assert!(
        error.contains("link `rod` starts") && error.contains("`floor.plane = false` removes the floor"),
        "{error}"
    );
    accepted(&crane(3.0, "floor.plane = false\n"));
}

/// Height of the block, 0.2 x 0.2 x 0.1 m, that starts without a position.
#[track_caller]
fn height(base: &str, more: &str) -> f64 {
    let heights = ["soles", "bodies"].map(|contact| setup(&block(contact, base, more)).start.position.z);
    assert!((heights[0] - heights[1]).abs() < 1e-12, "{heights:?}");
    heights[0]
}

#[test]
fn without_a_position_a_robot_starts_on_floor_and_terrain() {
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
    near(height("", ""), 0.05);
    let terrain = |kind: &str| format!("[[terrain]]\n{kind}\n");
    // A box of which half is under the block; one beside it; one above, whose underside is no obstacle.
    let step = |x: f64| terrain(&format!("type = \"box\"\nsize = [0.2, 1, 0.3]\nposition = [{x}, 0, 0.15]"));
    near(height("", &step(0.15)), 0.35);
    near(height("", &step(0.2)), 0.05);
    let high = terrain("type = \"box\"\nsize = [1, 1, 0.1]\nposition = [0, 0, 2]");
    near(height("", &high), 2.1);
    // The lower edge at x = 0.1 touches the ramp first, which rises by 0.25 from x = -0.5.
    let ramp = terrain("type = \"ramp\"\nsize = [2, 2, 0.5]\nposition = [-0.5, 0, 0]");
    near(height("", &ramp), 0.05 + 0.25 * 0.6);
    // Turned with the ramp it lies on it: above the origin the ramp is 0.125 m high.
    let slope = 0.25_f64.atan();
    near(height(&format!("rpy = [0, {}, 0]", -slope), &ramp), 0.125 + 0.05 / slope.cos());
    // Without a plane the terrain may be lower; where there is none, the plane's height counts.
    let low = terrain("type = \"box\"\nsize = [1, 1, 0.1]\nposition = [0, 0, -1]");
    near(height("", &format!("floor = {{ plane = false }}\n{low}")), -0.9);
    near(height("", &format!("floor = {{ plane = false, height = 0.5 }}\n{}", step(3.0))), 0.55);
    near(height("", &low), 0.05);
}

/// HOAP-2, thrown about, starts on rough ground with a body on it: lowered by 10 um it is refused.
#[test]
fn without_a_position_some_body_touches_the_terrain() {
    let terrain = "[[terrain]]\ntype = \"heightfield\"\nfile = \"scenarios/terrain/rubble.csv\"\nposition = [0.01, 0.02, 0.1]\nsize = [2.0, 2.0]\n";
    for rpy in ["[0, 0, 0]", "[0, \"90 deg\", 0]", "[0.3, -1.1, 0.4]"] {
        let text = |position: &str| {
            format!(
                "duration = 0.01\nrobot = {{ model = \"robots/hoap2/hoap2.toml\", contact = \"bodies\", base = {{ {position} rpy = {rpy} }} }}\n{terrain}"
            )
        };
        let z = setup(&text("")).start.position.z;
        let error = refused(&text(&format!("position = [0, 0, {}],", z - 1e-5)));
        assert!(error.contains("overlap by"), "{error}");
        accepted(&text(&format!("position = [0, 0, {}],", z + 1e-9)));
    }
}
