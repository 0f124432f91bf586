//! Tails and quantiles of the distributions of least squares: normal, Student, chi-square and F.
//!
//! ```text
//! normal       P(X > x)    = erfc(x / sqrt 2) / 2
//! Student      P(|T| > t)  = I(n / (n + t^2); n / 2, 1 / 2)
//! chi-square   P(X > x)    = Q(n / 2, x / 2)
//! F            P(X > x)    = I(b / (b + a x); b / 2, a / 2)
//! ```
//!
//! `I` is the regularized incomplete beta function, by its continued fraction [Abramowitz 1964, 26.5.8]
//! on the side where it converges fast; `Q` the regularized upper incomplete gamma function, by
//! the series 6.5.29 below its mean and the continued fraction 6.5.31 above. Relative errors are
//! below 1e-10 for up to a million degrees of freedom; they come from the logarithms of large gamma
//! functions (`tests/oracles/make_distributions.py`).

use crate::math;

/// Changes below this fraction end a series or a continued fraction.
const NEGLIGIBLE: f64 = 4e-16;

/// Terms after which a series or a continued fraction ends; they grow as the root of the degrees of
/// freedom.
const MAX_TERMS: usize = 100_000;

/// The `t` with `P(|X| <= t) = confidence` of a standard normal `X`.
pub fn normal_quantile(confidence: f64) -> f64 {
    quantile(confidence, |t| math::erfc(t / std::f64::consts::SQRT_2))
}

/// The `t` with `P(|X| <= t) = confidence` of Student's distribution with `freedom` degrees of freedom.
pub fn student_quantile(confidence: f64, freedom: f64) -> f64 {
    quantile(confidence, |t| incomplete_beta(freedom / (freedom + t * t), 0.5 * freedom, 0.5))
}

/// `P(X > x)` of a chi-square distribution.
pub fn chi_square_tail(x: f64, freedom: f64) -> f64 {
    upper_gamma(0.5 * freedom, 0.5 * x.max(0.0))
}

/// `P(X > x)` of an F distribution with `above` degrees of freedom in the numerator and `below` in
/// the denominator.
pub fn f_tail(x: f64, above: f64, below: f64) -> f64 {
    if x <= 0.0 { 1.0 } else { incomplete_beta(below / (below + above * x), 0.5 * below, 0.5 * above) }
}

/// The `t` at which a falling two-sided tail is `1 - confidence`.
fn quantile(confidence: f64, tail: impl Fn(f64) -> f64) -> f64 {
    let alpha = 1.0 - confidence;
    let mut high = 1.0;
    while tail(high) > alpha && high < 1e300 {
        high *= 2.0;
    }
    let mut low = 0.0;
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return middle;
        }
        *if tail(middle) > alpha { &mut low } else { &mut high } = middle;
    }
}

/// `I(x; a, b)`.
fn incomplete_beta(x: f64, a: f64, b: f64) -> f64 {
    if !(x > 0.0) {
        return 0.0;
    }
    if x >= 1.0 {
        return 1.0;
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(1.0 - x, b, a);
    }
    let ln_beta = math::ln_gamma(a) + math::ln_gamma(b) - math::ln_gamma(a + b);
    let front = math::exp(a * math::ln(x) + b * math::ln(1.0 - x) - ln_beta) / a;
    front
        / fraction(1.0, |m| {
            let k = (m / 2) as f64;
            let numerator = if m % 2 == 0 {
                k * (b - k) * x / ((a + 2.0 * k - 1.0) * (a + 2.0 * k))
            } else {
                -(a + k) * (a + b + k) * x / ((a + 2.0 * k) * (a + 2.0 * k + 1.0))
            };
            (numerator, 1.0)
        })
}

/// `Q(a, x)`.
fn upper_gamma(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    let front = math::exp(a * math::ln(x) - x - math::ln_gamma(a));
    if x < a + 1.0 {
        let (mut term, mut sum) = (1.0 / a, 1.0 / a);
        for k in 1..MAX_TERMS {
            term *= x / (a + k as f64);
            sum += term;
            if term <= sum * NEGLIGIBLE {
                break;
            }
        }
        return (1.0 - front * sum).max(0.0);
    }
    front
        / fraction(x + 1.0 - a, |m| {
            let k = m as f64;
            (k * (a - k), x + 2.0 * k + 1.0 - a)
        })
}

/// `b0 + a1 / (b1 + a2 / (b2 + ...))` by the method of Lentz; `part` gives `(a, b)` of each index
/// from 1.
fn fraction(first: f64, part: impl Fn(usize) -> (f64, f64)) -> f64 {
    const TINY: f64 = 1e-300;
    let nonzero = |x: f64| if x.abs() < TINY { TINY } else { x };
    let mut value = nonzero(first);
    let (mut c, mut d) = (value, 0.0);
    for m in 1..MAX_TERMS {
        let (a, b) = part(m);
        d = 1.0 / nonzero(b + a * d);
        c = nonzero(b + a / c);
        let change = c * d;
        value *= change;
        if (change - 1.0).abs() <= NEGLIGIBLE {
            break;
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_and_two_degrees_of_freedom_have_closed_forms() {
        // Cauchy: P(|T| > t) = 1 - 2 atan(t) / pi. Exponential: P(X > x) = exp(-x / 2).
        for confidence in [0.5, 0.9, 0.95, 0.999] {
            let exact = (std::f64::consts::FRAC_PI_2 * confidence).tan();
            // Rounding of 1 - confidence.
            assert!((student_quantile(confidence, 1.0) / exact - 1.0).abs() < 1e-12, "{confidence}");
            // With two degrees of freedom t^2 = 2 c^2 / (1 - c^2).
            let exact = (2.0 * confidence * confidence / (1.0 - confidence * confidence)).sqrt();
            assert!((student_quantile(confidence, 2.0) / exact - 1.0).abs() < 1e-12, "{confidence}");
        }
        for x in [0.1, 1.0, 3.0, 20.0] {
            // Rounding.
            assert!((chi_square_tail(x, 2.0) / (-0.5_f64 * x).exp() - 1.0).abs() < 1e-13, "{x}");
            assert!((f_tail(x, 2.0, 6.0) / (1.0 + x / 3.0_f64).powi(-3) - 1.0).abs() < 1e-13, "{x}");
        }
        assert_eq!((chi_square_tail(0.0, 3.0), f_tail(0.0, 3.0, 4.0)), (1.0, 1.0));
    }
}
