//! What is named as an input and is no file, or one without end: a clear error, at once and within little memory.
#![cfg(unix)]

use std::fs::File;
use std::os::unix::net::UnixListener;

use crate::cli::{Done, Place};

/// The program with an address space of 2 GB, for no longer than half a minute.
#[track_caller]
fn limited(place: &Place, arguments: &str) -> Done {
    let done = place.shell(&format!("ulimit -v 2000000; exec timeout 30 \"$0\" {arguments} < /dev/zero"));
    assert_ne!(done.code, Some(124), "it hangs: {}", done.stderr);
    done
}

/// Things that are no files, in a place: how they are called and what is said of them.
fn things(place: &Place) -> Vec<(String, &'static str)> {
    let done = place.shell("mkfifo pipe");
    assert_eq!(done.code, Some(0), "{}", done.stderr);
    let socket = place.path("socket");
    // It stays when its listener is gone.
    drop(UnixListener::bind(&socket).unwrap());
    let device = "it is a pipe or a device, not a file";
    let words = [
        ("pipe", device),
        ("socket", device),
        ("/dev/zero", device),
        ("/dev/stdin", device),
        ("block", "it is a folder, not a file"),
    ];
    let mut things: Vec<_> = words.map(|(name, words)| (name.to_owned(), words)).into();
    // More than is read, and takes no room.
    File::create(place.path("large")).unwrap().set_len(3 << 30).unwrap();
    things.push(("large".into(), "it is larger than"));
    things
}

#[test]
fn a_scenario() {
    let place = Place::new();
    for (thing, words) in things(&place) {
        // A folder stands for the scenarios in it.
        if thing == "block" {
            continue;
        }
        let done = limited(&place, &format!("check {thing}")).exits(2);
        assert!(done.stderr.contains(words), "{thing}: {}", done.stderr);
    }
}

#[test]
fn a_robot_and_its_urdf() {
    let place = Place::new();
    for (thing, words) in things(&place) {
        for ending in ["toml", "urdf"] {
            // The ending says what it is.
            let link = place.path(&format!("link.{ending}"));
            let _ = std::fs::remove_file(&link);
            std::os::unix::fs::symlink(&thing, &link).unwrap();
            place.write("s.toml", format!("robot.model = \"link.{ending}\"\n"));
            let done = limited(&place, "check s.toml").exits(2);
            assert!(done.stderr.contains(words), "{thing}: {}", done.stderr);
            let done = limited(&place, &format!("inspect link.{ending}")).exits(2);
            assert!(done.stderr.contains(words), "{thing}: {}", done.stderr);
        }
        place.write("r.toml", format!("urdf = \"{thing}\"\n"));
        let done = limited(&place, "inspect r.toml").exits(2);
        assert!(done.stderr.contains(words) && done.stderr.contains("r.toml:1:8"), "{thing}: {}", done.stderr);
    }
}

#[test]
fn files_of_tasks_and_forces() {
    let place = Place::new();
    for (thing, words) in things(&place) {
        for (kind, ending) in [("task", "luau"), ("task", "csv"), ("force", "luau")] {
            let link = place.path(&format!("link.{ending}"));
            let _ = std::fs::remove_file(&link);
            std::os::unix::fs::symlink(&thing, &link).unwrap();
            let name = if ending == "csv" { "playback" } else { "script" };
            place.block("s.toml", &format!("[[{kind}]]\ntype = \"{name}\"\nfile = \"link.{ending}\"\n"));
            let done = limited(&place, "check s.toml").exits(2);
            assert!(done.stderr.contains(words) && done.stderr.contains("s.toml:5:8"), "{thing}: {}", done.stderr);
        }
    }
}

#[test]
fn a_mesh() {
    let place = Place::new();
    for (thing, _) in things(&place) {
        let link = place.path("link.stl");
        let _ = std::fs::remove_file(&link);
        std::os::unix::fs::symlink(&thing, &link).unwrap();
        place.write(
            "r.urdf",
            "<robot name=\"r\"><link name=\"a\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" \
             ixz=\"0\" iyz=\"0\"/></inertial><visual><geometry><mesh filename=\"link.stl\"/></geometry></visual></link></robot>",
        );
        let done = limited(&place, "inspect r.urdf").exits(0);
        let all = done.stdout + &done.stderr;
        assert!(all.contains("visual mesh `link.stl` of link `a` is left out"), "{thing}: {all}");
    }
}

#[test]
fn a_record_and_a_log() {
    let place = Place::new();
    place.block("s.toml", "");
    place.runner(&["s.toml", "--set", "duration=0.01"]).exits(0);
    for (thing, _) in things(&place) {
        // What of results cannot be read is passed over.
        place.write("results/other/0/none", "");
        for name in ["run.json", "log.mcap"] {
            let link = place.path("results/other/0").join(name);
            let _ = std::fs::remove_file(&link);
            std::os::unix::fs::symlink(place.path(&thing), &link).unwrap();
        }
        let done = limited(&place, "report results").exits(0);
        assert!(done.stderr.contains("passed over: results/other/0/run.json"), "{thing}: {}", done.stderr);
        limited(&place, "export results/other/0 --list-columns").exits(2);
        // A folder without a log of its own is one of results, here of none.
        let done = limited(&place, "view results/other/0 -o page.html");
        assert!(matches!(done.code, Some(2 | 4)), "{thing}: {}", done.stderr);
    }
}

#[test]
fn entities_that_grow_are_refused() {
    let laughs: String =
        (1..10).map(|i| format!("<!ENTITY a{i} \"{}\">", format!("&a{};", i - 1).repeat(10))).collect();
    let document = |root: &str, body: &str| {
        format!(
            "<?xml version=\"1.0\"?><!DOCTYPE {root} [<!ENTITY a0 \"ha\">{laughs}]><{root} name=\"r\">{body}</{root}>"
        )
    };
    let place = Place::new();
    place.write("r.urdf", document("robot", "&a9;"));
    let done = limited(&place, "inspect r.urdf").exits(2);
    assert!(done.stderr.contains("the XML is not well-formed"), "{}", done.stderr);
    place.write("external.urdf", "<!DOCTYPE robot SYSTEM \"/dev/zero\"><robot name=\"r\"><link name=\"a\"/></robot>");
    let done = limited(&place, "inspect external.urdf").exits(2);
    assert!(done.stderr.contains("external.urdf:1"), "{}", done.stderr);
    place.write("mesh.dae", document("COLLADA", "&a9;"));
    place.write(
        "m.urdf",
        "<robot name=\"r\"><link name=\"a\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" \
         ixz=\"0\" iyz=\"0\"/></inertial><visual><geometry><mesh filename=\"mesh.dae\"/></geometry></visual></link></robot>",
    );
    let done = limited(&place, "inspect m.urdf").exits(0);
    let all = done.stdout + &done.stderr;
    assert!(all.contains("visual mesh `mesh.dae` of link `a` is left out"), "{all}");
}

/// The file that tells of each run must be one: a pipe would wait for another end, or keep nothing.
#[test]
fn the_list_of_runs() {
    let place = Place::new();
    place.block("s.toml", "");
    limited(&place, "s.toml --set duration=0.05 -o r").exits(0);
    place.shell("rm r/runs.jsonl && mkfifo r/runs.jsonl").exits(0);
    for arguments in ["s.toml -o r", "s.toml -o r --resume"] {
        let done = limited(&place, arguments).exits(2);
        assert!(done.stderr.contains("r/runs.jsonl: exists and is not a file: remove it"), "{}", done.stderr);
    }
}

/// A file with more mistakes than anybody reads is done with as soon as they are told.
#[test]
fn a_scenario_of_mistakes() {
    let place = Place::new();
    let keys: String = (0..200_000).map(|i| format!("a{i} = 1\n")).collect();
    place.write("s.toml", keys);
    let done = limited(&place, "check s.toml").exits(2);
    assert!(done.stderr.contains("errors"), "{}", &done.stderr[done.stderr.len() - 200..]);
    let done = limited(&place, "check s.toml --message-format json").exits(2);
    assert!(done.stdout.contains("\"key\":\"a17\""), "{}", &done.stdout[..500]);
}
