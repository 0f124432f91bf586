//! The reference run of a cell: its scenario, changed by the values of `compare.reference`.

use super::scenario::{self, Scenario};
use crate::scenario::findings::Findings;
use crate::scenario::format::run::LogSpec;
use crate::scenario::key_path::KeyPath;
use crate::text::source::Sources;
use crate::text::toml_tree::{Node, Value};

/// Keys of a scenario that concern the use of a run, not its simulation, and the world, whose
/// entries replace it.
const EXCLUDED_KEYS: [&str; 9] =
    ["schema", "description", "world", "sweep", "log", "expect", "claim", "search", "compare"];

/// A reference run before its seed is known.
pub(super) struct Reference {
    /// Every value, defaults included.
    pub scenario: Scenario,
    /// The values of `compare.reference`, with their spans.
    pub values: Vec<(KeyPath, Node)>,
    /// Warnings about the reference alone.
    pub warnings: Findings,
}

impl Reference {
    /// Reads the reference of a cell's tree; `None` without `compare.reference` or after an error,
    /// which goes to `findings`.
    pub fn read(cell: &Node, sources: &Sources, findings: &mut Findings) -> Option<Reference> {
        // A value that is not a table is reported when `[compare]` is read.
        let table = cell.get("compare")?.get("reference").filter(|node| matches!(node.value, Value::Table(_)))?;
        let mut tree = cell.clone();
        let mut values: Vec<(KeyPath, Node)> = Vec::new();
        let mut is_valid = true;
        for entry in table.entries() {
            let set = KeyPath::parse(&entry.key, &entry.key_span, sources)
                .map_err(|e| (e.span, e.message, None))
                .and_then(|path| {
                    check_key(&entry.key, &path, &entry.node, &values)
                        .map_err(|(message, help)| (entry.key_span.clone(), message, help))?;
                    path.set(&mut tree, entry.node.clone()).map_err(|e| (e.span, e.message, None))?;
                    Ok(path)
                });
            match set {
                Ok(path) => values.push((path, entry.node.clone())),
                Err((span, message, help)) => {
                    findings.error(span, message, help);
                    is_valid = false;
                }
            }
        }
        for part in EXCLUDED_KEYS {
            tree.remove(part);
        }
        let (scenario, mut found) = scenario::read(&tree);
        // Without a scenario there are errors, which replace the warnings.
        if scenario.is_some() {
            found.explain(|_| Some("this concerns the reference run".into()));
        }
        let warnings = findings.append(found);
        let log = log_settings(cell);
        scenario.filter(|_| is_valid).map(|scenario| Reference {
            scenario: Scenario { log, ..scenario },
            values,
            warnings,
        })
    }

    /// True when the reference sets its own seed.
    pub fn has_own_seed(&self) -> bool {
        self.values.iter().any(|(path, _)| path.segments[0].0 == "seed")
    }
}

/// Refuses keys that `compare.reference` cannot have, with message and help.
fn check_key(
    key: &str,
    path: &KeyPath,
    value: &Node,
    earlier: &[(KeyPath, Node)],
) -> Result<(), (String, Option<String>)> {
    let first = path.segments[0].0.as_str();
    if EXCLUDED_KEYS.contains(&first) {
        return Err((format!("`{first}` cannot be set in a reference run"), None));
    }
    if earlier.iter().any(|(other, _)| other.overlaps(path)) {
        return Err((format!("`{key}` overlaps another key of the reference"), None));
    }
    match value.entries().first() {
        // It would replace the whole section and reset its other keys to their defaults.
        Some(inner) if path.segments.len() == 1 => {
            let help = format!("a path is written as one key in quotes: \"{first}.{}\" = ...", inner.key);
            Err((format!("`{first}` cannot be replaced as a whole in a reference"), Some(help)))
        }
        _ => Ok(()),
    }
}

/// The log settings of a reference: it is compared at the instants of the cell's log, or of the
/// default log.
fn log_settings(cell: &Node) -> LogSpec {
    let rate = match cell.get("log").and_then(|log| log.get("rate")).map(|rate| &rate.value) {
        Some(Value::Float(rate)) if *rate > 0.0 => *rate,
        Some(Value::Integer(rate)) if *rate > 0 => *rate as f64,
        _ => LogSpec::default().rate,
    };
    LogSpec { rate, ..LogSpec::default() }
}
