//! Folders of runs: a large scenario has further folders above them, which all commands read.

use std::fs;
use std::path::PathBuf;

use crate::cli::Place;
use crate::support::same::{assert_same, files};

/// A sweep above the limit of one folder, of which a filter selects twelve runs.
fn large() -> Place {
    let place = Place::new();
    let speed = "base = { position = [0, 0, 0.05], linear_velocity = [1, 0, 0] }\n";
    let reference = "[compare]\nreference = { \"integrator.relative_tolerance\" = 1e-9 }\n";
    place.block("s.toml", &format!("{speed}{reference}[sweep]\nrepeat = 10001\n"));
    place
}

fn run(place: &Place, more: &[&str]) -> String {
    let arguments = ["s.toml", "--set", "duration=0.05", "--filter", "seed <= 12", "--max-runs", "20000"];
    place.runner(&[&arguments[..], more].concat()).exits(0).stderr
}

/// Records of runs, or of references, relative to the folder of results.
fn records(place: &Place, results: &str, references: bool) -> Vec<String> {
    let all = files(&place.path(results)).into_iter();
    all.filter(|file| file.ends_with("run.json") && file.contains("references/") == references).collect()
}

#[test]
fn a_large_scenario_has_folders_by_the_first_digits_of_keys() {
    let place = large();
    run(&place, &["-o", "whole"]);
    for references in [false, true] {
        let found = records(&place, "whole", references);
        assert_eq!(found.len(), 12);
        for file in found {
            let parts: Vec<&str> = file.trim_start_matches("s/").trim_start_matches("references/").split('/').collect();
            assert!(parts.len() == 3 && parts[0] == &parts[1][..2] && parts[1].len() == 16, "{file}");
        }
    }
    // In parts, and merged, also over an earlier merge.
    for part in ["1/2", "2/2"] {
        run(&place, &["--shard", part, "-o", &part[..1]]);
    }
    for _ in 0..2 {
        place.runner(&["merge", "1", "2", "-o", "merged"]).exits(0);
        assert_same(&place.path("whole"), &place.path("merged"));
    }
    // All commands find the runs.
    let key = place.summary("whole").column("key")[3].to_owned();
    let report = fs::read(place.path("whole/summary.csv")).unwrap();
    fs::remove_file(place.path("whole/summary.csv")).unwrap();
    place.runner(&["report", "whole", "--runs", &key[..8]]).exits(0);
    let rows = |bytes: &[u8]| {
        let text = String::from_utf8(bytes.to_vec()).unwrap();
        let mut keys: Vec<String> = text.lines().map(|line| line.split(',').take(3).collect()).collect();
        keys.sort();
        keys
    };
    assert_eq!(rows(&report), rows(&fs::read(place.path("whole/summary.csv")).unwrap()));
    let replayed = place.runner(&["replay", &key[..8], "--results", "whole"]);
    assert!(replayed.stdout.contains("same bits"), "{}{}", replayed.stdout, replayed.stderr);
    let folder = format!("whole/s/{}/{key}", &key[..2]);
    place.runner(&["export", &folder, "-o", "table.csv"]).exits(0);
    place.runner(&["compare", "whole", "merged"]).exits(0);
}

#[test]
fn resume_finds_runs_in_the_folders_of_earlier_versions() {
    let place = large();
    run(&place, &["-o", "expected"]);
    run(&place, &["-o", "results"]);
    // As an earlier version, or a sweep of another size, leaves them.
    let flatten = |up_to: usize| {
        for (at, file) in
            [records(&place, "results", false), records(&place, "results", true)].concat().iter().enumerate()
        {
            if at % 12 < up_to {
                let folder = place.path("results").join(file).parent().unwrap().to_owned();
                let flat: PathBuf = folder.parent().unwrap().parent().unwrap().join(folder.file_name().unwrap());
                fs::rename(&folder, &flat).unwrap();
            }
        }
    };
    flatten(8);
    let text = run(&place, &["-o", "results", "--resume"]);
    assert!(text.contains("resumed: 12 runs and 12 reference runs done already"), "{text}");
    assert_same(&place.path("expected"), &place.path("results"));
    // Without `--resume` no run is left in two folders.
    flatten(8);
    fs::remove_file(place.path("results/runs.jsonl")).unwrap();
    run(&place, &["-o", "results"]);
    assert_same(&place.path("expected"), &place.path("results"));
}
