//! Runs tasks and force models that are written in Luau.
//!
//! Each script of each run has its own interpreter (`sandbox`). Before a call, the numbers that the
//! script reads ([`fields`]) are written to a buffer, which `prelude.luau` unpacks into the table
//! `robot`. Joint commands return through another buffer. Every failure is a [`ScriptError`] with
//! file, line and message. [`script_task`] and [`script_force`] implement the traits of tasks and
//! force models.
//!
//! Imports: `math`, `text`, `random`, `robot`, `dynamics`, `task`, `force`. Used by: `assemble`,
//! `batch`, `console`.

mod convert;
pub mod fields;
mod global_lists;
mod interruption;
mod math_library;
mod sandbox;
mod script_error;
pub mod script_force;
pub mod script_task;

pub use convert::{ForceEntry, MAX_FORCES, RobotNames};
pub use global_lists::{MAX_NAME, MAX_POINTS};
pub use interruption::flag as interruption_flag;
pub use interruption::{interruptible, time_limited};
pub use sandbox::{BUDGET, BYTES, MEMORY};
pub use script_error::ScriptError;

use crate::random::Stream;
use crate::robot::{DriveMode, LinkId, Model};
use crate::task::{Command, Needs, PointOfInterest};
use fields::{Field, PARTS, Shape, TaskView, View};
use global_lists::string_list;
use mlua::{Buffer, Function, Table, Value};
use nalgebra::{Isometry3, Vector3};
use sandbox::Sandbox;
use std::collections::HashSet;
use std::sync::Mutex;

/// Names of the drive modes; their indices are the numbers in the buffer.
const MODES: [(&str, DriveMode); 5] = [
    ("position", DriveMode::Position),
    ("velocity", DriveMode::Velocity),
    ("force", DriveMode::Force),
    ("kinematic", DriveMode::Kinematic),
    ("passive", DriveMode::Passive),
];

/// Greatest number of tables in the globals of a force, which are all made read-only.
pub const MAX_TABLES: usize = 100_000;

/// Values given to a script by the scenario.
pub type Params = toml::Table;

/// Kind of a script.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Purpose {
    /// It commands joints.
    Task,
    /// It returns forces.
    Force,
}

/// A loaded script, ready to be called.
pub struct Script {
    sandbox: Sandbox,
    file: String,
    purpose: Purpose,
    fields: Vec<Field>,
    numbers: Vec<f64>,
    bytes: Vec<u8>,
    input: Buffer,
    output: Buffer,
    shown: Buffer,
    points: Vec<PointOfInterest>,
    robot: Table,
    refill: Function,
    allow: Function,
    init: Option<Function>,
    run: Function,
    change: Option<Function>,
    needs: Needs,
    /// Tables that `refill` alone writes.
    filled: Vec<Table>,
    /// Tables that are read-only between corners.
    locked: Vec<Table>,
}

/// Stage of a call, which decides what the script may do.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Stage {
    Prepare,
    Run,
}

impl Script {
    /// Loads a script called `file` and runs its top level once.
    ///
    /// # Errors
    /// The script has an error, lacks `run`, or lists unknown parts or links.
    pub fn load(file: &str, text: &str, purpose: Purpose, model: &Model, stream: Stream) -> Result<Self, ScriptError> {
        let sandbox = Sandbox::new(file)?;
        let to_error = |e: mlua::Error| ScriptError::read(file, &e);
        let stream = Mutex::new(stream);
        let draw = move |_: &mlua::Lua, ()| Ok(stream.lock().map_or(f64::NAN, |mut s| s.unit()));
        let draw = sandbox.lua.create_function(draw).map_err(to_error)?;
        let joints: Vec<&str> = model.joints.iter().map(|j| j.name.as_str()).collect();
        let modes = MODES.map(|(name, _)| name);
        let exports: Table = sandbox.prepare(include_str!("prelude.luau"), (draw, joints, modes.to_vec()))?;
        let random = exports.get::<Function>("random").and_then(|f| sandbox.lua.globals().set("random", f));
        random.map_err(to_error)?;
        sandbox.close()?;
        sandbox.load(text)?;
        let (needs, fields) = requested_data(&sandbox, file, purpose, model)?;
        let numbers = fields.iter().map(|f| f.shape.size()).sum();
        let input = sandbox.lua.create_buffer(vec![0; 8 * numbers]).map_err(to_error)?;
        let output = sandbox.lua.create_buffer(vec![0; 8 * 6 * model.nj()]).map_err(to_error)?;
        let points = points(&sandbox, file, purpose)?;
        let shown = sandbox.lua.create_buffer(vec![0; 8 * 4 * points.len()]).map_err(to_error)?;
        let layout = layout(&sandbox, &fields, (&input, &output), purpose).map_err(to_error)?;
        let names: Vec<&str> = points.iter().map(|point| point.name.as_str()).collect();
        layout.set("points", names).and_then(|()| layout.set("shown", &shown)).map_err(to_error)?;
        sandbox.call::<()>(&exports.get("build").map_err(to_error)?, layout)?;
        let globals = sandbox.lua.globals();
        let function = |name: &str| match globals.raw_get::<Value>(name).map_err(to_error)? {
            Value::Function(f) => Ok(Some(f)),
            Value::Nil => Ok(None),
            other => Err(ScriptError::new(
                file,
                None,
                format!("`{name}` must be a function, not {}", convert::describe(&other)),
            )),
        };
        let run = function("run")?.ok_or_else(|| ScriptError::new(file, None, "there is no function `run`"))?;
        let filled = lock_robot(&exports).map_err(to_error)?;
        let mut script = Script {
            init: function("init")?,
            change: function("change")?,
            run,
            robot: exports.get("robot").map_err(to_error)?,
            refill: exports.get("refill").map_err(to_error)?,
            allow: exports.get("allow").map_err(to_error)?,
            file: file.to_owned(),
            numbers: vec![0.0; numbers],
            bytes: vec![0; 8 * numbers.max(6 * model.nj())],
            purpose,
            sandbox,
            fields,
            input,
            output,
            shown,
            points,
            needs,
            filled,
            locked: Vec::new(),
        };
        script.lock_globals()?;
        Ok(script)
    }

    /// The parts of the augmented data it reads.
    pub fn needs(&self) -> Needs {
        self.needs
    }

    /// The points of interest of its list `points`.
    pub fn points(&self) -> &[PointOfInterest] {
        &self.points
    }

    /// True if it has a function `change`.
    pub fn can_change(&self) -> bool {
        self.change.is_some()
    }

    /// Calls `init`, if there is one. True: the script continues.
    pub fn init(&mut self, view: &View, params: &Params) -> Result<bool, ScriptError> {
        let function = self.init.clone();
        self.prepare(view, function, params)
    }

    /// Calls `change`, if there is one. True: the script continues.
    pub fn change(&mut self, view: &View, params: &Params) -> Result<bool, ScriptError> {
        let function = self.change.clone();
        self.prepare(view, function, params)
    }

    fn prepare(&mut self, view: &View, function: Option<Function>, params: &Params) -> Result<bool, ScriptError> {
        let Some(function) = function else { return Ok(true) };
        self.update_robot(view, Stage::Prepare)?;
        self.locked.drain(..).for_each(|table| table.set_readonly(false));
        let params = convert::params(&self.sandbox.lua, params).map_err(|e| self.sandbox.error(&e))?;
        let result: Value = self.sandbox.call(&function, (self.robot.clone(), params))?;
        self.lock_globals()?;
        self.should_continue(&function, result)
    }

    /// Calls `run` of a task, which may change `command`. True: the script continues.
    pub fn run_task(&mut self, view: &View, command: &mut Command) -> Result<bool, ScriptError> {
        self.update_robot(view, Stage::Run)?;
        let result: Value = self.sandbox.call(&self.run, self.robot.clone())?;
        self.read_command(command);
        self.read_points();
        self.should_continue(&self.run, result)
    }

    /// Calls `run` of a force model and replaces `forces` by the forces that it returns.
    pub fn run_force(
        &mut self,
        view: &View,
        names: &RobotNames,
        forces: &mut Vec<ForceEntry>,
    ) -> Result<(), ScriptError> {
        forces.clear();
        self.update_robot(view, Stage::Run)?;
        let result: Value = self.sandbox.call(&self.run, self.robot.clone())?;
        convert::read_forces(result, names, forces).map_err(|e| self.return_error(&self.run, e.to_string()))
    }

    /// An error in the return value of a function, at the function's first line.
    fn return_error(&self, function: &Function, message: String) -> ScriptError {
        ScriptError::new(&self.file, function.info().line_defined, message)
    }

    fn should_continue(&self, function: &Function, result: Value) -> Result<bool, ScriptError> {
        match &result {
            Value::Nil | Value::Boolean(true) => Ok(true),
            Value::Boolean(false) => Ok(false),
            Value::String(text) if text.as_bytes() == b"done" => Ok(false),
            other => {
                let message = format!(
                    "it must return nothing or true to continue, \"done\" or false to end, not {}",
                    convert::describe(other)
                );
                Err(self.return_error(function, message))
            }
        }
    }

    /// Forces are functions of time and state: between corners globals and all tables in them are
    /// read-only.
    fn lock_globals(&mut self) -> Result<(), ScriptError> {
        if self.purpose == Purpose::Force {
            let tables = reachable_tables([self.sandbox.lua.globals()], MAX_TABLES);
            self.locked = tables.ok_or_else(|| {
                let message =
                    format!("its globals hold more than {MAX_TABLES} tables, the greatest number for a force");
                ScriptError::new(&self.file, None, message)
            })?;
            self.locked.retain(|table| !table.is_readonly());
            self.locked.iter().for_each(|table| table.set_readonly(true));
        }
        Ok(())
    }

    /// Updates the table `robot`.
    fn update_robot(&mut self, view: &View, stage: Stage) -> Result<(), ScriptError> {
        let mut rest = &mut self.numbers[..];
        for field in &self.fields {
            let (own, others) = rest.split_at_mut(field.shape.size());
            (field.read)(view, own);
            rest = others;
        }
        pack(self.numbers.iter().copied(), &mut self.bytes);
        self.input.write_bytes(0, &self.bytes[..8 * self.numbers.len()]);
        if let Some(TaskView { command, .. }) = &view.task {
            self.write_command(command);
        }
        let draws = stage == Stage::Prepare || self.purpose == Purpose::Task;
        let drives = stage == Stage::Run && self.purpose == Purpose::Task;
        self.sandbox.call::<()>(&self.allow, (draws, drives))?;
        self.filled.iter().for_each(|table| table.set_readonly(false));
        self.sandbox.call::<()>(&self.refill, ())?;
        self.filled.iter().for_each(|table| table.set_readonly(true));
        Ok(())
    }

    /// Writes the joint commands to the buffer, row after row.
    fn write_command(&mut self, c: &Command) {
        let mode = |m: &DriveMode| MODES.iter().position(|(_, mode)| mode == m).unwrap_or(0) as f64;
        let rows = [&c.position, &c.velocity, &c.effort, &c.kp, &c.kd].into_iter().flatten().copied();
        let all = rows.chain(c.mode.iter().map(mode));
        let n = 6 * c.position.len();
        pack(all, &mut self.bytes);
        self.output.write_bytes(0, &self.bytes[..8 * n]);
    }

    fn read_command(&self, c: &mut Command) {
        let n = c.position.len();
        let at = |row: usize, i: usize| f64::from_le_bytes(self.output.read_bytes(8 * (row * n + i)));
        for i in 0..n {
            (c.position[i], c.velocity[i], c.effort[i]) = (at(0, i), at(1, i), at(2, i));
            (c.kp[i], c.kd[i], c.mode[i]) = (at(3, i), at(4, i), MODES[at(5, i) as usize].1);
        }
    }

    /// Reads the points: four numbers each, the first of them 1 while the point is shown.
    fn read_points(&mut self) {
        for (k, point) in self.points.iter_mut().enumerate() {
            let at = |i: usize| f64::from_le_bytes(self.shown.read_bytes(8 * (4 * k + i)));
            point.position = (at(0) == 1.0).then(|| Vector3::new(at(1), at(2), at(3)));
        }
    }
}

/// The points of a task's list `points`; none is shown yet.
fn points(sandbox: &Sandbox, file: &str, purpose: Purpose) -> Result<Vec<PointOfInterest>, ScriptError> {
    let names = string_list(sandbox, file, "points", MAX_POINTS, "the greatest number of points")?;
    if purpose == Purpose::Force && !names.is_empty() {
        return Err(ScriptError::new(file, None, "a force cannot have `points`: only tasks show points"));
    }
    if let Some(i) = (1..names.len()).find(|&i| names[..i].contains(&names[i])) {
        return Err(ScriptError::new(file, None, format!("`points` names \"{}\" twice", names[i])));
    }
    Ok(names.into_iter().map(|name| PointOfInterest { name, position: None }).collect())
}

/// The requested parts of the augmented data and the fields that a script reads: the fields of
/// every script, and those of its lists `needs` and `links`.
fn requested_data(
    sandbox: &Sandbox,
    file: &str,
    purpose: Purpose,
    model: &Model,
) -> Result<(Needs, Vec<Field>), ScriptError> {
    let to_error = |message: String| ScriptError::new(file, None, message);
    let task = purpose == Purpose::Task;
    let parts = || PARTS.iter().filter(|(name, _)| task || *name == "com");
    let mut needs = Needs::NONE;
    for need in string_list(sandbox, file, "needs", PARTS.len(), "the number of parts")? {
        let Some((_, part)) = parts().find(|(name, _)| *name == need) else {
            let help = crate::text::suggest(&need, parts().map(|(name, _)| *name).collect::<Vec<_>>());
            return Err(to_error(format!("`needs` has no part \"{need}\"; {help}")));
        };
        needs |= *part;
    }
    let mut fields = fields::common_fields(model);
    if task {
        fields.extend(fields::sensor_fields(model));
        fields.extend(fields::task_fields(model, needs));
    } else if needs.contains(Needs::COM) {
        fields.extend(fields::com_fields());
    }
    for name in string_list(sandbox, file, "links", links(model).count(), "the number of the robot's links")? {
        let Some((link, frame)) = model.link(&name) else {
            let help = crate::text::suggest(&name, links(model).map(|(name, ..)| name).collect::<Vec<_>>());
            return Err(to_error(format!("`links`: the robot `{}` has no link \"{name}\"; {help}", model.name)));
        };
        fields.extend(fields::link_fields(&name, link, frame));
        needs |= Needs::LINKS;
    }
    Ok((needs, fields))
}

/// All tables reachable from `roots`, the roots included; none if there are more than `max`. A
/// table that is reached twice takes no more memory.
fn reachable_tables(roots: impl IntoIterator<Item = Table>, max: usize) -> Option<Vec<Table>> {
    let (mut found, mut known) = (Vec::new(), HashSet::new());
    let mut pending: Vec<Table> = roots.into_iter().filter(|table| known.insert(table.to_pointer())).collect();
    while let Some(table) = pending.pop() {
        for (key, value) in table.pairs::<Value, Value>().flatten() {
            for entry in [key, value] {
                pending.extend(entry.as_table().filter(|table| known.insert(table.to_pointer())).cloned());
            }
            if known.len() > max {
                return None;
            }
        }
        found.push(table);
    }
    Some(found)
}

/// Makes the table `robot` read-only to the script; returns the tables to unlock for an update. The
/// lists of desired values stay writable for the functions that command joints.
fn lock_robot(exports: &Table) -> mlua::Result<Vec<Table>> {
    let robot: Table = exports.get("robot")?;
    let desired: Option<Table> = robot.get("desired")?;
    let lists = desired.iter().flat_map(|d| d.pairs::<Value, Table>().flatten());
    let writable: HashSet<_> = lists.map(|(_, list)| list.to_pointer()).collect();
    let is_locked = |table: &Table| !writable.contains(&table.to_pointer());
    let filled: Table = exports.get("filled")?;
    let mut filled: Vec<Table> = filled.sequence_values().collect::<mlua::Result<_>>()?;
    let rows: Table = exports.get("rows")?;
    filled.retain(is_locked);
    filled.sort_by_key(Table::to_pointer);
    filled.dedup_by_key(|table| table.to_pointer());
    // The prelude made these tables, so their number follows from the robot.
    let tables = reachable_tables([robot, rows], usize::MAX).unwrap_or_default();
    tables.iter().filter(|t| is_locked(t)).for_each(|table| table.set_readonly(true));
    Ok(filled)
}

fn pack(numbers: impl Iterator<Item = f64>, bytes: &mut [u8]) {
    bytes.chunks_exact_mut(8).zip(numbers).for_each(|(cell, x)| cell.copy_from_slice(&x.to_le_bytes()));
}

/// Describes the layout of the buffers to `prelude.luau`.
fn layout(
    sandbox: &Sandbox,
    fields: &[Field],
    (input, output): (&Buffer, &Buffer),
    purpose: Purpose,
) -> mlua::Result<Table> {
    let lua = &sandbox.lua;
    let (list, mut at) = (lua.create_table()?, 0);
    for field in fields {
        let (kind, rows, columns) = match field.shape {
            Shape::Number => ("number", 1, 1),
            Shape::List(n) => ("list", 1, n),
            Shape::Matrix(rows, columns) => ("matrix", rows, columns),
            Shape::Optional(n) => ("optional", 1, n),
            Shape::Rows(rows, columns) => ("rows", rows, columns),
        };
        let entry = lua.create_table()?;
        entry.set("path", field.path.clone())?;
        entry.set("kind", kind)?;
        entry.set("rows", rows)?;
        entry.set("columns", columns)?;
        entry.set("at", 8 * at)?;
        list.push(entry)?;
        at += field.shape.size();
    }
    let layout = lua.create_table()?;
    layout.set("fields", list)?;
    layout.set("input", input)?;
    layout.set("output", output)?;
    layout.set("drives", purpose == Purpose::Task)?;
    Ok(layout)
}

/// All link names, welded ones included, with their links and frames.
pub fn links(model: &Model) -> impl Iterator<Item = (&str, LinkId, Isometry3<f64>)> {
    model.links.iter().enumerate().flat_map(|(i, l)| {
        let own = (l.name.as_str(), LinkId(i), l.urdf_frame);
        std::iter::once(own).chain(l.merged.iter().map(move |m| (m.name.as_str(), LinkId(i), m.pose)))
    })
}
