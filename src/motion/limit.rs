//! A stream of positions kept within a range and a speed, and smoothed.
//!
//! ```text
//! r(t) = min(max(q(t), lower), upper)
//! l(t) = 1/2 [ min_s (r(s) + V |t - s|) + max_s (r(s) - V |t - s|) ]
//! x    = l averaged three times over a window
//! ```
//!
//! l is, of all motions no faster than V, one that keeps nearest to r: the first term is the greatest such motion below r,
//! the second the least one above it, and no motion within the speed can have a smaller greatest distance from r than their
//! mean has (E. J. McShane, Extension of range of functions, Bull. AMS 40 (1934), for the two envelopes). Unlike a rate
//! limiter that follows, it does not lag. Averages of positions within a range and a speed stay within them.

/// How far a limit moved a stream.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Limited {
    /// Greatest distance, rad or m.
    pub distance: f64,
    /// Samples that were moved.
    pub samples: usize,
}

impl Limited {
    fn see(&mut self, before: f64, after: f64) {
        let distance = (after - before).abs();
        // Less than this is rounding of sums that undo each other.
        if distance > 1e-12 * before.abs().max(1.0) {
            self.distance = self.distance.max(distance);
            self.samples += 1;
        }
    }
}

/// Brings every position into `[lower, upper]`.
pub fn range(x: &mut [f64], lower: f64, upper: f64) -> Limited {
    let mut limited = Limited::default();
    for x in x {
        let within = x.max(lower).min(upper);
        limited.see(*x, within);
        *x = within;
    }
    limited
}

/// Brings the steps between positions down to `step` (the speed times the time between samples; infinite: no limit).
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
        limited.see(*x, within);
        *x = within;
    }
    limited
}

/// Averages three times over `2 half + 1` samples; beyond its ends a stream stands as it ends.
pub fn smooth(x: &mut Vec<f64>, half: usize) {
    if half == 0 || x.is_empty() {
        return;
    }
    for _ in 0..3 {
        let at = |i: isize| x[i.clamp(0, x.len() as isize - 1) as usize];
        let window = (2 * half + 1) as f64;
        let average = |i: usize| {
            let i = i as isize;
            (i - half as isize..=i + half as isize).map(at).sum::<f64>() / window
        };
        *x = (0..x.len()).map(average).collect();
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
    fn a_jump_is_met_half_way() {
        let mut x: Vec<f64> = (0..21).map(|i| if i < 10 { 0.0 } else { 1.0 }).collect();
        let limited = speed(&mut x, 0.25);
        // The jump stands between samples 9 and 10. The envelopes are 0.25 (i - 9) and 1 - 0.25 (10 - i), each in [0, 1]; all
        // numbers are exact.
        let wanted =
            |i: usize| 0.5 * ((0.25 * (i as f64 - 9.0)).clamp(0.0, 1.0) + (0.25 * (i as f64 - 6.0)).clamp(0.0, 1.0));
        assert!(x.iter().enumerate().all(|(i, x)| *x == wanted(i)), "{x:?}");
        assert_eq!(limited, Limited { distance: 0.375, samples: 6 });
    }

    /// The smallest greatest distance that any motion within the speed can have is half the greatest excess of a difference
    /// of two samples over what the speed allows between them.
    #[test]
    fn nothing_within_the_speed_is_nearer() {
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
        // Away from the ends, where the standing continuation reaches: 3 windows of 5 samples.
        assert!((15..85).all(|i| (line[i] - i as f64).abs() < 1e-12));
    }

    #[test]
    fn what_is_within_is_not_touched() {
        let slow: Vec<f64> = (0..50).map(|i| (0.1 * f64::from(i)).sin()).collect();
        let mut x = slow.clone();
        assert_eq!(range(&mut x, -1.0, 1.0), Limited::default());
        assert_eq!(speed(&mut x, 0.1), Limited::default());
        assert!(x.iter().zip(&slow).all(|(a, b)| (a - b).abs() < 1e-15));
        let most = x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        assert_eq!(range(&mut x, -0.5, 0.5).distance, most - 0.5);
    }
}
