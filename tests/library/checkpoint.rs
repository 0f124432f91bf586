//! Checkpoints: the steps after a return have the bits of those after the checkpoint.

use stiction::sim::{Checkpoint, Simulation};
use stiction::{Context, Metrics, Scenario, State, Status, Task, TaskResult};

/// Commands the joints by a function of time.
struct Wave;

impl Task for Wave {
    fn init(&mut self, _: &Context, _: &stiction::Command) -> TaskResult {
        Ok(Status::Running)
    }

    fn run(&mut self, context: &Context, command: &mut stiction::Command) -> TaskResult {
        for (j, position) in command.position.iter_mut().enumerate() {
            *position += 1e-3 * (30.0 * context.time + j as f64).sin();
        }
        Ok(Status::Running)
    }

    fn has_memory(&self) -> bool {
        false
    }

    fn name(&self) -> &str {
        "wave"
    }
}

fn simulation(text: &str, waves: bool) -> Simulation {
    let run = Scenario::parse("checkpoint.toml", text).unwrap().runs().unwrap().remove(0);
    let mut simulation = run.simulation().unwrap();
    if waves {
        simulation.add_task(0.0, Box::new(Wave));
    }
    simulation
}

fn to_end(simulation: &mut Simulation) -> (State, Vec<State>, Metrics) {
    simulation.run_to_end(&mut ()).unwrap();
    let objects = simulation.plant().objects.list.iter().map(|object| object.state.clone()).collect();
    (simulation.state().clone(), objects, simulation.metrics().clone())
}

/// A run continues after a checkpoint as without it, and again after each return, also in another simulation
/// of the same run.
fn returns_to_the_bits(text: &str, waves: bool, times: &[f64]) {
    let end = to_end(&mut simulation(text, waves));
    for time in times {
        let mut first = simulation(text, waves);
        first.advance_to(*time, &mut ()).unwrap();
        let checkpoint: Checkpoint = first.checkpoint().unwrap();
        assert_eq!(to_end(&mut first), end, "{time} s of {text}");
        first.return_to(&checkpoint).unwrap();
        assert_eq!(first.time().to_bits(), checkpoint.time().to_bits());
        assert_eq!(to_end(&mut first), end, "returned to {time} s of {text}");
        let mut other = simulation(text, waves);
        other.advance_to(0.5 * time, &mut ()).unwrap();
        other.return_to(&checkpoint).unwrap();
        assert_eq!(to_end(&mut other), end, "another simulation at {time} s of {text}");
    }
}

#[test]
fn a_return_repeats_the_bits_of_each_method_and_integrator() {
    for (method, integrator) in [
        ("exact", "method = \"dopri5\""),
        ("exact", "method = \"bs23\""),
        ("exact", "method = \"rk4\", step = 1e-4"),
        ("exact", "method = \"semi-implicit\", step = 1e-3"),
        ("exact", "method = \"rosenbrock\""),
        ("exact", "method = \"bdf\""),
        ("penalty", "method = \"bdf\""),
        ("exact", "method = \"auto\""),
        ("one-step", "method = \"dopri5\""),
        ("one-step", "method = \"semi-implicit\", step = 1e-3"),
        ("penalty", "method = \"auto\""),
        ("lcp", "method = \"semi-implicit\", step = 1e-3"),
        ("ncp", "method = \"semi-implicit\", step = 1e-3"),
    ] {
        // HOAP-2 is dropped on its soles, stands, and slips under a push.
        let text = format!(
            "duration = 0.4
            robot = {{ model = \"robots/hoap2/hoap2.toml\", base = {{ position = [0, 0, 0.29] }} }}
            floor.friction = {{ static = 0.3, kinetic = 0.2 }}
            contact.method = \"{method}\"
            integrator = {{ {integrator} }}
            force = [{{ type = \"push\", link = \"torso\", force = [25, 5, 0], start = 0.2, duration = 0.1 }}]"
        );
        returns_to_the_bits(&text, true, &[0.05, 0.25]);
        returns_to_the_bits(&text, false, &[0.02, 0.22]);
    }
}

#[test]
fn a_return_repeats_the_bits_of_links_objects_and_drives_with_memory() {
    let falls = "duration = 0.9
        robot = { model = \"robots/hoap2/hoap2.toml\", joint = { left_knee = { lag = 0.01 } } }
        floor.friction = 0.5
        force = [{ type = \"push\", link = \"torso\", force = [80, 30, 0], start = 0.0, duration = 0.2 }]
        terrain = [{ type = \"box\", size = [0.4, 0.4, 0.03], position = [0.5, 0, 0] }]";
    returns_to_the_bits(falls, true, &[0.3, 0.7]);
    let stack = "duration = 0.6
        robot.model = \"robots/block/block.toml\"
        [[object]]
        name = \"ball\"
        type = \"sphere\"
        radius = 0.05
        mass = 0.3
        position = [0.3, 0.02, 0.2]
        linear_velocity = [-2, 0, 0]
        [[object]]
        name = \"box\"
        type = \"box\"
        size = [0.1, 0.1, 0.1]
        mass = 0.5
        position = [0.0, 0.6, 0.12]
        linear_velocity = [0, -3, 0]";
    returns_to_the_bits(stack, false, &[0.05, 0.15, 0.35]);
}

#[test]
fn what_a_checkpoint_lacks_is_named() {
    let text = |more: &str| format!("duration = 0.3\nrobot.model = \"robots/hoap2/hoap2.toml\"\n{more}");
    // A task with memory that is active, and one that has not begun.
    let posture = |start: f64| {
        text(&format!(
            "task = [{{ type = \"posture\", start = {start}, duration = 0.1, joints = {{ waist_pitch = 0.1 }} }}]"
        ))
    };
    let mut running = simulation(&posture(0.0), false);
    running.advance_to(0.05, &mut ()).unwrap();
    let checkpoint = running.checkpoint().unwrap();
    running.advance_to(0.06, &mut ()).unwrap();
    let before = running.state().clone();
    let message = running.return_to(&checkpoint).unwrap_err().message;
    assert!(message.contains("task `posture`"), "{message}");
    assert_eq!(*running.state(), before);
    let mut waiting = simulation(&posture(0.2), false);
    waiting.advance_to(0.05, &mut ()).unwrap();
    let checkpoint = waiting.checkpoint().unwrap();
    waiting.advance_to(0.1, &mut ()).unwrap();
    waiting.return_to(&checkpoint).unwrap();
    assert_eq!(waiting.time(), checkpoint.time());
    // An event between.
    let mut event = simulation(&text("event = [{ at = 0.1, set = { \"floor.friction\" = 0.2 } }]"), false);
    event.advance_to(0.05, &mut ()).unwrap();
    let checkpoint = event.checkpoint().unwrap();
    event.advance_to(0.15, &mut ()).unwrap();
    let message = event.return_to(&checkpoint).unwrap_err().message;
    assert!(message.contains("event of the scenario"), "{message}");
    // Other runs, and state that is not included.
    let mut block = simulation("robot.model = \"robots/block/block.toml\"", false);
    block.advance_to(0.05, &mut ()).unwrap();
    let message = block.return_to(&checkpoint).unwrap_err().message;
    assert!(message.contains("another run"), "{message}");
    let mut noisy = simulation(&text("sensors = { joint_position = { noise = 1e-4 } }"), false);
    noisy.advance_to(0.05, &mut ()).unwrap();
    let message = noisy.checkpoint().err().unwrap().message;
    assert!(message.contains("errors of sensors"), "{message}");
}
