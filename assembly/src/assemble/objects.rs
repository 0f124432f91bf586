//! Objects of a scenario: their models, initial states and shapes.

use super::friction::extra;
use super::object_models;
use crate::dynamics::State;
use crate::geometry::polyhedron::{self, Moments};
use crate::mesh;
use crate::patches::ConvexBody;
use crate::robot::{Base, Geometry, Link, LinkId, Model, Robot, Shape};
use crate::scenario::{Diagnostic, MeshObject, ObjectEntry, ObjectSpec, Run};
use crate::sim::bodies::Friction;
use crate::sim::plant::ObjectSetup;
use crate::task::Command;
use crate::terrain::mesh_shapes;
use nalgebra::{Isometry3, Matrix3, Point3, UnitQuaternion, Vector3};
use std::f64::consts::PI;
use std::sync::Arc;

/// Colour of objects in views.
const COLOUR: [f32; 4] = [0.85, 0.55, 0.25, 1.0];

/// Greatest coordinate of a mesh, m.
const MAX_COORDINATE: f64 = 1e6;

/// An object and what touches of it.
pub(super) struct Object {
    pub setup: ObjectSetup,
    /// Convex bodies and the links that carry them.
    pub bodies: Vec<(LinkId, ConvexBody)>,
    /// Its own friction.
    pub friction: Option<Friction>,
}

/// The objects of a run. `models` are those of its objects of type `model`, in their order. One that
/// cannot be used is an error at its position, and left out.
pub(super) fn objects(
    run: &Run,
    models: &[Arc<Robot>],
    notes: &mut Vec<String>,
    errors: &mut Vec<Diagnostic>,
) -> Vec<Object> {
    let mut models = models.iter();
    let mut objects = Vec::new();
    for (i, spec) in run.scenario.object.iter().enumerate() {
        let name = spec.name(i);
        let object = match spec {
            ObjectSpec::Model(model) => {
                models.next().map(|robot| object_models::object(run, i, name, model, &spec.entry(), robot, errors))
            }
            ObjectSpec::Mesh(mesh) => {
                mesh_solid(run, i, mesh, notes, errors).map(|solid| object(&spec.entry(), name, solid))
            }
            ObjectSpec::Box(block) => {
                let size = Vector3::from(block.size);
                let squares = size.component_mul(&size);
                let inertia = Vector3::new(squares.y + squares.z, squares.x + squares.z, squares.x + squares.y) / 12.0;
                let shape = ConvexBody::cuboid(size * 0.5);
                Some(object(&spec.entry(), name, Solid::centred(shape, Geometry::Box(size), block.mass, inertia)))
            }
            ObjectSpec::Sphere(ball) => {
                let inertia = Vector3::repeat(0.4 * ball.radius * ball.radius);
                let (shape, geometry) = (ConvexBody::ball(ball.radius), Geometry::Sphere(ball.radius));
                Some(object(&spec.entry(), name, Solid::centred(shape, geometry, ball.mass, inertia)))
            }
            ObjectSpec::Capsule(capsule) => {
                let (r, l) = (capsule.radius, capsule.length);
                let (shape, geometry) = (ConvexBody::capsule(0.5 * l, r), Geometry::Capsule(r, l));
                Some(object(&spec.entry(), name, Solid::centred(shape, geometry, capsule.mass, capsule_inertia(r, l))))
            }
            ObjectSpec::Cylinder(cylinder) => {
                let (r, l) = (cylinder.radius, cylinder.length);
                let across = r * r / 4.0 + l * l / 12.0;
                let inertia = Vector3::new(across, across, r * r / 2.0);
                let (shape, geometry) = (ConvexBody::cylinder(0.5 * l, r), Geometry::Cylinder(r, l));
                Some(object(&spec.entry(), name, Solid::centred(shape, geometry, cylinder.mass, inertia)))
            }
        };
        objects.extend(object);
    }
    objects
}

/// A single body: shape, mass, centre of mass, inertia about it per mass.
struct Solid {
    shape: ConvexBody,
    geometry: Geometry,
    mass: f64,
    com: Vector3<f64>,
    inertia: Matrix3<f64>,
}

impl Solid {
    /// With its principal axes along those of its frame, at its centre of mass.
    fn centred(shape: ConvexBody, geometry: Geometry, mass: f64, inertia: Vector3<f64>) -> Self {
        Solid { shape, geometry, mass, com: Vector3::zeros(), inertia: Matrix3::from_diagonal(&inertia) }
    }
}

/// The convex hull of a mesh; `None` after an error, which goes to `errors`.
fn mesh_solid(
    run: &Run,
    i: usize,
    spec: &MeshObject,
    notes: &mut Vec<String>,
    errors: &mut Vec<Diagnostic>,
) -> Option<Solid> {
    let path = format!("object.{i}");
    let input = run.input(&format!("{path}.file"))?;
    let mut refuse = |message: String| {
        let message = format!("{}: {message}", input.path.display());
        errors.push(run.error_at(&format!("{path}.file"), message, None));
        None
    };
    let decoded = match mesh::decode(&input.bytes, &input.path) {
        Ok(decoded) => decoded,
        Err(error) => return refuse(error.to_string()),
    };
    let scaled = decoded.scaled(&Vector3::repeat(spec.scale));
    let is_bounded = |points: &[Point3<f64>]| points.iter().all(|p| p.coords.amax() <= MAX_COORDINATE);
    let Some((points, _)) = scaled.filter(|(points, _)| is_bounded(points)) else {
        return refuse(format!("at the scale {} it has coordinates beyond {MAX_COORDINATE} m", spec.scale));
    };
    let points: Vec<Vector3<f64>> = points.iter().map(|p| p.coords).collect();
    let flat = "it is flat, so its convex hull has no volume";
    let Some(hull) = mesh_shapes::hull(&points) else { return refuse(flat.to_owned()) };
    let indices: Vec<[u16; 3]> = hull
        .faces
        .iter()
        .flat_map(|face| face.corners.windows(2).skip(1).map(|edge| [face.corners[0], edge[0], edge[1]]))
        .collect();
    let triangles = indices.iter().map(|triangle| triangle.map(|k| hull.points[usize::from(k)]));
    let (Some(Moments { centre, inertia, .. }), Some(shape)) =
        (polyhedron::moments(triangles), ConvexBody::from_points(&hull.points))
    else {
        return refuse(flat.to_owned());
    };
    notes.extend(decoded.remark.map(|remark| format!("{path}: {}: {remark}", input.path.display())));
    let vertices = hull.points.iter().map(|p| Point3::from(*p)).collect();
    let geometry = Geometry::Mesh(vertices, indices.iter().map(|t| t.map(u32::from)).collect());
    Some(Solid { shape, geometry, mass: spec.mass, com: centre, inertia })
}

/// An object of one body.
fn object(entry: &ObjectEntry, name: String, solid: Solid) -> Object {
    let Solid { shape, geometry, mass, com, inertia } = solid;
    let shown = Shape { pose: Isometry3::identity(), geometry, rgba: COLOUR };
    let link = Link {
        name: name.clone(),
        parent: None,
        rotation: Matrix3::identity(),
        offset: Vector3::zeros(),
        mass,
        com,
        inertia: inertia * mass,
        urdf_frame: Isometry3::identity(),
        merged: Vec::new(),
        visuals: vec![shown.clone()],
        collisions: vec![shown],
    };
    let model = Model::tree(name.clone(), Base::Floating, vec![link], Vec::new());
    let state = initial_state(&model, entry);
    let command = Command::hold(&model, &[]);
    let setup = ObjectSetup { name, model: Arc::new(model), state, command, joint_stops: true };
    Object { setup, bodies: vec![(LinkId(0), shape)], friction: own_friction(entry) }
}

/// The home posture at the pose and, if the base is free, with the velocity of the entry.
pub(super) fn initial_state(model: &Model, entry: &ObjectEntry) -> State {
    let mut state = State::home(model);
    state.position = entry.position.into();
    let [roll, pitch, yaw] = entry.rpy;
    state.rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    if model.base == Base::Floating {
        state.v[..3].copy_from_slice(&entry.linear_velocity);
        state.v[3..6].copy_from_slice(&entry.angular_velocity);
    }
    state
}

/// The friction that an entry gives.
pub(super) fn own_friction(entry: &ObjectEntry) -> Option<Friction> {
    entry.friction.map(|f| Friction { mu_s: f.static_, mu_k: f.kinetic, extra: extra(f) })
}

/// Principal moments of inertia of a homogeneous capsule along z about its centre, per mass, m^2:
///
/// ```text
/// cylinder c = pi r^2 l, ends e = 4/3 pi r^3 (volumes)
/// I_z = (c r^2 / 2 + e 2 r^2 / 5) / (c + e)
/// I_x = (c (r^2 / 4 + l^2 / 12) + e (2 r^2 / 5 + l^2 / 4 + 3 r l / 8)) / (c + e)
/// ```
///
/// The ends' centres of mass are 3 r / 8 from their flat faces.
fn capsule_inertia(r: f64, l: f64) -> Vector3<f64> {
    let (c, e) = (PI * r * r * l, 4.0 / 3.0 * PI * r * r * r);
    let along = (c * r * r / 2.0 + e * 0.4 * r * r) / (c + e);
    let across = (c * (r * r / 4.0 + l * l / 12.0) + e * (0.4 * r * r + l * l / 4.0 + 3.0 * r * l / 8.0)) / (c + e);
    Vector3::new(across, across, along)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inertia_of_a_capsule_is_that_of_its_slices() {
        let (r, l) = (0.3, 0.7);
        // Discs of the profile along z: mass dm = rho(z)^2 dz, I_z = dm rho^2 / 2, I_x = dm (rho^2 / 4 + z^2).
        let n = 200_000;
        let half = 0.5 * l + r;
        let (mut mass, mut along, mut across) = (0.0, 0.0, 0.0);
        for k in 0..n {
            let z = -half + 2.0 * half * (k as f64 + 0.5) / n as f64;
            let beyond = (z.abs() - 0.5 * l).max(0.0);
            let square = r * r - beyond * beyond;
            mass += square;
            along += square * square / 2.0;
            across += square * (square / 4.0 + z * z);
        }
        let inertia = capsule_inertia(r, l);
        // Midpoint rule of a profile with a kink.
        assert!((inertia.z - along / mass).abs() < 1e-10);
        assert!((inertia.x - across / mass).abs() < 1e-10);
    }
}
