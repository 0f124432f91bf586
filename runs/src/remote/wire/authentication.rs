//! Authenticates packets by a keyed BLAKE3 hash over all bytes before the tag. Without the key,
//! packets can be neither forged nor changed. Session and sequence numbers, which the tag covers,
//! reject replayed packets of a session; the challenge of the welcome rejects replayed sessions.

/// Length of a tag, bytes.
pub const TAG_SIZE: usize = 32;

/// Smallest length of a secret, bytes.
pub const MIN_SECRET: usize = 16;

/// A pre-shared key.
#[derive(Clone)]
pub struct Key([u8; 32]);

impl Key {
    /// Derives the key from a secret that both sides have, such as the bytes of a file; none if the
    /// secret is shorter than [`MIN_SECRET`] bytes.
    pub fn of(secret: &[u8]) -> Option<Key> {
        (secret.len() >= MIN_SECRET).then(|| Key(blake3::derive_key("stiction 2026 wire format 2, packets", secret)))
    }

    /// Authentication tag of these bytes.
    pub(super) fn tag(&self, bytes: &[u8]) -> [u8; TAG_SIZE] {
        *blake3::keyed_hash(&self.0, bytes).as_bytes()
    }

    /// True if `tag` is the tag of these bytes; compares in constant time.
    pub(super) fn verifies(&self, bytes: &[u8], tag: &[u8]) -> bool {
        <[u8; TAG_SIZE]>::try_from(tag).is_ok_and(|tag| blake3::keyed_hash(&self.0, bytes) == tag)
    }
}

impl std::fmt::Debug for Key {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Key(..)")
    }
}
