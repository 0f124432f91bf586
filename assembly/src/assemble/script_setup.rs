//! Creates scripted tasks and forces. Scripts are loaded here, so that their errors are found
//! before the run starts.

use crate::force::Force;
use crate::force::profile::Profile;
use crate::random::Stream;
use crate::robot::Model;
use crate::scenario::{ChangeSpec, Diagnostic, Run, ScriptForce as ForceSpec, ScriptTask as TaskSpec};
use crate::script::script_force::{Schedule, ScriptForce};
use crate::script::script_task::ScriptTask;
use crate::script::{Params, Purpose, RobotNames, Script};
use crate::task::Task;
use std::collections::BTreeMap;

/// The task of entry `i`; a script that cannot be loaded is an error at the key that names it.
pub(super) fn task(
    run: &Run,
    model: &Model,
    i: usize,
    spec: &TaskSpec,
    errors: &mut Vec<Diagnostic>,
) -> Option<Box<dyn Task>> {
    let script = load(run, model, &format!("task.{i}"), &spec.file, Purpose::Task, &spec.change, errors)?;
    let end = spec.duration.map_or(f64::INFINITY, |d| spec.start + d);
    let (params, changes) = parameters(&spec.params, &spec.change);
    Some(Box::new(ScriptTask::new(format!("script {}", spec.file), script, params, changes, end)))
}

/// The force model of entry `i`, as [`task`].
pub(super) fn force(
    run: &Run,
    model: &Model,
    i: usize,
    spec: &ForceSpec,
    span: Profile,
    errors: &mut Vec<Diagnostic>,
) -> Option<Box<dyn Force>> {
    let script = load(run, model, &format!("force.{i}"), &spec.file, Purpose::Force, &spec.change, errors)?;
    let (params, changes) = parameters(&spec.params, &spec.change);
    let plan = Schedule { span, corners: spec.corners.clone(), params, changes };
    Some(Box::new(ScriptForce::new(spec.file.clone(), script, RobotNames::new(model), plan)))
}

fn load(
    run: &Run,
    model: &Model,
    path: &str,
    file: &str,
    purpose: Purpose,
    changes: &[ChangeSpec],
    errors: &mut Vec<Diagnostic>,
) -> Option<Script> {
    // A file that cannot be read was reported when the scenario was expanded.
    let input = run.input(&format!("{path}.file"))?;
    let text = match std::str::from_utf8(&input.bytes) {
        Ok(text) => text,
        Err(error) => {
            let message = format!("{file} is not UTF-8 from byte {} on", error.valid_up_to());
            errors.push(run.error_at(&format!("{path}.file"), message, None));
            return None;
        }
    };
    let mut purposes: Vec<&str> = vec!["run"];
    purposes.extend(path.split('.'));
    match Script::load(file, text, purpose, model, Stream::new(run.scenario.seed, &purposes)) {
        Ok(script) if !changes.is_empty() && !script.can_change() => {
            let message = format!("{file} has no function `change`");
            errors.push(run.error_at(&format!("{path}.change"), message, None));
            None
        }
        Ok(script) => Some(script),
        Err(error) => {
            errors.push(run.error_at(&format!("{path}.file"), error.to_string(), None));
            None
        }
    }
}

/// Parameters at the start, and all of them after each change.
fn parameters(start: &BTreeMap<String, toml::Value>, changes: &[ChangeSpec]) -> (Params, Vec<(f64, Params)>) {
    let table = |values: &BTreeMap<String, toml::Value>| -> Params {
        values.iter().map(|(key, value)| (key.clone(), value.clone())).collect()
    };
    let first = table(start);
    let mut current = first.clone();
    let change = |change: &ChangeSpec| {
        current.extend(table(&change.params));
        (change.at, current.clone())
    };
    (first, changes.iter().map(change).collect())
}
