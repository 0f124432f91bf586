//! Challenges of a robot side that waits for a client. They are functions of a secret, so nothing is
//! stored per hello: the sender of many hellos takes no memory and replaces no other client.

use std::net::{IpAddr, SocketAddr};
use std::time::{Duration, Instant};

use crate::remote::link_error::LinkError;
use crate::remote::random_bytes;
use crate::remote::wire::CHALLENGE_SIZE;

/// Time in which a challenge is valid: at least this, less than twice. It bounds how long a confirm
/// that was held back on its way can begin a session.
const VALID: Duration = Duration::from_secs(10);

/// Issues and verifies challenges.
pub(super) struct Challenges {
    secret: [u8; 32],
    start: Instant,
}

impl Challenges {
    pub fn new() -> Result<Self, LinkError> {
        Ok(Challenges { secret: random_bytes()?, start: Instant::now() })
    }

    /// The challenge for the hello with this number from an address.
    pub fn issue(&self, from: SocketAddr, hello: u64, now: Instant) -> [u8; CHALLENGE_SIZE] {
        *self.hash(from, hello, self.period(now)).as_bytes()
    }

    /// True if the challenge was issued for this hello and address, and is still valid.
    pub fn verifies(&self, from: SocketAddr, hello: u64, challenge: &[u8; CHALLENGE_SIZE], now: Instant) -> bool {
        let last = self.period(now);
        // The comparison of hashes takes constant time.
        (last.saturating_sub(1)..=last).any(|period| self.hash(from, hello, period) == *challenge)
    }

    fn period(&self, now: Instant) -> u64 {
        now.saturating_duration_since(self.start).as_secs() / VALID.as_secs()
    }

    fn hash(&self, from: SocketAddr, hello: u64, period: u64) -> blake3::Hash {
        let mut hasher = blake3::Hasher::new_keyed(&self.secret);
        let ip = match from.ip() {
            IpAddr::V4(ip) => ip.to_ipv6_mapped(),
            IpAddr::V6(ip) => ip,
        };
        hasher.update(&ip.octets()).update(&from.port().to_le_bytes());
        hasher.update(&hello.to_le_bytes()).update(&period.to_le_bytes()).finalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_challenge_is_valid_for_its_hello_address_server_and_time() {
        let (one, other) = (Challenges::new().unwrap(), Challenges::new().unwrap());
        let at = |text: &str| -> SocketAddr { text.parse().unwrap() };
        let (from, start) = (at("127.0.0.1:5000"), one.start);
        let challenge = one.issue(from, 7, start);
        assert!(one.verifies(from, 7, &challenge, start));
        assert!(one.verifies(from, 7, &challenge, start + 2 * VALID - Duration::from_millis(1)));
        assert!(!one.verifies(from, 7, &challenge, start + 2 * VALID), "it is too old");
        assert!(!one.verifies(from, 8, &challenge, start), "another hello");
        assert!(!one.verifies(at("127.0.0.1:5001"), 7, &challenge, start), "another port");
        assert!(!one.verifies(at("127.0.0.2:5000"), 7, &challenge, start), "another address");
        assert!(!other.verifies(from, 7, &challenge, start.max(other.start)), "another server");
        for bit in 0..8 * CHALLENGE_SIZE {
            let mut changed = challenge;
            changed[bit / 8] ^= 1 << (bit % 8);
            assert!(!one.verifies(from, 7, &changed, start), "bit {bit}");
        }
    }
}
