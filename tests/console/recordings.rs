//! Tests of recordings: record, save, load, play, jump, export.

use super::{answer, export, log_of, numbers, session};
use crate::cli::Place;

/// A block that falls from 1 m and slides: z = 1 - g t^2 / 2, with touchdown at sqrt(2 0.95 / g).
fn falling(place: &Place) {
    place.block("b.toml", "base = { position = [0, 0, 1], linear_velocity = [1, 0, 0] }\n[floor]\nfriction = 0.1\n");
}

const FALL: &str = "record\nrun 1.0\nrecord stop\nrun 0.5";

#[test]
fn queries_use_the_recording_after_a_jump() {
    let place = Place::new();
    falling(&place);
    let touchdown = (2.0_f64 * 0.95 / 9.81).sqrt();
    let z = |jumps: &str| numbers(&answer(&place, "b.toml", &format!("{FALL}\n{jumps}"), "value time_s base_z_m"));
    let fall = |t: f64| 1.0 - 0.5 * 9.81 * t * t;
    assert_eq!(z("jump 0.3")[0], 0.3);
    assert!((z("jump 0.3")[1] - fall(0.3)).abs() < 1e-9);
    assert_eq!(z("jump 0.3\njump +0.1")[0], 0.4);
    assert_eq!(z("jump 0.3\njump -0.1")[0], 0.2);
    assert_eq!((z("jump end")[0], z("jump start")[0]), (1.0, 0.0));
    // To the last instant of the log before the event, at 200 Hz.
    let before = (touchdown * 200.0).floor() / 200.0;
    assert_eq!(z("jump next touchdown")[0], before);
    assert_eq!(z("jump end\njump previous touchdown bottom")[0], before);
    // To the first instant below this height.
    let lower = ((2.0_f64 * 0.5 / 9.81).sqrt() * 200.0).ceil() / 200.0;
    assert_eq!(z("jump when base_z_m < 0.5")[0], lower);
    assert_eq!(z("jump when sole.bottom.state = face-dynamic")[0], before + 0.005);
    assert_eq!(z("jump 0.3\nnow")[0], 1.5);
    assert_eq!(z("jump 0.3\nstep")[0], 1.501);
    // The recorded velocity: for a free body the Jacobian of the centre of mass is the identity.
    let com = numbers(&answer(&place, "b.toml", &format!("{FALL}\njump 0.3"), "com"));
    assert!((com[3] - 1.0).abs() < 1e-6 && (com[5] + 9.81 * 0.3).abs() < 1e-6, "{com:?}");
    for (jump, output) in [
        ("jump 2", "2 s is outside of the recording, 0 s to 1 s"),
        ("jump next slip", "no slip after 0 s"),
        ("jump event 99", "there is no event 99"),
        ("jump when base_z_m < -1", "`base_z_m < -1` does not hold after 0 s"),
        ("jump when base_z_m ~ 1", "expected `<`, `>` or `=`, found `~`"),
        ("jump when base_z_m < low", "expected a number, found `low`"),
        ("jump soon", "`soon` is not a time"),
    ] {
        let done = session(&place, "b.toml", &format!("{FALL}\n{jump}\n")).exits(2);
        assert!(done.stderr.contains(output), "{jump}: {}", done.stderr);
    }
}

/// Playback prints the recorded values at the given rate, forwards and backwards.
#[test]
fn a_recording_is_played() {
    let place = Place::new();
    falling(&place);
    let lines = |play: &str| -> Vec<Vec<f64>> {
        let output = answer(&place, "b.toml", FALL, play);
        assert!(output.starts_with("time_s base_z_m\n"), "{output}");
        output.lines().skip(1).map(numbers).collect()
    };
    let free = lines("play free base_z_m rate=20");
    assert_eq!(free.len(), 21);
    for (k, row) in free.iter().enumerate() {
        let t = k as f64 / 20.0;
        assert!((row[0] - t).abs() < 1e-12, "{row:?}");
        assert!(t > 0.43 || (row[1] - (1.0 - 0.5 * 9.81 * t * t)).abs() < 1e-9, "{row:?}");
    }
    assert_eq!(lines("play free base_z_m from=0.1 to=0.3 rate=10").len(), 3);
    // Playback at 50 times the original speed prints the same lines.
    assert_eq!(lines("play 50 base_z_m rate=20"), free);
    let backwards = lines("play -50 base_z_m rate=20");
    assert_eq!(backwards.iter().rev().cloned().collect::<Vec<_>>(), free);
    for (play, output) in [
        ("play 0", "the speed must not be 0"),
        ("play free base_q", "unknown column `base_q`"),
        ("play free rate=0", "`rate` must be above 0"),
        ("play free from=0.5 to=0.2", "from 0.5 s to 0.2 s is against the direction of playback"),
        ("play free until=3", "`until` is none of rate, from, to"),
    ] {
        let done = session(&place, "b.toml", &format!("{FALL}\n{play}\n")).exits(2);
        assert!(done.stderr.contains(output), "{play}: {}", done.stderr);
    }
}

#[test]
fn recordings_are_saved_loaded_and_exported() {
    let place = Place::new();
    falling(&place);
    let done =
        session(&place, "b.toml", &format!("{FALL}\nsave recording r/fall.mcap\nexport e.csv base_z_m rate=50\n"));
    let done = done.exits(0);
    assert!(done.stdout.contains("r/fall.mcap: 201 instants"), "{}", done.stdout);
    let saved = export(&place, "r/fall.mcap", &["--columns", "base_z_m", "--rate", "50"]);
    let exported = crate::cli::Table::read(&place.path("e.csv"));
    assert_eq!((saved.header, saved.rows), (exported.header, exported.rows));
    // A loaded log of an ordinary run, exported with text options.
    place.runner(&["b.toml", "--set", "duration=1"]).exits(0);
    let log = log_of(&place, "results", "b");
    let lines = format!(
        "load {log:?}\nexport t.dat base_z_m rate=10 separator=semicolon numbers=%.3f header=comment time-unit=ms to=0.2\nexport v.txt format=csv events=true\nexport p.parquet base_*\n"
    );
    session(&place, "b.toml", &lines).exits(0);
    let text = std::fs::read_to_string(place.path("t.dat")).unwrap();
    assert_eq!(text, "# time_ms;base_z_m\n0.000;1.000\n100.000;0.951\n200.000;0.804\n");
    assert!(std::fs::read_to_string(place.path("v.txt")).unwrap().starts_with("time_s,kind,subject,message\n"));
    assert!(std::fs::read(place.path("p.parquet")).unwrap().starts_with(b"PAR1"));
    for (line, output) in [
        ("export x.csv nothing", "unknown column `nothing`"),
        ("export x.doc", "unknown format `doc`: expected csv, parquet or gnuplot (.dat, .txt)"),
        ("export x.csv separator=tab", "options of text apply to the format gnuplot"),
        ("export x.dat colour=red", "`colour` is none of separator, numbers"),
        ("export x.dat rate=0", "`rate` must be a number above 0, not `0`"),
        ("load lines.txt", "not a log of this program"),
    ] {
        let done = session(&place, "b.toml", &format!("{FALL}\n{line}\n")).exits(2);
        assert!(done.stderr.contains(output), "{line}: {}", done.stderr);
        assert!(!place.path("x.csv").exists() && !place.path("x.dat").exists(), "{line}");
    }
}

/// `reset` and `undo` end a recording without losing it.
#[test]
fn a_recording_outlives_reset_and_undo() {
    let place = Place::new();
    falling(&place);
    for end in ["reset", "floor 0.2\nrun 0.01\nundo"] {
        let output = answer(&place, "b.toml", &format!("record\nrun 0.1\n{end}"), "status");
        assert!(output.contains("recording of b: 0 s to 0.1"), "{end}: {output}");
    }
    // A recording that starts between two instants of the log contains its start and its end. A
    // loaded log replaces the current recording.
    let off = "run 0.013\nrecord\nrun 0.01";
    let output = answer(&place, "b.toml", off, "jump start");
    assert_eq!(output, "recording at 0.013 s\n");
    let saved = format!("{off}\nsave recording off.mcap\nrecord\nrun 0.1\nload off.mcap");
    assert_eq!(answer(&place, "b.toml", &saved, "jump end"), "recording at 0.023 s\n");
}

/// A recording can be played back as a motion: recorded joint positions become desired ones.
#[test]
fn a_recording_is_a_motion() {
    let place = Place::new();
    super::hoap2(&place, "h.toml", "");
    let lines = "record\ndrive left_elbow=-0.5 in 0.3\nrun 0.6\nsave recording m.mcap\ndrive home in 0.2\nrun 0.3\nstart playback file=\"m.mcap\" blend=0.1\nrun 0.75";
    let output = answer(&place, "h.toml", lines, "value joint.left_elbow.desired_position_rad");
    assert!((numbers(&output)[0] + 0.5).abs() < 0.02, "{output}");
}
