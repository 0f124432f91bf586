//! Commands for tasks: `tasks`, `start`, `stop`, `change`, `drive`.

use toml::{Table, Value};

use crate::console::arguments::Arguments;
use crate::console::console_error::ConsoleError;
use crate::console::scenario_document::put;
use crate::console::session::Session;
use crate::task::server::TaskState;
use crate::text::suggest;

impl Session {
    pub(in crate::console) fn tasks(&self) -> String {
        let tasks = self.simulation.tasks().states().enumerate();
        let line = |(i, (name, start, state)): (usize, (&str, f64, TaskState))| {
            let state = match state {
                TaskState::Waiting => "waits",
                TaskState::Running => "runs",
                TaskState::Ended => "has ended",
            };
            format!("{i} {name}: {state}, start {start} s\n")
        };
        let lines: String = tasks.map(line).collect();
        if lines.is_empty() { "no tasks\n".to_owned() } else { lines }
    }

    /// `start TYPE [KEY=VALUE ...]`
    pub(in crate::console) fn start(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        let kind = args.need("the type of a task")?.to_owned();
        let values = args.assignments()?;
        self.begin_task(&kind, values)
    }

    fn begin_task(&mut self, kind: &str, values: Vec<(String, Value)>) -> Result<String, ConsoleError> {
        let entry = self.entry(kind, values)?;
        let number = self.present().task.len();
        let notes = self.edit(|document| {
            document.list("task").push(Value::Table(entry));
            Ok(())
        })?;
        Ok(format!("{notes}task {number}, {kind}, from {} s\n", self.time()))
    }

    /// Scenario entry of a task or force that starts now.
    pub(in crate::console) fn entry(&self, kind: &str, values: Vec<(String, Value)>) -> Result<Table, ConsoleError> {
        let mut entry = Table::from_iter([("type".to_owned(), Value::String(kind.to_owned()))]);
        entry.insert("start".to_owned(), Value::Float(self.time()));
        for (key, value) in values {
            if key == "start" || key == "type" {
                return Err(ConsoleError::usage(format!("`{key}` is given by the command itself")));
            }
            put(&mut entry, &key, value)?;
        }
        Ok(entry)
    }

    /// Index of a task given by number, or by a type of which exactly one task has not ended.
    fn task(&self, name: &str) -> Result<usize, ConsoleError> {
        let states: Vec<_> = self.simulation.tasks().states().map(|(_, _, state)| state).collect();
        if let Ok(number) = name.parse::<usize>() {
            let known = (number < states.len()).then_some(number);
            return known.ok_or_else(|| ConsoleError::usage(format!("there is no task {number} (`tasks`)")));
        }
        let specs = self.run.scenario.task.iter();
        let kinds: Vec<&str> = specs.map(|spec| spec.type_name()).collect();
        let alive = |i: &usize| kinds[*i] == name && states.get(*i) != Some(&TaskState::Ended);
        let found: Vec<usize> = (0..kinds.len()).filter(alive).collect();
        match found[..] {
            [only] => Ok(only),
            [] if kinds.contains(&name) => {
                Err(ConsoleError::usage(format!("all tasks of type `{name}` have ended (`tasks`)")))
            }
            [] => Err(ConsoleError::usage(format!("no task is of type `{name}`; {}", suggest(name, kinds)))),
            _ => Err(ConsoleError::usage(format!(
                "several tasks are of type `{name}`: give the number of one (see `tasks`)"
            ))),
        }
    }

    /// `stop TASK|all`
    pub(in crate::console) fn stop(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        let name = args.need("a task, or `all`")?.to_owned();
        args.done()?;
        let numbers: Vec<usize> = if name == "all" {
            let states = self.simulation.tasks().states().enumerate();
            states.filter(|(_, (_, _, state))| *state != TaskState::Ended).map(|(i, _)| i).collect()
        } else {
            vec![self.task(&name)?]
        };
        if numbers.is_empty() {
            return Err(ConsoleError::usage("no task runs or waits"));
        }
        let ended = |i: &usize| self.simulation.tasks().states().nth(*i).is_some_and(|(_, _, s)| s == TaskState::Ended);
        if let Some(number) = numbers.iter().find(|i| ended(i)) {
            return Err(ConsoleError::usage(format!("task {number} has ended")));
        }
        let list = numbers.iter().map(|n| Value::Integer(*n as i64)).collect();
        let mut event = self.event();
        event.insert("end_tasks".into(), Value::Array(list));
        self.add_event(event)
    }

    /// `change TASK KEY=VALUE ...`
    pub(in crate::console) fn change(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        let name = args.need("a task")?.to_owned();
        let number = self.task(&name)?;
        let values = args.assignments()?;
        if values.is_empty() {
            return Err(ConsoleError::usage("new values are missing, such as speed=0.5"));
        }
        let now = self.time();
        let mut change = Table::from_iter([("at".to_owned(), Value::Float(now))]);
        for (key, value) in values {
            put(&mut change, &key, value)?;
        }
        self.edit(|document| {
            let Some(Value::Table(task)) = document.list("task").get_mut(number) else {
                return Err(ConsoleError::usage(format!("there is no task {number}")));
            };
            let list = task.entry("change").or_insert_with(|| Value::Array(Vec::new()));
            let Value::Array(list) = list else {
                return Err(ConsoleError::usage(format!("`task.{number}.change` is not a list")));
            };
            // Keep the list ordered by time.
            let at = |v: &Value| v.get("at").and_then(crate::console::scenario_document::as_number).unwrap_or(0.0);
            let index = list.iter().take_while(|other| at(other) <= now).count();
            list.insert(index, Value::Table(change));
            Ok(())
        })
    }

    /// `drive JOINT=VALUE ... [in SECONDS]`, or `drive home`
    pub(in crate::console) fn drive(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        let mut joints = Table::new();
        if args.take("home") {
            let model = self.model();
            let home = model.joints.iter().zip(&model.home);
            joints.extend(home.map(|(joint, q)| (joint.name.clone(), Value::Float(*q))));
        }
        while let Some(argument) = args.peek().map(str::to_owned) {
            if argument == "in" {
                break;
            }
            args.next();
            let (joint, value) = crate::scenario::parse_override(&argument).map_err(ConsoleError::usage)?;
            joints.insert(joint, value);
        }
        if joints.is_empty() {
            return Err(ConsoleError::usage("no joint is named"));
        }
        let seconds = if args.take("in") { args.number("a time")? } else { 1.0 };
        args.done()?;
        let values = vec![("joints".to_owned(), Value::Table(joints)), ("duration".to_owned(), Value::Float(seconds))];
        self.begin_task("posture", values)
    }
}
