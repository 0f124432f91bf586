//! Creates carried objects from their entries.

use crate::assemble::names::{self, GripFrame, Owner};
use crate::robot::Model;
use crate::robot::adjustments;
use crate::scenario::{CarriedObject as ObjectSpec, Diagnostic, ForceSpec, Run};
use crate::sim::CarriedObject;
use nalgebra::{Isometry3, Translation3, UnitQuaternion};

/// The carried objects. One that does not fit the robot is an error at its position.
pub(in crate::assemble) fn loads(run: &Run, model: &Model, errors: &mut Vec<Diagnostic>) -> Vec<CarriedObject> {
    let entries = run.scenario.force.iter().enumerate();
    let object = |(i, spec): (usize, &ForceSpec)| match spec {
        ForceSpec::CarriedObject(object) => {
            let frame = names::grip_frame(Owner::robot(model), run, i, spec, errors)?;
            load(run, i, frame, object, errors)
        }
        _ => None,
    };
    entries.filter_map(object).collect()
}

fn load(
    run: &Run,
    i: usize,
    frame: GripFrame,
    spec: &ObjectSpec,
    errors: &mut Vec<Diagnostic>,
) -> Option<CarriedObject> {
    let [roll, pitch, yaw] = spec.rpy;
    let rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    let pose = Isometry3::from_parts(Translation3::from(spec.position), rotation);
    match adjustments::load_in(&frame.pose, &frame.name, spec.mass, pose, spec.inertia) {
        Ok(body) => Some(CarriedObject {
            name: frame.name,
            link: frame.link,
            body,
            velocity: spec.velocity.map(Into::into),
            from: spec.start,
            to: spec.duration.map_or(f64::INFINITY, |d| spec.start + d),
        }),
        Err(error) => {
            errors.push(run.error_at(&format!("force.{i}"), error.to_string(), None));
            None
        }
    }
}
