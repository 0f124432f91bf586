//! A reference that moves to new goals, also while it is still moving: every new goal adds a
//! minimum-jerk move, so that neither the reference nor its velocity jumps.
//!
//! ```text
//! r(t) = r_0 + sum_i (g_i - g_{i-1}) (10 s_i^3 - 15 s_i^4 + 6 s_i^5),   s_i = (t - t_i) / T_i,   g_0 = r_0
//! ```

use crate::motion::minimum_jerk::minimum_jerk;
use nalgebra::SVector;

/// One minimum-jerk move.
#[derive(Clone, Copy, Debug)]
struct Leg<const N: usize> {
    start: f64,
    duration: f64,
    way: SVector<f64, N>,
}

/// A sum of minimum-jerk moves. Times in s.
#[derive(Clone, Debug)]
pub struct ReferenceTrajectory<const N: usize> {
    from: SVector<f64, N>,
    legs: Vec<Leg<N>>,
}

impl<const N: usize> ReferenceTrajectory<N> {
    /// At the origin, with room for so many moves.
    pub fn new(paths: usize) -> Self {
        ReferenceTrajectory { from: SVector::zeros(), legs: Vec::with_capacity(paths) }
    }

    /// Removes all moves: the reference rests at `from`.
    pub fn begin(&mut self, from: SVector<f64, N>) {
        self.from = from;
        self.legs.clear();
    }

    /// Shifts the goal by `way` from `start` on within `duration` seconds (0: at once).
    pub fn add(&mut self, start: f64, duration: f64, way: SVector<f64, N>) {
        self.legs.push(Leg { start, duration, way });
    }

    /// Position and velocity at a time.
    pub fn at(&self, time: f64) -> (SVector<f64, N>, SVector<f64, N>) {
        let mut sum = (self.from, SVector::zeros());
        for leg in &self.legs {
            let (progress, rate) = minimum_jerk(time - leg.start, leg.duration);
            sum.0 += leg.way * progress;
            sum.1 += leg.way * rate;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    #[test]
    fn new_goals_change_the_path_without_a_jump() {
        let mut course = ReferenceTrajectory::new(2);
        course.begin(Vector2::new(1.0, 2.0));
        course.add(1.0, 2.0, Vector2::new(4.0, 0.0));
        let before = course.at(2.0);
        assert_eq!(before.0, Vector2::new(3.0, 2.0), "half way at half time");
        course.add(2.0, 1.0, Vector2::new(-4.0, 1.0));
        assert_eq!(course.at(2.0), before);
        assert_eq!(course.at(3.0), (Vector2::new(1.0, 3.0), Vector2::zeros()));
        let h = 1e-6;
        for t in [1.5, 2.2, 2.9] {
            let slope = (course.at(t + h).0 - course.at(t - h).0) / (2.0 * h);
            // The polynomial's terms reach 10, times displacements of 4: roundings of 9e-15 at both
            // ends, over 2 h.
            assert!((slope - course.at(t).1).norm() < 1e-8, "{t}");
        }
    }
}
