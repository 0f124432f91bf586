//! Tests of inputs that are no regular files or too large: an error without delay and within little
//! memory.
#![cfg(unix)]

use std::fs::File;
use std::os::unix::net::UnixListener;

use crate::cli::{Done, Place};

/// Runs the program with an address space of 2 GB for at most half a minute.
#[track_caller]
fn limited(place: &Place, arguments: &str) -> Done {
    let done = place.shell(&format!("ulimit -v 2000000; exec timeout 300 \"$0\" {arguments} < /dev/zero"));
    assert_ne!(done.code, Some(124), "timeout: {}", done.stderr);
    done
}

/// Creates special files. Returns their names and the expected error messages.
fn special_files(place: &Place) -> Vec<(String, &'static str)> {
    let done = place.shell("mkfifo pipe");
    assert_eq!(done.code, Some(0), "{}", done.stderr);
    let socket = place.path("socket");
    // The socket file remains without a listener.
    drop(UnixListener::bind(&socket).unwrap());
    let device = "it is a pipe or a device, not a file";
    let messages = [
        ("pipe", device),
        ("socket", device),
        ("/dev/zero", device),
        ("/dev/stdin", device),
        ("block", "it is a folder, not a file"),
    ];
    let mut special_files: Vec<_> = messages.map(|(name, message)| (name.to_owned(), message)).into();
    // A sparse file larger than the limit.
    File::create(place.path("large")).unwrap().set_len(3 << 30).unwrap();
    special_files.push(("large".into(), "it is larger than"));
    special_files
}

#[test]
fn special_files_as_scenario_are_refused() {
    let place = Place::new();
    for (special, message) in special_files(&place) {
        // A folder as argument means the scenarios in it.
        if special == "block" {
            continue;
        }
        let done = limited(&place, &format!("check {special}")).exits(2);
        assert!(done.stderr.contains(message), "{special}: {}", done.stderr);
    }
}

#[test]
fn special_files_as_robot_or_urdf_are_refused() {
    let place = Place::new();
    for (special, message) in special_files(&place) {
        for ending in ["toml", "urdf"] {
            // The extension determines the kind of file.
            let link = place.path(&format!("link.{ending}"));
            let _ = std::fs::remove_file(&link);
            std::os::unix::fs::symlink(&special, &link).unwrap();
            place.write("s.toml", format!("robot.model = \"link.{ending}\"\n"));
            let done = limited(&place, "check s.toml").exits(2);
            assert!(done.stderr.contains(message), "{special}: {}", done.stderr);
            let done = limited(&place, &format!("inspect link.{ending}")).exits(2);
            assert!(done.stderr.contains(message), "{special}: {}", done.stderr);
        }
        place.write("r.toml", format!("urdf = \"{special}\"\n"));
        let done = limited(&place, "inspect r.toml").exits(2);
        assert!(done.stderr.contains(message) && done.stderr.contains("r.toml:1:8"), "{special}: {}", done.stderr);
    }
}

#[test]
fn special_files_of_tasks_and_forces_are_refused() {
    let place = Place::new();
    for (special, message) in special_files(&place) {
        for (kind, ending) in [("task", "luau"), ("task", "csv"), ("force", "luau")] {
            let link = place.path(&format!("link.{ending}"));
            let _ = std::fs::remove_file(&link);
            std::os::unix::fs::symlink(&special, &link).unwrap();
            let name = if ending == "csv" { "playback" } else { "script" };
            place.block("s.toml", &format!("[[{kind}]]\ntype = \"{name}\"\nfile = \"link.{ending}\"\n"));
            let done = limited(&place, "check s.toml").exits(2);
            assert!(done.stderr.contains(message) && done.stderr.contains("s.toml:5:8"), "{special}: {}", done.stderr);
        }
    }
}

#[test]
fn special_files_as_mesh_are_left_out() {
    let place = Place::new();
    for (special, _) in special_files(&place) {
        let link = place.path("link.stl");
        let _ = std::fs::remove_file(&link);
        std::os::unix::fs::symlink(&special, &link).unwrap();
        place.write(
            "r.urdf",
            "<robot name=\"r\"><link name=\"a\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" \
             ixz=\"0\" iyz=\"0\"/></inertial><visual><geometry><mesh filename=\"link.stl\"/></geometry></visual></link></robot>",
        );
        let done = limited(&place, "inspect r.urdf").exits(0);
        let all = done.stdout + &done.stderr;
        assert!(all.contains("visual mesh `link.stl` of link `a` is left out"), "{special}: {all}");
    }
}

#[test]
fn special_files_as_record_or_log_are_skipped() {
    let place = Place::new();
    place.block("s.toml", "");
    place.runner(&["s.toml", "--set", "duration=0.01"]).exits(0);
    for (special, _) in special_files(&place) {
        // Unreadable records are skipped.
        place.write("results/other/0/none", "");
        for name in ["run.json", "log.mcap"] {
            let link = place.path("results/other/0").join(name);
            let _ = std::fs::remove_file(&link);
            std::os::unix::fs::symlink(place.path(&special), &link).unwrap();
        }
        let done = limited(&place, "report results").exits(0);
        assert!(done.stderr.contains("passed over: results/other/0/run.json"), "{special}: {}", done.stderr);
        limited(&place, "export results/other/0 --list-columns").exits(2);
        // A folder without a log counts as a folder of results, here an empty one.
        let done = limited(&place, "view results/other/0 -o page.html");
        assert!(matches!(done.code, Some(2 | 4)), "{special}: {}", done.stderr);
    }
}

#[test]
fn expanding_xml_entities_are_refused() {
    let entities: String =
        (1..10).map(|i| format!("<!ENTITY a{i} \"{}\">", format!("&a{};", i - 1).repeat(10))).collect();
    let document = |root: &str, body: &str| {
        format!(
            "<?xml version=\"1.0\"?><!DOCTYPE {root} [<!ENTITY a0 \"ha\">{entities}]><{root} name=\"r\">{body}</{root}>"
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

/// `runs.jsonl` must be a regular file: a pipe would block or store nothing.
#[test]
fn a_pipe_as_list_of_runs_is_refused() {
    let place = Place::new();
    place.block("s.toml", "");
    limited(&place, "s.toml --set duration=0.05 -o r").exits(0);
    place.shell("rm r/runs.jsonl && mkfifo r/runs.jsonl").exits(0);
    for arguments in ["s.toml -o r", "s.toml -o r --resume"] {
        let done = limited(&place, arguments).exits(2);
        assert!(done.stderr.contains("r/runs.jsonl: exists and is not a file: remove it"), "{}", done.stderr);
    }
}

/// A file with very many errors is reported without delay.
#[test]
fn a_scenario_with_many_errors_is_reported_in_time() {
    let place = Place::new();
    let keys: String = (0..200_000).map(|i| format!("a{i} = 1\n")).collect();
    place.write("s.toml", keys);
    let done = limited(&place, "check s.toml").exits(2);
    assert!(done.stderr.contains("errors"), "{}", &done.stderr[done.stderr.len() - 200..]);
    let done = limited(&place, "check s.toml --message-format json").exits(2);
    assert!(done.stdout.contains("\"key\":\"a17\""), "{}", &done.stdout[..500]);
}
