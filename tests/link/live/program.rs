//! The program, and clients of every kind.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Stdio};
use std::time::{Duration, Instant};

use mcap::{MessageStream, Summary};

use super::viewer::{Said, Topic, Viewer};
use crate::cli::{Done, Place};

/// A program that ends with the test that started it.
struct Ended(Child);

impl Drop for Ended {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A run that is shown, in the background.
struct Shown {
    child: Ended,
    said: BufReader<ChildStderr>,
    before: String,
    port: u16,
}

impl Shown {
    /// It waits for a client for as long as this test program lets it.
    fn start(place: &Place, arguments: &[&str]) -> Self {
        let fixed = ["--live=127.0.0.1:0", "--live-wait", "600"];
        let mut command = place.command(&[arguments, &fixed].concat());
        let mut child = Ended(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap());
        let mut said = BufReader::new(child.0.stderr.take().unwrap());
        let mut before = String::new();
        let port = loop {
            let mut line = String::new();
            assert_ne!(said.read_line(&mut line).unwrap(), 0, "{before}");
            before += &line;
            if let Some(port) = line.trim_end().strip_prefix("live at ws://127.0.0.1:") {
                break port.parse().unwrap();
            }
        };
        Shown { child, said, before, port }
    }

    fn end(mut self) -> Done {
        // Its summary is short enough for a pipe that is read later.
        let (mut stdout, mut stderr) = (String::new(), self.before);
        self.said.read_to_string(&mut stderr).unwrap();
        self.child.0.stdout.take().unwrap().read_to_string(&mut stdout).unwrap();
        Done { code: self.child.0.wait().unwrap().code(), stdout, stderr }
    }
}

/// HOAP-2 squatting while it is pushed.
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

/// The file that a run of `s.toml` left.
fn left(place: &Place, results: &str, name: &str) -> PathBuf {
    let mut runs = std::fs::read_dir(place.path(results).join("s")).unwrap();
    runs.next().unwrap().unwrap().path().join(name)
}

fn log(place: &Place, results: &str) -> Vec<u8> {
    std::fs::read(left(place, results, "log.mcap")).unwrap()
}

/// What the program counted of this kind, such as `messages sent`.
#[track_caller]
fn counted(done: &Done, what: &str) -> u64 {
    let line = done.stderr.lines().find(|line| line.contains(" messages sent, ")).expect("it is told");
    let (number, _) = line.split_once(&format!(" {what}")).unwrap_or_else(|| panic!("{line}"));
    number.rsplit(' ').next().unwrap().parse().unwrap()
}

/// Who keeps up gets every byte of the log, and the log is that of a run that nobody looked at.
#[test]
fn a_client_is_shown_the_log() {
    let place = Place::new();
    hoap2(&place, 0.5, 200.0);
    place.runner(&["s.toml", "-o", "alone"]).exits(0);
    let shown = Shown::start(&place, &["s.toml", "-o", "shown", "--pace", "2"]);
    let mut viewer = Viewer::connect(shown.port, "foxglove.websocket.v1");
    viewer.subscribe(|_| true);
    let heard = viewer.messages();
    let done = shown.end().exits(0);

    let log = log(&place, "shown");
    assert!(log == self::log(&place, "alone"), "the run is another");
    // Nor does its record say that somebody looked.
    place.runner(&["replay", "shown"]).exits(0);
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
    assert_eq!(heard.keys().collect::<Vec<_>>(), logged.keys().collect::<Vec<_>>());
    for (topic, messages) in &logged {
        assert!(heard[topic] == *messages, "{topic}: {} heard, {} logged", heard[topic].len(), messages.len());
    }
    assert!(logged["/state"].len() > 100 && logged["/events"].len() > 1 && logged["/scene"].len() == 1);
    let all: usize = logged.values().map(Vec::len).sum();
    assert_eq!((counted(&done, "messages sent"), counted(&done, "client")), (all as u64, 1), "{}", done.stderr);
    assert_eq!((counted(&done, "dropped"), counted(&done, "not taken")), (0, 0), "{}", done.stderr);
}

/// More is told than sockets and backlog hold.
#[test]
fn a_client_that_never_reads_changes_nothing() {
    let place = Place::new();
    hoap2(&place, 4.0, 1000.0);
    place.runner(&["s.toml", "-o", "alone"]).exits(0);
    let shown = Shown::start(&place, &["s.toml", "-o", "shown"]);
    let mut viewer = Viewer::connect(shown.port, "foxglove.sdk.v1");
    viewer.subscribe(|_| true);
    let done = shown.end().exits(0);
    assert!(log(&place, "shown") == log(&place, "alone"), "the run is another");
    assert!(counted(&done, "dropped") > 0, "{}", done.stderr);
    drop(viewer);
}

#[test]
fn a_client_that_leaves_changes_nothing() {
    let place = Place::new();
    hoap2(&place, 0.5, 200.0);
    place.runner(&["s.toml", "-o", "alone"]).exits(0);
    let shown = Shown::start(&place, &["s.toml", "-o", "shown", "--pace", "2"]);
    let mut viewer = Viewer::connect(shown.port, "foxglove.sdk.v1");
    viewer.subscribe(|topic| topic == "/state");
    while !matches!(viewer.hear(), Some(Said::Message(_, time, _)) if time >= 50_000_000) {}
    drop(viewer);
    let done = shown.end().exits(0);
    assert!(log(&place, "shown") == log(&place, "alone"), "the run is another");
    // Of 100 instants.
    assert!((10..100).contains(&counted(&done, "messages sent")), "{}", done.stderr);
}

/// Without a log a run is shown at the rate of the log that there could be, or 60 times a second.
#[test]
fn no_log_is_needed() {
    let place = Place::new();
    for (rate, no_log, instants) in [(0.0, "-j1", 31), (200.0, "--no-log", 101)] {
        hoap2(&place, 0.5, rate);
        let results = format!("results-{rate}");
        let shown = Shown::start(&place, &["s.toml", "-o", &results, "--pace", "realtime", no_log]);
        let start = Instant::now();
        let mut viewer = Viewer::connect(shown.port, "foxglove.sdk.v1");
        viewer.subscribe(|topic| topic == "/tf" || topic == "/scene");
        let heard = viewer.messages();
        assert!(start.elapsed() >= Duration::from_millis(500), "half a second was shown in {:?}", start.elapsed());
        shown.end().exits(0);
        assert_eq!((heard["/tf"].len(), heard["/scene"].len(), heard.len()), (instants, 1, 2));
        assert!(!left(&place, &results, "log.mcap").exists());
        let alone = format!("alone-{rate}");
        place.runner(&["s.toml", "-o", &alone, "--no-log"]).exits(0);
        for column in ["final_base_x", "final_base_z", "evaluations"] {
            let value = |results: &str| place.summary(results).column(column)[0].to_owned();
            assert_eq!(value(&results), value(&alone), "{column}");
        }
    }
}

/// The robot's side of a link is shown as well.
#[test]
fn a_motor_server_is_shown() {
    let place = Place::new();
    hoap2(&place, 0.2, 200.0);
    let mut shown = Shown::start(&place, &["motor-server", "s.toml", "--bind", "127.0.0.1:0", "-o", "robot"]);
    let mut viewer = Viewer::connect(shown.port, "foxglove.sdk.v1");
    viewer.subscribe(|topic| topic == "/state");
    let at = loop {
        let mut line = String::new();
        assert_ne!(shown.said.read_line(&mut line).unwrap(), 0, "{}", shown.before);
        shown.before += &line;
        if let Some((_, at)) = line.trim_end().split_once(" at 127.0.0.1:") {
            break at.to_owned();
        }
    };
    let backend = format!("robot.backend=\"udp://127.0.0.1:{at}\"");
    place.runner(&["s.toml", "--set", &backend, "-o", "tasks"]).exits(0);
    let heard = viewer.messages();
    shown.end().exits(0);
    let bytes = log(&place, "robot");
    let logged = MessageStream::new(&bytes).unwrap().map(Result::unwrap).filter(|m| m.channel.topic == "/state");
    assert!(heard["/state"] == logged.map(|m| (m.log_time, m.data.to_vec())).collect::<Vec<_>>());
}

#[test]
fn what_cannot_be_shown_is_refused_before_anything_runs() {
    let place = Place::new();
    hoap2(&place, 0.1, 200.0);
    std::fs::copy(place.path("s.toml"), place.path("t.toml")).unwrap();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let taken = format!("--live={}", taken.local_addr().unwrap());
    for (arguments, words) in [
        (&["s.toml", taken.as_str()][..], "cannot listen on 127.0.0.1:"),
        (&["s.toml", "--live=0.0.0.0:0"], "0.0.0.0:0 is not on this machine's loopback"),
        (&["s.toml", "--live=192.0.2.1:8765"], "192.0.2.1:8765 is not on this machine's loopback"),
        (&["s.toml", "t.toml", "--live"], "--live shows one run, and this is 2 runs: choose one"),
        (&["s.toml", "--live=here"], "an address with a port is wanted"),
        (&["s.toml", "--pace", "realtime"], "--live"),
        (&["s.toml", "--live-wait", "1"], "--live"),
        (&["motor-server", "s.toml", "--live=0.0.0.0:0"], "0.0.0.0:0 is not on this machine's loopback"),
    ] {
        let done = place.runner(arguments).exits(2);
        assert!(done.stderr.contains(words), "{arguments:?}: {}", done.stderr);
        assert!(!place.path("results").exists() && !place.path("results-robot").exists(), "{arguments:?}");
    }
}

/// A run goes on without anybody, and says so.
#[test]
fn nobody_comes() {
    let place = Place::new();
    hoap2(&place, 0.1, 200.0);
    let done = place.runner(&["s.toml", "--live=127.0.0.1:0", "--live-wait", "0.05"]).exits(0);
    assert!(done.stderr.contains("live: nobody came within 0.05 s"), "{}", done.stderr);
    assert_eq!((counted(&done, "clients"), counted(&done, "messages sent")), (0, 0));
}

/// A session at the console is shown as it is recorded, and what comes before the first step too.
#[test]
fn a_session_is_shown() {
    let place = Place::new();
    hoap2(&place, 1.0, 200.0);
    let lines = ["-c", "record", "-c", "run 0.2", "-c", "floor 0.3", "-c", "run 0.3", "-c", "save recording r.mcap"];
    let shown = Shown::start(&place, &[&["console", "s.toml"][..], &lines].concat());
    let mut viewer = Viewer::connect(shown.port, "foxglove.websocket.v1");
    viewer.subscribe(|topic| topic == "/state");
    let heard = viewer.messages();
    shown.end().exits(0);
    let recorded = std::fs::read(place.path("r.mcap")).unwrap();
    let messages = MessageStream::new(&recorded).unwrap().map(|m| m.unwrap()).filter(|m| m.channel.topic == "/state");
    let recorded: Vec<_> = messages.map(|m| (m.log_time, m.data.to_vec())).collect();
    assert_eq!(recorded.len(), 101);
    // Before it the present was shown to who came.
    let heard = &heard["/state"];
    assert!(heard.len() > 101 && heard[heard.len() - 101..] == recorded[..], "{} messages", heard.len());
}
