//! A force that jumps with the state: a joint reaches its stop.

use super::{NO_COMMANDS, robot, simulation};
use crate::support::runs::{Recording, finish};

/// A foot of 1 kg and a slider of 1 kg on it that may rise by 0.1 m.
fn hopper() -> String {
    let link = |name: &str| {
        format!(
            "<link name=\"{name}\"><inertial><mass value=\"1\"/>
            <inertia ixx=\"0.01\" iyy=\"0.01\" izz=\"0.01\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>"
        )
    };
    let slide =
        "<joint name=\"slide\" type=\"prismatic\"><parent link=\"foot\"/><child link=\"mass\"/><axis xyz=\"0 0 1\"/>
        <limit lower=\"0\" upper=\"0.1\" effort=\"1000\" velocity=\"1000\"/></joint>"
            .to_owned();
    robot(&[link("foot"), link("mass"), slide])
}

/// The slider starts upwards at 2 m/s and reaches its stop. The stop's damper then pulls with b
/// sqrt(v^2 - 2 g d) = 143 N, 15 times the weight of the foot. The foot leaves the floor at that
/// instant, t = (v - sqrt(v^2 - 2 g d)) / g.
#[test]
fn a_joint_stop_lifts_the_foot_off_the_floor() {
    const G: f64 = 9.81;
    let text = "duration = 0.15
        [robot]
        model = \"hopper.urdf\"
        soles = [{ name = \"sole\", link = \"foot\", polygon = [[0.1, 0.1, 0], [-0.1, 0.1, 0], [-0.1, -0.1, 0], [0.1, -0.1, 0]] }]
        velocity = { slide = 2.0 }
        joint = { slide = { mode = \"passive\", stop = { stiffness = 1e4, damping = 100.0 } } }";
    let mut sim = simulation(Some(&hopper()), text, NO_COMMANDS);
    let metrics = finish(&mut sim, &mut Recording::default());
    let at = (2.0 - (4.0 - 2.0 * G * 0.1_f64).sqrt()) / G;
    let left = metrics.first_liftoff_s.expect("it lifts off");
    // Up to a few steps of 1e-13 s beyond the stop; before it the motion is a parabola, which the
    // integrator solves.
    assert!((left - at).abs() < 2e-12, "{left} instead of {at}");
    // The slider had all its momentum, less the impulse of its weight; from then on both fly,
    // whatever the stop does.
    let v = &sim.plant().state.v;
    let momentum = v[2] + (v[2] + v[6]);
    let expected = (2.0 - G * at) - 2.0 * G * (0.15 - at);
    // The step across the jump, some 1e-13 s, still has the floor hold the foot down by 133 N in
    // part of its stages.
    assert!((momentum - expected).abs() < 1e-10, "{momentum} instead of {expected}");
}
