//! Opening handshake of RFC 6455 (section 4.2), for a server of one resource.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

use crate::web::{AccessError, LocalAccess, RequestHead};

/// Supported subprotocols, the preferred one first. The parts used are the same in both.
const PROTOCOLS: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];
/// RFC 6455, section 1.3.
const GUID: &str = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";

/// Result of parsing the beginning of a connection.
#[derive(Debug, PartialEq, Eq)]
pub enum HandshakeResult {
    /// The request is incomplete.
    Incomplete,
    /// The response that accepts it, and the length of the request.
    Accept(String, usize),
    /// The response that refuses it, and the reason if the client is not permitted; the connection
    /// is then closed.
    Refuse(String, Option<AccessError>),
}

/// Parses a request, of which `received` has arrived.
pub fn parse_handshake(received: &[u8], access: &LocalAccess) -> HandshakeResult {
    let (request, length) = match RequestHead::parse(received) {
        Ok(Some(complete)) => complete,
        Ok(None) => return HandshakeResult::Incomplete,
        Err(error) => return refuse("400 Bad Request", &error.to_string()),
    };
    if let Err(error) = access.check(&request) {
        let response = response("403 Forbidden", "this server accepts viewers on this machine and known ones only");
        return HandshakeResult::Refuse(response, Some(error));
    }
    let key = request.elements("sec-websocket-key").into_iter().next();
    let key = key.filter(|key| BASE64_STANDARD.decode(key).is_ok_and(|k| k.len() == 16));
    let (true, true, "GET", Some(key)) = (
        request.has_element("connection", "upgrade"),
        request.has_element("upgrade", "websocket"),
        request.method.as_str(),
        key,
    ) else {
        return refuse("426 Upgrade Required", "expected a WebSocket handshake, as Foxglove sends it");
    };
    if !request.has_element("sec-websocket-version", "13") {
        return refuse("426 Upgrade Required", "expected WebSocket version 13");
    }
    let offered = request.elements("sec-websocket-protocol");
    let Some(protocol) = PROTOCOLS.into_iter().find(|protocol| offered.iter().any(|v| v == protocol)) else {
        return refuse("400 Bad Request", "expected the subprotocol foxglove.sdk.v1 or foxglove.websocket.v1");
    };
    let accept = accept(&key);
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
    HandshakeResult::Refuse(response(status, reason), None)
}

/// Response that closes the connection.
pub(super) fn response(status: &str, reason: &str) -> String {
    let length = reason.len() + 1;
    let upgrade = "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n";
    format!(
        "HTTP/1.1 {status}\r\n{upgrade}Connection: close\r\nContent-Type: text/plain\r\nContent-Length: {length}\r\n\r\n{reason}\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::web::MAX_HEAD;

    const REQUEST: &str = "GET / HTTP/1.1\r\nHost: localhost:8765\r\nConnection: keep-alive, Upgrade\r\nUpgrade: WebSocket\r\n\
        Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\
        Sec-WebSocket-Protocol: other, foxglove.websocket.v1\r\n\r\n";

    fn parse(received: &[u8]) -> HandshakeResult {
        parse_handshake(received, &LocalAccess::default())
    }

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
            let HandshakeResult::Refuse(response, None) = parse(REQUEST.replacen(from, to, 1).as_bytes()) else {
                panic!("{to}")
            };
            assert!(response.starts_with("HTTP/1.1 4"), "{response}");
        }
        assert!(matches!(parse(&[b'a'; MAX_HEAD]), HandshakeResult::Refuse(..)));
    }

    #[test]
    fn foreign_hosts_and_origins_are_forbidden() {
        for (from, to) in [
            ("Host: localhost:8765", "Host: evil.example:8765"),
            ("Host: localhost:8765\r\n", ""),
            ("Upgrade: WebSocket", "Origin: https://evil.example\r\nUpgrade: WebSocket"),
            ("Upgrade: WebSocket", "Origin: null\r\nUpgrade: WebSocket"),
        ] {
            let HandshakeResult::Refuse(response, Some(_)) = parse(REQUEST.replacen(from, to, 1).as_bytes()) else {
                panic!("{to}")
            };
            assert!(response.starts_with("HTTP/1.1 403 "), "{response}");
        }
    }

    /// Every value of every byte: only valid requests are accepted, with one of the subprotocols.
    #[test]
    fn changed_bytes_do_not_panic() {
        let mut accepted = 0;
        for at in 0..REQUEST.len() {
            for byte in 0..=255 {
                let mut changed = REQUEST.as_bytes().to_vec();
                changed[at] = byte;
                if let HandshakeResult::Accept(response, _) = parse(&changed) {
                    assert!(PROTOCOLS.iter().any(|protocol| response.contains(protocol)), "{response}");
                    accepted += 1;
                }
            }
        }
        assert!(accepted > REQUEST.len(), "{accepted}");
    }
}
