//! At which instants a log is read, and what lies between its ticks.

use crate::export::{ExportError, Selection};
use nalgebra::UnitQuaternion;

/// More rows than anyone plots; beyond them a rate is a mistake.
pub(super) const MOST_ROWS: f64 = 1e7;

/// A part of the time between two rows that still counts as being at the tick: rounding of `k / rate`.
const AT_TICK: f64 = 1e-6;

/// A place in the time of a log: between the ticks `before` and `after`, or at `before` when `fraction` is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    pub before: usize,
    pub after: usize,
    pub fraction: f64,
}

impl Sample {
    fn tick(at: usize) -> Self {
        Self { before: at, after: at, fraction: 0.0 }
    }

    /// A number on the line from `a` to `b`; `a` itself at a tick.
    pub fn between(self, a: f64, b: f64) -> f64 {
        if self.fraction == 0.0 { a } else { a + self.fraction * (b - a) }
    }

    /// An orientation on the shortest arc from `a` to `b`; `a` itself at a tick.
    pub fn turned(self, a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
        if self.fraction == 0.0 {
            return *a;
        }
        // Half a turn apart there is no shortest arc; nearly equal ones need none.
        a.try_slerp(b, self.fraction, 1e-12).unwrap_or(*a)
    }
}

/// The instants of a selection, s, and where they lie in the log.
pub(super) fn choose(ticks: &[f64], wanted: &Selection) -> Result<(Vec<f64>, Vec<Sample>), ExportError> {
    let (Some(&first), Some(&last)) = (ticks.first(), ticks.last()) else { return Err(ExportError::NoSeries) };
    let (from, to) = (wanted.from.unwrap_or(first), wanted.to.unwrap_or(last));
    let chosen = match wanted.rate {
        Some(rate) => at_rate(ticks, from, to, rate)?,
        None => {
            let inside = |(i, t): (usize, &f64)| (from..=to).contains(t).then_some((*t, Sample::tick(i)));
            ticks.iter().enumerate().filter_map(inside).collect()
        }
    };
    if chosen.is_empty() {
        return Err(ExportError::NoInstants { from, to, first, last });
    }
    Ok(chosen.into_iter().unzip())
}

/// `from + k / rate` for every whole `k` that leads to an instant of the log.
fn at_rate(ticks: &[f64], from: f64, to: f64, rate: f64) -> Result<Vec<(f64, Sample)>, ExportError> {
    let (first, last) = (ticks[0], ticks[ticks.len() - 1]);
    let (slack, end) = (AT_TICK / rate, to.min(last));
    let rows = ((end - from) * rate).floor() + 1.0;
    if rows > MOST_ROWS {
        return Err(ExportError::TooManyRows { rows, rate });
    }
    let mut chosen = Vec::new();
    for k in 0.. {
        let t = from + f64::from(k) / rate;
        if !(t <= end + slack) {
            break;
        }
        if t < first - slack {
            // Before the log there is nothing, however much of that is asked for.
            if (first - from) * rate > MOST_ROWS {
                return Err(ExportError::TooManyRows { rows: (first - from) * rate, rate });
            }
            continue;
        }
        chosen.push((t, at(ticks, t, slack)));
    }
    Ok(chosen)
}

/// Where an instant lies; one that is nearly at a tick is at it.
fn at(ticks: &[f64], t: f64, slack: f64) -> Sample {
    let after = ticks.partition_point(|tick| *tick <= t);
    if after < ticks.len() && ticks[after] - t <= slack {
        return Sample::tick(after);
    }
    let before = after.saturating_sub(1);
    if after == ticks.len() || t - ticks[before] <= slack {
        return Sample::tick(before);
    }
    Sample { before, after, fraction: (t - ticks[before]) / (ticks[after] - ticks[before]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rate(ticks: &[f64], from: Option<f64>, to: Option<f64>, rate: f64) -> Vec<(f64, Sample)> {
        let wanted = Selection { rate: Some(rate), from, to, ..Selection::default() };
        let (times, samples) = choose(ticks, &wanted).unwrap();
        times.into_iter().zip(samples).collect()
    }

    #[test]
    fn an_instant_that_rounds_next_to_a_tick_is_at_it() {
        let ticks: Vec<f64> = (0..=1000).map(|k| f64::from(k) / 200.0).collect();
        for hz in [200.0, 100.0, 40.0, 1.0] {
            let chosen = rate(&ticks, None, None, hz);
            assert_eq!(chosen.len(), (5.0 * hz) as usize + 1);
            let every = (200.0 / hz) as usize;
            assert!(chosen.iter().enumerate().all(|(k, (_, s))| *s == Sample::tick(every * k)), "{hz}");
        }
        // Off by three decimals' rounding, the ends included.
        let shifted: Vec<f64> = ticks.iter().map(|t| t + 0.1).collect();
        let chosen = rate(&shifted, Some(0.3), Some(0.7), 200.0);
        assert_eq!((chosen.len(), chosen[0].1, chosen[80].1), (81, Sample::tick(40), Sample::tick(120)));
    }

    #[test]
    fn between_ticks_the_fraction_is_that_of_the_time() {
        let chosen = rate(&[0.0, 1.0, 3.0], None, None, 2.0);
        let fractions: Vec<_> = chosen.iter().map(|(t, s)| (*t, s.before, s.fraction)).collect();
        let expected =
            [(0.0, 0, 0.0), (0.5, 0, 0.5), (1.0, 1, 0.0), (1.5, 1, 0.25), (2.0, 1, 0.5), (2.5, 1, 0.75), (3.0, 2, 0.0)];
        assert_eq!(fractions, expected);
    }

    #[test]
    fn instants_outside_of_the_log_are_left_out() {
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
