//! Large files are read in a time proportional to their size, or refused. Each of these took
//! minutes when the time was quadratic.

use super::targets::{motion, scenario, tree, urdf};
use stiction::scenario::Diagnostics;

const BLOCK: &str = "robot.model = \"../robots/block/block.toml\"\n";

/// Errors of a scenario, before it is checked against its robot.
#[track_caller]
fn refused(text: &str) -> Diagnostics {
    let file = stiction::scenario::parse(&tree::root().join("scenarios/large.toml"), text).unwrap();
    let expansion = match file.expansion(&[], 10_000) {
        Ok(expansion) => expansion,
        Err(wrong) => return wrong,
    };
    expansion.check(&mut |_| {}).expect_err("it is sound")
}

/// Lines generated from their indices.
fn lines(count: usize, line: impl Fn(usize) -> String) -> String {
    (0..count).map(line).collect()
}

#[test]
fn too_long_lists_are_refused_with_their_position() {
    let event = |i| format!("[[event]]\nat = {i}e-4\nset = {{ \"floor.friction\" = 0.3 }}\n");
    let task = |_| "[[task]]\ntype = \"posture\"\njoints = { a = 1.0 }\n".to_owned();
    let corners = lines(1001, |i| format!("[{i}, {}], ", i * i));
    let cases = [
        (lines(1001, event), "`event` has 1001 entries, at most 1000 are allowed"),
        (lines(10_001, task), "`task` has 10001 entries, at most 10000 are allowed"),
        (
            format!("[floor]\npatches = [{{ friction = 0.1, polygon = [{corners}] }}]\n"),
            "has 1001 corners, at most 1000",
        ),
        (
            format!("[sweep.grid]\n{}", lines(1001, |i| format!("k{i} = [1]\n"))),
            "`k1000` is one too many: at most 1000 keys",
        ),
        (
            format!("[sweep]\nlist = [{}]\n", lines(1001, |i| format!("{{ k{i} = 1 }}, "))),
            "`k1000` is one too many: at most 1000 keys",
        ),
    ];
    for (text, message) in cases {
        let wrong = refused(&format!("{BLOCK}{text}"));
        assert!(wrong.iter().any(|d| d.message.contains(message) && d.position.is_some()), "{message}: {}", wrong.0[0]);
    }
}

#[test]
fn of_many_errors_the_first_are_shown_and_the_others_counted() {
    let wrong = refused(&format!("{BLOCK}{}", lines(100_000, |i| format!("k{i} = 1\n"))));
    assert_eq!(wrong.len(), 201);
    assert_eq!(wrong.0[200].message, "there are 99800 more errors");
    // Errors that only the check against the robot finds.
    scenario::take(format!("{BLOCK}[robot.posture]\n{}", lines(50_000, |i| format!("j{i} = 1\n"))).as_bytes());
}

#[test]
fn motions_with_many_tracks_are_read() {
    let names = lines(200_000, |i| format!(",j{i}"));
    motion::take(format!("ctime{names}\n0{}\n", ",1".repeat(200_000)).as_bytes());
    let joints = lines(50_000, |i| format!("j{i} = 1, ")).replace(", ", ",");
    motion::take(format!("p[[posture]]\nat = 0\njoints = {{{}}}\n", joints.trim_end_matches(',')).as_bytes());
    let joint = |i| format!("JOINT a{i} {{ OFFSET 0 0 0 CHANNELS 1 Xrotation ");
    let skeleton =
        format!("ROOT a {{ OFFSET 0 0 0 CHANNELS 1 Xrotation {}{}", lines(50_000, joint), "} ".repeat(50_001));
    motion::take(format!("bHIERARCHY {skeleton} MOTION Frames: 1 Frame Time: 1 {}", "1 ".repeat(50_001)).as_bytes());
}

#[test]
fn urdfs_with_many_parts_are_read() {
    let inertial = "<inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>";
    let robot = |inside: &str| format!("<robot name=\"r\">{inside}</robot>");
    let link = |i| format!("<link name=\"l{i}\">{inertial}</link>");
    let joint = |i: usize| {
        let of = if i == 0 { 1 } else { i - 1 };
        format!(
            "<joint name=\"j{i}\" type=\"continuous\"><parent link=\"l0\"/><child link=\"l{}\"/><axis xyz=\"0 0 1\"/>\
             <mimic joint=\"j{of}\"/></joint>",
            i + 1
        )
    };
    urdf::take(robot(&format!("{}{}", lines(2001, link), lines(2000, joint))).as_bytes());
    urdf::take(robot(&format!("{}{}", link(0), lines(100_000, |i| format!("<x{i}/>")))).as_bytes());
    let visual = "<visual><geometry><box size=\"1 1 1\"/></geometry><material name=\"m\"/></visual>".repeat(20_000);
    let materials = lines(20_000, |i| format!("<material name=\"x{i}\"/>"));
    urdf::take(robot(&format!("<link name=\"a\">{inertial}{visual}</link>{materials}")).as_bytes());
    let crowded =
        format!("<robot name=\"r\" {}><link name=\"a\"/></robot>", lines(100_000, |i| format!("a{i}=\"1\" ")));
    let error = stiction::robot::parse("r.urdf".as_ref(), crowded, None).unwrap_err();
    assert!(
        error.to_string().contains("r.urdf:1:") && error.to_string().contains("more than 1000 attributes"),
        "{error}"
    );
}
