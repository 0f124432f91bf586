//! HOAP-2 (31 velocities, two soles of four vertices) stands and sways under a push. Times one
//! evaluation of the equations of motion, one step of 1 ms with each integrator, and one selection
//! of contact states.
//!
//! The robots of `standing.toml` stand and swing their arms. Times one fixed step of 1 ms with each
//! contact method.

use super::standing::{self, Servos, Standing, after, parsed};
use divan::Bencher;
use std::slice;
use stiction::contact::methods::registry::{MethodDescriptor, MethodParameters};
use stiction::contact::model::problem::Tolerances;
use stiction::contact::model::solution::Solution;
use stiction::contact::model::state::{Pattern, SoleState, States};
use stiction::contact::search::judge::Rules;
use stiction::contact::search::select::{SearchOrder, SelectionInput, Selector};
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
    let root = crate::repository();
    parsed(&root.join("bench.toml"), &text)
}

/// A run after its initial transient.
fn swaying(method: &str, integrator: &str) -> Simulation {
    after(setup(method, integrator), 20)
}

/// A robot with a contact method.
struct Case {
    robot: Standing,
    method: &'static str,
}

impl std::fmt::Display for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.robot.name, self.method)
    }
}

fn standing_cases() -> Vec<Case> {
    let methods = ["exact", "one-step", "lcp", "ncp", "penalty"];
    let cases = |robot: Standing| methods.map(|method| Case { robot: robot.clone(), method });
    standing::robots().into_iter().flat_map(cases).collect()
}

#[divan::bench(args = standing_cases())]
fn standing_step(bencher: Bencher, case: &Case) {
    let keys = format!(
        "contact = {{ method = \"{}\" }}
        integrator = {{ method = \"semi-implicit\", step = 1e-3 }}
        control = {{ rate = 500 }}",
        case.method
    );
    let mut sim = after(case.robot.setup(&keys, &Servos::ByWeight, true), 1000);
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
