//! Table of the console's commands: syntax, help, completion and handler of each. The help, the
//! completion and the table of `docs/console.md` are derived from it.

use crate::console::arguments::Arguments;
use crate::console::error::ConsoleError;
use crate::console::session::Session;
use crate::text::suggest;

/// ArgumentKind of an argument, for completion.
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
    pub(super) arguments: &'static [ArgumentKind],
    pub(super) execute: fn(&mut Session, &mut Arguments) -> Result<String, ConsoleError>,
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
        short: "Show the commands, or what one of them wants",
        details: "",
        arguments: &[Commands],
        execute: |_, args| {
            let word = args.next().map(str::to_owned);
            args.done()?;
            Session::help(word.as_deref())
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
        short: "Simulate for a while, to a time, or until something happens",
        details: "Without words it runs to the session's end, or until `hold`. KIND is that of an event, such as touchdown or
               slip, and SUBJECT what it is of, such as a sole.",
        arguments: &[Of(&["until"]), Of(EVENTS), Soles],
        execute: Session::run,
    },
    Command {
        name: "step",
        usage: "step [TICKS]",
        short: "Simulate to the next control tick, or so many ticks",
        details: "",
        arguments: &[],
        execute: Session::step,
    },
    Command {
        name: "hold",
        usage: "hold",
        short: "Hold what runs or is played, as Ctrl-C does",
        details: "",
        arguments: &[],
        execute: |session, args| without_arguments(args, || Ok(session.hold())),
    },
    Command {
        name: "rate",
        usage: "rate FACTOR|realtime|free",
        short: "Simulated seconds per second from now on; free: as fast as it goes",
        details: "",
        arguments: &[Of(&["free", "realtime", "0.5", "0.1", "2"])],
        execute: Session::set_rate,
    },
    Command {
        name: "undo",
        usage: "undo",
        short: "Take the last change back, and return to when it was made",
        details: "What was before it is simulated again, so the state is that of then to the last bit. It brings back a run that a
               change has broken.",
        arguments: &[],
        execute: |session, args| without_arguments(args, || session.undo()),
    },
    Command {
        name: "reset",
        usage: "reset",
        short: "Begin the session anew; recordings stay",
        details: "",
        arguments: &[],
        execute: |session, args| without_arguments(args, || session.reset()),
    },
    Command {
        name: "tasks",
        usage: "tasks",
        short: "List the tasks, their numbers and what they are doing",
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
               Files begin at the folder of the scenario.",
        arguments: &[TaskTypes, Free],
        execute: Session::start,
    },
    Command {
        name: "stop",
        usage: "stop TASK|all",
        short: "End a task, by its number or its type",
        details: "Its joints stay where they were last asked to be.",
        arguments: &[Tasks],
        execute: Session::stop,
    },
    Command {
        name: "change",
        usage: "change TASK KEY=VALUE ...",
        short: "Give a task new parameters",
        details: "Keys are those of the task's `change`, such as
               change sine joints.left_knee.amplitude=0.2
               change 1 params.amplitude=0.5",
        arguments: &[Tasks, Free],
        execute: Session::change,
    },
    Command {
        name: "drive",
        usage: "drive JOINT=ANGLE ... [in SECONDS] | drive home [in SECONDS]",
        short: "Bring joints to a posture by a posture task, within 1 s if not said",
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
        details: "What is not given has its default. Without values the present ones are shown.",
        arguments: &[Joints, Of(&["coulomb=", "viscous=", "static=", "stribeck_velocity=", "slip_velocity="])],
        execute: Session::friction,
    },
    Command {
        name: "payload",
        usage: "payload [LINK MASS [X Y Z]]",
        short: "Let a link carry a mass (kg) at a point (m, link frame) instead of what it carries; 0: nothing",
        details: "Without words what is carried is shown.",
        arguments: &[Links],
        execute: Session::payload,
    },
    Command {
        name: "push",
        usage: "push LINK FX FY FZ [for SECONDS] [at X Y Z] [KEY=VALUE ...]",
        short: "Push a link now: force in N, world axes; 0.1 s if not said",
        details: "Other keys are those of the force `push`: moment, frame, profile.",
        arguments: &[Links, Of(&["for", "at", "profile=", "frame=", "moment="])],
        execute: Session::push,
    },
    Command {
        name: "force",
        usage: "force [TYPE KEY=VALUE ...]",
        short: "Let an external force act from now on; without words list those there are",
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
        short: "Put the robot into a state that was stored; time and tasks go on",
        details: "",
        arguments: &[States],
        execute: Session::restore,
    },
    Command {
        name: "states",
        usage: "states",
        short: "List the states that are stored",
        details: "",
        arguments: &[],
        execute: |session, args| without_arguments(args, || Ok(session.states())),
    },
    Command {
        name: "joints",
        usage: "joints [PATTERN]",
        short: "Show joints: position, velocity, what is asked, effort",
        details: "Names as on a command line: `*` any characters, `?` one.",
        arguments: &[Joints],
        execute: Session::joints,
    },
    Command {
        name: "base",
        usage: "base",
        short: "Show position, orientation and velocity of the base",
        details: "",
        arguments: &[],
        execute: |session, args| {
            args.done()?;
            session.base()
        },
    },
    Command {
        name: "com",
        usage: "com",
        short: "Show the centre of mass and its velocity",
        details: "",
        arguments: &[],
        execute: |session, args| {
            args.done()?;
            session.com()
        },
    },
    Command {
        name: "zmp",
        usage: "zmp",
        short: "Show zero-moment point, point of optimal stability and support polygon",
        details: "",
        arguments: &[],
        execute: |session, args| {
            args.done()?;
            session.zmp()
        },
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
        short: "List the columns that `value`, `play` and `export` know",
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
        short: "Show the newest events, 20 if not said",
        details: "",
        arguments: &[],
        execute: Session::events,
    },
    Command {
        name: "expect",
        usage: "expect COLUMN [min=X] [max=X] [value=X tolerance=X]",
        short: "Say whether a column is as expected; if not, the session ends with exit code 1 when it ends",
        details: "A column of words is compared with `value=WORD`.",
        arguments: &[Columns, Of(&["min=", "max=", "value=", "tolerance="])],
        execute: Session::expect,
    },
    Command {
        name: "record",
        usage: "record | record stop",
        short: "Begin or end a recording",
        details: "It is a log as every run leaves one, with the rate and the topics of `[log]`.",
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
        short: "Play the recording: its columns in lines, 10 a second, backwards if SPEED is below 0",
        details: "It begins where `jump` has led. Queries then show the recording; `now` returns to the simulation.
               As motion of the robot a recording is played by `start playback file=\"FILE.mcap\"`.",
        arguments: &[Columns],
        execute: Session::play,
    },
    Command {
        name: "jump",
        usage: "jump TIME|+S|-S|start|end | jump next|previous [KIND [SUBJECT]] | jump event NUMBER | jump when COLUMN <|>|= VALUE",
        short: "Go to an instant of the recording: a time, an event, or where a column comes to be so",
        details: "Queries then show the recording; `now` returns to the simulation.",
        arguments: &[Of(&["start", "end", "next", "previous", "event", "when"]), Of(EVENTS), Soles],
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

/// Event kinds.
pub(super) const EVENTS: &[&str] = &[
    "touchdown",
    "liftoff",
    "slip",
    "stick",
    "state",
    "border",
    "forced",
    "impact",
    "jam",
    "inconsistent",
    "self-collision",
    "task",
    "event",
    "force",
    "push",
    "spring",
    "object",
];

/// Finds a command by name.
pub(super) fn find(name: &str) -> Result<&'static Command, ConsoleError> {
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
