//! A run ends as `fallen` when a link that does not touch the floor has sunk through it.

use super::body::G;
use crate::support::runs::{root, run, simulation};
use nalgebra::{Matrix3, Vector3};
use std::sync::atomic::AtomicBool;
use stiction::dynamics::{State, Workspace, kinematics};
use stiction::robot::{self, Base, LinkId, Model};
use stiction::sim::floor::SunkLinks;
use stiction::sim::{Floor, Metrics, NullObserver, Outcome};

fn end(text: &str) -> (Outcome, String, Metrics) {
    let mut sim = simulation(text);
    let (outcome, message) = sim.run(&mut NullObserver, &AtomicBool::new(false));
    (outcome, message, sim.metrics().clone())
}

/// The block falls with its sole up, so that its other face is the first to reach the floor: after
/// sqrt(2 h / g), and a millimetre deeper 0.8 ms later. The run ends at the end of that step.
#[test]
fn an_inverted_block_ends_when_it_is_a_millimetre_below_the_floor() {
    let step = 1e-4;
    let text = format!(
        "duration = 1.0
        integrator = {{ method = \"rk4\", step = {step} }}
        robot = {{ model = \"robots/block/block.toml\", contact = \"soles\", base = {{ position = [0, 0, 0.15], rpy = [\"180 deg\", 0, 0] }} }}\n"
    );
    let (outcome, message, m) = end(&text);
    assert_eq!(outcome, Outcome::Fallen, "{message}");
    assert!(message.contains("link `block` 0.001") && message.contains("only soles touch the floor"), "{message}");
    let expected = (2.0 * 0.101 / G).sqrt();
    assert!((0.0..=step).contains(&(m.duration_s - expected)), "{} {expected}", m.duration_s);
    assert_eq!(m.first_fall_s, Some(m.duration_s));

    // Without the rule it falls on to its sole, which lands at the end of another 0.1 m.
    let (outcome, _, m) = end(&format!("{text}stop = {{ sunk_link = \"ignore\" }}\n"));
    assert_eq!(outcome, Outcome::Passed);
    assert_eq!((m.first_fall_s, m.duration_s), (None, 1.0));
}

/// On its sole, on an edge and on a corner the block is not below the floor, also if the sole is half as
/// long as its lower face, whose corners are then up to 4 cm deep.
#[test]
fn tilted_blocks_on_their_soles_continue() {
    let small = "soles = [{ name = \"small\", link = \"block\", polygon = [[0.05, 0.05, -0.05], [-0.05, 0.05, -0.05], [-0.05, -0.05, -0.05], [0.05, -0.05, -0.05]] }]";
    for rpy in ["[0, 0, 0]", "[0, \"30 deg\", 0]", "[\"25 deg\", \"-30 deg\", 0]"] {
        for soles in ["", small] {
            let m = run(&format!(
                "duration = 0.5\n[robot]\nmodel = \"robots/block/block.toml\"\ncontact = \"soles\"\nbase = {{ rpy = {rpy} }}\n{soles}\n"
            ));
            assert_eq!(m.duration_s, 0.5, "{rpy} {soles}");
        }
    }
}

/// A push of 60 N for 0.3 s throws HOAP-2 down: the run ends when an arm or the torso reaches the
/// floor. Without the rule its base ends below the floor.
#[test]
fn a_pushed_humanoid_ends_when_a_link_reaches_the_floor() {
    let text = "duration = 3.0
        robot = { model = \"robots/hoap2/hoap2.toml\", contact = \"soles\" }
        force = [{ type = \"push\", link = \"torso\", force = [60, 0, 0], start = 0.1, duration = 0.3 }]\n";
    let (outcome, message, m) = end(text);
    assert_eq!(outcome, Outcome::Fallen, "{message}");
    assert!(m.final_base_position[2] > 0.0, "{:?}", m.final_base_position);
    let (outcome, _, m) = end(&format!("{text}stop = {{ sunk_link = \"ignore\" }}\n"));
    assert_eq!(outcome, Outcome::Passed);
    assert!(m.final_base_position[2] < -0.1, "{:?}", m.final_base_position);
}

/// The floor has no meaning for a robot without soles, and a fixed base cannot fall.
#[test]
fn robots_without_soles_and_fixed_ones_continue() {
    let text = "duration = 0.1\nrobot = { model = \"robots/block/block.toml\", contact = \"soles\", base = { position = [0, 0, -1] }, soles = [] }\n";
    assert_eq!(end(text).0, Outcome::Passed);

    let block = robot::load(&root().join("robots/block/block.toml")).unwrap().model;
    let floor = Floor {
        rotation: Matrix3::identity(),
        point: Vector3::z(),
        mu_s: 0.8,
        mu_k: 0.6,
        extra: Default::default(),
        patches: Vec::new(),
        is_absent: false,
    };
    let depth = |model: &Model| {
        let mut ws = Workspace::new(model);
        kinematics::update(model, &State::home(model), &mut ws);
        SunkLinks::new(model).deepest(&ws, &floor)
    };
    // Its upper face is 0.05 m above the origin; the sole and what is near it do not count.
    let (link, sunk) = depth(&block).expect("1 m below the floor");
    assert!(link == LinkId(0) && (sunk - 0.95).abs() < 1e-15, "{sunk}");
    assert_eq!(depth(&Model { base: Base::Fixed, ..block.clone() }), None);
}
