//! Limits a stream of positions to a range and a speed, and smooths it.
//!
//! ```text
//! r(t) = min(max(q(t), lower), upper)
//! l(t) = 1/2 [ min_s (r(s) + V |t - s|) + max_s (r(s) - V |t - s|) ]
//! x    = l averaged three times over a window
//! ```
//!
//! Among all motions no faster than V, l minimises the greatest distance from r. The first term is
//! the greatest such motion below r, the second the least one above it; l is their mean (E. J.
//! McShane, Extension of range of functions, Bull. AMS 40 (1934), for the two envelopes). Unlike a
//! rate limiter, it does not lag.
//! Averages of positions within a range and a speed stay within them.

/// Change that a limit made to a stream.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Limited {
    /// Greatest distance, rad or m.
    pub distance: f64,
    /// Number of samples changed.
    pub samples: usize,
}

impl Limited {
    fn record(&mut self, before: f64, after: f64) {
        let distance = (after - before).abs();
        // Smaller differences are rounding of sums that cancel.
        if distance > 1e-12 * before.abs().max(1.0) {
            self.distance = self.distance.max(distance);
            self.samples += 1;
        }
    }
}

/// Clamps every position to `[lower, upper]`.
pub fn range(x: &mut [f64], lower: f64, upper: f64) -> Limited {
    let mut limited = Limited::default();
    for x in x {
        let within = x.max(lower).min(upper);
        limited.record(*x, within);
        *x = within;
    }
    limited
}

/// Limits the steps between positions to `step` (speed times sampling period; infinite: no limit).
pub fn speed(x: &mut [f64], step: f64) -> Limited {
    let mut limited = Limited::default();
    if !step.is_finite() {
        return limited;
    }
    let envelope = |sign: f64| {
        let mut e: Vec<f64> = x.iter().map(|x| sign * x).collect();
        for i in 1..e.len() {
            e[i] = e[i].min(e[i - 1] + step);
        }
        for i in (1..e.len()).rev() {
            e[i - 1] = e[i - 1].min(e[i] + step);
        }
        e
    };
    let (below, above) = (envelope(1.0), envelope(-1.0));
    for ((x, below), above) in x.iter_mut().zip(below).zip(above) {
        let within = 0.5 * (below - above);
        limited.record(*x, within);
        *x = within;
    }
    limited
}

/// Averages three times over `2 half + 1` samples; beyond its ends the stream keeps its end values.
pub fn smooth(x: &mut Vec<f64>, half: usize) {
    if half == 0 || x.is_empty() {
        return;
    }
    let extremes = |x: &[f64]| x.iter().fold((x[0], x[0]), |(low, high), x| (low.min(*x), high.max(*x)));
    let window = (2 * half + 1) as f64;
    for _ in 0..3 {
        let (low, high) = extremes(x);
        let last = x.len() - 1;
        // The window about sample 0: its first half repeats the first sample.
        let mut sum = Sum::default();
        sum.add_times(x[0], half);
        (0..=half.min(last)).for_each(|i| sum.add(x[i]));
        sum.add_times(x[last], half.saturating_sub(last));
        let mut smoothed = Vec::with_capacity(x.len());
        for i in 0..x.len() {
            smoothed.push((sum.value() / window).clamp(low, high));
            sum.add(x[(i + 1 + half).min(last)]);
            sum.add(-x[i.saturating_sub(half)]);
        }
        *x = smoothed;
    }
}

/// A compensated running sum: it keeps each addition's rounding error and does not drift.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    high: f64,
    low: f64,
}

impl Sum {
    /// Knuth's exact sum of two numbers.
    fn add(&mut self, x: f64) {
        let sum = self.high + x;
        let virtually = sum - self.high;
        self.low += (self.high - (sum - virtually)) + (x - virtually);
        self.high = sum;
    }

    fn add_times(&mut self, x: f64, times: usize) {
        let product = x * times as f64;
        self.add(product);
        self.add(x.mul_add(times as f64, -product));
    }

    fn value(&self) -> f64 {
        self.high + self.low
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Deterministic numbers in (-1, 1).
    fn noise(n: usize) -> Vec<f64> {
        let mut state = 12345u64;
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        };
        (0..n).map(|_| next()).collect()
    }

    fn greatest_step(x: &[f64]) -> f64 {
        x.windows(2).map(|p| (p[1] - p[0]).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn a_jump_is_split_evenly() {
        let mut x: Vec<f64> = (0..21).map(|i| if i < 10 { 0.0 } else { 1.0 }).collect();
        let limited = speed(&mut x, 0.25);
        // The jump is between samples 9 and 10. The envelopes are 0.25 (i - 9) and 1 - 0.25 (10 -
        // i), each in [0, 1]; all numbers are exact.
        let expected =
            |i: usize| 0.5 * ((0.25 * (i as f64 - 9.0)).clamp(0.0, 1.0) + (0.25 * (i as f64 - 6.0)).clamp(0.0, 1.0));
        assert!(x.iter().enumerate().all(|(i, x)| *x == expected(i)), "{x:?}");
        assert_eq!(limited, Limited { distance: 0.375, samples: 6 });
    }

    /// The smallest greatest distance that any motion within the speed can have is half the
    /// greatest excess of a difference of two samples over what the speed allows between them.
    #[test]
    fn the_limited_stream_is_nearest_within_the_speed() {
        let x = noise(200);
        for step in [0.01, 0.1, 0.5, 3.0] {
            let mut limited = x.clone();
            let distance = speed(&mut limited, step).distance;
            let excess = |i: usize, j: usize| (x[i] - x[j]).abs() - step * i.abs_diff(j) as f64;
            let all = (0..200).flat_map(|i| (0..200).map(move |j| (i, j)));
            let least = all.map(|(i, j)| excess(i, j)).fold(0.0, f64::max) / 2.0;
            // Roundings of sums of up to 200 steps.
            assert!((distance - least).abs() < 1e-13, "{step}: {distance} {least}");
            assert!(greatest_step(&limited) <= step + 1e-13);
        }
    }

    #[test]
    fn smoothing_keeps_ranges_and_speeds_and_straight_lines() {
        let mut x = noise(300);
        range(&mut x, -0.5, 0.4);
        speed(&mut x, 0.2);
        let mut smoothed = x.clone();
        smooth(&mut smoothed, 5);
        assert!(smoothed.iter().all(|x| (-0.5..=0.4).contains(x)));
        assert!(greatest_step(&smoothed) <= 0.2 + 1e-15);
        let bend = |x: &[f64]| x.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]).abs()).fold(0.0, f64::max);
        assert!(bend(&smoothed) < 0.2 * bend(&x), "{} {}", bend(&smoothed), bend(&x));
        let mut line: Vec<f64> = (0..100).map(f64::from).collect();
        smooth(&mut line, 5);
        // Away from the ends, where the constant continuation reaches: 3 windows of 5 samples.
        assert!((15..85).all(|i| (line[i] - i as f64).abs() < 1e-12));
    }

    /// The same sums computed directly, over a stream long enough for a plain running sum to drift.
    #[test]
    fn running_averages_are_the_averages() {
        let shifted: Vec<f64> = noise(20_000).iter().map(|x| 1e3 + x).collect();
        for (x, half) in [(shifted, 400), (noise(50), 7), (noise(5), 40), (vec![0.3], 3)] {
            let mut direct = x.clone();
            for _ in 0..3 {
                let at = |i: isize| direct[i.clamp(0, direct.len() as isize - 1) as usize];
                let sum = |i: isize| {
                    (i - half..=i + half).map(at).fold(Sum::default(), |mut s, x| {
                        s.add(x);
                        s
                    })
                };
                direct = (0..direct.len()).map(|i| sum(i as isize).value() / (2 * half + 1) as f64).collect();
            }
            let mut smoothed = x.clone();
            smooth(&mut smoothed, half as usize);
            // Some roundings of numbers of size 1e3.
            let off =
                smoothed.iter().zip(&direct).map(|(a, b)| (a - b).abs() / x[0].abs().max(1.0)).fold(0.0, f64::max);
            assert!(off < 4.0 * f64::EPSILON, "{half}: {off:e}");
        }
    }

    #[test]
    fn motions_within_the_limits_are_unchanged() {
        let slow: Vec<f64> = (0..50).map(|i| (0.1 * f64::from(i)).sin()).collect();
        let mut x = slow.clone();
        assert_eq!(range(&mut x, -1.0, 1.0), Limited::default());
        assert_eq!(speed(&mut x, 0.1), Limited::default());
        assert!(x.iter().zip(&slow).all(|(a, b)| (a - b).abs() < 1e-15));
        let most = x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        assert_eq!(range(&mut x, -0.5, 0.5).distance, most - 0.5);
    }
}
