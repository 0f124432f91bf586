//! Checks and keys of repetitions. Of many, some are judged together, since only their seeds differ.

use super::Place;

/// So many that groups of four are judged together.
const MANY: u64 = 300;

const SPEED: &str = "base = { linear_velocity = [1, 0, 0] }\n";

/// Keys of `list`, of the only scenario.
fn keys(place: &Place, arguments: &[&str]) -> Vec<String> {
    let text = place.runner(&[&["list", "--format", "json"], arguments].concat()).exits(0).stdout;
    let runs: Vec<serde_json::Value> = serde_json::from_str(&text).unwrap();
    runs.iter().map(|run| run["key"].as_str().unwrap().to_owned()).collect()
}

/// A repetition has the key of a run of its own with its seed: results of one are those of the other.
#[test]
fn repetitions_have_the_keys_of_runs_with_their_seeds() {
    let place = Place::new();
    let text = format!("{SPEED}[compare]\nreference = {{ \"integrator.relative_tolerance\" = 1e-9 }}\n");
    // Like the line of the seed.
    let description = "--set=description=\"seed = 1111111111111111111\"";
    place.block("repeated.toml", &format!("{text}[sweep]\nrepeat = {MANY}\n"));
    place.block("single.toml", &text);
    for first in [0, 7, 98] {
        let seed = |seed: u64| format!("--set=seed={seed}");
        let repeated = keys(&place, &["repeated.toml", description, &seed(first)]);
        assert_eq!(repeated.len(), MANY as usize);
        for by in [0, 1, 2, 3, MANY - 2, MANY - 1] {
            let single = keys(&place, &["single.toml", description, &seed(first + by)]);
            assert_eq!(single, [repeated[by as usize].clone()], "{first} + {by}");
        }
    }
}

/// The greatest seed counts, whichever repetition is judged.
#[test]
fn seeds_that_cannot_be_written_are_refused() {
    let place = Place::new();
    place.block("s.toml", &format!("[sweep]\nrepeat = {MANY}\n"));
    let greatest = i64::MAX as u64;
    place.runner(&["check", "s.toml", "--set", &format!("seed={}", greatest + 1 - MANY)]).exits(0);
    let done = place.runner(&["check", "s.toml", "--set", &format!("seed={}", greatest + 2 - MANY)]).exits(2);
    let message = format!("`seed` with its repetitions reaches {}, which TOML cannot hold", greatest + 1);
    assert!(done.stderr.contains(&message), "{}", done.stderr);
}

/// A script may use the seed before the run starts.
#[test]
fn scripts_are_judged_with_each_seed() {
    let place = Place::new();
    place.block("s.toml", &format!("[[force]]\ntype = \"script\"\nfile = \"f.luau\"\n[sweep]\nrepeat = {MANY}\n"));
    let with_limit = |limit: &str| {
        place.write(
            "f.luau",
            format!("function run()\n return {{}}\nend\nif random() < {limit} then error(\"unlucky\") end\n"),
        );
        place.runner(&["check", "s.toml", "--set", "seed=2"])
    };
    with_limit("0").exits(0);
    // The numbers of seeds 249 and 296 are less, which are not the first of a group.
    let done = with_limit("0.008").exits(2);
    assert!(done.stderr.contains("unlucky"), "{}", done.stderr);
}
