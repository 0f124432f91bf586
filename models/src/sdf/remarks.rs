//! Remarks about a file: elements without effect, grouped by kind, and assumptions.

use super::document::At;

/// A note or warning about an element.
#[derive(Clone, Debug)]
pub struct Remark {
    /// The element; of several the first.
    pub at: At,
    /// Whether the simulation may differ from what the author intended.
    pub is_warning: bool,
    /// What is assumed or ignored.
    pub message: String,
}

/// The remarks of a document, each kind once.
#[derive(Default, Debug)]
pub struct Remarks {
    all: Vec<Remark>,
    /// Index in `all`, and number, of each kind of ignored element.
    ignored: Vec<(String, usize, usize)>,
}

impl Remarks {
    /// Adds a note.
    pub fn note(&mut self, at: At, message: impl Into<String>) {
        self.all.push(Remark { at, is_warning: false, message: message.into() });
    }

    /// Adds a warning.
    pub fn warning(&mut self, at: At, message: impl Into<String>) {
        self.all.push(Remark { at, is_warning: true, message: message.into() });
    }

    /// Counts an element without effect; `kind` is as `<plugin> of a model`.
    pub fn ignore(&mut self, at: At, kind: String) {
        if let Some((.., count)) = self.ignored.iter_mut().find(|(known, ..)| *known == kind) {
            *count += 1;
            return;
        }
        self.ignored.push((kind, self.all.len(), 1));
        self.note(at, "");
    }

    /// All remarks, ignored elements with their number.
    pub fn into_list(mut self) -> Vec<Remark> {
        for (kind, index, count) in self.ignored {
            let more = if count == 1 { String::new() } else { format!(" ({count} of them, the first is here)") };
            self.all[index].message = format!("{kind} is ignored{more}");
        }
        self.all
    }
}
