//! Collects what the reader ignores: one notice of each kind, with the first line and the count.

use std::collections::HashMap;

use super::document::{Document, Id};
use crate::robot::notices::Notices;

/// A kind of notice.
struct Kind {
    message: String,
    first: Id,
    count: usize,
    is_warning: bool,
}

/// What a file is read as.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub(super) enum Role {
    /// The robot of a file.
    #[default]
    Robot,
    /// A part of a file selected by name: a robot, or an object of a world.
    Part,
    /// A world, which gives gravity and friction.
    World,
}

/// Notices by kind, in order of the first of each.
#[derive(Default)]
pub(super) struct Ignored {
    pub role: Role,
    kinds: Vec<Kind>,
    index: HashMap<String, usize>,
}

impl Ignored {
    /// For a file that is read as `role`.
    pub fn of(role: Role) -> Self {
        Self { role, ..Self::default() }
    }

    /// Counts a note: it has no effect on a simulation, or an assumption.
    pub fn note(&mut self, id: Id, message: impl Into<String>) {
        self.add(id, message.into(), false);
    }

    /// Counts a warning: the robot differs from that of MuJoCo.
    pub fn warning(&mut self, id: Id, message: impl Into<String>) {
        self.add(id, message.into(), true);
    }

    fn add(&mut self, id: Id, message: String, is_warning: bool) {
        match self.index.get(&message) {
            Some(&kind) => self.kinds[kind].count += 1,
            None => {
                self.index.insert(message.clone(), self.kinds.len());
                self.kinds.push(Kind { message, first: id, count: 1, is_warning });
            }
        }
    }

    /// All kinds: first element, whether it is a warning, text.
    pub fn into_list(self) -> impl Iterator<Item = (Id, bool, String)> {
        self.kinds.into_iter().map(|Kind { message, first, count, is_warning }| {
            let message = if count > 1 { format!("{message} ({count} times)") } else { message };
            (first, is_warning, message)
        })
    }

    /// Reports all kinds.
    pub fn report(self, document: &Document, notices: &mut Notices) {
        for (first, is_warning, message) in self.into_list() {
            let (source, at) = (document.source(first), document.at(first));
            if is_warning {
                notices.warning(source, at, message);
            } else {
                notices.info(source, at, message);
            }
        }
    }
}
