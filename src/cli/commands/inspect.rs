//! `runner inspect`: describes a robot as the simulator uses it.

use std::path::PathBuf;

use crate::collision::{self, CollisionModel};
use crate::robot::{self, InertiaPolicy};
use crate::text::visible::visible_lines;
use clap::{Args, ValueEnum};

use crate::cli::{Exit, colour, terminal};

/// Arguments of `inspect`.
#[derive(Args, Debug)]
pub struct Inspect {
    /// A robot file, URDF, MJCF file or SDF
    #[arg(value_name = "ROBOT")]
    robot: PathBuf,

    /// Form of the output
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,

    /// Replace each inertia that no body can have by the nearest physical tensor, and list it
    #[arg(long)]
    repair: bool,
}

/// Form of the output.
#[derive(ValueEnum, Clone, Copy, PartialEq, Debug)]
enum Format {
    /// Tables for people, numbers with six digits
    Text,
    /// One JSON object with all digits and the mass matrix at home
    Json,
}

impl Inspect {
    /// Prints the robot's model.
    pub fn execute(self) -> Result<Exit, Exit> {
        let robot = robot::load_with(&self.robot, self.repair.then_some(InertiaPolicy::Repair)).map_err(|error| {
            terminal::complain_drawn(&error.render(colour::on_stderr()));
            Exit::Invalid
        })?;
        if self.format == Format::Json {
            terminal::print(&format!("{:#}\n", robot::inspect_json(&robot)))?;
            return Ok(Exit::Success);
        }
        terminal::print(&visible_lines(&robot::inspect(&robot)))?;
        let bodies = CollisionModel::new(&robot.model, &robot.self_collision);
        terminal::print(&visible_lines(&collision::inspect(&bodies)))?;
        Ok(Exit::Success)
    }
}
