//! Bounds on what a scenario or a script can make the program do: sizes of logs and messages, the
//! time of a check, the number of joints.

use std::fmt::Write as _;

use stiction::text::length_limit::MAX_MESSAGE;

use super::Place;

#[test]
fn a_log_rate_is_bounded_by_clock_and_size() {
    let place = Place::new();
    for (log, message) in [
        ("rate = 1e12", "`log.rate` must be at most 1000000000 Hz, since times of the log are whole nanoseconds"),
        (
            "rate = 1e9",
            "`log.rate` = 1000000000 Hz over 1000 s makes a log of about 250 TB, at most 100 GB are allowed",
        ),
    ] {
        place.block("s.toml", &format!("[log]\n{log}\ntopics = []\n"));
        for command in [&["check", "s.toml"][..], &["s.toml"]] {
            let done = place.runner(&[command, &["--set", "duration=1000"]].concat()).exits(2);
            assert!(done.stderr.contains(message) && done.stderr.contains("s.toml:4:8"), "{}", done.stderr);
        }
        assert!(!place.path("results").exists());
    }
}

#[test]
fn a_large_log_causes_a_warning() {
    let place = Place::new();
    place.block("s.toml", "[log]\nrate = 1e6\ntopics = []\n");
    let at = |seconds: &str| place.runner(&["check", "--strict", "s.toml", "--set", &format!("duration={seconds}")]);
    at("3.9").exits(0);
    let done = at("8").exits(2);
    assert!(
        done.stderr.contains("warning: `log.rate` = 1000000 Hz makes a log of about 2.0 GB in 8 s"),
        "{}",
        done.stderr
    );
    // At an ordinary rate it takes days of simulated time: a warning, however long the run may last.
    let done = place.runner(&["check", "s.toml", "--set", "duration=1e9", "--set", "log.rate=100"]).exits(0);
    assert!(done.stderr.contains("makes a log of about 25 TB in 1000000000 s"), "{}", done.stderr);
}

#[test]
fn a_reference_that_does_not_fit_into_memory_is_refused() {
    let place = Place::new();
    place.block(
        "s.toml",
        "[log]\nrate = 1e6\ntopics = []\n[compare]\nreference = { \"integrator.relative_tolerance\" = 1e-9 }\n",
    );
    let done = place.runner(&["check", "s.toml", "--set", "duration=100"]).exits(2);
    let message = "makes samples of the reference that take about 8.8 GB, at most 4.0 GB are allowed";
    assert!(done.stderr.contains(message), "{}", done.stderr);
}

/// A step of a body at rest has any number of logged instants.
#[test]
fn a_time_limit_holds_between_logged_instants() {
    let place = Place::new();
    // The first step, of 1 ms, has 500 000 instants: some seconds, and a log of 72 MB.
    place.block("s.toml", "[log]\nrate = 5e8\n");
    place.runner(&["s.toml", "--set", "duration=0.1", "--timeout", "0.01"]).exits(3);
    assert_eq!(place.summary("results").column("outcome"), ["timed-out"]);
    let key = place.summary("results").column("key")[0].to_owned();
    let log = place.path("results/s").join(key).join("log.mcap").metadata().unwrap().len();
    // 10 ms of writing, 1 MB, and what the delay of the cancellation adds on a busy machine.
    assert!(log < 30_000_000, "{log} bytes");
}

/// A scenario of the block with this script as a force.
fn with_script(script: &str, more: &str) -> Place {
    let place = Place::new();
    let force = "[[force]]\ntype = \"script\"\nfile = \"f.luau\"\n";
    place.block("s.toml", &format!("{force}{more}")).write("f.luau", script);
    place
}

#[test]
fn messages_of_scripts_are_shortened_everywhere() {
    let script = "links = { \"block\" }\nfunction run() error(string.rep(\"A\", 2e7) .. \"END\") end\n";
    let place = with_script(script, "[sweep]\nrepeat = 10\n");
    let done = place.runner(&["s.toml", "--message-format", "json"]).exits(3);
    let summary = place.summary("results");
    assert_eq!(summary.column("outcome"), ["error"; 10]);
    for message in summary.column("message") {
        assert!(
            message.len() <= MAX_MESSAGE && message.contains("AAA") && message.contains("bytes left out"),
            "{message}"
        );
        assert!(message.contains("END at 0."), "{message}");
    }
    let all: u64 = crate::support::same::files(&place.path("results"))
        .iter()
        .map(|file| place.path("results").join(file).metadata().unwrap().len())
        .sum();
    // Ten runs, each with a record, a line, a row, a log and a part of the report.
    assert!(all < 2_000_000, "{all} bytes of results");
    assert!(done.stdout.len() + done.stderr.len() < 500_000, "{} {}", done.stdout.len(), done.stderr.len());
}

#[test]
fn scripts_must_be_ready_in_time() {
    // A microsecond has passed before the script is called.
    let place = with_script("links = { \"block\" }\nfor i = 1, 1e5 do end\nfunction run() end\n", "");
    place.runner(&["check", "s.toml"]).exits(0);
    let done = place.runner(&["check", "s.toml", "--timeout", "1e-6"]).exits(2);
    let message = "not ready after 0.000001 s of wall-clock time; `runner check --timeout` sets this limit";
    assert!(done.stderr.contains(message) && done.stderr.contains("s.toml:"), "{}", done.stderr);
}

#[test]
fn a_robot_has_a_bounded_number_of_joints() {
    let place = Place::new();
    let chain = |joints: usize| {
        let mut urdf = "<robot name=\"chain\">\n".to_owned();
        let inertial = "<inertial><mass value=\"0.1\"/><inertia ixx=\"1e-4\" iyy=\"1e-4\" izz=\"1e-4\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>";
        for i in 0..=joints {
            writeln!(urdf, "<link name=\"l{i}\">{inertial}</link>").unwrap();
        }
        for i in 0..joints {
            writeln!(
                urdf,
                "<joint name=\"j{i}\" type=\"continuous\"><parent link=\"l{i}\"/><child link=\"l{}\"/><origin xyz=\"0 0 0.01\"/><axis xyz=\"0 1 0\"/></joint>",
                i + 1
            )
            .unwrap();
        }
        urdf + "</robot>\n"
    };
    place.write("s.toml", "robot = { model = \"chain.urdf\" }\n");
    place.write("chain.urdf", chain(1024));
    place.runner(&["check", "s.toml"]).exits(0);
    place.write("chain.urdf", chain(1025));
    let done = place.runner(&["check", "s.toml"]).exits(2);
    let parts = ["the robot has too many moving joints", "chain.urdf:2052:", "1025", "at most 1024"];
    assert!(parts.iter().all(|part| done.stderr.contains(part)), "{}", done.stderr);
}

/// All commands that print tables or lines of runs.
#[test]
fn tables_show_long_values_by_their_ends() {
    let place = Place::new();
    let long = "x".repeat(70_000);
    let short = |done: &crate::cli::Done| {
        let text = done.stdout.clone() + &done.stderr;
        assert!(!text.contains("panicked") && text.len() < 20_000, "{} bytes", text.len());
    };
    for (name, friction) in [("a", 0.5), ("b", 0.4)] {
        place.block(
            "s.toml",
            &format!(
                "base = {{ linear_velocity = [1, 0, 0] }}\n[floor]\nfriction = {friction}\n\
                 [compare]\nreference = {{ \"integrator.relative_tolerance\" = 1e-9 }}\n\
                 [[expect]]\nmetric = \"steps\"\nmax = 0\n\
                 [sweep.grid]\ndescription = [\"{long}\", \"short\"]\n\"contact.method\" = [\"exact\", \"one-step\"]\n"
            ),
        );
        let run = ["s.toml", "--set", "duration=0.01", "--no-log", "-o", name];
        let done = place.runner(&run).exits(1);
        assert!(done.stdout.contains("steps") && done.stderr.contains('…'), "{}{}", done.stdout, done.stderr);
        short(&done);
        short(&place.runner(&[&run[..4], &["--verdicts", "all", "--shard", "1/1", "-o", "part"]].concat()).exits(1));
    }
    let done = place.runner(&["compare", "a", "b"]).exits(1);
    assert!(done.stdout.contains("runs compared") && done.stdout.contains('…'), "{}", done.stdout);
    short(&done);
    short(&place.runner(&["report", "a"]).exits(0));
    short(&place.runner(&["merge", "part", "-o", "merged"]).exits(1));
    let listed = place.runner(&["list", "s.toml"]).exits(0);
    assert!(listed.stdout.contains('…'), "{}", listed.stdout);
    short(&listed);
}
