//! An isolated interpreter for each script of each run.
//!
//! A script has no access to files, network, clock and other modules, and cannot compile strings to
//! code. Memory is limited, and so is the work of one call: the interpreter counts calls and loop
//! iterations, not time, so that a run ends at the same point on every machine. Library functions
//! that process long data count by its size (`counted.luau`), and so does allocated memory.

use super::interruption;
use super::math_library;
use super::script_error::ScriptError;
use mlua::chunk::ChunkMode;
use mlua::chunk::Compiler;
use mlua::{FromLuaMulti, Function, IntoLuaMulti, Lua, LuaOptions, StdLib, VmState};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

/// Memory that a script may keep, bytes; during a call it may use twice as much, garbage included.
pub const MEMORY: usize = 64 << 20;
/// Limit on calls and loop iterations within one call of a script.
pub const BUDGET: u64 = 1_000_000;

/// Removed functions of the base library, which access other modules, compile code or depend on the
/// machine.
const REMOVED: [&str; 11] = [
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

/// Bytes processed by a library function, or allocated, that count as one call.
pub const BYTES: u64 = 512;
/// Length of text, bytes, per additional count of a pattern's step.
const LONG: u64 = 1024;

/// Work done by the current call.
#[derive(Default)]
struct Meter {
    used: AtomicU64,
    /// Units that one interrupt counts.
    weight: AtomicU64,
    /// Memory at the last interrupt, and memory left by the last garbage collection, bytes.
    memory: AtomicUsize,
    live: AtomicUsize,
    exceeded: AtomicBool,
}

impl Meter {
    fn restart(&self, memory: usize) {
        self.used.store(0, Ordering::Relaxed);
        self.weight.store(1, Ordering::Relaxed);
        self.memory.store(memory, Ordering::Relaxed);
        self.live.store(0, Ordering::Relaxed);
        self.exceeded.store(false, Ordering::Relaxed);
    }

    /// Adds to the work done; false once the budget is used up.
    fn spend(&self, units: u64) -> bool {
        self.used.fetch_add(units, Ordering::Relaxed).saturating_add(units) <= BUDGET
    }

    /// The error of a call whose budget is used up.
    fn exceed(&self, lua: &Lua, file: &str) -> mlua::Error {
        self.exceeded.store(true, Ordering::Relaxed);
        let message = format!("more than {BUDGET} calls and loop iterations in one call: is there an endless loop?");
        mlua::Error::RuntimeError(ScriptError::new(file, line_in(lua, file), message).to_string())
    }
}

/// Interpreter with its limits.
pub(super) struct Sandbox {
    pub lua: Lua,
    meter: Arc<Meter>,
    file: String,
}

pub(super) fn out_of_memory() -> String {
    format!("not enough memory: a script may use {} MiB", MEMORY >> 20)
}

impl Sandbox {
    /// An interpreter for the script called `file`, still without limits, so that trusted code can
    /// change its libraries.
    pub fn new(file: &str) -> Result<Self, ScriptError> {
        let libraries = StdLib::TABLE | StdLib::STRING | StdLib::UTF8 | StdLib::BIT | StdLib::MATH | StdLib::BUFFER;
        let sandbox = |lua| Sandbox { lua, meter: Arc::default(), file: file.to_owned() };
        let lua = Lua::new_with(libraries, LuaOptions::new()).and_then(|lua| {
            let globals = lua.globals();
            REMOVED.iter().try_for_each(|name| globals.raw_remove(*name))?;
            for (library, function) in [("math", "random"), ("math", "randomseed")] {
                globals.get::<mlua::Table>(library)?.raw_remove(function)?;
            }
            math_library::install(&lua, file)?;
            Ok(lua)
        });
        lua.map(sandbox).map_err(|e| ScriptError::read(file, &e))
    }

    /// Runs trusted code.
    pub fn prepare<R: FromLuaMulti>(&self, code: &str, arguments: impl IntoLuaMulti) -> Result<R, ScriptError> {
        let chunk = self.lua.load(code).set_name("=prelude").set_mode(ChunkMode::Text);
        chunk.call(arguments).map_err(|e| self.error(&e))
    }

    /// Makes the libraries read-only and sets the limits.
    pub fn close(&self) -> Result<(), ScriptError> {
        self.count().map_err(|e| self.error(&e))?;
        let (meter, file, interruption) = (self.meter.clone(), self.file.clone(), interruption::current());
        let sandboxed = self.lua.sandbox(true).and_then(|()| self.lua.set_memory_limit(2 * MEMORY));
        sandboxed.map_err(|e| self.error(&e))?;
        self.lua.set_interrupt(move |lua| {
            if let Some(reason) = interruption.reason() {
                return Err(mlua::Error::RuntimeError(reason));
            }
            let mut memory = lua.used_memory();
            if memory > MEMORY && memory > meter.live.load(Ordering::Relaxed) / 2 * 3 {
                // Some library functions produce garbage faster than it is collected by default.
                lua.gc_collect()?;
                memory = lua.used_memory();
                meter.live.store(memory, Ordering::Relaxed);
            }
            let allocated = memory.saturating_sub(meter.memory.swap(memory, Ordering::Relaxed)) as u64;
            if meter.spend(meter.weight.load(Ordering::Relaxed) + allocated / BYTES) {
                return Ok(VmState::Continue);
            }
            Err(meter.exceed(lua, &file))
        });
        Ok(())
    }

    /// Makes library functions count their work.
    fn count(&self) -> mlua::Result<()> {
        let (meter, file) = (self.meter.clone(), self.file.clone());
        // Sizes come from the script and can be any number.
        let charge = self.lua.create_function(move |lua, bytes: f64| {
            if meter.spend((bytes / BYTES as f64) as u64) { Ok(()) } else { Err(meter.exceed(lua, &file)) }
        })?;
        let meter = self.meter.clone();
        let weigh = self.lua.create_function(move |_, bytes: f64| {
            meter.weight.store(1 + bytes as u64 / LONG, Ordering::Relaxed);
            Ok(())
        })?;
        let chunk = self.lua.load(include_str!("counted.luau")).set_name("=prelude").set_mode(ChunkMode::Text);
        let tonumber: Function = chunk.call((charge, weigh))?;
        self.lua.globals().set("tonumber", tonumber)
    }

    /// Runs the top level of the script.
    pub fn load(&self, text: &str) -> Result<(), ScriptError> {
        let chunk = self.lua.load(text).set_name(format!("={}", self.file)).set_mode(ChunkMode::Text);
        // Otherwise the compiler inlines these functions: their work is not counted, or their values
        // depend on the system.
        let compiler = Compiler::new().set_mutable_globals(["string", "tonumber"]);
        let compiler = compiler.set_disabled_builtins(math_library::replaced());
        let function = chunk.set_compiler(compiler).into_function().map_err(|e| self.error(&e))?;
        self.call(&function, ())
    }

    /// Calls a function of the script within its budget.
    pub fn call<R: FromLuaMulti>(&self, function: &Function, arguments: impl IntoLuaMulti) -> Result<R, ScriptError> {
        // Garbage does not count against the limit.
        if self.lua.used_memory() > MEMORY / 2 {
            self.collect()?;
        }
        self.meter.restart(self.lua.used_memory());
        let result = function.call(arguments).map_err(|e| self.error(&e));
        if self.lua.used_memory() > MEMORY {
            self.collect()?;
            if result.is_ok() && self.lua.used_memory() > MEMORY {
                return Err(ScriptError::new(&self.file, function.info().line_defined, out_of_memory()));
            }
        }
        // A script that has caught the error still fails.
        match result {
            Ok(_) if self.meter.exceeded.load(Ordering::Relaxed) => {
                let message = format!("more than {BUDGET} calls and loop iterations in one call");
                Err(ScriptError::new(&self.file, function.info().line_defined, message))
            }
            result => result,
        }
    }

    fn collect(&self) -> Result<(), ScriptError> {
        // The first cycle may have begun before this call.
        self.lua.gc_collect().and_then(|()| self.lua.gc_collect()).map_err(|e| self.error(&e))
    }

    pub fn error(&self, error: &mlua::Error) -> ScriptError {
        ScriptError::read(&self.file, error)
    }
}

/// The line of the script that is running.
pub(super) fn line_in(lua: &Lua, file: &str) -> Option<usize> {
    let line = |level| {
        let of_script = |d: &mlua::debug::Debug| {
            let source = d.source();
            (source.short_src.as_deref() == Some(file)).then(|| d.current_line()).flatten()
        };
        lua.inspect_stack(level, of_script)
    };
    (0..64).map_while(line).flatten().next()
}
