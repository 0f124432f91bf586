//! Test of a trend by ranks [Mann 1945], [Kendall 1938].
//!
//! ```text
//! S = sum over i < j of sign(x_j - x_i) = T - 2 d
//! ```
//!
//! with `T` pairs of different values, `d` of which fall. If all orders of the values are equally
//! likely, `d` is distributed as the inversions of a multiset, whose generating function is a product
//! of Gaussian binomials: values that join `b` others `a` times are inverted `k` times with the
//! probability [Mann 1947]
//!
//! ```text
//! p(a, b, k) = a / (a + b) p(a - 1, b, k - b) + b / (a + b) p(a, b - 1, k)
//! ```
//!
//! So the test is exact for any number of values, and of equal ones. All terms are positive: nothing
//! cancels.

/// Result of the test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RankTrend {
    /// Rising pairs less falling pairs.
    pub s: i64,
    /// Two-sided: probability of an `S` of this size or greater in a random order.
    pub p: f64,
}

/// Tests values in the order of time. Equal values form pairs that neither rise nor fall. None if a
/// value is NaN.
pub fn rank_trend(values: &[f64]) -> Option<RankTrend> {
    if values.iter().any(|value| value.is_nan()) {
        return None;
    }
    let (mut rising, mut falling) = (0_usize, 0_usize);
    for (i, first) in values.iter().enumerate() {
        for second in &values[i + 1..] {
            rising += usize::from(second > first);
            falling += usize::from(second < first);
        }
    }
    let tail: f64 = inversions(&multiplicities(values)).iter().take(rising.min(falling) + 1).sum();
    // The distribution is symmetric. At S = 0 both tails include its middle.
    let p = if rising == falling { 1.0 } else { (2.0 * tail).min(1.0) };
    Some(RankTrend { s: rising as i64 - falling as i64, p })
}

/// How often each distinct value occurs.
fn multiplicities(values: &[f64]) -> Vec<usize> {
    let mut sorted = values.to_vec();
    sorted.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    sorted.chunk_by(|a, b| a == b).map(<[f64]>::len).collect()
}

/// Probabilities of 0, 1, ... inversions in a random order of a multiset with these multiplicities.
fn inversions(multiplicities: &[usize]) -> Vec<f64> {
    let (mut all, mut joined) = (vec![1.0], 0);
    for &own in multiplicities {
        all = convolved(&all, &binomial(own, joined));
        joined += own;
    }
    all
}

/// Probabilities of 0 to `a b` inversions between `a` equal values and `b` other equal ones.
fn binomial(a: usize, b: usize) -> Vec<f64> {
    // Row `i` of the recursion, for all numbers of others.
    let mut row: Vec<Vec<f64>> = vec![vec![1.0]; b + 1];
    for i in 1..=a {
        for j in 1..=b {
            let (own, other) = (i as f64 / (i + j) as f64, j as f64 / (i + j) as f64);
            let mut next = vec![0.0; i * j + 1];
            row[j].iter().enumerate().for_each(|(k, p)| next[k + j] += own * p);
            row[j - 1].iter().enumerate().for_each(|(k, p)| next[k] += other * p);
            row[j] = next;
        }
    }
    row.pop().unwrap_or_default()
}

fn convolved(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; a.len() + b.len() - 1];
    for (i, x) in a.iter().enumerate() {
        for (j, y) in b.iter().enumerate() {
            sum[i + j] += x * y;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All orders of some values.
    fn orders(values: &[f64]) -> Vec<Vec<f64>> {
        if values.is_empty() {
            return vec![Vec::new()];
        }
        let mut all = Vec::new();
        for i in 0..values.len() {
            let mut rest = values.to_vec();
            let first = rest.remove(i);
            all.extend(orders(&rest).into_iter().map(|order| [vec![first], order].concat()));
        }
        all
    }

    #[test]
    fn probabilities_are_those_of_all_orders() {
        let sets: [&[f64]; 8] = [
            &[1.0],
            &[1.0, 2.0],
            &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0],
            &[1.0, 1.0, 2.0, 3.0, 3.0, 3.0],
            &[0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
            &[-0.0, 0.0, 1.0, 1.0],
            &[f64::NEG_INFINITY, 0.0, f64::INFINITY, f64::INFINITY],
            &[5.0, 5.0, 5.0],
        ];
        for values in sets {
            let all = orders(values);
            let sizes: Vec<i64> = all.iter().map(|order| rank_trend(order).unwrap().s.abs()).collect();
            for order in &all {
                let found = rank_trend(order).unwrap();
                let as_great = sizes.iter().filter(|size| **size >= found.s.abs()).count();
                // Rounding of some dozens of terms.
                assert!((found.p - as_great as f64 / all.len() as f64).abs() < 1e-14, "{order:?}: {found:?}");
            }
        }
    }

    #[test]
    fn monotone_values_have_the_closed_form() {
        let mut factorial = 1.0;
        for n in 1..=20_usize {
            factorial *= n as f64;
            let values: Vec<f64> = (0..n).map(|i| i as f64).collect();
            let falling: Vec<f64> = values.iter().rev().copied().collect();
            let expected = f64::min(2.0 / factorial, 1.0);
            for (values, sign) in [(values, 1), (falling, -1)] {
                let found = rank_trend(&values).unwrap();
                assert_eq!(found.s, sign * (n * (n - 1) / 2) as i64);
                // Rounding of a product of `n` factors.
                assert!((found.p / expected - 1.0).abs() < 1e-14, "{n}: {found:?}");
            }
        }
        assert_eq!(rank_trend(&[1.0, f64::NAN]), None);
        assert_eq!(rank_trend(&[]), Some(RankTrend { s: 0, p: 1.0 }));
    }
}
