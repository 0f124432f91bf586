//! The bits of twenty-four short runs, for this processor and for one without AVX2 and FMA as far as
//! the C library is concerned. `golden/hashes.txt` holds a hash of each run's log and record.
//!
//! A change of the numbers changes hashes. Renew the file with
//! `STICTION_GOLDEN=renew cargo test --release --test suite golden` and state the reason in the
//! commit.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use mcap::MessageStream;
use serde_json::Value;

use crate::cli::Place;
use crate::support::same::files;

/// A short run: its name, the scenario and settings. Each scenario file has one run with these.
struct GoldenRun {
    name: &'static str,
    file: &'static str,
    settings: &'static [&'static str],
}

const fn golden(name: &'static str, file: &'static str, settings: &'static [&'static str]) -> GoldenRun {
    GoldenRun { name, file, settings }
}

const TILTED: &str = "robot.base.rpy=[0.3, 0.2, 0.1]";
const FIXED: &str = "integrator.method=semi-implicit";

const RUNS: [GoldenRun; 24] = [
    golden("block-dopri5", "scenarios/drop-tilted.toml", &[TILTED, "duration=0.6"]),
    golden("block-bs23", "scenarios/drop-tilted.toml", &[TILTED, "duration=0.6", "integrator.method=bs23"]),
    golden("block-rk4", "scenarios/drop-tilted.toml", &[TILTED, "duration=0.6", "integrator.method=rk4"]),
    golden("block-one-step", "scenarios/drop-tilted.toml", &[TILTED, "duration=0.6", "contact.method=one-step"]),
    golden("block-penalty", "scenarios/drop-tilted.toml", &[TILTED, "duration=0.4", FIXED, "contact.method=penalty"]),
    golden("block-lcp", "scenarios/drop-tilted.toml", &[TILTED, "duration=0.6", FIXED, "contact.method=lcp"]),
    golden("block-ncp", "scenarios/drop-tilted.toml", &[TILTED, "duration=0.6", FIXED, "contact.method=ncp"]),
    golden("block-bounces", "scenarios/drop-tilted.toml", &[TILTED, "duration=0.6", "contact.restitution=0.5"]),
    golden("quadruped-slides", "scenarios/quadruped-slides.toml", &["duration=0.5"]),
    golden("pendulum-servo", "scenarios/servo-softens.toml", &["duration=2", "event.0.at=1"]),
    golden("pendulum-functions", "tests/determinism/golden/functions.toml", &[]),
    golden("orbit-script", "scenarios/script-orbit.toml", &["duration=0.3"]),
    golden("hoap2-forces", "tests/determinism/golden/forces.toml", &[]),
    golden(
        "hoap2-pushed",
        "scenarios/push.toml",
        &["duration=0.8", "force.0.start=0.1", "force.0.force=[60, 2, 0]", "contact.method=exact"],
    ),
    golden("hoap2-script", "scenarios/script-wave.toml", &["duration=0.5", "task.0.start=0.1", "task.0.change=[]"]),
    golden("hoap2-mocap", "scenarios/mocap-wave.toml", &["duration=0.6", "task.0.start=0.1"]),
    golden("hoap2-bow", "scenarios/playback-bow.toml", &["duration=0.6", "task.0.start=0.1"]),
    golden("hoap2-walk", "scenarios/hoap2-walk.toml", &["duration=1.5"]),
    golden("hoap2-balance", "scenarios/hoap2-balance.toml", &["duration=1.0"]),
    golden(
        "hoap2-estimates",
        "scenarios/estimators.toml",
        &["duration=0.6", "task.0.start=0.1", "control.estimator=kinematic", "expect.0.max=1"],
    ),
    golden(
        "hoap2-tucks",
        "scenarios/tuck.toml",
        &["duration=0.3", "integrator.relative_tolerance=1e-6", "integrator.absolute_tolerance=1e-8"],
    ),
    golden("cbi-balance", "scenarios/cbi-balance.toml", &["duration=0.3"]),
    golden("cbi-avoids", "scenarios/cbi-random-targets.toml", &["duration=1.5", "self_collision.method=3"]),
    golden("cbi-plans", "scenarios/cbi-random-targets.toml", &["duration=1.5", "self_collision.method=4"]),
];

/// Makes the C library of GNU choose the functions of older processors; others ignore it.
const OLDER_PROCESSOR: (&str, &str) = ("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4");

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The first 64 bits of a hash.
fn shortened(hasher: &blake3::Hasher) -> String {
    hasher.finalize().to_hex()[..16].to_owned()
}

/// Hash of all messages of a log. Attachments are left out: they are input files.
fn log_hash(path: &Path) -> String {
    let (bytes, mut hasher, mut messages) = (fs::read(path).unwrap(), blake3::Hasher::new(), 0);
    for message in MessageStream::new(&bytes).unwrap().map(Result::unwrap) {
        hasher.update(message.channel.topic.as_bytes()).update(&message.log_time.to_le_bytes());
        hasher.update(&(message.data.len() as u64).to_le_bytes()).update(&message.data);
        messages += 1;
    }
    assert!(messages > 50, "{}", path.display());
    shortened(&hasher)
}

/// Hash of a record's results: its outcome and metrics.
fn record_hash(path: &Path) -> String {
    let record: Value = serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    let mut hasher = blake3::Hasher::new();
    for field in ["outcome", "message", "metrics"] {
        hasher.update(record[field].to_string().as_bytes());
    }
    shortened(&hasher)
}

/// Lines of the file of hashes: name, hash of the log, hash of the record.
fn hashes(environment: Option<(&str, &str)>) -> String {
    let place = Place::new();
    let mut text = format!("# {:<20}{:<18}record\n", "run", "log");
    for run in &RUNS {
        let file = repository().join(run.file);
        let settings = run.settings.iter().flat_map(|setting| ["--set", setting]);
        let arguments: Vec<&str> = [file.to_str().unwrap(), "-o", run.name].into_iter().chain(settings).collect();
        let done = place.command(&arguments).envs(environment).output().unwrap();
        // The expectations of the scenarios are for longer runs.
        let stderr = String::from_utf8_lossy(&done.stderr);
        assert!(matches!(done.status.code(), Some(0 | 1)), "{}: {stderr}", run.name);
        let folder = place.path(run.name);
        let results = files(&folder);
        let only = |end: &str| -> PathBuf {
            let found: Vec<&String> = results.iter().filter(|file| file.ends_with(end)).collect();
            assert_eq!(found.len(), 1, "{}: {results:?}", run.name);
            folder.join(found[0])
        };
        let (log, record) = (log_hash(&only("/log.mcap")), record_hash(&only("/run.json")));
        writeln!(text, "{:<22}{log:<18}{record}", run.name).unwrap();
    }
    text
}

/// Lines that differ.
fn differences(found: &str, expected: &str) -> String {
    let expected: BTreeSet<&str> = expected.lines().collect();
    found.lines().filter(|line| !expected.contains(line)).map(|line| format!("{line}\n")).collect()
}

#[test]
fn golden_hashes_hold_on_this_and_on_older_processors() {
    let (here, older) = std::thread::scope(|scope| {
        let older = scope.spawn(|| hashes(Some(OLDER_PROCESSOR)));
        (hashes(None), older.join().unwrap())
    });
    let changed = differences(&older, &here);
    assert!(changed.is_empty(), "other bits with {}={}:\n{changed}", OLDER_PROCESSOR.0, OLDER_PROCESSOR.1);
    // The second column, with its heading.
    let logs: BTreeSet<&str> = here.lines().filter_map(|line| line.split_whitespace().nth(1)).collect();
    assert_eq!(logs.len(), RUNS.len() + 1, "all logs differ");
    let golden = repository().join("tests/determinism/golden/hashes.txt");
    if std::env::var("STICTION_GOLDEN").is_ok_and(|wish| wish == "renew") {
        return fs::write(golden, here).unwrap();
    }
    let changed = differences(&here, &fs::read_to_string(&golden).unwrap());
    assert!(
        changed.is_empty(),
        "the numbers of these runs changed; if they should, set STICTION_GOLDEN=renew once:\n{changed}"
    );
}
