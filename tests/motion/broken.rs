//! Broken motions are refused with file, line and column, the value found and the value expected.

use super::Folder;

/// A broken input: file, its text, the rest of the task, the position reported, part of the
/// message.
struct Broken(&'static str, &'static str, &'static str, &'static str, &'static str);

const POSTURE: &str =
    "[[posture]]\nat = 0\njoints = { left_knee = 0.5 }\n[[posture]]\nat = 1\njoints = { left_knee = 0.6 }\n";

const TABLE: &[Broken] = &[
    // The file by itself.
    Broken("m.toml", "[[posture]]\nat = 0\njoint = {}\n", "", "m.toml:3:1", "unknown field `joint`"),
    Broken("m.toml", "[[posture]]\nat = -1\njoints = { left_knee = 0.5 }\n", "", "m.toml:2:6", "0 or greater, not -1"),
    Broken("m.toml", "[[posture]]\nat = 1979-05-27\n", "", "m.toml:2:6", "the date or time 1979-05-27, expected f64"),
    Broken("m.csv", "t,left_knee\n0,0.5\n", "", "m.csv:1:1", "must be `time`, not \"t\""),
    Broken("m.csv", "time,left_knee\n0,0.5\n0,0.6\n", "", "m.csv:3:1", "after that of the line before, 0, not 0"),
    Broken("m.csv", "time,left_knee\n0,a\n", "", "m.csv:2:3", "`left_knee` must be a finite number, not \"a\""),
    Broken("m.csv", "time,left_knee\n0\n", "", "m.csv:2:1", "has 1 cells, the header 2"),
    // The file against the robot.
    Broken("m.csv", "time,left_kne\n0,0.5\n", "", "m.csv:1:6", "has no joint `left_kne`"),
    Broken(
        "m.csv",
        "time,left_knee\n0,0.5\n1,2.5\n",
        "",
        "m.csv:3:3",
        "`left_knee` = 2.5 at 1 s is outside its range, -0.0175 to 2.2689 rad",
    ),
    Broken(
        "m.toml",
        "[[posture]]\nat = 0\njoints = { left_knee = \"-10 deg\" }\n",
        "",
        "m.toml:3:24",
        "outside its range",
    ),
    Broken(
        "m.csv",
        "time,left_knee\n0,1\n0.2,0.05\n0.4,0.05\n0.6,1\n",
        "",
        "m.csv:1:6",
        "the curve of `left_knee` reaches -0.",
    ),
    // The task against the file.
    Broken("m.toml", POSTURE, "joints = [\"left_ankle_pitch\"]", "s.toml:6:11", "does not move `left_ankle_pitch`"),
    Broken("m.toml", POSTURE, "joints = [\"left_knee\", \"left_knee\"]", "s.toml:6:24", "is listed twice"),
    Broken("m.toml", POSTURE, "loop = true", "m.toml:6:24", "`left_knee` = 0.6 at 1 s is not 0.5 as at 0 s"),
    Broken(
        "m.csv",
        "time,left_knee,right_knee\n0,0.5,\n1,0.5,0.5\n",
        "loop = true",
        "m.csv:3:7",
        "`right_knee` has no value at 0 s",
    ),
    Broken(
        "m.toml",
        POSTURE,
        "loop = true\nends = \"natural\"",
        "s.toml:7:8",
        "`task.0.ends` has no meaning with `loop`",
    ),
    Broken("m.toml", POSTURE, "speed = 0", "s.toml:6:9", "must be greater than 0"),
    Broken("m.toml", POSTURE, "blend = -1", "s.toml:6:9", "must be 0 or greater"),
    Broken(
        "m.toml",
        POSTURE,
        "start = 1\nchange = [{ at = 0.5, speed = 2 }]",
        "s.toml:7:18",
        "must not be before `start` = 1, not 0.5",
    ),
    Broken(
        "m.toml",
        POSTURE,
        "change = [{ at = 1, speed = 2 }, { at = 1, speed = 1 }]",
        "s.toml:6:41",
        "after the previous change",
    ),
    Broken(
        "m.toml",
        POSTURE,
        "change = [{ at = 1, speed = 2 }, { at = 1.2, speed = 1 }]",
        "s.toml:6:41",
        "at least `blend` = 0.5 after",
    ),
    Broken("m.toml", POSTURE, "ends = \"free\"", "s.toml:6:8", "cannot be \"free\""),
    Broken("m.txt", POSTURE, "", "s.toml:5:8", "ends in `.toml` or `.csv` or `.mcap`"),
];

#[test]
fn playback() {
    for Broken(file, text, task, place, expected) in TABLE {
        let folder = Folder::with(&[(file, text)]);
        let scenario = format!(
            "robot = {{ model = \"ROBOTS/hoap2/hoap2.toml\" }}\n\n[[task]]\ntype = \"playback\"\nfile = \"{file}\"\n{task}\n"
        );
        reports(&folder, &scenario, place, expected);
    }
}

#[track_caller]
fn reports(folder: &Folder, scenario: &str, place: &str, expected: &str) {
    let found = folder.refused(scenario);
    let first = &found.0[0];
    assert!(first.message.contains(expected), "{scenario}: {found}");
    assert!(first.location().ends_with(place), "{scenario}: {} {found}", first.location());
    assert_eq!(found.len(), 1, "{found}");
}

#[test]
fn a_missing_file_is_an_error() {
    let folder = Folder::with(&[]);
    let task = "robot = { model = \"ROBOTS/hoap2/hoap2.toml\" }\n[[task]]\ntype = \"playback\"\nfile = \"no.toml\"\n";
    reports(&folder, task, "s.toml:4:8", "cannot read");
}

#[test]
fn sine() {
    let table = [
        ("joints = {}", "s.toml:4:10", "must name at least one joint"),
        ("joints = { left_knee = { frequency = 1 } }", "s.toml:4:24", "lacks the key `amplitude`"),
        ("joints = { left_knee = { amplitude = 1, frequency = 0 } }", "s.toml:4:53", "must be greater than 0"),
        ("joints = { left_kne = { amplitude = 1 } }", "s.toml:4:12", "has no joint `left_kne`"),
        (
            "joints = { left_knee = { amplitude = 1 } }\nduration = 0.7",
            "s.toml:5:12",
            "at least twice `ramp` = 0.5, not 0.7",
        ),
        (
            "joints = { left_knee = { amplitude = 1 } }\nchange = [{ at = 1, joints = { right_knee = { amplitude = 1 } } }]",
            "s.toml:5:32",
            "`task.0` does not swing `right_knee`",
        ),
        (
            "joints = { left_knee = { amplitude = 1 } }\nchange = [{ at = 1, joints = { left_knee = { phase = 1 } } }]",
            "s.toml:5:46",
            "unknown key `phase`",
        ),
    ];
    for (task, place, expected) in table {
        let scenario =
            format!("robot = {{ model = \"ROBOTS/hoap2/hoap2.toml\" }}\n[[task]]\ntype = \"sine\"\n{task}\n");
        reports(&Folder::with(&[]), &scenario, place, expected);
    }
}

#[test]
fn mocap() {
    const BVH: &str = "HIERARCHY ROOT a { OFFSET 0 0 0 CHANNELS 2 Xrotation Yrotation End Site { OFFSET 0 0 0 } }\nMOTION\n\
                       Frames: 1\nFrame Time: 0.1\n1 2\n";
    let x = "\"a.Xrotation\" = { joint = \"left_knee\" }";
    let table = [
        (
            BVH.replace("1 2", "1"),
            format!("map = {{ {x} }}"),
            "m.bvh:6:1",
            "ends too early: `a.Yrotation` of frame 0 of 1",
        ),
        (BVH.replace("1 2", "1 x"), format!("map = {{ {x} }}"), "m.bvh:5:3", "not \"x\""),
        (BVH.into(), "map = {}".into(), "s.toml:5:7", "must map at least one channel"),
        (
            BVH.into(),
            "map = { \"a.Zrotation\" = { joint = \"left_knee\" } }".into(),
            "s.toml:5:9",
            "no channel `a.Zrotation`",
        ),
        (
            BVH.into(),
            "map = { \"a.Xrotation\" = { joint = \"left_kne\" } }".into(),
            "s.toml:5:35",
            "no joint `left_kne`",
        ),
        (
            BVH.into(),
            format!("map = {{ {x}, \"a.Yrotation\" = {{ joint = \"left_knee\" }} }}"),
            "s.toml:5:76",
            "\"left_knee\" is moved already by \"a.Xrotation\"",
        ),
        (BVH.into(), format!("map = {{ {x} }}\nsmoothing = -1"), "s.toml:6:13", "must be 0 or greater"),
    ];
    for (file, task, place, expected) in table {
        let folder = Folder::with(&[("m.bvh", &file)]);
        let scenario = format!(
            "robot = {{ model = \"ROBOTS/hoap2/hoap2.toml\" }}\n[[task]]\ntype = \"mocap\"\nfile = \"m.bvh\"\n{task}\n"
        );
        reports(&folder, &scenario, place, expected);
    }
}
