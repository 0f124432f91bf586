//! Binomial probabilities and tails, by the saddle-point form of [Loader 2000]:
//!
//! ```text
//! ln P(X = k) = d(n) - d(k) - d(n - k) - D(k, n p) - D(n - k, n q) + ln(n / (2 pi k (n - k))) / 2
//! D(x, m) = x ln(x / m) + m - x,   d(n) = ln n! - ln(sqrt(2 pi n) (n / e)^n),   q = 1 - p
//! ```
//!
//! No large numbers cancel. Tails are sums of terms that fall from their first: the tail beyond the
//! mean is summed, the other is its complement. Relative errors are below 1e-12 for up to a million
//! runs, compared with sums in rational arithmetic (`tests/oracles/make_binomial.py`).

use crate::math;

use std::f64::consts::PI;

/// Terms below this fraction of the sum end a tail.
const NEGLIGIBLE: f64 = 1e-18;

/// `ln P(X = k)` of `n` trials that succeed with probability `p`.
pub fn ln_probability(n: usize, k: usize, p: f64) -> f64 {
    if k > n {
        return f64::NEG_INFINITY;
    }
    if p <= 0.0 || p >= 1.0 {
        let sure = if p <= 0.0 { 0 } else { n };
        return if k == sure { 0.0 } else { f64::NEG_INFINITY };
    }
    let (q, trials, successes, failures) = (1.0 - p, n as f64, k as f64, (n - k) as f64);
    if k == 0 {
        return ln_power(q, p, trials);
    }
    if k == n {
        return ln_power(p, q, trials);
    }
    let size = stirling_error(n) - stirling_error(k) - stirling_error(n - k);
    let deviance = deviance(successes, trials * p) + deviance(failures, trials * q);
    size - deviance + 0.5 * math::ln(trials / (2.0 * PI * successes * failures))
}

/// `P(X = k)` of `n` trials that succeed with probability `p`.
pub fn probability(n: usize, k: usize, p: f64) -> f64 {
    math::exp(ln_probability(n, k, p))
}

/// `P(X >= k)` of `n` trials that succeed with probability `p`.
pub fn upper_tail(n: usize, k: usize, p: f64) -> f64 {
    match k {
        0 => 1.0,
        k if k > n => 0.0,
        k if k as f64 > n as f64 * p => sum_up(n, k, p),
        k => 1.0 - sum_down(n, k - 1, p),
    }
}

/// `P(X <= k)` of `n` trials that succeed with probability `p`.
pub fn lower_tail(n: usize, k: usize, p: f64) -> f64 {
    match k {
        k if k >= n => 1.0,
        k if (k as f64) < n as f64 * p => sum_down(n, k, p),
        k => 1.0 - sum_up(n, k + 1, p),
    }
}

/// `n ln a` with `a = 1 - b`, without the rounding of `a` where `b` is small.
fn ln_power(a: f64, b: f64, n: f64) -> f64 {
    if b < 0.1 { -deviance(n, n * a) - n * b } else { n * math::ln(a) }
}

/// Sum of the probabilities of `k` and more.
fn sum_up(n: usize, k: usize, p: f64) -> f64 {
    let odds = p / (1.0 - p);
    sum(probability(n, k, p), k..n, |j| (n - j) as f64 / (j + 1) as f64 * odds)
}

/// Sum of the probabilities of `k` and fewer.
fn sum_down(n: usize, k: usize, p: f64) -> f64 {
    let odds = (1.0 - p) / p;
    sum(probability(n, k, p), (1..=k).rev(), |j| j as f64 / (n - j + 1) as f64 * odds)
}

/// Sum of terms with a ratio to the previous one at each index.
fn sum(first: f64, indices: impl Iterator<Item = usize>, ratio: impl Fn(usize) -> f64) -> f64 {
    let (mut sum, mut term) = (first, first);
    for index in indices {
        let factor = ratio(index);
        term *= factor;
        sum += term;
        if factor < 1.0 && term <= sum * NEGLIGIBLE {
            break;
        }
    }
    sum.min(1.0)
}

/// Error of Stirling's formula for `ln n!`.
fn stirling_error(n: usize) -> f64 {
    let x = n as f64;
    if n <= 15 {
        // Exact factorials below 2^53.
        let factorial: f64 = (1..=n).map(|i| i as f64).product();
        return math::ln(factorial / (2.0 * PI * x).sqrt()) - x * (math::ln(x) - 1.0);
    }
    let square = x * x;
    let series = 1.0 / 1680.0 - 1.0 / (1188.0 * square);
    (1.0 / 12.0 - (1.0 / 360.0 - (1.0 / 1260.0 - series / square) / square) / square) / x
}

/// `x ln(x / mean) + mean - x`, by a series where `x` is near the mean.
fn deviance(x: f64, mean: f64) -> f64 {
    let (difference, total) = (x - mean, x + mean);
    if difference.abs() >= 0.1 * total {
        return x * math::ln(x / mean) - difference;
    }
    let ratio = difference / total;
    let mut sum = difference * ratio;
    let mut power = 2.0 * x * ratio;
    for odd in (3..).step_by(2) {
        power *= ratio * ratio;
        let next = sum + power / f64::from(odd);
        if next == sum {
            break;
        }
        sum = next;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probabilities_of_few_trials_are_products() {
        // n, k, p, binomial coefficient.
        for (n, k, p, ways) in [(1, 0, 0.3, 1.0), (1, 1, 0.3, 1.0), (5, 2, 0.3, 10.0), (20, 19, 0.99, 20.0)] {
            let exact = ways * math::powi(p, k as i32) * math::powi(1.0 - p, (n - k) as i32);
            // Rounding.
            assert!((probability(n, k, p) / exact - 1.0).abs() < 1e-13, "{n} {k} {p}");
        }
        assert_eq!([probability(3, 0, 0.0), probability(3, 1, 0.0), probability(3, 3, 1.0)], [1.0, 0.0, 1.0]);
        assert_eq!(probability(3, 4, 0.5), 0.0);
    }

    #[test]
    fn probabilities_sum_to_one_and_tails_complement_each_other() {
        for (n, p) in [(1, 0.5), (17, 0.01), (200, 0.99), (2000, 0.3)] {
            let sum: f64 = (0..=n).map(|k| probability(n, k, p)).sum();
            // Rounding of up to 2000 terms.
            assert!((sum - 1.0).abs() < 1e-12, "{n} {p}: {sum}");
            for k in 0..n {
                let both = lower_tail(n, k, p) + upper_tail(n, k + 1, p);
                assert!((both - 1.0).abs() < 1e-12, "{n} {k} {p}: {both}");
            }
            assert_eq!([upper_tail(n, 0, p), lower_tail(n, n, p), upper_tail(n, n + 1, p)], [1.0, 1.0, 0.0]);
        }
    }
}
