//! Early termination: divergence, too many events, a fallen robot.

use super::plant::Plant;
use super::report::Outcome;
use super::run_error::RunError;

/// Events per simulated second beyond which a run has stalled.
const STALL_RATE: u64 = 5_000;
/// Successive events without progress in time beyond which a run has stalled.
const STALL_AT_INSTANT: u64 = 200;
/// Speeds (m/s, rad/s) and positions (m) beyond this mean divergence.
const PLAUSIBLE: f64 = 1e6;

/// A `diverged` error at the plant's present time.
pub fn diverged(plant: &Plant, what: &str) -> RunError {
    RunError::new(Outcome::Diverged, format!("{what} at {:.6} s", plant.state.time))
}

/// Fails when a number of the state is not finite or not plausible, and names the first one.
pub fn check_finite(plant: &Plant) -> Result<(), RunError> {
    let (state, model) = (&plant.state, &plant.model);
    let implausible = |x: &f64| !(x.abs() < PLAUSIBLE);
    if let Some(i) = state.v.iter().position(implausible) {
        let nb = model.nb();
        let name = if i < nb { "base" } else { model.joints[i - nb].name.as_str() };
        return Err(diverged(plant, &format!("velocity of {name} is {:e}", state.v[i])));
    }
    if let Some(x) = state.position.iter().chain(&state.joints).find(|x| implausible(x)) {
        return Err(diverged(plant, &format!("a position is {x:e}")));
    }
    for object in &plant.objects.list {
        let state = &object.state;
        if let Some(x) = state.v.iter().chain(state.position.iter()).find(|x| implausible(x)) {
            return Err(diverged(plant, &format!("a velocity or position of `{}` is {x:e}", object.name)));
        }
    }
    Ok(())
}

/// Counts events and fails when there are too many.
#[derive(Clone, Copy, Debug)]
pub struct StallGuard {
    /// Start of the present second, s, and events since.
    second: (f64, u64),
    /// Present instant, s, and events at it.
    instant: (f64, u64),
}

impl Default for StallGuard {
    fn default() -> Self {
        StallGuard { second: (0.0, 0), instant: (-1.0, 0) }
    }
}

impl StallGuard {
    /// Counts an event at time `t`.
    pub fn count(&mut self, t: f64) -> Result<(), RunError> {
        if t - self.second.0 >= 1.0 {
            self.second = (t, 0);
        }
        self.second.1 += 1;
        if self.second.1 > STALL_RATE {
            return Err(RunError::new(
                Outcome::Stalled,
                format!(
                    "more than {STALL_RATE} contact events within one second before {t:.6} s; a larger \
                     contact.velocity_tolerance ends bouncing and rocking sooner"
                ),
            ));
        }
        self.count_at_instant(t)
    }

    /// Counts an event at time `t` that does not count per second.
    pub fn count_at_instant(&mut self, t: f64) -> Result<(), RunError> {
        self.instant = if t - self.instant.0 > 1e-12 { (t, 1) } else { (self.instant.0, self.instant.1 + 1) };
        if self.instant.1 > STALL_AT_INSTANT {
            let message = format!("{STALL_AT_INSTANT} events without progress at {t:.9} s");
            return Err(RunError::new(Outcome::Stalled, message));
        }
        Ok(())
    }
}
