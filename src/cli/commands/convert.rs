//! `runner convert`: writes a robot as URDF or MJCF.

use std::io::Write;
use std::path::{Path, PathBuf};

use crate::convert::{self, RobotFormat};
use crate::files::{RecordError, atomic};
use crate::robot::{self, InertiaPolicy};
use crate::text::visible::visible_path;
use clap::Args;

use crate::cli::terminal::{complain, complain_drawn, complain_of, plural};
use crate::cli::{Exit, colour};

/// Arguments of `convert`.
#[derive(Args, Debug)]
pub struct Convert {
    /// A robot file, a URDF, MJCF file or SDF
    #[arg(value_name = "ROBOT")]
    robot: PathBuf,
    /// File to write: `.urdf`, or `.xml` for MJCF; meshes go to the folder `NAME_meshes` next to it
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Replace existing files
    #[arg(long)]
    force: bool,
    /// Replace each inertia that no body can have by the nearest physical tensor, and list it
    #[arg(long)]
    repair: bool,
}

impl Convert {
    /// Reads the robot and writes it.
    pub fn execute(self) -> Result<Exit, Exit> {
        let ending = self.output.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let format = match ending.as_str() {
            "urdf" => RobotFormat::Urdf,
            "xml" | "mjcf" => RobotFormat::Mjcf,
            _ => return Err(refuse(format!("{}: use .urdf, or .xml for MJCF", visible_path(&self.output)))),
        };
        if self.output.is_dir() {
            return Err(refuse(format!("{} is a folder: give the name of a file", visible_path(&self.output))));
        }
        let stem = self.output.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let robot = robot::load_with(&self.robot, self.repair.then_some(InertiaPolicy::Repair)).map_err(|error| {
            complain_drawn(&error.render(colour::on_stderr()));
            Exit::Invalid
        })?;
        let folder = format!("{stem}_meshes");
        let converted = convert::convert(&robot.model, format, &folder).map_err(refuse)?;
        let inside = self.output.parent().unwrap_or(Path::new("")).join(&folder);
        let meshes = converted.meshes.iter().map(|mesh| (inside.join(&mesh.name), &mesh.text));
        let files: Vec<(PathBuf, &String)> = meshes.chain([(self.output.clone(), &converted.text)]).collect();
        for (path, text) in &files {
            let is_input = robot.files.iter().any(|(input, _)| same_file(input, path));
            if is_input {
                return Err(refuse(format!("{} is a file of the robot itself: choose another", visible_path(path))));
            }
            // A mesh of another format may be there already.
            let is_same = || std::fs::read(path).is_ok_and(|bytes| bytes == text.as_bytes());
            if path.symlink_metadata().is_ok() && !self.force && !is_same() {
                return Err(refuse(format!("{} exists: choose another file, or give `--force`", visible_path(path))));
            }
        }
        for (path, text) in &files {
            let fill = |out: &mut dyn Write| out.write_all(text.as_bytes()).map_err(RecordError::io(path));
            atomic::write(path, |out| fill(out)).map_err(|error| {
                complain_of(&error);
                Exit::of_writing(&error)
            })?;
        }
        if !robot.self_collision.ignore.is_empty() {
            let pairs = plural(robot.self_collision.ignore.len(), "pair");
            complain(&format!("warning: {pairs} of links that are not checked for self-collision: not written"));
        }
        for warning in &converted.warnings {
            complain(&format!("warning: {warning}"));
        }
        let model = &robot.model;
        let meshes = match converted.meshes.len() {
            0 => String::new(),
            count => format!(", {} in {}", plural(count, "mesh file"), visible_path(&inside)),
        };
        let (links, joints) = (plural(model.links.len(), "link"), plural(model.nj(), "joint"));
        complain(&format!("{}: {links}, {joints}{meshes}", visible_path(&self.output)));
        Ok(Exit::Success)
    }
}

/// Do both paths name the same existing file?
fn same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

fn refuse(why: String) -> Exit {
    complain_of(why);
    Exit::Invalid
}
