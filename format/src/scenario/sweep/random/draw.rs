//! Random numbers in the open interval (0, 1), from the scenario's seed, the same on every machine.
//!
//! Independent and Latin hypercube draws use one ChaCha8 stream per key, seeded with the BLAKE3
//! hash of seed and path, so another key changes nothing. A Sobol sequence fills all its dimensions
//! together: a key's numbers depend on its index among the keys. Sources: [McKay 1979] (Latin
//! hypercube); [Burley 2020] (Owen scrambling).

use crate::math;
use crate::random::Stream;
use crate::scenario::key_path::KeyPath;

/// `n` independent uniform numbers; the first ones stay when `n` grows.
pub fn independent(seed: u64, path: &KeyPath, n: usize) -> Vec<f64> {
    let mut stream = stream(seed, path);
    (0..n).map(|_| stream.unit()).collect()
}

/// `n` numbers, one in each of the `n` equal parts of the interval, in random order.
pub fn latin(seed: u64, path: &KeyPath, n: usize) -> Vec<f64> {
    let mut stream = stream(seed, path);
    let mut part: Vec<usize> = (0..n).collect();
    // Fisher and Yates.
    for last in (1..n).rev() {
        part.swap(last, stream.below(last as u64 + 1) as usize);
    }
    let inside = |k: usize| {
        let x = (k as f64 + stream.unit()) / n as f64;
        // Rounding must not move a number into the next part.
        x.min(((k + 1) as f64 / n as f64).next_down())
    };
    part.into_iter().map(inside).collect()
}

/// The first `n` numbers of one dimension of an Owen-scrambled Sobol sequence; they keep 24 bits.
pub fn sobol(seed: u64, dimension: u32, n: usize) -> Vec<f64> {
    let hash = blake3::hash(&seed.to_le_bytes());
    let scramble = u32::from_le_bytes(hash.as_bytes()[..4].try_into().unwrap_or_default());
    // The middle of the interval of 2^-24 that a number represents: 0 has no quantile of a normal
    // distribution.
    let middle = |i: u32| f64::from(sobol_burley::sample(i, dimension, scramble)) + math::powi(0.5, 25);
    (0..n as u32).map(middle).collect()
}

fn stream(seed: u64, path: &KeyPath) -> Stream {
    let segments: Vec<&str> = path.segments.iter().map(|(segment, _)| segment.as_str()).collect();
    Stream::new(seed, &segments)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(text: &str) -> KeyPath {
        KeyPath::internal(text)
    }

    /// The part, of `n` equal ones, of each number.
    fn parts(numbers: &[f64], n: usize) -> Vec<usize> {
        let mut parts: Vec<usize> = numbers.iter().map(|x| (x * n as f64).floor() as usize).collect();
        parts.sort_unstable();
        parts
    }

    #[test]
    fn a_latin_hypercube_has_one_number_in_each_part() {
        for n in [1, 2, 3, 7, 16, 1000] {
            for seed in 0..20 {
                let drawn = latin(seed, &path("a.b"), n);
                assert_eq!(parts(&drawn, n), (0..n).collect::<Vec<_>>(), "{n} {seed}");
                // Exactly: between the parts' ends as the same division gives them.
                assert!(drawn.iter().all(|x| {
                    let k = (x * n as f64).floor();
                    k / n as f64 <= *x && *x < (k + 1.0) / n as f64
                }));
            }
        }
    }

    #[test]
    fn a_sobol_sequence_has_one_number_in_each_part_of_a_power_of_two() {
        for seed in 0..5 {
            for dimension in [0, 1, 2, 17, 255] {
                for n in [1, 2, 64, 1024] {
                    let drawn = sobol(seed, dimension, n);
                    assert_eq!(parts(&drawn, n), (0..n).collect::<Vec<_>>(), "{seed} {dimension} {n}");
                }
            }
        }
    }

    /// The L2 star discrepancy in two dimensions, by Warnock's formula.
    fn discrepancy(x: &[f64], y: &[f64]) -> f64 {
        let n = x.len() as f64;
        let one: f64 = x.iter().zip(y).map(|(x, y)| (1.0 - x * x) * (1.0 - y * y)).sum();
        let mut two = 0.0;
        for (a, b) in x.iter().zip(y) {
            two += x.iter().zip(y).map(|(c, d)| (1.0 - a.max(*c)) * (1.0 - b.max(*d))).sum::<f64>();
        }
        (1.0 / 9.0 - one / (2.0 * n) + two / (n * n)).sqrt()
    }

    #[test]
    fn a_sobol_sequence_fills_the_square_more_evenly_than_chance() {
        let n = 256;
        // The expected square for independent numbers is (1/4 - 1/9) / n; of a (0, 8, 2) net it is
        // smaller by about n.
        let chance = ((0.25f64 - 1.0 / 9.0) / n as f64).sqrt();
        let (mut even, mut random, mut latins) = (0.0f64, 0.0, 0.0);
        for seed in 0..20 {
            even = even.max(discrepancy(&sobol(seed, 0, n), &sobol(seed, 1, n)));
            random += discrepancy(&independent(seed, &path("x"), n), &independent(seed, &path("y"), n)).powi(2) / 20.0;
            latins += discrepancy(&latin(seed, &path("x"), n), &latin(seed, &path("y"), n)).powi(2) / 20.0;
        }
        assert!(even < 0.2 * chance, "{even} against {chance}");
        // The mean of 20 squares, each with a standard deviation of about its mean.
        assert!((random.sqrt() / chance - 1.0).abs() < 0.35, "{random} against {chance}");
        assert!(latins.sqrt() < 0.75 * chance, "{latins}: less than chance, since both margins are even");
    }

    #[test]
    fn independent_numbers_are_uniform() {
        let n = 40_000;
        let drawn = independent(3, &path("floor.friction"), n);
        // Pearson's statistic over 100 parts: 99 degrees of freedom, mean 99, standard deviation
        // 14; five of them.
        let mut counts = [0.0f64; 100];
        drawn.iter().for_each(|x| counts[(x * 100.0) as usize] += 1.0);
        let expected = n as f64 / 100.0;
        let statistic: f64 = counts.iter().map(|c| (c - expected).powi(2) / expected).sum();
        assert!((statistic - 99.0).abs() < 70.0, "{statistic}");
        // Neighbours are not correlated: the coefficient has a standard deviation of 1 / sqrt(n).
        let covariance: f64 = drawn.windows(2).map(|w| (w[0] - 0.5) * (w[1] - 0.5)).sum::<f64>() / n as f64;
        assert!((12.0 * covariance).abs() < 5.0 / (n as f64).sqrt(), "{covariance}");
    }

    #[test]
    fn orders_of_a_latin_hypercube_are_equally_likely() {
        let mut counts = std::collections::BTreeMap::new();
        let seeds = 6000;
        for seed in 0..seeds {
            let drawn = latin(seed, &path("a"), 3);
            *counts.entry(drawn.iter().map(|x| (x * 3.0) as u8).collect::<Vec<_>>()).or_insert(0.0) += 1.0;
        }
        // Six orders, 1000 each with a standard deviation of 29.
        assert_eq!(counts.len(), 6);
        assert!(counts.values().all(|c: &f64| (c - 1000.0).abs() < 150.0), "{counts:?}");
    }

    #[test]
    fn draws_depend_on_seed_and_path_only() {
        let base = independent(1, &path("a.b"), 4);
        assert_eq!(base, independent(1, &path("a.b"), 4));
        assert_eq!(base, independent(1, &path("a.b"), 9)[..4], "more samples leave the first as they are");
        assert_ne!(base, independent(2, &path("a.b"), 4));
        assert_ne!(base, independent(1, &path("a.c"), 4));
        assert_ne!(base, independent(1, &path("ab"), 4));
        assert_eq!(sobol(1, 3, 4), sobol(1, 3, 9)[..4]);
        assert_ne!(sobol(1, 3, 4), sobol(2, 3, 4));
    }
}
