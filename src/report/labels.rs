//! Labels of the page: short numbers and names of runs.

use crate::math;
use crate::results::{SummaryRow, is_truth};

/// A number to three digits, with an exponent where that is shorter. The summary has all digits.
pub(super) fn short(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 {
        // Positive and negative zero.
        "0".to_owned()
    } else if !x.is_finite() || !(1e-3..1e5).contains(&size) {
        format!("{x:.2e}")
    } else {
        let decimals = (2 - math::log10(size).floor() as i32).max(0) as usize;
        let text = format!("{x:.decimals$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    }
}

/// Swept values of a run, `name=value`, without truths and those with their own columns.
pub(super) fn parameters(row: &SummaryRow) -> Vec<String> {
    let own = |name: &str| ["contact.method", "integrator.method"].contains(&name) || is_truth(name);
    let named = row.parameters.iter().filter(|(name, _)| !own(name));
    named.map(|(name, value)| format!("{name}={}", value.brief())).collect()
}

/// Scenario, method, integrator and swept values of a run.
pub(super) fn name(row: &SummaryRow) -> String {
    format!("{} {}", row.scenario, method_and_parameters(row))
}

/// Method, integrator and swept values of a run.
pub(super) fn method_and_parameters(row: &SummaryRow) -> String {
    [row.method.clone(), row.integrator.clone()].into_iter().chain(parameters(row)).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        let numbers = [0.0, -0.0, 1.0, 0.25, 1234.5, 99_999.0, 1e5, 9.81, -0.001234, 1e-4, f64::NAN, f64::INFINITY];
        let texts = numbers.map(short);
        let expected = ["0", "0", "1", "0.25", "1234", "99999", "1.00e5", "9.81", "-0.00123", "1.00e-4", "NaN", "inf"];
        assert_eq!(texts, expected);
    }
}
