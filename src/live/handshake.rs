//! The opening handshake of RFC 6455 (section 4.2), as far as a server of one resource needs it.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

/// Protocols that are spoken, the better first. What is used of them is the same in both.
const PROTOCOLS: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];
/// A request is not longer.
pub(super) const LONGEST: usize = 16 << 10;
/// RFC 6455, section 1.3.
const GUID: &str = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";

/// What is made of the beginning of a connection.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Answer {
    /// More must come.
    Wait,
    /// To be answered so; the request was this long.
    Accept(String, usize),
    /// To be answered so, and closed.
    Refuse(String),
}

/// Reads a request, as far as it has come.
pub(super) fn answer(came: &[u8]) -> Answer {
    let mut headers = [httparse::EMPTY_HEADER; 64];
    let mut request = httparse::Request::new(&mut headers);
    let length = match request.parse(came) {
        Ok(httparse::Status::Complete(length)) => length,
        Ok(httparse::Status::Partial) if came.len() < LONGEST => return Answer::Wait,
        _ => return refuse("400 Bad Request", "this is no request"),
    };
    let words = |name: &'static str| {
        let all = request.headers.iter().filter(move |h| h.name.eq_ignore_ascii_case(name));
        all.filter_map(|h| std::str::from_utf8(h.value).ok()).flat_map(|value| value.split(',')).map(str::trim)
    };
    let says = |name, word: &str| words(name).any(|w| w.eq_ignore_ascii_case(word));
    let key = words("sec-websocket-key").next().filter(|key| BASE64_STANDARD.decode(key).is_ok_and(|k| k.len() == 16));
    let (true, true, Some("GET"), Some(key)) =
        (says("connection", "upgrade"), says("upgrade", "websocket"), request.method, key)
    else {
        return refuse("426 Upgrade Required", "a WebSocket is wanted here, such as Foxglove opens");
    };
    if !says("sec-websocket-version", "13") {
        return refuse("426 Upgrade Required", "version 13 is wanted");
    }
    let Some(protocol) = PROTOCOLS.into_iter().find(|protocol| words("sec-websocket-protocol").any(|w| w == *protocol))
    else {
        return refuse("400 Bad Request", "the subprotocol foxglove.sdk.v1 or foxglove.websocket.v1 is wanted");
    };
    let accept = accept(key);
    let response = format!(
        "HTTP/1.1 101 Switching Protocols\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Accept: {accept}\r\n\
         Sec-WebSocket-Protocol: {protocol}\r\n\r\n"
    );
    Answer::Accept(response, length)
}

fn accept(key: &str) -> String {
    BASE64_STANDARD.encode(sha1_smol::Sha1::from(format!("{key}{GUID}")).digest().bytes())
}

fn refuse(status: &str, why: &str) -> Answer {
    let length = why.len() + 1;
    let upgrade = "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n";
    Answer::Refuse(format!(
        "HTTP/1.1 {status}\r\n{upgrade}Connection: close\r\nContent-Type: text/plain\r\nContent-Length: {length}\r\n\r\n{why}\n"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    const REQUEST: &str = "GET / HTTP/1.1\r\nHost: localhost:8765\r\nConnection: keep-alive, Upgrade\r\nUpgrade: WebSocket\r\n\
        Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\
        Sec-WebSocket-Protocol: other, foxglove.websocket.v1\r\n\r\n";

    /// Key and answer are those of RFC 6455, section 1.3.
    #[test]
    fn the_example_of_the_rfc_is_accepted() {
        let Answer::Accept(response, length) = answer(format!("{REQUEST}\x01").as_bytes()) else { panic!("refused") };
        assert!(response.contains("\r\nSec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n"), "{response}");
        assert!(response.contains("\r\nSec-WebSocket-Protocol: foxglove.websocket.v1\r\n"), "{response}");
        assert_eq!(length, REQUEST.len());
        for part in 0..REQUEST.len() {
            assert_eq!(answer(&REQUEST.as_bytes()[..part]), Answer::Wait, "{part} bytes");
        }
    }

    #[test]
    fn what_is_no_such_request_is_refused() {
        for (from, to) in [
            ("GET", "PUT"),
            ("Upgrade: WebSocket\r\n", ""),
            ("Version: 13", "Version: 8"),
            ("dGhlIHNhbXBsZSBub25jZQ==", "dGhl"),
            ("foxglove.websocket.v1", "foxglove.websocket.v9"),
            ("HTTP/1.1", "HTTP/9.9"),
        ] {
            let Answer::Refuse(response) = answer(REQUEST.replacen(from, to, 1).as_bytes()) else { panic!("{to}") };
            assert!(response.starts_with("HTTP/1.1 4"), "{response}");
        }
        assert!(matches!(answer(&[b'a'; LONGEST]), Answer::Refuse(_)));
    }
}
