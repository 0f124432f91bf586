//! The rank test of a trend against SciPy and counted orders (`make_trend.py`).

use stiction::statistics::rank_trend;

#[test]
fn probabilities_are_those_of_scipy_and_of_counted_orders() {
    let cases: Vec<(Vec<f64>, f64)> = serde_json::from_str(include_str!("trend.json")).unwrap();
    assert_eq!(cases.len(), 64);
    for (values, expected) in cases {
        let found = rank_trend(&values).unwrap();
        // Rounding of products and sums of up to 60 values, here and in SciPy's sums of whole numbers.
        assert!((found.p / expected - 1.0).abs() < 1e-12, "{values:?}: {found:?}, not {expected}");
    }
}
