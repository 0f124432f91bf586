//! Completion of a line, from the table of commands and from what the session has.

use crate::console::commands::{COMMANDS, Kind, find};
use crate::console::session::Session;
use crate::export::column_names;
use crate::scenario::{ForceSpec, TaskSpec};
use crate::task::server::TaskState;

/// Names that completion offers, taken from a session once after each command.
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
    /// The names that there are now.
    pub fn names(&mut self) -> Names {
        let columns = self.shown(|_, log, _| Ok(column_names(log))).unwrap_or_default();
        let model = self.model();
        let alive =
            self.simulation.tasks().states().enumerate().filter(|(_, (_, _, stand))| *stand != TaskState::Ended);
        Names {
            columns,
            joints: model.joints.iter().map(|joint| joint.name.clone()).collect(),
            links: crate::script::links(model).map(|(name, ..)| name.to_owned()).collect(),
            soles: model.soles.iter().map(|sole| sole.name.clone()).collect(),
            tasks: alive.map(|(i, _)| i.to_string()).chain(["all".to_owned()]).collect(),
            states: self.run.events.iter().filter_map(|event| event.save.clone()).collect(),
            forces: self.present().force.len(),
        }
    }
}

/// Where the word that ends at `end` begins, and what it may become; none for files, which the file system knows.
pub fn complete(names: &Names, line: &str, end: usize) -> (usize, Option<Vec<String>>) {
    let before = line.get(..end).unwrap_or(line);
    let begin = before.rfind(char::is_whitespace).map_or(0, |at| at + 1);
    let word = &before[begin..];
    let earlier: Vec<&str> = before[..begin].split_whitespace().collect();
    let Some((first, rest)) = earlier.split_first() else {
        return (begin, Some(matching(word, COMMANDS.iter().map(|command| command.name.to_owned()))));
    };
    let Ok(command) = find(first) else { return (begin, Some(Vec::new())) };
    let kind = command.words.get(rest.len()).or(command.words.last()).copied().unwrap_or(Kind::Free);
    let own = |list: &[String]| matching(word, list.iter().cloned());
    let fixed = |list: &[&str]| matching(word, list.iter().map(|word| (*word).to_owned()));
    let found = match kind {
        Kind::Files => return (begin, None),
        Kind::Free => Vec::new(),
        Kind::Of(list) => fixed(list),
        Kind::Commands => matching(word, COMMANDS.iter().map(|command| command.name.to_owned())),
        Kind::Joints => own(&names.joints),
        Kind::JointValues => matching(word, names.joints.iter().map(|joint| format!("{joint}="))),
        Kind::Links => own(&names.links),
        Kind::Soles => own(&names.soles),
        Kind::Tasks => own(&names.tasks),
        Kind::States => own(&names.states),
        Kind::Columns => own(&names.columns),
        Kind::TaskTypes => fixed(TaskSpec::TYPES),
        Kind::ForceTypes => fixed(ForceSpec::TYPES),
        Kind::Keys => matching(word, keys(names)),
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
