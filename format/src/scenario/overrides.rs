//! Overrides of a scenario file, as `--set KEY=VALUE` gives them.

use super::key_path::{KeyPath, PathError};
use crate::scenario::findings::Findings;
use crate::scenario::segment;
use crate::text::source::Sources;
use crate::text::toml_tree::{self, Node};

/// Why a `KEY=VALUE` cannot be read.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum OverrideError {
    /// There is no `=`.
    #[error("`{0}` is not of the form KEY=VALUE")]
    Form(String),
    /// Nothing precedes the `=`.
    #[error("`{0}` has no key before the `=`")]
    NoKey(String),
    /// The value begins like a TOML string, array or table but is not valid.
    #[error("`{0}` is not a TOML value")]
    Value(String),
}

impl From<OverrideError> for String {
    fn from(error: OverrideError) -> String {
        error.to_string()
    }
}

/// Reads `KEY=VALUE`, the key a dotted path and the value as in TOML. A value that is not TOML is
/// taken as a string, so that `contact.method=one-step` needs no quotes.
///
/// # Errors
/// See [`OverrideError`].
pub fn parse_override(text: &str) -> Result<(String, toml::Value), OverrideError> {
    let (key, value) = text.split_once('=').ok_or_else(|| OverrideError::Form(text.to_owned()))?;
    let (key, value) = (key.trim(), value.trim());
    if key.is_empty() {
        return Err(OverrideError::NoKey(text.to_owned()));
    }
    let parsed = format!("value = {value}").parse::<toml::Table>().ok().and_then(|mut t| {
        let value = t.remove("value");
        value.filter(|_| t.is_empty())
    });
    match parsed {
        Some(value) => Ok((key.to_owned(), value)),
        None if value.starts_with(['[', '{', '"', '\'']) => Err(OverrideError::Value(value.to_owned())),
        None => Ok((key.to_owned(), toml::Value::String(value.to_owned()))),
    }
}

/// Sets overrides in a scenario's tree and returns their paths; the last override of a key wins. A
/// key that contains an earlier one is refused, since it would discard that value.
pub(super) fn apply(
    root: &mut Node,
    overrides: &[(String, toml::Value)],
    sources: &mut Sources,
    findings: &mut Findings,
) -> Vec<KeyPath> {
    let mut paths = Vec::new();
    for (key, value) in overrides {
        let text = format!("{key} = {value}");
        let start = sources.add("--set", &text);
        let set = KeyPath::parse(key, &(start..start + key.len()), sources).and_then(|path| {
            let mut before = paths.iter().filter(|before: &&KeyPath| before.segments.len() > path.segments.len());
            if let Some(part) = before.find(|before| before.overlaps(&path)) {
                let part = part.segments.iter().map(|s| segment(&s.0)).collect::<Vec<_>>().join(".");
                let message = format!("`{key}` would replace `{part}`, which is set as well: set one or the other");
                return Err(PathError { span: start..start + key.len(), message });
            }
            let (node, errors) = toml_tree::assigned_value(&text, start, path.segments.len());
            findings.syntax(errors);
            path.set(root, node).map(|()| path)
        });
        match set {
            Ok(path) => paths.push(path),
            Err(error) => findings.error(error.span, error.message, None),
        }
    }
    paths
}
