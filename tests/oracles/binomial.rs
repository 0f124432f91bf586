//! Binomial tails, bounds and likelihood ratios against SciPy and mpmath (`make_binomial.py`).

use serde::Deserialize;
use stiction::statistics::{Rule, ShareTest, ln_mean_above, ln_mean_below, lower_tail, upper_tail};

#[derive(Deserialize)]
struct Oracle {
    /// n, k, p, P(X >= k), P(X <= k).
    tails: Vec<(usize, usize, f64, f64, f64)>,
    /// n, k, confidence, lower bound, upper bound.
    bounds: Vec<(usize, usize, f64, f64, f64)>,
    /// n, k, q, and the logarithms of the means above and below q.
    means: Vec<(usize, usize, f64, f64, f64)>,
}

fn oracle() -> Oracle {
    serde_json::from_str(include_str!("binomial.json")).unwrap()
}

#[test]
fn tails_are_those_of_rational_arithmetic() {
    for (n, k, p, upper, lower) in oracle().tails {
        for (ours, exact) in [(upper_tail(n, k, p), upper), (lower_tail(n, k, p), lower)] {
            // Rounding of up to some thousand terms and of the logarithm of the first.
            assert!((ours / exact - 1.0).abs() < 1e-12, "{n} {k} {p}: {ours} and {exact}");
        }
    }
}

#[test]
fn bounds_are_those_of_scipy() {
    for (n, k, confidence, lower, upper) in oracle().bounds {
        let test = ShareTest { rule: Rule::Fixed, alpha: 1.0 - confidence };
        for (ours, theirs) in [(test.lower_bound(n, k), lower), (test.upper_bound(n, k), upper)] {
            // SciPy's search for a root ends within 2e-12.
            assert!((ours - theirs).abs() < 4e-12, "{n} {k} {confidence}: {ours} and {theirs}");
        }
    }
}

#[test]
fn means_of_likelihood_ratios_are_the_integrals() {
    for (n, k, q, above, below) in oracle().means {
        for (ours, integral) in [(ln_mean_above(n, k, q), above), (ln_mean_below(n, k, q), below)] {
            // Logarithms of size up to 16, of numbers with some 1e-13.
            assert!((ours - integral).abs() < 1e-11, "{n} {k} {q}: {ours} and {integral}");
        }
    }
}
