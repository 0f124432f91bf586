//! Commands that edit the scenario: values, floor, joint friction, payload, pushes, forces, and
//! stored states.

use toml::{Table, Value};

use crate::console::arguments::{Arguments, segments};
use crate::console::console_error::ConsoleError;
use crate::console::scenario_document::put;
use crate::console::session::Session;

impl Session {
    /// A new event at the present time.
    pub(in crate::console) fn event(&self) -> Table {
        Table::from_iter([("at".to_owned(), Value::Float(self.time()))])
    }

    pub(in crate::console) fn add_event(&mut self, event: Table) -> Result<String, ConsoleError> {
        self.edit(|document| {
            document.list("event").push(Value::Table(event));
            Ok(())
        })
    }

    /// Sets values: in the scenario itself before the first step, later by an event.
    fn assign(&mut self, values: Vec<(String, Value)>) -> Result<String, ConsoleError> {
        if !self.simulation.has_begun() {
            return self
                .edit(|document| values.into_iter().try_for_each(|(key, value)| set_initial(document, &key, value)));
        }
        let mut event = self.event();
        event.insert("set".into(), Value::Table(Table::from_iter(values)));
        self.add_event(event)
    }

    /// `set KEY=VALUE ...`
    pub(in crate::console) fn set(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        let values = args.assignments()?;
        if values.is_empty() {
            return Err(ConsoleError::usage("a value is missing, such as floor.friction=0.3"));
        }
        self.assign(values)
    }

    /// `get KEY`
    pub(in crate::console) fn get(&self, args: &mut Arguments) -> Result<String, ConsoleError> {
        let key = args.need("a dotted key")?.to_owned();
        args.done()?;
        let all = self.present().to_table().map_err(|error| ConsoleError::usage(error.to_string()))?;
        let mut value = &Value::Table(all);
        for segment in segments(&key)? {
            let inner = match value {
                Value::Array(list) => segment.parse::<usize>().ok().and_then(|i| list.get(i)),
                other => other.get(&segment),
            };
            value =
                inner.ok_or_else(|| ConsoleError::usage(format!("`{key}` has no value: there is no `{segment}`")))?;
        }
        Ok(format!("{value}\n").replace("\n\n", "\n"))
    }

    /// `floor [STATIC [KINETIC]]`
    pub(in crate::console) fn floor(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        if args.peek().is_none() {
            let friction = self.present().floor.friction;
            return Ok(format!("static {}, kinetic {}\n", friction.static_, friction.kinetic));
        }
        let static_ = args.number("the coefficient of static friction")?;
        let kinetic = args.some_number().unwrap_or(static_);
        args.done()?;
        let friction =
            Table::from_iter([("static".to_owned(), Value::Float(static_)), ("kinetic".into(), kinetic.into())]);
        self.assign(vec![("floor.friction".into(), Value::Table(friction))])
    }

    /// `friction JOINT [KEY=VALUE ...]`
    pub(in crate::console) fn friction(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        let joint = self.joint(args)?;
        let values = args.assignments()?;
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

    /// Index and name of the joint named by the next argument.
    fn joint(&self, args: &mut Arguments) -> Result<(usize, String), ConsoleError> {
        let name = args.need("a joint")?.to_owned();
        let model = self.model();
        let unknown = || {
            let names = model.joints.iter().map(|joint| joint.name.as_str());
            ConsoleError::usage(format!("there is no joint `{name}`; {}", crate::text::suggest(&name, names)))
        };
        model.joint(&name).map(|id| (id.0, name.clone())).ok_or_else(unknown)
    }

    /// `payload [LINK MASS [X Y Z]]`; mass 0 removes the payload.
    pub(in crate::console) fn payload(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        let to_toml = |spec: &crate::scenario::PayloadSpec| Value::try_from(spec);
        let wrong = |error: toml::ser::Error| ConsoleError::usage(error.to_string());
        let present: Result<Vec<Value>, _> = self.present().robot.payload.iter().map(to_toml).collect();
        let mut list = present.map_err(wrong)?;
        if args.peek().is_none() {
            return Ok(list.iter().map(|value| format!("{value}\n")).collect());
        }
        let link = args.need("a link")?.to_owned();
        let mass = args.number("the mass")?;
        let position = if args.peek().is_some() { args.vector("the position")? } else { [0.0; 3] };
        args.done()?;
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
    pub(in crate::console) fn push(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        let link = args.need("a link")?.to_owned();
        let force = args.vector("the force")?;
        let mut values = vec![("link".to_owned(), Value::String(link)), ("force".to_owned(), vector(force))];
        let mut seconds = 0.1;
        loop {
            if args.take("for") {
                seconds = args.number("a time")?;
            } else if args.take("at") {
                values.push(("point".to_owned(), vector(args.vector("the point")?)));
            } else {
                break;
            }
        }
        values.push(("duration".to_owned(), Value::Float(seconds)));
        values.extend(args.assignments()?);
        self.add_force("push", values)
    }

    /// `force [TYPE KEY=VALUE ...]`; without arguments lists the forces.
    pub(in crate::console) fn force(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        let Some(kind) = args.next().map(str::to_owned) else {
            let forces = self.present().force.iter().enumerate();
            let lines: String = forces.map(|(i, force)| format!("{i} {}\n", force.type_name())).collect();
            return Ok(if lines.is_empty() { "no forces\n".to_owned() } else { lines });
        };
        if kind == "script" && self.simulation.has_begun() {
            let why = "a script starts with the run: it can be added only before the first step, and changed later";
            return Err(ConsoleError::usage(why));
        }
        let values = args.assignments()?;
        self.add_force(&kind, values)
    }

    fn add_force(&mut self, kind: &str, values: Vec<(String, Value)>) -> Result<String, ConsoleError> {
        let mut entry = self.entry(kind, values)?;
        if kind == "joint-friction" {
            if self.simulation.has_begun() {
                let why = "joint friction acts during the whole run: it can be added only before the first step, and changed later";
                return Err(ConsoleError::usage(why));
            }
            entry.remove("start");
        }
        let number = self.present().force.len();
        let notes = self.edit(|document| {
            document.list("force").push(Value::Table(entry));
            Ok(())
        })?;
        Ok(format!("{notes}force {number}, {kind}, from {} s\n", self.time()))
    }

    /// `store NAME`
    pub(in crate::console) fn store(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        let name = args.need("a name")?.to_owned();
        args.done()?;
        let mut event = self.event();
        event.insert("save".into(), Value::String(name.clone()));
        self.add_event(event)?;
        Ok(format!("state {name} at {} s\n", self.time()))
    }

    /// `restore NAME`
    pub(in crate::console) fn restore(&mut self, args: &mut Arguments) -> Result<String, ConsoleError> {
        let name = args.need("a name")?.to_owned();
        args.done()?;
        let mut event = self.event();
        event.insert("restore".into(), Value::String(name.clone()));
        self.add_event(event)
    }

    pub(in crate::console) fn states(&self) -> String {
        let saved = self.run.events.iter().filter_map(|event| Some((event.save.as_deref()?, event.at)));
        let lines: String = saved.map(|(name, at)| format!("{name} at {at} s\n")).collect();
        if lines.is_empty() { "no states\n".to_owned() } else { lines }
    }
}

/// Sets an initial value; list entries are addressed by index.
fn set_initial(
    document: &mut crate::console::scenario_document::ScenarioDocument,
    key: &str,
    value: Value,
) -> Result<(), ConsoleError> {
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
            _ => Err(ConsoleError::usage(format!("`{key}` does not refer to a table"))),
        };
    }
    put(&mut document.table, key, value)
}

fn joined(segments: &[String]) -> String {
    segments.iter().map(|segment| quoted(segment)).collect::<Vec<_>>().join(".")
}

/// A name as a segment of a dotted key, quoted if needed.
fn quoted(name: &str) -> String {
    let plain = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
    if plain { name.to_owned() } else { Value::String(name.to_owned()).to_string() }
}

fn vector(vector: [f64; 3]) -> Value {
    Value::Array(vector.map(Value::Float).to_vec())
}
