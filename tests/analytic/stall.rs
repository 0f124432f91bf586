//! Runs with endless events or searches end with an error message; ordinary chains of impacts end by the
//! tolerances.

use super::body::G;
use crate::support::runs::{finish, run, setup, simulation, watch};
use nalgebra::Vector3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};
use stiction::assemble;
use stiction::force::{AppliedForces, Force, ForceContext};
use stiction::robot::LinkId;
use stiction::sim::{Metrics, NullObserver, Outcome, Simulation};

/// Twenty nanometres up, without loss: it bounces every 0.13 ms without end.
const BOUNCING: &str = "
    duration = 2.0
    robot = { model = \"robots/block/block.toml\", base = { position = [0, 0, 0.05000002] } }
    [contact]
    restitution = 1.0
    distance_tolerance = 1e-9
    velocity_tolerance = 1e-9
    acceleration_tolerance = 1e-9\n";

#[test]
fn endless_bouncing_without_loss_stalls() {
    let mut sim = simulation(BOUNCING);
    let (outcome, message) = sim.run(&mut NullObserver, &AtomicBool::new(false));
    assert_eq!(outcome, Outcome::Stalled, "{message}");
    assert!(message.contains("more than 5000 contact events within one second"), "{message}");
    // A bounce takes 2 sqrt(2 h / g), and each is two events: touch-down and lift-off.
    let bounces = sim.metrics().duration_s / (2.0 * (2.0 * 2e-8 / G).sqrt());
    assert!((bounces / 2500.0 - 1.0).abs() < 0.01, "{bounces}");
}

#[test]
fn from_a_greater_height_the_block_bounces_without_stalling() {
    let m = run(&BOUNCING.replace("0.05000002", "0.15"));
    let period = 2.0 * (2.0 * 0.1 / G).sqrt();
    assert_eq!(m.impacts, (2.0 / period + 0.5).floor() as u64);
    assert!(m.energy_error_j.abs() < 1e-9);
}

/// Pushes forward unless the body moves forward, and backward while it does: no motion satisfies
/// it.
struct Contrary(f64);

impl Force for Contrary {
    fn evaluate(&mut self, context: &ForceContext, applied: &mut AppliedForces) {
        let sign = if context.state.v[0] > 0.0 { -1.0 } else { 1.0 };
        let at = context.state.position - Vector3::new(0.0, 0.0, 0.05);
        applied.wrench(context, LinkId(0), &at, &Vector3::new(sign * self.0, 0.0, 0.0), &Vector3::zeros());
    }
}

/// The block on a floor of friction 0.2, pushed by [`Contrary`].
fn contrary(base: &str, duration: f64, force: f64) -> Metrics {
    let text = format!(
        "duration = {duration}
        robot = {{ model = \"robots/block/block.toml\", base = {{ {base} }} }}
        floor = {{ friction = 0.2 }}
        log = {{ rate = 0 }}\n"
    );
    let file = stiction::scenario::parse(&crate::support::runs::root().join("t.toml"), &text).unwrap();
    let runs = file.expand(&[]).unwrap();
    let robot = stiction::robot::load(&runs[0].resolve(&runs[0].scenario.robot.model)).unwrap();
    let mut setup = assemble::setup(&runs[0], &robot).unwrap();
    setup.forces.push(Box::new(Contrary(force)));
    finish(&mut Simulation::new(setup).unwrap(), &mut NullObserver)
}

#[test]
fn a_force_that_reverses_with_its_own_motion_holds_the_block() {
    // Below the friction limit the block sticks. Above it, sticking and sliding alternate at once, and
    // the only solution in Filippov's sense is that it stays: any motion is driven back.
    for (force, slides) in [(1.5, false), (4.0, true)] {
        let m = contrary("", 0.02, force);
        // Steps of 1 us at the difference of force and friction, on 1 kg: 2e-6 m/s.
        assert!(m.final_base_position[0].abs() < 1e-9, "{force} {:?}", m.final_base_position);
        assert!(m.final_base_velocity[0].abs() < 1e-5, "{force} {:?}", m.final_base_velocity);
        assert!(m.max_cone_excess < 1e-12 && m.inconsistent == 0, "{force} {}", m.max_cone_excess);
        let expected = if slides { m.duration_s } else { 0.0 };
        // Detection takes 16 events.
        assert!((m.sliding_mode_s - expected).abs() < 0.01 * m.duration_s, "{force} {}", m.sliding_mode_s);
    }
}

#[test]
fn bouncing_with_loss_ends_by_the_velocity_tolerance() {
    for (e, tolerance) in [(0.9, 1e-3), (0.5, 1e-3), (0.9, 0.1), (0.97, 1e-2)] {
        let (m, recording) = watch(&format!(
            "duration = 30.0
            robot = {{ model = \"robots/block/block.toml\", base = {{ position = [0, 0, 0.25] }} }}
            contact = {{ restitution = {e}, velocity_tolerance = {tolerance} }}
            integrator = {{ relative_tolerance = 1e-9, absolute_tolerance = 1e-11 }}\n"
        ));
        let fall = (2.0f64 * 0.2 / G).sqrt();
        // Approach speeds are v e^n; one slightly above the tolerance may end without a bounce.
        let impacts = ((tolerance / (G * fall)).ln() / f64::ln(e)).ceil();
        assert!((m.impacts as f64 - impacts).abs() <= 1.0, "{e} {tolerance} {} {impacts}", m.impacts);
        // All bounces would take (1 + e) / (1 - e) times the fall; those below the tolerance are
        // omitted.
        let all = fall * (1.0 + e) / (1.0 - e);
        let left_out = all - recording.events.last().expect("it bounces").time;
        assert!(left_out >= 0.0 && left_out < 2.0 * tolerance / (e * G * (1.0 - e)), "{e} {tolerance} {left_out}");
        let end = recording.snapshots.last().expect("the end is reported");
        assert_eq!(end.soles[0].state, "face-static");
        assert!((m.final_base_position[2] - 0.05).abs() < 1e-8 && m.energy_error_j.abs() < 1e-9);
        assert_eq!(m.inconsistent, 0);
    }
}

#[test]
fn rocking_ends_by_the_velocity_tolerance() {
    for (tilt, tolerance) in [(0.2, 1e-2), (0.1, 1e-3), (0.3, 1e-4)] {
        let (m, recording) = watch(&format!(
            "duration = 5.0
            robot = {{ model = \"robots/block/block.toml\", base = {{ rpy = [{tilt}, 0, 0] }}, soles = [
                {{ name = \"bottom\", link = \"block\", polygon = [[-0.1, -0.02, -0.05], [0.1, -0.02, -0.05], [0.1, 0.02, -0.05], [-0.1, 0.02, -0.05]] }} ] }}
            floor = {{ friction = 5.0 }}
            contact = {{ velocity_tolerance = {tolerance}, acceleration_tolerance = {tolerance} }}\n"
        ));
        println!("{tilt} {tolerance} {m:?}");
        let end = recording.snapshots.last().expect("the end is reported");
        assert_eq!((end.soles[0].state.as_str(), m.inconsistent), ("face-static", 0));
        assert!(m.impacts > 4 && m.events < 500, "{} {}", m.impacts, m.events);
        // Vertices are clamped within 1e-9 m of the floor, on a sole 0.04 m wide.
        assert!(m.final_base_rpy[0].abs() < 2.5e-8 && m.energy_error_j.abs() < 1e-6);
    }
}

/// HOAP-2 sunk by 3 cm into the floor: several links start in it, and no combination of their states
/// is valid with the split of least norm, the only one that the search `paper` tests.
fn sunk_humanoid() -> Simulation {
    let mut setup = setup(
        "duration = 0.1
        contact = { exact = { search = \"paper\" } }
        robot = { model = \"robots/hoap2/hoap2.toml\", contact = \"bodies\" }\n",
    );
    setup.start.position.z = 0.25;
    Simulation::new(setup).unwrap()
}

#[test]
fn cancellation_ends_a_search_for_contact_states() {
    let mut sim = sunk_humanoid();
    let cancel = Arc::new(AtomicBool::new(false));
    sim.cancel_on(cancel.clone());
    let flag = cancel.clone();
    let canceller = thread::spawn(move || {
        thread::sleep(Duration::from_millis(300));
        flag.store(true, Ordering::Relaxed);
        Instant::now()
    });
    let (outcome, message) = sim.run(&mut NullObserver, &cancel);
    let end = Instant::now();
    assert_eq!((outcome, message.as_str()), (Outcome::Cancelled, "interrupted"));
    assert!(sim.metrics().duration_s == 0.0, "the first choice of states");
    // One candidate takes some milliseconds at most.
    assert!(end - canceller.join().unwrap() < Duration::from_secs(5));
}

#[test]
fn a_search_through_too_many_states_stalls() {
    let (outcome, message) = sunk_humanoid().run(&mut NullObserver, &AtomicBool::new(false));
    assert_eq!(outcome, Outcome::Stalled, "{message}");
    assert!(message.contains("no valid contact state among 500") && message.contains("at 0.000000000 s"), "{message}");
}
