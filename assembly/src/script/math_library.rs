//! Functions of a script's table `math` that are those of [`math`](crate::math) instead of the
//! system's. Luau's compiler must not inline its own: it receives their names.

use super::sandbox::line_in;
use super::script_error::ScriptError;
use crate::math;
use mlua::{Either, Function, Lua, Value};

type Unary = fn(f64) -> f64;
type Binary = fn(f64, f64) -> f64;

const UNARY: [(&str, Unary); 11] = [
    ("acos", math::acos),
    ("asin", math::asin),
    ("atan", math::atan),
    ("cos", math::cos),
    ("cosh", math::cosh),
    ("exp", math::exp),
    ("log10", math::log10),
    ("sin", math::sin),
    ("sinh", math::sinh),
    ("tan", math::tan),
    ("tanh", math::tanh),
];

const BINARY: [(&str, Binary); 2] = [("atan2", math::atan2), ("pow", math::powf)];

/// An argument: a number, or text that reads as one.
type Number = Either<f64, Value>;

/// Names of the replaced functions, with their library.
pub(super) fn replaced() -> impl Iterator<Item = String> {
    let unary = UNARY.iter().map(|(name, _)| *name);
    unary.chain(BINARY.iter().map(|(name, _)| *name)).chain(["log"]).map(|name| format!("math.{name}"))
}

/// Replaces the functions, for the script `file`.
pub(super) fn install(lua: &Lua, file: &str) -> mlua::Result<()> {
    let library: mlua::Table = lua.globals().get("math")?;
    for (name, function) in UNARY {
        library.raw_set(name, unary(lua, file, name, function)?)?;
    }
    for (name, function) in BINARY {
        library.raw_set(name, binary(lua, file, name, function)?)?;
    }
    library.raw_set("log", logarithm(lua, file)?)
}

fn unary(lua: &Lua, file: &str, name: &'static str, function: Unary) -> mlua::Result<Function> {
    let file = file.to_owned();
    lua.create_function(move |lua, x: Number| Ok(function(number(lua, &file, name, 1, x)?)))
}

fn binary(lua: &Lua, file: &str, name: &'static str, function: Binary) -> mlua::Result<Function> {
    let file = file.to_owned();
    lua.create_function(move |lua, (x, y): (Number, Number)| {
        Ok(function(number(lua, &file, name, 1, x)?, number(lua, &file, name, 2, y)?))
    })
}

/// `math.log(x, base)`; without a base the natural logarithm.
fn logarithm(lua: &Lua, file: &str) -> mlua::Result<Function> {
    let file = file.to_owned();
    lua.create_function(move |lua, (x, base): (Number, Number)| {
        let x = number(lua, &file, "log", 1, x)?;
        if matches!(base, Either::Right(Value::Nil)) {
            return Ok(math::ln(x));
        }
        Ok(match number(lua, &file, "log", 2, base)? {
            2.0 => math::log2(x),
            10.0 => math::log10(x),
            base => math::ln(x) / math::ln(base),
        })
    })
}

/// The argument at `position` of the function `name`; otherwise Luau's message.
fn number(lua: &Lua, file: &str, name: &str, position: usize, argument: Number) -> mlua::Result<f64> {
    match argument {
        Either::Left(x) => Ok(x),
        Either::Right(other) => {
            let found = other.type_name();
            let message = format!("invalid argument #{position} to '{name}' (number expected, got {found})");
            Err(mlua::Error::RuntimeError(ScriptError::new(file, line_in(lua, file), message).to_string()))
        }
    }
}
