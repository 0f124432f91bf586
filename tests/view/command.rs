//! Tests of the command `runner view`.

use crate::cli::Place;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Stdio};

/// A finished batch of three runs, one without a log.
fn results() -> Place {
    let place = Place::new();
    place.block("slide.toml", "[sweep.grid]\n\"floor.friction\" = [0.2, 0.4]\n");
    place.block("silent.toml", "[log]\nrate = 0\n");
    place.runner(&["slide.toml", "silent.toml", "--set", "duration=0.2"]).exits(0);
    place
}

fn folders(place: &Place, scenario: &str) -> Vec<String> {
    let found = std::fs::read_dir(place.path("results").join(scenario)).unwrap();
    found.map(|e| format!("results/{scenario}/{}", e.unwrap().file_name().to_str().unwrap())).collect()
}

struct Served {
    child: Child,
    host: String,
}

impl Served {
    fn start(place: &Place, arguments: &[&str]) -> Self {
        let mut child = place.command(arguments).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let host = line.trim_end().strip_prefix("http://").and_then(|l| l.strip_suffix('/')).unwrap().to_owned();
        Self { child, host }
    }

    fn get(&self, target: &str) -> String {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        write!(stream, "GET {target} HTTP/1.1\r\nHost: {}\r\n\r\n", self.host).unwrap();
        let mut all = Vec::new();
        stream.read_to_end(&mut all).unwrap();
        String::from_utf8_lossy(&all).into_owned()
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn a_folder_of_results_is_served_as_a_list_of_runs() {
    let place = results();
    let served = Served::start(&place, &["view"]);
    let list = served.get("/");
    assert!(list.starts_with("HTTP/1.1 200 "), "{list}");
    assert_eq!(list.matches("<tr><td>").count(), 2, "{list}");
    assert!(list.contains("<a href=\"/run/1/\">slide</a>") && list.contains("floor.friction = 0.4"), "{list}");
    assert!(list.contains("1 run without a log"), "{list}");
    assert!(served.get("/run/1/").starts_with("HTTP/1.1 200 "));
    let data = served.get("/run/1/data");
    assert!(data.starts_with("HTTP/1.1 200 ") && data.contains("\"robot\":\"block\""));
    assert!(served.get("/run/2/").starts_with("HTTP/1.1 404 "));
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_the_server() {
    let place = results();
    let mut served = Served::start(&place, &["view", &folders(&place, "slide")[0]]);
    assert!(served.get("/").starts_with("HTTP/1.1 303 "));
    let sent = std::process::Command::new("kill").args(["-INT", &served.child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    assert_eq!(served.child.wait().unwrap().code(), Some(0));
    assert!(TcpStream::connect(&served.host).is_err());
}

#[test]
fn output_writes_a_page_as_a_file() {
    let place = results();
    let folder = &folders(&place, "slide")[0];
    let done = place.runner(&["view", folder, "-o", "pages/one.html"]).exits(0);
    assert!(done.stderr.contains("pages/one.html"), "{}", done.stderr);
    let page = std::fs::read_to_string(place.path("pages/one.html")).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>") && page.contains("slide"));
    let log = format!("{folder}/log.mcap");
    let same = place.runner(&["view", &log, "-o", "pages/two.html"]).exits(0);
    assert_eq!(std::fs::read_to_string(place.path("pages/two.html")).unwrap(), page, "{}", same.stderr);
}

#[test]
fn unreadable_logs_are_reported() {
    let place = results();
    let refused = |arguments: &[&str], code, text: &str| {
        let done = place.runner(arguments).exits(code);
        assert!(done.stderr.contains(text), "{}", done.stderr);
    };
    refused(&["view", "nowhere"], 2, "nowhere");
    refused(&["view", "slide.toml"], 2, "not a log of this program");
    refused(&["view", "results", "-o", "x.html"], 2, "holds 2 runs");
    refused(&["view", "results/silent"], 4, "none of which left a log");
    refused(&["view", "--port", "99999"], 2, "99999");
    let log = format!("{}/log.mcap", folders(&place, "slide")[0]);
    let before = std::fs::read(place.path(&log)).unwrap();
    refused(&["view", &log, "-o", &log], 2, "is the log itself");
    assert_eq!(std::fs::read(place.path(&log)).unwrap(), before);
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    refused(&["view", &log, "--port", &port], 2, "cannot listen on port");
}
