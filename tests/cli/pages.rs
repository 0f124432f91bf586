//! Tests of `docs/tutorial.md` and `docs/extending.md`: the shown files exist and their scenarios
//! pass.

use std::fs;
use std::path::Path;

use super::Place;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn page(name: &str) -> String {
    fs::read_to_string(root().join("docs").join(name)).unwrap()
}

/// Contents of all files below a folder with one of these extensions.
fn texts(folder: &str, extensions: &[&str]) -> Vec<String> {
    let (mut folders, mut found) = (vec![root().join(folder)], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().and_then(|e| e.to_str()).is_some_and(|e| extensions.contains(&e)) {
                found.push(fs::read_to_string(path).unwrap());
            }
        }
    }
    found
}

/// Contents of the fenced code blocks in one of these languages.
fn blocks(page: &str, languages: &[&str]) -> Vec<String> {
    let (mut found, mut lines) = (Vec::new(), page.lines());
    while let Some(line) = lines.next() {
        if line.strip_prefix("```").is_some_and(|language| languages.contains(&language)) {
            found.push(lines.by_ref().take_while(|l| *l != "```").map(|l| format!("{l}\n")).collect());
        }
    }
    found
}

/// Each tutorial file consists of blocks of the page, after its `#:schema` line.
#[test]
fn the_tutorial_shows_complete_files() {
    let blocks = blocks(&page("tutorial.md"), &["toml"]);
    let files = texts("scenarios/tutorial", &["toml"]);
    assert!(blocks.len() >= files.len() && files.len() >= 4, "{} {}", blocks.len(), files.len());
    for block in &blocks {
        assert!(files.iter().any(|file| file.contains(block)), "no file has\n{block}");
    }
    for file in &files {
        let (_, rest) = file.split_once('\n').unwrap();
        let shown: Vec<_> = blocks.iter().filter(|block| rest.contains(*block)).map(String::as_str).collect();
        assert_eq!(rest, shown.join("\n"));
    }
}

#[test]
fn code_blocks_of_extending_exist_in_the_repository() {
    let page = page("extending.md");
    for (folder, extensions, languages) in [
        ("scenarios/extending", &["toml", "urdf", "luau"][..], &["toml", "xml", "lua"][..]),
        ("simulator/src", &["rs"][..], &["rust"][..]),
    ] {
        let (files, blocks) = (texts(folder, extensions), blocks(&page, languages));
        assert!(blocks.len() >= 3, "{}", blocks.len());
        for block in &blocks {
            assert!(files.iter().any(|file| file.contains(block)), "nothing below {folder} has\n{block}");
        }
    }
}

/// The scenarios check themselves: by closed forms, except for the standing and the pushed robot.
#[test]
fn scenarios_of_both_pages_pass() {
    let place = Place::new();
    let scenarios = ["scenarios/extending", "scenarios/tutorial"].map(|folder| root().join(folder));
    let scenarios = scenarios.each_ref().map(|path| path.to_str().unwrap());
    place.runner(&[scenarios[0], scenarios[1], "--no-log", "--filter", "name != \"work-precision\""]).exits(0);
    assert_eq!(place.summary("results").column("scenario"), ["braked", "nodder", "block", "pushed", "standing"]);
    place.runner(&["check", "--strict", scenarios[1]]).exits(0);
}
