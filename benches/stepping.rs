//! HOAP-2 (31 velocities, two soles of four vertices) stands and sways under a push. Times one
//! evaluation of the equations of motion, one step of 1 ms with each integrator, and one selection
//! of contact states.
//!
//! Unitree G1 and Talos stand and swing their arms, if EXAMPLE_ROBOT_DATA names the folder of the
//! Python package of that name. Times one fixed step of 1 ms with each contact method.

use divan::Bencher;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::slice;
use stiction::assemble;
use stiction::contact::methods::registry::{MethodDescriptor, MethodParameters};
use stiction::contact::model::problem::Tolerances;
use stiction::contact::model::solution::Solution;
use stiction::contact::model::state::{Pattern, SoleState, States};
use stiction::contact::search::judge::Rules;
use stiction::contact::search::select::{SearchOrder, SelectionInput, Selector};
use stiction::robot;
use stiction::scenario;
use stiction::sim::plant::Plant;
use stiction::sim::{NullObserver, Setup, Simulation};

const ADAPTIVE: &str = "method = \"dopri5\", max_step = 1e-3";

fn setup(method: &str, integrator: &str) -> Setup {
    let text = format!(
        "duration = 1e6
        robot = {{ model = \"robots/hoap2/hoap2.toml\" }}
        contact = {{ method = \"{method}\" }}
        integrator = {{ {integrator} }}
        [[force]]
        type = \"push\"
        link = \"torso\"
        point = [0.0, 0.0, 0.1]
        force = [2.0, 1.0, 0.0]
        duration = 1e6
        profile = \"half-sine\"\n"
    );
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    setup_of(&root.join("bench.toml"), &text)
}

pub(super) fn setup_of(path: &Path, text: &str) -> Setup {
    let file = scenario::parse(path, text).unwrap_or_else(|e| panic!("{e}"));
    let run = file.expand(&[]).expect("a single run").remove(0);
    let robot = robot::load(&run.resolve(&run.scenario.robot.model)).expect("a robot");
    assemble::setup(&run, &robot).unwrap_or_else(|e| panic!("{e}"))
}

/// A run after its initial transient.
fn swaying(method: &str, integrator: &str) -> Simulation {
    after(setup(method, integrator), 20)
}

/// A run after some steps.
pub(super) fn after(setup: Setup, steps: usize) -> Simulation {
    let mut sim = Simulation::new(setup).expect("the physics can do it");
    sim.begin(&mut NullObserver).expect("it begins");
    (0..steps).for_each(|_| sim.step(&mut NullObserver).expect("it steps"));
    sim
}

/// A robot of the package, standing on position servos.
struct Standing {
    name: &'static str,
    file: &'static str,
    /// Parts of the names of leg joints, and of arm joints.
    legs: &'static [&'static str],
    arms: &'static [&'static str],
    /// Positions by the end of the joint's name, rad: bent knees, or `half_sitting` of the SRDF.
    posture: &'static [(&'static str, f64)],
    /// Position gain of the legs: 2.5 times weight and height of the centre of mass, N m.
    gain: f64,
}

const STANDING: [Standing; 2] = [
    Standing {
        name: "g1",
        file: "g1_description/urdf/g1_29dof_rev_1_0.urdf",
        legs: &["hip", "knee", "ankle"],
        arms: &["shoulder", "elbow", "wrist"],
        posture: &[("hip_pitch_joint", -0.1), ("knee_joint", 0.3), ("ankle_pitch_joint", -0.2)],
        gain: 570.0,
    },
    Standing {
        name: "talos",
        file: "talos_data/robots/talos_reduced.urdf",
        legs: &["leg_"],
        arms: &["arm_"],
        posture: &[
            ("torso_2_joint", 0.006761),
            ("arm_left_1_joint", 0.25847),
            ("arm_left_2_joint", 0.173046),
            ("arm_left_3_joint", -0.0002),
            ("arm_left_4_joint", -0.525366),
            ("arm_left_7_joint", 0.1),
            ("arm_right_1_joint", -0.25847),
            ("arm_right_2_joint", -0.173046),
            ("arm_right_3_joint", 0.0002),
            ("arm_right_4_joint", -0.525366),
            ("arm_right_7_joint", 0.1),
            ("leg_left_3_joint", -0.411354),
            ("leg_left_4_joint", 0.859395),
            ("leg_left_5_joint", -0.448041),
            ("leg_left_6_joint", -0.001708),
            ("leg_right_3_joint", -0.411354),
            ("leg_right_4_joint", 0.859395),
            ("leg_right_5_joint", -0.448041),
            ("leg_right_6_joint", -0.001708),
        ],
        gain: 1942.0,
    },
];

/// A robot of the package with a contact method.
struct Case {
    robot: &'static Standing,
    path: PathBuf,
    method: &'static str,
}

impl std::fmt::Display for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.robot.name, self.method)
    }
}

fn standing_cases() -> Vec<Case> {
    let Some(folder) = std::env::var_os("EXAMPLE_ROBOT_DATA").map(PathBuf::from) else { return vec![] };
    let mut cases = vec![];
    for robot in &STANDING {
        let paths = [folder.join("robots").join(robot.file), folder.join(robot.file)];
        let Some(path) = paths.into_iter().find(|path| path.is_file()) else { continue };
        let methods = ["exact", "one-step", "lcp", "ncp", "penalty"];
        cases.extend(methods.map(|method| Case { robot, path: path.clone(), method }));
    }
    cases
}

/// Gains as in `scenarios/studies/hard_pushes.py`. All arm joints swing by 0.05 rad at 1 Hz.
fn standing(case: &Case) -> Setup {
    let robot = case.robot;
    let model = robot::load(&case.path).expect("a robot of the package").model;
    let (mut posture, mut drives, mut swings) = (String::new(), String::new(), String::new());
    for joint in model.joints.iter().map(|joint| joint.name.as_str()) {
        let is_one_of = |parts: &[&str]| parts.iter().any(|part| joint.contains(part));
        let position = robot.posture.iter().find(|(end, _)| joint.ends_with(end)).map_or(0.0, |(_, q)| *q);
        let kp = if is_one_of(robot.legs) { robot.gain } else { 0.3 * robot.gain };
        let (kd, armature) = (0.03 * kp, 5e-5 * kp);
        writeln!(posture, "{joint} = {position:?}").expect("to a string");
        writeln!(
            drives,
            "{joint} = {{ mode = \"position\", kp = {kp:?}, kd = {kd:?}, armature = {armature:?}, effort = 1e6 }}"
        )
        .expect("to a string");
        if is_one_of(robot.arms) {
            writeln!(swings, "{joint} = {{ amplitude = 0.05, frequency = 1.0 }}").expect("to a string");
        }
    }
    let text = format!(
        "duration = 1e6
        contact = {{ method = \"{}\" }}
        integrator = {{ method = \"semi-implicit\", step = 1e-3 }}
        control = {{ rate = 500 }}
        [robot]
        model = {:?}
        inertia = \"repair\"
        joint_limits = \"ignore\"
        [robot.posture]\n{posture}
        [robot.joint]\n{drives}
        [[task]]
        type = \"sine\"
        [task.joints]\n{swings}",
        case.method, case.path
    );
    setup_of(&case.path.with_file_name("bench.toml"), &text)
}

#[divan::bench(args = standing_cases())]
fn standing_step(bencher: Bencher, case: &Case) {
    let mut sim = after(standing(case), 1000);
    super::each(bencher, || sim.step(&mut NullObserver).is_ok());
}

/// Accelerations and contact wrenches with constant states: one evaluation by an integrator.
#[divan::bench]
fn right_hand_side(bencher: Bencher) {
    let sim = swaying("exact", ADAPTIVE);
    let problem = sim.plant().problem.clone();
    let method = (MethodDescriptor::named("exact").expect("registered").solver)(&MethodParameters::default(), &problem);
    let mut plant = Plant::new(setup("exact", ADAPTIVE).plant(), method, problem);
    plant.state.clone_from(&sim.plant().state);
    plant.states = sim.plant().states.clone();
    assert!((0..2).all(|s| plant.states[s] == SoleState::fixed(Pattern::Face)), "on both soles");
    super::each(bencher, || plant.evaluate());
}

#[divan::bench(args = [
    ("exact", ADAPTIVE),
    ("exact", "method = \"bs23\", max_step = 1e-3"),
    ("exact", "method = \"rk4\", step = 1e-3"),
    ("exact", "method = \"semi-implicit\", step = 1e-3"),
    ("penalty", "method = \"semi-implicit\", step = 1e-3"),
    ("one-step", "method = \"semi-implicit\", step = 1e-3"),
    ("lcp", "method = \"semi-implicit\", step = 1e-3"),
    ("ncp", "method = \"semi-implicit\", step = 1e-3"),
])]
fn step(bencher: Bencher, (method, integrator): (&str, &str)) {
    let mut sim = swaying(method, integrator);
    super::each(bencher, || sim.step(&mut NullObserver).is_ok());
}

/// The search for the states of both soles, starting from one foot in the air.
#[divan::bench]
fn selection_from_a_changed_state(bencher: Bencher) {
    let sim = swaying("exact", ADAPTIVE);
    let mut p = sim.plant().problem.clone();
    let (mut selector, mut out) = (Selector::new(SearchOrder::Direct, &p), Solution::new(&p));
    let mut start = States::default();
    start[0] = SoleState::fixed(Pattern::Face);
    let rules = Rules::new(Tolerances::default(), start.clone());
    let input = SelectionInput { rules: &rules, event: true, allowed: &|_, _| true, cancel: None };
    super::each(bencher, || selector.select(&mut p, slice::from_ref(&start), &input, &mut out).tested);
}
