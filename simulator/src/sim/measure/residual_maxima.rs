//! Running maxima and root mean squares of the residuals and the energy error over a run.
//!
//! Residuals are evaluated at the end of every step, after a new contact state is chosen at an
//! event. The energy balance is evaluated at the start of the next step, from the state that it
//! integrates. In a root mean square each value is weighted by the length of the step it ends:
//! `rms = sqrt(sum r_i^2 dt_i / sum dt_i)`.

use super::energy_balance::EnergyBalance;
use crate::contact::model::per_sole::PerSole;
use crate::contact::model::residual::RESIDUALS;
use crate::math;
use crate::sim::plant::Plant;
use crate::sim::report::Metrics;

/// A sole that carries less than this fraction of the robot's weight is unloaded: solver rounding.
const UNLOADED: f64 = 1e-9;

/// A maximum and a time-weighted mean square.
#[derive(Clone, Copy, Debug, Default)]
struct RunningError {
    max: f64,
    squares: f64,
}

impl RunningError {
    fn add(&mut self, value: f64, dt: f64) {
        self.max = math::greater(self.max, value);
        self.squares += value * value * dt;
    }

    fn rms(&self, time: f64) -> f64 {
        if time > 0.0 { (self.squares / time).sqrt() } else { 0.0 }
    }
}

/// Loading of a sole, to detect flicker: its force drops to zero and returns while its gap stays
/// closed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Loading {
    /// The gap is open, or has been open since the sole was last loaded.
    #[default]
    Away,
    /// Carries load.
    Loaded,
    /// Unloaded, and the gap has not opened since.
    Dropped,
}

impl Loading {
    /// The loading at the next step, and whether the force flickered.
    fn next(self, loaded: bool, closed: bool) -> (Loading, bool) {
        match self {
            _ if loaded => (Loading::Loaded, self == Loading::Dropped),
            _ if !closed => (Loading::Away, false),
            Loading::Away => (Loading::Away, false),
            Loading::Loaded | Loading::Dropped => (Loading::Dropped, false),
        }
    }
}

/// Maxima and mean squares so far.
#[derive(Clone, Debug, Default)]
pub struct ResidualMaxima {
    residuals: [RunningError; RESIDUALS],
    energy: RunningError,
    contact: PerSole<Loading>,
    flickers: u64,
    /// Greatest height of the lowest vertex of the robot's soles, m; none without soles.
    lift: Option<f64>,
    /// Times up to which residuals and energy have been recorded, s.
    residual_time: f64,
    energy_time: f64,
}

impl ResidualMaxima {
    /// Records the residuals at the end of a step. `distance` is the tolerance d of closed gaps, m.
    pub fn record_step(&mut self, plant: &mut Plant, distance: f64) {
        let t = plant.state.time;
        let dt = t - std::mem::replace(&mut self.residual_time, t);
        self.record_lift(plant);
        if plant.problem.soles.is_empty() {
            return;
        }
        let r = plant.residual();
        for (running, value) in self.residuals.iter_mut().zip(r.values()) {
            running.add(value, dt);
        }
        for (s, sole) in plant.problem.soles.iter().enumerate() {
            let load: f64 = plant.solution.normal[s].iter().sum();
            let gap = sole.vertices.iter().map(|v| v.height).fold(f64::INFINITY, f64::min);
            let (loaded, closed) = (load > UNLOADED * plant.problem.scale, gap <= distance);
            let (next, flickered) = self.contact[s].next(loaded, closed);
            self.contact[s] = next;
            self.flickers += u64::from(flickered);
        }
    }

    fn record_lift(&mut self, plant: &Plant) {
        let soles = &plant.problem.soles[..plant.model.soles.len().min(plant.problem.soles.len())];
        let lowest = soles.iter().flat_map(|sole| &sole.vertices).map(|v| v.height).reduce(f64::min);
        self.lift = lowest.map_or(self.lift, |lowest| Some(math::greater(self.lift.unwrap_or(0.0), lowest)));
    }

    /// Continues with other polygons, `number` in all; `former` gives the former index of each that was
    /// there before.
    pub fn replace_polygons(&mut self, number: usize, former: impl Fn(usize) -> Option<usize>) {
        let before = std::mem::take(&mut self.contact);
        for s in 0..number {
            if let Some(former) = former(s) {
                self.contact[s] = before[former];
            }
        }
    }

    /// Records the error of the energy balance at time `t`, s.
    pub fn record_energy_error(&mut self, t: f64, error: f64) {
        let dt = t - std::mem::replace(&mut self.energy_time, t);
        self.energy.add(error.abs(), dt);
    }

    /// Writes maxima, root mean squares and the balance at the end into the metrics.
    pub fn write(&self, balance: &EnergyBalance, m: &mut Metrics) {
        let [penetration, tension, signorini, cone, dissipation, creep, resultant] = &self.residuals;
        let time = self.residual_time;
        m.max_lift_m = self.lift;
        (m.max_penetration_m, m.rms_penetration_m) = (penetration.max, penetration.rms(time));
        (m.max_tension_n, m.rms_tension_n) = (tension.max, tension.rms(time));
        (m.max_signorini_nm, m.rms_signorini_nm) = (signorini.max, signorini.rms(time));
        (m.max_cone_excess, m.rms_cone_excess_n) = (cone.max, cone.rms(time));
        (m.max_dissipation_gap_w, m.rms_dissipation_gap_w) = (dissipation.max, dissipation.rms(time));
        (m.max_creep_speed_m_per_s, m.rms_creep_speed_m_per_s) = (creep.max, creep.rms(time));
        m.max_resultant_gap_n = resultant.max;
        m.force_flickers = self.flickers;
        (m.max_energy_error_j, m.rms_energy_error_j) = (self.energy.max, self.energy.rms(self.energy_time));
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
        let mut loading = Loading::default();
        let mut count = 0;
        for &(loaded, closed) in history {
            let (next, flickered) = loading.next(loaded, closed);
            loading = next;
            count += usize::from(flickered);
        }
        count
    }

    #[test]
    fn force_that_drops_and_returns_while_the_gap_is_closed_flickers() {
        const ON: (bool, bool) = (true, true);
        const DROP: (bool, bool) = (false, true);
        const OPEN: (bool, bool) = (false, false);
        assert_eq!(flickers(&[DROP, ON, ON, ON]), 0, "touching down");
        assert_eq!(flickers(&[ON, DROP, OPEN, OPEN, DROP, ON]), 0, "a hop: lifts off at zero force, comes back");
        assert_eq!(flickers(&[ON, DROP, DROP, DROP]), 0, "unloaded for good");
        assert_eq!(flickers(&[ON, DROP, ON, DROP, DROP, ON]), 2);
    }

    #[test]
    fn mean_square_weights_values_by_their_time() {
        let mut running = RunningError::default();
        running.add(3.0, 0.1);
        running.add(1.0, 0.9);
        assert_eq!(running.max, 3.0);
        // sqrt(0.1 * 9 + 0.9 * 1)
        assert!((running.rms(1.0) - 1.8f64.sqrt()).abs() < 1e-15);
        assert_eq!(RunningError::default().rms(0.0), 0.0);
    }
}
