//! Settings of `<compiler>`.

use std::path::PathBuf;

use super::document::{Document, ROOT};
use super::view::View;
use crate::robot::robot_error::RobotError;

/// When inertias follow from geoms.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum FromGeoms {
    /// Also where there is an `<inertial>`.
    Always,
    Never,
    /// Where there is no `<inertial>`.
    Auto,
}

/// Settings of all `<compiler>` elements, later ones over earlier ones.
pub(super) struct Compiler {
    /// Radians per unit of an angle in the file.
    pub angle: f64,
    /// Axes of `euler`: lower case turns with the body, upper case does not.
    pub eulerseq: [char; 3],
    pub autolimits: bool,
    pub from_geoms: FromGeoms,
    /// Groups of geoms that have mass.
    pub groups: [f64; 2],
    /// Least mass of a body, kg.
    pub bound_mass: f64,
    /// Least principal moment of a body, kg m^2.
    pub bound_inertia: f64,
    pub balance: bool,
    /// Mass to which all bodies are scaled, kg, if above 0.
    pub total_mass: f64,
    /// Folder of meshes, relative to the main file.
    pub mesh_folder: PathBuf,
    pub strip_path: bool,
    /// Fits primitives to the bounding box of a mesh instead of its inertia.
    pub fit_box: bool,
    /// Meshes without an `inertia` attribute count by their signed volume.
    pub exact_meshes: bool,
}

impl Compiler {
    /// The first setting that differs, besides the folder of meshes.
    pub fn difference(&self, other: &Self) -> Option<&'static str> {
        let same = [
            ("angle", self.angle == other.angle),
            ("eulerseq", self.eulerseq == other.eulerseq),
            ("autolimits", self.autolimits == other.autolimits),
            ("inertiafromgeom", self.from_geoms == other.from_geoms),
            ("inertiagrouprange", self.groups == other.groups),
            ("boundmass", self.bound_mass == other.bound_mass),
            ("boundinertia", self.bound_inertia == other.bound_inertia),
            ("balanceinertia", self.balance == other.balance),
            ("settotalmass", self.total_mass <= 0.0 && other.total_mass <= 0.0),
            ("strippath", !self.strip_path && !other.strip_path),
            ("fitaabb", self.fit_box == other.fit_box),
            ("exactmeshinertia", self.exact_meshes == other.exact_meshes),
        ];
        same.into_iter().find(|(_, is_same)| !is_same).map(|(name, _)| name)
    }

    pub fn read(document: &Document) -> Result<Self, RobotError> {
        // The last one first, as default classes come after an element's own attributes.
        let mut levels: Vec<_> = document.section("compiler").collect();
        levels.reverse();
        levels.push(ROOT);
        let view = View { document, levels };
        if let Some("global") = view.word("coordinate", &["local", "global"])? {
            let fault = view.fault("coordinate", "local coordinates");
            return Err(fault.help("MuJoCo 2.3 or older saves such a file in local coordinates").not_available());
        }
        let letters = view.text("eulerseq").unwrap_or("xyz");
        let eulerseq: Option<[char; 3]> = letters.chars().collect::<Vec<_>>().try_into().ok();
        let is_axis = |letters: &[char; 3]| letters.iter().all(|c| "xyzXYZ".contains(*c));
        let Some(eulerseq) = eulerseq.filter(is_axis) else {
            return Err(view.fault("eulerseq", "three letters of xyzXYZ").invalid());
        };
        let angle = view.word("angle", &["degree", "radian"])?.unwrap_or("degree");
        let from_geoms = view.word("inertiafromgeom", &["true", "false", "auto"])?.unwrap_or("auto");
        let folder = view.text("meshdir").or(view.text("assetdir")).unwrap_or_default();
        Ok(Self {
            angle: if angle == "radian" { 1.0 } else { std::f64::consts::PI / 180.0 },
            eulerseq,
            autolimits: view.flag("autolimits")?.unwrap_or(true),
            from_geoms: match from_geoms {
                "true" => FromGeoms::Always,
                "false" => FromGeoms::Never,
                _ => FromGeoms::Auto,
            },
            groups: view.array("inertiagrouprange")?.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]),
            bound_mass: view.amount("boundmass")?,
            bound_inertia: view.amount("boundinertia")?,
            balance: view.flag("balanceinertia")?.unwrap_or(false),
            total_mass: view.number("settotalmass")?.unwrap_or(-1.0),
            mesh_folder: PathBuf::from(folder),
            strip_path: view.flag("strippath")?.unwrap_or(false),
            fit_box: view.flag("fitaabb")?.unwrap_or(false),
            exact_meshes: view.flag("exactmeshinertia")?.unwrap_or(false),
        })
    }
}
