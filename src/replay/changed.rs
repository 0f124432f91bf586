//! What of a run's inputs is not as it was.

use crate::results::{InputHash, RunRecord};
use std::fmt;

/// Something that is not as it was.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Change {
    /// Another program or version.
    Program {
        /// The one that made the record.
        then: String,
        /// This one.
        now: String,
    },
    /// Another build of the same version.
    Build {
        /// The one that made the record.
        then: String,
        /// This one.
        now: String,
    },
    /// Another machine: results are equal on equal kinds of machine.
    Machine {
        /// Then.
        then: String,
        /// Here.
        now: String,
    },
    /// A file has other bytes.
    Input(String),
    /// A file was not read then.
    New(String),
    /// A file is not read any more.
    Gone(String),
    /// All files are as they were, and yet the key is another: the scenario in the record is not the one that was run.
    Record,
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Change::Program { then, now } => write!(f, "it was run by {then}, this is {now}"),
            Change::Build { then, now } => {
                write!(f, "it was run by another build of this version, {then}, this is {now}")
            }
            Change::Machine { then, now } => write!(f, "it was run on {then}, this is {now}"),
            Change::Input(name) => write!(f, "{name} has changed since"),
            Change::New(name) => write!(f, "{name} was not among its files"),
            Change::Gone(name) => write!(f, "{name} is not among its files any more"),
            Change::Record => write!(f, "the scenario in the record is not the one that was run: it gives another key"),
        }
    }
}

impl Change {
    /// Is it something that the result may depend on, and not only the program as it was built?
    pub fn is_of_inputs(&self) -> bool {
        !matches!(self, Change::Build { .. })
    }
}

/// What differs between the inputs of two records of one run. Names may repeat (two meshes of one name in different
/// packages); the n-th of a name is compared with the n-th.
pub(super) fn changes(then: &RunRecord, now: &RunRecord) -> Vec<Change> {
    let mut all = Vec::new();
    if then.program != now.program {
        all.push(Change::Program { then: then.program.clone(), now: now.program.clone() });
    }
    if let (true, Some(a), Some(b)) = (then.program == now.program, &then.timing.build, &now.timing.build)
        && a != b
    {
        all.push(Change::Build { then: a.clone(), now: b.clone() });
    }
    let machine = |r: &RunRecord| format!("{} {}", r.timing.machine.os, r.timing.machine.arch);
    if machine(then) != machine(now) {
        all.push(Change::Machine { then: machine(then), now: machine(now) });
    }
    let mut left: Vec<&InputHash> = now.inputs.iter().collect();
    for input in &then.inputs {
        match left.iter().position(|other| other.name == input.name) {
            Some(at) => {
                if left.remove(at).blake3 != input.blake3 {
                    all.push(Change::Input(input.name.clone()));
                }
            }
            None => all.push(Change::Gone(input.name.clone())),
        }
    }
    all.extend(left.into_iter().map(|input| Change::New(input.name.clone())));
    let explained = all.iter().any(|change| !matches!(change, Change::Machine { .. } | Change::Build { .. }));
    if then.key != now.key && !explained {
        all.push(Change::Record);
    }
    all
}
