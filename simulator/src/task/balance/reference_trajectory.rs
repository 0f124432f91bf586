//! A reference that moves to new goals, also while it is still moving. Every new goal adds a
//! minimum-jerk move, so that neither the reference nor its velocity jumps.
//!
//! ```text
//! r(t) = r_0 + sum_i (g_i - g_{i-1}) (10 s_i^3 - 15 s_i^4 + 6 s_i^5),   s_i = (t - t_i) / T_i,   g_0 = r_0
//! ```

use crate::motion::minimum_jerk::minimum_jerk;
use nalgebra::SVector;

/// One minimum-jerk move.
#[derive(Clone, Copy, Debug)]
struct Move<const N: usize> {
    start: f64,
    duration: f64,
    shift: SVector<f64, N>,
}

/// A sum of minimum-jerk moves. Times in s.
#[derive(Clone, Debug)]
pub struct ReferenceTrajectory<const N: usize> {
    from: SVector<f64, N>,
    moves: Vec<Move<N>>,
}

impl<const N: usize> ReferenceTrajectory<N> {
    /// At the origin, with memory for `moves` moves.
    pub fn new(moves: usize) -> Self {
        ReferenceTrajectory { from: SVector::zeros(), moves: Vec::with_capacity(moves) }
    }

    /// Removes all moves: the reference rests at `from`.
    pub fn begin(&mut self, from: SVector<f64, N>) {
        self.from = from;
        self.moves.clear();
    }

    /// Shifts the goal by `shift` from `start` on within `duration` seconds (0: at once).
    pub fn add(&mut self, start: f64, duration: f64, shift: SVector<f64, N>) {
        self.moves.push(Move { start, duration, shift });
    }

    /// Position and velocity at a time.
    pub fn at(&self, time: f64) -> (SVector<f64, N>, SVector<f64, N>) {
        let mut sum = (self.from, SVector::zeros());
        for step in &self.moves {
            let (progress, rate) = minimum_jerk(time - step.start, step.duration);
            sum.0 += step.shift * progress;
            sum.1 += step.shift * rate;
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
        let mut reference = ReferenceTrajectory::new(2);
        reference.begin(Vector2::new(1.0, 2.0));
        reference.add(1.0, 2.0, Vector2::new(4.0, 0.0));
        let before = reference.at(2.0);
        assert_eq!(before.0, Vector2::new(3.0, 2.0), "halfway at half the duration");
        reference.add(2.0, 1.0, Vector2::new(-4.0, 1.0));
        assert_eq!(reference.at(2.0), before);
        assert_eq!(reference.at(3.0), (Vector2::new(1.0, 3.0), Vector2::zeros()));
        let h = 1e-6;
        for t in [1.5, 2.2, 2.9] {
            let slope = (reference.at(t + h).0 - reference.at(t - h).0) / (2.0 * h);
            // The polynomial's terms reach 10, times displacements of 4: roundings of 9e-15 at both
            // ends, over 2 h.
            assert!((slope - reference.at(t).1).norm() < 1e-8, "{t}");
        }
    }
}
