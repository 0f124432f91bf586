//! Nearly valid inputs of each target give an error, not a panic.

use super::mutation::{Stream, mutated, mutated_bytes};
use super::targets::{self, tree};
use super::{Take, files};

/// Mutated copies of each seed.
const COPIES: u64 = 6;

/// Runs a target on mutated copies of all files with this extension in folders of the repository;
/// each letter is a prefix that selects the kind of input.
fn check(target: Take, folders: &[&str], ending: &str, letters: &str) {
    let mut folders: Vec<_> = folders.iter().map(|folder| tree::root().join(folder)).collect();
    let mut seeds = Vec::new();
    while let Some(folder) = folders.pop() {
        for path in files(&folder) {
            match path.extension() {
                _ if path.is_dir() => folders.push(path),
                Some(found) if found == ending => seeds.push(path),
                _ => {}
            }
        }
    }
    assert!(!seeds.is_empty(), "no {ending}");
    seeds.sort();
    for (number, path) in seeds.iter().enumerate() {
        let text = std::fs::read_to_string(path).unwrap();
        for copy in 0..COPIES {
            let mut stream = Stream(1000 * number as u64 + copy);
            let mutated = mutated(&text, &mut stream);
            // Printed if the test panics.
            println!("{} mutated, copy {copy}:\n{mutated}", path.display());
            if letters.is_empty() {
                target(mutated.as_bytes());
            }
            letters.chars().for_each(|letter| target(format!("{letter}{mutated}").as_bytes()));
        }
    }
}

#[test]
fn nearly_valid_scenarios_do_not_panic() {
    check(targets::scenario::take, &["scenarios", "tests/scenario"], "toml", "");
}

#[test]
fn nearly_valid_robot_files_do_not_panic() {
    check(targets::robot_file::take, &["robots"], "toml", "");
}

#[test]
fn nearly_valid_urdfs_do_not_panic() {
    check(targets::urdf::take, &["robots", "scenarios"], "urdf", "");
}

/// Runs a target on mutated copies, and the prefixes and mutated bytes, of a repository's file.
fn check_file(target: Take, prefix: &[u8], name: &str, copies: u64) {
    let text = std::fs::read_to_string(tree::root().join(name)).unwrap();
    target(&[prefix, text.as_bytes()].concat());
    check_text(target, prefix, &text, copies);
    check_bytes(target, prefix, text.as_bytes(), copies / 4);
}

#[test]
fn nearly_valid_mjcf_files_do_not_panic() {
    for name in ["arm", "biped", "shapes"] {
        check_file(targets::mjcf::take, b"", &format!("tests/robot/mjcf/{name}.xml"), 100);
    }
}

#[test]
fn nearly_valid_sdfs_do_not_panic() {
    for name in ["fixed_base", "frames", "old_axis", "oldest_axis"] {
        check_file(targets::sdf::take, b"", &format!("tests/robot/sdf/{name}.sdf"), 100);
    }
}

#[test]
fn nearly_valid_worlds_do_not_panic() {
    check_file(targets::world::take, b"s", "scenarios/worlds/room.sdf", 60);
    check_file(targets::world::take, b"s", "tests/scenario/room.sdf", 60);
    check_file(targets::world::take, b"m", "tests/scenario/room.xml", 120);
}

#[test]
fn nearly_valid_motions_do_not_panic() {
    check(targets::motion::take, &["scenarios/motions"], "toml", "p");
    check(targets::motion::take, &["scenarios/motions"], "csv", "clm");
    check(targets::motion::take, &["scenarios/motions"], "bvh", "b");
}

#[test]
fn nearly_valid_fits_do_not_panic() {
    for (kind, name, copies) in [("f", "cart.toml", 80), ("f", "hoap2-load.toml", 80), ("t", "data/cart.csv", 120)] {
        let name = format!("scenarios/fits/{name}");
        let text = std::fs::read(tree::root().join(&name)).unwrap();
        assert!(targets::fit::is_valid(&[kind.as_bytes(), &text[..]].concat()), "{name}");
        check_file(targets::fit::take, kind.as_bytes(), &name, copies);
    }
    let log = std::fs::read(targets::samples::log()).unwrap();
    check_bytes(targets::fit::take, b"l", &log, 60);
}

#[test]
fn nearly_valid_scripts_do_not_panic() {
    check(targets::script::take, &["scenarios"], "luau", "tTHfF");
}

#[test]
fn nearly_valid_meshes_do_not_panic() {
    check(targets::mesh::take, &["fuzz/seeds/mesh"], "obj", "o");
    check(targets::mesh::take, &["fuzz/seeds/mesh"], "dae", "d");
}

#[test]
fn nearly_valid_terrain_does_not_panic() {
    let seed = |name: &str| std::fs::read(tree::root().join("tests/scenario").join(name)).unwrap();
    let (table, picture, mesh) = (seed("bumps.csv"), seed("bumps.png"), seed("stone.obj"));
    for (kind, bytes) in [(b"c", &table), (b"p", &picture), (b"t", &mesh), (b"h", &mesh)] {
        targets::terrain::take(&[kind, &bytes[..]].concat());
        check_bytes(targets::terrain::take, kind, bytes, 150);
        if let Ok(text) = std::str::from_utf8(bytes) {
            check_text(targets::terrain::take, kind, text, 100);
        }
    }
}

#[test]
fn nearly_valid_packets_do_not_panic() {
    let mut stream = Stream(1);
    for kind in targets::wire::KINDS {
        for tag in targets::wire::TAGS {
            for copy in 0..200 {
                let mut packet = vec![kind, tag, if copy % 4 == 0 { stream.next() as u8 } else { 0 }];
                for _ in 0..stream.below(4) {
                    // Half of the offsets fall into the header and the sizes.
                    let end = if stream.below(2) == 0 { 64 } else { 1024 };
                    packet.extend_from_slice(&(stream.below(end) as u16).to_le_bytes());
                    packet.push(stream.next() as u8);
                }
                targets::wire::take(&packet);
            }
        }
    }
}

/// Factor on the number of copies: `MUTATIONS`, for long runs.
fn factor() -> u64 {
    std::env::var("MUTATIONS").map_or(1, |text| text.parse().expect("a whole number"))
}

/// Runs a target on mutated copies of a text behind a prefix.
fn check_text(target: Take, prefix: &[u8], text: &str, copies: u64) {
    for copy in 0..copies * factor() {
        let mutated = mutated(text, &mut Stream(copy));
        println!("copy {copy}:\n{mutated}");
        target(&[prefix, mutated.as_bytes()].concat());
    }
}

/// Runs a target on mutated copies of bytes behind a prefix.
fn check_bytes(target: Take, prefix: &[u8], bytes: &[u8], copies: u64) {
    for copy in 0..copies * factor() {
        println!("copy {copy} of {} bytes after {prefix:?}", bytes.len());
        target(&[prefix, &mutated_bytes(bytes, &mut Stream(copy))].concat());
    }
}

#[test]
fn nearly_valid_results_do_not_panic() {
    let seeds = targets::results::seeds();
    assert_eq!(seeds.iter().map(|(kind, _)| *kind).collect::<Vec<_>>(), targets::results::KINDS);
    for (kind, seed) in seeds {
        targets::results::take(&[&[kind], &seed[..]].concat());
        match String::from_utf8(seed) {
            Ok(text) => check_text(targets::results::take, &[kind], &text, 150),
            Err(error) => check_bytes(targets::results::take, &[kind], error.as_bytes(), 150),
        }
    }
}

/// Names and messages of a record that would be elements of a page.
#[test]
fn texts_of_records_are_escaped_in_the_report() {
    let record = targets::samples::record();
    for hostile in ["<script>alert(1)</script>", "\\\"><img src=x onerror=alert(1)>", "</title><iframe>", "&lt;&#60;'"]
    {
        let mut changed = record.clone();
        for (from, to) in [
            ("\"scenario\": \"slide", format!("\"scenario\": \"{hostile}")),
            ("\"message\": \"", format!("\"message\": \"{hostile}")),
            ("\"method\": \"exact", format!("\"method\": \"{hostile}")),
            ("\"contact.method\"", format!("\"{hostile}\"")),
            ("\"program\": \"", format!("\"program\": \"{hostile}")),
            ("\"os\": \"", format!("\"os\": \"{hostile}")),
            ("\"metric\": \"", format!("\"metric\": \"{hostile}")),
        ] {
            changed = changed.replace(from, &to);
        }
        assert_ne!(changed, record);
        // It asserts that the page has no element of the record.
        targets::results::take(format!("r{changed}").as_bytes());
    }
}

#[test]
fn nearly_valid_logs_do_not_panic() {
    let log = std::fs::read(targets::samples::log()).unwrap();
    targets::log::take(&log);
    check_bytes(targets::log::take, b"", &log, 300);
}

#[test]
fn nearly_valid_http_requests_do_not_panic() {
    for request in targets::http::SEEDS {
        targets::http::take(request.as_bytes());
        check_text(targets::http::take, b"", request, 100);
        check_bytes(targets::http::take, b"", request.as_bytes(), 100);
    }
}

#[test]
fn nearly_valid_live_clients_do_not_panic() {
    use targets::live::{HANDSHAKE, KINDS, MESSAGES, frame, take};
    KINDS.iter().for_each(|kind| take(&[*kind]));
    check_text(take, b"h", HANDSHAKE, 500);
    check_bytes(take, b"h", HANDSHAKE.as_bytes(), 500);
    for message in MESSAGES {
        let connection = [HANDSHAKE.as_bytes(), &frame(message.as_bytes())].concat();
        let requests = stiction::live::read_client_bytes(&connection);
        assert_eq!(requests, 1, "{message}");
        check_text(take, b"m", message, 500);
        check_bytes(take, b"f", &frame(message.as_bytes()), 500);
    }
}

#[test]
fn nearly_valid_filters_do_not_panic() {
    for filter in targets::filter::SEEDS {
        targets::filter::take(filter.as_bytes());
        check_text(targets::filter::take, b"", filter, 400);
    }
}

#[test]
fn nearly_valid_console_lines_do_not_panic() {
    for lines in targets::console::seeds() {
        targets::console::take(lines.as_bytes());
        check_text(targets::console::take, b"", &lines, 15);
    }
}
