//! Commands as functions of time: `control.interpolation = "continuous"`.

use super::{NO_COMMANDS, simulation, wheel};
use crate::support::counting::count;
use crate::support::runs::{self, Recording, finish, rk4, root};
use std::f64::consts::TAU;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use stiction::assemble;
use stiction::motion::spline::{EndConditions, Spline};
use stiction::robot::{self, JointId};
use stiction::scenario;
use stiction::sim::{Metrics, NullObserver, Simulation};
use stiction::task::playback::Playback;
use stiction::task::{Command, Context, Status, Task, TaskResult};

const INERTIA: f64 = 0.2;
const KP: f64 = 200.0;
const KD: f64 = 20.0;
const TIGHT: &str = "method = \"dopri5\", relative_tolerance = 1e-10, absolute_tolerance = 1e-12";

/// A wheel with a servo of rates 11 and 89 1/s, which these tasks drive.
fn text(duration: f64, integrator: &str, interpolation: &str, tasks: &str) -> String {
    format!(
        "duration = {duration}
        gravity = [0, 0, 0]
        log.rate = 100.0
        control = {{ rate = 1000.0, interpolation = \"{interpolation}\" }}
        integrator = {{ {integrator} }}
        robot = {{ model = \"given\", soles = [], joint.axle = {{ kp = {KP}, kd = {KD}, effort = 1e9 }} }}
        {tasks}\n"
    )
}

fn ended(text: &str) -> (Metrics, Recording) {
    let mut recording = Recording::default();
    let metrics = finish(&mut simulation(Some(&wheel(INERTIA)), text, NO_COMMANDS), &mut recording);
    (metrics, recording)
}

/// Position at the last snapshot.
fn position(recording: &Recording) -> f64 {
    recording.snapshots.last().expect("one").q[0]
}

/// Greatest distance of the logged positions of two runs.
fn distance(a: &Recording, b: &Recording) -> f64 {
    assert_eq!(a.snapshots.len(), b.snapshots.len());
    a.snapshots.iter().zip(&b.snapshots).map(|(a, b)| (a.q[0] - b.q[0]).abs()).fold(0.0, f64::max)
}

/// The error e = q - r of a servo that follows r = A sin(w t) obeys `I e'' + kd e' + kp e = I A w^2 sin(w t)`.
#[test]
fn a_servo_follows_a_sine_as_its_closed_form_with_steps_over_many_ticks() {
    const A: f64 = 0.5;
    const END: f64 = 3.1;
    let w = TAU * 1.25;
    let task = "[[task]]\ntype = \"sine\"\nramp = 0.0\njoints.axle = { amplitude = 0.5, frequency = 1.25 }";
    let (stiffness, damping, drive) = (KP - INERTIA * w * w, KD * w, INERTIA * A * w * w);
    let (sin, cos) = (w * END).sin_cos();
    let square = stiffness * stiffness + damping * damping;
    let truth = A * sin + drive * (stiffness * sin - damping * cos) / square;
    let end = |integrator: &str, interpolation: &str| {
        let (m, seen) = ended(&text(END, integrator, interpolation, task));
        ((position(&seen) - truth).abs(), m.steps)
    };
    // The log has the desired motion of its instants.
    let (_, seen) = ended(&text(0.5, TIGHT, "continuous", task));
    for s in &seen.snapshots {
        let (sin, cos) = (w * s.time).sin_cos();
        assert!((s.q_desired[0] - A * sin).abs() < 1e-10 && (s.qd_desired[0] - A * w * cos).abs() < 1e-8, "{}", s.time);
    }
    // The transient of the start has decayed by exp(-33); errors of steps at 1e-10 add up over 0.1 s.
    let (error, steps) = end(TIGHT, "continuous");
    assert!(error < 1e-10, "{error}");
    // Held commands lag by half a tick: 2 mm/s.
    let (held, of_held) = end(TIGHT, "hold");
    assert!(held > 1e-4 && 2 * steps < of_held, "{held} {steps} {of_held}");
    // At the default tolerances of 1e-6, with far fewer steps than the 3000 ticks.
    for (method, most) in [("dopri5", 900), ("rosenbrock", 2200), ("bdf", 1200)] {
        let (error, steps) = end(&format!("method = \"{method}\""), "continuous");
        assert!(error < 2e-6 && steps < most, "{method} {error} {steps}");
    }
    // Semi-implicit steps meet the commands too: the order is 1.
    let of_step = |h: f64| end(&format!("method = \"semi-implicit\", step = {h}"), "continuous").0;
    let (coarse, fine) = (of_step(1e-3), of_step(5e-4));
    assert!((coarse / fine - 2.0).abs() < 0.1, "{coarse} {fine}");
}

/// Spans of a second have six and twelve periods of these, sampled at the same phase in any equal parts.
#[test]
fn fast_oscillations_are_not_overlooked() {
    for frequency in [6.0, 12.0, 24.0] {
        let task = format!(
            "[[task]]\ntype = \"sine\"\nramp = 0.0\njoints.axle = {{ amplitude = 0.1, frequency = {frequency}, phase = 1.5707963267948966 }}"
        );
        let text = text(1.0, TIGHT, "continuous", &task);
        let mut recording = Recording::default();
        finish(&mut simulation(Some(&wheel(INERTIA)), &text, NO_COMMANDS), &mut recording);
        for s in &recording.snapshots {
            let truth = 0.1 * (TAU * frequency * s.time).cos();
            // Spans agree with the commands to 1e-10 of their change.
            assert!((s.q_desired[0] - truth).abs() < 1e-10, "{frequency} {}: {} {truth}", s.time, s.q_desired[0]);
        }
    }
}

/// Ramps, whose ends are kinks, against the equations integrated apart from the program.
#[test]
fn ramps_and_the_end_of_a_sine_are_followed() {
    const RAMP: f64 = 0.30037; // s; between two ticks
    const LAST: f64 = 0.9;
    let task = format!(
        "[[task]]\ntype = \"sine\"\nramp = {RAMP}\nduration = {LAST}\njoints.axle = {{ amplitude = 0.5, frequency = 1.5 }}"
    );
    let rise = |t: f64| {
        let s = (t / RAMP).clamp(0.0, 1.0);
        (s * s * s * (10.0 - 15.0 * s + 6.0 * s * s), 30.0 * s * s * (1.0 - s) * (1.0 - s) / RAMP)
    };
    let w = TAU * 1.5;
    let reference = |t: f64| {
        let ((r, r1), (sin, cos)) = match t {
            _ if t >= LAST => ((0.0, 0.0), (0.0, 0.0)),
            _ if t > LAST - RAMP => ((rise(LAST - t).0, -rise(LAST - t).1), (w * t).sin_cos()),
            _ => (rise(t), (w * t).sin_cos()),
        };
        (0.5 * r * sin, 0.5 * (r1 * sin + r * w * cos))
    };
    let slope = |t: f64, y: &[f64; 2]| {
        let (q, qd) = reference(t);
        [y[1], (KP * (q - y[0]) + KD * (qd - y[1])) / INERTIA]
    };
    let (_, seen) = ended(&text(1.2, TIGHT, "continuous", &task));
    // Snapshots every 10 ms; steps of 5e-6 s of order 4 have no error besides rounding and kinks of r'''.
    let mut y = [0.0, 0.0];
    for pair in seen.snapshots.windows(2) {
        let from = pair[0].time;
        y = rk4(y, pair[1].time - from, 2000, |t, y| slope(from + t, y));
        // In the tick with a kink of r''' = 0.5 * 60 / ramp^3 the path is a cubic: 1e-9 * 1100 / 6 at most, for a tick of
        // the 10 that the servo's rate of 89 1/s averages over.
        assert!((pair[1].q[0] - y[0]).abs() < 2e-8, "{}: {} {}", pair[1].time, pair[1].q[0], y[0]);
    }
    assert!(y[0].abs() > 1e-6, "it still moves");
}

/// A wheel with these tasks, then a motion that repeats.
fn playing(interpolation: &str, tasks: &str) -> Simulation {
    let file = scenario::parse(&root().join("test.toml"), text(3.0, TIGHT, interpolation, tasks));
    let runs = file.unwrap_or_else(|e| panic!("{e}")).expand(&[]).unwrap_or_else(|e| panic!("{e}"));
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("robot.urdf");
    std::fs::write(&path, wheel(INERTIA)).expect("written");
    let mut setup = assemble::setup(&runs[0], &robot::load(&path).expect("a robot")).unwrap_or_else(|e| panic!("{e}"));
    let knots = Spline::new(vec![0.1, 0.33, 0.7, 0.9], &[0.0, 0.4, -0.2, 0.0], EndConditions::Periodic);
    let curve = knots.expect("a curve");
    let playback = Playback::new(vec![(JointId(0), curve)], 1.1, true, 0.15, vec![(1.2, 0.7), (2.0, 1.3)]);
    setup.tasks.add(0.4, Box::new(playback));
    Simulation::new(setup).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn postures_motions_and_their_changes_are_those_of_cubic_paths() {
    let posture = "[[task]]\ntype = \"posture\"\nduration = 0.25\njoints = { axle = 0.3 }";
    let run = |interpolation| {
        let mut recording = Recording::default();
        let metrics = finish(&mut playing(interpolation, posture), &mut recording);
        (metrics.steps, recording)
    };
    let ((few, found), (many, cubic)) = (run("continuous"), run("cubic"));
    assert!(found.snapshots.iter().any(|s| s.q[0].abs() > 0.3));
    // Cubics through the last two commands miss a jump of the acceleration by up to 100 rad/s^2, at the start of
    // the blend, for a tick of 1 ms: 100 * 1e-6 / 2, of which the servo follows 2 zeta w0 T = 0.1.
    assert!(distance(&found, &cubic) < 1e-5, "{}", distance(&found, &cubic));
    assert!(4 * few < 3 * many, "{few} {many}");
}

/// An event ends a task at the first tick after it, whatever was foreseen.
#[test]
fn an_event_ends_a_task_at_its_tick() {
    let tasks = "[[task]]\ntype = \"sine\"\nramp = 0.0\njoints.axle = { amplitude = 0.5, frequency = 1.25 }
        [[event]]\nat = 1.0305\nend_tasks = [0]";
    let mut ends = Vec::new();
    for interpolation in ["hold", "cubic", "continuous"] {
        let (_, seen) = ended(&text(5.0, TIGHT, interpolation, tasks));
        let end = seen.events.iter().find(|e| e.message == "task sine ends").expect("an event").time;
        assert_eq!(end, 1.031, "{interpolation}");
        ends.push(position(&seen));
    }
    // The joint rests at the command of the tick before; the transient has decayed by exp(-44).
    let last = 0.5 * (TAU * 1.25 * 1.03).sin();
    assert!(ends.iter().all(|end| (end - last).abs() < 1e-10), "{ends:?} {last}");
}

#[test]
fn a_task_that_an_event_ends_hands_its_joint_over_as_with_cubic_paths() {
    let sine = |a: f64, f: f64| {
        format!("[[task]]\ntype = \"sine\"\nramp = 0.0\njoints.axle = {{ amplitude = {a}, frequency = {f} }}\n")
    };
    let tasks = format!("{}{}[[event]]\nat = 1.0305\nend_tasks = [1]", sine(0.5, 0.5), sine(0.3, 1.25));
    let [cubic, found] = ["cubic", "continuous"].map(|interpolation| ended(&text(2.0, TIGHT, interpolation, &tasks)).1);
    // The joint is handed over where its commands are a third of a radian apart. Cubics extrapolate the last two
    // commands and miss the acceleration of one tick, below 20 rad/s^2: 20 * 1e-6 / 2, of which the servo follows a tenth.
    assert!(distance(&found, &cubic) < 1e-5, "{}", distance(&found, &cubic));
}

/// A task that counts its calls and commands nothing.
struct Counts(Arc<AtomicU64>);

impl Task for Counts {
    fn init(&mut self, _: &Context, _: &Command) -> TaskResult {
        Ok(Status::Running)
    }

    fn run(&mut self, _: &Context, _: &mut Command) -> TaskResult {
        self.0.fetch_add(1, Ordering::Relaxed);
        Ok(Status::Running)
    }

    fn name(&self) -> &str {
        "counts"
    }
}

#[test]
fn a_task_added_within_a_span_is_called_at_every_tick() {
    let task = "[[task]]\ntype = \"sine\"\njoints.axle = { amplitude = 0.5, frequency = 1.25 }";
    let mut sim = simulation(Some(&wheel(INERTIA)), &text(2.0, TIGHT, "continuous", task), NO_COMMANDS);
    sim.advance_to(0.4, &mut NullObserver).expect("it steps");
    while sim.next_tick().expect("one") < sim.time() + 0.01 {
        sim.step(&mut NullObserver).expect("it steps");
    }
    let now = sim.time();
    assert!(now < 0.7, "no span is that long");
    let calls = Arc::new(AtomicU64::new(0));
    sim.add_task(0.0, Box::new(Counts(calls.clone())));
    assert!(sim.next_tick().expect("one") < now + 1.0001e-3);
    sim.advance_to(now + 0.1, &mut NullObserver).expect("it steps");
    let calls = calls.load(Ordering::Relaxed);
    assert!((100..=101).contains(&calls), "{calls}");
}

/// Tasks with feedback have the bits of cubic paths.
#[test]
fn unknown_tasks_have_cubic_paths() {
    let end = |interpolation| {
        let text = text(0.3, TIGHT, interpolation, "");
        let mut sim = simulation(Some(&wheel(INERTIA)), &text, Some(|_, t| [t * t, 2.0 * t, 0.0]));
        finish(&mut sim, &mut NullObserver);
        sim.plant().state.joints[0].to_bits()
    };
    assert_eq!(end("continuous"), end("cubic"));
}

/// Prescribed motions meet their commands, and the drives' work the change of energy.
#[test]
fn kinematic_joints_move_along_the_commands() {
    let task = "[[task]]\ntype = \"sine\"\nramp = 0.2\njoints.axle = { amplitude = 0.5, frequency = 1.25 }";
    // The prescribed motion has no error to control; that of its work in steps of 2 ms is (2 pi 1.25 h)^6 of 2 J.
    let integrator = format!("{TIGHT}, max_step = 2e-3");
    let text = text(1.0, &integrator, "continuous", task).replace("axle = { kp", "axle = { mode = \"kinematic\", kp");
    let mut sim = simulation(Some(&wheel(INERTIA)), &text, NO_COMMANDS);
    let m = finish(&mut sim, &mut NullObserver);
    let (sin, cos) = (TAU * 1.25).sin_cos();
    let state = &sim.plant().state;
    // Spans agree with the commands to 1e-10 of a change of 0.1 rad, and 1e-9 of the velocity.
    assert!((state.joints[0] - 0.5 * sin).abs() < 1e-11, "{}", state.joints[0]);
    assert!((state.v[0] - 0.5 * TAU * 1.25 * cos).abs() < 4e-9, "{}", state.v[0]);
    assert!(m.max_energy_error_j < 1e-9, "{}", m.max_energy_error_j);
    assert!(m.steps < 600, "{}", m.steps);
}

#[test]
fn spans_are_planned_without_allocating() {
    let mut sim = runs::simulation(
        "duration = 1.0
        control.interpolation = \"continuous\"
        robot.model = \"robots/hoap2/hoap2.toml\"
        [[task]]
        type = \"sine\"
        joints = { head_pan = { amplitude = 0.3, frequency = 5.0 } }\n",
    );
    // Beyond the ramp, where nothing happens but spans that end.
    sim.advance_to(0.8, &mut NullObserver).expect("it steps");
    let first = sim.next_tick();
    let allocations = count(|| sim.advance_to(0.95, &mut NullObserver).expect("it steps"));
    assert!(sim.next_tick() > first.map(|t| t + 0.02), "spans have ended");
    assert_eq!(allocations, 0);
}
