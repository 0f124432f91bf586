//! Tests of the schemas and reference pages in `docs`.

use std::fs;
use std::path::Path;

use super::Place;

fn repository_path(path: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

#[test]
fn schema_files_equal_the_output_of_the_program() {
    let place = Place::new();
    let mut names: Vec<String> = fs::read_dir(repository_path("docs/schema"))
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["fit.json", "messages.json", "robot.json", "scenario.json"]);
    for format in ["fit", "messages", "robot", "scenario"] {
        let file = format!("docs/schema/{format}.json");
        let printed = place.runner(&["schema", format]).exits(0).stdout;
        assert!(
            fs::read_to_string(repository_path(&file)).unwrap() == printed,
            "{file} is not up to date: run `cargo run --release -- schema {format} > {file}`"
        );
    }
}

/// Every `#:schema` line in the repository refers to the schema of its kind of file.
#[test]
fn schema_lines_refer_to_the_schema_files() {
    let mut found = 0;
    for (folder, schema) in [("scenarios", "scenario.json"), ("robots", "robot.json")] {
        let mut folders = vec![repository_path(folder)];
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
                assert_eq!(
                    target,
                    repository_path("docs/schema").join(schema).canonicalize().unwrap(),
                    "{}",
                    path.display()
                );
                found += 1;
            }
        }
    }
    assert!(found >= 3, "{found}");
}

#[test]
fn a_schema_line_changes_no_key() {
    let place = Place::new();
    place.block("s.toml", "");
    let plain = place.runner(&["list", "s.toml"]).exits(0).stdout;
    let text = fs::read_to_string(place.path("s.toml")).unwrap();
    place.write("s.toml", format!("#:schema ../docs/schema/scenario.json\n{text}"));
    assert_eq!(place.runner(&["list", "s.toml"]).exits(0).stdout, plain, "the key must not change either");
    let robot = fs::read_to_string(place.path("block/block.toml")).unwrap();
    place.write("block/block.toml", format!("#:schema ../docs/schema/robot.json\n{robot}"));
    place.runner(&["check", "s.toml"]).exits(0);
}

/// The pages equal the output of the program. Every key, table, name and form has a description.
#[test]
fn reference_pages_are_up_to_date_and_complete() {
    let place = Place::new();
    for format in ["fit", "messages", "robot", "scenario"] {
        let file = format!("docs/reference/{format}.md");
        let printed = place.runner(&["schema", format, "--markdown"]).exits(0).stdout;
        assert!(
            fs::read_to_string(repository_path(&file)).unwrap() == printed,
            "{file} is not up to date: run `cargo run --release -- schema {format} --markdown > {file}`"
        );
        for line in printed.lines() {
            assert!(
                !line.starts_with('|') || !line.trim_end_matches('|').trim_end().ends_with('|'),
                "no description: {line}"
            );
        }
        // Each link target exists exactly once.
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

/// Each page has every key of its schema, at every level of nesting.
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
    for (format, least) in [("fit", 20), ("messages", 40), ("robot", 40), ("scenario", 200)] {
        let schema = fs::read_to_string(repository_path(&format!("docs/schema/{format}.json"))).unwrap();
        let page = fs::read_to_string(repository_path(&format!("docs/reference/{format}.md"))).unwrap();
        let mut expected = Vec::new();
        keys(&serde_json::from_str(&schema).unwrap(), &mut expected);
        assert!(expected.len() >= least, "{format}: {}", expected.len());
        for key in expected {
            // In its own line, within the line of a small table, or as the tag of a variant.
            let forms =
                [format!("| `{key}` |"), format!("`{key}`: "), format!("`{key} = \""), format!("`\"{key}\": \"")];
            assert!(forms.iter().any(|form| page.contains(form)), "{format}: {key}");
        }
    }
}
