//! Objects of a scenario: their models, initial states and shapes.

use crate::dynamics::State;
use crate::patches::ConvexBody;
use crate::robot::{Base, Geometry, Link, Model, SensorFrames, Shape};
use crate::scenario::{ObjectSpec, Run};
use crate::sim::bodies::Friction;
use crate::sim::plant::ObjectSetup;
use crate::task::Command;
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};
use std::f64::consts::PI;
use std::sync::Arc;

/// Colour of objects in views.
const COLOUR: [f32; 4] = [0.85, 0.55, 0.25, 1.0];

/// An object and what touches of it.
pub(super) struct Object {
    pub setup: ObjectSetup,
    /// Shape of its root link.
    pub shape: ConvexBody,
    /// Its own friction.
    pub friction: Option<Friction>,
}

/// The objects of a run.
pub(super) fn objects(run: &Run) -> Vec<Object> {
    run.scenario.object.iter().enumerate().map(|(i, spec)| object(spec, spec.name(i))).collect()
}

fn object(spec: &ObjectSpec, name: String) -> Object {
    let (shape, geometry, mass, inertia) = match spec {
        ObjectSpec::Box(spec) => {
            let size = Vector3::from(spec.size);
            let squares = size.component_mul(&size);
            let inertia = Vector3::new(squares.y + squares.z, squares.x + squares.z, squares.x + squares.y) / 12.0;
            (ConvexBody::cuboid(size * 0.5), Geometry::Box(size), spec.mass, inertia)
        }
        ObjectSpec::Sphere(spec) => {
            let inertia = Vector3::repeat(0.4 * spec.radius * spec.radius);
            (ConvexBody::ball(spec.radius), Geometry::Sphere(spec.radius), spec.mass, inertia)
        }
        ObjectSpec::Capsule(spec) => {
            let (r, l) = (spec.radius, spec.length);
            let geometry = Geometry::Capsule(r, l);
            (ConvexBody::capsule(0.5 * l, r), geometry, spec.mass, capsule_inertia(r, l))
        }
    };
    let shown = Shape { pose: Isometry3::identity(), geometry, rgba: COLOUR };
    let link = Link {
        name: name.clone(),
        parent: None,
        rotation: Matrix3::identity(),
        offset: Vector3::zeros(),
        mass,
        com: Vector3::zeros(),
        inertia: Matrix3::from_diagonal(&(inertia * mass)),
        urdf_frame: Isometry3::identity(),
        merged: Vec::new(),
        visuals: vec![shown.clone()],
        collisions: vec![shown],
    };
    let model = Model {
        name: name.clone(),
        base: Base::Floating,
        links: vec![link],
        joints: Vec::new(),
        soles: Vec::new(),
        end_effectors: Vec::new(),
        sensors: SensorFrames::default(),
        home: Vec::new(),
    };
    let entry = spec.entry();
    let mut state = State::home(&model);
    state.position = entry.position.into();
    let [roll, pitch, yaw] = entry.rpy;
    state.rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    state.v[..3].copy_from_slice(&entry.linear_velocity);
    state.v[3..].copy_from_slice(&entry.angular_velocity);
    let command = Command::hold(&model, &[]);
    let friction = entry.friction.map(|f| Friction { mu_s: f.static_, mu_k: f.kinetic });
    Object { setup: ObjectSetup { name, model: Arc::new(model), state, command }, shape, friction }
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
