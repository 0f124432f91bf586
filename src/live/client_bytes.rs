//! Reads the bytes of a client without a socket, as [`client`](super::client) does: handshake,
//! frames, requests. For fuzzing.

use std::io::{Cursor, ErrorKind, Read, Write};

use tungstenite::protocol::Role;
use tungstenite::{Error, Message, WebSocket};

use crate::live::VIEWER_ORIGINS;
use crate::live::client::socket_config;
use crate::live::handshake::{HandshakeResult, parse_handshake};
use crate::live::protocol::parse_request;
use crate::web::LocalAccess;

/// A stream of received bytes; written ones are dropped.
struct Received(Cursor<Vec<u8>>);

impl Read for Received {
    fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
        match self.0.read(to)? {
            0 => Err(ErrorKind::WouldBlock.into()),
            count => Ok(count),
        }
    }
}

impl Write for Received {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Number of valid requests after an accepted handshake.
#[doc(hidden)]
pub fn read_client_bytes(bytes: &[u8]) -> usize {
    let access = LocalAccess { origins: VIEWER_ORIGINS.map(str::to_owned).to_vec(), ..LocalAccess::default() };
    let HandshakeResult::Accept(response, length) = parse_handshake(bytes, &access) else { return 0 };
    debug_assert!(response.ends_with("\r\n\r\n") && length <= bytes.len());
    let rest = Received(Cursor::new(bytes[length..].to_vec()));
    let mut socket = WebSocket::from_raw_socket(rest, Role::Server, Some(socket_config()));
    let mut requests = 0;
    loop {
        match socket.read() {
            Ok(Message::Text(text)) => requests += usize::from(parse_request(&text).is_some()),
            Ok(_) => {}
            Err(Error::Io(error)) if error.kind() == ErrorKind::Interrupted => {}
            Err(_) => return requests,
        }
    }
}
