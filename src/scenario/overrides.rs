//! Values given beside a scenario file, as `--set KEY=VALUE` does.

use super::{
    diagnostic::Findings,
    path::{Path, PathError},
    source::Sources,
    tree,
    tree::Node,
};

/// Read `KEY=VALUE`, the key a dotted path and the value as in TOML; a word that is no TOML value is taken as a string,
/// so that `contact.method=one-step` needs no quotes.
///
/// # Errors
/// In words: there is no `=`, or something that opens like a TOML string, array or table is none.
pub fn parse_override(text: &str) -> Result<(String, toml::Value), String> {
    let (key, value) = text.split_once('=').ok_or_else(|| format!("`{text}` is not of the form KEY=VALUE"))?;
    let (key, value) = (key.trim(), value.trim());
    if key.is_empty() {
        return Err(format!("`{text}` has no key before the `=`"));
    }
    let parsed = format!("value = {value}").parse::<toml::Table>().ok().and_then(|mut t| {
        let value = t.remove("value");
        if t.is_empty() { value } else { None }
    });
    match parsed {
        Some(value) => Ok((key.to_owned(), value)),
        None if value.starts_with(['[', '{', '"', '\'']) => Err(format!("`{value}` is not a TOML value")),
        None => Ok((key.to_owned(), toml::Value::String(value.to_owned()))),
    }
}

/// Put overrides into a scenario's tree, the later of one key over the earlier; the paths they lead to are returned. A key
/// that holds what is overridden before it would drop that unseen.
pub(super) fn apply(
    root: &mut Node,
    overrides: &[(String, toml::Value)],
    sources: &mut Sources,
    findings: &mut Findings,
) -> Vec<Path> {
    let mut paths = Vec::new();
    for (key, value) in overrides {
        let text = format!("{key} = {value}");
        let start = sources.add("--set", &text);
        let set = Path::parse(key, &(start..start + key.len()), sources).and_then(|path| {
            let mut before = paths.iter().filter(|before: &&Path| before.segments.len() > path.segments.len());
            if let Some(part) = before.find(|before| before.overlaps(&path)) {
                let part = part.segments.iter().map(|s| Path::segment(&s.0)).collect::<Vec<_>>().join(".");
                let message = format!("`{key}` would replace `{part}`, which is set as well: set one or the other");
                return Err(PathError { span: start..start + key.len(), message });
            }
            let node = tree::assigned(&text, start, path.segments.len(), findings);
            path.set(root, node).map(|()| path)
        });
        match set {
            Ok(path) => paths.push(path),
            Err(error) => findings.error(error.span, error.message, None),
        }
    }
    paths
}
