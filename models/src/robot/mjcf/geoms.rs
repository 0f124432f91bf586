//! Geoms: shapes for drawing and collision, and their mass.

use std::collections::HashMap;

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, SymmetricEigen, UnitQuaternion, Vector3};

use super::bodies::{Held, between};
use super::classes::Classes;
use super::compiler::Compiler;
use super::document::Id;
use super::ignored::Ignored;
use super::meshes::Meshes;
use super::primitives::Primitive;
use super::view::View;
use crate::geometry::spatial_hull::{convex_hull_3d, spread};
use crate::robot::model::{Geometry, Shape};
use crate::robot::rigid_inertia::RigidInertia;
use crate::robot::robot_error::RobotError;

/// MuJoCo's density of a geom without mass, kg/m^3.
const DENSITY: f64 = 1000.0;
/// MuJoCo's colour of a geom.
const GREY: [f32; 4] = [0.5, 0.5, 0.5, 1.0];
/// Groups that MuJoCo's viewer draws at first.
const DRAWN_GROUPS: std::ops::RangeInclusive<f64> = 0.0..=2.0;
/// Points of the polyhedron that replaces an ellipsoid.
const ELLIPSOID_POINTS: usize = 200;
/// Largest size, m, and mass, kg, of a geom.
const MAX_SIZE: f64 = 1e4;
const MAX_MASS: f64 = 1e12;

/// Reads geoms; keeps meshes and colours.
pub(super) struct Geoms<'a> {
    pub meshes: Meshes<'a>,
    materials: HashMap<&'a str, View<'a>>,
}

/// A geom in the frame of its body.
pub(super) struct Geom {
    pub visual: Option<Shape>,
    pub collision: Option<Shape>,
    /// Mass properties, if the geom has any; with an error, why they cannot be computed.
    pub inertia: Result<Option<RigidInertia>, RobotError>,
}

impl<'a> Geoms<'a> {
    pub fn new(classes: &Classes<'a>, materials: &[Id], meshes: Meshes<'a>) -> Result<Self, RobotError> {
        let mut named = HashMap::new();
        for &id in materials {
            let view = classes.view(id, None)?;
            if let Some(name) = view.document.text(id, "name") {
                named.insert(name, view);
            }
        }
        Ok(Self { meshes, materials: named })
    }

    /// # Errors
    /// Values that are not valid, a mesh that is not in the file.
    pub fn read(&mut self, held: &Held, compiler: &Compiler, ignored: &mut Ignored) -> Result<Geom, RobotError> {
        let view = &held.view;
        let words = ["plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "sdf"];
        let kind = view.word("type", &words)?.unwrap_or("sphere");
        let (own, half) = between(view, compiler)?;
        let pose = held.frame * own;
        let none = || Geom { visual: None, collision: None, inertia: Ok(None) };
        if matches!(kind, "plane" | "hfield" | "sdf") {
            ignored.warning(view.id(), format!("geoms of type {kind} are left out"));
            return Ok(none());
        }
        let mass = view.number("mass")?;
        let density = view.number("density")?.unwrap_or(DENSITY);
        for (name, value) in [("mass", mass.unwrap_or(0.0)), ("density", density)] {
            if !(0.0..=MAX_MASS).contains(&value) {
                return Err(view.fault(name, format!("a number, not negative and at most {MAX_MASS:e}")).invalid());
            }
        }
        let shell = view.flag("shellinertia")?.unwrap_or(false);
        let (pose, geometry, unit) = if kind == "mesh" {
            let mesh = match self.meshes.get(view, compiler)? {
                Ok(mesh) => mesh,
                Err(reason) => return Ok(left_out(view, &reason, ignored)),
            };
            let geometry = Geometry::Mesh(mesh.vertices.clone(), mesh.triangles.clone());
            (pose, geometry, mesh.inertia(shell).map_err(|why| format!("the mass of mesh `{}`: {why}", text(view))))
        } else {
            let (pose, primitive) = match view.has("mesh") {
                false => (pose, primitive(view, kind, half)?),
                true => match self.fitted(view, kind, compiler)? {
                    Ok((fit, primitive)) => (pose * fit, primitive),
                    Err(reason) => return Ok(left_out(view, &reason, ignored)),
                },
            };
            let unit = match shell {
                false => Ok(primitive.solid()),
                true => primitive.shell().ok_or("the shell of an ellipsoid has no closed form".to_owned()),
            };
            (pose, geometry(&primitive), unit)
        };
        // A geom without mass needs no inertia.
        let inertia = match (mass, unit) {
            (Some(0.0), _) => Ok(None),
            (None, _) if density == 0.0 => Ok(None),
            (mass, Ok(unit)) => {
                let factor = mass.map_or(density, |mass| mass / unit.mass);
                let (mass, tensor) = (unit.mass * factor, unit.tensor * factor);
                Ok((mass > 0.0).then(|| RigidInertia { mass, tensor, ..unit }.transformed(&pose)))
            }
            (_, Err(why)) => {
                let fault = view.document.fault(view.id(), format!("{why}: the geom's mass cannot be computed"));
                Err(fault.expected("an <inertial> of the body, or mass=\"0\"").invalid())
            }
        };
        let rgba = self.colour(view)?;
        let collides = Self::collides(view)?;
        let is_drawn = !collides || DRAWN_GROUPS.contains(&view.number("group")?.unwrap_or(0.0));
        let shape = Shape { pose, geometry, rgba };
        let visual = is_drawn.then(|| shape.clone());
        Ok(Geom { visual, collision: collides.then_some(shape), inertia })
    }

    /// True for a geom that can touch others.
    pub fn collides(view: &View) -> Result<bool, RobotError> {
        let is_contact = |name| Ok(view.number(name)?.unwrap_or(1.0) != 0.0);
        Ok(is_contact("contype")? | is_contact("conaffinity")?)
    }

    /// The geom's own colour, or that of its material.
    fn colour(&self, view: &View) -> Result<[f32; 4], RobotError> {
        let own = view.array::<4>("rgba")?;
        let of_material = || match view.text("material").and_then(|name| self.materials.get(name)) {
            Some(material) => material.array::<4>("rgba").map(|c| Some(c.unwrap_or([1.0; 4]))),
            None => Ok(None),
        };
        let rgba = if own.is_some() { own } else { of_material()? };
        Ok(rgba.map_or(GREY, |c| c.map(|x| x.clamp(0.0, 1.0) as f32)))
    }

    /// A primitive with the inertia of a mesh, and its pose in the mesh's frame: the half edges of
    /// the box of equal inertia follow from the principal moments.
    fn fitted(
        &mut self,
        view: &View,
        kind: &str,
        compiler: &Compiler,
    ) -> Result<Result<(Isometry3<f64>, Primitive), String>, RobotError> {
        if compiler.fit_box {
            let fault = view.fault("mesh", "fitaabb=\"false\" of <compiler>, or a size instead of a mesh");
            return Err(fault.not_available());
        }
        let scale = view.number("fitscale")?.unwrap_or(1.0);
        let mesh = match self.meshes.get(view, compiler)? {
            Ok(mesh) => mesh,
            Err(reason) => return Ok(Err(reason)),
        };
        let body = match mesh.inertia(false) {
            Ok(body) => body,
            Err(why) => return Ok(Err(format!("mesh `{}`: {why}", text(view)))),
        };
        let eigen = SymmetricEigen::new(body.tensor);
        let mut order = [0, 1, 2];
        // The largest moment first, so that the longest edge is along z.
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        let moments = Vector3::from_fn(|i, _| eigen.eigenvalues[order[i]]);
        let half = moments.map(|m| 0.5 * (6.0 * (moments.sum() - 2.0 * m).max(0.0) / body.mass).sqrt()) * scale;
        let mut axes = Matrix3::from_columns(&order.map(|i| eigen.eigenvectors.column(i).into_owned()));
        if axes.determinant() < 0.0 {
            axes.set_column(2, &-axes.column(2).into_owned());
        }
        let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
        let fit = Isometry3::from_parts(body.com.into(), rotation);
        let across = 0.5 * (half.x + half.y);
        let primitive = match kind {
            "sphere" => Primitive::Sphere(half.mean()),
            "capsule" => Primitive::Capsule(across, (half.z - 0.5 * across).max(0.0)),
            "cylinder" => Primitive::Cylinder(across, half.z),
            "ellipsoid" => Primitive::Ellipsoid(half),
            _ => Primitive::Box(half),
        };
        Ok(Ok((fit, primitive)))
    }
}

fn text<'a>(view: &View<'a>) -> &'a str {
    view.text("mesh").unwrap_or_default()
}

/// A geom whose mesh cannot be read: an error only if its mass is needed.
fn left_out(view: &View, reason: &str, ignored: &mut Ignored) -> Geom {
    let message = format!("mesh `{}` cannot be read: {reason}", text(view));
    ignored.warning(view.id(), format!("{message}: its geoms are left out"));
    let has_none = |name| view.text(name).is_some_and(|text| text.trim().parse() == Ok(0.0));
    let fault = view.document.fault(view.id(), format!("{message}: the mass of its geom is not known"));
    let inertia = match has_none("mass") || has_none("density") && !view.has("mass") {
        true => Ok(None),
        false => Err(fault.expected("the mesh, or an <inertial> of the body").invalid()),
    };
    Geom { visual: None, collision: None, inertia }
}

/// A primitive by `size`, with the half length between two points if there is one.
fn primitive(view: &View, kind: &str, half: Option<f64>) -> Result<Primitive, RobotError> {
    let [mut a, mut b, mut c] = view.overlay("size", [0.0; 3])?;
    match (kind, half) {
        ("capsule" | "cylinder", Some(half)) => b = half,
        ("box" | "ellipsoid", Some(half)) => (b, c) = (a, half),
        ("sphere", Some(_)) => {
            return Err(view.fault("fromto", "a capsule, cylinder, ellipsoid or box").invalid());
        }
        _ => {}
    }
    let count = match kind {
        "sphere" => 1,
        "capsule" | "cylinder" => 2,
        _ => 3,
    };
    let is_size = |x: &f64| *x > 0.0 && *x <= MAX_SIZE;
    if ![a, b, c][..count].iter().all(is_size) {
        let fault = view.fault("size", format!("{count} numbers above 0 and at most {MAX_SIZE:e} for a {kind}"));
        return Err(fault.invalid());
    }
    if kind == "sphere" {
        (b, c) = (a, a);
    } else if count == 2 {
        (a, b, c) = (a, b, b);
    }
    Ok(match kind {
        "sphere" => Primitive::Sphere(a),
        "capsule" => Primitive::Capsule(a, b),
        "cylinder" => Primitive::Cylinder(a, b),
        "ellipsoid" => Primitive::Ellipsoid(Vector3::new(a, b, c)),
        _ => Primitive::Box(Vector3::new(a, b, c)),
    })
}

/// The geometry of a primitive, by whole lengths; a polyhedron for an ellipsoid.
fn geometry(primitive: &Primitive) -> Geometry {
    match *primitive {
        Primitive::Sphere(r) => Geometry::Sphere(r),
        Primitive::Capsule(r, h) => Geometry::Capsule(r, 2.0 * h),
        Primitive::Cylinder(r, h) => Geometry::Cylinder(r, 2.0 * h),
        Primitive::Box(half) => Geometry::Box(2.0 * half),
        Primitive::Ellipsoid(axes) => {
            let points = spread(ELLIPSOID_POINTS).into_iter().map(|d| Point3::from(d.component_mul(&axes)));
            let points: Vec<Point3<f64>> = points.collect();
            let (vertices, triangles) = convex_hull_3d(&points).unwrap_or((points, Vec::new()));
            Geometry::Mesh(vertices, triangles)
        }
    }
}
