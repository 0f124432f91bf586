//! When a run ends before its time: it fell, left all sense, or makes no progress.

use super::error::Stop;
use super::report::{Observer, Outcome};
use super::simulation::Simulation;

/// Events per simulated second beyond which a run has stalled.
const STALL_RATE: u64 = 5_000;
/// Events in a row without progress in time beyond which a run has stalled.
const STALL_IN_PLACE: u64 = 200;
/// Speeds (m/s, rad/s) and positions (m) beyond this mean divergence.
const SENSIBLE: f64 = 1e6;

impl Simulation {
    /// Ends the run when the stop rule says that the robot fell.
    pub(super) fn check_fallen(&mut self, observer: &mut dyn Observer) -> Result<(), Stop> {
        let Some(below) = self.fallen_below else { return Ok(()) };
        let height = self.plant.floor.height(&self.plant.state.position);
        if height >= below {
            return Ok(());
        }
        let t = self.plant.state.time;
        self.metrics.first_fall_s.get_or_insert(t);
        let message = format!("base {height:.4} m above the floor at {t:.4} s, below {below} m");
        self.event(observer, "fallen", "", &message)?;
        self.snapshot_last(observer)?;
        self.plant.evaluate();
        self.tell(observer)?;
        Err(Stop::new(Outcome::Fallen, message))
    }

    /// A `diverged` stop at the present time.
    pub(super) fn diverged(&self, what: &str) -> Stop {
        Stop::new(Outcome::Diverged, format!("{what} at {:.6} s", self.plant.state.time))
    }

    /// Ends the run when the state has left all sense, naming the first number that did.
    pub(super) fn check_finite(&self) -> Result<(), Stop> {
        let state = &self.plant.state;
        let model = &self.plant.model;
        let lost = |x: &f64| !(x.abs() < SENSIBLE);
        if let Some(i) = state.v.iter().position(lost) {
            let nb = model.nb();
            let name = if i < nb { "base" } else { model.joints[i - nb].name.as_str() };
            return Err(self.diverged(&format!("velocity of {name} is {:e}", state.v[i])));
        }
        if let Some(x) = state.position.iter().chain(&state.joints).find(|x| lost(x)) {
            return Err(self.diverged(&format!("a position is {x:e}")));
        }
        Ok(())
    }

    /// Counts one event; ends the run when there are too many.
    pub(super) fn count_event(&mut self) -> Result<(), Stop> {
        let t = self.plant.state.time;
        if t - self.window.0 >= 1.0 {
            self.window = (t, 0);
        }
        self.window.1 += 1;
        if self.window.1 > STALL_RATE {
            return Err(Stop::new(
                Outcome::Stalled,
                format!(
                    "more than {STALL_RATE} contact events within one second before {t:.6} s; a larger \
                     contact.velocity_tolerance ends bouncing and rocking sooner"
                ),
            ));
        }
        self.count_in_place()
    }

    /// Ends the run when there are too many events at one instant.
    pub(super) fn count_in_place(&mut self) -> Result<(), Stop> {
        let t = self.plant.state.time;
        self.in_place = if t - self.in_place.0 > 1e-12 { (t, 1) } else { (self.in_place.0, self.in_place.1 + 1) };
        if self.in_place.1 > STALL_IN_PLACE {
            return Err(Stop::new(Outcome::Stalled, format!("{STALL_IN_PLACE} events without progress at {t:.9} s")));
        }
        Ok(())
    }
}
