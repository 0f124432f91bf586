//! The scenario of a run after each of its events.
//!
//! The values of each `[[event]]` are set in the scenario in order of time, and the scenario is
//! read again after each. All errors are thus found before the run starts, and are shown at the
//! event.

use super::run::Run;
use super::scenario::{self, Scenario};
use crate::scenario::findings::Findings;
use crate::scenario::key_path::KeyPath;
use crate::text::source::{Sources, Span};
use crate::text::toml_tree::{Entry, Node};

/// Help: the keys that an event may set.
const CHANGEABLE: &str = "an event may set \"floor.friction\", \"floor.patches\", \"gravity\", \"contact.restitution\", \
                          \"robot.payload\", \"robot.joint.NAME.kp\" (or kd, effort, velocity, friction, armature), \
                          \"robot.joint_default.kp\" (or kd), \"force.N.KEY\"";

/// One event of a run.
#[derive(Clone, Debug)]
pub struct Event {
    /// Index among the entries of the file.
    pub index: usize,
    /// Time, s.
    pub at: f64,
    /// Dotted paths of the values it sets.
    pub set: Vec<String>,
    /// The same with the new values, for messages.
    pub assignments: String,
    /// The run with the values of this event and those before it.
    pub after: Box<Run>,
    /// Indices of the tasks it ends.
    pub end_tasks: Vec<usize>,
    /// Name under which the state is saved.
    pub save: Option<String>,
    /// Name of the state it restores.
    pub restore: Option<String>,
}

/// The events of a run in order of time; `None` after an error, which goes to `findings`.
pub(super) fn read(run: &Run, sources: &Sources, findings: &mut Findings) -> Option<Vec<Event>> {
    if run.scenario.event.is_empty() {
        return Some(Vec::new());
    }
    let mut order: Vec<usize> = (0..run.scenario.event.len()).collect();
    order.sort_by(|&a, &b| run.scenario.event[a].at.total_cmp(&run.scenario.event[b].at));
    let mut root = run.origin.tree();
    let mut after = Run { events: Vec::new(), reference: None, ..run.clone() };
    let mut events = Vec::with_capacity(order.len());
    for index in order {
        let spec = &run.scenario.event[index];
        let values = root.get("event").and_then(|all| all.items().get(index)).and_then(|event| event.get("set"));
        let entries = values.map_or(&[][..], Node::entries).to_vec();
        let mut paths: Vec<KeyPath> = Vec::new();
        for entry in &entries {
            match set_value(entry, &paths, &mut root, sources) {
                Ok(path) => {
                    after.origin.add(&path, &entry.node);
                    paths.push(path);
                }
                Err((span, message, help)) => findings.error(span, message, help),
            }
        }
        if findings.has_errors() {
            return None;
        }
        let (scenario, found) = scenario::read(&root);
        let Some(scenario) = scenario else {
            findings.append(found);
            return None;
        };
        after.scenario = Scenario { seed: run.scenario.seed, ..scenario };
        let assignment = |e: &Entry| format!("{} = {}", e.key, e.node.to_toml());
        events.push(Event {
            index,
            at: spec.at,
            set: paths.iter().map(dotted).collect(),
            assignments: entries.iter().map(assignment).collect::<Vec<_>>().join(", "),
            after: Box::new(after.clone()),
            end_tasks: spec.end_tasks.clone(),
            save: spec.save.clone(),
            restore: spec.restore.clone(),
        });
    }
    Some(events)
}

fn dotted(path: &KeyPath) -> String {
    path.segments.iter().map(|s| s.0.as_str()).collect::<Vec<_>>().join(".")
}

/// Span, message and help of an error.
type EventError = (Span, String, Option<String>);

/// Sets one value of an event in the scenario.
fn set_value(entry: &Entry, earlier: &[KeyPath], root: &mut Node, sources: &Sources) -> Result<KeyPath, EventError> {
    let path = KeyPath::parse(&entry.key, &entry.key_span, sources).map_err(|e| (e.span, e.message, None))?;
    let segments: Vec<&str> = path.segments.iter().map(|s| s.0.as_str()).collect();
    let refuse = |message: String, help: &str| Err((entry.key_span.clone(), message, Some(help.to_owned())));
    if !may_change(&segments) {
        if let Some(inner) = entry.node.entries().first() {
            let help = format!("a path is written as one key in quotes: \"{}.{}\" = ...", entry.key, inner.key);
            return refuse(format!("`{}` cannot be set as a whole by an event", entry.key), &help);
        }
        return refuse(format!("`{}` cannot change during a run", entry.key), CHANGEABLE);
    }
    if earlier.iter().any(|other| other.overlaps(&path)) {
        return refuse(format!("`{}` overlaps another key of the event", entry.key), "give it once");
    }
    let whole = whole_value(&path);
    let help = whole.as_ref().map(|whole| format!("set the whole: \"{0}\" = ...", dotted(whole)));
    if let Some(whole) = whole.filter(|whole| whole.get(root).is_none()) {
        let message = format!("the file has no `{0}`, whose default has no `{1}` to set", dotted(&whole), entry.key);
        return Err((entry.key_span.clone(), message, help));
    }
    path.set(root, entry.node.clone()).map_err(|e| (e.span, e.message, help))?;
    Ok(path)
}

/// The path of the whole value if the path sets a part of a value that the file may lack or write
/// in another form.
fn whole_value(path: &KeyPath) -> Option<KeyPath> {
    let names: Vec<&str> = path.segments.iter().map(|s| s.0.as_str()).collect();
    let length = match names[..] {
        ["gravity", _, ..] => 1,
        ["floor", "friction", _, ..] => 2,
        ["robot", "joint", _, "friction", _, ..] => 4,
        _ => return None,
    };
    Some(path.prefix(length))
}

/// True when an event may set this path.
fn may_change(path: &[&str]) -> bool {
    match path {
        ["gravity", ..] | ["floor", "friction" | "patches", ..] | ["contact", "restitution"] => true,
        ["robot", "payload", ..] | ["robot", "joint_default", "kp" | "kd"] => true,
        ["robot", "joint", _, "kp" | "kd" | "effort" | "velocity" | "armature"] => true,
        ["robot", "joint", _, "friction", ..] => true,
        // Another type or file would be another force.
        ["force", _, key, ..] => !matches!(*key, "type" | "file"),
        _ => false,
    }
}
