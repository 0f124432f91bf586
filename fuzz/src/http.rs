//! Requests to the server of `runner view`. `PORT` in the input stands for the server's port.

use stiction::view::{ViewServer, ViewableRuns};

use super::samples;

thread_local! {
    static SERVER: ViewServer = {
        let (runs, _) = ViewableRuns::find(&samples::results()).expect("runs");
        assert_eq!(runs.runs().len(), 2);
        ViewServer::new(runs, Some(100.0), 0).expect("a port")
    };
}

/// Requests for each kind of page, and refused ones.
pub const SEEDS: [&str; 8] = [
    "GET / HTTP/1.1\r\nHost: 127.0.0.1:PORT\r\nConnection: keep-alive\r\n\r\n",
    "GET /run/0/ HTTP/1.1\r\nHost: localhost:PORT\r\nAccept: text/html,*/*;q=0.8\r\nReferer: http://localhost:PORT/\r\n\r\n",
    "GET /run/1/data?x=1#y HTTP/1.1\r\nHost: 127.0.0.1:PORT\r\nOrigin: http://127.0.0.1:PORT\r\nSec-Fetch-Site: same-origin\r\n\r\n",
    "HEAD /run/1/ HTTP/1.1\r\nhost: LOCALHOST:PORT\r\n\r\n",
    "GET /run/18446744073709551616/data HTTP/1.1\r\nHost: 127.0.0.1:PORT\r\n\r\n",
    "GET /run/../../etc/passwd HTTP/1.1\r\nHost: example.org\r\n\r\n",
    "POST / HTTP/1.0\r\nContent-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\nhello",
    "GET http://127.0.0.1:PORT/ HTTP/1.1\r\nHost: 127.0.0.1:PORT\r\nHost: 127.0.0.1:PORT\r\n\r\n",
];

/// Sends the bytes of a connection and checks the response.
pub fn take(data: &[u8]) {
    SERVER.with(|server| {
        let port = server.address().port().to_string();
        let response = server.answer_bytes(&with_port(data, port.as_bytes()));
        if response.is_empty() {
            return;
        }
        let end = response.windows(4).position(|four| four == b"\r\n\r\n").expect("a head");
        let head = std::str::from_utf8(&response[..end]).expect("a head of text");
        assert!(head.starts_with("HTTP/1.1 "), "{head}");
        // A field that a request injects would come after an additional line end.
        let known = [
            "Content-Type",
            "Content-Length",
            "Content-Security-Policy",
            "X-Content-Type-Options",
            "Referrer-Policy",
            "Cross-Origin-Resource-Policy",
            "Cache-Control",
            "Connection",
            "Allow",
            "Location",
        ];
        for field in head.split("\r\n").skip(1) {
            let name = field.split_once(": ").map(|(name, _)| name);
            assert!(name.is_some_and(|name| known.contains(&name)), "{field}");
            assert!(!field.contains('\n') && !field.contains('\r'), "{field}");
        }
    });
}

fn with_port(data: &[u8], port: &[u8]) -> Vec<u8> {
    let (mut out, mut rest) = (Vec::new(), data);
    while let Some(at) = rest.windows(4).position(|four| four == b"PORT") {
        out.extend_from_slice(&rest[..at]);
        out.extend_from_slice(port);
        rest = &rest[at + 4..];
    }
    out.extend_from_slice(rest);
    out
}
