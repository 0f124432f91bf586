//! Tests of console output against closed forms.

use super::{answer, hoap2, numbers, session};
use crate::cli::Place;

/// A block of 1 kg with half a height of 0.05 m, on a floor without friction.
fn block(place: &Place) {
    place.block("b.toml", "[floor]\nfriction = 0.0\n");
}

/// The velocity is f t / m after a constant force f for the time t.
#[test]
fn a_push_accelerates_a_block_by_newtons_law() {
    let place = Place::new();
    block(&place);
    let output = answer(
        &place,
        "b.toml",
        "push block 2 -1 0 for 0.5 profile=constant\nrun 0.75",
        "value base_vx_m_s base_vy_m_s base_x_m",
    );
    let found = numbers(&output);
    // The integrator's relative tolerance is 1e-6.
    for (found, expected) in found.iter().zip([1.0, -0.5, 0.25 + 0.25]) {
        assert!((found - expected).abs() < 2e-6, "{output}");
    }
    assert_eq!(found.len(), 3, "{output}");
}

/// The deceleration of a sliding block is mu g with the new kinetic friction, until it rests.
#[test]
fn floor_sets_the_friction_of_the_running_session() {
    let place = Place::new();
    block(&place);
    let lines = "push block 4 0 0 for 0.5 profile=constant\nrun 0.5\nfloor 0.5 0.2\nrun 0.4";
    let found = numbers(&answer(&place, "b.toml", lines, "value base_vx_m_s"))[0];
    assert!((found - (2.0 - 0.2 * 9.81 * 0.4)).abs() < 1e-5, "{found}");
    let stopped = numbers(&answer(&place, "b.toml", &format!("{lines}\nrun 2"), "value base_vx_m_s"))[0];
    assert_eq!(stopped, 0.0);
    assert_eq!(answer(&place, "b.toml", lines, "floor"), "static 0.5, kinetic 0.2\n");
    assert_eq!(answer(&place, "b.toml", lines, "get floor.friction.kinetic"), "0.2\n");
}

/// The zero-moment point of a block at rest is below the common centre of mass: m x / (M + m).
#[test]
fn a_payload_shifts_the_zero_moment_point() {
    let place = Place::new();
    place.block("b.toml", "[floor]\nfriction = 1.0\n");
    for before in ["", "run 0.1\n"] {
        let lines = format!("{before}payload block 0.5 0.06 0.03 0.1\nrun 0.3");
        let found = numbers(&answer(&place, "b.toml", &lines, "zmp"));
        let share = 0.5 / 1.5;
        assert!((found[0] - share * 0.06).abs() < 1e-6 && (found[1] - share * 0.03).abs() < 1e-6, "{found:?}");
        // The payload is removed.
        let off = numbers(&answer(&place, "b.toml", &format!("{lines}\npayload block 0\nrun 0.2"), "zmp"));
        assert!(off[0].abs() < 1e-6 && off[1].abs() < 1e-6, "{off:?}");
    }
    // The force on the sole is the weight of block and payload.
    let lines = "payload block 0.5\nrun 0.1";
    let force = numbers(&answer(&place, "b.toml", lines, "value sole.bottom.force_z_N"))[0];
    assert!((force - 1.5 * 9.81).abs() < 1e-9, "{force}");
}

/// A restored block falls again from the stored position, while time continues.
#[test]
fn a_restored_block_falls_again() {
    let place = Place::new();
    place.block("b.toml", "base = { position = [0, 0, 1] }\n");
    let height = |lines: &str| numbers(&answer(&place, "b.toml", lines, "value time_s base_z_m base_vz_m_s"));
    assert_eq!(height("run 0.2"), height("run 0.2"));
    let fall = |t: f64| 1.0 - 0.5 * 9.81 * t * t;
    let first = height("run 0.1\nstore up\nrun 0.2");
    assert!((first[1] - fall(0.3)).abs() < 1e-9, "{first:?}");
    let again = height("run 0.1\nstore up\nrun 0.2\nrestore up\nrun 0.1");
    assert_eq!(again[0], 0.4);
    assert!((again[1] - fall(0.2)).abs() < 1e-9 && (again[2] + 9.81 * 0.2).abs() < 1e-9, "{again:?}");
    assert_eq!(answer(&place, "b.toml", "run 0.1\nstore up", "states"), "up at 0.1 s\n");
}

/// Jacobian times velocities gives the velocity of the centre of mass, and of a hand compared with
/// central differences of its position.
#[test]
fn jacobians_match_the_motion() {
    let place = Place::new();
    hoap2(
        &place,
        "h.toml",
        "task = [{ type = \"sine\", ramp = 0.05, joints = { left_shoulder_pitch = { amplitude = 0.2 }, left_elbow = { amplitude = 0.5, frequency = 2.0, offset = -1.0 }, head_pan = { amplitude = 0.1 } } }]\n[log]\nrate = 1000",
    );
    let lines = "run 0.213";
    let rows = |what: &str| -> Vec<Vec<f64>> {
        let output = answer(&place, "h.toml", lines, &format!("jacobian {what}"));
        output.lines().skip(1).map(numbers).collect()
    };
    let velocities =
        numbers(&answer(&place, "h.toml", lines, "value base_v?_m_s base_w?_rad_s joint.*.velocity_rad_s"));
    // Joint velocities are in the order of the joints, like the columns of the Jacobian.
    let product = |row: &[f64]| -> f64 { row.iter().zip(&velocities).map(|(j, v)| j * v).sum() };
    let com = numbers(&answer(&place, "h.toml", lines, "value com_v?_m_s"));
    let found = rows("com");
    assert_eq!(found.len(), 3);
    assert_eq!(found[0].len(), velocities.len());
    for (row, expected) in found.iter().zip(com) {
        assert!((product(row) - expected).abs() < 1e-12, "{} {expected}", product(row));
    }
    // Velocity of a hand from its positions 1 ms before and after. The second-order error is 2e-5
    // with a third derivative of some 100 m/s^3.
    let hand_position =
        |ticks: &str| numbers(&answer(&place, "h.toml", &format!("run {ticks}"), "frame l_hand"))[..3].to_vec();
    let (before, after) = (hand_position("0.212"), hand_position("0.214"));
    let hand = rows("l_hand");
    assert_eq!(hand.len(), 6);
    for i in 0..3 {
        let measured = (after[i] - before[i]) / 0.002;
        // Positions have six digits, so the error is 1e-6 / 0.002.
        assert!((product(&hand[i]) - measured).abs() < 1e-3, "{i}: {} {measured}", product(&hand[i]));
    }
    assert!((0..3).any(|i| product(&hand[i]).abs() > 0.05), "the hand moves");
}

#[test]
fn drive_moves_joints_to_a_posture() {
    let place = Place::new();
    hoap2(&place, "h.toml", "");
    let output = answer(&place, "h.toml", "drive left_elbow=-0.5 head_pan=\"20 deg\" in 0.4\nrun 1", "joints *");
    let desired_position = |joint: &str| {
        let line = output.lines().find(|line| line.starts_with(joint)).unwrap();
        numbers(line)[2]
    };
    assert_eq!(desired_position("left_elbow"), -0.5);
    assert_eq!(desired_position("head_pan"), 0.349066);
    assert_eq!(output.lines().count(), 26);
    let home = answer(
        &place,
        "h.toml",
        "drive left_elbow=-0.5 in 0.2\nrun 0.3\ndrive home in 0.2\nrun 0.4",
        "joints left_elbow",
    );
    assert_eq!(numbers(&home)[2], 0.0, "{home}");
}

#[test]
fn tasks_start_change_and_stop_on_command() {
    let place = Place::new();
    hoap2(&place, "h.toml", "");
    let start = "run 0.1\nstart sine ramp=0.0 joints.head_pan.amplitude=0.3 joints.head_pan.offset=0.0\n";
    let desired =
        |lines: &str| numbers(&answer(&place, "h.toml", lines, "value joint.head_pan.desired_position_rad"))[0];
    let sine = |t: f64| 0.3 * (std::f64::consts::TAU * t).sin();
    // The desired position is that of the last tick, 1 ms before.
    assert!((desired(&format!("{start}run 0.2")) - sine(0.199)).abs() < 1e-12);
    let changed = desired(&format!("{start}run 0.2\nchange 0 joints.head_pan.amplitude=0.1\nrun 0.1"));
    assert!((changed - sine(0.299) / 3.0).abs() < 1e-12, "{changed}");
    // After the end of the task the desired position stays constant.
    let ended = desired(&format!("{start}run 0.2\nstop sine\nrun 0.3"));
    assert!((ended - sine(0.199)).abs() < 1e-12, "{ended}");
    assert_eq!(answer(&place, "h.toml", start, "tasks"), "0 sine: waits, start 0.1 s\n");
    assert_eq!(answer(&place, "h.toml", &format!("{start}step"), "tasks"), "0 sine: runs, start 0.1 s\n");
    assert_eq!(
        answer(&place, "h.toml", &format!("{start}step\nstop 0\nstep"), "tasks"),
        "0 sine: has ended, start 0.1 s\n"
    );
    // A change planned in the scenario still takes effect after a change in the session.
    hoap2(
        &place,
        "later.toml",
        "task = [{ type = \"sine\", ramp = 0.0, joints = { head_pan = { amplitude = 0.3, offset = 0.0 } }, change = [{ at = 0.4, joints = { head_pan = { amplitude = 0.2 } } }] }]",
    );
    let lines = "run 0.2\nchange sine joints.head_pan.amplitude=0.1\nrun 0.1";
    let desired_position =
        |lines: &str| numbers(&answer(&place, "later.toml", lines, "value joint.head_pan.desired_position_rad"))[0];
    assert!((desired_position(lines) - sine(0.299) / 3.0).abs() < 1e-12);
    assert!((desired_position(&format!("{lines}\nrun 0.2")) - sine(0.499) / 1.5).abs() < 1e-12);
    // A task stopped before its start never starts.
    let never = "start sine joints.head_pan.amplitude=0.3\nstop all\nrun 0.2";
    assert_eq!(answer(&place, "h.toml", never, "tasks"), "0 sine: has ended, start 0 s\n");
    assert_eq!(desired(never), 0.0);
}

#[test]
fn run_until_stops_at_an_event() {
    let place = Place::new();
    place.block("b.toml", "base = { position = [0, 0, 0.55] }\n");
    // sqrt(2 h / g), at the tick after it.
    let fall = (2.0_f64 * 0.5 / 9.81).sqrt();
    // An event that does not occur until the end of the session is an error.
    let lines = ["run until touchdown", "status", "run until liftoff", "step 2"];
    let lines = lines.into_iter().flat_map(|line| ["-c", line]);
    let fixed = ["console", "b.toml", "--duration", "1"];
    let done = place.runner(&fixed.into_iter().chain(lines).collect::<Vec<_>>());
    let done = done.exits(2);
    let tick = (fall * 1000.0).ceil() / 1000.0;
    assert!(done.stdout.contains(&format!("\n{tick} s\n")), "{tick}: {}", done.stdout);
    assert!(done.stderr.contains("--command:3: error: no liftoff until 1 s"), "{}", done.stderr);
}

/// Before the first step every scenario value can be set, and applies from the start.
#[test]
fn all_scenario_values_can_be_set_before_the_first_step() {
    let place = Place::new();
    block(&place);
    let lines = "set contact.method=penalty base.x=1";
    let invalid = session(&place, "b.toml", lines).exits(2);
    assert!(invalid.stderr.contains("unknown key `base`"), "{}", invalid.stderr);
    let output = answer(
        &place,
        "b.toml",
        "set robot.base.position=[0,0,2] contact.method=one-step integrator.method=semi-implicit\nrun 0.1",
        "status",
    );
    assert!(output.contains("contact one-step, integrator semi-implicit"), "{output}");
    let height = numbers(&answer(&place, "b.toml", "set robot.base.position=[0,0,2]\nrun 0.1", "value base_z_m"))[0];
    assert!((height - (2.0 - 0.5 * 9.81 * 0.01)).abs() < 1e-9, "{height}");
}
