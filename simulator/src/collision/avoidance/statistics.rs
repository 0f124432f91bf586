//! Work and effect of avoidance over a run.

/// Counts and deviations since the start.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct AvoidanceStatistics {
    /// Planning cycles.
    pub cycles: u64,
    /// Of these, cycles between the regular ones: the last test did not cover the motion of a
    /// joint.
    pub early: u64,
    /// Cycles in which a joint could not reach its goal.
    pub blocked: u64,
    /// Postures tested.
    pub tests: u64,
    /// Most postures tested in one cycle.
    pub tests_max: u64,
    /// Postures tested in the last cycle.
    pub tests_last: u64,
    /// Ticks of joints: one for each joint that follows its command at each tick.
    pub ticks: u64,
    /// Of these, ticks of joints stopped by a method or commanded more than 1 mrad or mm from the
    /// desired position.
    pub held_back: u64,
    /// Sum over them of the squared difference between commanded and desired position.
    pub squares: f64,
    /// The greatest difference, rad or m.
    pub greatest: f64,
}

impl AvoidanceStatistics {
    /// Mean number of postures tested in a cycle; none without cycles.
    pub fn tests_mean(&self) -> Option<f64> {
        (self.cycles > 0).then(|| self.tests as f64 / self.cycles as f64)
    }

    /// Root mean square of the difference between commanded and desired position over joints and
    /// ticks, rad or m.
    pub fn deviation(&self) -> Option<f64> {
        (self.ticks > 0).then(|| (self.squares / self.ticks as f64).sqrt())
    }

    /// Fraction of the joints' ticks at which they were held back from their desired positions.
    pub fn held_share(&self) -> Option<f64> {
        (self.ticks > 0).then(|| self.held_back as f64 / self.ticks as f64)
    }
}
