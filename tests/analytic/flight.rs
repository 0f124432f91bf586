//! HOAP-2 in the air: no contact, joints driven, arms swinging.

use crate::support::runs::{finish, simulation};
use nalgebra::Vector3;
use stiction::dynamics::body;
use stiction::sim::NullObserver;

fn scenario(spin: [f64; 3], duration: f64) -> String {
    format!(
        "duration = {duration}
        integrator = {{ relative_tolerance = 1e-12, absolute_tolerance = 1e-13 }}
        [robot]
        model = \"robots/hoap2/hoap2.toml\"
        soles = []
        base = {{ position = [0.0, 0.0, 2.0], linear_velocity = [0.7, -0.3, 2.0], angular_velocity = {spin:?} }}
        velocity = {{ left_knee = 1.0, right_shoulder_pitch = -1.5 }}
        [[task]]
        type = \"posture\"
        start = 0.05
        duration = 0.3
        joints = {{ left_knee = 1.2, right_hip_roll = -0.3, waist_pitch = 0.3 }}\n"
    )
}

#[test]
fn the_centre_of_mass_follows_a_parabola_and_angular_momentum_is_conserved() {
    for spin in [[0.0, 0.0, 0.0], [0.5, -1.5, 2.0]] {
        let duration = 0.4;
        let mut sim = simulation(&scenario(spin, duration));
        let (start, before) = (body::center_of_mass(&sim.plant().ws), body::momentum(&sim.plant().ws));
        let velocity = body::center_of_mass_velocity(&sim.plant().ws);
        let m = finish(&mut sim, &mut NullObserver);
        let (end, after) = (body::center_of_mass(&sim.plant().ws), body::momentum(&sim.plant().ws));
        let fall = Vector3::new(0.0, 0.0, -9.81);
        // Integration at relative tolerance 1e-12 over about a thousand steps.
        let parabola = start + velocity * duration + fall * (0.5 * duration * duration);
        assert!((end - parabola).norm() < 1e-10, "{}", (end - parabola).norm());
        let size = before.angular.norm();
        assert!(size > 1e-3);
        assert!((after.angular - before.angular).norm() < 1e-10 * size, "{}", (after.angular - before.angular).norm());
        let mass = sim.plant().model.mass();
        assert!((after.linear - before.linear - fall * (mass * duration)).norm() < 1e-10 * after.linear.norm());
        // Energy against the work of the drives, an integral computed along with the state.
        assert!(m.energy_error_j.abs() < 1e-9, "{}", m.energy_error_j);
        // The drives did some work.
        assert!(sim.plant().state.joints.iter().zip(&sim.plant().model.home).any(|(q, home)| (q - home).abs() > 0.1));
    }
}
