//! The key of a run: a short hash of everything its result depends on.

/// Hashes labelled inputs to 16 hexadecimal characters, such as `("scenario", resolved text)`,
/// `("file robot.urdf", bytes)`, `("program", version)`.
///
/// The order of the inputs does not matter; labels distinguish them. 64 bits: among a million runs
/// two share a key with a probability of 3e-8.
pub fn key(inputs: &[(&str, &[u8])]) -> String {
    let mut sorted = inputs.to_vec();
    sorted.sort_unstable();
    let mut hasher = KeyHasher::default();
    sorted.into_iter().for_each(|(label, bytes)| hasher.add(label, &[bytes]));
    format!("{:016x}", hasher.key())
}

/// A key under construction. Copies continue from the inputs that they share.
#[derive(Clone, Default)]
pub struct KeyHasher(blake3::Hasher);

impl KeyHasher {
    /// Adds an input, whose bytes are given in parts. Inputs must be added in the order of their
    /// labels.
    pub fn add(&mut self, label: &str, parts: &[&[u8]]) {
        // Lengths come first, so that no two lists of inputs give the same bytes.
        let length: usize = parts.iter().map(|part| part.len()).sum();
        self.0.update(&(label.len() as u64).to_le_bytes()).update(label.as_bytes());
        self.0.update(&(length as u64).to_le_bytes());
        parts.iter().for_each(|part| {
            self.0.update(part);
        });
    }

    /// The key of the inputs so far: the first 64 bits of their hash.
    pub fn key(&self) -> u64 {
        let mut first = [0; 8];
        first.copy_from_slice(&self.0.finalize().as_bytes()[..8]);
        u64::from_be_bytes(first)
    }
}

#[cfg(test)]
mod tests {
    use super::key;

    #[test]
    fn keys_depend_on_labels_bytes_and_borders_but_not_on_order() {
        let base = key(&[("scenario", b"abc"), ("program", b"1")]);
        assert_eq!(base.len(), 16);
        assert!(base.bytes().all(|b| b.is_ascii_hexdigit()));
        assert_eq!(base, key(&[("program", b"1"), ("scenario", b"abc")]));
        assert_ne!(base, key(&[("scenario", b"abd"), ("program", b"1")]));
        assert_ne!(base, key(&[("scenarioa", b"bc"), ("program", b"1")]));
        assert_ne!(base, key(&[("program", b"abc"), ("scenario", b"1")]));
        assert_ne!(key(&[("a", b"")]), key(&[]));
    }

    #[test]
    fn the_key_of_given_bytes_never_changes() {
        // Computed by Python's blake3 over the same bytes. Results of older runs are identified by
        // their keys.
        assert_eq!(key(&[("scenario", b"abc")]), "de8963159f71ebf3");
    }
}
