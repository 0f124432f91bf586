//! Tails and quantiles of continuous distributions against SciPy (`make_distributions.py`).

use serde::Deserialize;
use stiction::statistics::{chi_square_tail, f_tail, normal_quantile, student_quantile};

#[derive(Deserialize)]
struct Oracle {
    /// Confidence, degrees of freedom, quantile of |T|.
    student: Vec<(f64, f64, f64)>,
    /// Confidence, quantile of |X|.
    normal: Vec<(f64, f64)>,
    /// x, degrees of freedom, P(X > x).
    chi_square: Vec<(f64, f64, f64)>,
    /// x, degrees of freedom above and below, P(X > x).
    f: Vec<(f64, f64, f64, f64)>,
}

#[test]
fn quantiles_and_tails_are_those_of_scipy() {
    let oracle: Oracle = serde_json::from_str(include_str!("distributions.json")).unwrap();
    let near = |ours: f64, theirs: f64, what: &dyn std::fmt::Debug| {
        // Logarithms of gamma functions of 5e5, some 6e6, rounded to 53 bits.
        assert!((ours / theirs - 1.0).abs() < 1e-8, "{what:?}: {ours:e} and {theirs:e}");
    };
    assert!(oracle.student.len() == 45 && oracle.chi_square.len() > 40 && oracle.f.len() > 30);
    oracle.student.iter().for_each(|row| near(student_quantile(row.0, row.1), row.2, row));
    oracle.normal.iter().for_each(|row| near(normal_quantile(row.0), row.1, row));
    oracle.chi_square.iter().for_each(|row| near(chi_square_tail(row.0, row.1), row.2, row));
    oracle.f.iter().for_each(|row| near(f_tail(row.0, row.1, row.2), row.3, row));
}
