//! The table of commands: from it come what can be typed, its help, its completion and the page about it.

use crate::console::error::ConsoleError;
use crate::console::session::Session;
use crate::console::words::Words;
use crate::text::suggest;

/// What the words of a command can be, for completion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One of these.
    Of(&'static [&'static str]),
    /// A command.
    Commands,
    /// A joint.
    Joints,
    /// `JOINT=`.
    JointValues,
    /// A link.
    Links,
    /// A sole.
    Soles,
    /// A type of a task.
    TaskTypes,
    /// A task that has not ended.
    Tasks,
    /// A type of a force.
    ForceTypes,
    /// A key that can be set.
    Keys,
    /// A column.
    Columns,
    /// A state that was stored.
    States,
    /// A file.
    Files,
    /// Nothing that could be known.
    Free,
}

/// A command.
pub struct Command {
    /// Its first word.
    pub name: &'static str,
    /// How it is written.
    pub usage: &'static str,
    /// What it does, in a line.
    pub short: &'static str,
    /// What else there is to know; lines without an end are joined.
    more: &'static str,
    /// What follows the name; the last one goes on.
    pub(super) words: &'static [Kind],
    pub(super) act: fn(&mut Session, &mut Words) -> Result<String, ConsoleError>,
}

impl Command {
    /// What else there is to know, with line ends; may be empty.
    pub fn more(&self) -> String {
        self.more.lines().map(|line| format!("  {}\n", line.trim_start())).collect()
    }
}

/// A command whose words are all there.
fn alone(words: &mut Words, act: impl FnOnce() -> Result<String, ConsoleError>) -> Result<String, ConsoleError> {
    words.done()?;
    act()
}

use Kind::{
    Columns, Commands, Files, ForceTypes, Free, JointValues, Joints, Keys, Links, Of, Soles, States, TaskTypes, Tasks,
};

/// All there are.
pub const COMMANDS: &[Command] = &[
    Command {
        name: "help",
        usage: "help [COMMAND]",
        short: "Show the commands, or what one of them wants",
        more: "",
        words: &[Commands],
        act: |_, words| {
            let word = words.next().map(str::to_owned);
            words.done()?;
            Session::help(word.as_deref())
        },
    },
    Command {
        name: "status",
        usage: "status",
        short: "Show time, robot, rate and recordings",
        more: "",
        words: &[],
        act: |session, words| alone(words, || Ok(session.status())),
    },
    Command {
        name: "run",
        usage: "run [SECONDS] | run until TIME | run until KIND [SUBJECT]",
        short: "Simulate for a while, to a time, or until something happens",
        more: "Without words it runs to the session's end, or until `hold`. KIND is that of an event, such as touchdown or
               slip, and SUBJECT what it is of, such as a sole.",
        words: &[Of(&["until"]), Of(EVENTS), Soles],
        act: Session::run_on,
    },
    Command {
        name: "step",
        usage: "step [TICKS]",
        short: "Simulate to the next control tick, or so many ticks",
        more: "",
        words: &[],
        act: Session::step_on,
    },
    Command {
        name: "hold",
        usage: "hold",
        short: "Hold what runs or is played, as Ctrl-C does",
        more: "",
        words: &[],
        act: |session, words| alone(words, || Ok(session.hold())),
    },
    Command {
        name: "rate",
        usage: "rate FACTOR|realtime|free",
        short: "Simulated seconds per second from now on; free: as fast as it goes",
        more: "",
        words: &[Of(&["free", "realtime", "0.5", "0.1", "2"])],
        act: Session::set_rate,
    },
    Command {
        name: "undo",
        usage: "undo",
        short: "Take the last change back, and return to when it was made",
        more: "What was before it is simulated again, so the state is that of then to the last bit. It brings back a run that a
               change has broken.",
        words: &[],
        act: |session, words| alone(words, || session.undo()),
    },
    Command {
        name: "reset",
        usage: "reset",
        short: "Begin the session anew; recordings stay",
        more: "",
        words: &[],
        act: |session, words| alone(words, || session.reset()),
    },
    Command {
        name: "tasks",
        usage: "tasks",
        short: "List the tasks, their numbers and what they are doing",
        more: "",
        words: &[],
        act: |session, words| alone(words, || Ok(session.tasks())),
    },
    Command {
        name: "start",
        usage: "start TYPE [KEY=VALUE ...]",
        short: "Start a task now",
        more: "Types and keys are those of `[[task]]` (docs/reference/scenario.md); keys may be dotted, values are TOML:
               start sine joints.left_knee.amplitude=0.1 ramp=0.2
               start script file=\"tasks/wave.luau\" params={ amplitude = 0.3 }
               Files begin at the folder of the scenario.",
        words: &[TaskTypes, Free],
        act: Session::start,
    },
    Command {
        name: "stop",
        usage: "stop TASK|all",
        short: "End a task, by its number or its type",
        more: "Its joints stay where they were last asked to be.",
        words: &[Tasks],
        act: Session::stop,
    },
    Command {
        name: "change",
        usage: "change TASK KEY=VALUE ...",
        short: "Give a task new parameters",
        more: "Keys are those of the task's `change`, such as
               change sine joints.left_knee.amplitude=0.2
               change 1 params.amplitude=0.5",
        words: &[Tasks, Free],
        act: Session::change,
    },
    Command {
        name: "drive",
        usage: "drive JOINT=ANGLE ... [in SECONDS] | drive home [in SECONDS]",
        short: "Bring joints to a posture by a posture task, within 1 s if not said",
        more: "An angle is in radians, or such as \"30 deg\".",
        words: &[JointValues],
        act: Session::drive,
    },
    Command {
        name: "set",
        usage: "set KEY=VALUE ...",
        short: "Change values of the scenario: any before the first step, later those of events",
        more: "Later it may be floor.friction, floor.patches, gravity, contact.restitution, robot.payload,
               robot.joint.NAME.kp (kd, effort, velocity, friction, armature), robot.joint_default.kp (kd), force.N.KEY.",
        words: &[Keys],
        act: Session::set,
    },
    Command {
        name: "get",
        usage: "get KEY",
        short: "Show the present value of a key of the scenario",
        more: "",
        words: &[Keys],
        act: |session, words| session.get(words),
    },
    Command {
        name: "floor",
        usage: "floor [STATIC [KINETIC]]",
        short: "Set the floor's coefficients of friction, or show them",
        more: "",
        words: &[],
        act: Session::floor,
    },
    Command {
        name: "friction",
        usage: "friction JOINT [KEY=VALUE ...]",
        short: "Set the friction of a joint: coulomb, viscous, static, stribeck_velocity, slip_velocity",
        more: "What is not given has its default. Without values the present ones are shown.",
        words: &[Joints, Of(&["coulomb=", "viscous=", "static=", "stribeck_velocity=", "slip_velocity="])],
        act: Session::friction,
    },
    Command {
        name: "payload",
        usage: "payload [LINK MASS [X Y Z]]",
        short: "Let a link carry a mass (kg) at a point (m, link frame) instead of what it carries; 0: nothing",
        more: "Without words what is carried is shown.",
        words: &[Links],
        act: Session::payload,
    },
    Command {
        name: "push",
        usage: "push LINK FX FY FZ [for SECONDS] [at X Y Z] [KEY=VALUE ...]",
        short: "Push a link now: force in N, world axes; 0.1 s if not said",
        more: "Other keys are those of the force `push`: moment, frame, profile.",
        words: &[Links, Of(&["for", "at", "profile=", "frame=", "moment="])],
        act: Session::push,
    },
    Command {
        name: "force",
        usage: "force [TYPE KEY=VALUE ...]",
        short: "Let an external force act from now on; without words list those there are",
        more: "Types and keys are those of `[[force]]`; `set force.N.KEY=VALUE` changes one.",
        words: &[ForceTypes, Free],
        act: Session::force,
    },
    Command {
        name: "store",
        usage: "store NAME",
        short: "Store the robot's present state under a name",
        more: "",
        words: &[],
        act: Session::store,
    },
    Command {
        name: "restore",
        usage: "restore NAME",
        short: "Put the robot into a state that was stored; time and tasks go on",
        more: "",
        words: &[States],
        act: Session::restore,
    },
    Command {
        name: "states",
        usage: "states",
        short: "List the states that are stored",
        more: "",
        words: &[],
        act: |session, words| alone(words, || Ok(session.states())),
    },
    Command {
        name: "joints",
        usage: "joints [PATTERN]",
        short: "Show joints: position, velocity, what is asked, effort",
        more: "Names as on a command line: `*` any characters, `?` one.",
        words: &[Joints],
        act: Session::joints,
    },
    Command {
        name: "base",
        usage: "base",
        short: "Show position, orientation and velocity of the base",
        more: "",
        words: &[],
        act: |session, words| {
            words.done()?;
            session.base()
        },
    },
    Command {
        name: "com",
        usage: "com",
        short: "Show the centre of mass and its velocity",
        more: "",
        words: &[],
        act: |session, words| {
            words.done()?;
            session.com()
        },
    },
    Command {
        name: "zmp",
        usage: "zmp",
        short: "Show zero-moment point, point of optimal stability and support polygon",
        more: "",
        words: &[],
        act: |session, words| {
            words.done()?;
            session.zmp()
        },
    },
    Command {
        name: "contact",
        usage: "contact [SOLE]",
        short: "Show contact states of the soles, and forces at their vertices",
        more: "",
        words: &[Soles],
        act: Session::contact,
    },
    Command {
        name: "frame",
        usage: "frame LINK",
        short: "Show pose and velocity of a link's frame in the world",
        more: "",
        words: &[Links],
        act: Session::frame,
    },
    Command {
        name: "jacobian",
        usage: "jacobian com | jacobian LINK [X Y Z]",
        short: "Show the Jacobian of the centre of mass, or of a point of a link (link frame, m)",
        more: "Rows are velocities in world axes, columns the base's velocities, if it is free, and the joints'.",
        words: &[Links],
        act: Session::jacobian,
    },
    Command {
        name: "columns",
        usage: "columns [PATTERN]",
        short: "List the columns that `value`, `play` and `export` know",
        more: "",
        words: &[Columns],
        act: Session::columns,
    },
    Command {
        name: "value",
        usage: "value COLUMN ...",
        short: "Show columns with all their digits",
        more: "",
        words: &[Columns],
        act: Session::value,
    },
    Command {
        name: "events",
        usage: "events [NUMBER]",
        short: "Show the newest events, 20 if not said",
        more: "",
        words: &[],
        act: Session::events,
    },
    Command {
        name: "expect",
        usage: "expect COLUMN [min=X] [max=X] [value=X tolerance=X]",
        short: "Say whether a column is as expected; if not, the session ends with exit code 1 when it ends",
        more: "A column of words is compared with `value=WORD`.",
        words: &[Columns, Of(&["min=", "max=", "value=", "tolerance="])],
        act: Session::expect,
    },
    Command {
        name: "record",
        usage: "record | record stop",
        short: "Begin or end a recording",
        more: "It is a log as every run leaves one, with the rate and the topics of `[log]`.",
        words: &[Of(&["stop"])],
        act: Session::record,
    },
    Command {
        name: "save",
        usage: "save session FILE.toml | save recording FILE.mcap",
        short: "Write the session as a scenario, or the last recording as a log",
        more: "The scenario ends at the present time; run, it gives the same bits.",
        words: &[Of(&["session", "recording"]), Files],
        act: Session::save,
    },
    Command {
        name: "load",
        usage: "load LOG|FOLDER",
        short: "Load a recording: a log, or the folder of a run",
        more: "",
        words: &[Files],
        act: Session::load,
    },
    Command {
        name: "play",
        usage: "play [SPEED|free] [COLUMN ...] [rate=HZ] [from=S] [to=S]",
        short: "Play the recording: its columns in lines, 10 a second, backwards if SPEED is below 0",
        more: "It begins where `jump` has led. Queries then show the recording; `now` returns to the simulation.
               As motion of the robot a recording is played by `start playback file=\"FILE.mcap\"`.",
        words: &[Columns],
        act: Session::play,
    },
    Command {
        name: "jump",
        usage: "jump TIME|+S|-S|start|end | jump next|previous [KIND [SUBJECT]] | jump event NUMBER | jump when COLUMN <|>|= VALUE",
        short: "Go to an instant of the recording: a time, an event, or where a column comes to be so",
        more: "Queries then show the recording; `now` returns to the simulation.",
        words: &[Of(&["start", "end", "next", "previous", "event", "when"]), Of(EVENTS), Soles],
        act: Session::jump,
    },
    Command {
        name: "now",
        usage: "now",
        short: "Return from the recording to the simulation",
        more: "",
        words: &[],
        act: |session, words| alone(words, || Ok(session.now())),
    },
    Command {
        name: "export",
        usage: "export FILE [COLUMN ...] [OPTION=VALUE ...]",
        short: "Write columns of the recording as .csv, .parquet, or text (.dat, .txt)",
        more: "Options are those of `runner export`: rate, from, to, format, events=true, and for text separator, numbers,
               header, comment, missing, time-unit, blocks.",
        words: &[Files, Columns],
        act: Session::export,
    },
    Command {
        name: "quit",
        usage: "quit",
        short: "End the session",
        more: "",
        words: &[],
        act: |session, words| {
            words.done()?;
            session.leave();
            Ok(String::new())
        },
    },
];

/// Kinds of events.
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

/// The command of a name.
pub(super) fn find(name: &str) -> Result<&'static Command, ConsoleError> {
    COMMANDS.iter().find(|command| command.name == name).ok_or_else(|| {
        let names = COMMANDS.iter().map(|command| command.name);
        ConsoleError::usage(format!("there is no command `{name}`; {} (`help` lists all)", suggest(name, names)))
    })
}

/// The table as Markdown, for the documentation.
pub fn reference() -> String {
    let escaped = |text: &str| text.replace('|', "\\|");
    let line = |c: &Command| format!("| `{}` | {} |\n", escaped(c.usage), escaped(c.short));
    COMMANDS.iter().map(line).fold("| command | |\n|---|---|\n".to_owned(), |all, line| all + &line)
}
