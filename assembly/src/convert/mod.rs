//! Writes a loaded robot as URDF or MJCF (MuJoCo), with its meshes as OBJ files.
//!
//! The text is what the program understood: links with everything welded to them, in SI units.
//! Numbers have the fewest digits that read back to the same bits. What a format cannot hold is
//! listed as warnings.
//!
//! Imports: `math`, `geometry`, `robot`. Used by: `log`, `batch`, `cli`.

mod mesh_files;
mod mjcf;
mod mjcf_inertia;
mod mjcf_parts;
mod urdf;
mod xml_text;

use crate::robot::{DriveMode, Model};

pub use mesh_files::MeshFile;
pub use urdf::{AXIS_LINK, description};

/// A format of robots.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum RobotFormat {
    /// URDF.
    Urdf,
    /// MJCF of MuJoCo.
    Mjcf,
}

/// A converted robot.
#[derive(Clone, PartialEq, Debug)]
pub struct Converted {
    /// The robot's file.
    pub text: String,
    /// Meshes that it names.
    pub meshes: Vec<MeshFile>,
    /// What the format cannot hold.
    pub warnings: Vec<String>,
}

/// Converts a robot. Meshes are in `folder`, relative to the robot's file.
///
/// # Errors
/// As URDF, a link whose only inertia about its joint is the joint's armature, which URDF lacks.
pub fn convert(model: &Model, format: RobotFormat, folder: &str) -> Result<Converted, String> {
    match format {
        RobotFormat::Urdf => urdf::write(model, folder),
        RobotFormat::Mjcf => Ok(mjcf::write(model, folder)),
    }
}

/// Warnings about properties of joints that a format does not hold; MJCF `holds_drives` and
/// armature.
fn joint_warnings(model: &Model, holds_drives: bool, warnings: &mut Vec<String>) {
    type Test = fn(&crate::robot::Joint) -> bool;
    let tests: [(&str, Test, bool); 6] = [
        ("armature", |j| j.armature != 0.0, !holds_drives),
        ("the lag of the actuator", |j| j.lag != 0.0, true),
        ("static friction", |j| j.static_friction > j.friction, true),
        ("the end stop", |j| j.stop.is_some(), true),
        ("the drive", |j| !matches!(j.drive.mode, DriveMode::Passive | DriveMode::Kinematic), !holds_drives),
        ("the drive of mode `kinematic`", |j| j.drive.mode == DriveMode::Kinematic, true),
    ];
    for (what, test, is_lost) in tests {
        let names: Vec<&str> = model.joints.iter().filter(|j| is_lost && test(j)).map(|j| j.name.as_str()).collect();
        list(what, "joint", &names, warnings);
    }
    let coupled = model.transmissions.iter().filter(|transmission| transmission.is_coupled());
    let names: Vec<&str> = coupled.map(|transmission| transmission.name.as_str()).collect();
    list("the coupling of motors", "transmission", &names, warnings);
}

/// A warning that names the first of several elements.
fn list(what: &str, kind: &str, names: &[&str], warnings: &mut Vec<String>) {
    match names {
        [] => {}
        [only] => warnings.push(format!("{what} of {kind} `{only}` is not written")),
        [first, rest @ ..] => {
            warnings.push(format!("{what} of {kind} `{first}` and {} more is not written", rest.len()));
        }
    }
}
