//! Loads a robot: robot file and URDF or MJCF to a [`Model`], its files and notices.

use std::path::{Path, PathBuf};

use super::apply_robot_file::{apply, note_unread_force_sensors};
use super::coupled_joints;
use super::mesh_simplification::simplify_meshes;
use super::mjcf;
use super::mjcf::is_mjcf_name;
use super::model::{Base, LinkId, Model};
use super::notices::Notices;
use super::robot_error::{FileError, RobotError, read_source};
use super::robot_file::{self, BaseWord, RobotFile};
use super::sdf;
use super::self_collision::{self, SelfCollision};
use super::sole_detection::find_soles;
use super::urdf::{self, InertiaPolicy, Mimic};
use super::xml_syntax::root_element;
use crate::input;
use crate::sdf::is_sdf_name;
use crate::text::diagnostic::Diagnostic;
use crate::text::source::Source;
use crate::text::xml_syntax::root_tag;

/// A loaded robot.
#[derive(Clone, Debug)]
pub struct Robot {
    /// The simulated model.
    pub model: Model,
    /// Every file used with its bytes: the robot file if there is one, the model file,
    /// included files, meshes. For hashing and for logs.
    pub files: Vec<(PathBuf, Vec<u8>)>,
    /// The URDF's text; `None` for a model of another format.
    pub urdf_text: Option<String>,
    /// Notes and warnings: ignored elements, assumptions, detected soles.
    pub notices: Vec<Diagnostic>,
    /// Links that must not touch each other.
    pub self_collision: SelfCollision,
}

/// Loads a robot file (`.toml`), a bare URDF (`.urdf`), MJCF file (`.xml`, `.mjcf`) or SDF (`.sdf`,
/// of several models one by `FILE#MODEL`). Errors: see [`RobotError`]; the first one
/// found is returned.
pub fn load(path: &Path) -> Result<Robot, RobotError> {
    load_with(path, None)
}

/// As [`load`]; `policy`, if given, overrides the robot file's treatment of inertias that no body
/// can have.
pub fn load_with(path: &Path, policy: Option<InertiaPolicy>) -> Result<Robot, RobotError> {
    match model_of_file(path) {
        Some((file, name)) => build(read_source(&file)?, Some(&name), None, policy),
        None => read(read_source(path)?, policy),
    }
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
            let (key, path_in_file) = file.model_path(&source)?;
            let model_path = path.parent().unwrap_or(Path::new("")).join(path_in_file.get_ref());
            let (model_path, name) =
                model_of_file(&model_path).map_or((model_path, None), |(file, name)| (file, Some(name)));
            let model = read_source(&model_path).map_err(|error| {
                let fault = FileError::new(&source, path_in_file.span(), error.to_string()).element(key);
                fault.expected("the path of a URDF, MJCF or SDF file, relative to this file").invalid()
            })?;
            build(model, name.as_deref(), Some((source, file)), policy)
        }
        "urdf" | "xml" | "mjcf" | "sdf" | "world" => build(source, None, None, policy),
        _ => {
            let reason = "it is not a .toml, .urdf, .xml, .mjcf, .sdf or .world file".into();
            Err(RobotError::Read { path, reason })
        }
    }
}

/// File and model of a path `FILE#MODEL`.
fn model_of_file(path: &Path) -> Option<(PathBuf, String)> {
    let (file, model) = path.to_str()?.rsplit_once('#')?;
    let file = PathBuf::from(file);
    let has_models = is_sdf_name(&file) || is_mjcf_name(&file);
    (has_models && !path.exists()).then(|| (file, model.to_owned()))
}

/// Format of a model file.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ModelFormat {
    Urdf,
    Mjcf,
    Sdf,
}

/// A robot as its model file describes it.
struct Described {
    model: Model,
    files: Vec<(PathBuf, Vec<u8>)>,
    mimics: Vec<Mimic>,
    ignored_pairs: Vec<[LinkId; 2]>,
    format: ModelFormat,
}

/// Reads a URDF, an MJCF file if the root element is `<mujoco>`, or an SDF if it is `<sdf>`.
/// `name` selects one of several models of an SDF.
fn describe(
    source: &Source,
    name: Option<&str>,
    base: Option<Base>,
    policy: InertiaPolicy,
    notices: &mut Notices,
) -> Result<Described, RobotError> {
    let format = match root_tag(source.text()) {
        Some((_, "mujoco" | "mujocoinclude")) => ModelFormat::Mjcf,
        Some((_, "sdf")) => ModelFormat::Sdf,
        _ => ModelFormat::Urdf,
    };
    if format == ModelFormat::Mjcf {
        let mjcf::Loaded { model, files, ignored_pairs } = mjcf::load(source, name, base, policy, notices)?;
        return Ok(Described { model, files, mimics: Vec::new(), ignored_pairs, format });
    }
    if let (ModelFormat::Urdf, Some(name)) = (format, name) {
        let fault = FileError::new(source, 0..0, format!("a URDF has one robot: `#{name}` cannot select another"));
        return Err(fault.expected("the path without `#`").invalid());
    }
    let urdf::Loaded { model, meshes, mimics } = match format {
        ModelFormat::Sdf => sdf::load(source, name, base, policy, notices)?,
        _ => urdf::load(source, base, policy, notices)?,
    };
    Ok(Described { model, files: meshes, mimics, ignored_pairs: Vec::new(), format })
}

fn build(
    urdf: Source,
    name: Option<&str>,
    file: Option<(Source, RobotFile)>,
    policy: Option<InertiaPolicy>,
) -> Result<Robot, RobotError> {
    let mut notices = Notices::default();
    let base = file.as_ref().and_then(|(_, f)| f.base.as_ref()).map(|word| match word.get_ref() {
        BaseWord::Fixed => Base::Fixed,
        BaseWord::Floating => Base::Floating,
    });
    let own_policy = file.as_ref().and_then(|(_, f)| f.inertia).map(InertiaPolicy::from);
    let policy = policy.or(own_policy).unwrap_or_default();
    let Described { mut model, files: described, mimics, ignored_pairs, format } =
        describe(&urdf, name, base, policy, &mut notices)?;
    if model.name.trim().is_empty() {
        model.name = urdf.path().file_stem().map_or("robot".into(), |stem| stem.to_string_lossy().into_owned());
        notices.info(&urdf, root_element(&urdf), format!("the robot has no name; `{}` is used", model.name));
    }
    let is_named = |joint: &str| file.as_ref().is_some_and(|(_, f)| f.home.contains_key(joint));
    coupled_joints::add_mimics(&mut model, &mimics, &urdf, &mut notices);
    // An MJCF file has a home, by its key or its references.
    if format == ModelFormat::Mjcf {
        coupled_joints::replace_homes(&mut model, &urdf, root_element(&urdf), &mut notices);
    } else {
        set_default_home(&mut model, &urdf, is_named, &mut notices);
        coupled_joints::set_homes(&mut model);
    }
    let mut files = Vec::new();
    let mut soles_given = false;
    let mut self_collision = SelfCollision::default();
    if let Some((source, file)) = &file {
        apply(file, source, &mut model, &mut notices)?;
        self_collision = self_collision::read(file, source, &model)?;
        soles_given = file.sole.is_some();
        files.push((source.path().to_owned(), source.text().as_bytes().to_vec()));
    }
    self_collision.ignore.extend(ignored_pairs);
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
    files.extend(described);
    warn_about_symbolic_links(&files, &urdf, &mut notices);
    let urdf_text = (format == ModelFormat::Urdf).then(|| urdf.text().to_owned());
    Ok(Robot { model, files, urdf_text, notices: notices.into_diagnostics(), self_collision })
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
        notices.warning(urdf, root_element(urdf), message);
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
