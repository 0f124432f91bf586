//! Tests of remote runs with the program on both sides of the link.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStderr, Stdio};

use crate::cli::{Done, Place, Table};

/// `runner motor-server` in the background, listening.
pub struct Server {
    child: Child,
    stderr: BufReader<ChildStderr>,
    stderr_so_far: String,
    /// UDP port of the server.
    pub port: u16,
}

impl Server {
    pub fn start(place: &Place, arguments: &[&str]) -> Self {
        let fixed = ["motor-server", "--bind", "127.0.0.1:0"];
        let mut child = place
            .command(&[&fixed[..], arguments].concat())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut stderr = BufReader::new(child.stderr.take().unwrap());
        let mut stderr_so_far = String::new();
        let port = loop {
            let mut line = String::new();
            if stderr.read_line(&mut line).unwrap() == 0 {
                child.wait().unwrap();
                panic!("the server does not listen:\n{stderr_so_far}");
            }
            stderr_so_far += &line;
            if let Some((_, port)) = line.trim_end().split_once(" at 127.0.0.1:") {
                break port.parse().unwrap();
            }
        };
        Server { child, stderr, stderr_so_far, port }
    }

    fn backend(&self) -> String {
        format!("robot.backend=\"udp://127.0.0.1:{}\"", self.port)
    }

    /// Waits until it exits.
    pub fn end(mut self) -> Done {
        let mut stderr = self.stderr_so_far;
        self.stderr.read_to_string(&mut stderr).unwrap();
        let output = self.child.wait_with_output().unwrap();
        Done { code: output.status.code(), stdout: String::from_utf8(output.stdout).unwrap(), stderr }
    }
}

/// Writes a scenario of HOAP-2 on the floor with the keys of `more`.
pub fn hoap2(place: &Place, name: &str, more: &str) {
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/hoap2/hoap2.toml");
    place.write(name, format!("duration = 1.0\n{more}\n[robot]\nmodel = {model:?}\n"));
}

const SQUAT: &str = "task = [{ type = \"squat\", start = 0.1, depth = 0.02, period = 0.6, repetitions = 1 }]
force = [{ type = \"push\", link = \"torso\", force = [10, 4, 0], start = 0.5, duration = 0.1 }]";

/// Columns of both logs that must agree: position and velocity of base and joints, and the joint
/// commands.
const MOTION: &str = "base_*,joint.*.position_rad,joint.*.velocity_rad_s,joint.*.desired_position_rad";

pub fn motion(place: &Place, results: &str, scenario: &str) -> Table {
    let folder = std::fs::read_dir(place.path(results).join(scenario)).unwrap().next().unwrap().unwrap().path();
    let log = folder.join("log.mcap");
    Table::parse(&place.runner(&["export", log.to_str().unwrap(), "--columns", MOTION]).exits(0).stdout)
}

/// Asserts that each row of the remote log is a row of the local one, with equal positions and
/// commands. Velocities are compared in the log of the robot's side: when the contact state changes
/// at the instant of a row, the log has the velocity after the change, sensing the one before.
#[track_caller]
fn assert_same_motion(local: &Table, remote: &Table, at_least: usize) {
    assert_eq!(local.header, remote.header);
    let mut rows = 0;
    for row in &remote.rows {
        let there = local.rows.iter().find(|other| other[0] == row[0]);
        let Some(there) = there else { panic!("no row at {} s", row[0]) };
        for ((name, here), there) in remote.header.iter().zip(row).zip(there) {
            assert!(
                here == there || name.ends_with("_m_s") || name.ends_with("_rad_s"),
                "{name} at {} s: {here}, {there}",
                row[0]
            );
        }
        rows += 1;
    }
    assert!(rows >= at_least, "{rows} rows");
}

/// A run in lock step over loopback has the bits of a local run.
#[test]
fn lock_step_equals_a_local_run() {
    let place = Place::new();
    for (name, more) in [
        ("squat", SQUAT.to_owned()),
        ("balance", "task = [{ type = \"balance\", control = \"position\" }]\nforce = [{ type = \"push\", link = \"torso\", force = [8, 3, 0], start = 0.3, duration = 0.1 }]".to_owned()),
        ("sensed", format!("{SQUAT}\ncontrol = {{ estimator = \"inertial\" }}\nsensors = {{ joint_position = {{ noise = 1e-4 }}, gyroscope = {{ noise = 1e-3 }} }}")),
        ("ended", format!("{SQUAT}\nevent = [{{ at = 0.35, end_tasks = [0] }}]")),
        ("felt", "task = [{ type = \"balance\", control = \"force\", force = { contacts = \"sensed\" } }]\nsensors = { sole_force = { noise = 0.2 }, sole_moment = { bias = 0.05 } }".to_owned()),
        ("one-step", format!("{SQUAT}\ncontact = {{ method = \"one-step\" }}\nintegrator = {{ method = \"semi-implicit\" }}")),
    ] {
        let file = format!("{name}.toml");
        hoap2(&place, &file, &more);
        let (local, remote, robot) = (format!("{name}-l"), format!("{name}-r"), format!("{name}-s"));
        place.runner(&[&file, "-o", &local]).exits(0);
        let server = Server::start(&place, &[&file, "-o", &robot]);
        let backend = server.backend();
        let done = place.runner(&[&file, "--set", &backend, "-o", &remote]).exits(0);
        let there = server.end().exits(0);
        assert!(done.stdout.contains("link: ") && there.stdout.contains("link: "), "{}\n{}", done.stdout, there.stdout);
        let truth = motion(&place, &local, name);
        assert_eq!(truth.rows, motion(&place, &robot, name).rows, "{name}: log of the robot's side");
        // The tasks' side logs the estimated base.
        if name != "sensed" {
            assert_same_motion(&truth, &motion(&place, &remote, name), 100);
        }
    }
}

/// With a fifth of the packets each lost, duplicated, delayed or reordered, the run is the same and
/// both sides report the impairment.
#[test]
fn network_impairment_keeps_the_bits_in_lock_step() {
    let place = Place::new();
    hoap2(&place, "s.toml", &format!("{SQUAT}\nstop = {{ fallen = {{ below = 0.2 }} }}"));
    place.runner(&["s.toml", "--set", "duration=0.3", "-o", "l"]).exits(0);
    let impairment = "loss=0.2,duplicate=0.2,reorder=0.2,delay=0.2:0.002,seed=3";
    let server = Server::start(&place, &["s.toml", "--set", "duration=0.3", "-o", "r", "--impair", impairment]);
    let backend = server.backend();
    let done = place.runner(&["s.toml", "--set", "duration=0.3", "--set", &backend, "-o", "t"]).exits(0);
    let there = server.end().exits(0);
    for output in [&done.stdout, &there.stdout] {
        assert!(output.contains("resent"), "{output}");
    }
    assert!(done.stdout.contains("lost") && !done.stdout.contains(" 0 lost"), "{}", done.stdout);
    assert!(done.stdout.contains("late or replayed"), "{}", done.stdout);
    // The squat begins at 0.1 s; before it no tick needs a command.
    assert_same_motion(&motion(&place, "l", "s"), &motion(&place, "t", "s"), 40);
    assert_eq!(motion(&place, "l", "s").rows, motion(&place, "r", "s").rows);
}

/// At a pace the robot's clock does not wait for commands; the robot keeps standing despite network
/// impairment, and the server counts the ticks without a new command.
#[test]
fn at_a_pace_the_robot_stands_despite_network_impairment() {
    let place = Place::new();
    hoap2(
        &place,
        "s.toml",
        "control = { rate = 200 }\nstop = { fallen = { below = 0.2 } }\ntask = [{ type = \"squat\", start = 0.1, depth = 0.02, period = 0.6, repetitions = 1 }]",
    );
    let impairment = "loss=0.2,duplicate=0.2,reorder=0.2,delay=0.2:0.01,seed=4";
    let server = Server::start(&place, &["s.toml", "-o", "r", "--pace", "0.5", "--impair", impairment]);
    let backend = server.backend();
    let done = place.runner(&["s.toml", "--set", &backend, "-o", "t"]).exits(0);
    let there = server.end().exits(0);
    assert!(there.stdout.contains("ticks without a new command"), "{}", there.stdout);
    assert!(!done.stdout.contains(" 0 lost"), "{}", done.stdout);
    let height = place.summary("r").numbers("final_base_z")[0];
    assert!(height > 0.25, "{height} m: the robot stands");
}

#[test]
fn missing_peers_are_reported_and_recorded() {
    let place = Place::new();
    hoap2(&place, "s.toml", SQUAT);
    // This socket receives the packets and never answers.
    let silent = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    let port = silent.local_addr().unwrap().port();
    let done = place.runner(&["s.toml", "--set", &format!("robot.backend=\"udp://127.0.0.1:{port}\"")]).exits(3);
    assert!(done.stdout.contains(&format!("no packet from 127.0.0.1:{port} for 3 s")), "{}", done.stdout);
    assert_eq!(place.summary("results").column("outcome"), ["error"]);
    // A robot without tasks.
    let server = place.runner(&["motor-server", "s.toml", "--bind", "127.0.0.1:0", "--wait", "0.1"]).exits(3);
    assert!(server.stdout.contains("no packet from any client for 0.1 s"), "{}", server.stdout);
}

/// If the tasks' process is killed, the robot's side ends by itself and keeps its log.
#[test]
fn killed_tasks_end_the_run() {
    let place = Place::new();
    hoap2(&place, "s.toml", SQUAT);
    let server = Server::start(&place, &["s.toml", "--set", "duration=1000", "-o", "r"]);
    let backend = server.backend();
    let mut tasks = place
        .command(&["s.toml", "--set", "duration=1000", "--set", &backend, "-o", "t"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    // Data in the log shows that commands have arrived.
    let written = || -> Option<u64> {
        let folder = std::fs::read_dir(place.path("t/s")).ok()?.next()?.ok()?.path();
        std::fs::read_dir(folder).ok()?.filter_map(|file| file.ok()?.metadata().ok()).map(|data| data.len()).max()
    };
    while written().unwrap_or(0) < 100_000 {
        assert!(tasks.try_wait().unwrap().is_none(), "the tasks ended too early");
        std::thread::yield_now();
    }
    tasks.kill().unwrap();
    tasks.wait().unwrap();
    let there = server.end().exits(3);
    assert!(there.stdout.contains("no packet from 127.0.0.1:"), "{}", there.stdout);
    assert!(place.summary("r").numbers("duration_s")[0] > 0.0);
    motion(&place, "r", "s");
}

#[test]
fn addresses_beyond_loopback_need_a_key() {
    let place = Place::new();
    hoap2(&place, "s.toml", SQUAT);
    let open = place.runner(&["motor-server", "s.toml", "--bind", "0.0.0.0:0"]).exits(2);
    assert!(open.stderr.contains("such a link needs a key file"), "{}", open.stderr);
    let remote = place.runner(&["s.toml", "--set", "robot.backend=\"udp://192.0.2.1:4747\""]).exits(3);
    assert!(remote.stdout.contains("such a link needs a key file"), "{}", remote.stdout);
    place
        .write("short", "fifteen bytes..\n")
        .write("key", "a secret of both sides\n")
        .write("other", "another secret of mine\n");
    let short = place.runner(&["motor-server", "s.toml", "--bind", "127.0.0.1:0", "--key", "short"]).exits(2);
    assert!(short.stderr.contains("has 15 bytes, expected at least 16"), "{}", short.stderr);
    for (key, code) in [("key", 0), ("other", 3)] {
        let server =
            Server::start(&place, &["s.toml", "--set", "duration=0.1", "-o", "r", "--key", "key", "--wait", "5"]);
        let backend = server.backend();
        let with_key = format!("robot.backend_key=\"{key}\"");
        let done = place
            .runner(&["s.toml", "--set", "duration=0.1", "--set", &backend, "--set", &with_key, "-o", "t"])
            .exits(code);
        let there = server.end().exits(code);
        // The tests' files may be read by others.
        let warning = "other users have access to the key in ";
        assert!(there.stderr.contains(&format!("warning: {warning}key (mode 06")), "{}", there.stderr);
        assert!(done.stdout.contains(warning) && done.stdout.contains("chmod 600"), "{}", done.stdout);
        if code != 0 {
            assert!(there.stdout.contains("(wrong authentication tag)"), "{}", there.stdout);
            assert!(done.stdout.contains("no packet from"), "{}", done.stdout);
        }
    }
}

#[test]
fn another_robot_or_another_rate_is_refused() {
    let place = Place::new();
    hoap2(&place, "s.toml", SQUAT);
    place.block("block.toml", "");
    let server = Server::start(&place, &["s.toml", "-o", "r"]);
    let backend = server.backend();
    let other = place.runner(&["block.toml", "--set", &backend, "-o", "t"]).exits(3);
    assert!(other.stdout.contains("has other joints or soles"), "{}", other.stdout);
    let rate = place.runner(&["s.toml", "--set", &backend, "--set", "control.rate=500", "-o", "u"]).exits(3);
    assert!(
        rate.stdout.contains("is controlled at 1000 Hz, this scenario's `control.rate` is 500 Hz"),
        "{}",
        rate.stdout
    );
    // The server still waits.
    place.runner(&["s.toml", "--set", &backend, "-o", "v"]).exits(0);
    server.end().exits(0);
}

/// A backend makes one run at a time.
#[test]
fn sweeps_with_a_backend_are_refused() {
    let place = Place::new();
    let backend = "robot.backend=\"udp://127.0.0.1:9\"";
    hoap2(&place, "sweep.toml", "sweep = { grid = { seed = [1, 2] } }");
    hoap2(&place, "compare.toml", "compare = { reference = { \"contact.method\" = \"one-step\" } }");
    for name in ["sweep.toml", "compare.toml"] {
        let done = place.runner(&[name, "--set", backend]).exits(2);
        assert!(done.stderr.contains("makes one run, but this batch has 2"), "{}", done.stderr);
        assert!(!place.path("results").exists());
    }
}

/// Metrics that need the simulation are empty on the tasks' side, and their expectations fail.
#[test]
fn metrics_of_the_simulation_are_unmeasured() {
    let place = Place::new();
    let expect =
        "[[expect]]\nmetric = \"state_changes\"\nmax = 1000\n[[expect]]\nmetric = \"final_base_z\"\nmin = 0.2\n";
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/hoap2/hoap2.toml");
    place.write("s.toml", format!("duration = 0.1\n{SQUAT}\n[robot]\nmodel = {model:?}\n{expect}"));
    let server = Server::start(&place, &["s.toml", "-o", "r"]);
    let backend = server.backend();
    place.runner(&["s.toml", "--set", &backend, "-o", "t"]).exits(1);
    server.end().exits(0);
    let table = place.summary("t");
    for empty in ["state_changes", "steps", "energy_error_J", "max_penetration_m", "impacts"] {
        assert_eq!(table.column(empty), [""], "{empty}");
    }
    assert!(table.column("message")[0].contains("state_changes"), "{:?}", table.column("message"));
    // The run cannot be replayed either.
    let again = place.runner(&["replay", &table.column("key")[0][..8], "--results", "t"]).exits(2);
    assert!(again.stderr.contains("so it cannot be re-run"), "{}", again.stderr);
    assert!(table.numbers("final_base_z")[0] > 0.2);
}

/// The client of docs/wire.md; skipped without Python.
#[test]
fn the_documented_python_client_works() {
    let page = include_str!("../../docs/wire.md");
    assert!(page.contains(include_str!("client.py").trim_end()), "docs/wire.md shows another client");
    let Ok(version) = std::process::Command::new("python3").arg("--version").output() else { return };
    if !version.status.success() {
        return;
    }
    let place = Place::new();
    hoap2(&place, "s.toml", "");
    let robot = stiction::robot::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/hoap2/hoap2.toml")).unwrap();
    let shoulder = robot.model.joints.iter().position(|joint| joint.name == "left_shoulder_pitch").unwrap();
    let server = Server::start(&place, &["s.toml", "-o", "r"]);
    let client = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/link/client.py");
    let output = std::process::Command::new("python3")
        .arg(client)
        .args([server.port.to_string(), shoulder.to_string()])
        .output()
        .unwrap();
    let (stdout, stderr) = (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
    server.end().exits(0);
    let numbers: Vec<f64> = stdout.split_whitespace().map(|n| n.parse().unwrap()).collect();
    assert_eq!(numbers.len(), 5, "{stdout}{stderr}");
    assert_eq!(numbers[0], 1.0, "the end of the run");
    // Gravity on the arm, some 0.1 N m, against 100 N m/rad.
    assert!((numbers[1] - 0.1).abs() < 0.01, "{stdout}");
    let table = place.summary("r");
    let ends = ["final_base_x", "final_base_y", "final_base_z"].map(|name| table.numbers(name)[0]);
    assert_eq!(numbers[2..], ends, "the client has received the final position");
}
