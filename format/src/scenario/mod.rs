//! Reads scenario files: from TOML to runs in which every value is set.
//!
//! ```text
//! file -> TOML tree with positions -> overrides -> sweep -> Scenario (typed, checked) -> Run
//! ```
//!
//! [`load`] reads a file and [`ScenarioFile::expand`] gives its [`Run`]s. Errors come back as
//! [`Diagnostics`] with file, line, column, an excerpt and a suggestion.
//!
//! Reads the files that a scenario names, but opens no robot file and simulates nothing. `assemble`
//! and `batch` call it.
//!
//! Imports: `math`, `text`, `geometry`, `random`, `input`, `metrics`, `sdf`, `robot`, `contact`,
//! `statistics`, `search`. Used by: `assemble`, `results`, `batch`, `replay`, `api`, `cli`,
//! `console`, `fit`.

mod checks;
mod claims;
mod decode;
mod events;
mod expansion;
mod expansion_check;
mod file;
mod findings;
pub(crate) mod format;
mod inputs;
mod key_path;
mod overrides;
mod reference;
mod run;
mod run_key;
#[expect(clippy::module_inception)]
mod scenario;
mod search;
mod sweep;
mod unused_parameters;
mod world;

pub use crate::metrics::METRICS;
pub use crate::text::diagnostic::{Diagnostic, Diagnostics, Severity};
pub use crate::text::toml_syntax::segment;
pub use checks::host_and_port;
pub use claims::{ClaimPlace, PlannedClaim};
pub use decode::NodeDeserializer;
pub use events::Event;
pub use expansion::Expansion;
pub use expansion_check::{CheckedCell, CheckedCells, ExpansionCheck};
pub use file::{ScenarioFile, load, parse};
pub use findings::Findings;
pub use format::{
    change::ChangeSpec,
    claim::{ClaimSpec, ShareQuestion},
    compare::{CompareSpec, TruthMetric},
    contact::{ContactMethod, ContactSpec, EventHandling, ForcedState, IntegratorMethod, IntegratorSpec},
    contact_pair::ContactPair,
    control::{AccelerationSource, ControlSpec, Estimator, InertialSpec, Interpolation, KinematicSpec},
    event::EventSpec,
    expect::{Expect, ExpectedOutcome},
    floor::{FloorSpec, Friction, PatchSpec},
    force::{
        AnchorSpec, CarriedObject, ConstantForce, Directions, DragForce, ForceFrame, ForceSpec, JointFrictionForce,
        PathShape, Profile, PushForce, RampForce, RandomPushes, ScriptForce, SineSpec, SpringForce, WaypointSpec,
    },
    object::{
        BoxObject, CapsuleObject, CylinderObject, MeshObject, ModelObject, ObjectEntry, ObjectSpec, ServoSpec,
        SphereObject,
    },
    random::{Distribution, RandomSpec, Sampling},
    robot::{
        BaseSpec, InertiaSpec, JointDefault, JointFriction, JointLimits, JointMode, JointSpec, PayloadSpec, RobotSpec,
        SoleSpec, TouchingParts,
    },
    run::{FallenRule, LogSpec, LogTopic, StopSpec, SunkLink},
    search::{SearchSpec, SearchedKey},
    self_collision::SelfCollisionSpec,
    sensors::{OrientationError, SensorError, SensorsSpec},
    sweep::{Axis, SweepSpec},
    task::{
        BalanceChange, BalanceControl, BalanceTask, CompensationChange, Contacts, Ends, ForceBalance,
        ForceBalanceChange, Gains, GravityCompensationTask, MocapTarget, MocapTask, PlaybackChange, PlaybackTask,
        PolicyAction, PolicyChange, PolicyMode, PolicyNumbers, PolicyObservation, PolicyState, PolicyTask, PolicyTerm,
        PositionBalance, PositionBalanceChange, PostureTask, Recorded, ScriptTask, SineChange, SineJoint,
        SineJointChange, SineTask, SquatTask, TaskSpec, WalkTask,
    },
    terrain::{
        BoxTerrain, HeightFieldTerrain, MeshBody, MeshTerrain, RampTerrain, StairsTerrain, TerrainEntry, TerrainSpec,
    },
    world::WorldSpec,
};
pub use inputs::Input;
pub use key_path::KeyPath;
pub use overrides::{OverrideError, parse_override};
pub use run::{DEFAULT_MAX_RUNS, Origin, Run};
pub use run_key::{KeyHasher, key};
pub use scenario::{FORMAT, Scenario, schema};
pub use search::{FollowedCell, PlannedSearch, SearchAxis};
pub use sweep::MAX_BATCH_RUNS;
