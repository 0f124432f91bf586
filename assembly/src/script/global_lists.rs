//! Global lists of names that a script hands over: `links`, `needs`, `points`.
//!
//! Lists and names have bounds, which are checked before anything is copied. All reads are raw, so
//! no metamethod of the script runs outside of a call with its budget.

use super::sandbox::Sandbox;
use super::script_error::ScriptError;
use mlua::{FromLua, Value};

/// Greatest length of a name that a script hands over, bytes.
pub const MAX_NAME: usize = 4096;

/// Greatest number of points that a task may show.
pub const MAX_POINTS: usize = 256;

/// A global list of at most `max` strings; nil counts as empty. `bound` says where `max` comes from.
pub(super) fn string_list(
    sandbox: &Sandbox,
    file: &str,
    list: &str,
    max: usize,
    bound: &str,
) -> Result<Vec<String>, ScriptError> {
    let error = |message: String| ScriptError::new(file, None, message);
    let shape = || error(format!("`{list}` must be a list of strings"));
    let table = match sandbox.lua.globals().raw_get::<Value>(list).map_err(|e| sandbox.error(&e))? {
        Value::Nil => return Ok(Vec::new()),
        Value::Table(table) => table,
        _ => return Err(shape()),
    };
    let length = table.raw_len();
    if length > max {
        return Err(error(format!("the list `{list}` has {length} entries, at most {max} are allowed: {bound}")));
    }
    let name = |(i, value): (usize, mlua::Result<Value>)| {
        let value = value.map_err(|e| sandbox.error(&e))?;
        if let Some(bytes) = value.as_string().map(|text| text.as_bytes().len()).filter(|bytes| *bytes > MAX_NAME) {
            let entry = i + 1;
            return Err(error(format!("`{list}[{entry}]` has {bytes} bytes, at most {MAX_NAME} are allowed")));
        }
        String::from_lua(value, &sandbox.lua).map_err(|_| shape())
    };
    table.sequence_values::<Value>().take(max).enumerate().map(name).collect()
}
