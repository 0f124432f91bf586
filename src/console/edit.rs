//! What is changed of floor, robot and forces while the run goes on, and states saved and restored.

use toml::{Table, Value};

use crate::console::document::put;
use crate::console::error::ConsoleError;
use crate::console::session::Session;
use crate::console::words::{Words, segments};

impl Session {
    /// An event at the present time.
    pub(super) fn event(&self) -> Table {
        Table::from_iter([("at".to_owned(), Value::Float(self.time()))])
    }

    pub(super) fn add_event(&mut self, event: Table) -> Result<String, ConsoleError> {
        self.edit(|document| {
            document.list("event").push(Value::Table(event));
            Ok(())
        })
    }

    /// Sets values: as those of the start before anything has moved, else by an event.
    fn assign(&mut self, values: Vec<(String, Value)>) -> Result<String, ConsoleError> {
        if !self.simulation.has_begun() {
            return self
                .edit(|document| values.into_iter().try_for_each(|(key, value)| set_first(document, &key, value)));
        }
        let mut event = self.event();
        event.insert("set".into(), Value::Table(Table::from_iter(values)));
        self.add_event(event)
    }

    /// `set KEY=VALUE ...`
    pub(super) fn set(&mut self, words: &mut Words) -> Result<String, ConsoleError> {
        let values = words.assignments()?;
        if values.is_empty() {
            return Err(ConsoleError::usage("a value is missing, such as floor.friction=0.3"));
        }
        self.assign(values)
    }

    /// `get KEY`
    pub(super) fn get(&self, words: &mut Words) -> Result<String, ConsoleError> {
        let key = words.need("a dotted key")?.to_owned();
        words.done()?;
        let all = Table::try_from(self.present()).map_err(|error| ConsoleError::usage(error.to_string()))?;
        let mut value = &Value::Table(all);
        for segment in segments(&key)? {
            let inner = match value {
                Value::Array(list) => segment.parse::<usize>().ok().and_then(|i| list.get(i)),
                other => other.get(&segment),
            };
            value =
                inner.ok_or_else(|| ConsoleError::usage(format!("`{key}` has no value: `{segment}` is not there")))?;
        }
        Ok(format!("{value}\n").replace("\n\n", "\n"))
    }

    /// `floor STATIC [KINETIC]`
    pub(super) fn floor(&mut self, words: &mut Words) -> Result<String, ConsoleError> {
        if words.peek().is_none() {
            let friction = self.present().floor.friction;
            return Ok(format!("static {}, kinetic {}\n", friction.static_, friction.kinetic));
        }
        let rest = words.number("the coefficient of static friction")?;
        let sliding = words.some_number().unwrap_or(rest);
        words.done()?;
        let friction =
            Table::from_iter([("static".to_owned(), Value::Float(rest)), ("kinetic".into(), sliding.into())]);
        self.assign(vec![("floor.friction".into(), Value::Table(friction))])
    }

    /// `friction JOINT KEY=VALUE ...`
    pub(super) fn friction(&mut self, words: &mut Words) -> Result<String, ConsoleError> {
        let joint = self.joint(words)?;
        let values = words.assignments()?;
        if values.is_empty() {
            let law = self.model().joints[joint.0].friction_law();
            return Ok(format!(
                "coulomb {}, viscous {}, static {}, stribeck_velocity {}, slip_velocity {}\n",
                law.coulomb, law.viscous, law.static_, law.stribeck_velocity, law.slip_velocity
            ));
        }
        let mut friction = Table::new();
        for (key, value) in values {
            put(&mut friction, &key, value)?;
        }
        let key = format!("robot.joint.{}.friction", quoted(&joint.1));
        self.assign(vec![(key, Value::Table(friction))])
    }

    /// Number and name of the joint that the next word is.
    fn joint(&self, words: &mut Words) -> Result<(usize, String), ConsoleError> {
        let name = words.need("a joint")?.to_owned();
        let model = self.model();
        let unknown = || {
            let names = model.joints.iter().map(|joint| joint.name.as_str());
            ConsoleError::usage(format!("there is no joint `{name}`; {}", crate::text::suggest(&name, names)))
        };
        model.joint(&name).map(|id| (id.0, name.clone())).ok_or_else(unknown)
    }

    /// `payload LINK MASS [X Y Z]`; mass 0 takes it off.
    pub(super) fn payload(&mut self, words: &mut Words) -> Result<String, ConsoleError> {
        let written = |spec: &crate::scenario::PayloadSpec| Value::try_from(spec);
        let wrong = |error: toml::ser::Error| ConsoleError::usage(error.to_string());
        let present: Result<Vec<Value>, _> = self.present().robot.payload.iter().map(written).collect();
        let mut list = present.map_err(wrong)?;
        if words.peek().is_none() {
            return Ok(list.iter().map(|value| format!("{value}\n")).collect());
        }
        let link = words.need("a link")?.to_owned();
        let mass = words.number("the mass")?;
        let position = if words.peek().is_some() { words.vector("the position")? } else { [0.0; 3] };
        words.done()?;
        list.retain(|other| other.get("link").and_then(Value::as_str) != Some(&link));
        if mass != 0.0 {
            let position = position.map(Value::Float).to_vec();
            list.push(Value::Table(Table::from_iter([
                ("link".to_owned(), Value::String(link)),
                ("mass".to_owned(), Value::Float(mass)),
                ("position".to_owned(), Value::Array(position)),
            ])));
        }
        self.assign(vec![("robot.payload".into(), Value::Array(list))])
    }

    /// `push LINK FX FY FZ [for SECONDS] [at X Y Z] [KEY=VALUE ...]`
    pub(super) fn push(&mut self, words: &mut Words) -> Result<String, ConsoleError> {
        let link = words.need("a link")?.to_owned();
        let force = words.vector("the force")?;
        let mut values = vec![("link".to_owned(), Value::String(link)), ("force".to_owned(), vector(force))];
        let mut seconds = 0.1;
        loop {
            if words.take("for") {
                seconds = words.number("a time")?;
            } else if words.take("at") {
                values.push(("point".to_owned(), vector(words.vector("the point")?)));
            } else {
                break;
            }
        }
        values.push(("duration".to_owned(), Value::Float(seconds)));
        values.extend(words.assignments()?);
        self.add_force("push", values)
    }

    /// `force TYPE KEY=VALUE ...`; without words what there is.
    pub(super) fn force(&mut self, words: &mut Words) -> Result<String, ConsoleError> {
        let Some(kind) = words.next().map(str::to_owned) else {
            let forces = self.present().force.iter().enumerate();
            let lines: String = forces.map(|(i, force)| format!("{i} {}\n", force.type_name())).collect();
            return Ok(if lines.is_empty() { "no forces\n".to_owned() } else { lines });
        };
        if kind == "script" && self.simulation.has_begun() {
            let why = "a script begins with the run: it can be added before the first step, and changed later";
            return Err(ConsoleError::usage(why));
        }
        let values = words.assignments()?;
        self.add_force(&kind, values)
    }

    fn add_force(&mut self, kind: &str, values: Vec<(String, Value)>) -> Result<String, ConsoleError> {
        let mut entry = self.entry(kind, values)?;
        if kind == "joint-friction" {
            if self.simulation.has_begun() {
                let why = "joint friction acts throughout: it can be added before the first step, and changed later";
                return Err(ConsoleError::usage(why));
            }
            entry.remove("start");
        }
        let number = self.present().force.len();
        let news = self.edit(|document| {
            document.list("force").push(Value::Table(entry));
            Ok(())
        })?;
        Ok(format!("{news}force {number}, {kind}, from {} s\n", self.time()))
    }

    /// `store NAME`
    pub(super) fn store(&mut self, words: &mut Words) -> Result<String, ConsoleError> {
        let name = words.need("a name")?.to_owned();
        words.done()?;
        let mut event = self.event();
        event.insert("save".into(), Value::String(name.clone()));
        self.add_event(event)?;
        Ok(format!("state {name} at {} s\n", self.time()))
    }

    /// `restore NAME`
    pub(super) fn restore(&mut self, words: &mut Words) -> Result<String, ConsoleError> {
        let name = words.need("a name")?.to_owned();
        words.done()?;
        let mut event = self.event();
        event.insert("restore".into(), Value::String(name.clone()));
        self.add_event(event)
    }

    pub(super) fn states(&self) -> String {
        let saved = self.run.events.iter().filter_map(|event| Some((event.save.as_deref()?, event.at)));
        let lines: String = saved.map(|(name, at)| format!("{name} at {at} s\n")).collect();
        if lines.is_empty() { "no states\n".to_owned() } else { lines }
    }
}

/// Sets a value of the start; lists are entered by number.
fn set_first(document: &mut crate::console::document::Document, key: &str, value: Value) -> Result<(), ConsoleError> {
    let path = segments(key)?;
    if let [list, number, rest @ ..] = &path[..]
        && let Some(entry) = number.parse::<usize>().ok().and_then(|i| document.list(list).get_mut(i))
    {
        return match (rest, entry) {
            ([], entry) => {
                *entry = value;
                Ok(())
            }
            (_, Value::Table(table)) => put(table, &joined(rest), value),
            _ => Err(ConsoleError::usage(format!("`{key}` leads into no table"))),
        };
    }
    put(&mut document.table, key, value)
}

fn joined(segments: &[String]) -> String {
    segments.iter().map(|segment| quoted(segment)).collect::<Vec<_>>().join(".")
}

/// A name as a segment of a dotted key.
fn quoted(name: &str) -> String {
    let plain = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
    if plain { name.to_owned() } else { Value::String(name.to_owned()).to_string() }
}

fn vector(vector: [f64; 3]) -> Value {
    Value::Array(vector.map(Value::Float).to_vec())
}
