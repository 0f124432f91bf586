//! Tests of the program with clients that read, do not read, leave or are absent.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Stdio};
use std::time::{Duration, Instant};

use mcap::{MessageStream, Summary};

use super::viewer::{ServerMessage, Topic, Viewer};
use crate::cli::{Done, Place};

/// A process that is killed when the test ends.
struct KilledOnDrop(Child);

impl Drop for KilledOnDrop {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A live run in the background.
pub struct LiveRun {
    child: KilledOnDrop,
    stderr: BufReader<ChildStderr>,
    stderr_so_far: String,
    /// TCP port of the server.
    pub port: u16,
}

impl LiveRun {
    /// Starts the program, which waits 600 s for a client.
    pub fn start(place: &Place, arguments: &[&str]) -> Self {
        let fixed = ["--live=127.0.0.1:0", "--live-wait", "600"];
        let mut command = place.command(&[arguments, &fixed].concat());
        let mut child = KilledOnDrop(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap());
        let mut stderr = BufReader::new(child.0.stderr.take().unwrap());
        let mut stderr_so_far = String::new();
        let port = loop {
            let mut line = String::new();
            assert_ne!(stderr.read_line(&mut line).unwrap(), 0, "{stderr_so_far}");
            stderr_so_far += &line;
            if let Some(port) = line.trim_end().strip_prefix("live at ws://127.0.0.1:") {
                break port.parse().unwrap();
            }
        };
        LiveRun { child, stderr, stderr_so_far, port }
    }

    pub fn end(mut self) -> Done {
        // The summary on stdout fits into the pipe until it is read.
        let (mut stdout, mut stderr) = (String::new(), self.stderr_so_far);
        self.stderr.read_to_string(&mut stderr).unwrap();
        self.child.0.stdout.take().unwrap().read_to_string(&mut stdout).unwrap();
        Done { code: self.child.0.wait().unwrap().code(), stdout, stderr }
    }
}

/// Writes a scenario of HOAP-2 that squats while it is pushed.
fn hoap2(place: &Place, duration: f64, rate: f64) {
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/hoap2/hoap2.toml");
    let text = format!(
        "duration = {duration}
log = {{ rate = {rate} }}
task = [{{ type = \"squat\", start = 0.05, depth = 0.02, period = 0.6, repetitions = 1 }}]
force = [{{ type = \"push\", link = \"torso\", force = [10, 4, 0], start = 0.2, duration = 0.1 }}]
[robot]
model = {model:?}
"
    );
    place.write("s.toml", text);
}

/// Path of a result file of a run of `s.toml`.
fn result_file(place: &Place, results: &str, name: &str) -> PathBuf {
    let mut runs = std::fs::read_dir(place.path(results).join("s")).unwrap();
    runs.next().unwrap().unwrap().path().join(name)
}

fn log(place: &Place, results: &str) -> Vec<u8> {
    std::fs::read(result_file(place, results, "log.mcap")).unwrap()
}

/// A count that the program printed, such as `messages sent`.
#[track_caller]
fn counted(done: &Done, what: &str) -> u64 {
    let line = done.stderr.lines().find(|line| line.contains(" messages sent, ")).expect("a line of counts");
    let (number, _) = line.split_once(&format!(" {what}")).unwrap_or_else(|| panic!("{line}"));
    number.rsplit(' ').next().unwrap().parse().unwrap()
}

/// A client that keeps up receives every byte of the log, and the log equals that of a run without
/// clients.
#[test]
fn a_client_receives_the_log() {
    let place = Place::new();
    hoap2(&place, 0.5, 200.0);
    place.runner(&["s.toml", "-o", "alone"]).exits(0);
    let run = LiveRun::start(&place, &["s.toml", "-o", "streamed", "--pace", "0.5"]);
    let mut viewer = Viewer::connect(run.port, "foxglove.websocket.v1");
    viewer.subscribe(|_| true);
    let received = viewer.messages();
    let done = run.end().exits(0);

    let log = log(&place, "streamed");
    assert!(log == self::log(&place, "alone"), "the run differs");
    // The record does not depend on the client either.
    place.runner(&["replay", "streamed"]).exits(0);
    let summary = Summary::read(&log).unwrap().unwrap();
    let topics = summary.channels.values().map(|c| {
        let schema = c.schema.as_ref().unwrap();
        let topic = Topic {
            schema_name: schema.name.clone(),
            schema_encoding: schema.encoding.clone(),
            schema: schema.data.to_vec(),
            encoding: c.message_encoding.clone(),
            metadata: c.metadata.clone(),
        };
        (c.topic.clone(), topic)
    });
    assert_eq!(viewer.topics(), topics.collect());
    let mut logged: BTreeMap<String, Vec<_>> = BTreeMap::new();
    for message in MessageStream::new(&log).unwrap().map(Result::unwrap) {
        logged.entry(message.channel.topic.clone()).or_default().push((message.log_time, message.data.to_vec()));
    }
    assert_eq!(received.keys().collect::<Vec<_>>(), logged.keys().collect::<Vec<_>>());
    for (topic, messages) in &logged {
        assert!(received[topic] == *messages, "{topic}: {} received, {} logged", received[topic].len(), messages.len());
    }
    assert!(logged["/state"].len() > 100 && logged["/events"].len() > 1 && logged["/scene"].len() == 1);
    let all: usize = logged.values().map(Vec::len).sum();
    assert_eq!((counted(&done, "messages sent"), counted(&done, "client")), (all as u64, 1), "{}", done.stderr);
    assert_eq!((counted(&done, "dropped"), counted(&done, "not taken")), (0, 0), "{}", done.stderr);
}

/// Sends more than sockets and backlog hold.
#[test]
fn a_client_that_never_reads_changes_nothing() {
    let place = Place::new();
    hoap2(&place, 4.0, 1000.0);
    place.runner(&["s.toml", "-o", "alone"]).exits(0);
    let run = LiveRun::start(&place, &["s.toml", "-o", "streamed"]);
    let mut viewer = Viewer::connect(run.port, "foxglove.sdk.v1");
    viewer.subscribe(|_| true);
    let done = run.end().exits(0);
    assert!(log(&place, "streamed") == log(&place, "alone"), "the run differs");
    assert!(counted(&done, "dropped") > 0, "{}", done.stderr);
    drop(viewer);
}

#[test]
fn a_client_that_leaves_changes_nothing() {
    let place = Place::new();
    hoap2(&place, 0.5, 200.0);
    place.runner(&["s.toml", "-o", "alone"]).exits(0);
    let run = LiveRun::start(&place, &["s.toml", "-o", "streamed", "--pace", "2"]);
    let mut viewer = Viewer::connect(run.port, "foxglove.sdk.v1");
    viewer.subscribe(|topic| topic == "/state");
    while !matches!(viewer.receive(), Some(ServerMessage::Data(_, time, _)) if time >= 50_000_000) {}
    drop(viewer);
    let done = run.end().exits(0);
    assert!(log(&place, "streamed") == log(&place, "alone"), "the run differs");
    // The run has 100 instants.
    assert!((10..100).contains(&counted(&done, "messages sent")), "{}", done.stderr);
}

/// Without a log a run is streamed at `log.rate`, of which `/tf` has 50 Hz, or at 60 Hz if that is 0.
#[test]
fn streams_without_a_log() {
    let place = Place::new();
    for (rate, no_log, instants) in [(0.0, "-j1", 31), (200.0, "--no-log", 26)] {
        hoap2(&place, 0.5, rate);
        let results = format!("results-{rate}");
        let run = LiveRun::start(&place, &["s.toml", "-o", &results, "--pace", "realtime", no_log]);
        let start = Instant::now();
        let mut viewer = Viewer::connect(run.port, "foxglove.sdk.v1");
        viewer.subscribe(|topic| topic == "/tf" || topic == "/scene");
        let received = viewer.messages();
        assert!(start.elapsed() >= Duration::from_millis(500), "half a second was streamed in {:?}", start.elapsed());
        run.end().exits(0);
        assert_eq!((received["/tf"].len(), received["/scene"].len(), received.len()), (instants, 1, 2));
        assert!(!result_file(&place, &results, "log.mcap").exists());
        let alone = format!("alone-{rate}");
        place.runner(&["s.toml", "-o", &alone, "--no-log"]).exits(0);
        for column in ["final_base_x", "final_base_z", "evaluations"] {
            let value = |results: &str| place.summary(results).column(column)[0].to_owned();
            assert_eq!(value(&results), value(&alone), "{column}");
        }
    }
}

/// The motor server streams its run as well.
#[test]
fn a_motor_server_streams_its_run() {
    let place = Place::new();
    hoap2(&place, 0.2, 200.0);
    let mut run = LiveRun::start(&place, &["motor-server", "s.toml", "--bind", "127.0.0.1:0", "-o", "robot"]);
    let mut viewer = Viewer::connect(run.port, "foxglove.sdk.v1");
    viewer.subscribe(|topic| topic == "/state");
    let port = loop {
        let mut line = String::new();
        assert_ne!(run.stderr.read_line(&mut line).unwrap(), 0, "{}", run.stderr_so_far);
        run.stderr_so_far += &line;
        if let Some((_, port)) = line.trim_end().split_once(" at 127.0.0.1:") {
            break port.to_owned();
        }
    };
    let backend = format!("robot.backend=\"udp://127.0.0.1:{port}\"");
    place.runner(&["s.toml", "--set", &backend, "-o", "tasks"]).exits(0);
    let received = viewer.messages();
    run.end().exits(0);
    let bytes = log(&place, "robot");
    let logged = MessageStream::new(&bytes).unwrap().map(Result::unwrap).filter(|m| m.channel.topic == "/state");
    assert!(received["/state"] == logged.map(|m| (m.log_time, m.data.to_vec())).collect::<Vec<_>>());
}

#[test]
fn invalid_live_options_are_refused_before_the_run() {
    let place = Place::new();
    hoap2(&place, 0.1, 200.0);
    std::fs::copy(place.path("s.toml"), place.path("t.toml")).unwrap();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let taken = format!("--live={}", taken.local_addr().unwrap());
    for (arguments, text) in [
        (&["s.toml", taken.as_str()][..], "cannot listen on 127.0.0.1:"),
        (&["s.toml", "--live=0.0.0.0:0"], "0.0.0.0:0 is not a loopback address"),
        (&["s.toml", "--live=192.0.2.1:8765"], "192.0.2.1:8765 is not a loopback address"),
        (&["s.toml", "t.toml", "--live"], "--live streams one run, and this is 2 runs: choose one"),
        (&["s.toml", "--live=here"], "expected an address with a port"),
        (&["s.toml", "--pace", "realtime"], "--live"),
        (&["s.toml", "--live-wait", "1"], "--live"),
        (&["motor-server", "s.toml", "--live=0.0.0.0:0"], "0.0.0.0:0 is not a loopback address"),
    ] {
        let done = place.runner(arguments).exits(2);
        assert!(done.stderr.contains(text), "{arguments:?}: {}", done.stderr);
        assert!(!place.path("results").exists() && !place.path("results-robot").exists(), "{arguments:?}");
    }
}

/// Without a client the run starts after the wait, with a note.
#[test]
fn a_run_without_clients_continues() {
    let place = Place::new();
    hoap2(&place, 0.1, 200.0);
    let done = place.runner(&["s.toml", "--live=127.0.0.1:0", "--live-wait", "0.05"]).exits(0);
    assert!(done.stderr.contains("live: no client within 0.05 s"), "{}", done.stderr);
    assert_eq!((counted(&done, "clients"), counted(&done, "messages sent")), (0, 0));
}

/// A console session streams its recording, and before it the present state.
#[test]
fn a_console_session_streams_its_recording() {
    let place = Place::new();
    hoap2(&place, 1.0, 200.0);
    let lines = ["-c", "record", "-c", "run 0.2", "-c", "floor 0.3", "-c", "run 0.3", "-c", "save recording r.mcap"];
    let run = LiveRun::start(&place, &[&["console", "s.toml"][..], &lines].concat());
    let mut viewer = Viewer::connect(run.port, "foxglove.websocket.v1");
    viewer.subscribe(|topic| topic == "/state");
    let received = viewer.messages();
    run.end().exits(0);
    let recorded = std::fs::read(place.path("r.mcap")).unwrap();
    let messages = MessageStream::new(&recorded).unwrap().map(|m| m.unwrap()).filter(|m| m.channel.topic == "/state");
    let recorded: Vec<_> = messages.map(|m| (m.log_time, m.data.to_vec())).collect();
    assert_eq!(recorded.len(), 101);
    // Before the recording, new clients receive the present state.
    let received = &received["/state"];
    assert!(received.len() > 101 && received[received.len() - 101..] == recorded[..], "{} messages", received.len());
}
