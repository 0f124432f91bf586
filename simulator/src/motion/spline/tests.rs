use super::*;

fn at(spline: &Spline, t: f64) -> TrajectoryPoint {
    spline.at(t, &mut 0)
}

/// Third, fourth and fifth derivative of the interval `i` at its start (`end` false) or its end.
fn higher(spline: &Spline, i: usize, end: bool) -> [f64; 3] {
    let (p, q, h) = (spline.knots[i], spline.knots[i + 1], spline.times[i + 1] - spline.times[i]);
    let d = q.q - p.q - h * (p.v + 0.5 * h * p.a);
    let (v, a) = ((q.v - p.v - h * p.a) * h, (q.a - p.a) * h * h);
    let (c3, c4, c5) = (10.0 * d - 4.0 * v + 0.5 * a, -15.0 * d + 7.0 * v - a, 6.0 * d - 3.0 * v + 0.5 * a);
    let s = f64::from(u8::from(end));
    [
        (6.0 * c3 + s * (24.0 * c4 + s * 60.0 * c5)) / h.powi(3),
        (24.0 * c4 + s * 120.0 * c5) / h.powi(4),
        120.0 * c5 / h.powi(5),
    ]
}

/// Integral of the squared jerk: the jerk is quadratic on an interval, so its square is integrated
/// exactly by three Gauss points.
fn jerk(spline: &Spline) -> f64 {
    (0..spline.knots.len() - 1)
        .map(|i| {
            let h = spline.times[i + 1] - spline.times[i];
            let [j, s, c] = higher(spline, i, false);
            let at = |x: f64| (j + s * x * h + 0.5 * c * (x * h).powi(2)).powi(2);
            let off = 0.6f64.sqrt() / 2.0;
            h * (5.0 * at(0.5 - off) + 8.0 * at(0.5) + 5.0 * at(0.5 + off)) / 18.0
        })
        .sum()
}

const TIMES: [f64; 6] = [0.2, 0.5, 1.3, 1.5, 2.6, 3.0];
const VALUES: [f64; 6] = [0.3, -0.4, 1.1, 0.9, 0.2, 0.3];

fn all() -> [Spline; 3] {
    [EndConditions::Natural, EndConditions::Clamped, EndConditions::Periodic]
        .map(|ends| Spline::new(TIMES.to_vec(), &VALUES, ends).unwrap())
}

#[test]
fn two_knots_clamped_are_the_minimum_jerk_path() {
    let spline = Spline::new(vec![1.0, 3.0], &[0.5, -0.25], EndConditions::Clamped).unwrap();
    for k in 0..=20 {
        let s = f64::from(k) / 20.0;
        let expected = 0.5 - 0.75 * s * s * s * (10.0 + s * (6.0 * s - 15.0));
        let rate = -0.75 * 30.0 * s * s * (1.0 - s) * (1.0 - s) / 2.0;
        let got = at(&spline, 1.0 + 2.0 * s);
        // Roundings of a handful of products of order 10.
        assert!((got.q - expected).abs() < 1e-14 && (got.v - rate).abs() < 1e-14, "{s}: {got:?}");
    }
    // 720 D^2 / h^5.
    assert!((jerk(&spline) - 720.0 * 0.5625 / 32.0).abs() < 1e-12);
}

#[test]
fn knots_are_interpolated_and_four_derivatives_are_continuous() {
    for spline in all() {
        let scale = jerk(&spline).sqrt();
        for (time, value) in TIMES.into_iter().zip(VALUES) {
            // Rounding of a sum.
            assert!((at(&spline, time).q - value).abs() < 1e-15 * 8.0);
        }
        for i in 0..TIMES.len() - 2 {
            let (left, right) = (higher(&spline, i, true), higher(&spline, i + 1, false));
            // 1/h^4 = 625 for the shortest interval enlarges the roundings of the knots'
            // derivatives.
            assert!((left[0] - right[0]).abs() < 1e-11 * scale, "jerk at {i}: {left:?} {right:?}");
            assert!((left[1] - right[1]).abs() < 1e-10 * scale, "snap at {i}: {left:?} {right:?}");
        }
    }
}

#[test]
fn end_conditions_hold() {
    let [natural, clamped, periodic] = all();
    let last = TIMES.len() - 2;
    let scale = jerk(&natural).sqrt();
    for [jerk, snap, _] in [higher(&natural, 0, false), higher(&natural, last, true)] {
        assert!(jerk.abs() < 1e-11 * scale && snap.abs() < 1e-10 * scale, "{jerk} {snap}");
    }
    for t in [TIMES[0], TIMES[5]] {
        let p = at(&clamped, t);
        assert!(p.v.abs() < 1e-13 && p.a.abs() < 1e-11, "{p:?}");
    }
    let (first, end) = (higher(&periodic, 0, false), higher(&periodic, last, true));
    assert_eq!((periodic.knots[0].v, periodic.knots[0].a), (periodic.knots[5].v, periodic.knots[5].a));
    assert!((first[0] - end[0]).abs() < 1e-11 * scale && (first[1] - end[1]).abs() < 1e-10 * scale);
}

/// No other curve through the knots with the same ends has less jerk: tested against curves with
/// other knot derivatives, all of them quintics, which are the least between given ends. The excess
/// is exactly quadratic, so both signs agree.
#[test]
fn the_jerk_is_least() {
    for (spline, ends) in
        all().into_iter().zip([EndConditions::Natural, EndConditions::Clamped, EndConditions::Periodic])
    {
        let least = jerk(&spline);
        let n = TIMES.len();
        for i in 0..n {
            if ends == EndConditions::Clamped && (i == 0 || i == n - 1) {
                continue;
            }
            for (v, a) in [(0.1, 0.0), (0.0, 0.3), (0.02, -0.1)] {
                let excess = |sign: f64| {
                    let mut other = spline.clone();
                    let knots =
                        if ends == EndConditions::Periodic && i % (n - 1) == 0 { vec![0, n - 1] } else { vec![i] };
                    for k in knots {
                        other.knots[k].v += sign * v;
                        other.knots[k].a += sign * a;
                    }
                    jerk(&other) - least
                };
                let (plus, minus) = (excess(1.0), excess(-1.0));
                assert!(plus > 0.0 && minus > 0.0, "{ends:?} {i}: {plus} {minus}");
                // The slope of the jerk there is zero except for the cancellation of `least`.
                assert!((plus - minus).abs() < 1e-11 * (least + plus), "{ends:?} {i}: {plus} {minus}");
            }
        }
    }
}

#[test]
fn natural_ends_reproduce_parabolas_and_mirrors_are_mirrored() {
    let parabola = |t: f64| 0.3 - 0.7 * t + 0.4 * t * t;
    let values: Vec<f64> = TIMES.iter().map(|t| parabola(*t)).collect();
    let spline = Spline::new(TIMES.to_vec(), &values, EndConditions::Natural).unwrap();
    for k in 0..=100 {
        let t = 0.2 + 2.8 * f64::from(k) / 100.0;
        let p = at(&spline, t);
        // Condition of the system (some 1e3) times the rounding.
        assert!(
            (p.q - parabola(t)).abs() < 1e-13 && (p.v - (0.8 * t - 0.7)).abs() < 1e-12 && (p.a - 0.8).abs() < 1e-11
        );
    }
    for (spline, ends) in
        all().into_iter().zip([EndConditions::Natural, EndConditions::Clamped, EndConditions::Periodic])
    {
        let times: Vec<f64> = TIMES.iter().rev().map(|t| 3.2 - t).collect();
        let values: Vec<f64> = VALUES.iter().rev().copied().collect();
        let mirror = Spline::new(times, &values, ends).unwrap();
        for k in 0..=50 {
            let t = 0.2 + 2.8 * f64::from(k) / 50.0;
            let (p, m) = (at(&spline, t), at(&mirror, 3.2 - t));
            assert!((p.q - m.q).abs() < 1e-13 && (p.v + m.v).abs() < 1e-12, "{ends:?} {t}: {p:?} {m:?}");
        }
    }
}

/// Sampling a smooth function ever more densely, the error falls with the sixth power of the
/// interval: at clamped ends where the function is at rest without acceleration, and on a periodic
/// curve.
#[test]
fn the_error_is_of_order_six() {
    type Function = fn(f64) -> f64;
    let cases: [(EndConditions, Function); 2] =
        [(EndConditions::Clamped, |t| t - t.sin()), (EndConditions::Periodic, |t| (t + 0.4).sin())];
    for (ends, f) in cases {
        let error = |n: usize| {
            let times: Vec<f64> = (0..=n).map(|i| std::f64::consts::TAU * i as f64 / n as f64).collect();
            let mut values: Vec<f64> = times.iter().map(|t| f(*t)).collect();
            if ends == EndConditions::Periodic {
                values[n] = values[0];
            }
            let spline = Spline::new(times, &values, ends).unwrap();
            let errors = (0..1000).map(|k| std::f64::consts::TAU * (f64::from(k) + 0.5) / 1000.0);
            errors.map(|t| (at(&spline, t).q - f(t)).abs()).fold(0.0, f64::max)
        };
        let errors = [10, 20, 40, 80].map(error);
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!((5.7..6.3).contains(&order), "{ends:?}: {errors:?}");
        }
    }
}

#[test]
fn velocities_are_derivatives_and_ends_are_at_rest() {
    for spline in all() {
        for k in 0..40 {
            let (t, h) = (0.25 + 0.065 * f64::from(k), 1e-5);
            let slope = (at(&spline, t + h).q - at(&spline, t - h).q) / (2.0 * h);
            let bend = (at(&spline, t + h).v - at(&spline, t - h).v) / (2.0 * h);
            // h^2 / 6 times the third derivative (some 1e2), and rounding over h.
            assert!((slope - at(&spline, t).v).abs() < 1e-8 && (bend - at(&spline, t).a).abs() < 1e-6);
        }
        assert_eq!(at(&spline, 0.1), TrajectoryPoint { q: 0.3, v: 0.0, a: 0.0 });
        assert_eq!(at(&spline, 3.1), TrajectoryPoint { q: 0.3, v: 0.0, a: 0.0 });
    }
    let alone = Spline::new(vec![1.0], &[0.7], EndConditions::Natural).unwrap();
    assert_eq!(at(&alone, 1.0), TrajectoryPoint { q: 0.7, v: 0.0, a: 0.0 });
    let line = Spline::new(vec![1.0, 3.0], &[0.0, 1.0], EndConditions::Natural).unwrap();
    assert_eq!(at(&line, 2.0), TrajectoryPoint { q: 0.5, v: 0.5, a: 0.0 });
}

#[test]
fn the_cursor_finds_its_interval_from_anywhere() {
    let [spline, ..] = all();
    let mut cursor = 0;
    for t in [0.3, 2.9, 0.2, 3.0, 1.4, 1.3, 1.5, 0.6] {
        assert_eq!(spline.at(t, &mut cursor), at(&spline, t));
    }
}

#[test]
fn extremes_agree_with_dense_sampling() {
    for spline in all() {
        let [low, high] = spline.extremes();
        let dense = || (0..=28_000).map(|k| at(&spline, 0.2 + 1e-4 * f64::from(k)).q);
        let (least, most) = (dense().fold(f64::MAX, f64::min), dense().fold(f64::MIN, f64::max));
        // A sample every 1e-4 s misses an extreme by a (5e-5)^2 / 2, a being some 20.
        assert!(low.1 <= least + 1e-15 && least - low.1 < 1e-7 && high.1 >= most - 1e-15 && high.1 - most < 1e-7);
        // The time is rounded when the knot's is added, the rate is some 10.
        assert!((at(&spline, low.0).q - low.1).abs() < 1e-14 && (at(&spline, high.0).q - high.1).abs() < 1e-14);
    }
}

#[test]
fn invalid_knots_are_refused() {
    let refused =
        |times: &[f64], values: &[f64], ends| Spline::new(times.to_vec(), values, ends).unwrap_err().to_string();
    assert!(refused(&[], &[], EndConditions::Natural).contains("0 times and 0 values"));
    assert!(refused(&[0.0, 1.0], &[0.0], EndConditions::Natural).contains("2 times and 1 values"));
    assert!(refused(&[0.0, 0.0], &[0.0, 1.0], EndConditions::Natural).contains("but 0 follows 0"));
    assert!(refused(&[0.0, f64::NAN], &[0.0, 1.0], EndConditions::Natural).contains("NaN"));
    assert!(refused(&[0.0, 1.0], &[0.0, 1.0], EndConditions::Periodic).contains("first value 0, not at 1"));
}
