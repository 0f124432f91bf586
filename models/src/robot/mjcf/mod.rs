//! Reads MJCF, MuJoCo's XML, to the tree of moving links.
//!
//! [`document`] reads the file with its included files, [`attach`] and [`replicate`] expand what
//! creates bodies, [`grammar`] checks names of elements and
//! attributes, [`classes`] resolves defaults. [`bodies`] reads the tree of bodies, [`robot_tree`]
//! chooses the robot in it, and [`moving_tree`] builds links and joints. Actuators, sensors,
//! equalities and keys refer to these. Meaning of all values: [MuJoCo], XML reference.
//!
//! Called by the loader of robots.

mod actuators;
mod attach;
mod bodies;
mod classes;
mod compiler;
mod document;
mod equalities;
mod geoms;
mod grammar;
mod height_fields;
mod ignored;
mod inertials;
mod joints;
mod keyframes;
mod mesh_inertia;
mod meshes;
mod moving_tree;
mod orientation;
mod primitives;
mod replicate;
mod robot_tree;
mod selection;
mod sensors;
mod unused_sections;
mod view;
mod world;

use std::path::{Path, PathBuf};

use super::mass_matrix::mass_matrix;
use super::model::{Base, LinkId, Model};
use super::notices::Notices;
use super::robot_error::RobotError;
use super::urdf::InertiaPolicy;
use crate::sdf;
use crate::text::source::Source;
use document::{Document, ROOT};
use ignored::{Ignored, Role};
use moving_tree::Context;

/// The robot as the file describes it.
pub(super) struct Loaded {
    /// The model, without soles.
    pub model: Model,
    /// Included files and meshes, with their bytes.
    pub files: Vec<(PathBuf, Vec<u8>)>,
    /// Pairs of links that are not checked for collisions.
    pub ignored_pairs: Vec<[LinkId; 2]>,
}

/// Reads an MJCF file. `name`, if given, selects a body under the world with what it carries, or
/// by `MODEL::BODY::GEOM` only that geom; `base`, if given, decides how the root is held.
pub(super) fn load(
    source: &Source,
    name: Option<&str>,
    base: Option<Base>,
    policy: InertiaPolicy,
    notices: &mut Notices,
) -> Result<Loaded, RobotError> {
    let mut document = Document::read(source)?;
    attach::expand(&mut document)?;
    let mut ignored = Ignored::of(if name.is_some() { Role::Part } else { Role::Robot });
    let loaded = read(&document, name, base, policy, &mut ignored)?;
    ignored.report(&document, notices);
    Ok(loaded)
}

/// True for files whose name ends as those of MJCF do.
pub fn is_mjcf_name(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    ["xml", "mjcf"].iter().any(|known| extension.eq_ignore_ascii_case(known))
}

/// Reads an MJCF file as a world. Names of models for which `skip` is true are left out.
///
/// # Errors
/// As for robots, except that there may be any number of mechanisms.
pub fn read_world(source: &Source, skip: &dyn Fn(&str) -> bool) -> Result<sdf::Document, sdf::SdfError> {
    let (world, found) = world::read(source, skip).map_err(|error| world::sdf_error(&error, source))?;
    let mut remarks = sdf::Remarks::default();
    for (at, is_warning, message) in found {
        match is_warning {
            true => remarks.warning(at, message),
            false => remarks.note(at, message),
        }
    }
    Ok(sdf::Document { worlds: vec![world], remarks, ..sdf::Document::default() })
}

fn read(
    document: &Document,
    name: Option<&str>,
    base: Option<Base>,
    policy: InertiaPolicy,
    ignored: &mut Ignored,
) -> Result<Loaded, RobotError> {
    grammar::check(document, ignored)?;
    let compiler = compiler::Compiler::read(document)?;
    let classes = classes::Classes::read(document)?;
    let mut bodies = bodies::Bodies::read(document, &classes, &compiler, ignored)?;
    let kinds = robot_tree::joint_kinds(&bodies, document)?;
    let tree = match name.map(|name| selection::select(&mut bodies, document, name)).transpose()? {
        Some(selection) => robot_tree::choose_one(&bodies, &kinds, document, (selection, base), ignored)?,
        None => robot_tree::choose(&bodies, &kinds, document, base, ignored)?,
    };
    let folder = document.sources[0].path().parent().unwrap_or(Path::new("")).to_owned();
    let meshes = meshes::Meshes::new(&classes, &document.assets("mesh"), &compiler, &folder)?;
    let mut geoms = geoms::Geoms::new(&classes, &document.assets("material"), meshes)?;
    let context = Context { document, compiler: &compiler, bodies: &bodies, kinds: &kinds };
    let mut parts = moving_tree::build(&context, &tree, &mut geoms, policy, ignored)?;
    let ratios = actuators::apply(&context, &classes, &mut parts, ignored)?;
    let conditions = equalities::read(&context, &classes, &parts, tree.base, ignored)?;
    let sensors = sensors::read(document, &bodies, &parts, ignored)?;
    let ignored_pairs = equalities::exclusions(&context, &parts, ignored)?;
    let (home, keyframes) = keyframes::read(&context, &parts, ignored)?;
    let name = document.text(ROOT, "model").unwrap_or_default().to_owned();
    let mut model = Model {
        sensors,
        home,
        keyframes,
        couplings: conditions.couplings,
        loops: conditions.loops,
        ..Model::tree(name, tree.base, parts.links, parts.joints)
    };
    damp_by_ratio(&mut model, &parts.references, &ratios);
    // A model that is attached several times was read as often.
    let sources = &document.sources;
    let is_first = |i: &usize| sources[..*i].iter().all(|other| other.path() != sources[*i].path());
    let included = (1..sources.len())
        .filter(is_first)
        .map(|i| &sources[i])
        .map(|s| (s.path().to_owned(), s.text().as_bytes().to_vec()));
    let files = included.chain(geoms.meshes.files).collect();
    Ok(Loaded { model, files, ignored_pairs })
}

/// The damping of servos with a damping ratio z: `kd = 2 z sqrt(kp m)`, with m the inertia at the
/// joint while all others move freely, `1 / (M^-1)_jj` at the reference positions.
fn damp_by_ratio(model: &mut Model, references: &[f64], ratios: &[actuators::RatioServo]) {
    if ratios.is_empty() {
        return;
    }
    let nb = model.nb();
    let Some(inverse) = mass_matrix(model, references).cholesky().map(|factor| factor.inverse()) else { return };
    for servo in ratios {
        let at = nb + servo.joint;
        let drive = &mut model.joints[servo.joint].drive;
        drive.kd += 2.0 * servo.ratio * (drive.kp / inverse[(at, at)]).sqrt();
    }
}
