//! The type of a whole scenario, read from its tree section by section.
//!
//! Sections are read one by one, so that an error in one does not hide those in others.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::checks;
use super::decode::{DecodeError, NodeDeserializer};
use crate::scenario::findings::Findings;
use crate::scenario::format::claim::ClaimSpec;
use crate::scenario::format::compare::CompareSpec;
use crate::scenario::format::contact::{ContactSpec, IntegratorSpec};
use crate::scenario::format::control::ControlSpec;
use crate::scenario::format::event::EventSpec;
use crate::scenario::format::expect::Expect;
use crate::scenario::format::floor::FloorSpec;
use crate::scenario::format::force::ForceSpec;
use crate::scenario::format::object::ObjectSpec;
use crate::scenario::format::robot::RobotSpec;
use crate::scenario::format::run::{LogSpec, StopSpec};
use crate::scenario::format::search::SearchSpec;
use crate::scenario::format::self_collision::SelfCollisionSpec;
use crate::scenario::format::sensors::SensorsSpec;
use crate::scenario::format::sweep::SweepSpec;
use crate::scenario::format::tagged::{self, Tagged};
use crate::scenario::format::task::TaskSpec;
use crate::scenario::format::terrain::TerrainSpec;
use crate::scenario::format::world::WorldSpec;
use crate::text::quantity::{json, positive};
use crate::text::suggest;
use crate::text::toml_tree::{Node, Value};

/// The version of the file format this program reads.
pub const FORMAT: u32 = 1;

/// One scenario. SI units, angles in radians (or strings such as `"30 deg"`), vectors `[x, y, z]`.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(title = "Scenario", extend("required" = ["robot"]))]
pub struct Scenario {
    /// Version of the file format.
    #[schemars(extend("const" = FORMAT))]
    pub schema: u32,
    /// Description for readers.
    pub description: String,
    /// Simulated time, s.
    #[schemars(with = "json::Positive")]
    pub duration: f64,
    /// Seed of all random draws.
    pub seed: u64,
    /// Acceleration of free fall in world axes, m/s^2.
    pub gravity: [f64; 3],
    /// The robot.
    pub robot: RobotSpec,
    /// The floor.
    pub floor: FloorSpec,
    /// Fixed bodies on which the robot stands, besides the floor.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub terrain: Vec<TerrainSpec>,
    /// Bodies from a world file. In an expanded run they are among `terrain` and `object`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub world: Option<WorldSpec>,
    /// Contact method and its parameters.
    pub contact: ContactSpec,
    /// Integration of the equations of motion.
    pub integrator: IntegratorSpec,
    /// The task server.
    pub control: ControlSpec,
    /// Errors of the sensors.
    #[serde(skip_serializing_if = "SensorsSpec::is_none")]
    pub sensors: SensorsSpec,
    /// Tasks. Where tasks overlap in time, the later one in the file commands a joint.
    pub task: Vec<TaskSpec>,
    /// External forces.
    pub force: Vec<ForceSpec>,
    /// Bodies besides the robot.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub object: Vec<ObjectSpec>,
    /// Changes of parameters during the run.
    pub event: Vec<EventSpec>,
    /// Detection and avoidance of collisions of the robot with itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub self_collision: Option<SelfCollisionSpec>,
    /// The log.
    pub log: LogSpec,
    /// Rules that end a run early.
    pub stop: StopSpec,
    /// Expectations by which a run is judged.
    pub expect: Vec<Expect>,
    /// Claims about all runs of the sweep. Empty in an expanded run.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub claim: Vec<ClaimSpec>,
    /// A search, whose runs depend on the results of earlier ones. None in an expanded run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub search: Option<SearchSpec>,
    /// Sweep: many runs from one file. Empty in an expanded run.
    #[serde(skip_serializing_if = "SweepSpec::is_single")]
    pub sweep: SweepSpec,
    /// Measurement of accuracy and cost.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compare: Option<CompareSpec>,
}

impl Scenario {
    /// End of the run, s.
    pub fn end(&self) -> f64 {
        self.stop.at.map_or(self.duration, |at| at.min(self.duration))
    }
}

/// Default values of all keys; the robot's path is empty.
impl Default for Scenario {
    fn default() -> Self {
        Scenario {
            schema: FORMAT,
            description: String::new(),
            duration: 5.0,
            seed: 1,
            gravity: [0.0, 0.0, -9.81],
            robot: RobotSpec::default(),
            floor: FloorSpec::default(),
            terrain: Vec::new(),
            world: None,
            contact: ContactSpec::default(),
            integrator: IntegratorSpec::default(),
            control: ControlSpec::default(),
            sensors: SensorsSpec::default(),
            task: Vec::new(),
            force: Vec::new(),
            object: Vec::new(),
            event: Vec::new(),
            self_collision: None,
            log: LogSpec::default(),
            stop: StopSpec::default(),
            expect: Vec::new(),
            claim: Vec::new(),
            search: None,
            sweep: SweepSpec::default(),
            compare: None,
        }
    }
}

/// True when this program reads the tree's format version; otherwise nothing else is checked.
pub(super) fn check_format(root: &Node, findings: &mut Findings) -> bool {
    let Some(node) = root.get("schema") else { return true };
    match node.value {
        Value::Integer(version) if version == i64::from(FORMAT) => return true,
        Value::Integer(version) => {
            let message = format!("schema = {version} is not a file format this program reads");
            findings.error(node.span.clone(), message, Some(format!("it reads schema = {FORMAT}")));
        }
        _ => findings.error(node.span.clone(), format!("`schema` must be {FORMAT}, not {}", node.value), None),
    }
    false
}

impl Scenario {
    /// The scenario, for serializers.
    pub fn erased(&self) -> &dyn erased_serde::Serialize {
        self
    }

    /// All values, defaults included, as a text in TOML.
    ///
    /// # Errors
    /// The seed is beyond the whole numbers of TOML.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(self.erased())
    }

    /// All values, defaults included, as a table.
    ///
    /// # Errors
    /// See [`Scenario::to_toml`].
    pub fn to_table(&self) -> Result<toml::Table, toml::ser::Error> {
        toml::Table::try_from(self.erased())
    }
}

/// Reads a scenario; `None` after an error, which is among the findings.
pub(super) fn read(root: &Node) -> (Option<Scenario>, Findings) {
    let mut findings = Findings::default();
    if !check_format(root, &mut findings) {
        return (None, findings);
    }
    let default = Scenario::default();
    let mut part = Sections { root, known: vec!["schema"], findings: &mut findings };
    let scenario = Scenario {
        schema: FORMAT,
        description: part.value("description", default.description),
        duration: part.with("duration", default.duration, positive),
        seed: part.value("seed", default.seed),
        gravity: part.value("gravity", default.gravity),
        robot: part.required("robot", "model"),
        floor: part.value("floor", default.floor),
        terrain: part.tagged("terrain"),
        world: part.with("world", None, |d| WorldSpec::deserialize(d).map(Some)),
        contact: part.value("contact", default.contact),
        integrator: part.value("integrator", default.integrator),
        control: part.value("control", default.control),
        sensors: part.value("sensors", default.sensors),
        task: part.tagged("task"),
        force: part.tagged("force"),
        object: part.tagged("object"),
        event: part.list("event"),
        self_collision: part.with("self_collision", None, |d| SelfCollisionSpec::deserialize(d).map(Some)),
        log: part.value("log", default.log),
        stop: part.value("stop", default.stop),
        expect: part.list("expect"),
        claim: part.list("claim"),
        search: part.with("search", None, |d| SearchSpec::deserialize(d).map(Some)),
        sweep: part.value("sweep", default.sweep),
        compare: part.with("compare", None, |d| CompareSpec::deserialize(d).map(Some)),
    };
    part.refuse_unknown_keys();
    // Rules between values are checked only when each value is valid.
    if !findings.has_errors() {
        checks::check(&scenario, root, &mut findings);
    }
    let is_valid = !findings.has_errors();
    (is_valid.then_some(scenario), findings)
}

/// JSON Schema (draft 2020-12) of a scenario file, generated from the types that read it.
/// Descriptions give the units.
pub fn schema() -> serde_json::Value {
    let mut schema = schemars::schema_for!(Scenario).to_value();
    // The only key without a default. The type has one so that reading can continue after an error.
    if let Some(robot) = schema.pointer_mut("/properties/robot").and_then(|r| r.as_object_mut()) {
        robot.remove("default");
    }
    schema
}

/// Reads the top-level keys of a scenario and records their names.
struct Sections<'a, 'f> {
    root: &'a Node,
    known: Vec<&'static str>,
    findings: &'f mut Findings,
}

impl<'a> Sections<'a, '_> {
    fn with<T>(
        &mut self,
        key: &'static str,
        default: T,
        read: impl FnOnce(NodeDeserializer<'a>) -> Result<T, DecodeError>,
    ) -> T {
        self.known.push(key);
        let Some(node) = self.root.get(key) else { return default };
        read(NodeDeserializer(node)).unwrap_or_else(|error| {
            error.at(&node.span).report(key, self.findings);
            default
        })
    }

    fn value<T: Deserialize<'a>>(&mut self, key: &'static str, default: T) -> T {
        self.with(key, default, |d| T::deserialize(d))
    }

    fn required<T: Deserialize<'a> + Default>(&mut self, key: &'static str, example: &str) -> T {
        if self.root.get(key).is_none() {
            let help = format!("the smallest scenario is\n[{key}]\n{example} = \"...\"");
            self.findings.error(self.root.span.clone(), format!("the scenario lacks the table `[{key}]`"), Some(help));
        }
        self.value(key, T::default())
    }

    fn items(&mut self, key: &'static str) -> impl Iterator<Item = (String, &'a Node)> + use<'a> {
        self.known.push(key);
        let node = self.root.get(key);
        if let Some(node) = node
            && !matches!(node.value, Value::Array(_))
        {
            let message = format!("`{key}` must be an array of tables, not {}", node.value);
            self.findings.error(node.span.clone(), message, Some(format!("write `[[{key}]]`")));
        }
        node.map_or(&[][..], Node::items).iter().enumerate().map(move |(i, n)| (format!("{key}.{i}"), n))
    }

    fn list<T: Deserialize<'a>>(&mut self, key: &'static str) -> Vec<T> {
        let mut list = Vec::new();
        for (path, node) in self.items(key) {
            match T::deserialize(NodeDeserializer(node)) {
                Ok(value) => list.push(value),
                Err(error) => error.at(&node.span).report(&path, self.findings),
            }
        }
        list
    }

    fn tagged<T: Tagged>(&mut self, key: &'static str) -> Vec<T> {
        self.items(key).filter_map(|(path, node)| tagged::read(node, &path, self.findings)).collect()
    }

    fn refuse_unknown_keys(self) {
        for entry in self.root.entries().iter().filter(|e| !self.known.contains(&e.key.as_str())) {
            let help = suggest::help(&entry.key, self.known.iter().copied());
            self.findings.error(entry.key_span.clone(), format!("unknown key `{}`", entry.key), Some(help));
        }
    }
}
