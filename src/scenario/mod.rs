//! Scenario files: from TOML to runs in which everything is decided.
//!
//! ```text
//! file -> tree (every value knows its place) -> overrides -> sweep -> Scenario (typed, checked) -> Run
//! ```
//!
//! [`load`] reads a file, [`ScenarioFile::expand`] gives its [`Run`]s. Whatever is wrong comes back as [`Diagnostics`]:
//! with file, line and column, the line itself, and a guess at what was meant. Files that a scenario names beside
//! its robot are read, but nothing here opens a robot file, loads a mesh or steps.

mod axis;
mod checks;
mod decode;
mod diagnostic;
mod dimensions;
mod events;
mod expand;
mod expansion;
mod file;
pub(crate) mod format;
mod grid;
mod inputs;
mod key;
mod locate;
mod overrides;
mod path;
mod polygon;
mod quantity;
mod random;
mod reference;
#[expect(clippy::module_inception)]
mod scenario;
mod schema;
mod source;
mod tree;

pub use crate::metrics::METRICS;
pub use checks::host_and_port;
pub use diagnostic::{Diagnostic, Diagnostics, Place, Severity};
pub use events::Event;
pub use expand::{DEFAULT_MAX_RUNS, Origin, Run};
pub use expansion::Expansion;
pub use file::{ScenarioFile, load, parse};
pub use format::{
    change::ChangeSpec,
    compare::{CompareSpec, TruthMetric},
    contact::{
        ContactMethod, ContactSpec, EventHandling, ForcedState, IntegratorMethod, IntegratorSpec, LcpSpec, NcpSpec,
        PenaltySpec,
    },
    control::{AccelerationSource, ControlSpec, Estimator, InertialSpec, KinematicSpec},
    event::EventSpec,
    expect::{Expect, ExpectedOutcome},
    floor::{FloorSpec, Friction, PatchSpec},
    force::{
        AnchorSpec, CarriedObject, ConstantForce, Directions, DragForce, ForceFrame, ForceSpec, JointFrictionForce,
        PathShape, Profile, PushForce, RampForce, RandomPushes, ScriptForce, SineSpec, SpringForce, WaypointSpec,
    },
    random::{Distribution, RandomSpec, Sampling},
    robot::{
        BaseSpec, InertiaSpec, JointDefault, JointFriction, JointLimits, JointMode, JointSpec, PayloadSpec, RobotSpec,
        SoleSpec,
    },
    run::{FallenRule, LogSpec, LogTopic, StopSpec},
    self_collision::SelfCollisionSpec,
    sensors::{OrientationError, SensorError, SensorsSpec},
    sweep::{Axis, SweepSpec},
    task::{
        BalanceChange, BalanceControl, BalanceTask, CompensationChange, Contacts, Ends, ForceBalance,
        ForceBalanceChange, Gains, GravityCompensationTask, MocapTarget, MocapTask, PlaybackChange, PlaybackTask,
        PositionBalance, PositionBalanceChange, PostureTask, Recorded, ScriptTask, SineChange, SineJoint,
        SineJointChange, SineTask, SquatTask, TaskSpec, WalkTask,
    },
};
pub use grid::MOST_RUNS_EVER;
pub use inputs::Input;
pub use key::key;
pub use overrides::parse_override;
pub use quantity::Angle;
pub use scenario::{FORMAT, Scenario};
pub use schema::schema;

/// A name as a segment of a dotted path: in quotes where it is no bare key.
pub(crate) fn segment(name: &str) -> String {
    path::Path::segment(name)
}
