//! Recordings: made, kept, loaded, played, gone through, exported.

use super::{answer, export, log_of, numbers, session};
use crate::cli::Place;

/// A block that falls from 1 m and slides: z = 1 - g t^2 / 2, touching at sqrt(2 0.95 / g).
fn falling(place: &Place) {
    place.block("b.toml", "base = { position = [0, 0, 1], linear_velocity = [1, 0, 0] }\n[floor]\nfriction = 0.1\n");
}

const FALL: &str = "record\nrun 1.0\nrecord stop\nrun 0.5";

#[test]
fn queries_follow_a_jump_and_come_back() {
    let place = Place::new();
    falling(&place);
    let touch = (2.0_f64 * 0.95 / 9.81).sqrt();
    let z = |jumps: &str| numbers(&answer(&place, "b.toml", &format!("{FALL}\n{jumps}"), "value time_s base_z_m"));
    let fall = |t: f64| 1.0 - 0.5 * 9.81 * t * t;
    assert_eq!(z("jump 0.3")[0], 0.3);
    assert!((z("jump 0.3")[1] - fall(0.3)).abs() < 1e-9);
    assert_eq!(z("jump 0.3\njump +0.1")[0], 0.4);
    assert_eq!(z("jump 0.3\njump -0.1")[0], 0.2);
    assert_eq!((z("jump end")[0], z("jump start")[0]), (1.0, 0.0));
    // To the instant of the log before the event, at 200 Hz.
    let before = (touch * 200.0).floor() / 200.0;
    assert_eq!(z("jump next touchdown")[0], before);
    assert_eq!(z("jump end\njump previous touchdown bottom")[0], before);
    // The first instant at which it is lower.
    let lower = ((2.0_f64 * 0.5 / 9.81).sqrt() * 200.0).ceil() / 200.0;
    assert_eq!(z("jump when base_z_m < 0.5")[0], lower);
    assert_eq!(z("jump when sole.bottom.state = face-dynamic")[0], before + 0.005);
    assert_eq!(z("jump 0.3\nnow")[0], 1.5);
    assert_eq!(z("jump 0.3\nstep")[0], 1.501);
    // The recorded speed, of which the Jacobian of a free body's centre of mass is the identity.
    let com = numbers(&answer(&place, "b.toml", &format!("{FALL}\njump 0.3"), "com"));
    assert!((com[3] - 1.0).abs() < 1e-6 && (com[5] + 9.81 * 0.3).abs() < 1e-6, "{com:?}");
    for (jump, said) in [
        ("jump 2", "2 s is outside of the recording, 0 s to 1 s"),
        ("jump next slip", "no slip after 0 s"),
        ("jump event 99", "there is no event 99"),
        ("jump when base_z_m < -1", "`base_z_m < -1` does not come true after 0 s"),
        ("jump when base_z_m ~ 1", "`<`, `>` or `=` is wanted, not `~`"),
        ("jump when base_z_m < low", "`low` is no number"),
        ("jump soon", "`soon` is no time"),
    ] {
        let done = session(&place, "b.toml", &format!("{FALL}\n{jump}\n")).exits(2);
        assert!(done.stderr.contains(said), "{jump}: {}", done.stderr);
    }
}

/// Lines as many as the rate says, with the recorded values, forwards and backwards.
#[test]
fn a_recording_is_played() {
    let place = Place::new();
    falling(&place);
    let lines = |play: &str| -> Vec<Vec<f64>> {
        let said = answer(&place, "b.toml", FALL, play);
        assert!(said.starts_with("time_s base_z_m\n"), "{said}");
        said.lines().skip(1).map(numbers).collect()
    };
    let free = lines("play free base_z_m rate=20");
    assert_eq!(free.len(), 21);
    for (k, row) in free.iter().enumerate() {
        let t = k as f64 / 20.0;
        assert!((row[0] - t).abs() < 1e-12, "{row:?}");
        assert!(t > 0.43 || (row[1] - (1.0 - 0.5 * 9.81 * t * t)).abs() < 1e-9, "{row:?}");
    }
    assert_eq!(lines("play free base_z_m from=0.1 to=0.3 rate=10").len(), 3);
    // With waiting too, faster than it was, and the same lines.
    assert_eq!(lines("play 50 base_z_m rate=20"), free);
    let backwards = lines("play -50 base_z_m rate=20");
    assert_eq!(backwards.iter().rev().cloned().collect::<Vec<_>>(), free);
    for (play, said) in [
        ("play 0", "at speed 0 nothing would move"),
        ("play free base_q", "unknown column `base_q`"),
        ("play free rate=0", "`rate` must be above 0"),
        ("play free from=0.5 to=0.2", "from 0.5 s to 0.2 s is the other way round"),
        ("play free until=3", "`until` is none of rate, from, to"),
    ] {
        let done = session(&place, "b.toml", &format!("{FALL}\n{play}\n")).exits(2);
        assert!(done.stderr.contains(said), "{play}: {}", done.stderr);
    }
}

#[test]
fn recordings_are_kept_loaded_and_exported() {
    let place = Place::new();
    falling(&place);
    let done =
        session(&place, "b.toml", &format!("{FALL}\nsave recording r/fall.mcap\nexport e.csv base_z_m rate=50\n"));
    let done = done.exits(0);
    assert!(done.stdout.contains("r/fall.mcap: 201 instants"), "{}", done.stdout);
    let kept = export(&place, "r/fall.mcap", &["--columns", "base_z_m", "--rate", "50"]);
    let exported = crate::cli::Table::read(&place.path("e.csv"));
    assert_eq!((kept.header, kept.rows), (exported.header, exported.rows));
    // A log of an ordinary run, and text as it is wanted.
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
    for (line, said) in [
        ("export x.csv nothing", "unknown column `nothing`"),
        ("export x.doc", "`doc` is no format: csv, parquet and gnuplot (.dat, .txt) are"),
        ("export x.csv separator=tab", "how text looks is of format gnuplot"),
        ("export x.dat colour=red", "`colour` is none of separator, numbers"),
        ("export x.dat rate=0", "`rate` must be a number above 0, not `0`"),
        ("load lines.txt", "no log of this program"),
    ] {
        let done = session(&place, "b.toml", &format!("{FALL}\n{line}\n")).exits(2);
        assert!(done.stderr.contains(said), "{line}: {}", done.stderr);
        assert!(!place.path("x.csv").exists() && !place.path("x.dat").exists(), "{line}");
    }
}

/// What begins the session anew, or takes something back, ends a recording; nothing of it is lost.
#[test]
fn a_recording_outlives_its_session() {
    let place = Place::new();
    falling(&place);
    for end in ["reset", "floor 0.2\nrun 0.01\nundo"] {
        let said = answer(&place, "b.toml", &format!("record\nrun 0.1\n{end}"), "status");
        assert!(said.contains("recording of b: 0 s to 0.1"), "{end}: {said}");
    }
    // One that begins between two instants of the log has its beginning and its end, and what is loaded takes its place.
    let off = "run 0.013\nrecord\nrun 0.01";
    let said = answer(&place, "b.toml", off, "jump start");
    assert_eq!(said, "recording at 0.013 s\n");
    let kept = format!("{off}\nsave recording off.mcap\nrecord\nrun 0.1\nload off.mcap");
    assert_eq!(answer(&place, "b.toml", &kept, "jump end"), "recording at 0.023 s\n");
}

/// A recording moves the robot: what was recorded is asked of the joints again.
#[test]
fn a_recording_is_a_motion() {
    let place = Place::new();
    super::hoap2(&place, "h.toml", "");
    let lines = "record\ndrive left_elbow=-0.5 in 0.3\nrun 0.6\nsave recording m.mcap\ndrive home in 0.2\nrun 0.3\nstart playback file=\"m.mcap\" blend=0.1\nrun 0.75";
    let said = answer(&place, "h.toml", lines, "value joint.left_elbow.desired_position_rad");
    assert!((numbers(&said)[0] + 0.5).abs() < 0.02, "{said}");
}
