//! Which requests a server on loopback answers.
//!
//! Pages of any site can send requests to loopback. Two fields that pages cannot choose tell them
//! apart: `Host` is the name in the address that the browser opened, which is foreign if a site
//! resolves its own name to loopback (DNS rebinding). `Origin` is the site of the page; browsers
//! send it with every WebSocket handshake and do not limit handshakes to the page's own site.

use std::net::{Ipv4Addr, Ipv6Addr};

use crate::web::RequestHead;

/// Longest part of a field in an error, characters.
const MAX_SHOWN: usize = 200;

/// Hosts and origins of permitted requests. Names and addresses of loopback are always permitted.
#[derive(Clone, Debug, Default)]
pub struct LocalAccess {
    /// Port that the host must have; none: any, as behind a forwarded port.
    pub port: Option<u16>,
    /// Other permitted hosts, without port.
    pub hosts: Vec<String>,
    /// Other permitted origins.
    pub origins: Vec<String>,
}

/// Why a request is refused. The text escapes and shortens what the client sent.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum AccessError {
    /// No `Host`, or several.
    #[error("expected one Host field, found {0}")]
    Hosts(usize),
    /// A host other than loopback.
    #[error("the host {0} is not permitted")]
    Host(String),
    /// Several origins.
    #[error("expected at most one Origin field, found {0}")]
    Origins(usize),
    /// An origin other than loopback or a known one.
    #[error("the origin {0} is not permitted")]
    Origin(String),
}

impl LocalAccess {
    /// Checks `Host` and `Origin` of a request. A request without origin is not from a page.
    ///
    /// # Errors
    /// See [`AccessError`].
    pub fn check(&self, head: &RequestHead) -> Result<(), AccessError> {
        let hosts: Vec<String> = head.fields("host").collect();
        let [host] = hosts.as_slice() else { return Err(AccessError::Hosts(hosts.len())) };
        if !self.permits_host(host) {
            return Err(AccessError::Host(shown(host)));
        }
        let origins: Vec<String> = head.fields("origin").collect();
        match origins.as_slice() {
            [] => Ok(()),
            [origin] if self.permits_origin(origin) => Ok(()),
            [origin] => Err(AccessError::Origin(shown(origin))),
            several => Err(AccessError::Origins(several.len())),
        }
    }

    fn permits_host(&self, host: &str) -> bool {
        let Some((name, port)) = split_port(host) else { return false };
        let named = is_loopback(name) || self.hosts.iter().any(|other| other.eq_ignore_ascii_case(name));
        // Browsers omit the port of the scheme.
        named && self.port.is_none_or(|expected| expected == port.unwrap_or(80))
    }

    fn permits_origin(&self, origin: &str) -> bool {
        let site = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
        site.and_then(split_port).is_some_and(|(name, _)| is_loopback(name))
            || self.origins.iter().any(|other| other.eq_ignore_ascii_case(origin))
    }
}

/// True for an origin as browsers send it: scheme and host, perhaps a port, no path.
pub fn is_origin(text: &str) -> bool {
    let Some((scheme, site)) = text.split_once("://") else { return false };
    let valid =
        |text: &str, more: &str| text.bytes().all(|b| b.is_ascii_alphanumeric() || more.as_bytes().contains(&b));
    let known = scheme == "file" && site.is_empty();
    !scheme.is_empty() && valid(scheme, "+-.") && (known || !site.is_empty()) && valid(site, "-._:[]~")
}

/// Name and port of a host.
fn split_port(host: &str) -> Option<(&str, Option<u16>)> {
    let end = match host.starts_with('[') {
        true => host.find(']')? + 1,
        false => host.find(':').unwrap_or(host.len()),
    };
    let (name, port) = host.split_at(end);
    match port.strip_prefix(':') {
        None => port.is_empty().then_some((name, None)),
        // `parse` accepts a sign.
        Some(digits) => digits
            .bytes()
            .all(|b| b.is_ascii_digit())
            .then(|| digits.parse().ok())
            .flatten()
            .map(|port| (name, Some(port))),
    }
}

fn is_loopback(name: &str) -> bool {
    let v6 = name.strip_prefix('[').and_then(|rest| rest.strip_suffix(']'));
    name.eq_ignore_ascii_case("localhost")
        || name.parse().is_ok_and(|ip: Ipv4Addr| ip.is_loopback())
        || v6.is_some_and(|name| name.parse().is_ok_and(|ip: Ipv6Addr| ip.is_loopback()))
}

fn shown(text: &str) -> String {
    let short: String = text.chars().take(MAX_SHOWN).collect();
    let more = if short.len() < text.len() { "..." } else { "" };
    format!("{short:?}{more}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(access: &LocalAccess, fields: &str) -> Result<(), AccessError> {
        let request = format!("GET / HTTP/1.1\r\n{fields}\r\n");
        access.check(&RequestHead::parse(request.as_bytes()).unwrap().unwrap().0)
    }

    #[test]
    fn only_hosts_of_loopback_and_given_ones_are_permitted() {
        let access = LocalAccess { hosts: vec!["robot.local".into()], ..LocalAccess::default() };
        for host in ["localhost", "LocalHost:8765", "127.0.0.1:1", "127.255.0.3", "[::1]", "[::1]:80", "Robot.Local:5"]
        {
            assert_eq!(check(&access, &format!("Host: {host}\r\n")), Ok(()), "{host}");
        }
        for host in [
            "evil.example",
            "evil.example:8765",
            "localhost.evil.example",
            "127.0.0.1.evil.example",
            "0.0.0.0",
            "128.0.0.1",
            "2130706433",
            "0177.0.0.1",
            "[::2]",
            "[::1",
            "[::1]evil",
            "::1",
            "localhost:",
            "localhost:+80",
            "localhost:99999",
            "localhost:80:80",
            "user@localhost",
            "",
        ] {
            let found = check(&access, &format!("Host: {host}\r\n"));
            assert!(matches!(found, Err(AccessError::Host(_))), "{host}: {found:?}");
        }
        assert_eq!(check(&access, ""), Err(AccessError::Hosts(0)));
        assert_eq!(check(&access, "Host: localhost\r\nhost: evil.example\r\n"), Err(AccessError::Hosts(2)));
    }

    #[test]
    fn a_port_may_be_required() {
        let at = |port| LocalAccess { port: Some(port), ..LocalAccess::default() };
        assert_eq!(check(&at(8765), "Host: localhost:8765\r\n"), Ok(()));
        for host in ["localhost:8766", "localhost"] {
            assert!(check(&at(8765), &format!("Host: {host}\r\n")).is_err(), "{host}");
        }
        assert_eq!(check(&at(80), "Host: localhost\r\n"), Ok(()));
    }

    #[test]
    fn only_origins_of_loopback_and_given_ones_are_permitted() {
        let origins = vec!["https://viewer.example".into(), "file://".into()];
        let access = LocalAccess { origins, ..LocalAccess::default() };
        let with = |origin: &str| check(&access, &format!("Host: localhost\r\nOrigin: {origin}\r\n"));
        for origin in
            ["http://localhost:8080", "https://127.0.0.1", "http://[::1]:3", "https://Viewer.example", "file://"]
        {
            assert_eq!(with(origin), Ok(()), "{origin}");
        }
        for origin in [
            "https://evil.example",
            "http://viewer.example",
            "https://viewer.example:444",
            "https://viewer.example.evil.example",
            "http://localhost.evil.example",
            "http://localhost@evil.example",
            "ftp://localhost",
            "localhost",
            // Sandboxed frames of any site.
            "null",
            "",
        ] {
            assert!(matches!(with(origin), Err(AccessError::Origin(_))), "{origin}");
        }
        let two = "Host: localhost\r\nOrigin: file://\r\nOrigin: https://evil.example\r\n";
        assert_eq!(check(&access, two), Err(AccessError::Origins(2)));
    }

    #[test]
    fn errors_escape_and_shorten_what_the_client_sent() {
        let found = check(&LocalAccess::default(), &format!("Host: a\u{9b}31m{}\r\n", "b".repeat(900))).unwrap_err();
        let text = found.to_string();
        assert!(text.contains("a\\u{9b}31m") && text.len() < 300, "{text}");
    }

    #[test]
    fn origins_have_a_scheme_and_a_host_but_no_path() {
        for origin in ["https://viewer.example", "http://10.0.0.1:8080", "app://viewer", "file://", "http://[::1]:80"] {
            assert!(is_origin(origin), "{origin}");
        }
        for other in
            ["viewer.example", "https://", "https://viewer.example/", "https://a b", "null", "*", "://a", "a://é"]
        {
            assert!(!is_origin(other), "{other}");
        }
    }
}
