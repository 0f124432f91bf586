//! Tests of the responses of the viewer server.

use crate::record::sample;
use std::io::{Read, Write};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use stiction::log::TopicGroups;
use stiction::view::{ConnectionLimits, DrawnRun, ServerStopper, ViewServer, ViewableRuns, pack};
use tempfile::TempDir;

struct Serving {
    folder: TempDir,
    address: SocketAddr,
    stopper: ServerStopper,
    thread: Option<JoinHandle<()>>,
}

struct Response {
    status: u16,
    head: String,
    body: Vec<u8>,
}

impl Serving {
    /// Serves one log.
    fn start(topics: TopicGroups) -> Self {
        Self::start_with(topics, ConnectionLimits::default())
    }

    fn start_with(topics: TopicGroups, limits: ConnectionLimits) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.mcap");
        sample::open_log(&path, 20, topics).finish().unwrap();
        let (runs, skipped) = ViewableRuns::find(&path).unwrap();
        assert!(skipped.is_empty());
        let server = ViewServer::new(runs, None, 0).unwrap().with_limits(limits);
        let (address, stopper) = (server.address(), server.stopper());
        Self { folder, address, stopper, thread: Some(std::thread::spawn(|| server.run())) }
    }

    fn get(&self, target: &str) -> Response {
        self.send(&format!("GET {target} HTTP/1.1\r\nHost: {}\r\n\r\n", self.address))
    }

    fn send(&self, request: &str) -> Response {
        let mut stream = TcpStream::connect(self.address).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut all = Vec::new();
        stream.read_to_end(&mut all).unwrap();
        let end = all.windows(4).position(|w| w == b"\r\n\r\n").expect("a head") + 4;
        let head = String::from_utf8(all[..end].to_vec()).unwrap();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        Response { status, head, body: all[end..].to_vec() }
    }
}

impl Drop for Serving {
    fn drop(&mut self) {
        self.stopper.stop();
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }
}

#[test]
fn the_server_listens_on_loopback_only() {
    let serving = Serving::start(TopicGroups::ALL);
    assert_eq!(serving.address.ip(), IpAddr::V4(Ipv4Addr::LOCALHOST));
    // The same port of every other address of this machine is free.
    let elsewhere = SocketAddr::from(([127, 0, 0, 2], serving.address.port()));
    assert!(TcpStream::connect(elsewhere).is_err() || cfg!(not(target_os = "linux")));
    assert!(TcpListener::bind(serving.address).is_err(), "the server listens");
}

#[test]
fn the_server_serves_the_page_and_the_data_of_its_run() {
    let serving = Serving::start(TopicGroups::ALL);
    let home = serving.get("/");
    assert_eq!(home.status, 303);
    assert!(home.head.contains("\r\nLocation: /run/0/\r\n"), "{}", home.head);
    let page = serving.get("/run/0/");
    assert_eq!(page.status, 200);
    assert!(page.head.contains("\r\nContent-Type: text/html; charset=utf-8\r\n"), "{}", page.head);
    assert!(page.head.contains("default-src 'none'"), "{}", page.head);
    assert!(page.head.contains(&format!("\r\nContent-Length: {}\r\n", page.body.len())), "{}", page.head);
    assert!(page.body.ends_with(b"</html>") || page.body.ends_with(b"</html>\n"));
    let data = serving.get("/run/0/data?again");
    assert_eq!(data.status, 200);
    assert!(data.head.contains("\r\nContent-Type: application/octet-stream\r\n"), "{}", data.head);
    let replay = DrawnRun::read(&serving.folder.path().join("log.mcap")).unwrap();
    assert_eq!(data.body, pack(&replay, None).0);
    let head = serving.send(&format!("HEAD /run/0/data HTTP/1.1\r\nHost: {}\r\n\r\n", serving.address));
    assert_eq!((head.status, head.body.len()), (200, 0));
    assert!(head.head.contains(&format!("\r\nContent-Length: {}\r\n", data.body.len())), "{}", head.head);
}

#[test]
fn other_targets_are_not_found() {
    let serving = Serving::start(TopicGroups::ALL);
    std::fs::write(serving.folder.path().join("secret"), "x").unwrap();
    for target in [
        "/log.mcap",
        "/secret",
        "/run/0/../../secret",
        "/run/0/..%2f..%2fsecret",
        "/../secret",
        "//etc/passwd",
        "/etc/passwd",
        "/run/1/",
        "/run/-1/",
        "/run/+0/",
        "/run/00x/",
        "/run//",
        "/run/0",
        "/run/0/data/",
        "/run/99999999999999999999999/",
        "/%00",
        "*",
        "http://example.org/",
    ] {
        let response = serving.get(target);
        assert_eq!(response.status, 404, "{target}: {}", response.head);
        assert_eq!(response.body, b"there is no such page\n", "{target}");
    }
}

#[test]
fn requests_with_another_host_are_refused() {
    let serving = Serving::start(TopicGroups::ALL);
    let port = serving.address.port();
    for host in ["Host: evil.example\r\n", &format!("Host: evil.example:{port}\r\n"), "Host: 127.0.0.1\r\n", ""] {
        assert_eq!(serving.send(&format!("GET /run/0/data HTTP/1.1\r\n{host}\r\n")).status, 403, "{host}");
    }
    let named = serving.send(&format!("GET /run/0/data HTTP/1.1\r\nHost: LocalHost:{port}\r\n\r\n"));
    assert_eq!(named.status, 200);
}

#[test]
fn methods_other_than_get_and_head_are_refused() {
    let serving = Serving::start(TopicGroups::ALL);
    for method in ["POST", "PUT", "DELETE", "OPTIONS"] {
        let response = serving.send(&format!("{method} / HTTP/1.1\r\nHost: {}\r\n\r\n", serving.address));
        assert_eq!(response.status, 405, "{method}");
        assert!(response.head.contains("\r\nAllow: GET, HEAD\r\n"), "{}", response.head);
    }
    assert_eq!(serving.send("what?\r\n\r\n").status, 400);
}

#[test]
fn the_error_of_an_unreadable_log_is_the_response() {
    let serving = Serving::start(TopicGroups { scene: false, ..TopicGroups::ALL });
    let response = serving.get("/run/0/data");
    assert_eq!(response.status, 500);
    assert!(String::from_utf8(response.body).unwrap().contains("log.topics"));
    std::fs::write(serving.folder.path().join("log.mcap"), "no log").unwrap();
    assert_eq!(serving.get("/run/0/data").status, 500);
}

#[test]
fn requests_of_pages_of_other_sites_are_refused() {
    let serving = Serving::start(TopicGroups::ALL);
    let from = |origin: &str| {
        serving.send(&format!("GET /run/0/ HTTP/1.1\r\nHost: {}\r\nOrigin: {origin}\r\n\r\n", serving.address)).status
    };
    assert_eq!(from(&format!("http://{}", serving.address)), 200);
    assert_eq!([from("https://evil.example"), from("null")], [403, 403]);
}

/// More connections than the limit, none of which completes its request, or reads its response.
#[test]
fn connections_that_do_not_end_do_not_block_others() {
    let serving = Serving::start(TopicGroups::ALL);
    let requests =
        ["", "GET /run/0/data HT", &format!("GET /run/0/data HTTP/1.1\r\nHost: {}\r\n\r\n", serving.address)];
    let mut held = Vec::new();
    for request in requests {
        for _ in 0..2 * ConnectionLimits::default().connections {
            let mut stream = TcpStream::connect(serving.address).unwrap();
            stream.write_all(request.as_bytes()).unwrap();
            held.push(stream);
        }
        assert_eq!(serving.get("/run/0/").status, 200, "after {request:?}");
        assert_eq!(serving.get("/run/0/data").status, 200, "after {request:?}");
    }
}

/// A client that sends one byte at a time is disconnected, although each byte arrives in time.
#[test]
fn a_request_must_be_complete_in_time() {
    let request = Duration::from_secs(2);
    let serving = Serving::start_with(TopicGroups::ALL, ConnectionLimits { request, ..ConnectionLimits::default() });
    let mut stream = TcpStream::connect(serving.address).unwrap();
    stream.set_read_timeout(Some(Duration::from_millis(5))).unwrap();
    let end = Instant::now() + Duration::from_secs(60);
    stream.write_all(b"GET / HTTP/1.1\r\nA: ").unwrap();
    // A closed connection ends the reading, or breaks the writing.
    while stream.write_all(b"a").is_ok() && stream.read(&mut [0]).is_err_and(|error| is_timeout(&error)) {
        assert!(Instant::now() < end, "the connection stays open");
    }
    assert_eq!(serving.get("/run/0/").status, 200);
}

fn is_timeout(error: &std::io::Error) -> bool {
    matches!(error.kind(), std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut)
}
