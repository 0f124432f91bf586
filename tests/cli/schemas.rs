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

/// The pages are those that the program prints. Every key, table, word and form on them says what it means.
#[test]
fn reference_pages_are_up_to_date_and_whole() {
    let place = Place::new();
    for format in ["messages", "robot", "scenario"] {
        let file = format!("docs/reference/{format}.md");
        let printed = place.runner(&["schema", format, "--markdown"]).exits(0).stdout;
        assert!(
            fs::read_to_string(tree(&file)).unwrap() == printed,
            "{file} is not up to date: run `cargo run --release -- schema {format} --markdown > {file}`"
        );
        for line in printed.lines() {
            assert!(
                !line.starts_with('|') || !line.trim_end_matches('|').trim_end().ends_with('|'),
                "no meaning: {line}"
            );
        }
        // Links lead to sections, each of which is there once.
        let anchors: Vec<&str> =
            printed.lines().filter_map(|l| l.strip_prefix("<a id=\"")?.strip_suffix("\"></a>")).collect();
        let mut targets: Vec<&str> = printed.split("](#").skip(1).filter_map(|rest| rest.split(')').next()).collect();
        targets.sort_unstable();
        targets.dedup();
        let mut sorted = anchors.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, targets, "{format}");
    }
}

/// No key of the schema is missing on its page, wherever it is nested.
#[test]
fn reference_pages_have_every_key() {
    fn keys(node: &serde_json::Value, found: &mut Vec<String>) {
        if let Some(properties) = node.get("properties").and_then(|p| p.as_object()) {
            found.extend(properties.keys().cloned());
        }
        match node {
            serde_json::Value::Object(map) => map.values().for_each(|value| keys(value, found)),
            serde_json::Value::Array(items) => items.iter().for_each(|value| keys(value, found)),
            _ => {}
        }
    }
    for (format, least) in [("messages", 40), ("robot", 40), ("scenario", 200)] {
        let schema = fs::read_to_string(tree(&format!("docs/schema/{format}.json"))).unwrap();
        let page = fs::read_to_string(tree(&format!("docs/reference/{format}.md"))).unwrap();
        let mut wanted = Vec::new();
        keys(&serde_json::from_str(&schema).unwrap(), &mut wanted);
        assert!(wanted.len() >= least, "{format}: {}", wanted.len());
        for key in wanted {
            // In a line of its own, inside the line of a small table, or as the word that tells variants apart.
            let ways =
                [format!("| `{key}` |"), format!("`{key}`: "), format!("`{key} = \""), format!("`\"{key}\": \"")];
            assert!(ways.iter().any(|way| page.contains(way)), "{format}: {key}");
        }
    }
}
