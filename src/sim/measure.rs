//! Running maxima and root mean squares of the residuals, over the whole run.
//!
//! Residuals are taken at the end of every step; the energy balance at the start of the next, where the state is what it
//! goes on from. In a root mean square each value counts for the length of the step it ends:
//! `rms = sqrt(sum r_i^2 dt_i / sum dt_i)`. A step at an event is judged after the new state was chosen.

use super::simulation::Simulation;
use crate::contact::model::residual::{self, RESIDUALS};
use crate::contact::model::state::MAX_SOLES;

/// A sole that carries less than this part of the robot's weight carries nothing: rounding of a solve.
const NOTHING: f64 = 1e-9;

/// A maximum and a time-weighted mean square.
#[derive(Clone, Copy, Debug, Default)]
struct Running {
    max: f64,
    squares: f64,
}

impl Running {
    fn take(&mut self, value: f64, dt: f64) {
        self.max = self.max.max(value);
        self.squares += value * value * dt;
    }

    fn rms(&self, time: f64) -> f64 {
        if time > 0.0 { (self.squares / time).sqrt() } else { 0.0 }
    }
}

/// How a sole presses on the floor, to see flicker: its force drops to zero and returns while its gap stays closed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Press {
    /// The gap is open, or has been open since the sole was last loaded.
    #[default]
    Away,
    /// Carries load.
    Loaded,
    /// Carries none any more, the gap has not opened.
    Dropped,
}

impl Press {
    /// The next one, and whether the force flickered.
    fn next(self, loaded: bool, closed: bool) -> (Press, bool) {
        match self {
            _ if loaded => (Press::Loaded, self == Press::Dropped),
            _ if !closed => (Press::Away, false),
            Press::Away => (Press::Away, false),
            Press::Loaded | Press::Dropped => (Press::Dropped, false),
        }
    }
}

/// What is kept from step to step.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    residuals: [Running; RESIDUALS],
    energy: Running,
    press: [Press; MAX_SOLES],
    flickers: u64,
    lift: f64,
    /// Times up to which residuals and energy have been taken, s.
    taken: f64,
    balanced: f64,
}

impl Simulation {
    /// Takes the residuals at the end of a step.
    pub(super) fn measure(&mut self) {
        self.mark_step();
        let plant = &mut self.plant;
        let t = plant.state.time;
        let dt = t - std::mem::replace(&mut self.tally.taken, t);
        if plant.problem.soles.is_empty() {
            return;
        }
        plant.share_forces();
        let r = residual::evaluate(&plant.problem, &plant.states, &plant.solution);
        for (running, value) in self.tally.residuals.iter_mut().zip(r.values()) {
            running.take(value, dt);
        }
        self.tally.lift = self.tally.lift.max(r.lift);
        for (s, sole) in plant.problem.soles.iter().enumerate() {
            let load: f64 = plant.solution.normal[s].iter().sum();
            let gap = sole.vertices.iter().map(|v| v.height).fold(f64::INFINITY, f64::min);
            let (loaded, closed) = (load > NOTHING * plant.problem.scale, gap <= self.tolerances.distance);
            let (next, flickered) = self.tally.press[s].next(loaded, closed);
            self.tally.press[s] = next;
            self.tally.flickers += u64::from(flickered);
        }
    }

    /// Takes the error of the energy balance at the plant's present state, which must be evaluated.
    pub(super) fn audit(&mut self) {
        let t = self.plant.state.time;
        let dt = t - std::mem::replace(&mut self.tally.balanced, t);
        let error = self.balance().error().abs();
        self.tally.energy.take(error, dt);
    }

    /// Writes the maxima and means into the metrics, and the balance at the plant's present state.
    pub(super) fn conclude(&mut self) {
        let balance = self.balance();
        let (tally, m) = (&self.tally, &mut self.metrics);
        let [penetration, tension, signorini, cone, dissipation, creep, resultant] = &tally.residuals;
        let time = tally.taken;
        m.max_lift_m = tally.lift;
        (m.max_penetration_m, m.rms_penetration_m) = (penetration.max, penetration.rms(time));
        (m.max_tension_n, m.rms_tension_n) = (tension.max, tension.rms(time));
        (m.max_signorini_nm, m.rms_signorini_nm) = (signorini.max, signorini.rms(time));
        (m.max_cone_excess, m.rms_cone_excess_n) = (cone.max, cone.rms(time));
        (m.max_dissipation_gap_w, m.rms_dissipation_gap_w) = (dissipation.max, dissipation.rms(time));
        (m.max_creep_speed_m_per_s, m.rms_creep_speed_m_per_s) = (creep.max, creep.rms(time));
        m.max_resultant_gap_n = resultant.max;
        m.force_flickers = tally.flickers;
        (m.max_energy_error_j, m.rms_energy_error_j) = (tally.energy.max, tally.energy.rms(tally.balanced));
        m.energy_error_j = balance.error();
        m.energy_change_j = balance.change;
        m.actuator_work_j = balance.actuators;
        m.external_work_j = balance.external;
        m.joint_loss_j = balance.joint_loss;
        m.friction_loss_j = balance.friction_loss;
        m.impact_loss_j = balance.impact_loss;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Flickers in a history of (loaded, closed).
    fn flickers(history: &[(bool, bool)]) -> usize {
        let mut press = Press::default();
        let mut count = 0;
        for &(loaded, closed) in history {
            let (next, flickered) = press.next(loaded, closed);
            press = next;
            count += usize::from(flickered);
        }
        count
    }

    #[test]
    fn a_force_that_drops_and_returns_through_a_closed_gap_flickers() {
        const ON: (bool, bool) = (true, true);
        const DROP: (bool, bool) = (false, true);
        const OPEN: (bool, bool) = (false, false);
        assert_eq!(flickers(&[DROP, ON, ON, ON]), 0, "touching down");
        assert_eq!(flickers(&[ON, DROP, OPEN, OPEN, DROP, ON]), 0, "a hop: lifts off at zero force, comes back");
        assert_eq!(flickers(&[ON, DROP, DROP, DROP]), 0, "unloaded for good");
        assert_eq!(flickers(&[ON, DROP, ON, DROP, DROP, ON]), 2);
    }

    #[test]
    fn a_mean_square_weighs_values_by_their_time() {
        let mut running = Running::default();
        running.take(3.0, 0.1);
        running.take(1.0, 0.9);
        assert_eq!(running.max, 3.0);
        // sqrt(0.1 * 9 + 0.9 * 1)
        assert!((running.rms(1.0) - 1.8f64.sqrt()).abs() < 1e-15);
        assert_eq!(Running::default().rms(0.0), 0.0);
    }
}
