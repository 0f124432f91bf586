//! Tests of which clients a live server accepts.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::mpsc::channel;
use std::time::Duration;

use stiction::live::{LiveServer, VIEWER_ORIGINS};
use stiction::web::LocalAccess;

use super::program::LiveRun;
use super::viewer::Viewer;
use crate::cli::Place;

const PROTOCOL: &str = "foxglove.sdk.v1";

fn status(port: u16, fields: &str) -> String {
    let (_, response) = Viewer::handshake(port, fields, PROTOCOL);
    response.split(' ').nth(1).unwrap().to_owned()
}

#[test]
fn foreign_hosts_and_origins_are_refused() {
    let access = LocalAccess {
        hosts: vec!["robot.local".into()],
        origins: vec!["https://viewer.example".into()],
        ..LocalAccess::default()
    };
    let (refused, reasons) = channel();
    let on_refusal = Box::new(move |reason: &_| refused.send(format!("{reason}")).unwrap());
    let server = LiveServer::start_with("127.0.0.1:0".parse().unwrap(), access, on_refusal).unwrap();
    let port = server.address().port();
    let host = format!("Host: localhost:{port}\r\n");
    // As behind a forwarded port.
    for own in [&host, "Host: 127.0.0.1\r\n", "Host: [::1]:9\r\n", "Host: robot.local:9\r\n"] {
        assert_eq!(status(port, own), "101", "{own}");
    }
    let known = VIEWER_ORIGINS.into_iter().chain(["http://localhost:8080", "https://viewer.example"]);
    for origin in known {
        assert_eq!(status(port, &format!("{host}Origin: {origin}\r\n")), "101", "{origin}");
    }
    assert_eq!(reasons.try_iter().count(), 0);
    for fields in ["", "Host: evil.example\r\n", &format!("{host}Host: evil.example\r\n")] {
        assert_eq!(status(port, fields), "403", "{fields}");
    }
    for origin in ["https://evil.example", "null", "https://app.foxglove.dev.evil.example"] {
        assert_eq!(status(port, &format!("{host}Origin: {origin}\r\n")), "403", "{origin}");
    }
    // The server reports a refusal after its response.
    let reasons: Vec<String> = (0..6).map(|_| reasons.recv_timeout(Duration::from_secs(30)).unwrap()).collect();
    assert_eq!(reasons[1], "the host \"evil.example\" is not permitted");
    assert_eq!(reasons[3], "the origin \"https://evil.example\" is not permitted");
    assert_eq!(server.counts().refused, 6);
}

/// Connections without a complete handshake do not keep a viewer out, however many there are.
#[test]
fn unfinished_handshakes_do_not_block_others() {
    let server = LiveServer::start("127.0.0.1:0".parse().unwrap()).unwrap();
    let mut held = Vec::new();
    for _ in 0..100 {
        let mut stream = TcpStream::connect(server.address()).unwrap();
        stream.write_all(b"GET / HTTP/1.1\r\nHost: local").unwrap();
        held.push(stream);
    }
    drop(Viewer::connect(server.address().port(), PROTOCOL));
    // The oldest have made room.
    assert!(!matches!(held[0].read(&mut [0]), Ok(1..)));
}

/// The seventeenth client gets a response that says why.
#[test]
fn the_number_of_clients_is_limited() {
    let server = LiveServer::start("127.0.0.1:0".parse().unwrap()).unwrap();
    let port = server.address().port();
    let _clients: Vec<_> = (0..16).map(|_| Viewer::connect(port, PROTOCOL)).collect();
    assert_eq!(status(port, "Host: localhost\r\n"), "503");
}

/// The program reports the first refused client, and permits the origin of `--live-origin`.
#[test]
fn the_program_reports_a_refused_client_once() {
    let place = Place::new();
    place.block("s.toml", "");
    let run = LiveRun::start(&place, &["s.toml", "--live-origin", "https://viewer.example"]);
    for origin in ["https://evil.example", "https://other.example"] {
        assert_eq!(status(run.port, &format!("Host: localhost\r\nOrigin: {origin}\r\n")), "403");
    }
    let fields = "Host: localhost\r\nOrigin: https://viewer.example\r\n";
    let (line, response) = Viewer::handshake(run.port, fields, PROTOCOL);
    assert!(response.starts_with("HTTP/1.1 101 "), "{response}");
    let mut viewer = Viewer::connect(run.port, PROTOCOL);
    viewer.subscribe(|topic| topic == "/tf");
    viewer.messages();
    drop(line);
    let done = run.end().exits(0);
    let text = "live: refused a client: the origin \"https://evil.example\" is not permitted\n\
                help: if it is the site of your viewer, `--live-origin` permits it\n";
    assert!(done.stderr.contains(text) && !done.stderr.contains("other.example"), "{}", done.stderr);
    assert!(done.stderr.contains(" not taken in time, 2 refused\n"), "{}", done.stderr);
    let path = place.runner(&["s.toml", "--live", "--live-origin", "https://viewer.example/"]).exits(2);
    assert!(path.stderr.contains("expected an origin without a path"), "{}", path.stderr);
}
