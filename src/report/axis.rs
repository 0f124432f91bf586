//! Axes: range, labelled values, and position of a value.

use crate::math;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use std::ops::Range;

/// A range with its ticks.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    pub from: f64,
    pub to: f64,
    /// Labelled values.
    pub ticks: Vec<f64>,
    /// Values of fine lines between the labels.
    pub fine: Vec<f64>,
    /// True for a logarithmic scale, false for a linear one.
    pub logarithmic: bool,
}

impl Ranged for Axis {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let scaled = |v: f64| if self.logarithmic { math::log10(v) } else { v };
        // Halves, since the difference of two numbers may overflow.
        let (from, to, value) = (scaled(self.from) / 2.0, scaled(self.to) / 2.0, scaled(*value) / 2.0);
        let share = (value - from) / (to - from);
        limit.0 + (share * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { self.fine.clone() } else { self.ticks.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.from..self.to
    }
}

impl Axis {
    /// The label of a tick.
    pub fn label(&self, value: f64) -> String {
        if self.logarithmic { logarithmic_label(value) } else { linear_label(value, self) }
    }
}

/// Limit of drawn values, and inverse of the lower limit. It leaves room to the ends of double
/// precision.
const HUGE: f64 = 1e250;

/// Decades with fine lines between them.
const FEW_DECADES: i32 = 6;
/// Decades with a fine line each.
const MANY_DECADES: i32 = 40;
/// Largest number of labels of an axis.
const MAX_LABELS: i32 = 8;

/// A logarithmic axis around positive values; at least a decade.
pub(super) fn logarithmic(values: impl Iterator<Item = f64>) -> Axis {
    let logs = values.map(|v| math::log10(clamped(v)));
    let (low, high) = logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let (low, high) = if low <= high { (low, high) } else { (-1.0, 0.0) };
    let room = (0.06 * (high - low)).max(0.5 * (1.0 - (high - low))).max(0.08);
    let (low, high) = (low - room, high + room);
    let (first, last) = (low.ceil() as i32, high.floor() as i32);
    let decades: Vec<i32> = (first..=last).collect();
    let mantissas = |of: &[f64]| -> Vec<f64> {
        let all = (first - 1..=last).flat_map(|d| of.iter().map(move |m| m * power(d)));
        all.filter(|v| (low..=high).contains(&math::log10(*v))).collect()
    };
    let stride = (last - first) / MAX_LABELS + 1;
    let (ticks, fine) = match decades.len() {
        // Fewer than two labels at powers of ten.
        0..=2 => (mantissas(&[1.0, 2.0, 5.0]), mantissas(&[3.0, 4.0, 6.0, 7.0, 8.0, 9.0])),
        _ => {
            let labelled = decades.iter().filter(|d| *d % stride == 0).map(|d| power(*d)).collect();
            let fine = match last - first {
                0..=FEW_DECADES => mantissas(&[2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]),
                ..=MANY_DECADES => decades.iter().filter(|d| *d % stride != 0).map(|d| power(*d)).collect(),
                _ => Vec::new(),
            };
            (labelled, fine)
        }
    };
    Axis { from: math::powf(10.0, low), to: math::powf(10.0, high), ticks, fine, logarithmic: true }
}

/// A size that a logarithmic axis can show.
pub(super) fn clamped(size: f64) -> f64 {
    size.clamp(HUGE.recip(), HUGE)
}

/// `10^n`, correctly rounded.
fn power(n: i32) -> f64 {
    format!("1e{n}").parse().unwrap_or(f64::NAN)
}

/// `10⁻³`, `5·10⁻³`; plain near one.
fn logarithmic_label(value: f64) -> String {
    if (0.1..100.0).contains(&value) {
        return format!("{value}");
    }
    let exponent = (math::log10(value) + 1e-9).floor() as i32;
    let mantissa = (value / power(exponent)).round();
    let raised: String = exponent.to_string().chars().map(superscript).collect();
    if mantissa == 1.0 { format!("10{raised}") } else { format!("{mantissa}·10{raised}") }
}

fn superscript(c: char) -> char {
    match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '0' | '4'..='9' => char::from_u32('⁰' as u32 + (c as u32 - '0' as u32)).unwrap_or(c),
        other => other,
    }
}

/// A linear axis around values, with about `labels` labels; no narrower than `least`.
pub(super) fn linear(values: impl Iterator<Item = f64>, labels: u32, least: f64) -> Axis {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
    // Halves, since the difference of two numbers may overflow.
    let middle = low / 2.0 + high / 2.0;
    let half = (high / 2.0 - low / 2.0).max(least / 2.0).max(middle.abs() * 1e-9).max(f64::MIN_POSITIVE);
    let (from, to) = (middle - 1.06 * half, middle + 1.06 * half);
    let step = step(2.0 * (half / f64::from(labels)));
    let first = (from / step).ceil();
    let ticks = (0..4 * labels).map(|i| (first + f64::from(i)) * step).take_while(|v| *v <= to).collect();
    Axis { from, to, ticks, fine: Vec::new(), logarithmic: false }
}

/// 1, 2 or 5 times a power of ten, near `about`.
fn step(about: f64) -> f64 {
    let decade = math::powf(10.0, math::log10(about).floor());
    let times = [1.0, 2.0, 5.0].into_iter().find(|m| m * decade >= 0.99 * about).unwrap_or(10.0);
    times * decade
}

/// A tick of a linear axis, with the decimals that its neighbours need.
fn linear_label(value: f64, axis: &Axis) -> String {
    let step = match axis.ticks.as_slice() {
        [a, b, ..] => b - a,
        _ => 1.0,
    };
    let largest = axis.from.abs().max(axis.to.abs());
    if !(1e-4..1e6).contains(&largest) {
        return if value.abs() < step / 2.0 { "0".to_owned() } else { format!("{value:.1e}") };
    }
    let decimals = (-math::log10(step) + 0.01).ceil().clamp(0.0, 9.0) as usize;
    // No minus before a zero.
    let value = if value.abs() < step / 2.0 { 0.0 } else { value };
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decades_are_labelled_and_contain_all_values() {
        let axis = logarithmic([3e-9, 2e-4].into_iter());
        assert!(axis.from < 3e-9 && axis.to > 2e-4);
        assert_eq!(axis.ticks, [1e-8, 1e-7, 1e-6, 1e-5, 1e-4]);
        assert!(axis.fine.contains(&5e-7), "{:?}", axis.fine);
        // Hardly any span, one value, none, and the ends of double precision.
        for values in [vec![0.011, 0.012], vec![3.0], vec![], vec![5e-324, f64::MAX], vec![1e-5, 1e5]] {
            let axis = logarithmic(values.iter().copied());
            assert!(axis.from > 0.0 && axis.to.is_finite() && axis.to / axis.from >= 9.9, "{values:?}: {axis:?}");
            assert!((2..=11).contains(&axis.ticks.len()), "{values:?}: {:?}", axis.ticks);
            assert!(axis.ticks.iter().chain(&axis.fine).all(|t| (axis.from..=axis.to).contains(t)), "{axis:?}");
        }
    }

    #[test]
    fn logarithmic_labels_are_powers() {
        let labels = [1e-12, 2e-3, 0.5, 1.0, 20.0, 100.0, 5e17].map(logarithmic_label);
        assert_eq!(labels, ["10⁻¹²", "2·10⁻³", "0.5", "1", "20", "10²", "5·10¹⁷"]);
    }

    #[test]
    fn linear_ticks_are_round() {
        let labels = |values: &[f64]| -> Vec<String> {
            let axis = linear(values.iter().copied(), 4, 1e-3);
            assert!(values.iter().all(|v| (axis.from..=axis.to).contains(v)), "{values:?}: {axis:?}");
            axis.ticks.iter().map(|v| axis.label(*v)).collect()
        };
        assert_eq!(labels(&[0.0, 5.0]), ["0", "2", "4"]);
        assert_eq!(labels(&[-0.3, 0.3]), ["-0.2", "0.0", "0.2"]);
        assert_eq!(labels(&[0.28, 0.28]), ["0.2795", "0.2800", "0.2805"]);
        assert_eq!(labels(&[]), ["0.0", "0.5", "1.0"]);
        assert!(labels(&[-f64::MAX, f64::MAX]).len() >= 2);
        assert!(labels(&[1e9, 1e9]).len() >= 2, "the span of a large value is that of its digits");
    }
}
