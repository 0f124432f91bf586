//! The part of HTTP/1.1 that a local viewer needs: one `GET` or `HEAD` request per connection.

use std::borrow::Cow;
use std::io::{Read, Write};

use crate::web::RequestHead;

/// A page loads data from its own server only, and other pages must not frame it.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src 'self' data: blob:; \
                      connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// A response.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Response {
    /// Status code.
    pub status: u16,
    /// Media type of the body.
    pub media_type: &'static str,
    /// Address of the redirection, for 303.
    pub location: Option<String>,
    /// The body.
    pub body: Cow<'static, [u8]>,
}

impl Response {
    /// A page.
    pub fn page(html: String) -> Self {
        Self { status: 200, media_type: "text/html; charset=utf-8", location: None, body: html.into_bytes().into() }
    }

    /// Binary data.
    pub fn bytes(bytes: Vec<u8>) -> Self {
        Self { status: 200, media_type: "application/octet-stream", location: None, body: bytes.into() }
    }

    /// An error with a text.
    pub fn refusal(status: u16, text: impl Into<String>) -> Self {
        let body = format!("{}\n", text.into()).into_bytes().into();
        Self { status, media_type: "text/plain; charset=utf-8", location: None, body }
    }

    /// A redirection.
    pub fn redirect(location: impl Into<String>) -> Self {
        let location = location.into();
        Self { location: Some(location.clone()), ..Self::refusal(303, location) }
    }

    /// Writes the response; without the body for `HEAD`.
    pub fn write(&self, head_only: bool, mut to: impl Write) -> std::io::Result<()> {
        let reason = match self.status {
            200 => "OK",
            303 => "See Other",
            400 => "Bad Request",
            403 => "Forbidden",
            404 => "Not Found",
            405 => "Method Not Allowed",
            431 => "Request Header Fields Too Large",
            _ => "Internal Server Error",
        };
        let mut head = format!(
            "HTTP/1.1 {} {reason}\r\nContent-Type: {}\r\nContent-Length: {}\r\nContent-Security-Policy: {POLICY}\r\n\
             X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n\
             Cache-Control: no-store\r\nConnection: close\r\n",
            self.status,
            self.media_type,
            self.body.len(),
        );
        if self.status == 405 {
            head += "Allow: GET, HEAD\r\n";
        }
        if let Some(location) = &self.location {
            head += &format!("Location: {location}\r\n");
        }
        head += "\r\n";
        to.write_all(head.as_bytes())?;
        if !head_only {
            to.write_all(&self.body)?;
        }
        to.flush()
    }
}

/// Reads a request up to the empty line after its head and ignores the rest.
///
/// # Errors
/// The response to a bad request; `None` if the connection is closed.
pub(super) fn read(mut from: impl Read) -> Result<RequestHead, Option<Response>> {
    let mut bytes: Vec<u8> = Vec::new();
    let mut piece = [0; 2048];
    loop {
        let count = match from.read(&mut piece) {
            Ok(0) | Err(_) => return Err(None),
            Ok(count) => count,
        };
        bytes.extend(&piece[..count]);
        match RequestHead::parse(&bytes) {
            Ok(None) => {}
            Ok(Some((head, _))) if ["GET", "HEAD"].contains(&head.method.as_str()) => return Ok(head),
            Ok(Some(_)) => return Err(Some(Response::refusal(405, "only GET and HEAD are supported"))),
            Err(error) => return Err(Some(Response::refusal(error.status(), error.to_string()))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::web::MAX_HEAD;

    fn refused(bytes: &[u8]) -> Option<u16> {
        read(bytes).unwrap_err().map(|r| r.status)
    }

    #[test]
    fn malformed_requests_are_refused() {
        assert_eq!(read(&b"HEAD / HTTP/1.1\r\n\r\nrest"[..]).unwrap().method, "HEAD");
        assert_eq!(refused(b""), None, "the connection is closed");
        assert_eq!(refused(b"GET / HTTP/1.1\r\nHost: a\r\n"), None, "closed in the middle");
        assert_eq!(refused(b"\x16\x03\x01\x02\x00\x01"), Some(400), "TLS");
        assert_eq!(refused(b"POST / HTTP/1.1\r\n\r\n"), Some(405));
        let long = format!("GET / HTTP/1.1\r\nA: {}", "a".repeat(2 * MAX_HEAD));
        assert_eq!(refused(long.as_bytes()), Some(431));
    }
}
