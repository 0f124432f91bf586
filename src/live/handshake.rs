//! Opening handshake of RFC 6455 (section 4.2), for a server of one resource.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

/// Supported subprotocols, the preferred one first. The parts used are the same in both.
const PROTOCOLS: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];
/// Largest length of a request, bytes.
pub(super) const MAX_REQUEST: usize = 16 << 10;
/// RFC 6455, section 1.3.
const GUID: &str = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";

/// Result of parsing the beginning of a connection.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum HandshakeResult {
    /// The request is incomplete.
    Incomplete,
    /// The response that accepts it, and the length of the request.
    Accept(String, usize),
    /// The response that refuses it; the connection is then closed.
    Refuse(String),
}

/// Parses a request, of which `received` has arrived.
pub(super) fn parse(received: &[u8]) -> HandshakeResult {
    let mut headers = [httparse::EMPTY_HEADER; 64];
    let mut request = httparse::Request::new(&mut headers);
    let length = match request.parse(received) {
        Ok(httparse::Status::Complete(length)) => length,
        Ok(httparse::Status::Partial) if received.len() < MAX_REQUEST => return HandshakeResult::Incomplete,
        _ => return refuse("400 Bad Request", "not an HTTP request"),
    };
    let values = |name: &'static str| {
        let all = request.headers.iter().filter(move |h| h.name.eq_ignore_ascii_case(name));
        all.filter_map(|h| std::str::from_utf8(h.value).ok()).flat_map(|value| value.split(',')).map(str::trim)
    };
    let has = |name, value: &str| values(name).any(|v| v.eq_ignore_ascii_case(value));
    let key = values("sec-websocket-key").next().filter(|key| BASE64_STANDARD.decode(key).is_ok_and(|k| k.len() == 16));
    let (true, true, Some("GET"), Some(key)) =
        (has("connection", "upgrade"), has("upgrade", "websocket"), request.method, key)
    else {
        return refuse("426 Upgrade Required", "expected a WebSocket handshake, as Foxglove sends it");
    };
    if !has("sec-websocket-version", "13") {
        return refuse("426 Upgrade Required", "expected WebSocket version 13");
    }
    let Some(protocol) =
        PROTOCOLS.into_iter().find(|protocol| values("sec-websocket-protocol").any(|v| v == *protocol))
    else {
        return refuse("400 Bad Request", "expected the subprotocol foxglove.sdk.v1 or foxglove.websocket.v1");
    };
    let accept = accept(key);
    let response = format!(
        "HTTP/1.1 101 Switching Protocols\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Accept: {accept}\r\n\
         Sec-WebSocket-Protocol: {protocol}\r\n\r\n"
    );
    HandshakeResult::Accept(response, length)
}

fn accept(key: &str) -> String {
    BASE64_STANDARD.encode(sha1_smol::Sha1::from(format!("{key}{GUID}")).digest().bytes())
}

fn refuse(status: &str, reason: &str) -> HandshakeResult {
    let length = reason.len() + 1;
    let upgrade = "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n";
    HandshakeResult::Refuse(format!(
        "HTTP/1.1 {status}\r\n{upgrade}Connection: close\r\nContent-Type: text/plain\r\nContent-Length: {length}\r\n\r\n{reason}\n"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    const REQUEST: &str = "GET / HTTP/1.1\r\nHost: localhost:8765\r\nConnection: keep-alive, Upgrade\r\nUpgrade: WebSocket\r\n\
        Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\
        Sec-WebSocket-Protocol: other, foxglove.websocket.v1\r\n\r\n";

    /// Key and response are those of RFC 6455, section 1.3.
    #[test]
    fn the_example_of_the_rfc_is_accepted() {
        let HandshakeResult::Accept(response, length) = parse(format!("{REQUEST}\x01").as_bytes()) else {
            panic!("refused")
        };
        assert!(response.contains("\r\nSec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n"), "{response}");
        assert!(response.contains("\r\nSec-WebSocket-Protocol: foxglove.websocket.v1\r\n"), "{response}");
        assert_eq!(length, REQUEST.len());
        for part in 0..REQUEST.len() {
            assert_eq!(parse(&REQUEST.as_bytes()[..part]), HandshakeResult::Incomplete, "{part} bytes");
        }
    }

    #[test]
    fn invalid_requests_are_refused() {
        for (from, to) in [
            ("GET", "PUT"),
            ("Upgrade: WebSocket\r\n", ""),
            ("Version: 13", "Version: 8"),
            ("dGhlIHNhbXBsZSBub25jZQ==", "dGhl"),
            ("foxglove.websocket.v1", "foxglove.websocket.v9"),
            ("HTTP/1.1", "HTTP/9.9"),
        ] {
            let HandshakeResult::Refuse(response) = parse(REQUEST.replacen(from, to, 1).as_bytes()) else {
                panic!("{to}")
            };
            assert!(response.starts_with("HTTP/1.1 4"), "{response}");
        }
        assert!(matches!(parse(&[b'a'; MAX_REQUEST]), HandshakeResult::Refuse(_)));
    }
}
