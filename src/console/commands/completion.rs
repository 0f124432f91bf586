//! Completes a line from the command table and the names of the session.

use crate::console::commands::table::{ArgumentKind, COMMANDS, find};
use crate::console::session::Session;
use crate::export::column_names;
use crate::scenario::{ForceSpec, TaskSpec};
use crate::task::server::TaskState;

/// Names offered by completion; collected from the session after each command.
#[derive(Clone, Debug, Default)]
pub struct Names {
    joints: Vec<String>,
    links: Vec<String>,
    soles: Vec<String>,
    tasks: Vec<String>,
    states: Vec<String>,
    columns: Vec<String>,
    forces: usize,
}

impl Session {
    /// Collects the names known at present.
    pub fn names(&mut self) -> Names {
        let columns = self.with_displayed_log(|_, log, _| Ok(column_names(log))).unwrap_or_default();
        let model = self.model();
        let active =
            self.simulation.tasks().states().enumerate().filter(|(_, (_, _, state))| *state != TaskState::Ended);
        Names {
            columns,
            joints: model.joints.iter().map(|joint| joint.name.clone()).collect(),
            links: crate::script::links(model).map(|(name, ..)| name.to_owned()).collect(),
            soles: model.soles.iter().map(|sole| sole.name.clone()).collect(),
            tasks: active.map(|(i, _)| i.to_string()).chain(["all".to_owned()]).collect(),
            states: self.run.events.iter().filter_map(|event| event.save.clone()).collect(),
            forces: self.present().force.len(),
        }
    }
}

/// Start of the word that ends at `end`, and its candidates; `None` for file names, which the
/// caller completes.
pub fn complete(names: &Names, line: &str, end: usize) -> (usize, Option<Vec<String>>) {
    let before = line.get(..end).unwrap_or(line);
    let begin = before.rfind(char::is_whitespace).map_or(0, |at| at + 1);
    let word = &before[begin..];
    let earlier: Vec<&str> = before[..begin].split_whitespace().collect();
    let Some((first, rest)) = earlier.split_first() else {
        return (begin, Some(matching(word, COMMANDS.iter().map(|command| command.name.to_owned()))));
    };
    let Ok(command) = find(first) else { return (begin, Some(Vec::new())) };
    let kind = command.arguments.get(rest.len()).or(command.arguments.last()).copied().unwrap_or(ArgumentKind::Free);
    let own = |list: &[String]| matching(word, list.iter().cloned());
    let fixed = |list: &[&str]| matching(word, list.iter().map(|word| (*word).to_owned()));
    let found = match kind {
        ArgumentKind::Files => return (begin, None),
        ArgumentKind::Free => Vec::new(),
        ArgumentKind::Of(list) => fixed(list),
        ArgumentKind::Commands => matching(word, COMMANDS.iter().map(|command| command.name.to_owned())),
        ArgumentKind::Joints => own(&names.joints),
        ArgumentKind::JointValues => matching(word, names.joints.iter().map(|joint| format!("{joint}="))),
        ArgumentKind::Links => own(&names.links),
        ArgumentKind::Soles => own(&names.soles),
        ArgumentKind::Tasks => own(&names.tasks),
        ArgumentKind::States => own(&names.states),
        ArgumentKind::Columns => own(&names.columns),
        ArgumentKind::TaskTypes => fixed(TaskSpec::TYPES),
        ArgumentKind::ForceTypes => fixed(ForceSpec::TYPES),
        ArgumentKind::Keys => matching(word, keys(names)),
    };
    (begin, Some(found))
}

fn matching(word: &str, of: impl Iterator<Item = String>) -> Vec<String> {
    of.filter(|candidate| candidate.starts_with(word)).collect()
}

fn keys(names: &Names) -> impl Iterator<Item = String> {
    let plain = ["floor.friction=", "floor.patches=", "gravity=", "contact.restitution=", "robot.payload="];
    let joint = |joint: &String| {
        let parts = ["kp", "kd", "effort", "velocity", "friction", "armature"];
        let joint = joint.clone();
        parts.map(|part| format!("robot.joint.{joint}.{part}="))
    };
    let joints: Vec<String> = names.joints.iter().flat_map(joint).collect();
    let forces = (0..names.forces).map(|i| format!("force.{i}."));
    plain.map(str::to_owned).into_iter().chain(joints).chain(forces).collect::<Vec<_>>().into_iter()
}
