//! An interpreter of its own for each script of each run, from which nothing of the machine can be reached.
//!
//! There are no files, no network, no clock, no other modules and no code made from strings. Memory is limited, and so
//! is what one call may do: the interpreter asks at every call and every turn of a loop whether to go on, and what is
//! counted is these questions, not time, so that a run ends at the same place everywhere.

use super::error::ScriptError;
use mlua::chunk::ChunkMode;
use mlua::{FromLuaMulti, Function, IntoLuaMulti, Lua, LuaOptions, StdLib, VmState};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Memory of one script, bytes.
pub const MEMORY: usize = 64 << 20;
/// Calls and turns of loops within one call of a script.
pub const BUDGET: u64 = 1_000_000;

/// Functions of the base library that lead outside, make code or depend on the machine.
const CLOSED: [&str; 11] = [
    "require",
    "loadstring",
    "load",
    "dofile",
    "loadfile",
    "getfenv",
    "setfenv",
    "collectgarbage",
    "gcinfo",
    "newproxy",
    "print",
];

/// How much the call going on has used.
#[derive(Default)]
struct Meter {
    used: AtomicU64,
    exceeded: AtomicBool,
}

/// See the module.
pub(super) struct Sandbox {
    pub lua: Lua,
    meter: Arc<Meter>,
    file: String,
}

pub(super) fn out_of_memory() -> String {
    format!("not enough memory: a script may use {} MiB", MEMORY >> 20)
}

impl Sandbox {
    /// An interpreter for the script called `file`, still without limits, libraries open to trusted code.
    pub fn new(file: &str) -> Result<Self, ScriptError> {
        let libraries = StdLib::TABLE | StdLib::STRING | StdLib::UTF8 | StdLib::BIT | StdLib::MATH | StdLib::BUFFER;
        let sandbox = |lua| Sandbox { lua, meter: Arc::default(), file: file.to_owned() };
        let made = Lua::new_with(libraries, LuaOptions::new()).and_then(|lua| {
            let globals = lua.globals();
            CLOSED.iter().try_for_each(|name| globals.raw_remove(*name))?;
            for (library, function) in [("math", "random"), ("math", "randomseed")] {
                globals.get::<mlua::Table>(library)?.raw_remove(function)?;
            }
            Ok(lua)
        });
        made.map(sandbox).map_err(|e| ScriptError::read(file, &e))
    }

    /// Runs trusted code.
    pub fn prepare<R: FromLuaMulti>(&self, code: &str, arguments: impl IntoLuaMulti) -> Result<R, ScriptError> {
        let chunk = self.lua.load(code).set_name("=prelude").set_mode(ChunkMode::Text);
        chunk.call(arguments).map_err(|e| self.error(&e))
    }

    /// Closes the libraries to changes and sets the limits.
    pub fn close(&self) -> Result<(), ScriptError> {
        let (meter, file) = (self.meter.clone(), self.file.clone());
        let closed = self.lua.sandbox(true).and_then(|()| self.lua.set_memory_limit(MEMORY));
        closed.map_err(|e| self.error(&e))?;
        self.lua.set_interrupt(move |lua| {
            if meter.used.fetch_add(1, Ordering::Relaxed) < BUDGET {
                return Ok(VmState::Continue);
            }
            meter.exceeded.store(true, Ordering::Relaxed);
            let message = format!("more than {BUDGET} calls and turns of loops in one call: does it ever end?");
            Err(mlua::Error::RuntimeError(ScriptError::new(&file, line_in(lua, &file), message).to_string()))
        });
        Ok(())
    }

    /// Runs the script's own text.
    pub fn load(&self, text: &str) -> Result<(), ScriptError> {
        let chunk = self.lua.load(text).set_name(format!("={}", self.file)).set_mode(ChunkMode::Text);
        let function = chunk.into_function().map_err(|e| self.error(&e))?;
        self.call(&function, ())
    }

    /// Calls a function of the script within its budget.
    pub fn call<R: FromLuaMulti>(&self, function: &Function, arguments: impl IntoLuaMulti) -> Result<R, ScriptError> {
        self.meter.used.store(0, Ordering::Relaxed);
        self.meter.exceeded.store(false, Ordering::Relaxed);
        let result = function.call(arguments).map_err(|e| self.error(&e));
        // The script may have caught the interruption: that does not help it.
        match result {
            Ok(_) if self.meter.exceeded.load(Ordering::Relaxed) => {
                let message = format!("more than {BUDGET} calls and turns of loops in one call");
                Err(ScriptError::new(&self.file, function.info().line_defined, message))
            }
            result => result,
        }
    }

    pub fn error(&self, error: &mlua::Error) -> ScriptError {
        ScriptError::read(&self.file, error)
    }
}

/// The line of the script that is being run.
fn line_in(lua: &Lua, file: &str) -> Option<usize> {
    let line = |level| {
        let of_script = |d: &mlua::debug::Debug| {
            let source = d.source();
            (source.short_src.as_deref() == Some(file)).then(|| d.current_line()).flatten()
        };
        lua.inspect_stack(level, of_script)
    };
    (0..64).map_while(line).flatten().next()
}
