//! Reads poses, shapes and inertias.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::document::{Geometry, Inertial, SdfError, Shape, WrittenPose};
use super::pose::Pose;
use super::remarks::Remarks;
use super::xml::{Element, MAX_COORDINATE, MAX_MASS};

/// Deviation of a quaternion from unit length that is not reported.
const UNIT: f64 = 1e-3;

/// The `<pose>` of an element: x y z and roll pitch yaw, rad; with `degrees` in degrees; with
/// `rotation_format="quat_xyzw"` x y z and qx qy qz qw.
pub(super) fn pose(owner: &Element, remarks: &mut Remarks) -> Result<WrittenPose, SdfError> {
    let Some(element) = owner.child("pose")? else {
        return Ok(WrittenPose { pose: Pose::IDENTITY, relative_to: None, at: owner.at() });
    };
    let relative_to = element.named("relative_to");
    if element.named("frame").is_some() {
        remarks.ignore(element.at(), "attribute `frame` of <pose>".into());
    }
    let in_degrees = match element.attribute("degrees") {
        None | Some("false" | "0") => false,
        Some("true" | "1") => true,
        Some(other) => {
            let at = element.at_attribute("degrees");
            let error = SdfError::new(at, format!("{}: `degrees` cannot be used", element.describe()));
            return Err(error.found(format!("`{other}`")).expected("true or false"));
        }
    };
    let at = element.at_value();
    let pose = match element.attribute("rotation_format").unwrap_or("euler_rpy") {
        _ if element.text().is_empty() => Pose::IDENTITY,
        "euler_rpy" => {
            let [x, y, z, roll, pitch, yaw] = element.numbers()?;
            let angle = |a: f64| if in_degrees { a.to_radians() } else { a };
            Pose::from_rpy([x, y, z], [angle(roll), angle(pitch), angle(yaw)])
        }
        "quat_xyzw" if in_degrees => {
            return Err(element.bad_value("euler_rpy, as `degrees` is true"));
        }
        "quat_xyzw" => {
            let [x, y, z, qx, qy, qz, qw] = element.numbers()?;
            let quaternion = Quaternion::new(qw, qx, qy, qz);
            let norm = quaternion.norm();
            if norm < 1e-6 {
                return Err(element.bad_value("a quaternion of length 1"));
            }
            if (norm - 1.0).abs() > UNIT {
                remarks.note(element.at(), format!("the quaternion has length {norm:.6}: normalised"));
            }
            Pose::from_quaternion([x, y, z], UnitQuaternion::new_normalize(quaternion))
        }
        other => {
            let at = element.at_attribute("rotation_format");
            let error = SdfError::new(at, format!("{}: the rotation format is unknown", element.describe()));
            return Err(error.found(format!("`{other}`")).expected("euler_rpy or quat_xyzw"));
        }
    };
    if pose.position().iter().any(|x| x.abs() > MAX_COORDINATE) {
        return Err(element.bad_value(&format!("coordinates of at most {MAX_COORDINATE:e} m")));
    }
    Ok(WrittenPose { pose, relative_to, at })
}

/// The `<inertial>` of a link. Without `<mass>` it is 1 kg, without a moment that is 1 kg m^2, as
/// the format defines.
pub(super) fn inertial(link: &Element, remarks: &mut Remarks) -> Result<Option<Inertial>, SdfError> {
    let Some(element) = link.child("inertial")? else { return Ok(None) };
    if matches!(element.attribute("auto"), Some("true" | "1")) {
        let error = SdfError::new(element.at_attribute("auto"), "inertias by shape and density are not available");
        let error = error.element(element.describe()).expected("<mass> and <inertia>");
        return Err(error.help("`gz sdf --print --expand-auto-inertials FILE` writes them out").not_available());
    }
    element.check_children(remarks);
    let pose = pose(&element, remarks)?;
    let expected = format!("a mass in kg, not negative and at most {MAX_MASS:e}");
    let mass = element.number("mass", |m| (0.0..=MAX_MASS).contains(&m), &expected)?.unwrap_or(1.0);
    let mut tensor = Matrix3::identity();
    if let Some(inertia) = element.child("inertia")? {
        inertia.check_children(remarks);
        let entry = |tag| inertia.number(tag, |_| true, "a finite number");
        let (xx, yy, zz) = (entry("ixx")?.unwrap_or(1.0), entry("iyy")?.unwrap_or(1.0), entry("izz")?.unwrap_or(1.0));
        let (xy, xz, yz) = (entry("ixy")?.unwrap_or(0.0), entry("ixz")?.unwrap_or(0.0), entry("iyz")?.unwrap_or(0.0));
        tensor = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    }
    Ok(Some(Inertial { at: element.at(), pose, mass, tensor }))
}

/// A `<visual>` or `<collision>`.
pub(super) fn shape(element: &Element, remarks: &mut Remarks) -> Result<Shape, SdfError> {
    element.check_children(remarks);
    let name = element.attribute("name").unwrap_or_default().to_owned();
    let pose = pose(element, remarks)?;
    let geometry = geometry(&element.required("geometry")?)?;
    let rgba = match element.child("material")? {
        Some(material) => colour(&material)?,
        None => None,
    };
    Ok(Shape { name, at: element.at(), pose, geometry, rgba, mu: friction(element, remarks)? })
}

/// The diffuse colour of a material, or the ambient one.
fn colour(material: &Element) -> Result<Option<[f32; 4]>, SdfError> {
    let diffuse = material.child("diffuse")?;
    let Some(element) = (match diffuse {
        Some(_) => diffuse,
        None => material.child("ambient")?,
    }) else {
        return Ok(None);
    };
    let rgba = element.parse_numbers::<4>(element.text());
    let rgb = || element.parse_numbers::<3>(element.text()).map(|[r, g, b]| [r, g, b, 1.0]);
    let rgba = rgba.or_else(rgb).ok_or_else(|| element.bad_value("4 finite numbers"))?;
    Ok(Some(rgba.map(|x| x.clamp(0.0, 1.0) as f32)))
}

/// `<surface><friction><ode>`: mu, and mu2 where it differs.
fn friction(owner: &Element, remarks: &mut Remarks) -> Result<Option<(f64, Option<f64>)>, SdfError> {
    let Some(surface) = owner.child("surface")? else { return Ok(None) };
    surface.check_children(remarks);
    let Some(friction) = surface.child("friction")? else { return Ok(None) };
    friction.check_children(remarks);
    let Some(ode) = friction.child("ode")? else { return Ok(None) };
    ode.check_children(remarks);
    let number = |tag| ode.number(tag, |x| x >= 0.0, "a finite number, not negative");
    let (mu, mu2) = (number("mu")?, number("mu2")?);
    Ok(mu.map(|mu| (mu, mu2.filter(|second| *second != mu))))
}

fn geometry(element: &Element) -> Result<Geometry, SdfError> {
    let shapes: Vec<Element> = element
        .node
        .children()
        .filter(|n| n.is_element())
        .map(|node| Element { node, source: element.source })
        .collect();
    let [shape] = shapes[..] else {
        let message = format!("{}: <geometry> must hold one shape", element.describe());
        return Err(element.error(message).expected("one of <box>, <sphere>, <cylinder>, <capsule>, <mesh>, ..."));
    };
    let positive = |tag: &'static str| -> Result<f64, SdfError> {
        shape.required(tag)?;
        Ok(shape.number(tag, |x| x > 0.0, "a finite number above 0")?.unwrap_or_default())
    };
    let three = |tag: &'static str| -> Result<Vector3<f64>, SdfError> {
        let child = shape.required(tag)?;
        let numbers = child.numbers::<3>().ok().filter(|n| n.iter().all(|x| *x > 0.0));
        Ok(numbers.ok_or_else(|| child.bad_value("3 finite numbers above 0"))?.into())
    };
    Ok(match shape.tag() {
        "box" => Geometry::Box(three("size")?),
        "sphere" => Geometry::Sphere(positive("radius")?),
        "cylinder" => Geometry::Cylinder(positive("radius")?, positive("length")?),
        "capsule" => Geometry::Capsule(positive("radius")?, positive("length")?),
        "ellipsoid" => Geometry::Ellipsoid(three("radii")?),
        "mesh" => {
            let uri = shape.required("uri")?.text().to_owned();
            let scale = match shape.child("scale")? {
                Some(scale) => scale.numbers::<3>()?,
                None => [1.0; 3],
            };
            Geometry::Mesh(uri, scale.into(), shape.child("submesh")?.is_some())
        }
        "plane" => {
            let normal = match shape.child("normal")? {
                Some(normal) => Vector3::from(normal.numbers::<3>()?)
                    .try_normalize(1e-6)
                    .ok_or_else(|| normal.bad_value("a direction, such as 0 0 1"))?,
                None => Vector3::z(),
            };
            Geometry::Plane(normal)
        }
        "heightmap" => {
            let uri = shape.required("uri")?.text().to_owned();
            let numbers = |tag: &'static str, default: f64| match shape.child(tag)? {
                Some(child) => Ok(Vector3::from(child.numbers::<3>()?)),
                None => Ok(Vector3::repeat(default)),
            };
            Geometry::Heightmap(uri, numbers("size", 1.0)?, numbers("pos", 0.0)?)
        }
        other => Geometry::Other(other.to_owned()),
    })
}
