//! Marks runs whose final base position is implausible, whatever the expectations.

use nalgebra::{Rotation3, Vector3};

use crate::batch::Job;
use crate::geometry::Plane;
use crate::robot::Base;
use crate::sim::{Metrics, Outcome};

/// Depth of the base's origin below the floor from which a run is marked, m. Only soles touch the
/// floor, so other parts of a fallen robot pass through it.
const SUNK: f64 = 1e-3;

/// Distance of the base from its start beyond which a run is marked, m.
const FAR: f64 = 1e3;

/// Beginning of the note of a marked run.
const MARK: &str = "implausible: ";

/// The note of a run that reached its end with its base below the floor or far from its start.
pub(in crate::batch) fn implausible(job: &Job, outcome: Outcome, metrics: &Metrics) -> Option<String> {
    let ended = matches!(outcome, Outcome::Passed | Outcome::Failed | Outcome::Fallen);
    if !ended || job.robot.model.base == Base::Fixed {
        return None;
    }
    let floor = &job.run.scenario.floor;
    let [roll, pitch, yaw] = floor.rpy;
    let rotation = *Rotation3::from_euler_angles(roll, pitch, yaw).matrix();
    let plane = Plane { rotation, point: Vector3::new(0.0, 0.0, floor.height) };
    reason(plane.height(&metrics.final_base_position.into()), metrics.final_base_shift_m)
        .map(|reason| format!("{MARK}{reason}"))
}

fn reason(height: f64, shift: f64) -> Option<String> {
    match () {
        () if height < -SUNK => Some(format!("at its end the base is {:.3} m below the floor", -height)),
        () if shift > FAR => Some(format!("at its end the base is {shift:.0} m from its start")),
        () => None,
    }
}

/// True if a note marks its run as implausible.
pub fn marks_implausible(note: &str) -> bool {
    note.starts_with(MARK)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_base_below_the_floor_or_far_away_is_named() {
        assert_eq!(reason(-0.25, 0.3).as_deref(), Some("at its end the base is 0.250 m below the floor"));
        assert_eq!(reason(0.25, 1234.5).as_deref(), Some("at its end the base is 1234 m from its start"));
        for (height, shift) in [(0.25, 0.0), (-1e-6, 0.0), (0.0, 100.0), (f64::NAN, f64::NAN)] {
            assert_eq!(reason(height, shift), None);
        }
        assert!(marks_implausible(&format!("{MARK}at its end")) && !marks_implausible("not compared"));
    }
}
