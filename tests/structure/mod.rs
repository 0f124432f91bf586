//! Tests that the rooms of the crates import each other only as in the tables "Rooms" of
//! `docs/development.md`. A room is a top-level module of a crate.

mod file_cycles;
mod links;
mod markdown;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Imports of each room.
type Imports = BTreeMap<String, BTreeSet<String>>;

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Folders of the sources, lowest crate first. Each crate exports the rooms below it under their
/// names.
fn sources() -> [PathBuf; 7] {
    ["numerics/src", "models/src", "simulator/src", "format/src", "assembly/src", "runs/src", "src"]
        .map(|folder| repository().join(folder))
}

/// Folder or file of a room.
fn room_path(room: &str) -> PathBuf {
    let candidates = sources().into_iter().flat_map(|source| [source.join(room), source.join(format!("{room}.rs"))]);
    candidates.into_iter().find(|path| path.exists()).unwrap_or_else(|| panic!("there is no room `{room}`"))
}

/// Rooms: folders and files of the sources, except for the crate roots.
fn rooms() -> BTreeSet<String> {
    sources().iter().flat_map(|source| rooms_in(source)).collect()
}

fn rooms_in(source: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(source).unwrap().map(|entry| entry.unwrap().path());
    // Version control may leave empty folders.
    let has_code = |path: &PathBuf| {
        let mut files = Vec::new();
        if path.is_dir() {
            rust_files(path, &mut files)
        } else {
            files.push(path.clone())
        }
        !files.is_empty()
    };
    let stem = |path: PathBuf| path.file_stem().unwrap().to_str().unwrap().to_owned();
    entries.filter(has_code).map(stem).filter(|name| !["lib", "main", "bin"].contains(&name.as_str())).collect()
}

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// Names of rooms in the text after `crate::` or the name of a crate: one, or several in braces.
fn imported_names(text: &str) -> Vec<&str> {
    let name = |text: &str| text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    let Some(inside) = text.strip_prefix('{') else { return vec![&text[..name(text)]] };
    let (mut depth, mut start, mut names) = (0, 0, Vec::new());
    for (at, c) in inside.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            ',' | '}' if depth == 0 => {
                let item = inside[start..at].trim();
                names.push(&item[..name(item)]);
                start = at + 1;
                if c == '}' {
                    break;
                }
            }
            _ => {}
        }
    }
    names.retain(|name| !name.is_empty());
    names
}

/// Imports of each room, without unit tests and comments.
fn imports() -> Imports {
    let mut imports = Imports::new();
    let rooms = rooms();
    for room in &rooms {
        let mut files = Vec::new();
        match room_path(room) {
            folder if folder.is_dir() => rust_files(&folder, &mut files),
            file => files.push(file),
        }
        let room_imports = imports.entry(room.clone()).or_default();
        for file in files {
            let text = fs::read_to_string(&file).unwrap();
            let code = text.split("\nmod tests {").next().unwrap();
            let lines: Vec<&str> = code.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
            let code = lines.join("\n");
            for root in [
                "crate::",
                "stiction::",
                "stiction_assembly::",
                "stiction_format::",
                "stiction_models::",
                "stiction_numerics::",
                "stiction_runs::",
                "stiction_simulator::",
            ] {
                for (at, _) in code.match_indices(root) {
                    if code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':') {
                        continue;
                    }
                    let names = imported_names(&code[at + root.len()..]).into_iter();
                    room_imports.extend(names.filter(|name| rooms.contains(*name) && *name != room).map(str::to_owned));
                }
            }
        }
    }
    imports
}

/// The table of `docs/development.md`: `| `room/` | purpose | imports |`.
fn table() -> Imports {
    let page = fs::read_to_string(repository().join("docs/development.md")).unwrap();
    let section = page.split("\n## Rooms\n").nth(1).expect("a section `Rooms`").split("\n## ").next().unwrap();
    let mut table = Imports::new();
    for line in section.lines().filter(|line| line.starts_with("| `")) {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        assert_eq!(cells.len(), 3, "{line}");
        let room = cells[0].trim_matches('`').trim_end_matches('/').to_owned();
        let listed = cells[2].split(',').map(|name| name.trim().trim_matches('`').to_owned());
        let before = table.insert(room, listed.filter(|name| !name.is_empty()).collect());
        assert!(before.is_none(), "a room is listed twice: {line}");
    }
    table
}

#[test]
fn imports_between_rooms_match_the_table() {
    let (table, imports) = (table(), imports());
    let mut errors = Vec::new();
    for (room, found) in &imports {
        let Some(listed) = table.get(room) else {
            errors.push(format!("`{room}` is not in the table; it imports {found:?}"));
            continue;
        };
        errors.extend(
            found.difference(listed).map(|other| format!("`{room}` imports `{other}`, which the table does not list")),
        );
        errors.extend(
            listed.difference(found).map(|other| format!("`{room}` does not import `{other}`, which the table lists")),
        );
    }
    errors.extend(
        table.keys().filter(|room| !imports.contains_key(*room)).map(|room| format!("there is no room `{room}`")),
    );
    assert!(errors.is_empty(), "{}", errors.join("\n"));
}

/// The module comment of a room: its `mod.rs`, or its file.
fn module_comment(room: &str) -> String {
    let path = room_path(room);
    let file = if path.is_dir() { path.join("mod.rs") } else { path };
    let text = fs::read_to_string(file).unwrap();
    let lines: Vec<&str> = text.lines().map_while(|line| line.strip_prefix("//!")).map(str::trim).collect();
    lines.join(" ")
}

/// Names in backticks.
fn quoted_names(text: &str) -> BTreeSet<String> {
    text.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

#[test]
fn module_comments_name_imports_and_users() {
    let imports = imports();
    let mut errors = Vec::new();
    for (room, listed) in &imports {
        let users: BTreeSet<String> =
            imports.iter().filter(|(_, to)| to.contains(room)).map(|(user, _)| user.clone()).collect();
        let comment = module_comment(room);
        let Some((_, sentences)) = comment.rsplit_once("Imports: ") else {
            errors.push(format!("`{room}`: no sentence `Imports: ...`"));
            continue;
        };
        let Some((first, second)) = sentences.split_once(". Used by: ") else {
            errors.push(format!("`{room}`: no sentence `Used by: ...`"));
            continue;
        };
        for (sentence, names, expected) in [("Imports", first, listed), ("Used by", second, &users)] {
            let names = quoted_names(names);
            if names != *expected {
                errors.push(format!("`{room}`: {sentence}: found {names:?}, expected {expected:?}"));
            }
        }
    }
    assert!(errors.is_empty(), "{}", errors.join("\n"));
}

/// The compiler checks the first as well, without a message about rooms.
#[test]
fn crates_import_those_below_them_and_have_a_table_each() {
    let crates = sources().map(|source| rooms_in(&source));
    let page = fs::read_to_string(repository().join("docs/development.md")).unwrap();
    let imports = imports();
    for (level, (rooms, source)) in crates.iter().zip(sources()).enumerate() {
        let above: BTreeSet<&String> = crates[level + 1..].iter().flatten().collect();
        for room in rooms {
            let found: Vec<&String> = imports[room].iter().filter(|other| above.contains(other)).collect();
            assert!(found.is_empty(), "`{room}` imports {found:?} of a crate above its own");
        }
        let title = source.strip_prefix(repository()).unwrap().display().to_string();
        let table = page.split(&format!("\n`{title}/`:\n\n")).nth(1).expect("a table").split("\n\n").next().unwrap();
        let listed = table.lines().filter_map(|line| line.strip_prefix("| `")?.split_once("/`")).map(|(name, _)| name);
        assert_eq!(listed.map(str::to_owned).collect::<BTreeSet<_>>(), *rooms, "rooms of {title}");
    }
}

/// Repeatedly removes rooms without remaining imports. The remaining rooms are on a cycle or import
/// one.
#[test]
fn rooms_have_no_cycle() {
    let mut remaining = imports();
    loop {
        let free: Vec<String> =
            remaining.iter().filter(|(_, to)| to.is_empty()).map(|(room, _)| room.clone()).collect();
        if free.is_empty() {
            break;
        }
        remaining.retain(|room, _| !free.contains(room));
        for to in remaining.values_mut() {
            to.retain(|room| !free.contains(room));
        }
    }
    assert!(remaining.is_empty(), "rooms on or above a cycle of imports: {remaining:#?}");
}

/// Paths of this repository in a page: in backticks or as link targets, without placeholders in
/// capitals.
fn named_paths(page: &str) -> Vec<&str> {
    const ROOTS: [&str; 13] = [
        "src/",
        "assembly/",
        "format/",
        "models/",
        "numerics/",
        "runs/",
        "simulator/",
        "tests/",
        "docs/",
        "scenarios/",
        "robots/",
        "examples/",
        "engines/",
    ];
    let pieces = page.split(['`', '(', ')', ' ', ',', '\n', '"', '|', ';']);
    // The reader of the tutorial creates `scenarios/mine/`.
    let path = |piece: &str| ROOTS.iter().any(|root| piece.starts_with(root)) && !piece.starts_with("scenarios/mine");
    let plain =
        |piece: &&str| !piece.contains(['*', '<', '{', '#', '=', ':']) && !piece.split(['/', '.']).any(is_placeholder);
    pieces.filter(|piece| path(piece)).map(|piece| piece.trim_end_matches(['.', '/'])).filter(plain).collect()
}

fn is_placeholder(part: &str) -> bool {
    part.len() > 2 && part.chars().all(|c| c.is_ascii_uppercase()) && part != "README"
}

#[test]
fn paths_in_the_docs_exist() {
    let root = repository();
    let pages = fs::read_dir(root.join("docs")).unwrap().map(|entry| entry.unwrap().path());
    let pages = pages
        .filter(|path| path.extension().is_some_and(|e| e == "md"))
        .chain(["README.md", "SECURITY.md", "CHANGELOG.md", "CONTRIBUTING.md"].map(|page| root.join(page)));
    let (mut missing, mut found) = (Vec::new(), 0);
    for page in pages {
        let text = fs::read_to_string(&page).unwrap();
        for path in named_paths(&text) {
            match root.join(path).exists() {
                true => found += 1,
                false => missing.push(format!("{}: {path}", page.display())),
            }
        }
    }
    assert!(missing.is_empty(), "{}", missing.join("\n"));
    assert!(found > 150, "only {found} paths were found in the pages");
}

#[test]
fn imports_are_found_in_braces_and_in_paths() {
    assert_eq!(imported_names("robot::Model;"), ["robot"]);
    assert_eq!(imported_names("{robot::{Model, Joint}, sim, contact::model as m};"), ["robot", "sim", "contact"]);
    assert!(imports()["sim"].contains("dynamics"));
}
