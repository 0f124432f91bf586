//! Defaults of a scenario, and preservation of its given values.

use std::path::Path;

use stiction::contact::methods::penalty::PenaltyParameters;
use stiction::scenario::{
    Estimator, EventHandling, ForceFrame, ForceSpec, Friction, IntegratorMethod, JointLimits, JointMode, LogTopic,
    Profile, TaskSpec,
};

use super::{FULL, SMALLEST, file, runs};

#[test]
fn the_smallest_scenario_has_the_documented_defaults() {
    let runs = runs(SMALLEST);
    assert_eq!(runs.len(), 1);
    assert!(runs[0].parameters.is_empty());
    let s = &runs[0].scenario;
    assert_eq!((s.schema, s.duration, s.seed, s.gravity), (1, 5.0, 1, [0.0, 0.0, -9.81]));
    assert_eq!(s.description, "");

    let robot = &s.robot;
    assert_eq!(robot.model, "block.urdf");
    assert_eq!(robot.base.position, None);
    assert_eq!(
        (robot.base.rpy, robot.base.linear_velocity, robot.base.angular_velocity),
        ([0.0; 3], [0.0; 3], [0.0; 3])
    );
    assert_eq!(robot.joint_default.mode, JointMode::Position);
    assert_eq!((robot.joint_default.kp, robot.joint_default.kd), (100.0, 5.0));
    assert_eq!(robot.joint_limits, JointLimits::Stop);
    assert_eq!(robot.soles, None);
    assert!(
        robot.posture.is_empty() && robot.velocity.is_empty() && robot.payload.is_empty() && robot.joint.is_empty()
    );

    assert_eq!(s.floor.friction, Friction::coulomb(0.8, 0.6));
    assert_eq!((s.floor.height, s.floor.rpy), (0.0, [0.0; 3]));
    assert!(s.floor.plane && s.terrain.is_empty());
    assert!(
        !runs[0].resolved_toml.contains("plane") && !runs[0].resolved_toml.contains("terrain"),
        "keys of runs stay"
    );

    let c = &s.contact;
    assert_eq!(c.method.name(), "exact");
    assert_eq!((c.distance_tolerance, c.velocity_tolerance, c.acceleration_tolerance), (1e-3, 0.1, 0.1));
    assert_eq!((c.restitution, c.events), (0.0, EventHandling::Locate));
    assert!(c.forced.is_empty());
    let springs = (c.penalty.stiffness, c.penalty.damping, c.penalty.slip_velocity);
    let defaults = PenaltyParameters::default();
    assert_eq!(springs, (1e5, 300.0, 1e-3));
    assert_eq!(springs, (defaults.stiffness, defaults.damping, defaults.slip_velocity));

    let i = &s.integrator;
    assert_eq!(i.method, IntegratorMethod::Dopri5);
    assert_eq!((i.relative_tolerance, i.absolute_tolerance, i.max_step, i.step), (1e-6, 1e-8, 0.01, 1e-3));

    assert_eq!((s.control.rate, s.control.estimator), (1000.0, Estimator::Truth));
    assert_eq!(s.log.rate, 200.0);
    assert_eq!(s.log.topics, [LogTopic::State, LogTopic::Contact, LogTopic::Scene]);
    assert_eq!(s.stop.fallen, None);
    assert!(s.task.is_empty() && s.force.is_empty() && s.event.is_empty() && s.expect.is_empty());
    assert!(s.self_collision.is_none() && s.compare.is_none() && s.sweep.is_single());
}

#[test]
fn entries_have_defaults_too() {
    let text = format!(
        "{SMALLEST}
[[task]]
type = \"posture\"
joints = {{ knee = 1 }}
[[force]]
type = \"push\"
link = \"torso\"
force = [1, 2, 3]
[[force]]
type = \"constant\"
link = \"torso\"
moment = [0, 0, 1]
[[force]]
type = \"joint-friction\"
all = {{ viscous = 2 }}
joints = {{ knee = {{ coulomb = 1 }} }}
"
    );
    let s = runs(&text).remove(0).scenario;
    let TaskSpec::Posture(posture) = &s.task[0] else { panic!("{:?}", s.task[0]) };
    assert_eq!((posture.start, posture.duration, posture.joints["knee"]), (0.0, 1.0, 1.0));
    let ForceSpec::Push(push) = &s.force[0] else { panic!("{:?}", s.force[0]) };
    assert_eq!((push.point, push.force, push.moment), ([0.0; 3], [1.0, 2.0, 3.0], [0.0; 3]));
    assert_eq!((push.start, push.duration), (0.0, 0.1));
    assert_eq!((push.frame, push.profile), (ForceFrame::World, Profile::Constant));
    let ForceSpec::Constant(constant) = &s.force[1] else { panic!("{:?}", s.force[1]) };
    assert_eq!((constant.start, constant.duration, constant.moment), (0.0, None, [0.0, 0.0, 1.0]));
    let ForceSpec::JointFriction(friction) = &s.force[2] else { panic!("{:?}", s.force[2]) };
    let of = |joint| friction.friction_of(joint).map(|f| (f.coulomb, f.viscous));
    assert_eq!((of("knee"), of("hip")), (Some((1.0, 0.0)), Some((0.0, 2.0))));
}

#[test]
fn the_full_example_is_read() {
    let s = runs(FULL).remove(0).scenario;
    assert_eq!(s.description, "Push recovery on a slippery floor");
    // One rounding in the conversion to radians.
    assert!((s.robot.base.rpy[1] - std::f64::consts::FRAC_PI_6).abs() < 1e-15);
    assert!((s.robot.base.angular_velocity[2] - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    assert_eq!(s.robot.base.position, Some([0.0, 0.0, 0.4]));
    assert_eq!(s.robot.soles.as_ref().unwrap()[0].polygon.len(), 4);
    assert_eq!(s.robot.joint["left_knee"].friction.unwrap().coulomb, 0.1);
    assert_eq!(s.robot.joint["left_knee"].effort, Some(3.0));
    assert_eq!(s.contact.forced[0].to, Some(0.5));
    assert_eq!((s.task.len(), s.force.len(), s.expect.len()), (11, 12, 3));
    let ForceSpec::Push(push) = &s.force[0] else { panic!("{:?}", s.force[0]) };
    assert_eq!((push.profile, push.start), (Profile::HalfSine, 2.0));
    assert_eq!(s.stop.fallen.unwrap().below, 0.2);
}

#[test]
fn one_number_is_both_frictions_and_no_soles_is_not_all_soles() {
    let s = runs(&format!("{SMALLEST}soles = []\n[floor]\nfriction = 1\n")).remove(0).scenario;
    assert_eq!(s.floor.friction, Friction::coulomb(1.0, 1.0));
    assert_eq!(s.robot.soles, Some(vec![]));
}

#[test]
fn a_resolved_scenario_reads_back_unchanged() {
    for text in [SMALLEST, FULL] {
        for run in runs(text) {
            let again = runs(&run.resolved_toml).remove(0);
            assert_eq!(again.scenario, run.scenario);
            assert_eq!(again.resolved_toml, run.resolved_toml);
        }
    }
}

#[test]
fn the_resolved_text_does_not_depend_on_the_notation() {
    let a = runs("[robot]\nmodel = \"b\"\nposture = { b = 1, a = 2 }\n[floor]\nfriction = 0.5\n");
    let b = runs(
        "# x\nfloor = { height = 0, friction = { kinetic = 0.5, static = 5e-1 } }\n[robot.posture]\na = 2.0\nb = 1.0\n[robot]\nmodel = 'b'\n",
    );
    assert_eq!(a[0].resolved_toml, b[0].resolved_toml);
}

#[test]
fn paths_are_relative_to_the_scenario_file() {
    let file = file(FULL).unwrap();
    assert_eq!(file.name(), "test");
    assert_eq!(file.resolve("../robots/a.toml"), Path::new("scenarios/../robots/a.toml"));
    assert_eq!(file.resolve("/robots/a.toml"), Path::new("/robots/a.toml"));
    let run = file.expand(&[]).unwrap().remove(0);
    assert_eq!(run.resolve(&run.scenario.robot.model), Path::new("scenarios/../robots/hoap2/hoap2.toml"));
    assert_eq!(run.name, "test");
}

#[test]
fn entries_that_start_after_the_end_give_a_warning() {
    let runs = runs(&format!(
        "duration = 1\n{SMALLEST}[[force]]\ntype = \"push\"\nlink = \"l\"\nforce = [1, 0, 0]\nstart = 2\n[sweep]\nrepeat = 2\n"
    ));
    assert_eq!(runs[0].warnings.len(), 1);
    assert!(!runs[0].warnings.has_errors());
    assert_eq!(runs[0].warnings.0[0].location(), "scenarios/test.toml:8:9");
    assert!(runs[1].warnings.is_empty(), "reported once");
}
