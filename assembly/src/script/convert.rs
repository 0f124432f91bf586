//! Conversion of values to and from scripts.

use super::Params;
use crate::robot::{LinkId, Model};
use mlua::{Lua, Table, Value};
use nalgebra::{Isometry3, Point3, Vector3};
use std::collections::HashMap;

/// Greatest number of forces that one call may return.
pub const MAX_FORCES: usize = 4096;

/// Bytes of a script's string that an error message shows.
const SHOWN: usize = 200;

/// A force or effort returned by a force model.
#[derive(Clone, Debug, PartialEq)]
pub enum ForceEntry {
    /// A force (N) at a point in the link's internal frame (m) and a moment (N m).
    Wrench {
        /// The link.
        link: LinkId,
        /// Point of action.
        point: Vector3<f64>,
        /// Force in world axes, or in those of `axes`.
        force: Vector3<f64>,
        /// Moment in the same axes.
        moment: Vector3<f64>,
        /// Orientation of the axes in the link's internal frame; none for world axes.
        axes: Option<nalgebra::UnitQuaternion<f64>>,
    },
    /// An effort (N m or N) on a joint.
    Joint {
        /// Index of the joint.
        joint: usize,
        /// The effort.
        effort: f64,
    },
}

/// Joints and links of a robot by name.
#[derive(Clone, Debug)]
pub struct RobotNames {
    joints: HashMap<String, usize>,
    links: HashMap<String, (LinkId, Isometry3<f64>)>,
}

impl RobotNames {
    /// The names of a robot.
    pub fn new(model: &Model) -> Self {
        RobotNames {
            joints: model.joints.iter().enumerate().map(|(i, j)| (j.name.clone(), i)).collect(),
            links: super::links(model).map(|(name, link, frame)| (name.to_owned(), (link, frame))).collect(),
        }
    }

    fn joint(&self, value: &Value) -> Option<usize> {
        match value {
            Value::String(name) => self.joints.get(&*name.to_str().ok()?).copied(),
            _ => {
                let number = number(value)?;
                let whole = number.fract() == 0.0 && number >= 1.0 && number <= self.joints.len() as f64;
                whole.then(|| number as usize - 1)
            }
        }
    }
}

/// A table of a scenario as a Luau table; dates become strings.
pub(super) fn params(lua: &Lua, params: &Params) -> mlua::Result<Table> {
    let table = lua.create_table()?;
    for (key, value) in params {
        table.set(key.as_str(), plain(lua, value)?)?;
    }
    Ok(table)
}

fn plain(lua: &Lua, value: &toml::Value) -> mlua::Result<Value> {
    Ok(match value {
        toml::Value::String(text) => Value::String(lua.create_string(text)?),
        toml::Value::Integer(n) => Value::Number(*n as f64),
        toml::Value::Float(x) => Value::Number(*x),
        toml::Value::Boolean(yes) => Value::Boolean(*yes),
        toml::Value::Datetime(date) => Value::String(lua.create_string(date.to_string())?),
        toml::Value::Array(items) => {
            let table = lua.create_table()?;
            for item in items {
                table.push(plain(lua, item)?)?;
            }
            Value::Table(table)
        }
        toml::Value::Table(entries) => Value::Table(params(lua, entries)?),
    })
}

/// A value as shown in error messages.
pub(super) fn describe(value: &Value) -> String {
    match value {
        Value::String(text) => quoted(text),
        Value::Number(x) => x.to_string(),
        Value::Integer(n) => n.to_string(),
        Value::Boolean(yes) => yes.to_string(),
        Value::Nil => "nil".into(),
        other => format!("a {}", other.type_name()),
    }
}

/// A string in quotes, cut if it is long.
fn quoted(text: &mlua::LuaString) -> String {
    let bytes = text.as_bytes();
    match bytes.get(..SHOWN) {
        Some(begin) if bytes.len() > SHOWN => {
            format!("{:?}... ({} bytes)", String::from_utf8_lossy(begin), bytes.len())
        }
        _ => format!("{:?}", String::from_utf8_lossy(&bytes)),
    }
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Number(x) => Some(*x),
        Value::Integer(n) => Some(*n as f64),
        _ => None,
    }
}

/// Why the value that a force model returned is not a list of forces.
#[derive(Debug, thiserror::Error)]
pub(super) enum ReturnError {
    #[error("`run` must return a list of forces, not {0}")]
    NotAList(String),
    #[error("`run` must return a list of forces: {{ {{ link = .., force = .. }} }}")]
    NoEntries,
    #[error("`run` returned {0} forces, at most {MAX_FORCES} are allowed")]
    TooMany(usize),
    #[error("force {0} must be a table, not {1}")]
    NotATable(usize, String),
    #[error("force {0}: {1}")]
    Entry(usize, EntryError),
    #[error(transparent)]
    Lua(#[from] mlua::Error),
}

/// Why an entry of that list is not a force.
#[derive(Debug, thiserror::Error)]
pub(super) enum EntryError {
    #[error("unknown key {0}; known here: {known}", known = KEYS.join(", "))]
    UnknownKey(String),
    #[error("the robot has no joint {0}")]
    UnknownJoint(String),
    #[error("the robot has no link {0}")]
    UnknownLink(String),
    #[error("needs `link`, the name of a link, or `joint`; `link` is {0}")]
    LinkMissing(String),
    #[error("`frame` must be \"world\" or \"link\", not {0}")]
    Frame(String),
    #[error("`{0}` must be a finite number, not {1}")]
    NotFinite(String, String),
    #[error("`{0}` must be {{ x, y, z }}, three finite numbers, not {1}")]
    NotAVector(&'static str, String),
    #[error(transparent)]
    Lua(#[from] mlua::Error),
}

/// Appends the forces of the list that a force model returned.
pub(super) fn read_forces(value: Value, names: &RobotNames, forces: &mut Vec<ForceEntry>) -> Result<(), ReturnError> {
    let list = match &value {
        Value::Nil => return Ok(()),
        Value::Table(list) => list,
        other => return Err(ReturnError::NotAList(describe(other))),
    };
    let length = list.raw_len();
    if length > MAX_FORCES {
        return Err(ReturnError::TooMany(length));
    }
    for (i, entry) in list.sequence_values::<Value>().take(MAX_FORCES).enumerate() {
        match entry? {
            Value::Table(entry) => {
                forces.push(read_force(&entry, names).map_err(|e| ReturnError::Entry(i + 1, e))?);
            }
            other => return Err(ReturnError::NotATable(i + 1, describe(&other))),
        }
    }
    // A table of keys alone is one force that is not in a list.
    if forces.is_empty() && !list.is_empty() {
        return Err(ReturnError::NoEntries);
    }
    Ok(())
}

const KEYS: [&str; 7] = ["link", "point", "force", "moment", "frame", "joint", "effort"];

fn read_force(entry: &Table, names: &RobotNames) -> Result<ForceEntry, EntryError> {
    for pair in entry.pairs::<Value, Value>() {
        let (key, _) = pair?;
        let known = key.as_string().is_some_and(|k| KEYS.iter().any(|known| known.as_bytes() == &*k.as_bytes()));
        if !known {
            return Err(EntryError::UnknownKey(describe(&key)));
        }
    }
    let get = |key: &str| entry.raw_get::<Value>(key);
    let joint = get("joint")?;
    if !joint.is_nil() {
        let index = names.joint(&joint).ok_or_else(|| EntryError::UnknownJoint(describe(&joint)))?;
        let effort = get("effort")?;
        let value = number(&effort).filter(|x| x.is_finite());
        let effort = value.ok_or_else(|| EntryError::NotFinite("effort".into(), describe(&effort)))?;
        return Ok(ForceEntry::Joint { joint: index, effort });
    }
    let link = get("link")?;
    let name = link.as_string().ok_or_else(|| EntryError::LinkMissing(describe(&link)))?;
    let found = name.to_str().ok().and_then(|name| names.links.get(&*name));
    let (id, frame) = found.ok_or_else(|| EntryError::UnknownLink(quoted(name)))?;
    let in_link_axes = match get("frame")? {
        Value::Nil => false,
        Value::String(word) if word.as_bytes() == b"world" => false,
        Value::String(word) if word.as_bytes() == b"link" => true,
        other => return Err(EntryError::Frame(describe(&other))),
    };
    Ok(ForceEntry::Wrench {
        link: *id,
        point: (frame * Point3::from(vector("point", &get("point")?)?)).coords,
        force: vector("force", &get("force")?)?,
        moment: vector("moment", &get("moment")?)?,
        axes: in_link_axes.then_some(frame.rotation),
    })
}

/// Three finite numbers; nil is zero.
fn vector(key: &'static str, value: &Value) -> Result<Vector3<f64>, EntryError> {
    let list = match value {
        Value::Nil => return Ok(Vector3::zeros()),
        Value::Table(list) if list.raw_len() == 3 => list,
        Value::Table(list) => {
            return Err(EntryError::NotAVector(key, format!("{} of {}", describe(value), list.raw_len())));
        }
        _ => return Err(EntryError::NotAVector(key, describe(value))),
    };
    let mut v = Vector3::zeros();
    for i in 0..3 {
        let entry: Value = list.raw_get(i + 1)?;
        let finite = number(&entry).filter(|x| x.is_finite());
        v[i] = finite.ok_or_else(|| EntryError::NotFinite(format!("{key}[{}]", i + 1), describe(&entry)))?;
    }
    Ok(v)
}
