//! The schemas that are kept in the tree for editors and other programs.

use std::fs;
use std::path::Path;

use super::Place;

fn tree(path: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

#[test]
fn they_are_those_that_the_program_prints() {
    let place = Place::new();
    let mut kept: Vec<String> =
        fs::read_dir(tree("docs/schema")).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    kept.sort();
    assert_eq!(kept, ["messages.json", "robot.json", "scenario.json"]);
    for format in ["messages", "robot", "scenario"] {
        let file = format!("docs/schema/{format}.json");
        let printed = place.runner(&["schema", format]).exits(0).stdout;
        assert!(
            fs::read_to_string(tree(&file)).unwrap() == printed,
            "{file} is not up to date: run `cargo run --release -- schema {format} > {file}`"
        );
    }
}

/// Every `#:schema` line of the tree leads from its file to a schema of its kind.
#[test]
fn lines_for_editors_lead_to_them() {
    let mut found = 0;
    for (folder, schema) in [("scenarios", "scenario.json"), ("robots", "robot.json")] {
        let mut folders = vec![tree(folder)];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path);
                    continue;
                }
                if path.extension().is_none_or(|e| e != "toml") {
                    continue;
                }
                let text = fs::read_to_string(&path).unwrap();
                let Some(target) = text.lines().next().and_then(|line| line.strip_prefix("#:schema ")) else {
                    continue;
                };
                let target = path.parent().unwrap().join(target).canonicalize().unwrap();
                assert_eq!(target, tree("docs/schema").join(schema).canonicalize().unwrap(), "{}", path.display());
                found += 1;
            }
        }
    }
    assert!(found >= 3, "{found}");
}

#[test]
fn a_line_for_editors_changes_nothing() {
    let place = Place::new();
    place.block("s.toml", "");
    let plain = place.runner(&["list", "s.toml"]).exits(0).stdout;
    let text = fs::read_to_string(place.path("s.toml")).unwrap();
    place.write("s.toml", format!("#:schema ../docs/schema/scenario.json\n{text}"));
    assert_eq!(place.runner(&["list", "s.toml"]).exits(0).stdout, plain, "not even the key");
    let robot = fs::read_to_string(place.path("block/block.toml")).unwrap();
    place.write("block/block.toml", format!("#:schema ../docs/schema/robot.json\n{robot}"));
    place.runner(&["check", "s.toml"]).exits(0);
}
