//! Random numbers of a run: streams that depend on its seed and a name, and on nothing of the machine's threads.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A stream of its own for `name`: what else draws random numbers changes nothing in it.
pub fn stream(seed: u64, name: &str) -> ChaCha8Rng {
    let mut hasher = blake3::Hasher::new();
    hasher.update(b"run").update(&seed.to_le_bytes()).update(name.as_bytes());
    ChaCha8Rng::from_seed(*hasher.finalize().as_bytes())
}

/// Uniform in the open interval (0, 1).
pub fn unit(stream: &mut ChaCha8Rng) -> f64 {
    ((stream.next_u64() >> 12) as f64 + 0.5) * 0.5f64.powi(52)
}

/// Standard normal, by Box and Muller: `sqrt(-2 ln u) cos(2 pi w)`. Source: G. E. P. Box, M. E. Muller, Annals of
/// Mathematical Statistics 29 (1958) 610.
pub fn normal(stream: &mut ChaCha8Rng) -> f64 {
    let (u, w) = (unit(stream), unit(stream));
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * w).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_of_the_normal_distribution() {
        let mut s = stream(1, "test");
        let n = 200_000;
        let x: Vec<f64> = (0..n).map(|_| normal(&mut s)).collect();
        let moment = |k: i32| x.iter().map(|x| x.powi(k)).sum::<f64>() / f64::from(n);
        // Five standard deviations of each sample moment: sqrt(Var(x^k) / n) with variances 1, 2, 15, 96.
        for (k, want, variance) in [(1, 0.0, 1.0), (2, 1.0, 2.0), (3, 0.0, 15.0), (4, 3.0, 96.0)] {
            let bar = 5.0 * f64::sqrt(variance / f64::from(n));
            assert!((moment(k) - want).abs() < bar, "moment {k}: {}", moment(k));
        }
    }

    #[test]
    fn streams_differ_by_seed_and_by_name() {
        let first = |seed, name| unit(&mut stream(seed, name));
        assert_eq!(first(1, "a"), first(1, "a"));
        assert!(first(1, "a") != first(2, "a") && first(1, "a") != first(1, "b"));
    }
}
