//! Paths of one joint in pieces of constant jerk, which end at rest.
//!
//! ```text
//! q(s) = q + v s + a s^2 / 2 + j s^3 / 6        within a piece, s from its start
//! ```
//!
//! A *stop* brings (v, a) to (0, 0) in two pieces of length d,
//!
//! ```text
//! j1 = -v / d^2 - 3 a / (2 d),   j2 = v / d^2 + a / (2 d)
//! ```
//!
//! with the smallest d of a geometric series that keeps the limits. A *transfer* reaches (q1, v1,
//! a1) after three pieces of length d, with `A = (a1 - a0) / d`, `B = (v1 - v0 - 3 d a0) / d^2`,
//! `C = (q1 - q0 - 3 d v0 - 9/2 d^2 a0) / d^3`
//!
//! ```text
//! j1 = C - B + A / 3,   j2 = B - A / 2 - 2 j1,   j3 = A - j1 - j2
//! ```
//!
//! and stops from there. A path can therefore always be followed to its end. Extremes are those of
//! the polynomials: of acceleration at the ends of pieces, of speed there and where a = 0, of
//! position there and where v = 0.

use super::Limits;
use crate::math;
use crate::motion::spline::TrajectoryPoint;

/// `from` after `s` seconds of constant jerk.
fn after(from: &TrajectoryPoint, jerk: f64, s: f64) -> TrajectoryPoint {
    TrajectoryPoint {
        q: from.q + s * (from.v + s * (0.5 * from.a + s * jerk / 6.0)),
        v: from.v + s * (from.a + 0.5 * s * jerk),
        a: from.a + s * jerk,
    }
}

/// Pieces of the longest path: a transfer of three and a stop of two.
const PIECES: usize = 5;

/// Rounding tolerated in ranges, relative and in rad or m.
const RANGE_ROUNDING: f64 = 1e-9;

/// Relative rounding tolerated in limits.
const ROUNDING: f64 = 1e-6;

/// Growth factor and maximum, s, of the durations tried for a path.
const DURATIONS: (f64, f64) = (1.2, 30.0);

#[derive(Clone, Copy, PartialEq, Debug, Default)]
struct Piece {
    begin: f64,
    end: f64,
    from: TrajectoryPoint,
    jerk: f64,
}

/// A path of constant-jerk pieces.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct JointPath {
    pieces: [Piece; PIECES],
    count: usize,
    /// Final position, at rest.
    rest: f64,
    end: f64,
}

impl JointPath {
    /// At rest at `q`.
    pub fn resting(q: f64) -> Self {
        JointPath { pieces: [Piece::default(); PIECES], count: 0, rest: q, end: f64::NEG_INFINITY }
    }

    /// Constant velocity for `duration`, then rest: the prediction for an uncontrolled joint.
    pub fn drift(q: f64, v: f64, begin: f64, duration: f64) -> Self {
        let mut path = JointPath::resting(q);
        if v != 0.0 {
            path.rest = path.push(TrajectoryPoint { q, v, a: 0.0 }, begin, duration, 0.0).q;
        }
        path
    }

    /// From `from` at `begin` to rest, in the shortest stop that keeps the limits of acceleration
    /// and jerk. [`Self::keeps`] checks speed and range.
    pub fn stop(from: TrajectoryPoint, begin: f64, limits: &Limits) -> Self {
        let mut path = JointPath::resting(from.q);
        path.append_stop(from, begin, limits);
        path
    }

    /// From `from` at `begin` to `to` after `duration`, and then to rest; none if that breaks a
    /// limit.
    pub fn transfer(
        from: TrajectoryPoint,
        begin: f64,
        to: TrajectoryPoint,
        duration: f64,
        limits: &Limits,
    ) -> Option<Self> {
        let mut path = JointPath::resting(to.q);
        let d = duration / 3.0;
        let a = (to.a - from.a) / d;
        let b = (to.v - from.v - 3.0 * d * from.a) / (d * d);
        let c = (to.q - from.q - 3.0 * d * from.v - 4.5 * d * d * from.a) / (d * d * d);
        let j1 = c - b + a / 3.0;
        let j2 = b - 0.5 * a - 2.0 * j1;
        let jerks = [j1, j2, a - j1 - j2];
        if jerks.iter().any(|j| !(j.abs() <= limits.jerk)) {
            return None;
        }
        let mut at = from;
        for (k, jerk) in jerks.into_iter().enumerate() {
            at = path.push(at, begin + k as f64 * d, d, jerk);
        }
        path.append_stop(to, begin + duration, limits);
        path.keeps(limits).then_some(path)
    }

    /// The path with the shortest of a series of durations from `shortest` on that keeps the
    /// limits; `target` gives the end of the motion for a duration.
    pub fn soonest(
        here: TrajectoryPoint,
        begin: f64,
        shortest: f64,
        limits: &Limits,
        target: impl Fn(f64) -> TrajectoryPoint,
    ) -> Option<Self> {
        // From rest to rest over x the jerk is 54 x / T^3: a much shorter path breaks its limit.
        let distance = (target(shortest).q - here.q).abs();
        let mut duration = shortest.max(0.5 * math::cbrt(54.0 * distance / limits.jerk));
        while duration <= DURATIONS.1.max(2.0 * shortest) {
            let path = JointPath::transfer(here, begin, target(duration), duration, limits);
            if path.is_some() {
                return path;
            }
            duration *= DURATIONS.0;
        }
        None
    }

    fn push(&mut self, from: TrajectoryPoint, begin: f64, length: f64, jerk: f64) -> TrajectoryPoint {
        self.pieces[self.count] = Piece { begin, end: begin + length, from, jerk };
        self.count += 1;
        self.end = begin + length;
        after(&from, jerk, length)
    }

    fn append_stop(&mut self, from: TrajectoryPoint, begin: f64, limits: &Limits) {
        self.rest = from.q;
        self.end = begin;
        if from.v == 0.0 && from.a == 0.0 {
            return;
        }
        let (v, a) = (from.v, from.a);
        // The first value is too short for either limit alone.
        let mut d = 0.5 * (v.abs() / limits.acceleration).max((v.abs() / limits.jerk).sqrt());
        d = d.max(0.4 * a.abs() / limits.jerk).max(1e-6);
        let fits = |d: f64| {
            let (j1, j2) = (-v / (d * d) - 1.5 * a / d, v / (d * d) + 0.5 * a / d);
            let (jerk, between) = (j1.abs().max(j2.abs()), (v / d + 0.5 * a).abs());
            (jerk <= limits.jerk && between <= limits.acceleration.max(a.abs())).then_some((j1, j2))
        };
        // The terms decrease with d, except a / 2, which a limit of at least |a| allows.
        let found = (0..400).find_map(|_| {
            d *= 1.1;
            fits(d)
        });
        let Some((j1, j2)) = found else { return };
        let middle = self.push(from, begin, d, j1);
        self.rest = self.push(middle, begin + d, d, j2).q;
    }

    /// Time at which it comes to rest, s.
    pub fn end(&self) -> f64 {
        self.end
    }

    /// Position at which it comes to rest.
    pub fn rest(&self) -> f64 {
        self.rest
    }

    /// The motion at time `t`.
    pub fn at(&self, t: f64) -> TrajectoryPoint {
        match self.pieces[..self.count].iter().find(|p| t < p.end) {
            Some(p) => after(&p.from, p.jerk, (t - p.begin).max(0.0)),
            None => TrajectoryPoint { q: self.rest, v: 0.0, a: 0.0 },
        }
    }

    /// Smallest and greatest position from `from` to `to`, s.
    pub fn range(&self, from: f64, to: f64) -> [f64; 2] {
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        let mut add = |q: f64| range = [range[0].min(q), range[1].max(q)];
        add(self.at(from).q);
        add(self.at(to).q);
        for p in self.pieces[..self.count].iter().filter(|p| p.end > from && p.begin < to) {
            let (s0, s1) = ((from - p.begin).max(0.0), to.min(p.end) - p.begin);
            let ends = [s0, s1].into_iter().chain(turns(&p.from, p.jerk).into_iter().flatten());
            ends.filter(|s| *s >= s0 && *s <= s1).for_each(|s| add(after(&p.from, p.jerk, s).q));
        }
        range
    }

    /// Greatest distance from the position `q` from `from` on.
    pub fn reach(&self, q: f64, from: f64) -> f64 {
        let [low, high] = self.range(from, self.end.max(from));
        (high - q).max(q - low)
    }

    /// Whether it keeps the limits of jerk, acceleration, speed and range.
    pub fn keeps(&self, limits: &Limits) -> bool {
        let more = 1.0 + ROUNDING;
        let pieces = &self.pieces[..self.count];
        let piece_keeps = |p: &Piece| {
            let length = p.end - p.begin;
            let last = after(&p.from, p.jerk, length);
            let flat = Some(-p.from.a / p.jerk).filter(|s| *s > 0.0 && *s < length);
            let peak = flat.map_or(0.0, |s| after(&p.from, p.jerk, s).v.abs());
            let speed = peak.max(p.from.v.abs()).max(last.v.abs());
            let acceleration = p.from.a.abs().max(last.a.abs());
            p.jerk.abs() <= limits.jerk * more
                && acceleration <= limits.acceleration * more
                && speed <= limits.speed * more
        };
        pieces.iter().all(piece_keeps) && self.stays(pieces.first().map_or(self.end, |p| p.begin), limits)
    }

    /// Whether it stays within the range from `from` on. A path that begins outside may return.
    fn stays(&self, from: f64, limits: &Limits) -> bool {
        let [low, high] = self.range(from, self.end.max(from));
        let start = self.at(from).q;
        let tolerance = RANGE_ROUNDING * (1.0 + low.abs().max(high.abs()));
        low >= (limits.lower - tolerance).min(start) && high <= (limits.upper + tolerance).max(start)
    }
}

/// Times at which v = 0, seconds from the start of a piece.
fn turns(m: &TrajectoryPoint, jerk: f64) -> [Option<f64>; 2] {
    let (a, b, c) = (0.5 * jerk, m.a, m.v);
    let root = b * b - 4.0 * a * c;
    if root < 0.0 || (a == 0.0 && b == 0.0) {
        return [None, None];
    }
    // Avoids cancellation.
    let w = -0.5 * (b + b.signum() * root.sqrt());
    [(a != 0.0).then(|| w / a), (w != 0.0).then(|| c / w)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    const LIMITS: Limits = Limits { lower: -2.0, upper: 2.0, speed: 5.0, acceleration: 40.0, jerk: 800.0 };

    fn random(r: &mut Stream) -> TrajectoryPoint {
        TrajectoryPoint { q: r.normal() * 0.5, v: r.normal(), a: 10.0 * r.normal() }
    }

    #[test]
    fn a_transfer_reaches_its_target_and_ends_at_rest() {
        let mut r = Stream::new(1, &["go"]);
        let mut found = 0;
        for _ in 0..2000 {
            let (from, to) = (random(&mut r), random(&mut r));
            let duration = 0.1 + r.unit();
            let Some(path) = JointPath::transfer(from, 3.0, to, duration, &LIMITS) else { continue };
            found += 1;
            // Rounding of d^3 j with j up to 800, and of the cubes' sums, relative to 1.
            let (start, end) = (path.at(3.0), after(&path.pieces[2].from, path.pieces[2].jerk, duration / 3.0));
            assert_eq!(start, from);
            assert!((end.q - to.q).abs() < 1e-12 && (end.v - to.v).abs() < 1e-11, "{end:?} {to:?}");
            assert!((end.a - to.a).abs() < 1e-10, "{end:?} {to:?}");
            let rest = path.at(path.end() + 1.0);
            assert!((path.at(path.end() - 1e-9).q - rest.q).abs() < 1e-8 && rest.v == 0.0 && rest.a == 0.0);
        }
        assert!(found > 500, "{found}");
    }

    #[test]
    fn limits_hold_between_the_pieces_and_the_range_is_exact() {
        let mut r = Stream::new(2, &["limits"]);
        for _ in 0..500 {
            let (from, to) = (random(&mut r), random(&mut r));
            let stop = JointPath::stop(from, 0.0, &LIMITS);
            let transfer = JointPath::transfer(from, 0.0, to, 0.1 + r.unit(), &LIMITS);
            for (path, whole) in [(Some(stop), false), (transfer, true)] {
                let Some(path) = path else { continue };
                let n = 4000;
                let (mut low, mut high, mut before) = (f64::INFINITY, f64::NEG_INFINITY, path.at(0.0));
                let h = path.end().max(0.0) / f64::from(n);
                for i in 0..=n {
                    let now = path.at(f64::from(i) * h);
                    (low, high) = (low.min(now.q), high.max(now.q));
                    assert!(now.a.abs() <= LIMITS.acceleration.max(from.a.abs()) * (1.0 + 1e-8), "{now:?}");
                    if whole {
                        assert!(now.v.abs() <= LIMITS.speed * (1.0 + 1e-8));
                        assert!(now.q.abs() <= 2.0 + 1e-8);
                    }
                    if i > 0 && h > 0.0 {
                        // Acceleration is continuous: it changes by no more than the jerk allows.
                        assert!(
                            (now.a - before.a).abs() <= LIMITS.jerk * h * (1.0 + 1e-6) + 1e-9,
                            "{before:?} {now:?}"
                        );
                    }
                    before = now;
                }
                let [least, most] = path.range(0.0, path.end().max(0.0));
                // Between two of the samples a turning point rises by at most a h^2 / 8.
                let bar = 60.0 * h * h / 8.0 + 1e-12;
                assert!(least <= low + 1e-12 && low - least <= bar, "{least} {low}");
                assert!(most >= high - 1e-12 && most - high <= bar, "{most} {high}");
            }
        }
    }

    #[test]
    fn paths_that_break_a_limit_are_rejected() {
        let rest = |q| TrajectoryPoint { q, v: 0.0, a: 0.0 };
        // 54 x / T^3 of jerk: 0.5 in 0.3 s takes 1000; 0.4 s are enough.
        assert!(JointPath::transfer(rest(0.0), 0.0, rest(0.5), 0.3, &LIMITS).is_none());
        assert!(JointPath::transfer(rest(0.0), 0.0, rest(0.5), 0.4, &LIMITS).is_some());
        // Beyond the range, even where it ends within it.
        assert!(JointPath::transfer(rest(0.0), 0.0, rest(2.1), 5.0, &LIMITS).is_none());
        let up = TrajectoryPoint { q: 1.99, v: 1.0, a: 0.0 };
        assert!(JointPath::transfer(up, 0.0, rest(1.99), 0.5, &LIMITS).is_none());
        // The mean speed of 2 rad in 0.88 s is within 5, the greatest, 2.25 times that at the
        // middle, is not.
        let wide = Limits { acceleration: 1e3, jerk: 1e5, ..LIMITS };
        assert!(JointPath::transfer(rest(0.0), 0.0, rest(2.0), 0.88, &wide).is_none());
        assert!(JointPath::transfer(rest(0.0), 0.0, rest(2.0), 0.92, &wide).is_some());
    }
}
