//! The values of a swept key. Decimal grids give decimal numbers, and both ends are exact.

use crate::math;
use crate::scenario::format::sweep::Axis;
use crate::text::source::Span;
use crate::text::toml_tree::{Node, Value};

/// The number of values of an axis, without generating them.
pub fn count(axis: &Axis) -> usize {
    match axis {
        Axis::Values(values) => values.len(),
        Axis::Linspace(_, _, n) | Axis::Logspace(_, _, n) => *n as usize,
        Axis::Step(a, b, s) => {
            // Rounding of (b - a) / s must not lose the last value; no intended grid is as fine as
            // 1e-9 of a step.
            let steps = ((b - a) / s + 1e-9).floor();
            if steps < 1e15 { steps as usize + 1 } else { usize::MAX }
        }
    }
}

/// The values of an axis that is written as `node`, in order. A listed value keeps its own span;
/// the others have that of the axis.
pub fn values(axis: &Axis, node: &Node) -> Vec<Node> {
    match axis {
        Axis::Values(_) => unify_numbers(node.items().to_vec()),
        Axis::Linspace(a, b, n) => typed(linspace(*a, *b, *n as usize), "linspace", node),
        Axis::Logspace(a, b, n) => typed(logspace(*a, *b, *n as usize), "logspace", node),
        Axis::Step(a, _, s) if has_whole_numbers(node, "step") => {
            (0..count(axis)).map(|i| whole(*a as i64 + i as i64 * *s as i64, &node.span)).collect()
        }
        Axis::Step(a, b, s) => floats(steps(*a, *b, *s, count(axis)), &node.span),
    }
}

fn whole(number: i64, span: &Span) -> Node {
    Node::computed(Value::Integer(number), span)
}

fn floats(numbers: Vec<f64>, span: &Span) -> Vec<Node> {
    numbers.into_iter().map(|x| Node::computed(Value::Float(x), span)).collect()
}

/// Whole numbers if the ends are written as whole numbers and all values between are whole.
fn typed(numbers: Vec<f64>, form: &str, node: &Node) -> Vec<Node> {
    if has_whole_numbers(node, form) && numbers.iter().all(|x| x.fract() == 0.0) {
        return numbers.into_iter().map(|x| whole(x as i64, &node.span)).collect();
    }
    floats(numbers, &node.span)
}

/// True when all numbers of the axis are written as whole numbers that are exact in f64.
fn has_whole_numbers(node: &Node, form: &str) -> bool {
    let is_whole = |i: &Node| matches!(i.value, Value::Integer(x) if x.abs() < 1 << 53);
    node.get(form).is_some_and(|node| node.items().iter().all(is_whole))
}

/// Converts all numbers of a list to floats if one of them is a float, so that a column of results
/// has one type.
pub fn unify_numbers(items: Vec<Node>) -> Vec<Node> {
    unify_numbers_with_gaps(items.into_iter().map(Some).collect()).into_iter().flatten().collect()
}

/// As [`unify_numbers`], for a list with gaps.
pub fn unify_numbers_with_gaps(mut items: Vec<Option<Node>>) -> Vec<Option<Node>> {
    if items.iter().flatten().any(|i| matches!(i.value, Value::Float(_))) {
        for item in items.iter_mut().flatten() {
            if let Value::Integer(number) = item.value {
                item.value = Value::Float(number as f64);
            }
        }
    }
    items
}

fn linspace(a: f64, b: f64, n: usize) -> Vec<f64> {
    let last = (n - 1) as f64;
    let inner = |i: usize| {
        let t = i as f64 / last;
        decimal(a * (1.0 - t) + b * t, a.abs().max(b.abs()))
    };
    ends(a, b, n, inner)
}

fn logspace(a: f64, b: f64, n: usize) -> Vec<f64> {
    let (low, high, last) = (math::log10(a.abs()), math::log10(b.abs()), (n - 1) as f64);
    let inner = |i: usize| {
        let t = i as f64 / last;
        let size = math::powf(10.0, low * (1.0 - t) + high * t);
        decimal(size.copysign(a), size)
    };
    ends(a, b, n, inner)
}

fn steps(a: f64, b: f64, s: f64, n: usize) -> Vec<f64> {
    let scale = a.abs().max(b.abs());
    (0..n).map(|i| if i == 0 { a } else { decimal(a + i as f64 * s, scale) }).collect()
}

fn ends(a: f64, b: f64, n: usize, inner: impl Fn(usize) -> f64) -> Vec<f64> {
    (0..n)
        .map(|i| match i {
            0 => a,
            i if i == n - 1 => b,
            i => inner(i),
        })
        .collect()
}

/// The number with 14 significant decimal digits relative to `scale`: exact when both ends are
/// decimal, and closer than any simulation resolves otherwise.
pub fn decimal(x: f64, scale: f64) -> f64 {
    if scale == 0.0 {
        return 0.0;
    }
    let digits = 13 - math::log10(scale).floor() as i64;
    let rounded = format!("{x:.*}", digits.clamp(0, 330) as usize).parse().unwrap_or(x);
    // No negative zero.
    rounded + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_grids_stay_decimal() {
        assert_eq!(linspace(0.0, 1.0, 11), [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0]);
        assert_eq!(linspace(-0.3, 0.3, 3), [-0.3, 0.0, 0.3]);
        assert_eq!(logspace(1e-6, 1e-2, 5), [1e-6, 1e-5, 1e-4, 1e-3, 1e-2]);
        assert_eq!(logspace(-100.0, -1.0, 3), [-100.0, -10.0, -1.0]);
        assert_eq!(steps(0.1, 0.7, 0.1, 7), [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]);
        assert_eq!(steps(1.0, -1.0, -0.5, 5), [1.0, 0.5, 0.0, -0.5, -1.0]);
        assert!(linspace(-0.3, 0.3, 3)[1].is_sign_positive());
    }

    #[test]
    fn the_last_step_is_not_lost_to_rounding() {
        // In f64, (0.7 - 0.1) / 0.1 is 5.999999999999999.
        assert_eq!(count(&Axis::Step(0.1, 0.7, 0.1)), 7);
        assert_eq!(count(&Axis::Step(0.0, 1.0, 0.3)), 4);
        assert_eq!(count(&Axis::Step(2.0, 2.0, 0.5)), 1);
        assert_eq!(count(&Axis::Step(0.0, 1.0, 1e-300)), usize::MAX);
    }

    #[test]
    fn ends_that_are_not_decimal_are_hit_exactly() {
        let values = linspace(0.0, std::f64::consts::PI, 4);
        assert_eq!(values[3], std::f64::consts::PI);
        // Rounding to 14 digits of a number of size 1.
        assert!((values[1] - std::f64::consts::FRAC_PI_3).abs() < 1e-13);
    }
}
