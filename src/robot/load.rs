//! Loads a robot: robot file and URDF to a [`Model`], its files and notices.

use std::path::{Path, PathBuf};

use super::apply_robot_file::{apply, note_unread_force_sensors};
use super::coupled_joints;
use super::mesh_simplification::simplify_meshes;
use super::model::{Base, Model};
use super::notices::Notices;
use super::robot_error::{FileError, RobotError, read_source};
use super::robot_file::{self, BaseWord, RobotFile};
use super::self_collision::{self, SelfCollision};
use super::sole_detection::find_soles;
use super::urdf::{self, InertiaPolicy};
use crate::files::input;
use crate::text::diagnostic::Diagnostic;
use crate::text::source::Source;

/// A loaded robot.
#[derive(Clone, Debug)]
pub struct Robot {
    /// The simulated model.
    pub model: Model,
    /// Every file used with its bytes: the robot file if there is one, the URDF, meshes. For
    /// hashing and for logs.
    pub files: Vec<(PathBuf, Vec<u8>)>,
    /// The URDF's text.
    pub urdf_text: String,
    /// Notes and warnings: ignored elements, assumptions, detected soles.
    pub notices: Vec<Diagnostic>,
    /// Links that must not touch each other.
    pub self_collision: SelfCollision,
}

/// Loads a robot file (`.toml`) or a bare URDF (`.urdf`). Errors: see [`RobotError`]; the first one
/// found is returned.
pub fn load(path: &Path) -> Result<Robot, RobotError> {
    load_with(path, None)
}

/// As [`load`]; `policy`, if given, overrides the robot file's treatment of inertias that no body
/// can have.
pub fn load_with(path: &Path, policy: Option<InertiaPolicy>) -> Result<Robot, RobotError> {
    read(read_source(path)?, policy)
}

/// As [`load_with`], for a text. Errors name `path`; its extension gives the format, and other
/// files are relative to it.
pub fn parse(path: &Path, text: impl Into<String>, policy: Option<InertiaPolicy>) -> Result<Robot, RobotError> {
    read(Source::new(path, text), policy)
}

fn read(source: Source, policy: Option<InertiaPolicy>) -> Result<Robot, RobotError> {
    let path = source.path().to_owned();
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    match extension.as_str() {
        "toml" => {
            let file = robot_file::parse(&source)?;
            let urdf_path = path.parent().unwrap_or(Path::new("")).join(file.urdf.get_ref());
            let urdf = read_source(&urdf_path).map_err(|error| {
                let fault = FileError::new(&source, file.urdf.span(), error.to_string()).element("urdf");
                fault.expected("the path of a URDF, relative to this file").invalid()
            })?;
            build(urdf, Some((source, file)), policy)
        }
        "urdf" | "xml" => build(source, None, policy),
        _ => Err(RobotError::Read { path, reason: "it is neither a .toml nor a .urdf file".into() }),
    }
}

fn build(urdf: Source, file: Option<(Source, RobotFile)>, policy: Option<InertiaPolicy>) -> Result<Robot, RobotError> {
    let mut notices = Notices::default();
    let base = file.as_ref().and_then(|(_, f)| f.base.as_ref()).map(|word| match word.get_ref() {
        BaseWord::Fixed => Base::Fixed,
        BaseWord::Floating => Base::Floating,
    });
    let own_policy = file.as_ref().and_then(|(_, f)| f.inertia).map(InertiaPolicy::from);
    let policy = policy.or(own_policy).unwrap_or_default();
    let urdf::Loaded { mut model, meshes, mimics } = urdf::load(&urdf, base, policy, &mut notices)?;
    if model.name.trim().is_empty() {
        model.name = urdf.path().file_stem().map_or("robot".into(), |stem| stem.to_string_lossy().into_owned());
        notices.info(
            &urdf,
            urdf.text().find("<robot").unwrap_or(0),
            format!("the robot has no name; `{}` is used", model.name),
        );
    }
    let is_named = |joint: &str| file.as_ref().is_some_and(|(_, f)| f.home.contains_key(joint));
    set_default_home(&mut model, &urdf, is_named, &mut notices);
    coupled_joints::add_mimics(&mut model, &mimics, &urdf, &mut notices);
    coupled_joints::set_homes(&mut model);
    let mut files = Vec::new();
    let mut soles_given = false;
    let mut self_collision = SelfCollision::default();
    if let Some((source, file)) = &file {
        apply(file, source, &mut model, &mut notices)?;
        self_collision = self_collision::read(file, source, &model)?;
        soles_given = file.sole.is_some();
        files.push((source.path().to_owned(), source.text().as_bytes().to_vec()));
    }
    coupled_joints::note_homes(&model, &urdf, &mut notices);
    if !soles_given {
        find_soles(&mut model, &urdf, &mut notices);
    }
    if let Some((source, file)) = &file {
        note_unread_force_sensors(file, source, &model, &mut notices);
    }
    // Soles are detected on the original meshes.
    simplify_meshes(&mut model, &urdf, &mut notices);
    files.push((urdf.path().to_owned(), urdf.text().as_bytes().to_vec()));
    files.extend(meshes);
    warn_about_symbolic_links(&files, &urdf, &mut notices);
    Ok(Robot { model, files, urdf_text: urdf.text().to_owned(), notices: notices.into_diagnostics(), self_collision })
}

/// Warns about symbolic links out of the robot's folder; their targets are read.
fn warn_about_symbolic_links(files: &[(PathBuf, Vec<u8>)], urdf: &Source, notices: &mut Notices) {
    let Some(home) = files.first().and_then(|(path, _)| path.parent()) else { return };
    let outside = files.iter().filter_map(|(path, _)| Some((path, input::outside_target(home, path)?)));
    let outside: Vec<_> = outside.collect();
    if let Some((path, real)) = outside.first() {
        let (path, real, more) = (path.display(), real.display(), outside.len() - 1);
        let others = if more == 0 { String::new() } else { format!("; so do links of {more} more files") };
        let message = format!("a symbolic link leads out of the robot's folder: {path} is {real}{others}");
        notices.warning(urdf, urdf.text().find("<robot").unwrap_or(0), message);
    }
}

/// Sets the home of each joint to 0, or to the limit nearest to 0. `is_named` is true for joints in
/// the robot file's `home`, which need no note.
fn set_default_home(model: &mut Model, urdf: &Source, is_named: impl Fn(&str) -> bool, notices: &mut Notices) {
    for (joint, home) in model.joints.iter().zip(&mut model.home) {
        *home = 0.0f64.clamp(joint.lower, joint.upper);
        if *home != 0.0 && !is_named(&joint.name) {
            let at = urdf.text().find(&format!("\"{}\"", joint.name)).unwrap_or(0);
            let message = format!("0 is outside the limits of joint `{}`: its home is {home}", joint.name);
            notices.info(urdf, at, message);
        }
    }
}
