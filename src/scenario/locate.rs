//! Which key of a scenario a diagnostic is about.

use super::diagnostic::Diagnostic;
use super::source::Span;
use super::tree::{Node, Value};
use crate::text::toml_syntax;

impl Diagnostic {
    /// The dotted path of the key at its place, such as `task.0.joints.knee`; none when there is no key there, or the file
    /// is no TOML.
    pub fn key(&self) -> Option<String> {
        let (source, range) = self.snippet.as_ref()?;
        if let Some(path) = toml_syntax::duplicate(&self.message) {
            return Some(path.to_owned());
        }
        let mut best = None;
        narrow(source.root(), &mut Vec::new(), range.start, &mut best);
        best.map(|(path, _): (Vec<String>, usize)| toml_syntax::dotted(&path))
    }
}

/// Finds the entry with the shortest key or value around a byte; of equal ones the inner.
fn narrow(node: &Node, path: &mut Vec<String>, at: usize, best: &mut Option<(Vec<String>, usize)>) {
    let mut look = |path: &mut Vec<String>, node: &Node, spans: &[&Span]| {
        for span in spans.iter().filter(|span| span.start <= at && at < span.end) {
            if best.as_ref().is_none_or(|(_, length)| span.len() <= *length) {
                *best = Some((path.clone(), span.len()));
            }
        }
        narrow(node, path, at, best);
    };
    match &node.value {
        Value::Table(entries) => {
            for entry in entries {
                path.push(entry.key.clone());
                look(path, &entry.node, &[&entry.key_span, &entry.node.span]);
                path.pop();
            }
        }
        Value::Array(items) => {
            for (index, item) in items.iter().enumerate() {
                path.push(index.to_string());
                look(path, item, &[&item.span]);
                path.pop();
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_innermost_key_or_value_at_a_place() {
        let text = "duration = 1\n[floor]\nfrction = 0.5\n[[task]]\ntype = \"posture\"\njoints = { knee = [1, 2] }\n\
                    [sweep.grid]\n\"floor.friction\" = [0.1,\n-0.2]\n";
        let key = |piece: &str| {
            let at = text.find(piece).unwrap();
            Diagnostic::in_text("s.toml", text, at..at + 1, "", None).key()
        };
        for (piece, wanted) in [
            ("duration", "duration"),
            ("= 1", "-"),
            ("1\n", "duration"),
            ("floor]", "floor"),
            ("frction", "floor.frction"),
            ("\"posture", "task.0.type"),
            ("knee", "task.0.joints.knee"),
            ("2]", "task.0.joints.knee.1"),
            ("\"floor.friction", "sweep.grid.\"floor.friction\""),
            ("-0.2", "sweep.grid.\"floor.friction\".1"),
        ] {
            assert_eq!(key(piece).as_deref().unwrap_or("-"), wanted, "{piece}");
        }
        assert_eq!(Diagnostic::in_text("x", "no toml", 0..1, "", None).key(), None);
    }
}
