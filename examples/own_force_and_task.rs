//! A force model and a task written in Rust: a block hangs on a rubber band, and a humanoid nods.
//!
//!     cargo run --release --example own_force_and_task

// The functions of `f64` may give other last digits on another processor.
#![allow(clippy::disallowed_methods)]

use std::error::Error;
use stiction::nalgebra::{Point3, Vector3};
use stiction::{AppliedForces, Command, Context, Force, ForceContext, Scenario, Status, Task, TaskResult};

/// Pulls the root link towards a fixed point: `f = -k (p - p0)`.
struct Band {
    anchor: Point3<f64>,
    stiffness: f64,
}

impl Force for Band {
    fn evaluate(&mut self, context: &ForceContext, applied: &mut AppliedForces) {
        let root = stiction::LinkId(0);
        let point = context.state.position;
        let force = -self.stiffness * (point - self.anchor.coords);
        applied.wrench(context, root, &point, &force, &Vector3::zeros());
    }
}

/// Swings one joint: `q = amplitude sin(2 pi t)`.
struct Nod {
    joint: usize,
    amplitude: f64,
    start: f64,
}

impl Task for Nod {
    fn init(&mut self, context: &Context, _: &Command) -> TaskResult {
        self.start = context.start;
        Ok(Status::Running)
    }

    fn run(&mut self, context: &Context, command: &mut Command) -> TaskResult {
        let (sin, cos) = (std::f64::consts::TAU * (context.time - self.start)).sin_cos();
        command.position[self.joint] = self.amplitude * sin;
        command.velocity[self.joint] = std::f64::consts::TAU * self.amplitude * cos;
        Ok(Status::Running)
    }

    fn name(&self) -> &str {
        "nod"
    }
}

pub fn main() -> Result<(), Box<dyn Error>> {
    // The block's mass is 1 kg: without gravity it swings about the anchor with the angular frequency sqrt(k / m) = 5 / s.
    let text = r#"
        duration = 1.0
        gravity = [0, 0, 0]
        robot = { model = "robots/block/block.toml", base = { position = [0.1, 0, 1] } }
    "#;
    let mut setup = Scenario::parse("band.toml", text)?.runs()?[0].setup()?;
    setup.forces.push(Box::new(Band { anchor: Point3::new(0.0, 0.0, 1.0), stiffness: 25.0 }));
    let mut simulation = stiction::Simulation::new(setup)?;
    simulation.run_to_end(&mut ())?;
    let (x, expected) = (simulation.state().position.x, 0.1 * 5f64.cos());
    println!("band: x = {x:.9} m, closed form {expected:.9} m");
    // The integrator's default relative tolerance is 1e-6.
    assert!((x - expected).abs() < 1e-6);

    let text = "duration = 1.25\nrobot = { model = \"robots/hoap2/hoap2.toml\" }";
    let mut setup = Scenario::parse("nod.toml", text)?.runs()?[0].setup()?;
    let joint =
        setup.model.joints.iter().position(|joint| joint.name.contains("head")).ok_or("no joint of the head")?;
    setup.tasks.add(0.0, Box::new(Nod { joint, amplitude: 0.2, start: 0.0 }));
    let mut simulation = stiction::Simulation::new(setup)?;
    simulation.run_to_end(&mut ())?;
    println!("nod: {} at {:.3} rad", simulation.model().joints[joint].name, simulation.state().joints[joint]);
    Ok(())
}
