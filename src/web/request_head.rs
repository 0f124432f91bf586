//! Parses the head of an HTTP/1.1 request: method, target and fields.

/// Longest accepted head, bytes. Browsers send less than 2 kB without cookies.
pub const MAX_HEAD: usize = 16 << 10;
/// Largest number of fields.
const MAX_FIELDS: usize = 64;

/// Head of a request.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct RequestHead {
    /// The method.
    pub method: String,
    /// The target with its query.
    pub target: String,
    fields: Vec<(String, Vec<u8>)>,
}

/// Why a head is refused.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum HeadError {
    /// More bytes or fields than permitted.
    #[error("the head of the request is too long: expected at most {MAX_HEAD} bytes and {MAX_FIELDS} fields")]
    TooLong,
    /// Not HTTP/1.1.
    #[error("not an HTTP request: {0}")]
    Invalid(httparse::Error),
}

impl HeadError {
    /// Status of the response.
    pub fn status(self) -> u16 {
        match self {
            HeadError::TooLong => 431,
            HeadError::Invalid(_) => 400,
        }
    }
}

impl RequestHead {
    /// Parses the beginning of a connection. Returns the head and its length; none while it is
    /// incomplete.
    ///
    /// # Errors
    /// See [`HeadError`]; an incomplete head that is too long is refused as well.
    pub fn parse(received: &[u8]) -> Result<Option<(Self, usize)>, HeadError> {
        let mut fields = [httparse::EMPTY_HEADER; MAX_FIELDS];
        let mut request = httparse::Request::new(&mut fields);
        match request.parse(received) {
            Ok(httparse::Status::Complete(length)) if length <= MAX_HEAD => {
                let fields = request.headers.iter().map(|field| (field.name.to_owned(), field.value.to_vec()));
                let [method, target] = [request.method, request.path].map(|text| text.unwrap_or_default().to_owned());
                Ok(Some((RequestHead { method, target, fields: fields.collect() }, length)))
            }
            Ok(httparse::Status::Partial) if received.len() < MAX_HEAD => Ok(None),
            Ok(_) | Err(httparse::Error::TooManyHeaders) => Err(HeadError::TooLong),
            Err(error) => Err(HeadError::Invalid(error)),
        }
    }

    /// All fields of this name, as text.
    pub fn fields(&self, name: &str) -> impl Iterator<Item = String> {
        let named = self.fields.iter().filter(move |field| field.0.eq_ignore_ascii_case(name));
        named.map(|field| String::from_utf8_lossy(&field.1).into_owned())
    }

    /// Elements of the comma-separated lists in the fields of this name.
    pub fn elements(&self, name: &str) -> Vec<String> {
        self.fields(name).flat_map(|list| list.split(',').map(|e| e.trim().to_owned()).collect::<Vec<_>>()).collect()
    }

    /// True if a list has this element, in any case.
    pub fn has_element(&self, name: &str, element: &str) -> bool {
        self.elements(name).iter().any(|found| found.eq_ignore_ascii_case(element))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REQUEST: &str = "GET /run/0/?x=1 HTTP/1.1\r\nhOST: localhost:80\r\nA: b, C\r\na: d\r\n\r\n";

    #[test]
    fn a_head_has_method_target_and_fields() {
        let (head, length) = RequestHead::parse(format!("{REQUEST}rest").as_bytes()).unwrap().unwrap();
        assert_eq!((head.method.as_str(), head.target.as_str(), length), ("GET", "/run/0/?x=1", REQUEST.len()));
        assert_eq!(head.fields("Host").collect::<Vec<_>>(), ["localhost:80"]);
        assert_eq!(head.elements("a"), ["b", "C", "d"]);
        assert!(head.has_element("a", "c") && !head.has_element("b", "c"));
        for part in 0..REQUEST.len() {
            assert_eq!(RequestHead::parse(&REQUEST.as_bytes()[..part]), Ok(None), "{part} bytes");
        }
    }

    #[test]
    fn malformed_heads_are_refused() {
        let status = |bytes: &[u8]| RequestHead::parse(bytes).unwrap_err().status();
        assert_eq!(status(b"\x16\x03\x01\x02\x00\x01"), 400, "TLS");
        assert_eq!(status(b"GET / HTTP/9.9\r\n\r\n"), 400);
        let with_length = |length: usize| {
            let rest = "GET / HTTP/1.1\r\nA: \r\n\r\n".len();
            format!("GET / HTTP/1.1\r\nA: {}\r\n\r\n", "a".repeat(length - rest))
        };
        assert!(RequestHead::parse(with_length(MAX_HEAD).as_bytes()).unwrap().is_some());
        assert_eq!(status(with_length(MAX_HEAD + 1).as_bytes()), 431);
        assert_eq!(status(&with_length(2 * MAX_HEAD).as_bytes()[..MAX_HEAD]), 431, "not complete");
        let many = format!("GET / HTTP/1.1\r\n{}\r\n", "A: b\r\n".repeat(MAX_FIELDS + 1));
        assert_eq!(status(many.as_bytes()), 431);
    }

    /// Every change of a byte of a valid request, and every byte alone.
    #[test]
    fn changed_bytes_do_not_panic() {
        for at in 0..REQUEST.len() {
            for byte in 0..=255 {
                let mut changed = REQUEST.as_bytes().to_vec();
                changed[at] = byte;
                if let Ok(Some((head, length))) = RequestHead::parse(&changed) {
                    assert!(length <= changed.len() && head.elements("host").len() <= MAX_HEAD);
                }
            }
        }
    }
}
