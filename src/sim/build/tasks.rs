//! The task server with its tasks from their entries.

use super::names;
use crate::robot::Model;
use crate::scenario::{Diagnostic, Run, TaskSpec, suggest};
use crate::sim::setup::Start;
use crate::task::gait::Stride;
use crate::task::kinematic::figure;
use crate::task::posture::Posture;
use crate::task::squat::{Shape, Squat};
use crate::task::walk::Walk;
use crate::task::{Command, Task, TaskServer};

/// Tasks in file order; those that do not fit the robot are errors at their places.
pub(super) fn tasks(run: &Run, model: &Model, start: &Start, errors: &mut Vec<Diagnostic>) -> TaskServer {
    let mut server = TaskServer::new(run.scenario.control.rate, model, Command::hold(model, &start.joints));
    for (i, spec) in run.scenario.task.iter().enumerate() {
        let path = format!("task.{i}");
        let (start, task): (f64, Box<dyn Task>) = match spec {
            TaskSpec::Posture(posture) => {
                let targets = names::joints(model, run, &format!("{path}.joints"), posture.joints.iter(), errors);
                (posture.start, Box::new(Posture::new(targets, posture.duration)))
            }
            TaskSpec::Squat(squat) => {
                if let Err(e) = figure::check(model) {
                    errors.push(run.error_at(&format!("{path}.type"), format!("`squat` cannot be planned: {e}"), None));
                    continue;
                }
                let shape = Shape {
                    depth: squat.depth,
                    period: squat.period,
                    repetitions: squat.repetitions,
                    settle: squat.settle,
                };
                (squat.start, Box::new(Squat::new(model, shape)))
            }
            TaskSpec::Walk(walk) => {
                if let Err(e) = figure::check_biped(model) {
                    errors.push(run.error_at(&format!("{path}.type"), format!("`walk` cannot be planned: {e}"), None));
                    continue;
                }
                let Some(first) = first_foot(run, model, &path, walk.first.as_deref(), errors) else { continue };
                let stride = Stride {
                    steps: walk.steps as usize,
                    length: walk.step_length,
                    time: walk.step_time,
                    double_support: walk.double_support,
                    height: walk.step_height,
                    wait: walk.wait,
                    first,
                };
                (walk.start, Box::new(Walk::new(model, stride, walk.com_height, walk.settle)))
            }
        };
        server.add(start, task);
    }
    server
}

/// Number of the sole that swings first; an unknown name is an error.
fn first_foot(
    run: &Run,
    model: &Model,
    path: &str,
    name: Option<&str>,
    errors: &mut Vec<Diagnostic>,
) -> Option<usize> {
    let Some(name) = name else { return Some(0) };
    let found = model.soles.iter().position(|s| s.name == name);
    if found.is_none() {
        let help = suggest(name, model.soles.iter().map(|s| s.name.as_str()));
        let message = format!("the robot `{}` has no sole `{name}`", model.name);
        errors.push(run.error_at(&format!("{path}.first"), message, Some(help)));
    }
    found
}
