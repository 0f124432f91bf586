//! Creates the changes of a run's events from the scenario after each event.

use crate::assemble::objects::Object;
use crate::assemble::{floor, forces, model, pairing};
use crate::robot::{Model, Robot};
use crate::scenario::{Diagnostic, Event, ForceSpec, Run, ScriptForce};
use crate::sim::ScenarioEvent;
use std::sync::Arc;

/// The changes in order of time, and the number of saved states. `model` is the robot at the start.
/// Ends at the first event that does not fit the robot.
pub(super) fn changes(
    run: &Run,
    robot: &Robot,
    model: &Model,
    objects: &[Object],
    errors: &mut Vec<Diagnostic>,
) -> (Vec<ScenarioEvent>, usize) {
    // In the order of saving, so that later names change no index.
    let mut names: Vec<&str> = Vec::new();
    for name in run.events.iter().filter_map(|e| e.save.as_deref()) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let slot = |name: &Option<String>| name.as_ref().and_then(|name| names.iter().position(|n| n == name));
    let mut model = Arc::new(model.clone());
    let mut changes = Vec::with_capacity(run.events.len());
    for (k, event) in run.events.iter().enumerate() {
        let after = &event.after;
        let changes_part = |part: &str| event.set.iter().any(|key| key.starts_with(part));
        let mut change = ScenarioEvent {
            at: event.at,
            message: summary(event),
            end_tasks: event.end_tasks.clone(),
            save: slot(&event.save),
            restore: slot(&event.restore),
            gravity: changes_part("gravity").then(|| after.scenario.gravity.into()),
            restitution: changes_part("contact.").then_some(after.scenario.contact.restitution),
            floor: changes_part("floor.").then(|| floor(after, errors)),
            ..ScenarioEvent::default()
        };
        if change.floor.is_some() {
            pairing::check_moments(after, errors);
        }
        if change.restitution.is_some() {
            pairing::check_restitution(after, errors);
        }
        if changes_part("robot.") {
            let changed = Arc::new(changed_model(&model, after, robot, errors));
            change.gains = gains(&model, &changed);
            change.model = Some(changed.clone());
            model = changed;
        }
        let mut changed_forces: Vec<usize> = event.set.iter().filter_map(|key| force_index(key)).collect();
        changed_forces.sort_unstable();
        changed_forces.dedup();
        for i in &changed_forces {
            if let Some(ForceSpec::CarriedObject(_)) = after.scenario.force.get(*i) {
                let message = format!("`force.{i}` is a carried object, which cannot change during a run");
                let help = Some("add another object with its own times".to_owned());
                errors.push(after.error_at(&format!("force.{i}"), message, help));
            }
        }
        if !changed_forces.is_empty() {
            let forces =
                forces::forces(&current_run(&run.events[..=k]), &model, objects, errors).into_iter().enumerate();
            change.forces = forces.filter(|(i, _)| changed_forces.binary_search(i).is_ok()).collect();
        }
        if !errors.is_empty() {
            break;
        }
        changes.push(change);
    }
    (changes, names.len())
}

/// Index of the force whose key a path names.
fn force_index(key: &str) -> Option<usize> {
    key.strip_prefix("force.")?.split('.').next()?.parse().ok()
}

/// The run after the last of these events, with its scripts' parameters at that time.
fn current_run(events: &[Event]) -> Run {
    let last = events.last().expect("the current event is among them");
    let mut run = (*last.after).clone();
    for (i, force) in run.scenario.force.iter_mut().enumerate() {
        if let ForceSpec::Script(script) = force {
            apply_script_changes(script, &format!("force.{i}.params"), events, last.at);
        }
    }
    run
}

/// Applies a script's changes up to a time to its parameters, except those that an event set later
/// than the change.
fn apply_script_changes(script: &mut ScriptForce, path: &str, events: &[Event], time: f64) {
    let sets = |event: &Event, name: &str| {
        let into = |key: &String| key.strip_prefix(path).is_some_and(|rest| concerns(rest, name));
        event.set.iter().any(into)
    };
    let count = script.change.iter().take_while(|change| change.at <= time).count();
    for change in script.change.drain(..count) {
        let is_set = |name: &String| events.iter().any(|event| event.at >= change.at && sets(event, name));
        script.params.extend(change.params.into_iter().filter(|(name, _)| !is_set(name)));
    }
}

/// True when a path, given from `params` on, names all parameters, this one or a part of it.
fn concerns(rest: &str, name: &str) -> bool {
    let inner = rest.strip_prefix('.').and_then(|rest| rest.strip_prefix(name));
    rest.is_empty() || inner.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// The robot after an event. Drives keep their modes. If a joint's own table gives one gain alone,
/// the other keeps its value: a joint with both gains of `joint_default` would otherwise lose it.
fn changed_model(before: &Model, after: &Run, robot: &Robot, errors: &mut Vec<Diagnostic>) -> Model {
    let mut after = after.clone();
    for (name, joint) in &mut after.scenario.robot.joint {
        let Some(id) = before.joint(name).filter(|_| joint.kp.is_some() != joint.kd.is_some()) else { continue };
        let drive = &before.joints[id.0].drive;
        joint.kp.get_or_insert(drive.kp);
        joint.kd.get_or_insert(drive.kd);
    }
    let mut model = model::adjusted_model(&after, robot, errors);
    model.joints.iter_mut().zip(&before.joints).for_each(|(joint, old)| joint.drive.mode = old.drive.mode);
    model
}

/// Joints whose gains differ, with kp and kd.
fn gains(before: &Model, after: &Model) -> Vec<(usize, f64, f64)> {
    let joints = before.joints.iter().zip(&after.joints).enumerate();
    joints
        .filter(|(_, (a, b))| (a.drive.kp, a.drive.kd) != (b.drive.kp, b.drive.kd))
        .map(|(j, (_, b))| (j, b.drive.kp, b.drive.kd))
        .collect()
}

/// Text of an event for the log.
fn summary(event: &Event) -> String {
    let state = [("saves", &event.save), ("restores", &event.restore)];
    let state = state.into_iter().filter_map(|(does, name)| name.as_ref().map(|name| format!("{does} state {name}")));
    let ends = event.end_tasks.iter().map(|number| format!("ends task {number}"));
    let set = (!event.assignments.is_empty()).then(|| event.assignments.clone());
    state.chain(ends).chain(set).collect::<Vec<_>>().join(", ")
}
