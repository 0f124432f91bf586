//! The program on both sides of a link.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStderr, Stdio};

use crate::cli::{Done, Place, Table};

/// `runner motor-server` in the background, listening.
struct Server {
    child: Child,
    said: BufReader<ChildStderr>,
    before: String,
    /// Where it listens.
    port: u16,
}

impl Server {
    fn start(place: &Place, arguments: &[&str]) -> Self {
        let fixed = ["motor-server", "--bind", "127.0.0.1:0", "--wait", "60"];
        let mut child = place
            .command(&[&fixed[..], arguments].concat())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut said = BufReader::new(child.stderr.take().unwrap());
        let mut before = String::new();
        loop {
            let mut line = String::new();
            assert!(said.read_line(&mut line).unwrap() > 0, "it does not listen:\n{before}");
            before += &line;
            if let Some((_, port)) = line.trim_end().split_once(" at 127.0.0.1:") {
                let port = port.parse().unwrap();
                return Server { child, said, before, port };
            }
        }
    }

    fn backend(&self) -> String {
        format!("robot.backend=\"udp://127.0.0.1:{}\"", self.port)
    }

    /// Waits for its end.
    fn end(mut self) -> Done {
        let mut stderr = self.before;
        self.said.read_to_string(&mut stderr).unwrap();
        let output = self.child.wait_with_output().unwrap();
        Done { code: output.status.code(), stdout: String::from_utf8(output.stdout).unwrap(), stderr }
    }
}

/// HOAP-2 on the floor, pushed, with what `more` says.
fn hoap2(place: &Place, name: &str, more: &str) {
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/hoap2/hoap2.toml");
    place.write(name, format!("duration = 1.0\n{more}\n[robot]\nmodel = {model:?}\n"));
}

const SQUAT: &str = "task = [{ type = \"squat\", start = 0.1, depth = 0.02, period = 0.6, repetitions = 1 }]
force = [{ type = \"push\", link = \"torso\", force = [10, 4, 0], start = 0.5, duration = 0.1 }]";

/// Columns of both logs that must agree: the base and all joints, positions and velocities, and what the joints are asked.
const MOTION: &str = "base_*,joint.*.position_rad,joint.*.velocity_rad_s,joint.*.desired_position_rad";

fn motion(place: &Place, results: &str, scenario: &str) -> Table {
    let folder = std::fs::read_dir(place.path(results).join(scenario)).unwrap().next().unwrap().unwrap().path();
    let log = folder.join("log.mcap");
    Table::parse(&place.runner(&["export", log.to_str().unwrap(), "--columns", MOTION]).exits(0).stdout)
}

/// Rows of the remote log are rows of the local one, character by character, and there are as many of them.
#[track_caller]
fn assert_same_motion(local: &Table, remote: &Table, at_least: usize) {
    assert_eq!(local.header, remote.header);
    let mut rows = 0;
    for row in &remote.rows {
        let there = local.rows.iter().find(|other| other[0] == row[0]);
        let Some(there) = there else { panic!("no row at {} s", row[0]) };
        assert_eq!(there, row, "at {} s", row[0]);
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
            assert_same_motion(&truth, &motion(&place, &remote, name), 190);
        }
    }
}
