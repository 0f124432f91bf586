//! What a client of `--live` sends; the first byte selects the kind.

use stiction::live::read_client_bytes;

/// Kinds: all bytes of a connection, frames after a valid handshake, a JSON message in a frame.
pub const KINDS: [u8; 3] = *b"hfm";

/// A handshake of Foxglove.
pub const HANDSHAKE: &str = "GET / HTTP/1.1\r\nHost: localhost:8765\r\nConnection: keep-alive, Upgrade\r\n\
    Upgrade: websocket\r\nOrigin: https://app.foxglove.dev\r\nSec-WebSocket-Version: 13\r\n\
    Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n";

/// Messages of a client.
pub const MESSAGES: [&str; 4] = [
    r#"{"op":"subscribe","subscriptions":[{"id":0,"channelId":3},{"id":1,"channelId":5}]}"#,
    r#"{"op":"unsubscribe","subscriptionIds":[0,1]}"#,
    r#"{"op":"getParameters","parameterNames":[]}"#,
    r#"{"op":"advertise","channels":[{"id":1,"topic":"/a","encoding":"json","schemaName":"b"}]}"#,
];

/// Reads the bytes of a client; the first byte is the letter of their kind.
pub fn take(data: &[u8]) {
    let Some((kind, bytes)) = data.split_first() else { return };
    match kind {
        b'h' => drop(read_client_bytes(bytes)),
        b'f' => drop(read_client_bytes(&[HANDSHAKE.as_bytes(), bytes].concat())),
        b'm' => {
            let read = read_client_bytes(&[HANDSHAKE.as_bytes(), &frame(bytes)].concat());
            assert!(read <= 1, "{read} requests in one message");
        }
        _ => {}
    }
}

/// A text frame of a client, with a mask of zeros.
pub fn frame(text: &[u8]) -> Vec<u8> {
    let mut frame = vec![0x81];
    match u16::try_from(text.len()) {
        Ok(length @ 0..126) => frame.push(0x80 | length as u8),
        Ok(length) => {
            frame.push(0x80 | 126);
            frame.extend_from_slice(&length.to_be_bytes());
        }
        Err(_) => {
            frame.push(0x80 | 127);
            frame.extend_from_slice(&(text.len() as u64).to_be_bytes());
        }
    }
    frame.extend_from_slice(&[0; 4]);
    frame.extend_from_slice(text);
    frame
}
