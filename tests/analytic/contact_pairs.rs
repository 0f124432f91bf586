//! Rules for pairs of bodies, and links of a robot that touch each other, by closed forms.

use super::body::G;
use super::several_contacts::write_gripper;
use crate::support::runs::{Recording, finish, root, simulation, watch};
use stiction::sim::{Metrics, NullObserver, Simulation};

const TIGHT: &str = "integrator = { relative_tolerance = 1e-10, absolute_tolerance = 1e-12 }
    log = { rate = 0 }\n";

const CLOSE: &str = "distance_tolerance = 1e-8, velocity_tolerance = 1e-8, acceleration_tolerance = 1e-8";

fn finished(scenario: &str) -> (Simulation, Metrics) {
    let mut sim = simulation(&format!("{TIGHT}{scenario}"));
    let metrics = finish(&mut sim, &mut NullObserver);
    (sim, metrics)
}

fn way(mu: f64) -> f64 {
    1.0 / (2.0 * mu * G)
}

/// Two boxes and the sole of a block slide at 1 m/s over floor and terrain, each with the friction of its
/// rule: v^2 / (2 mu g) until rest. The last rule that applies counts.
#[test]
fn rules_set_the_friction_of_pairs() {
    let (sim, m) = finished(
        "duration = 2.0
        floor.friction = 0.9
        terrain = [{ type = \"box\", name = \"table\", size = [4, 1, 0.1], position = [0, 3, 0.05] }]
        robot = { model = \"robots/block/block.toml\", base = { position = [0, 0, 0.05], linear_velocity = [1, 0, 0] } }
        object = [
            { type = \"box\", name = \"red\", size = [0.2, 0.2, 0.1], mass = 1.0, position = [0, 1, 0.05], linear_velocity = [1, 0, 0] },
            { type = \"box\", name = \"blue\", size = [0.2, 0.2, 0.1], mass = 1.0, position = [0, 3, 0.15], linear_velocity = [1, 0, 0] },
        ]
        [contact]
        distance_tolerance = 1e-8\nvelocity_tolerance = 1e-8\nacceleration_tolerance = 1e-8
        pair = [
            { bodies = [\"bottom\", \"floor\"], friction = 0.2 },
            { bodies = [\"*\", \"table\"], friction = 0.5 },
            { bodies = [\"floor\", \"r*\"], friction = 0.1 },
            { bodies = [\"red\", \"fl??r\"], friction = 0.3 },
        ]"
    );
    let x = |o: usize| sim.plant().objects.list[o].state.position.x;
    let found = [m.final_base_position[0], x(0), x(1)];
    let expected = [way(0.2), way(0.3), way(0.5)];
    assert!(found.iter().zip(expected).all(|(x, way)| (x - way).abs() < 1e-9), "{found:?} {expected:?}");
    assert!(m.inconsistent == 0 && m.energy_error_j.abs() < 1e-9, "{m:?}");
}

/// A ball that touches neither table nor block falls through them onto the floor.
#[test]
fn bodies_that_do_not_touch_pass_through_each_other() {
    let (sim, m) = finished(&format!(
        "duration = 1.0
        terrain = [{{ type = \"box\", name = \"table\", size = [1, 1, 0.1], position = [0, 0, 0.25] }}]
        robot = {{ model = \"robots/block/block.toml\", contact = \"soles\", base = {{ position = [0, 0, 0.35] }} }}
        object = [{{ type = \"sphere\", name = \"ghost\", radius = 0.02, mass = 1.0, position = [0, 0, 0.5] }}]
        contact = {{ {CLOSE}, pair = [{{ bodies = [\"ghost\", \"table\"], touch = false }}, {{ bodies = [\"bottom\", \"ghost\"], touch = false }}] }}"
    ));
    assert!((sim.plant().objects.list[0].state.position.z - 0.02).abs() < 1e-9);
    // The block stays on the table, the ball loses m g h on the floor.
    assert!((m.final_base_position[2] - 0.35).abs() < 1e-9, "{:?}", m.final_base_position);
    assert!((m.impact_loss_j - 0.48 * G).abs() < 1e-9, "{}", m.impact_loss_j);
}

/// Two fingers of 0.5 kg are pressed towards each other by 14 N and meet half way, 0.05 m, without rebound.
#[test]
fn fingers_of_a_robot_meet() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = folder.path().join("gripper.urdf");
    write_gripper(&urdf);
    let run = |more: &str| {
        finished(&format!(
            "duration = 0.5
            floor.plane = false
            contact = {{ {CLOSE} }}
            robot = {{ model = {urdf:?}, contact = \"bodies\", {more}joint_default = {{ mode = \"passive\" }} }}
            force = [
                {{ type = \"constant\", link = \"left\", force = [14, 0, 0] }},
                {{ type = \"constant\", link = \"right\", force = [-14, 0, 0] }},
            ]"
        ))
    };
    let (sim, m) = run("self_contact = true, ");
    assert!((m.first_touchdown_s.unwrap() - (2.0 * 0.05 / 28.0f64).sqrt()).abs() < 1e-9, "{:?}", m.first_touchdown_s);
    let joints = &sim.plant().state.joints;
    assert!((joints[0] - 0.05).abs() < 1e-9 && (joints[1] + 0.05).abs() < 1e-9, "{joints:?}");
    assert!((m.impact_loss_j - 2.0 * 14.0 * 0.05).abs() < 1e-9, "{}", m.impact_loss_j);
    let patch = sim.plant().pair_patches().next().unwrap();
    assert_eq!((patch.name.as_str(), patch.len()), ("left on right", 4));
    let n: f64 = sim.plant().solution.normal.iter().flatten().sum();
    assert!((n - 14.0).abs() < 1e-9, "{n}");
    assert!(m.inconsistent == 0 && m.energy_error_j.abs() < 1e-9 && m.max_penetration_m < 1e-9, "{m:?}");
    // Without self-contact they pass each other.
    let (sim, _) = run("");
    assert!(sim.plant().state.joints[0] > 0.1);
}

/// The feet of a humanoid swing together without gravity: they hit each other, which changes neither the
/// momentum of the whole nor adds energy. Without self-contact they pass.
#[test]
fn feet_of_a_humanoid_hit_each_other() {
    let run = |more: &str| {
        watch(&format!(
            "duration = 0.1
            gravity = [0, 0, 0]
            floor.plane = false
            robot = {{ model = \"robots/hoap2/hoap2.toml\", contact = \"bodies\", {more}joint_default = {{ mode = \"passive\" }}, velocity = {{ left_hip_roll = -4, right_hip_roll = 4 }} }}
            integrator = {{ relative_tolerance = 1e-9, absolute_tolerance = 1e-11 }}
            log.rate = 0\n"
        ))
    };
    let touches = |recording: &Recording| {
        recording.events.iter().any(|e| e.kind == "touchdown" && e.subject == "l_foot on r_foot")
    };
    let ((m, recording), (free, other)) = (run("self_contact = true, "), run(""));
    assert!(touches(&recording) && !touches(&other), "{:?}", recording.events);
    assert!(m.impacts > 0 && m.impact_loss_j > 1e-3, "{m:?}");
    let apart = m.final_com_velocity.iter().zip(free.final_com_velocity).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f64::max) < 1e-9, "{:?} {:?}", m.final_com_velocity, free.final_com_velocity);
    // The tolerances of the integrator.
    assert!(m.inconsistent == 0 && m.energy_error_j.abs() < 1e-7 && m.max_penetration_m < 1e-8, "{m:?}");
}

#[test]
fn names_that_no_body_has_are_errors() {
    let error = |pair: &str| {
        let text = format!(
            "terrain = [{{ type = \"box\", name = \"table\", size = [1, 1, 0.1], position = [0, 0, 0.25] }}]
            robot = {{ model = \"robots/block/block.toml\", contact = \"soles\", base = {{ position = [0, 0, 0.35] }} }}
            contact = {{ pair = [{pair}] }}"
        );
        let file = stiction::scenario::parse(&root().join("test.toml"), text).unwrap();
        let run = file.expand(&[]).unwrap().remove(0);
        let robot = stiction::robot::load(&run.resolve(&run.scenario.robot.model)).unwrap();
        stiction::assemble::setup(&run, &robot).err().map(|e| e.to_string()).unwrap_or_default()
    };
    let unknown = error("{ bodies = [\"bottom\", \"tabel\"], friction = 0.2 }");
    assert!(unknown.contains("test.toml:3:") && unknown.contains("is called `tabel`"), "{unknown}");
    assert!(unknown.contains("did you mean `table`?"), "{unknown}");
    let floor = error("{ bodies = [\"*\", \"floor\"], touch = false }");
    assert!(floor.contains("soles and links of the robot always touch the floor"), "{floor}");
    assert_eq!(error("{ bodies = [\"b*\", \"table\"], touch = false }"), "");
    // Soles touch, not their link.
    let link = error("{ bodies = [\"block\", \"table\"], friction = 0.2 }");
    assert!(link.contains("is called `block`"), "{link}");
}
