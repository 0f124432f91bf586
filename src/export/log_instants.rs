//! Chooses the instants of an export and interpolates between the ticks of the log.
//!
//! Numbers are interpolated linearly, the orientation on the shortest arc; roll, pitch and yaw are
//! those of the result. States and flags are those of the tick before, and so is the centre of
//! pressure up to a lift-off.

use crate::export::export_error::ExportError;
use crate::export::selection::{MAX_ROWS, Selection};
use nalgebra::UnitQuaternion;

/// Fraction of a row period within which an instant counts as a tick, for the rounding of `k /
/// rate`.
const TICK_TOLERANCE: f64 = 1e-6;

/// An instant between the ticks `before` and `after` of a log, or at `before` when `fraction` is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LogInstant {
    pub before: usize,
    pub after: usize,
    pub fraction: f64,
}

impl LogInstant {
    fn tick(at: usize) -> Self {
        Self { before: at, after: at, fraction: 0.0 }
    }

    /// Interpolates linearly from `a` to `b`; gives `a` itself at a tick.
    pub fn interpolate(self, a: f64, b: f64) -> f64 {
        if self.fraction == 0.0 { a } else { a + self.fraction * (b - a) }
    }

    /// Interpolates along the shortest arc from `a` to `b`; gives `a` itself at a tick.
    pub fn interpolate_orientation(self, a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
        if self.fraction == 0.0 {
            return *a;
        }
        // There is no shortest arc for half a turn, and none is needed between nearly equal
        // orientations.
        a.try_slerp(b, self.fraction, 1e-12).unwrap_or(*a)
    }
}

/// The instants of a selection, s, each with its position between ticks of the log.
pub(super) fn choose(ticks: &[f64], selection: &Selection) -> Result<(Vec<f64>, Vec<LogInstant>), ExportError> {
    let (Some(&first), Some(&last)) = (ticks.first(), ticks.last()) else { return Err(ExportError::NoSeries) };
    let (from, to) = (selection.from.unwrap_or(first), selection.to.unwrap_or(last));
    let chosen = match selection.rate {
        Some(rate) => at_rate(ticks, from, to, rate)?,
        None => {
            let inside = |(i, t): (usize, &f64)| (from..=to).contains(t).then_some((*t, LogInstant::tick(i)));
            ticks.iter().enumerate().filter_map(inside).collect()
        }
    };
    if chosen.is_empty() {
        return Err(ExportError::NoInstants { from, to, first, last });
    }
    Ok(chosen.into_iter().unzip())
}

/// The instants `from + k / rate`, k = 0, 1, ..., within the log.
fn at_rate(ticks: &[f64], from: f64, to: f64, rate: f64) -> Result<Vec<(f64, LogInstant)>, ExportError> {
    let (first, last) = (ticks[0], ticks[ticks.len() - 1]);
    let (tolerance, end) = (TICK_TOLERANCE / rate, to.min(last));
    let rows = ((end - from) * rate).floor() + 1.0;
    if rows > MAX_ROWS {
        return Err(ExportError::TooManyRows { rows, rate });
    }
    let mut chosen = Vec::new();
    for k in 0.. {
        let t = from + f64::from(k) / rate;
        if !(t <= end + tolerance) {
            break;
        }
        if t < first - tolerance {
            // Rows before the log are skipped, but only so many.
            if (first - from) * rate > MAX_ROWS {
                return Err(ExportError::TooManyRows { rows: (first - from) * rate, rate });
            }
            continue;
        }
        chosen.push((t, at(ticks, t, tolerance)));
    }
    Ok(chosen)
}

/// Finds the ticks around an instant; an instant within `tolerance` of a tick is that tick.
fn at(ticks: &[f64], t: f64, tolerance: f64) -> LogInstant {
    let after = ticks.partition_point(|tick| *tick <= t);
    if after < ticks.len() && ticks[after] - t <= tolerance {
        return LogInstant::tick(after);
    }
    let before = after.saturating_sub(1);
    if after == ticks.len() || t - ticks[before] <= tolerance {
        return LogInstant::tick(before);
    }
    LogInstant { before, after, fraction: (t - ticks[before]) / (ticks[after] - ticks[before]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rate(ticks: &[f64], from: Option<f64>, to: Option<f64>, rate: f64) -> Vec<(f64, LogInstant)> {
        let selection = Selection { rate: Some(rate), from, to, ..Selection::default() };
        let (times, samples) = choose(ticks, &selection).unwrap();
        times.into_iter().zip(samples).collect()
    }

    #[test]
    fn an_instant_within_rounding_of_a_tick_is_the_tick() {
        let ticks: Vec<f64> = (0..=1000).map(|k| f64::from(k) / 200.0).collect();
        for hz in [200.0, 100.0, 40.0, 1.0] {
            let chosen = rate(&ticks, None, None, hz);
            assert_eq!(chosen.len(), (5.0 * hz) as usize + 1);
            let every = (200.0 / hz) as usize;
            assert!(chosen.iter().enumerate().all(|(k, (_, s))| *s == LogInstant::tick(every * k)), "{hz}");
        }
        // Off by three decimals' rounding, the ends included.
        let shifted: Vec<f64> = ticks.iter().map(|t| t + 0.1).collect();
        let chosen = rate(&shifted, Some(0.3), Some(0.7), 200.0);
        assert_eq!((chosen.len(), chosen[0].1, chosen[80].1), (81, LogInstant::tick(40), LogInstant::tick(120)));
    }

    #[test]
    fn the_fraction_between_ticks_is_proportional_to_time() {
        let chosen = rate(&[0.0, 1.0, 3.0], None, None, 2.0);
        let fractions: Vec<_> = chosen.iter().map(|(t, s)| (*t, s.before, s.fraction)).collect();
        let expected =
            [(0.0, 0, 0.0), (0.5, 0, 0.5), (1.0, 1, 0.0), (1.5, 1, 0.25), (2.0, 1, 0.5), (2.5, 1, 0.75), (3.0, 2, 0.0)];
        assert_eq!(fractions, expected);
    }

    #[test]
    fn instants_outside_the_log_are_omitted() {
        let ticks = [1.0, 2.0, 3.0];
        let times = |from, to| rate(&ticks, from, to, 1.0).into_iter().map(|c| c.0).collect::<Vec<_>>();
        assert_eq!(times(Some(-1.5), None), [1.5, 2.5]);
        assert_eq!(times(None, Some(9.0)), [1.0, 2.0, 3.0]);
        let plain = Selection { from: Some(2.0), to: Some(2.5), ..Selection::default() };
        assert_eq!(choose(&ticks, &plain).unwrap().0, [2.0]);
        let nothing = Selection { from: Some(3.5), ..Selection::default() };
        assert!(matches!(choose(&ticks, &nothing), Err(ExportError::NoInstants { last: 3.0, .. })));
        let nothing = Selection { rate: Some(1.0), ..nothing };
        assert!(matches!(choose(&ticks, &nothing), Err(ExportError::NoInstants { .. })));
        let fast = Selection { rate: Some(1e12), ..Selection::default() };
        assert!(matches!(choose(&ticks, &fast), Err(ExportError::TooManyRows { .. })));
        let early = Selection { rate: Some(1.0), from: Some(-1e12), ..Selection::default() };
        assert!(matches!(choose(&ticks, &early), Err(ExportError::TooManyRows { .. })));
        assert!(matches!(choose(&[], &plain), Err(ExportError::NoSeries)));
    }
}
