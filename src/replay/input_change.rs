//! Changes of a run's inputs since it was recorded.

use crate::results::{InputHash, RunRecord};
use std::fmt;

/// A change since the record.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum InputChange {
    /// Another program or version.
    Program {
        /// The one that wrote the record.
        then: String,
        /// This one.
        now: String,
    },
    /// Another build of the same version.
    Build {
        /// The one that wrote the record.
        then: String,
        /// This one.
        now: String,
    },
    /// Another kind of machine; results are equal on machines of one kind only.
    Machine {
        /// System and processor architecture of the record.
        then: String,
        /// Those of this machine.
        now: String,
    },
    /// A file has other bytes.
    Input(String),
    /// A file that the recorded run did not read.
    New(String),
    /// A file that the re-run does not read.
    Removed(String),
    /// All files are unchanged, but the key differs: the scenario in the record is not the one that
    /// was run.
    Record,
}

impl fmt::Display for InputChange {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            InputChange::Program { then, now } => write!(f, "it was run by {then}, this is {now}"),
            InputChange::Build { then, now } => {
                write!(f, "it was run by another build of this version, {then}, this is {now}")
            }
            InputChange::Machine { then, now } => write!(f, "it was run on {then}, this is {now}"),
            InputChange::Input(name) => write!(f, "{name} has changed since the record"),
            InputChange::New(name) => write!(f, "{name} was not among its files"),
            InputChange::Removed(name) => write!(f, "{name} is no longer among its files"),
            InputChange::Record => {
                write!(f, "the scenario in the record is not the one that was run: it gives another key")
            }
        }
    }
}

impl InputChange {
    /// True unless only the build of the program differs.
    pub fn affects_result(&self) -> bool {
        !matches!(self, InputChange::Build { .. })
    }
}

/// Differences between the inputs of two records of one run. Names may repeat (two meshes of one
/// name in different packages); the n-th file of a name is compared with the n-th.
pub(super) fn changes(then: &RunRecord, now: &RunRecord) -> Vec<InputChange> {
    let mut all = Vec::new();
    if then.program != now.program {
        all.push(InputChange::Program { then: then.program.clone(), now: now.program.clone() });
    }
    if let (true, Some(a), Some(b)) = (then.program == now.program, &then.timing.build, &now.timing.build)
        && a != b
    {
        all.push(InputChange::Build { then: a.clone(), now: b.clone() });
    }
    let machine = |r: &RunRecord| format!("{} {}", r.timing.machine.os, r.timing.machine.arch);
    if machine(then) != machine(now) {
        all.push(InputChange::Machine { then: machine(then), now: machine(now) });
    }
    let mut remaining: Vec<&InputHash> = now.inputs.iter().collect();
    for input in &then.inputs {
        match remaining.iter().position(|other| other.name == input.name) {
            Some(at) => {
                if remaining.remove(at).blake3 != input.blake3 {
                    all.push(InputChange::Input(input.name.clone()));
                }
            }
            None => all.push(InputChange::Removed(input.name.clone())),
        }
    }
    all.extend(remaining.into_iter().map(|input| InputChange::New(input.name.clone())));
    let explained = all.iter().any(|change| !matches!(change, InputChange::Machine { .. } | InputChange::Build { .. }));
    if then.key != now.key && !explained {
        all.push(InputChange::Record);
    }
    all
}
