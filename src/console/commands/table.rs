//! Table of the console's commands: syntax, help, completion and handler of each. The help, the
//! completion and the table of `docs/console.md` are derived from it.

use crate::console::arguments::Arguments;
use crate::console::console_error::ConsoleError;
use crate::console::run_goal::EVENT_KINDS;
use crate::console::session::Session;
use crate::text::suggest;

/// Kind of an argument, for completion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArgumentKind {
    /// One of fixed words.
    Of(&'static [&'static str]),
    /// A command name.
    Commands,
    /// A joint name.
    Joints,
    /// `JOINT=`.
    JointValues,
    /// A link name.
    Links,
    /// A sole name.
    Soles,
    /// A task type.
    TaskTypes,
    /// Number of a task that has not ended, or `all`.
    Tasks,
    /// A force type.
    ForceTypes,
    /// A key that `set` accepts.
    Keys,
    /// A log column.
    Columns,
    /// Name of a stored state.
    States,
    /// A file path.
    Files,
    /// Free text, not completed.
    Free,
}

/// A console command.
pub struct Command {
    /// Name, the first word of the line.
    pub name: &'static str,
    /// Syntax.
    pub usage: &'static str,
    /// One-line description.
    pub short: &'static str,
    /// Details, one line of help per line; may be empty.
    details: &'static str,
    /// Kinds of the arguments; the last kind repeats.
    pub(in crate::console) arguments: &'static [ArgumentKind],
    pub(in crate::console) execute: fn(&mut Session, &mut Arguments) -> Result<String, ConsoleError>,
}

impl Command {
    /// Details, indented, each line with its line end; may be empty.
    pub fn details(&self) -> String {
        self.details.lines().map(|line| format!("  {}\n", line.trim_start())).collect()
    }
}

/// Executes a command that takes no arguments.
fn without_arguments(
    args: &mut Arguments,
    execute: impl FnOnce() -> Result<String, ConsoleError>,
) -> Result<String, ConsoleError> {
    args.done()?;
    execute()
}

use ArgumentKind::{
    Columns, Commands, Files, ForceTypes, Free, JointValues, Joints, Keys, Links, Of, Soles, States, TaskTypes, Tasks,
};

/// All commands.
pub const COMMANDS: &[Command] = &[
    Command {
        name: "help",
        usage: "help [COMMAND]",
        short: "Show the commands, or the arguments of one",
        details: "",
        arguments: &[Commands],
        execute: |_, args| {
            let name = args.next().map(str::to_owned);
            args.done()?;
            Session::help(name.as_deref())
        },
    },
    Command {
        name: "status",
        usage: "status",
        short: "Show time, robot, rate and recordings",
        details: "",
        arguments: &[],
        execute: |session, args| without_arguments(args, || Ok(session.status())),
    },
    Command {
        name: "run",
        usage: "run [SECONDS] | run until TIME | run until KIND [SUBJECT]",
        short: "Simulate for a duration, to a time, or until an event",
        details: "Without arguments it runs to the session's end, or until `hold`. KIND is the kind of an event, such as
               touchdown or slip, and SUBJECT its subject, such as a sole.",
        arguments: &[Of(&["until"]), Of(EVENT_KINDS), Soles],
        execute: Session::run,
    },
    Command {
        name: "step",
        usage: "step [TICKS]",
        short: "Simulate to the next control tick, or a number of ticks",
        details: "",
        arguments: &[],
        execute: Session::step,
    },
    Command {
        name: "hold",
        usage: "hold",
        short: "Hold the run or the playback, as Ctrl-C does",
        details: "",
        arguments: &[],
        execute: |session, args| without_arguments(args, || Ok(session.hold())),
    },
    Command {
        name: "rate",
        usage: "rate FACTOR|realtime|free",
        short: "Set the simulated seconds per second; free: as fast as possible",
        details: "",
        arguments: &[Of(&["free", "realtime", "0.5", "0.1", "2"])],
        execute: Session::set_rate,
    },
    Command {
        name: "undo",
        usage: "undo",
        short: "Undo the last change, and return to its time",
        details: "The run before the change is simulated again, so the state is equal to the last bit. A run that terminated
               after the change can continue.",
        arguments: &[],
        execute: |session, args| without_arguments(args, || session.undo()),
    },
    Command {
        name: "reset",
        usage: "reset",
        short: "Restart the session; recordings stay",
        details: "",
        arguments: &[],
        execute: |session, args| without_arguments(args, || session.reset()),
    },
    Command {
        name: "tasks",
        usage: "tasks",
        short: "List the tasks with their numbers and states",
        details: "",
        arguments: &[],
        execute: |session, args| without_arguments(args, || Ok(session.tasks())),
    },
    Command {
        name: "start",
        usage: "start TYPE [KEY=VALUE ...]",
        short: "Start a task now",
        details: "Types and keys are those of `[[task]]` (docs/reference/scenario.md); keys may be dotted, values are TOML:
               start sine joints.left_knee.amplitude=0.1 ramp=0.2
               start script file=\"tasks/wave.luau\" params={ amplitude = 0.3 }
               Paths of files are relative to the folder of the scenario.",
        arguments: &[TaskTypes, Free],
        execute: Session::start,
    },
    Command {
        name: "stop",
        usage: "stop TASK|all",
        short: "End a task, by its number or its type",
        details: "Its joints keep their last desired positions.",
        arguments: &[Tasks],
        execute: Session::stop,
    },
    Command {
        name: "change",
        usage: "change TASK KEY=VALUE ...",
        short: "Change parameters of a task",
        details: "Keys are those of the task's `change`, such as
               change sine joints.left_knee.amplitude=0.2
               change 1 params.amplitude=0.5",
        arguments: &[Tasks, Free],
        execute: Session::change,
    },
    Command {
        name: "drive",
        usage: "drive JOINT=ANGLE ... [in SECONDS] | drive home [in SECONDS]",
        short: "Move joints to a posture with a posture task, by default within 1 s",
        details: "An angle is in radians, or such as \"30 deg\".",
        arguments: &[JointValues],
        execute: Session::drive,
    },
    Command {
        name: "set",
        usage: "set KEY=VALUE ...",
        short: "Change values of the scenario: any before the first step, later those of events",
        details: "Later it may be floor.friction, floor.patches, gravity, contact.restitution, robot.payload,
               robot.joint.NAME.kp (kd, effort, velocity, friction, armature), robot.joint_default.kp (kd), force.N.KEY.",
        arguments: &[Keys],
        execute: Session::set,
    },
    Command {
        name: "get",
        usage: "get KEY",
        short: "Show the present value of a key of the scenario",
        details: "",
        arguments: &[Keys],
        execute: |session, args| session.get(args),
    },
    Command {
        name: "floor",
        usage: "floor [STATIC [KINETIC]]",
        short: "Set the floor's coefficients of friction, or show them",
        details: "",
        arguments: &[],
        execute: Session::floor,
    },
    Command {
        name: "friction",
        usage: "friction JOINT [KEY=VALUE ...]",
        short: "Set the friction of a joint: coulomb, viscous, static, stribeck_velocity, slip_velocity",
        details: "Values not given have their defaults. Without values, the present ones are shown.",
        arguments: &[Joints, Of(&["coulomb=", "viscous=", "static=", "stribeck_velocity=", "slip_velocity="])],
        execute: Session::friction,
    },
    Command {
        name: "payload",
        usage: "payload [LINK MASS [X Y Z]]",
        short: "Replace the payload of a link: a mass (kg) at a point (m, link frame); mass 0 removes it",
        details: "Without arguments, the present payloads are shown.",
        arguments: &[Links],
        execute: Session::payload,
    },
    Command {
        name: "push",
        usage: "push LINK FX FY FZ [for SECONDS] [at X Y Z] [KEY=VALUE ...]",
        short: "Push a link now: force in N, world axes; by default for 0.1 s",
        details: "Other keys are those of the force `push`: moment, frame, profile.",
        arguments: &[Links, Of(&["for", "at", "profile=", "frame=", "moment="])],
        execute: Session::push,
    },
    Command {
        name: "force",
        usage: "force [TYPE KEY=VALUE ...]",
        short: "Apply an external force from now on; without arguments, list the forces",
        details: "Types and keys are those of `[[force]]`; `set force.N.KEY=VALUE` changes one.",
        arguments: &[ForceTypes, Free],
        execute: Session::force,
    },
    Command {
        name: "store",
        usage: "store NAME",
        short: "Store the robot's present state under a name",
        details: "",
        arguments: &[],
        execute: Session::store,
    },
    Command {
        name: "restore",
        usage: "restore NAME",
        short: "Set the robot to a stored state; time and tasks continue",
        details: "",
        arguments: &[States],
        execute: Session::restore,
    },
    Command {
        name: "states",
        usage: "states",
        short: "List the stored states",
        details: "",
        arguments: &[],
        execute: |session, args| without_arguments(args, || Ok(session.states())),
    },
    Command {
        name: "joints",
        usage: "joints [PATTERN]",
        short: "Show joints: position, velocity, desired position, effort",
        details: "In PATTERN, `*` matches any characters and `?` one character.",
        arguments: &[Joints],
        execute: Session::joints,
    },
    Command {
        name: "base",
        usage: "base",
        short: "Show position, orientation and velocity of the base",
        details: "",
        arguments: &[],
        execute: |session, args| without_arguments(args, || session.base()),
    },
    Command {
        name: "com",
        usage: "com",
        short: "Show the centre of mass and its velocity",
        details: "",
        arguments: &[],
        execute: |session, args| without_arguments(args, || session.com()),
    },
    Command {
        name: "zmp",
        usage: "zmp",
        short: "Show zero-moment point, point of optimal stability and support polygon",
        details: "",
        arguments: &[],
        execute: |session, args| without_arguments(args, || session.zmp()),
    },
    Command {
        name: "contact",
        usage: "contact [SOLE]",
        short: "Show contact states of the soles, and forces at their vertices",
        details: "",
        arguments: &[Soles],
        execute: Session::contact,
    },
    Command {
        name: "frame",
        usage: "frame LINK",
        short: "Show pose and velocity of a link's frame in the world",
        details: "",
        arguments: &[Links],
        execute: Session::frame,
    },
    Command {
        name: "jacobian",
        usage: "jacobian com | jacobian LINK [X Y Z]",
        short: "Show the Jacobian of the centre of mass, or of a point of a link (link frame, m)",
        details: "Rows are velocities in world axes, columns the base's velocities, if it is free, and the joints'.",
        arguments: &[Links],
        execute: Session::jacobian,
    },
    Command {
        name: "columns",
        usage: "columns [PATTERN]",
        short: "List the columns that `value`, `play` and `export` accept",
        details: "",
        arguments: &[Columns],
        execute: Session::columns,
    },
    Command {
        name: "value",
        usage: "value COLUMN ...",
        short: "Show columns with all their digits",
        details: "",
        arguments: &[Columns],
        execute: Session::value,
    },
    Command {
        name: "events",
        usage: "events [NUMBER]",
        short: "Show the newest events, by default 20",
        details: "",
        arguments: &[],
        execute: Session::events,
    },
    Command {
        name: "expect",
        usage: "expect COLUMN [min=X] [max=X] [value=X tolerance=X]",
        short: "Check a column; if the check fails, the session later exits with code 1",
        details: "Compare a text column with `value=WORD`.",
        arguments: &[Columns, Of(&["min=", "max=", "value=", "tolerance="])],
        execute: Session::expect,
    },
    Command {
        name: "record",
        usage: "record | record stop",
        short: "Begin or end a recording",
        details: "The log has the rate and the topics of `[log]`.",
        arguments: &[Of(&["stop"])],
        execute: Session::record,
    },
    Command {
        name: "save",
        usage: "save session FILE.toml | save recording FILE.mcap",
        short: "Write the session as a scenario, or the last recording as a log",
        details: "The scenario ends at the present time; run, it gives the same bits.",
        arguments: &[Of(&["session", "recording"]), Files],
        execute: Session::save,
    },
    Command {
        name: "load",
        usage: "load LOG|FOLDER",
        short: "Load a recording: a log, or the folder of a run",
        details: "",
        arguments: &[Files],
        execute: Session::load,
    },
    Command {
        name: "play",
        usage: "play [SPEED|free] [COLUMN ...] [rate=HZ] [from=S] [to=S]",
        short: "Print columns of the recording, 10 lines per second; backwards if SPEED is below 0",
        details: "It begins at the instant selected by `jump`. Queries then show the recording; `now` returns to the simulation.
               `start playback file=\"FILE.mcap\"` moves the robot as recorded.",
        arguments: &[Columns],
        execute: Session::play,
    },
    Command {
        name: "jump",
        usage: "jump TIME|+S|-S|start|end | jump next|previous [KIND [SUBJECT]] | jump event NUMBER | jump when COLUMN <|>|= VALUE",
        short: "Select an instant of the recording: a time, an event, or where a column meets a condition",
        details: "Queries then show the recording; `now` returns to the simulation.",
        arguments: &[Of(&["start", "end", "next", "previous", "event", "when"]), Of(EVENT_KINDS), Soles],
        execute: Session::jump,
    },
    Command {
        name: "now",
        usage: "now",
        short: "Return from the recording to the simulation",
        details: "",
        arguments: &[],
        execute: |session, args| without_arguments(args, || Ok(session.now())),
    },
    Command {
        name: "export",
        usage: "export FILE [COLUMN ...] [OPTION=VALUE ...]",
        short: "Write columns of the recording as .csv, .parquet, or text (.dat, .txt)",
        details: "Options are those of `runner export`: rate, from, to, format, events=true, and for text separator, numbers,
               header, comment, missing, time-unit, blocks.",
        arguments: &[Files, Columns],
        execute: Session::export,
    },
    Command {
        name: "quit",
        usage: "quit",
        short: "End the session",
        details: "",
        arguments: &[],
        execute: |session, args| {
            args.done()?;
            session.quit();
            Ok(String::new())
        },
    },
];

impl Session {
    /// Executes a line, or starts its run or playback. Returns the output with line ends. An empty
    /// line does nothing.
    ///
    /// # Errors
    /// The line is invalid or its command fails; the session is then unchanged.
    pub fn execute(&mut self, line: &str) -> Result<String, ConsoleError> {
        let mut args = Arguments::of(line)?;
        let Some(name) = args.next().map(str::to_owned) else { return Ok(String::new()) };
        let command = find(&name)?;
        (command.execute)(self, &mut args).map_err(|error| match error {
            ConsoleError::Usage(why) => {
                ConsoleError::Usage(format!("{}: {why}; usage: `{}`", command.name, command.usage))
            }
            other => other,
        })
    }

    pub(in crate::console) fn help(name: Option<&str>) -> Result<String, ConsoleError> {
        let Some(name) = name else {
            let width = COMMANDS.iter().map(|c| c.name.len()).max().unwrap_or(0);
            let line = |c: &Command| format!("  {:width$}  {}\n", c.name, c.short);
            let list: String = COMMANDS.iter().map(line).collect();
            return Ok(format!("{list}`help COMMAND` shows the details of one.\n"));
        };
        let command = find(name)?;
        Ok(format!("{}\n  {}.\n{}", command.usage, command.short, command.details()))
    }
}

/// Finds a command by name.
pub(in crate::console) fn find(name: &str) -> Result<&'static Command, ConsoleError> {
    COMMANDS.iter().find(|command| command.name == name).ok_or_else(|| {
        let names = COMMANDS.iter().map(|command| command.name);
        ConsoleError::usage(format!("there is no command `{name}`; {} (`help` lists all)", suggest(name, names)))
    })
}

/// Table of the commands as Markdown, for `docs/console.md`.
pub fn reference() -> String {
    let escaped = |text: &str| text.replace('|', "\\|");
    let line = |c: &Command| format!("| `{}` | {} |\n", escaped(c.usage), escaped(c.short));
    COMMANDS.iter().map(line).fold("| command | |\n|---|---|\n".to_owned(), |all, line| all + &line)
}
