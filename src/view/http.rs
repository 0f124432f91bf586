//! The part of HTTP/1.1 that a local viewer needs: one `GET` or `HEAD` request per connection.

use std::borrow::Cow;
use std::io::{Read, Write};

/// Longest accepted head of a request, bytes. Browsers send less than 2 kB without cookies.
const MAX_HEAD: usize = 16 * 1024;
/// Largest number of header fields.
const MAX_FIELDS: usize = 64;

/// A page loads data from its own server only, and other pages must not frame it.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src 'self' data: blob:; \
                      connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// A request.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Request {
    /// `HEAD` instead of `GET`.
    pub head_only: bool,
    /// The target with its query.
    pub target: String,
    /// The field `Host`.
    pub host: Option<String>,
}

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
pub(super) fn read(mut from: impl Read) -> Result<Request, Option<Response>> {
    let mut bytes: Vec<u8> = Vec::new();
    let mut piece = [0; 2048];
    loop {
        let count = match from.read(&mut piece) {
            Ok(0) | Err(_) => return Err(None),
            Ok(count) => count,
        };
        bytes.extend(&piece[..count]);
        let mut fields = [httparse::EMPTY_HEADER; MAX_FIELDS];
        let mut request = httparse::Request::new(&mut fields);
        match request.parse(&bytes) {
            Ok(httparse::Status::Complete(_)) => return accept(&request),
            Ok(httparse::Status::Partial) if bytes.len() <= MAX_HEAD => {}
            Ok(httparse::Status::Partial) | Err(httparse::Error::TooManyHeaders) => {
                return Err(Some(Response::refusal(431, "the head of the request is too long")));
            }
            Err(error) => return Err(Some(Response::refusal(400, format!("not an HTTP request: {error}")))),
        }
    }
}

fn accept(request: &httparse::Request) -> Result<Request, Option<Response>> {
    let head_only = match request.method {
        Some("GET") => false,
        Some("HEAD") => true,
        _ => return Err(Some(Response::refusal(405, "only GET and HEAD are supported"))),
    };
    let mut hosts = request.headers.iter().filter(|h| h.name.eq_ignore_ascii_case("host"));
    let host = hosts.next().map(|h| String::from_utf8_lossy(h.value).into_owned());
    if hosts.next().is_some() {
        return Err(Some(Response::refusal(400, "more than one Host field")));
    }
    Ok(Request { head_only, target: request.path.unwrap_or_default().to_owned(), host })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(bytes: &[u8]) -> Option<u16> {
        read(bytes).unwrap_err().map(|r| r.status)
    }

    #[test]
    fn a_request_has_method_target_and_host() {
        let found = read(&b"HEAD /run/0/?x=1 HTTP/1.1\r\nhOST: localhost:80\r\nA: b\r\n\r\nrest"[..]).unwrap();
        assert_eq!(found, Request { head_only: true, target: "/run/0/?x=1".into(), host: Some("localhost:80".into()) });
    }

    #[test]
    fn malformed_requests_are_refused() {
        assert_eq!(refused(b""), None, "the connection is closed");
        assert_eq!(refused(b"GET / HTTP/1.1\r\nHost: a\r\n"), None, "closed in the middle");
        assert_eq!(refused(b"\x16\x03\x01\x02\x00\x01"), Some(400), "TLS");
        assert_eq!(refused(b"POST / HTTP/1.1\r\n\r\n"), Some(405));
        assert_eq!(refused(b"GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n"), Some(400));
        let long = format!("GET / HTTP/1.1\r\nA: {}", "a".repeat(2 * MAX_HEAD));
        assert_eq!(refused(long.as_bytes()), Some(431));
        let many = format!("GET / HTTP/1.1\r\n{}\r\n", "A: b\r\n".repeat(MAX_FIELDS + 1));
        assert_eq!(refused(many.as_bytes()), Some(431));
    }
}
