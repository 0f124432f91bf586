//! The task server with its tasks from their entries.

use super::{balance, names, planned, script};
use crate::robot::Model;
use crate::scenario::{Diagnostic, Run, TaskSpec};
use crate::sim::setup::Start;
use crate::task::posture::Posture;
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
            TaskSpec::Balance(spec) => match balance::balance(run, model, &path, spec, errors) {
                Some(task) => (spec.start, task),
                None => continue,
            },
            TaskSpec::GravityCompensation(spec) => {
                (spec.start, balance::gravity_compensation(run, model, &path, spec, errors))
            }
            TaskSpec::Script(spec) => match script::task(run, model, i, spec, errors) {
                Some(task) => (spec.start, task),
                None => continue,
            },
            TaskSpec::Squat(spec) => match planned::squat(run, model, &path, spec, errors) {
                Some(task) => (spec.start, task),
                None => continue,
            },
            TaskSpec::Walk(spec) => match planned::walk(run, model, &path, spec, errors) {
                Some(task) => (spec.start, task),
                None => continue,
            },
        };
        server.add(start, task);
    }
    server
}
