//! What avoidance did and what it took.

/// Work and effect since the start.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct AvoidanceStatistics {
    /// Cycles.
    pub cycles: u64,
    /// Of these, those between the regular ones: a joint moved as its last test did not foresee.
    pub early: u64,
    /// Cycles in which a joint could not go where the tasks want it.
    pub blocked: u64,
    /// Postures tested.
    pub tests: u64,
    /// Most postures tested in one cycle.
    pub tests_max: u64,
    /// Postures tested in the last cycle.
    pub tests_last: u64,
    /// Ticks of joints: one for each joint that follows its command at each tick.
    pub ticks: u64,
    /// Of these, those of joints that were stopped by a method, or asked something else by more than 1 mrad or mm.
    pub held_back: u64,
    /// Sum of the squares of the differences between asked and wanted over them.
    pub squares: f64,
    /// The greatest difference, rad or m.
    pub greatest: f64,
}

impl AvoidanceStatistics {
    /// Postures tested in a cycle, on average; none without cycles.
    pub fn tests_mean(&self) -> Option<f64> {
        (self.cycles > 0).then(|| self.tests as f64 / self.cycles as f64)
    }

    /// Root mean square of the difference between what is asked and what is wanted, over joints and ticks, rad or m.
    pub fn deviation(&self) -> Option<f64> {
        (self.ticks > 0).then(|| (self.squares / self.ticks as f64).sqrt())
    }

    /// Share of the joints' time in which they were kept from where the tasks want them.
    pub fn held_share(&self) -> Option<f64> {
        (self.ticks > 0).then(|| self.held_back as f64 / self.ticks as f64)
    }
}
