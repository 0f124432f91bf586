//! Creates the external force models from their entries.

mod drag;
mod load;
mod random_pushes;
mod spring;

pub(super) use load::loads;

use crate::assemble::names::{self, GripFrame};
use crate::assemble::script_setup;
use crate::force::friction::JointFriction;
use crate::force::profile::{Profile, Shape};
use crate::force::wrench::Wrench;
use crate::force::{Force, NoForce};
use crate::robot::{JointFrictionLaw, Model};
use crate::scenario::{
    ConstantForce, Diagnostic, ForceFrame, ForceSpec, Profile as ProfileSpec, PushForce, RampForce, Run,
};
use nalgebra::Point3;

/// The force models, in file order.
pub(super) fn forces(run: &Run, model: &Model, errors: &mut Vec<Diagnostic>) -> Vec<Box<dyn Force>> {
    let mut forces: Vec<Box<dyn Force>> = Vec::new();
    for (i, spec) in run.scenario.force.iter().enumerate() {
        match spec {
            ForceSpec::Push(PushForce { point, force, moment, frame, start, duration, profile, .. }) => {
                let profile = Profile::new(shape(*profile), *start, *duration);
                forces.extend(wrench(run, model, (i, spec), [point, force, moment], *frame, profile, errors));
            }
            ForceSpec::Constant(ConstantForce { point, force, moment, frame, start, duration, .. }) => {
                let profile = span(*start, *duration);
                forces.extend(wrench(run, model, (i, spec), [point, force, moment], *frame, profile, errors));
            }
            ForceSpec::Ramp(RampForce { point, force, moment, frame, start, duration, .. }) => {
                let profile = Profile::new(Shape::Ramp, *start, *duration);
                forces.extend(wrench(run, model, (i, spec), [point, force, moment], *frame, profile, errors));
            }
            ForceSpec::Spring(spring) => {
                let frame = names::grip_frame(model, run, i, spec, errors);
                forces.extend(frame.map(|frame| spring::spring(frame, spring)));
            }
            ForceSpec::RandomPushes(spec) => forces.extend(random_pushes::pushes(run, model, i, spec, errors)),
            ForceSpec::Drag(spec) => forces.extend(drag::drag(run, model, i, spec, errors)),
            ForceSpec::Script(spec) => {
                let span = span(spec.start, spec.duration);
                forces.extend(script_setup::force(run, model, i, spec, span, errors));
            }
            // It exerts no force but adds inertia: see `loads`. The placeholder keeps the indices.
            ForceSpec::CarriedObject(_) => forces.push(Box::new(NoForce)),
            ForceSpec::JointFriction(spec) => {
                let unused: Vec<f64> = spec.joints.values().map(|_| 0.0).collect();
                names::joints(model, run, &format!("force.{i}.joints"), spec.joints.keys().zip(&unused), errors);
                let law = |(j, joint): (usize, &crate::robot::Joint)| {
                    spec.friction_of(&joint.name).map(|f| (j, friction(&f)))
                };
                let joints = model.joints.iter().enumerate().filter_map(law).collect();
                if model.joints.is_empty() {
                    let message = format!("the robot `{}` has no joints that could have friction", model.name);
                    errors.push(run.error_at(&format!("force.{i}"), message, None));
                }
                forces.push(Box::new(JointFriction { joints }));
            }
        }
    }
    forces
}

/// Constant from `start` on, for a duration or to the end.
fn span(start: f64, duration: Option<f64>) -> Profile {
    let always = start == 0.0 && duration.is_none();
    Profile::new(if always { Shape::Always } else { Shape::Constant }, start, duration.unwrap_or(f64::INFINITY))
}

fn shape(profile: ProfileSpec) -> Shape {
    match profile {
        ProfileSpec::Constant => Shape::Constant,
        ProfileSpec::HalfSine => Shape::HalfSine,
        ProfileSpec::Ramp => Shape::Ramp,
        ProfileSpec::Triangle => Shape::Triangle,
    }
}

fn friction(f: &crate::scenario::JointFriction) -> JointFrictionLaw {
    let default = JointFrictionLaw::default();
    JointFrictionLaw {
        coulomb: f.coulomb,
        viscous: f.viscous,
        static_: f.static_.unwrap_or(default.static_),
        stribeck_velocity: f.stribeck_velocity.unwrap_or(default.stribeck_velocity),
        slip_velocity: f.slip_velocity.unwrap_or(default.slip_velocity),
    }
}

fn wrench(
    run: &Run,
    model: &Model,
    (i, spec): (usize, &ForceSpec),
    [point, force, moment]: [&[f64; 3]; 3],
    frame: ForceFrame,
    profile: Profile,
    errors: &mut Vec<Diagnostic>,
) -> Option<Box<dyn Force>> {
    let GripFrame { link, pose, .. } = names::grip_frame(model, run, i, spec, errors)?;
    Some(Box::new(Wrench {
        link,
        point: (pose * Point3::from(*point)).coords,
        force: (*force).into(),
        moment: (*moment).into(),
        axes: (frame == ForceFrame::Link).then_some(pose.rotation),
        profile,
    }))
}
