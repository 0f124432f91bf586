//! Drives, limits, friction and lag of joints against closed forms and conservation laws.

mod continuous;
mod drives;
mod friction;
mod kinematic;
mod lag;
mod stiff;
mod stops;
mod transmissions;

use crate::support::runs::root;
use stiction::assemble;
use stiction::robot;
use stiction::scenario;
use stiction::sim::Simulation;
use stiction::task::{Command, Context, Status, Task, TaskResult};

/// Commands as functions of time: `(joint, time) -> [position, velocity, effort]`.
struct CommandTask<F>(F);

impl<F: Fn(usize, f64) -> [f64; 3] + Send + 'static> Task for CommandTask<F> {
    fn init(&mut self, _: &Context, _: &Command) -> TaskResult {
        Ok(Status::Running)
    }

    fn run(&mut self, context: &Context, command: &mut Command) -> TaskResult {
        for j in 0..command.position.len() {
            [command.position[j], command.velocity[j], command.effort[j]] = (self.0)(j, context.time);
        }
        Ok(Status::Running)
    }

    fn name(&self) -> &str {
        "commanded"
    }
}

/// Assembles a scenario with this URDF, or with its own robot if `None`; `command` drives the
/// joints.
fn simulation(
    urdf: Option<&str>,
    text: &str,
    command: Option<impl Fn(usize, f64) -> [f64; 3] + Send + 'static>,
) -> Simulation {
    let file = scenario::parse(&root().join("test.toml"), text).unwrap_or_else(|e| panic!("{e}"));
    let runs = file.expand(&[]).unwrap_or_else(|e| panic!("{e}"));
    let folder = tempfile::tempdir().expect("a folder");
    let path = match urdf {
        Some(urdf) => {
            let path = folder.path().join("robot.urdf");
            std::fs::write(&path, urdf).expect("written");
            path
        }
        None => runs[0].resolve(&runs[0].scenario.robot.model),
    };
    let robot = robot::load(&path).unwrap_or_else(|e| panic!("{e}"));
    let mut setup = assemble::setup(&runs[0], &robot).unwrap_or_else(|e| panic!("{e}"));
    if let Some(command) = command {
        setup.tasks.add(0.0, Box::new(CommandTask(command)));
    }
    Simulation::new(setup).unwrap_or_else(|e| panic!("{e}"))
}

/// No commands.
const NO_COMMANDS: Option<fn(usize, f64) -> [f64; 3]> = None;

/// A link with its centre of mass at `[x, 0, 0]` and the moment of inertia `inertia` about every axis.
fn link(name: &str, mass: f64, x: f64, inertia: f64) -> String {
    format!(
        "<link name=\"{name}\"><inertial><origin xyz=\"{x} 0 0\"/><mass value=\"{mass:e}\"/>
        <inertia ixx=\"{inertia:e}\" iyy=\"{inertia:e}\" izz=\"{inertia:e}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>"
    )
}

/// A joint that turns freely about `axis` through `[x, 0, 0]` of its parent.
fn hinge(name: &str, parent: &str, child: &str, x: f64, axis: &str) -> String {
    format!(
        "<joint name=\"{name}\" type=\"continuous\"><origin xyz=\"{x} 0 0\"/><parent link=\"{parent}\"/>
        <child link=\"{child}\"/><axis xyz=\"{axis}\"/></joint>"
    )
}

fn robot(parts: &[String]) -> String {
    format!("<robot name=\"rig\">{}</robot>", parts.concat())
}

/// A wheel of this inertia on a fixed axle; gravity exerts no moment about it.
fn wheel(inertia: f64) -> String {
    robot(&[
        "<link name=\"world\"/>".into(),
        hinge("axle", "world", "wheel", 0.0, "0 0 1"),
        link("wheel", 1.0, 0.0, inertia),
    ])
}
