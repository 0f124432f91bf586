//! Creates the tasks that plan joint positions, `squat` and `walk`, from their entries.

use crate::assemble::names;
use crate::robot::Model;
use crate::scenario::{Diagnostic, Run, SquatTask, WalkTask};
use crate::task::Task;
use crate::task::gait::Stride;
use crate::task::kinematic::{NotPlannable, planned_robot};
use crate::task::squat::{Shape, Squat};
use crate::task::walk::Walk;

/// The squat of the entry at `path`; `None`, with an error, for an unsuitable robot.
pub(super) fn squat(
    run: &Run,
    model: &Model,
    path: &str,
    spec: &SquatTask,
    errors: &mut Vec<Diagnostic>,
) -> Option<Box<dyn Task>> {
    require_plannable(run, path, "a foot", planned_robot::check(model), errors)?;
    let shape = Shape { depth: spec.depth, period: spec.period, repetitions: spec.repetitions, settle: spec.settle };
    Some(Box::new(Squat::new(model, shape, spec.feed_forward)))
}

/// The walk of the entry at `path`; `None`, with an error, for an unsuitable robot.
pub(super) fn walk(
    run: &Run,
    model: &Model,
    path: &str,
    spec: &WalkTask,
    errors: &mut Vec<Diagnostic>,
) -> Option<Box<dyn Task>> {
    require_plannable(run, path, "two feet", planned_robot::check_biped(model), errors)?;
    let first = match &spec.first {
        None => 0,
        Some(name) => names::sole(model, run, &format!("{path}.first"), name, errors)?.0,
    };
    let until = run.scenario.duration - spec.start;
    let stride = Stride {
        steps: spec.steps as usize,
        length: spec.step_length,
        rise: spec.step_rise,
        time: spec.step_time,
        double_support: spec.double_support,
        height: spec.step_height,
        wait: spec.wait,
        first,
    };
    Some(Box::new(Walk::new(model, stride, spec.com_height, spec.settle, spec.feed_forward, until)))
}

/// `None`, with an error, if motions of the robot cannot be planned.
pub(super) fn require_plannable(
    run: &Run,
    path: &str,
    feet: &str,
    result: Result<(), NotPlannable>,
    errors: &mut Vec<Diagnostic>,
) -> Option<()> {
    if let Err(e) = result {
        errors.push(run.error_at(
            &format!("{path}.type"),
            format!("this task needs {feet} that it can move freely: {e}"),
            None,
        ));
        return None;
    }
    Some(())
}
