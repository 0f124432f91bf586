//! External force models from their entries.

mod spring;

use super::names;
use crate::force::Force;
use crate::force::friction::{Joint, JointFriction, SLIP_SPEED};
use crate::force::profile::{Profile, Shape};
use crate::force::wrench::Wrench;
use crate::robot::Model;
use crate::scenario::{
    ConstantForce, Diagnostic, ForceFrame, ForceSpec, Profile as ProfileSpec, PushForce, RampForce, Run,
};
use nalgebra::Point3;

/// The force models, in file order.
pub(super) fn forces(run: &Run, model: &Model, errors: &mut Vec<Diagnostic>) -> Vec<Box<dyn Force>> {
    let mut forces: Vec<Box<dyn Force>> = Vec::new();
    for (i, spec) in run.scenario.force.iter().enumerate() {
        match spec {
            ForceSpec::Push(PushForce { link, point, force, moment, frame, start, duration, profile }) => {
                let shape = match profile {
                    ProfileSpec::Constant => Shape::Constant,
                    ProfileSpec::HalfSine => Shape::HalfSine,
                    ProfileSpec::Ramp => Shape::Ramp,
                    ProfileSpec::Triangle => Shape::Triangle,
                };
                let profile = Profile::new(shape, *start, *duration);
                let made = wrench(run, model, i, link, [point, force, moment], *frame, profile, errors);
                forces.extend(made);
            }
            ForceSpec::Constant(ConstantForce { link, point, force, moment, frame, start, duration }) => {
                let always = *start == 0.0 && duration.is_none();
                let shape = if always { Shape::Always } else { Shape::Constant };
                let profile = Profile::new(shape, *start, duration.unwrap_or(f64::INFINITY));
                let made = wrench(run, model, i, link, [point, force, moment], *frame, profile, errors);
                forces.extend(made);
            }
            ForceSpec::Ramp(RampForce { link, point, force, moment, frame, start, duration }) => {
                let profile = Profile::new(Shape::Ramp, *start, *duration);
                let made = wrench(run, model, i, link, [point, force, moment], *frame, profile, errors);
                forces.extend(made);
            }
            ForceSpec::Spring(spec) => forces.extend(spring::spring(run, model, i, spec, errors)),
            ForceSpec::JointFriction(spec) => {
                let unused: Vec<f64> = spec.joints.values().map(|_| 0.0).collect();
                names::joints(model, run, &format!("force.{i}.joints"), spec.joints.keys().zip(&unused), errors);
                let of = |(j, joint): (usize, &crate::robot::Joint)| {
                    spec.of(&joint.name).map(|f| Joint { joint: j, coulomb: f.coulomb, viscous: f.viscous })
                };
                let joints = model.joints.iter().enumerate().filter_map(of).collect();
                forces.push(Box::new(JointFriction { joints, slip_speed: SLIP_SPEED }));
            }
        }
    }
    forces
}

#[expect(clippy::too_many_arguments)]
fn wrench(
    run: &Run,
    model: &Model,
    i: usize,
    link: &str,
    [point, force, moment]: [&[f64; 3]; 3],
    frame: ForceFrame,
    profile: Profile,
    errors: &mut Vec<Diagnostic>,
) -> Option<Box<dyn Force>> {
    let (id, pose) = names::link(model, run, &format!("force.{i}.link"), link, errors)?;
    Some(Box::new(Wrench {
        link: id,
        point: (pose * Point3::from(*point)).coords,
        force: (*force).into(),
        moment: (*moment).into(),
        axes: (frame == ForceFrame::Link).then_some(pose.rotation),
        profile,
    }))
}
