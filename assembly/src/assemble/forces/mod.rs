//! Creates the external force models from their entries.

mod drag;
mod load;
mod random_pushes;
mod spring;

pub(super) use load::loads;

use crate::assemble::names::{self, GripFrame, Owner};
use crate::assemble::objects::Object;
use crate::assemble::script_setup;
use crate::force::friction::JointFriction;
use crate::force::on_object::OnObject;
use crate::force::profile::{Profile, Shape};
use crate::force::wrench::Wrench;
use crate::force::{Force, NoForce};
use crate::robot::{JointFrictionLaw, Model};
use crate::scenario::{
    ConstantForce, Diagnostic, ForceFrame, ForceSpec, Profile as ProfileSpec, PushForce, RampForce, Run,
};
use crate::text::suggest;
use nalgebra::Point3;

/// The force models, in file order.
pub(super) fn forces(
    run: &Run,
    model: &Model,
    objects: &[Object],
    errors: &mut Vec<Diagnostic>,
) -> Vec<Box<dyn Force>> {
    let mut forces: Vec<Box<dyn Force>> = Vec::new();
    for (i, spec) in run.scenario.force.iter().enumerate() {
        let Some(name) = spec.object() else {
            forces.extend(force(run, Owner::robot(model), i, spec, errors));
            continue;
        };
        let Some((index, object)) = find_object(run, i, name, objects, errors) else { continue };
        let owner = Owner { model: &object.setup.model, kind: "object" };
        let on_object = |force| -> Box<dyn Force> { Box::new(OnObject { object: index, force }) };
        forces.extend(force(run, owner, i, spec, errors).map(on_object));
    }
    forces
}

/// The object that the force entry `i` names, with its index; an unknown one is an error there.
fn find_object<'a>(
    run: &Run,
    i: usize,
    name: &str,
    objects: &'a [Object],
    errors: &mut Vec<Diagnostic>,
) -> Option<(usize, &'a Object)> {
    let names: Vec<String> = run.scenario.object.iter().enumerate().map(|(o, object)| object.name(o)).collect();
    if !names.iter().any(|known| known == name) {
        let help = match names.is_empty() {
            true => "it has no `[[object]]`".to_owned(),
            false => suggest(name, names.iter().map(String::as_str)),
        };
        let message = format!("the scenario has no object `{name}`");
        errors.push(run.error_at(&format!("force.{i}.object"), message, Some(help)));
    }
    // An object with errors is left out.
    objects.iter().enumerate().find(|(_, object)| object.setup.name == name)
}

/// The force model of entry `i`; `None` after an error.
fn force(run: &Run, owner: Owner, i: usize, spec: &ForceSpec, errors: &mut Vec<Diagnostic>) -> Option<Box<dyn Force>> {
    match spec {
        ForceSpec::Push(PushForce { point, force, moment, frame, start, duration, profile, .. }) => {
            let profile = Profile::new(shape(*profile), *start, *duration);
            wrench(run, owner, (i, spec), [point, force, moment], *frame, profile, errors)
        }
        ForceSpec::Constant(ConstantForce { point, force, moment, frame, start, duration, .. }) => {
            let profile = span(*start, *duration);
            wrench(run, owner, (i, spec), [point, force, moment], *frame, profile, errors)
        }
        ForceSpec::Ramp(RampForce { point, force, moment, frame, start, duration, .. }) => {
            let profile = Profile::new(Shape::Ramp, *start, *duration);
            wrench(run, owner, (i, spec), [point, force, moment], *frame, profile, errors)
        }
        ForceSpec::Spring(spring) => {
            names::grip_frame(owner, run, i, spec, errors).map(|frame| spring::spring(frame, spring))
        }
        ForceSpec::RandomPushes(spec) => random_pushes::pushes(run, owner, i, spec, errors),
        ForceSpec::Drag(spec) => drag::drag(run, owner, i, spec, errors),
        ForceSpec::Script(spec) => {
            let span = span(spec.start, spec.duration);
            script_setup::force(run, owner.model, i, spec, span, errors)
        }
        // It exerts no force but adds inertia: see `loads`. The placeholder keeps the indices.
        ForceSpec::CarriedObject(_) => Some(Box::new(NoForce)),
        ForceSpec::JointFriction(spec) => {
            let unused: Vec<f64> = spec.joints.values().map(|_| 0.0).collect();
            let named = spec.joints.keys().zip(&unused);
            names::joints_of(owner, run, &format!("force.{i}.joints"), named, errors);
            let law =
                |(j, joint): (usize, &crate::robot::Joint)| spec.friction_of(&joint.name).map(|f| (j, friction(&f)));
            let joints = owner.model.joints.iter().enumerate().filter_map(law).collect();
            if owner.model.joints.is_empty() {
                let message = format!("{owner} has no joints that could have friction");
                errors.push(run.error_at(&format!("force.{i}"), message, None));
            }
            Some(Box::new(JointFriction { joints }))
        }
    }
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
    owner: Owner,
    (i, spec): (usize, &ForceSpec),
    [point, force, moment]: [&[f64; 3]; 3],
    frame: ForceFrame,
    profile: Profile,
    errors: &mut Vec<Diagnostic>,
) -> Option<Box<dyn Force>> {
    let GripFrame { link, pose, .. } = names::grip_frame(owner, run, i, spec, errors)?;
    Some(Box::new(Wrench {
        link,
        point: (pose * Point3::from(*point)).coords,
        force: (*force).into(),
        moment: (*moment).into(),
        axes: (frame == ForceFrame::Link).then_some(pose.rotation),
        profile,
    }))
}
