//! Geared motors by closed forms: a pendulum with one motor, and a ball on two crossing axes that two motors turn
//! through a differential.

use super::{NO_COMMANDS, simulation};
use crate::analytic::body::G;
use crate::support::runs::{Recording, finish, rk4};
use nalgebra::{Matrix2, Vector2};
use stiction::sim::{Metrics, Simulation};
use tempfile::TempDir;

/// A robot file next to its URDF.
struct Robot(TempDir);

impl Robot {
    fn new(urdf: &str, more: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
        write("robot.urdf", urdf);
        write("robot.toml", &format!("urdf = \"robot.urdf\"\n{more}"));
        Robot(folder)
    }

    fn path(&self) -> String {
        format!("{:?}", self.0.path().join("robot.toml"))
    }
}

/// Mass, distance of the centre, moment of inertia about the pivot.
const PENDULUM: (f64, f64, f64) = (1.0, 0.25, 0.08);

fn pendulum(more: &str) -> Robot {
    let (mass, distance, inertia) = PENDULUM;
    let own = inertia - mass * distance * distance;
    let urdf = format!(
        "<robot name=\"pendulum\"><link name=\"world\"/>
         <link name=\"rod\"><inertial><origin xyz=\"0 0 -{distance}\"/><mass value=\"{mass}\"/>
         <inertia ixx=\"{own}\" iyy=\"{own}\" izz=\"{own}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>
         <joint name=\"hinge\" type=\"revolute\"><parent link=\"world\"/><child link=\"rod\"/><axis xyz=\"0 1 0\"/>
         <limit lower=\"-9\" upper=\"9\" effort=\"100\" velocity=\"100\"/><dynamics damping=\"0.3\" friction=\"0.2\"/>
         </joint></robot>"
    );
    Robot::new(&urdf, more)
}

/// Moment of inertia of the ball about each axis through its centre.
const INERTIA: f64 = 0.2;
/// Matrix and gear ratio of the differential.
const MATRIX: [[f64; 2]; 2] = [[1.0, 1.0], [1.0, -1.0]];
const RATIO: f64 = 50.0;

/// The speeds of the motors by those of pitch and roll.
fn gear() -> Matrix2<f64> {
    Matrix2::new(MATRIX[0][0], MATRIX[0][1], MATRIX[1][0], MATRIX[1][1]) * RATIO
}

/// A ball with its centre on the axes of pitch and roll, which stay perpendicular: M is its moment of inertia times
/// the unit matrix, and nothing else acts.
fn ball(joint: &str, transmission: &str) -> Robot {
    let hinge = |name: &str, parent: &str, child: &str, axis: &str| {
        format!(
            "<joint name=\"{name}\" type=\"continuous\"><parent link=\"{parent}\"/><child link=\"{child}\"/>
             <axis xyz=\"{axis}\"/></joint>"
        )
    };
    let urdf = format!(
        "<robot name=\"ball\"><link name=\"world\"/><link name=\"cross\"/><link name=\"ball\"><inertial>
         <mass value=\"1\"/><inertia ixx=\"{0}\" iyy=\"{0}\" izz=\"{0}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>
         {1}{2}</robot>",
        INERTIA,
        hinge("pitch", "world", "cross", "0 1 0"),
        hinge("roll", "cross", "ball", "1 0 0"),
    );
    Robot::new(
        &urdf,
        &format!(
            "joint_default = {{ {joint} }}
            [[transmission]]
            name = \"ankle\"
            joints = [\"pitch\", \"roll\"]
            matrix = {MATRIX:?}
            gear_ratio = {RATIO}
            {transmission}\n"
        ),
    )
}

/// Adaptive methods, explicit and implicit, and steps of the velocity level.
const DOPRI5: &str = "{ relative_tolerance = 1e-10, absolute_tolerance = 1e-12 }";
const ROSENBROCK: &str = "{ method = \"rosenbrock\", relative_tolerance = 1e-8, absolute_tolerance = 1e-9 }";
const FIXED: &str = "{ method = \"semi-implicit\", step = 1e-3 }";

fn run(
    robot: &Robot,
    integrator: &str,
    more: &str,
    start: &str,
    command: Option<impl Fn(usize, f64) -> [f64; 3] + Send + 'static>,
) -> (Simulation, Metrics, Recording) {
    let mut sim = simulation(
        None,
        &format!(
            "duration = 0.5
            log.rate = 200.0
            floor.plane = false
            integrator = {integrator}
            {more}
            [robot]
            model = {}
            soles = []
            {start}\n",
            robot.path()
        ),
        command,
    );
    let mut recording = Recording::default();
    let metrics = finish(&mut sim, &mut recording);
    (sim, metrics, recording)
}

#[test]
fn a_geared_pendulum_swings_with_its_rotor() {
    let (mass, distance, inertia) = PENDULUM;
    let robot = pendulum(
        "[[transmission]]
        name = \"gear\"
        joints = [\"hinge\"]
        gear_ratio = 50.0
        rotor_inertia = 2e-5
        friction = {}
        [joint_default]
        mode = \"passive\"\n",
    );
    let integrator = "{ relative_tolerance = 1e-12, absolute_tolerance = 1e-13 }";
    let start = "posture.hinge = 0.7\nvelocity.hinge = -2.0";
    let (sim, metrics, _) = run(&robot, integrator, "", start, NO_COMMANDS);
    // (I + N^2 J) q'' = -m g l sin q
    let whole = inertia + 50.0 * 50.0 * 2e-5;
    let truth = rk4([0.7, -2.0], 0.5, 50_000, |_, s| [s[1], -mass * G * distance * s[0].sin() / whole]);
    let state = &sim.plant().state;
    // Accumulated error of integration.
    assert!((state.joints[0] - truth[0]).abs() < 1e-10, "{} {}", state.joints[0], truth[0]);
    assert!((state.v[0] - truth[1]).abs() < 1e-10, "{} {}", state.v[0], truth[1]);
    assert!(metrics.max_energy_error_j < 1e-11, "{metrics:?}");
}

/// A motor of one joint is a setting of the joint.
#[test]
fn one_motor_gives_the_bits_of_the_settings_of_its_joint() {
    let (n, c, d) = (30.0, 0.01, 2e-5);
    let servo = "kp = 200.0, kd = 2.0";
    let geared = pendulum(&format!(
        "joint.hinge = {{ {servo} }}
        [[transmission]]
        name = \"gear\"
        joints = [\"hinge\"]
        matrix = [[-1.0]]
        gear_ratio = {n}
        rotor_inertia = 3e-5
        effort = 0.2
        velocity = 90.0
        friction = {{ coulomb = {c}, viscous = {d}, static = 0.015, slip_velocity = 0.6 }}\n"
    ));
    let plain = pendulum(&format!(
        "[joint.hinge]
        {}
        armature = {:?}
        effort = {:?}
        velocity = {:?}
        friction = {{ coulomb = {:?}, viscous = {:?}, static = {:?}, stribeck_velocity = {:?}, slip_velocity = {:?} }}\n",
        servo.replace(", ", "\n"),
        n * n * 3e-5,
        n * 0.2,
        90.0 / n,
        n * c,
        n * n * d,
        n * 0.015,
        0.2,
        0.6 / n,
    ));
    let task = "task = [{ type = \"sine\", joints = { hinge = { amplitude = 0.5, frequency = 2.0 } } }]";
    for integrator in [DOPRI5, ROSENBROCK, FIXED] {
        let ends = [&geared, &plain].map(|robot| {
            let (sim, metrics, recording) = run(robot, integrator, task, "", NO_COMMANDS);
            let (state, last) = (&sim.plant().state, recording.snapshots.last().expect("one"));
            let numbers = [state.joints[0], state.v[0], last.effort[0], metrics.actuator_work_j, metrics.joint_loss_j];
            assert!(recording.snapshots.iter().any(|s| s.effort[0] != s.effort_desired[0]), "no limit acts");
            numbers.map(f64::to_bits)
        });
        assert_eq!(ends[0], ends[1], "{integrator}");
    }
}

/// `(M + T^T J T) q'' = tau` with constant efforts; motors that differ couple the joints.
#[test]
fn rotors_couple_the_joints_that_they_turn() {
    let robot = ball("mode = \"force\"", "rotor_inertia = [2e-5, 5e-5]");
    let (tau, t) = (Vector2::new(0.7, -0.3), gear());
    let rotors = Matrix2::new(2e-5, 0.0, 0.0, 5e-5);
    let mass = Matrix2::identity() * INERTIA + t.transpose() * rotors * t;
    let acceleration = mass.try_inverse().expect("regular") * tau;
    for (integrator, tolerance) in [(DOPRI5, 1e-11), (ROSENBROCK, 1e-9), (FIXED, 1e-12)] {
        let command = move |j: usize, _| [0.0, 0.0, tau[j]];
        let (sim, metrics, _) = run(&robot, integrator, "", "", Some(command));
        let state = &sim.plant().state;
        for j in 0..2 {
            // Integration; velocities of steps are exact up to rounding.
            assert!(
                (state.v[j] - 0.5 * acceleration[j]).abs() < tolerance,
                "{integrator}: {} {acceleration}",
                state.v[j]
            );
        }
        // Energy of ball and rotors is the work of the drives.
        assert!(metrics.max_energy_error_j < tolerance, "{metrics:?}");
        let speeds = t * Vector2::new(state.v[0], state.v[1]);
        let energy = 0.5 * (INERTIA * (state.v[0].powi(2) + state.v[1].powi(2)) + speeds.dot(&(rotors * speeds)));
        assert!((metrics.actuator_work_j - energy).abs() < tolerance, "{} {energy}", metrics.actuator_work_j);
    }
}

/// Torques of the motors, clamped, as efforts of the joints.
fn clamped(tau: Vector2<f64>, most: f64) -> (Vector2<f64>, Vector2<f64>) {
    let torques = gear().transpose().try_inverse().expect("regular") * tau;
    let torques = torques.map(|m| m.clamp(-most, most));
    (torques, gear().transpose() * torques)
}

#[test]
fn one_motor_saturates_and_the_other_does_not() {
    let robot = ball("mode = \"force\"", "rotor_inertia = [2e-5, 5e-5]\neffort = 0.1");
    // Torques of 0.15 and 0.05 N m.
    let tau = Vector2::new(10.0, 5.0);
    let (torques, efforts) = clamped(tau, 0.1);
    assert_eq!((torques[0], (torques[1] - 0.05).abs() < 1e-15), (0.1, true));
    for integrator in [DOPRI5, ROSENBROCK, FIXED] {
        let (_, metrics, recording) = run(&robot, integrator, "", "", Some(move |j: usize, _| [0.0, 0.0, tau[j]]));
        // The first snapshot of velocity-level steps precedes the first command.
        for s in recording.snapshots.iter().skip(1) {
            for j in 0..2 {
                // Rounding of both inverses.
                assert!((s.effort[j] - efforts[j]).abs() < 1e-14, "{integrator}: {:?} {efforts}", s.effort);
                assert_eq!(s.effort_desired[j], tau[j]);
            }
        }
        assert!(metrics.max_energy_error_j < 1e-9, "{metrics:?}");
    }
}

/// Position servos whose motors saturate on the way: continuous efforts are `T^T clamp(T^-T tau)` at each instant,
/// those of steps are means within the limits.
#[test]
fn servos_saturate_at_their_motors() {
    let (kp, kd, most) = (400.0, 20.0, 0.4);
    let robot = ball(&format!("kp = {kp}, kd = {kd}"), &format!("rotor_inertia = 2e-5\neffort = {most}"));
    let target = Vector2::new(0.2, 0.1);
    for integrator in [DOPRI5, ROSENBROCK, FIXED] {
        let (sim, metrics, recording) = run(&robot, integrator, "", "", Some(move |j: usize, _| [target[j], 0.0, 0.0]));
        let mut partly = 0;
        for s in recording.snapshots.iter().skip(1) {
            let (q, v, effort) = ([s.q[0], s.q[1]], [s.qd[0], s.qd[1]], Vector2::new(s.effort[0], s.effort[1]));
            let desired = (target - Vector2::from(q)) * kp - Vector2::from(v) * kd;
            let (torques, efforts) = clamped(desired, most);
            let full = torques.map(|m| f64::from(m.abs() == most)).sum();
            partly += usize::from(full == 1.0);
            // Rounding; a step ends with the mean of its efforts instead.
            let (own, tolerance) = if integrator == FIXED {
                (gear().transpose().try_inverse().expect("regular") * effort, most * (1.0 + 1e-14))
            } else {
                ((effort - efforts) / effort.norm().max(1.0), 1e-13)
            };
            assert!(own.amax() <= tolerance, "{integrator} {}: {effort} {efforts}", s.time);
        }
        assert!(partly > 3, "{integrator}: {partly} logged instants with one motor at its limit");
        let state = &sim.plant().state;
        // The slowest mode, 20 to 25 1/s with the rotors, has 1e-3 left at most after its saturation.
        for j in 0..2 {
            assert!((state.joints[j] - target[j]).abs() < 2e-3, "{integrator}: {:?}", state.joints);
        }
        let tolerance = if integrator == ROSENBROCK { 1e-6 } else { 1e-9 };
        assert!(metrics.max_energy_error_j < tolerance, "{integrator}: {metrics:?}");
    }
}

/// Stiff gains and few steps: steps are stable while one motor is at its limit, and tend to the solution of the
/// adaptive method.
#[test]
fn stiff_servos_are_stable_with_a_saturated_motor() {
    let robot = ball("kp = 2e4, kd = 2e2", "rotor_inertia = [2e-5, 5e-5]\neffort = [0.2, 5.0]");
    let target = Vector2::new(0.2, 0.1);
    // Steps end at ticks.
    let slow = "control.rate = 50.0";
    let end = |integrator: &str| {
        let (sim, metrics, recording) =
            run(&robot, integrator, slow, "", Some(move |j: usize, _| [target[j], 0.0, 0.0]));
        let at = recording.snapshots.iter().find(|s| s.time > 0.0999).expect("a snapshot");
        (Vector2::new(at.q[0], at.q[1]), metrics, sim.plant().state.joints.clone())
    };
    let (truth, adaptive, _) = end(DOPRI5);
    let errors = [2e-3, 2.5e-4, 1.25e-4, 6.25e-5].map(|step| {
        let (at, metrics, last) = end(&format!("{{ method = \"semi-implicit\", step = {step} }}"));
        // The energy of each step is balanced.
        assert!(metrics.max_energy_error_j < 1e-10, "{metrics:?}");
        assert!(last.iter().zip(target.iter()).all(|(q, to)| (q - to).abs() < 1e-2), "{last:?}");
        (at - truth).norm()
    });
    // First order, where steps resolve the instants at which the motor leaves its limit.
    assert!(errors[0] < 5e-3 && errors[1] / errors[2] > 1.8 && errors[2] / errors[3] > 1.8, "{errors:?}");
    let (stiff, implicit, _) = end(ROSENBROCK);
    // Tolerance of the method over its steps.
    assert!((stiff - truth).norm() < 1e-5, "{stiff} {truth}");
    assert!(adaptive.max_energy_error_j < 1e-6 && implicit.max_energy_error_j < 1e-4, "{adaptive:?} {implicit:?}");
}

/// One motor alone feels the inertia `1 / (T M^-1 T^T)`; over the last tenth of its speed range its torque falls
/// to zero.
#[test]
fn a_motor_does_not_push_beyond_its_speed_limit() {
    let (speed, torque) = (150.0, 0.1);
    let robot = ball("mode = \"force\"", &format!("velocity = {speed}"));
    let tau = gear().transpose() * Vector2::new(torque, 0.0);
    let felt = INERTIA / (2.0 * RATIO * RATIO);
    let (border, rate) = (0.9 * speed * felt / torque, torque / (felt * 0.1 * speed));
    let truth = |t: f64| match t {
        t if t < border => torque * t / felt,
        t => speed - 0.1 * speed * (-rate * (t - border)).exp(),
    };
    assert!(border < 0.3);
    // A step of the first order; its last third is exact at the limit.
    for (integrator, tolerance) in [(DOPRI5, 1e-7), (ROSENBROCK, 1e-4), (FIXED, 2.0)] {
        let (_, metrics, recording) = run(&robot, integrator, "", "", Some(move |j: usize, _| [0.0, 0.0, tau[j]]));
        for s in recording.snapshots.iter().skip(1) {
            let speeds = gear() * Vector2::new(s.qd[0], s.qd[1]);
            assert!(
                (speeds[0] - truth(s.time)).abs() < tolerance,
                "{integrator} {}: {speeds} {}",
                s.time,
                truth(s.time)
            );
            // The other motor rests.
            assert!(speeds[1].abs() < 1e-9 && speeds[0] < speed * (1.0 + 1e-12), "{speeds}");
        }
        assert!(metrics.max_energy_error_j < tolerance.min(1e-4), "{metrics:?}");
    }
}

/// `theta'' = -d theta' / J_k` for each motor, J_k its inertia with the ball.
#[test]
fn viscous_friction_of_a_motor_lets_it_coast_exponentially() {
    let (d, j) = (1e-4, 2e-5);
    let robot = ball("mode = \"passive\"", &format!("rotor_inertia = {j}\nfriction.viscous = {d}"));
    let inertia = INERTIA / (2.0 * RATIO * RATIO) + j;
    for (integrator, tolerance) in [(DOPRI5, 1e-7), (ROSENBROCK, 1e-4)] {
        let (_, metrics, recording) =
            run(&robot, integrator, "", "velocity = { pitch = 2.0, roll = -0.5 }", NO_COMMANDS);
        for s in &recording.snapshots {
            let speeds = gear() * Vector2::new(s.qd[0], s.qd[1]);
            let truth = gear() * Vector2::new(2.0, -0.5) * (-d * s.time / inertia).exp();
            // Integration of speeds of 100 rad/s.
            assert!((speeds - truth).amax() < tolerance, "{integrator} {}: {speeds} {truth}", s.time);
        }
        assert!(metrics.max_energy_error_j < tolerance, "{metrics:?}");
    }
    // Implicit steps divide the speed by 1 + d dt / J_k.
    let (sim, metrics, _) = run(&robot, FIXED, "", "velocity = { pitch = 2.0, roll = -0.5 }", NO_COMMANDS);
    let factor = (1.0 + d * 1e-3 / inertia).powi(-500);
    for (v, start) in sim.plant().state.v.iter().zip([2.0, -0.5]) {
        // Rounding of 500 steps.
        assert!((v - start * factor).abs() < 1e-12, "{v} {}", start * factor);
    }
    assert!(metrics.max_energy_error_j < 1e-13 && metrics.joint_loss_j > 0.3, "{metrics:?}");
}

/// `theta'' = -c tanh(theta' / v_s) / J_k`: `sinh(theta' / v_s)` decays exponentially; the motor stops at
/// `J_k theta'_0 / c`. The other motor, which rests, has no friction.
#[test]
fn coulomb_friction_stops_a_motor_in_time() {
    let (c, slip, start) = (0.02, 0.5, 100.0);
    let robot = ball("mode = \"passive\"", &format!("friction = {{ coulomb = {c}, slip_velocity = {slip} }}"));
    let inertia = INERTIA / (2.0 * RATIO * RATIO);
    let stop = inertia * start / c;
    assert!(stop < 0.3);
    let joints = gear().try_inverse().expect("regular") * Vector2::new(start, 0.0);
    let at = format!("velocity = {{ pitch = {:?}, roll = {:?} }}", joints[0], joints[1]);
    // asinh(sinh(x) exp(-y)) without overflow.
    let truth = |t: f64| {
        let (x, y): (f64, f64) = (start / slip, c * t / (inertia * slip));
        if x - y > 30.0 { (x - y) * slip } else { ((x - y).exp() / 2.0).asinh() * slip }
    };
    for (integrator, tolerance) in [(DOPRI5, 1e-7), (ROSENBROCK, 1e-3), (FIXED, 2.0)] {
        let (sim, metrics, recording) = run(&robot, integrator, "", &at, NO_COMMANDS);
        for s in &recording.snapshots {
            let speeds = gear() * Vector2::new(s.qd[0], s.qd[1]);
            // Integration; friction at the step's end is c theta'+ / theta', short by c dt / (J_k theta') of itself:
            // c dt / J_k = 0.5 rad/s times ln(100 / 2) in all.
            assert!(
                (speeds[0] - truth(s.time)).abs() < tolerance,
                "{integrator} {}: {speeds} {}",
                s.time,
                truth(s.time)
            );
            assert!(speeds[1].abs() < 1e-9, "{speeds}");
        }
        let speeds = gear() * Vector2::new(sim.plant().state.v[0], sim.plant().state.v[1]);
        assert!(speeds[0] < 1e-6 && speeds[0] > -1e-9, "{integrator}: {speeds}");
        let lost = 0.5 * inertia * start * start;
        assert!((metrics.joint_loss_j - lost).abs() < 1e-4 * lost, "{} {lost}", metrics.joint_loss_j);
        assert!(metrics.max_energy_error_j < if integrator == ROSENBROCK { 1e-5 } else { 1e-8 }, "{metrics:?}");
    }
}

/// Lag, limits, friction and a kinematic joint together: the energy is balanced.
#[test]
fn energy_is_balanced_with_all_that_motors_have() {
    let transmission = "rotor_inertia = [2e-5, 5e-5]\neffort = [0.2, 0.3]\nvelocity = 60.0
        friction = { coulomb = 0.01, viscous = 1e-5, static = 0.02 }";
    let sine = "task = [{ type = \"sine\", joints = { pitch = { amplitude = 0.4, frequency = 2.0 }, \
                roll = { amplitude = 0.3, frequency = 3.0 } } }]";
    for joint in ["kp = 400.0, kd = 20.0", "kp = 400.0, kd = 20.0, lag = 0.01"] {
        let robot = ball(joint, transmission);
        for start in ["", "joint.pitch.mode = \"kinematic\""] {
            for (integrator, tolerance) in [(DOPRI5, 1e-7), (ROSENBROCK, 1e-4), (FIXED, 1e-12)] {
                let (_, metrics, recording) = run(&robot, integrator, sine, start, NO_COMMANDS);
                // Kinks of adaptive methods; steps balance exactly.
                assert!(metrics.max_energy_error_j < tolerance, "{joint} {start} {integrator}: {metrics:?}");
                assert!(metrics.joint_loss_j > 0.01, "{metrics:?}");
                let is_limited = recording.snapshots.iter().any(|s| (s.effort[1] - s.effort_desired[1]).abs() > 1.0);
                assert!(is_limited || !start.is_empty(), "no limit acts");
            }
        }
    }
}
