//! The program on both sides of a link.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStderr, Stdio};

use crate::cli::{Done, Place, Table};

/// `runner motor-server` in the background, listening.
pub struct Server {
    child: Child,
    said: BufReader<ChildStderr>,
    before: String,
    /// Where it listens.
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
        let mut said = BufReader::new(child.stderr.take().unwrap());
        let mut before = String::new();
        let port = loop {
            let mut line = String::new();
            if said.read_line(&mut line).unwrap() == 0 {
                child.wait().unwrap();
                panic!("it does not listen:\n{before}");
            }
            before += &line;
            if let Some((_, port)) = line.trim_end().split_once(" at 127.0.0.1:") {
                break port.parse().unwrap();
            }
        };
        Server { child, said, before, port }
    }

    fn backend(&self) -> String {
        format!("robot.backend=\"udp://127.0.0.1:{}\"", self.port)
    }

    /// Waits for its end.
    pub fn end(mut self) -> Done {
        let mut stderr = self.before;
        self.said.read_to_string(&mut stderr).unwrap();
        let output = self.child.wait_with_output().unwrap();
        Done { code: output.status.code(), stdout: String::from_utf8(output.stdout).unwrap(), stderr }
    }
}

/// HOAP-2 on the floor, pushed, with what `more` says.
pub fn hoap2(place: &Place, name: &str, more: &str) {
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/hoap2/hoap2.toml");
    place.write(name, format!("duration = 1.0\n{more}\n[robot]\nmodel = {model:?}\n"));
}

const SQUAT: &str = "task = [{ type = \"squat\", start = 0.1, depth = 0.02, period = 0.6, repetitions = 1 }]
force = [{ type = \"push\", link = \"torso\", force = [10, 4, 0], start = 0.5, duration = 0.1 }]";

/// Columns of both logs that must agree: the base and all joints, positions and velocities, and what the joints are asked.
const MOTION: &str = "base_*,joint.*.position_rad,joint.*.velocity_rad_s,joint.*.desired_position_rad";

pub fn motion(place: &Place, results: &str, scenario: &str) -> Table {
    let folder = std::fs::read_dir(place.path(results).join(scenario)).unwrap().next().unwrap().unwrap().path();
    let log = folder.join("log.mcap");
    Table::parse(&place.runner(&["export", log.to_str().unwrap(), "--columns", MOTION]).exits(0).stdout)
}

/// Rows of the remote log are rows of the local one, positions and what was asked character by character. Velocities are looked at in
/// the log of the robot's side: at an instant at which contact is decided anew the log has what that makes of them, sensing what
/// was before.
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

/// Local, and in lock-step over loopback: the same bits.
#[test]
fn a_link_changes_no_bit() {
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
        assert_eq!(truth.rows, motion(&place, &robot, name).rows, "{name}: where it is simulated");
        // What the tasks' side knows of the base is what it estimates.
        if name != "sensed" {
            assert_same_motion(&truth, &motion(&place, &remote, name), 100);
        }
    }
}

/// A fifth of the packets each is lost, doubled, late or behind the next: the run is the same, and both sides say what happened.
#[test]
fn a_bad_line_changes_no_bit_either() {
    let place = Place::new();
    hoap2(&place, "s.toml", &format!("{SQUAT}\nstop = {{ fallen = {{ below = 0.2 }} }}"));
    place.runner(&["s.toml", "--set", "duration=0.3", "-o", "l"]).exits(0);
    let bad = "loss=0.2,duplicate=0.2,reorder=0.2,delay=0.2:0.002,seed=3";
    let server = Server::start(&place, &["s.toml", "--set", "duration=0.3", "-o", "r", "--impair", bad]);
    let backend = server.backend();
    let done = place.runner(&["s.toml", "--set", "duration=0.3", "--set", &backend, "-o", "t"]).exits(0);
    let there = server.end().exits(0);
    for said in [&done.stdout, &there.stdout] {
        assert!(said.contains("sent again"), "{said}");
    }
    assert!(done.stdout.contains("lost on the way here") && !done.stdout.contains(" 0 lost"), "{}", done.stdout);
    assert!(done.stdout.contains("late or replayed"), "{}", done.stdout);
    // The squat begins at 0.1 s; before it there is nothing to decide.
    assert_same_motion(&motion(&place, "l", "s"), &motion(&place, "t", "s"), 40);
    assert_eq!(motion(&place, "l", "s").rows, motion(&place, "r", "s").rows);
}

/// The robot's clock waits for nobody; it keeps standing, and says at how many ticks no control was there.
#[test]
fn at_a_pace_it_stands_on_a_bad_line() {
    let place = Place::new();
    hoap2(
        &place,
        "s.toml",
        "control = { rate = 200 }\nstop = { fallen = { below = 0.2 } }\ntask = [{ type = \"squat\", start = 0.1, depth = 0.02, period = 0.6, repetitions = 1 }]",
    );
    let bad = "loss=0.2,duplicate=0.2,reorder=0.2,delay=0.2:0.01,seed=4";
    let server = Server::start(&place, &["s.toml", "-o", "r", "--pace", "0.5", "--impair", bad]);
    let backend = server.backend();
    let done = place.runner(&["s.toml", "--set", &backend, "-o", "t"]).exits(0);
    let there = server.end().exits(0);
    assert!(there.stdout.contains("ticks without fresh control"), "{}", there.stdout);
    assert!(!done.stdout.contains(" 0 lost"), "{}", done.stdout);
    let height = place.summary("r").numbers("final_base_z")[0];
    assert!(height > 0.25, "{height} m: it stands");
}

#[test]
fn nobody_there_is_told_and_kept() {
    let place = Place::new();
    hoap2(&place, "s.toml", SQUAT);
    // Bound and given back: nobody listens there.
    let port = std::net::UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let done = place.runner(&["s.toml", "--set", &format!("robot.backend=\"udp://127.0.0.1:{port}\"")]).exits(3);
    assert!(done.stdout.contains(&format!("nothing was heard from 127.0.0.1:{port} for 3 s")), "{}", done.stdout);
    assert_eq!(place.summary("results").column("outcome"), ["error"]);
    // Nor is there anybody for a robot.
    let server = place.runner(&["motor-server", "s.toml", "--bind", "127.0.0.1:0", "--wait", "0.1"]).exits(3);
    assert!(server.stdout.contains("nothing was heard from anybody for 0.1 s"), "{}", server.stdout);
}

/// The tasks are killed while they drive: the robot's side ends by itself, and keeps what was.
#[test]
fn tasks_that_vanish_end_the_run() {
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
    // Once there is something in its log, control has come.
    let written = || -> Option<u64> {
        let folder = std::fs::read_dir(place.path("t/s")).ok()?.next()?.ok()?.path();
        std::fs::read_dir(folder).ok()?.filter_map(|file| file.ok()?.metadata().ok()).map(|data| data.len()).max()
    };
    while written().unwrap_or(0) < 100_000 {
        assert!(tasks.try_wait().unwrap().is_none(), "they ended too early");
        std::thread::yield_now();
    }
    tasks.kill().unwrap();
    tasks.wait().unwrap();
    let there = server.end().exits(3);
    assert!(there.stdout.contains("nothing was heard from 127.0.0.1:"), "{}", there.stdout);
    assert!(place.summary("r").numbers("duration_s")[0] > 0.0);
    motion(&place, "r", "s");
}

#[test]
fn who_is_not_on_this_machine_needs_a_key() {
    let place = Place::new();
    hoap2(&place, "s.toml", SQUAT);
    let open = place.runner(&["motor-server", "s.toml", "--bind", "0.0.0.0:0"]).exits(2);
    assert!(open.stderr.contains("a key file is needed there"), "{}", open.stderr);
    let away = place.runner(&["s.toml", "--set", "robot.backend=\"udp://192.0.2.1:4747\""]).exits(3);
    assert!(away.stdout.contains("a key file is needed there"), "{}", away.stdout);
    place
        .write("short", "fifteen bytes..\n")
        .write("key", "a secret of both sides\n")
        .write("other", "another secret of mine\n");
    let short = place.runner(&["motor-server", "s.toml", "--bind", "127.0.0.1:0", "--key", "short"]).exits(2);
    assert!(short.stderr.contains("has 15 bytes; at least 16 are wanted"), "{}", short.stderr);
    for (key, code) in [("key", 0), ("other", 3)] {
        let server =
            Server::start(&place, &["s.toml", "--set", "duration=0.1", "-o", "r", "--key", "key", "--wait", "5"]);
        let backend = server.backend();
        let with_key = format!("robot.backend_key=\"{key}\"");
        let done = place
            .runner(&["s.toml", "--set", "duration=0.1", "--set", &backend, "--set", &with_key, "-o", "t"])
            .exits(code);
        let there = server.end().exits(code);
        if code != 0 {
            assert!(there.stdout.contains("(wrong seal)"), "{}", there.stdout);
            assert!(done.stdout.contains("nothing was heard"), "{}", done.stdout);
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
    server.end().exits(3);
}

/// A robot makes one run at a time.
#[test]
fn a_robot_is_asked_once() {
    let place = Place::new();
    let backend = "robot.backend=\"udp://127.0.0.1:9\"";
    hoap2(&place, "sweep.toml", "sweep = { grid = { seed = [1, 2] } }");
    hoap2(&place, "compare.toml", "compare = { reference = { \"contact.method\" = \"one-step\" } }");
    for name in ["sweep.toml", "compare.toml"] {
        let done = place.runner(&[name, "--set", backend]).exits(2);
        assert!(done.stderr.contains("makes one run, and this asks for it 2 times"), "{}", done.stderr);
        assert!(!place.path("results").exists());
    }
}

/// What only a simulation knows is not measured, and nothing expected of it holds.
#[test]
fn nothing_is_measured_that_cannot_be() {
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
    // Nor can it be made again.
    let again = place.runner(&["replay", &table.column("key")[0][..8], "--results", "t"]).exits(2);
    assert!(again.stderr.contains("so it cannot be re-run"), "{}", again.stderr);
    assert!(table.numbers("final_base_z")[0] > 0.2);
}

/// The client of docs/wire.md; left out where there is no Python.
#[test]
fn a_client_in_python_drives_it() {
    let page = include_str!("../../docs/wire.md");
    assert!(page.contains(include_str!("client.py").trim_end()), "docs/wire.md has another client");
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
    let (said, wrong) = (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
    server.end().exits(0);
    let numbers: Vec<f64> = said.split_whitespace().map(|n| n.parse().unwrap()).collect();
    assert_eq!(numbers.len(), 5, "{said}{wrong}");
    assert_eq!(numbers[0], 1.0, "the end of the run");
    // Gravity on the arm, some 0.1 N m, against 100 N m/rad.
    assert!((numbers[1] - 0.1).abs() < 0.01, "{said}");
    let table = place.summary("r");
    let ends = ["final_base_x", "final_base_y", "final_base_z"].map(|name| table.numbers(name)[0]);
    assert_eq!(numbers[2..], ends, "what it was told last is where it is");
}
