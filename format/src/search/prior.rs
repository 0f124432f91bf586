//! Where a change is expected on a lattice, to divide it into parts of equal probability.
//!
//! The density is `(1 - w) / (2 s (1 + |x - x0| / s)^2) + w / n` for an expected position x0, a scale
//! s and n intervals. Its tails are so heavy, and its uniform part so large, that a wrong expectation
//! costs a few additional probes only. It is rational: its bits are the same on every processor.

/// Weight of the uniform part.
const UNIFORM: f64 = 0.1;

/// Fraction of the lattice that is the scale.
const SCALE: f64 = 1.0 / 16.0;

/// An expected position of a change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    /// The position, in steps of the lattice.
    pub at: f64,
    /// True if the condition is expected to hold below it.
    pub below: bool,
}

impl Prior {
    /// The distance within which the density hardly changes, in steps of a lattice of `last` steps.
    pub(super) fn scale(last: u64) -> f64 {
        (last as f64 * SCALE).max(1.0)
    }

    /// The probability that the change is below a position.
    fn below(&self, x: f64, last: u64) -> f64 {
        let distance = (x - self.at) / Self::scale(last);
        let near = match distance < 0.0 {
            true => 0.5 / (1.0 - distance),
            false => 1.0 - 0.5 / (1.0 + distance),
        };
        (1.0 - UNIFORM) * near + UNIFORM * (x + 1.0) / (last as f64 + 2.0)
    }

    /// The position between two others, exclusive, that divides the probability between them best.
    pub(super) fn median(&self, from: i64, to: i64, last: u64) -> i64 {
        let half = 0.5 * (self.below(from as f64, last) + self.below(to as f64, last));
        let (mut low, mut high) = (from, to);
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if self.below(middle as f64, last) <= half { low = middle } else { high = middle }
        }
        // The first of them, unless the second is nearer to one half.
        let error = |x: i64| (self.below(x as f64, last) - half).abs();
        let best = if error(high) < error(low) { high } else { low };
        best.clamp(from + 1, to - 1)
    }
}
