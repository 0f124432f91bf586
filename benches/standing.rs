//! Robots of `standing.toml`, standing on position servos: HOAP-2, and Unitree G1 and Talos if EXAMPLE_ROBOT_DATA
//! names the folder of the Python package example-robot-data.

use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use stiction::assemble;
use stiction::robot;
use stiction::scenario;
use stiction::sim::{NullObserver, Setup, Simulation};

#[derive(Clone, Debug, Deserialize)]
pub struct Standing {
    pub name: String,
    /// As in the file, then with its folder.
    pub file: PathBuf,
    legs: Vec<String>,
    arms: Vec<String>,
    /// Position gain of the legs, N m/rad.
    gain: f64,
    posture: BTreeMap<String, f64>,
    sole: Vec<toml::Table>,
}

/// The robots whose files are there.
pub fn robots() -> Vec<Standing> {
    #[derive(Deserialize)]
    struct File {
        robot: Vec<Standing>,
    }
    let own = crate::repository().join("robots");
    let package = std::env::var_os("EXAMPLE_ROBOT_DATA").map(PathBuf::from);
    let folders: Vec<PathBuf> = package.into_iter().flat_map(|at| [at.join("robots"), at]).chain([own]).collect();
    let File { robot } = toml::from_str(include_str!("standing.toml")).expect("a list of robots");
    let find = |robot: Standing| {
        let file = folders.iter().map(|folder| folder.join(&robot.file)).find(|path| path.is_file())?;
        Some(Standing { file, ..robot })
    };
    robot.into_iter().filter_map(find).collect()
}

/// A servo of each joint.
pub enum Servos {
    /// As in `scenarios/studies/hard_pushes.py`: by weight, weaker above the legs.
    ByWeight,
    /// The same for all joints.
    Equal { kp: f64, kd: f64, armature: f64 },
}

impl Standing {
    /// A run without an end; with `swings` all arm joints swing by 0.05 rad at 1 Hz. `keys` are those of the
    /// scenario but for `robot` and `task`.
    pub fn setup(&self, keys: &str, servos: &Servos, swings: bool) -> Setup {
        let model = robot::load(&self.file).unwrap_or_else(|e| panic!("{e}")).model;
        let (mut posture, mut drives, mut swinging) = (String::new(), String::new(), String::new());
        for joint in model.joints.iter().map(|joint| joint.name.as_str()) {
            let is_one_of = |parts: &[String]| parts.iter().any(|part| joint.contains(part.as_str()));
            let position = self.posture.iter().find(|(end, _)| joint.ends_with(end.as_str())).map_or(0.0, |(_, q)| *q);
            let (kp, kd, armature) = match *servos {
                Servos::Equal { kp, kd, armature } => (kp, kd, armature),
                Servos::ByWeight => {
                    let kp = if is_one_of(&self.legs) { self.gain } else { 0.3 * self.gain };
                    (kp, 0.03 * kp, 5e-5 * kp)
                }
            };
            writeln!(posture, "{joint} = {position:?}").expect("to a string");
            writeln!(
                drives,
                "{joint} = {{ mode = \"position\", kp = {kp:?}, kd = {kd:?}, armature = {armature:?}, effort = 1e6, \
                 friction = {{ coulomb = 0.0, viscous = 0.0 }} }}"
            )
            .expect("to a string");
            if is_one_of(&self.arms) {
                writeln!(swinging, "{joint} = {{ amplitude = 0.05, frequency = 1.0 }}").expect("to a string");
            }
        }
        let task = if swings { format!("[[task]]\ntype = \"sine\"\n[task.joints]\n{swinging}") } else { String::new() };
        let mut text = format!(
            "duration = 1e6
            {keys}
            [robot]
            model = {:?}
            contact = \"soles\"
            inertia = \"repair\"
            joint_limits = \"ignore\"
            [robot.posture]\n{posture}
            [robot.joint]\n{drives}",
            self.file
        );
        for sole in &self.sole {
            write!(text, "[[robot.soles]]\n{sole}").expect("to a string");
        }
        parsed(&self.file.with_file_name("bench.toml"), &(text + &task))
    }
}

/// The only run of a scenario.
pub fn parsed(path: &Path, text: &str) -> Setup {
    let file = scenario::parse(path, text).unwrap_or_else(|e| panic!("{e}"));
    let run = file.expand(&[]).expect("a single run").remove(0);
    let robot = robot::load(&run.resolve(&run.scenario.robot.model)).expect("a robot");
    assemble::setup(&run, &robot).unwrap_or_else(|e| panic!("{e}"))
}

/// A run after some steps.
pub fn after(setup: Setup, steps: usize) -> Simulation {
    let mut sim = Simulation::new(setup).expect("the physics can do it");
    sim.begin(&mut NullObserver).expect("it begins");
    (0..steps).for_each(|_| sim.step(&mut NullObserver).expect("it steps"));
    sim
}
