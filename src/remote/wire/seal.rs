//! Seals: a keyed hash (BLAKE3) over all of a packet before the seal. Who has not the key can neither make a packet nor change
//! one; session and sequence number, which it covers, keep an old one from being used again.

/// Bytes of a seal.
pub const SIZE: usize = 32;

/// Least bytes of what a key is made of.
pub const SHORTEST_SECRET: usize = 16;

/// A pre-shared key.
#[derive(Clone)]
pub struct Key([u8; 32]);

impl Key {
    /// The key of a secret that both sides have, such as the bytes of a file; none if it is shorter than
    /// [`SHORTEST_SECRET`] bytes.
    pub fn of(secret: &[u8]) -> Option<Key> {
        (secret.len() >= SHORTEST_SECRET)
            .then(|| Key(blake3::derive_key("stiction 2026 wire format 1, packets", secret)))
    }

    /// The seal of these bytes.
    pub(super) fn seal(&self, bytes: &[u8]) -> [u8; SIZE] {
        *blake3::keyed_hash(&self.0, bytes).as_bytes()
    }

    /// Is `seal` that of these bytes? Takes equally long whatever differs.
    pub(super) fn fits(&self, bytes: &[u8], seal: &[u8]) -> bool {
        <[u8; SIZE]>::try_from(seal).is_ok_and(|seal| blake3::keyed_hash(&self.0, bytes) == seal)
    }
}

impl std::fmt::Debug for Key {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Key(..)")
    }
}
