//! Tests of invalid lines, and of the sources of lines.

use std::io::Write;
use std::process::Stdio;

use super::{hoap2, session};
use crate::cli::Place;

#[test]
fn errors_are_reported_with_their_line() {
    let place = Place::new();
    place.block("b.toml", "");
    for (line, message) in [
        ("strat", "there is no command `strat`; did you mean `start`? (`help` lists all)"),
        ("run fast", "run: expected a number of seconds greater than 0, found `fast`; usage: `run [SECONDS]"),
        ("run -1", "expected a number of seconds greater than 0, found `-1`"),
        ("run until 0", "0 s is not after the present time, 0 s"),
        ("run 1e9", "is beyond the session's end, 600 s (`--duration`)"),
        ("step 0", "expected a number of ticks, found `0`"),
        ("rate 0", "expected `free`, `realtime` or a number greater than 0, found `0`"),
        ("start sien", "unknown task type `sien`"),
        ("start posture joints.knee=1", "the robot `block` has no joint `knee`"),
        ("start posture start=1 joints={}", "`start` is given by the command itself"),
        ("undo", "there is no change to undo"),
        ("stop 0", "there is no task 0 (`tasks`)"),
        ("stop all", "no task runs or waits"),
        ("stop sine", "no task is of type `sine`; there are none here"),
        ("set floor.friction=-1", "must be 0 or greater, not -1"),
        ("set floor.frction=1", "unknown key `frction`"),
        ("set duration=3", "`duration` cannot be set in a session"),
        ("set robot.model=\"other.toml\"", "`robot.model` cannot be set in a session"),
        ("set robot={model=\"other.toml\"}", "`robot.model` cannot be set in a session"),
        ("set robot.backend=\"udp://127.0.0.1:9\"", "`robot.backend` cannot be set in a session"),
        ("set control.idle_ticks=false", "`control.idle_ticks` cannot be set in a session"),
        ("set expect=[{metric=\"final_base_z\",min=1}]", "`expect` cannot be set in a session"),
        ("set", "a value is missing"),
        ("get floor.color", "`floor.color` has no value: there is no `color`"),
        ("floor ice", "the coefficient of static friction must be a number, not `ice`"),
        ("floor 0.2 0.4", "must not be greater than `static` = 0.2, not 0.4\n --> session:"),
        ("payload wagon 1", "has no link `wagon`"),
        ("push block 1 2", "the force is missing"),
        ("push block 1 2 3 for", "a time is missing"),
        ("restore up", "names `up`, which no earlier event saves"),
        ("contact left", "there is no sole `left`"),
        ("frame wheel", "there is no link `wheel`"),
        ("joints knee*", "no joint matches `knee*`"),
        ("columns knee*", "no column matches `knee*`"),
        ("expect base_z_m min=1 max=0", "`min` = 1 is greater than `max` = 0"),
        ("run until touchdwn", "there is no kind of event `touchdwn`; did you mean `touchdown`?"),
        ("run until slip left", "there is no sole `left`"),
        ("run until inf", "`inf` is not a time"),
        ("value base_q", "unknown column `base_q`"),
        ("expect base_z_m", "`min`, `max` or `value` is missing"),
        ("expect base_z_m value=1", "`value` of a number needs a `tolerance`"),
        ("expect base_z_m least=1", "`least` is none of min, max, value, tolerance"),
        ("jump 1", "there is no recording"),
        ("play", "there is no recording"),
        ("export x.csv", "there is no recording"),
        ("record stop", "nothing is being recorded"),
        ("save session s.toml", "the session is at 0 s"),
        ("save it s.toml", "expected `session` or `recording`, found `it`"),
        ("load nowhere.mcap", "nowhere.mcap: "),
        ("quit now", "unexpected argument `now`"),
        ("set a=[1", "`]` is missing at the end"),
    ] {
        let done = session(&place, "b.toml", &format!("# a comment\n\n{line}\nrun 5\n"));
        assert_eq!(done.code, Some(2), "{line}: {}", done.stderr);
        assert!(
            done.stderr.contains("lines.txt:3: error: ") && done.stderr.contains(message),
            "{line}: {}",
            done.stderr
        );
        assert!(!done.stdout.contains("5 s"), "{line}: the session continues: {}", done.stdout);
    }
}

/// After the first step, only keys that events can set can be changed.
#[test]
fn fixed_keys_are_refused_after_the_first_step() {
    let place = Place::new();
    place.block("b.toml", "").write("f.luau", "function force(robot) return {} end");
    for (line, message) in [
        ("set contact.method=ncp", "`contact.method` cannot change during a run"),
        ("set gravity=[0,0,-9.8] gravity.2=-1", "overlaps another key of the event"),
        ("force script file=\"f.luau\"", "a script starts with the run"),
        ("restore up", "names `up`, which no earlier event saves"),
    ] {
        let done = session(&place, "b.toml", &format!("step\n{line}\n")).exits(2);
        assert!(
            done.stderr.contains("lines.txt:2: error: ") && done.stderr.contains(message),
            "{line}: {}",
            done.stderr
        );
    }
}

/// A failed expectation is reported, and the session continues.
#[test]
fn failed_expectations_are_reported_and_exit_with_1() {
    let place = Place::new();
    place.block("b.toml", "");
    let done = session(
        &place,
        "b.toml",
        "run 0.1\nexpect base_z_m min=1\nexpect base_z_m value=0.05 tolerance=1e-9\nexpect sole.bottom.state value=face-static\nexpect sole.bottom.state value=free\nrun 0.1\n",
    );
    let done = done.exits(1);
    assert!(done.stderr.contains("lines.txt:2: error: expected base_z_m >= 1, found 0.05"), "{}", done.stderr);
    assert!(
        done.stderr.contains("lines.txt:5: error: expected sole.bottom.state = free, found face-static"),
        "{}",
        done.stderr
    );
    assert!(done.stdout.contains("sole.bottom.state face-static, = face-static"), "{}", done.stdout);
    assert!(done.stdout.ends_with("0.2 s\n"), "{}", done.stdout);
}

#[test]
fn a_diverged_run_ends_the_session_with_exit_code_3() {
    let place = Place::new();
    place.block("b.toml", "");
    // Gravity so large that the run diverges.
    let done = session(&place, "b.toml", "run 0.1\nset gravity=[0,0,1e200]\nrun 5\nstatus\n").exits(3);
    assert!(done.stderr.contains("lines.txt:3: error: the run has ended at "), "{}", done.stderr);
    assert!(done.stderr.contains("`undo` reverts the last change, `reset` restarts the session"), "{}", done.stderr);
}

#[test]
fn lines_are_read_from_standard_input_and_the_command_line() {
    let place = Place::new();
    place.block("b.toml", "");
    let mut child = place
        .command(&["console", "b.toml"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(b"run 0.25\nquit\nnonsense\n").unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    assert_eq!(String::from_utf8(output.stdout).unwrap(), "0.25 s\n");
    let done =
        place.runner(&["console", "b.toml", "-c", "run 0.5", "-c", "value base_z_m", "--save", "s.toml"]).exits(0);
    assert_eq!(done.stdout, "0.5 s\nbase_z_m 0.05\ns.toml: 0.5 s, 0 events\n");
    place.runner(&["s.toml"]).exits(0);
    let bad = place.runner(&["console", "b.toml", "-c", "run 0.5", "-c", "rnu"]).exits(2);
    assert!(bad.stderr.contains("--command:2: error: there is no command `rnu`"), "{}", bad.stderr);
    place.runner(&["console", "b.toml", "--file", "nothing.txt"]).exits(2);
}

#[test]
fn a_session_requires_one_run_with_a_local_robot() {
    let place = Place::new();
    place.block("two.toml", "[sweep]\ngrid = { seed = [1, 2] }\n").block("b.toml", "");
    let two = place.runner(&["console", "two.toml", "-c", "status"]).exits(2);
    assert!(two.stderr.contains("expected one run, found 2 runs"), "{}", two.stderr);
    place.runner(&["console", "two.toml", "--filter", "seed == 2", "-c", "status"]).exits(0);
    let remote = ["console", "b.toml", "--set", "robot.backend=\"udp://127.0.0.1:9\"", "-c", "status"];
    let remote = place.runner(&remote).exits(2);
    assert!(remote.stderr.contains("the scenario's robot is remote"), "{}", remote.stderr);
    let long = place.runner(&["console", "b.toml", "--duration", "0.2", "-c", "run", "-c", "run"]).exits(2);
    assert_eq!(long.stdout, "0.2 s\n");
    assert!(long.stderr.contains("the session's last instant, 0.2 s, is reached"), "{}", long.stderr);
}

/// A session ignores `stop.fallen` and `expect`, and has the swept values of the selected run.
#[test]
fn a_session_uses_the_selected_run() {
    let place = Place::new();
    hoap2(
        &place,
        "h.toml",
        "stop = { fallen = { below = 10.0 } }\nexpect = [{ metric = \"final_base_z\", min = 5 }]\nsweep = { grid = { \"floor.friction\" = [0.2, 0.7] } }",
    );
    let chosen = [
        "console",
        "h.toml",
        "--filter",
        "floor.friction == 0.7",
        "-c",
        "run 0.01",
        "-c",
        "floor",
        "--save",
        "out.toml",
    ];
    let done = place.runner(&chosen).exits(0);
    assert!(done.stdout.contains("static 0.7, kinetic 0.7"), "{}", done.stdout);
    place.runner(&["out.toml"]).exits(0);
    let saved = std::fs::read_to_string(place.path("out.toml")).unwrap();
    assert!(!saved.contains("sweep") && !saved.contains("expect") && !saved.contains("fallen"), "{saved}");
}

/// `docs/console.md` contains the table of commands, and every command has help.
#[test]
fn every_command_is_documented() {
    let page = include_str!("../../docs/console.md");
    assert!(
        page.contains(&stiction::console::reference()),
        "docs/console.md lacks the table:\n{}",
        stiction::console::reference()
    );
    let place = Place::new();
    place.block("b.toml", "");
    for command in stiction::console::COMMANDS {
        let done = session(&place, "b.toml", &format!("help {}\n", command.name)).exits(0);
        assert!(done.stdout.contains(command.short) && done.stdout.starts_with(command.usage), "{}", done.stdout);
        assert!(command.usage.starts_with(command.name));
    }
    let all = session(&place, "b.toml", "help\n").exits(0).stdout;
    assert!(stiction::console::COMMANDS.iter().all(|c| all.contains(&format!("  {} ", c.name))), "{all}");
}
