//! `script`: a task written in Luau; see [`crate::script`].

use super::fields::{TaskView, View};
use super::{Params, Script, ScriptError};
use crate::task::{
    Command, Context, Needs, PointOfInterest, Status, Task, TaskError, TaskResult, has_elapsed, of_type,
};

/// Task of a script.
pub struct ScriptTask {
    name: String,
    script: Script,
    params: Params,
    /// Times of parameter changes, s.
    changes: Vec<f64>,
    /// Parameters after each change.
    changed: Vec<Params>,
    /// Joint commands at the last call of `init` or `run`.
    command: Option<Command>,
    end: f64,
}

impl ScriptTask {
    /// A task called `name`, with parameters and their changes (times in s, ascending), that ends
    /// at `end` at the latest.
    pub fn new(name: String, script: Script, params: Params, changes: Vec<(f64, Params)>, end: f64) -> Self {
        let (changes, changed) = changes.into_iter().unzip();
        ScriptTask { name, script, params, changes, changed, command: None, end }
    }
}

fn view<'a>(context: &'a Context, command: &'a Command) -> View<'a> {
    View {
        time: context.time,
        model: context.model,
        gravity: context.gravity,
        state: context.state,
        kinematics: &context.data.workspace,
        task: Some(TaskView { sensed: context.sensed, data: context.data, command }),
    }
}

fn status(continues: Result<bool, ScriptError>) -> TaskResult {
    match continues {
        Ok(true) => Ok(Status::Running),
        Ok(false) => Ok(Status::Done),
        Err(error) => Err(TaskError::other(error)),
    }
}

impl Task for ScriptTask {
    fn init(&mut self, context: &Context, command: &Command) -> TaskResult {
        self.command = Some(command.clone());
        status(self.script.init(&view(context, command), &self.params))
    }

    fn run(&mut self, context: &Context, command: &mut Command) -> TaskResult {
        if has_elapsed(context.time, self.end) {
            return Ok(Status::Done);
        }
        let current = self.command.get_or_insert_with(|| command.clone());
        current.copy_from(command);
        status(self.script.run_task(&view(context, current), command))
    }

    fn change(&mut self, context: &Context, number: usize) -> TaskResult {
        let Some(command) = &self.command else { return Ok(Status::Running) };
        status(self.script.change(&view(context, command), &self.changed[number]))
    }

    fn adopt_changes(&mut self, newer: Box<dyn Task>) {
        if let Some(newer) = of_type::<Self>(newer) {
            self.changes = newer.changes;
            self.changed = newer.changed;
        }
    }

    fn changes(&self) -> &[f64] {
        &self.changes
    }

    fn needs(&self) -> Needs {
        self.script.needs()
    }

    fn points(&self) -> &[PointOfInterest] {
        self.script.points()
    }

    fn name(&self) -> &str {
        &self.name
    }
}
