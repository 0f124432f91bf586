//! Random numbers from a seed and a purpose, the same on every machine.
//!
//! Imports: `math`. Used by: `search`, `collision`, `force`, `script`, `scenario`, `sim`, `assemble`,
//! `remote`.

use crate::math;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A ChaCha8 stream seeded with the BLAKE3 hash of a seed and the strings of a purpose. Streams for
/// different purposes are independent.
#[derive(Clone, Debug)]
pub struct Stream(ChaCha8Rng);

impl Stream {
    /// The stream of a seed for a purpose, such as `["force", "0"]`.
    pub fn new<S: AsRef<str>>(seed: u64, purpose: &[S]) -> Self {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&seed.to_le_bytes());
        for part in purpose {
            // Lengths come first, so that no two purposes give the same bytes.
            let part = part.as_ref().as_bytes();
            hasher.update(&(part.len() as u64).to_le_bytes()).update(part);
        }
        Stream(ChaCha8Rng::from_seed(*hasher.finalize().as_bytes()))
    }

    /// A uniform number in (0, 1): 52 random bits plus half of the last one, so never 0 or 1.
    pub fn unit(&mut self) -> f64 {
        ((self.0.next_u64() >> 12) as f64 + 0.5) * math::powi(0.5, 52)
    }

    /// A standard normal number, `sqrt(-2 ln u) cos(2 pi w)` [Box 1958].
    pub fn normal(&mut self) -> f64 {
        let (u, w) = (self.unit(), self.unit());
        (-2.0 * math::ln(u)).sqrt() * math::cos(std::f64::consts::TAU * w)
    }

    /// A whole number below `n` (at least 1), each equally likely: numbers beyond the greatest
    /// multiple of `n` are drawn again.
    pub fn below(&mut self, n: u64) -> u64 {
        let limit = u64::MAX - u64::MAX % n;
        loop {
            let x = self.0.next_u64();
            if x < limit {
                return x % n;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_of_the_normal_distribution() {
        let mut s = Stream::new(1, &["test"]);
        let n = 200_000;
        let x: Vec<f64> = (0..n).map(|_| s.normal()).collect();
        let moment = |k: i32| x.iter().map(|x| x.powi(k)).sum::<f64>() / f64::from(n);
        // The bound is five standard deviations of each sample moment, sqrt(Var(x^k) / n).
        for (k, expected, variance) in [(1, 0.0, 1.0), (2, 1.0, 2.0), (3, 0.0, 15.0), (4, 3.0, 96.0)] {
            let bound = 5.0 * f64::sqrt(variance / f64::from(n));
            assert!((moment(k) - expected).abs() < bound, "moment {k}: {}", moment(k));
        }
    }

    #[test]
    fn streams_differ_by_seed_and_by_purpose() {
        let first = |seed, purpose| Stream::new(seed, &[purpose]).unit();
        assert_eq!(first(1, "a"), first(1, "a"));
        assert!(first(1, "a") != first(2, "a") && first(1, "a") != first(1, "b"));
    }
}
