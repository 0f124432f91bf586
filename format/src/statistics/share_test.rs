//! Tests of a share against a threshold, and the confidence bounds that they imply.
//!
//! `k` of `n` independent trials succeeded, each with the unknown probability `p`. A test shows
//! `p >= q` or `p <= q`, either wrongly with a probability of at most `alpha`.
//!
//! - **Fixed**: the number of trials does not depend on the results. [Clopper 1934]: `p >= q` is
//!   shown if `P(X >= k; n, q) <= alpha`.
//! - **Sequential**: the test may be made after every trial. `p >= q` is shown once `M >= 1 / alpha`,
//!   where `M` is the ratio of likelihoods, averaged over a uniform prior above `q`:
//!
//! ```text
//! M = 1 / (1 - q) * integral from q to 1 of (p / q)^k ((1 - p) / (1 - q))^(n - k) dp
//!   = P(X <= k; n + 1, q) / ((1 - q) (n + 1) P(X = k; n, q))
//! ```
//!
//!   For `p <= q`, `M` is a supermartingale that begins at 1, so it ever reaches `1 / alpha` with a
//!   probability of at most `alpha` [Ville 1939], [Robbins 1970]. The second line follows from the
//!   incomplete beta function being a binomial tail.
//!
//! `p <= q` is tested by the failures against `1 - q`.

use crate::math;

use super::binomial::{ln_probability, lower_tail, upper_tail};

/// When a test may be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Once, after a number of trials that does not depend on the results.
    Fixed,
    /// After every trial.
    Sequential,
}

/// A test of a share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShareTest {
    /// When it is made.
    pub rule: Rule,
    /// Greatest probability of a wrong result, between 0 and 1.
    pub alpha: f64,
}

impl ShareTest {
    /// True if `k` of `n` successes show that their probability is at least `q`.
    pub fn shows_at_least(self, n: usize, k: usize, q: f64) -> bool {
        match self.rule {
            Rule::Fixed => upper_tail(n, k, q) <= self.alpha,
            Rule::Sequential => ln_mean_above(n, k, q) >= -math::ln(self.alpha),
        }
    }

    /// True if `k` of `n` successes show that their probability is at most `q`.
    pub fn shows_at_most(self, n: usize, k: usize, q: f64) -> bool {
        match self.rule {
            Rule::Fixed => lower_tail(n, k, q) <= self.alpha,
            Rule::Sequential => ln_mean_below(n, k, q) >= -math::ln(self.alpha),
        }
    }

    /// The greatest `q` for which the successes show a probability of at least `q`; 0 if there is
    /// none.
    pub fn lower_bound(self, n: usize, k: usize) -> f64 {
        if k == 0 { 0.0 } else { bisect(0.0, k as f64 / n as f64, |q| self.shows_at_least(n, k, q)) }
    }

    /// The least `q` for which the successes show a probability of at most `q`; 1 if there is none.
    pub fn upper_bound(self, n: usize, k: usize) -> f64 {
        if k == n { 1.0 } else { bisect(1.0, k as f64 / n as f64, |q| self.shows_at_most(n, k, q)) }
    }

    /// The least number of trials of which all succeed that shows a probability of at least `q`.
    pub fn fewest_to_show_at_least(self, q: f64) -> usize {
        let mut most = 1;
        while !self.shows_at_least(most, most, q) {
            most *= 2;
        }
        let (mut less, mut enough) = (most / 2, most);
        while enough - less > 1 {
            let middle = less + (enough - less) / 2;
            *if self.shows_at_least(middle, middle, q) { &mut enough } else { &mut less } = middle;
        }
        enough
    }

    /// The least number of trials of which none succeeds that shows a probability of at most `q`.
    pub fn fewest_to_show_at_most(self, q: f64) -> usize {
        self.fewest_to_show_at_least(1.0 - q)
    }
}

/// `ln M` of `k` successes in `n` trials against `p <= q`.
pub fn ln_mean_above(n: usize, k: usize, q: f64) -> f64 {
    math::ln(lower_tail(n + 1, k, q)) - ln_probability(n, k, q) - math::ln((1.0 - q) * (n + 1) as f64)
}

/// `ln M` of `k` successes in `n` trials against `p >= q`.
pub fn ln_mean_below(n: usize, k: usize, q: f64) -> f64 {
    math::ln(upper_tail(n + 1, k + 1, q)) - ln_probability(n, k, q) - math::ln(q * (n + 1) as f64)
}

/// The value nearest to `outside` for which `holds`, between `inside`, where it holds in the limit,
/// and `outside`.
fn bisect(inside: f64, outside: f64, holds: impl Fn(f64) -> bool) -> f64 {
    let (mut inside, mut outside) = (inside, outside);
    loop {
        let middle = 0.5 * (inside + outside);
        if middle == inside || middle == outside || (outside - inside).abs() <= 1e-16 * outside.abs() {
            return inside;
        }
        *if holds(middle) { &mut inside } else { &mut outside } = middle;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIXED: ShareTest = ShareTest { rule: Rule::Fixed, alpha: 0.05 };
    const SEQUENTIAL: ShareTest = ShareTest { rule: Rule::Sequential, alpha: 0.05 };

    #[test]
    fn bounds_have_their_closed_forms_at_the_ends() {
        for n in [1_usize, 2, 29, 200, 100_000] {
            // All succeed: P(X >= n) = q^n = alpha.
            let closed = 0.05_f64.powf(1.0 / n as f64);
            // Bisection to the last digits; the complement of the upper bound is absolute.
            assert!((FIXED.lower_bound(n, n) / closed - 1.0).abs() < 1e-14, "{n}");
            assert!((FIXED.upper_bound(n, 0) - (1.0 - closed)).abs() < 1e-15, "{n}");
            assert_eq!((FIXED.lower_bound(n, 0), FIXED.upper_bound(n, n)), (0.0, 1.0));
        }
    }

    #[test]
    fn without_failures_the_sequential_mean_has_a_closed_form() {
        // M = (1 - q^(n + 1)) / ((n + 1) (1 - q) q^n).
        for q in [0.5_f64, 0.9, 0.99] {
            let mean = |n: i32| (1.0 - q.powi(n + 1)) / (f64::from(n + 1) * (1.0 - q) * q.powi(n));
            for n in 1..600 {
                assert_eq!(SEQUENTIAL.shows_at_least(n, n, q), mean(n as i32) >= 20.0, "{q} {n}");
                assert_eq!(SEQUENTIAL.shows_at_most(n, 0, 1.0 - q), mean(n as i32) >= 20.0, "{q} {n}");
            }
        }
    }

    #[test]
    fn tests_agree_with_their_bounds() {
        for test in [FIXED, SEQUENTIAL] {
            for n in [1, 7, 60] {
                for k in 0..=n {
                    let (low, high) = (test.lower_bound(n, k), test.upper_bound(n, k));
                    assert!(low <= k as f64 / n as f64 && k as f64 / n as f64 <= high, "{n} {k}: {low} {high}");
                    // A grid that no bound hits.
                    for q in (0..200).map(|i| (f64::from(i) + 0.4142) / 200.0) {
                        assert_eq!(test.shows_at_least(n, k, q), q <= low, "{test:?} {n} {k} {q}");
                        assert_eq!(test.shows_at_most(n, k, q), q >= high, "{test:?} {n} {k} {q}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_fewest_trials_are_those_of_the_closed_form() {
        // 0.99^298 = 0.0500, just above; 0.99^299 = 0.0495.
        assert_eq!(FIXED.fewest_to_show_at_least(0.99), 299);
        assert_eq!(FIXED.fewest_to_show_at_most(0.01), 299);
        assert_eq!(FIXED.fewest_to_show_at_least(0.95), 59);
        assert_eq!(FIXED.fewest_to_show_at_least(0.04), 1);
        assert_eq!(SEQUENTIAL.fewest_to_show_at_least(0.9), 43);
    }
}
