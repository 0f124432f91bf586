//! The stepping loop allocates nothing after the first step.

use crate::support::counting::count;
use crate::support::runs::simulation;
use stiction::sim::NullObserver;

/// HOAP-2 stands and sways under a push; no event falls into the counted steps.
fn pushed(method: &str, integrator: &str, drives: &str) -> String {
    format!(
        "duration = 100.0
        robot.model = \"robots/hoap2/hoap2.toml\"
        contact = {{ method = \"{method}\" }}
        integrator = {{ {integrator} }}
        log = {{ rate = 0.0 }}
        [[force]]
        type = \"push\"
        link = \"torso\"
        point = [0.0, 0.0, 0.1]
        force = [2.0, 1.0, 0.0]
        start = 0.0
        duration = 50.0
        profile = \"half-sine\"
        {drives}\n"
    )
}

/// A kinematic head in motion, and joints with lag, speed limit and friction.
const DRIVES: &str = "
    [robot.joint]
    head_pan = { mode = \"kinematic\" }
    left_knee = { lag = 0.01 }
    right_knee = { velocity = 1e-3 }
    waist_pitch = { friction = { coulomb = 0.01, static = 0.02 } }
    [[task]]
    type = \"posture\"
    duration = 50.0
    joints = { head_pan = 0.5 }
";

#[test]
fn stepping_allocates_nothing() {
    for drives in ["", DRIVES] {
        without_allocations(drives);
    }
}

fn without_allocations(drives: &str) {
    for (method, integrator) in [
        ("exact", "method = \"dopri5\""),
        ("exact", "method = \"bs23\""),
        ("exact", "method = \"rosenbrock\""),
        ("exact", "method = \"bdf\""),
        ("exact", "method = \"auto\""),
        ("one-step", "method = \"rosenbrock\""),
        ("penalty", "method = \"rosenbrock\""),
        ("penalty", "method = \"bdf\""),
        ("exact", "method = \"rk4\", step = 1e-3"),
        ("exact", "method = \"semi-implicit\", step = 1e-3"),
        ("one-step", "method = \"dopri5\""),
        ("one-step", "method = \"semi-implicit\", step = 1e-3"),
        ("lcp", "method = \"semi-implicit\", step = 1e-3"),
        ("ncp", "method = \"semi-implicit\", step = 1e-3"),
        ("penalty", "method = \"dopri5\""),
        ("penalty", "method = \"semi-implicit\", step = 1e-3"),
    ] {
        let mut sim = simulation(&pushed(method, integrator, drives));
        sim.begin(&mut NullObserver).expect("it begins");
        // The first step may allocate its lists.
        sim.step(&mut NullObserver).expect("it steps");
        let before = sim.metrics().state_changes;
        let allocations = count(|| (0..200).for_each(|_| sim.step(&mut NullObserver).expect("it steps")));
        assert_eq!(sim.metrics().state_changes, before, "no event in the window");
        assert!(sim.plant().state.v.iter().any(|v| v.abs() > 1e-6), "it moves");
        assert_eq!(allocations, 0, "{method} {integrator} {drives}");
    }
}

/// Motors of an ankle at their limits, with friction and rotors.
#[test]
fn coupled_motors_allocate_nothing() {
    for integrator in [
        "method = \"dopri5\"",
        "method = \"rosenbrock\"",
        "method = \"bdf\"",
        "method = \"semi-implicit\", step = 1e-3",
    ] {
        let mut sim = simulation(&format!(
            "duration = 100.0
            integrator = {{ {integrator} }}
            floor.plane = false
            gravity = [0, 0, 0]
            log.rate = 0
            robot = {{ model = \"robots/differential/differential.toml\" }}
            task = [{{ type = \"posture\", duration = 0.1, joints = {{ pitch = 0.6, roll = 0.3 }} }}]\n"
        ));
        sim.begin(&mut NullObserver).expect("it begins");
        // The first steps may allocate lists.
        (0..5).for_each(|_| sim.step(&mut NullObserver).expect("it steps"));
        let mut limited = 0;
        let allocations = count(|| {
            // Until the task ends, an event with a text.
            while sim.plant().state.time < 0.09 {
                sim.step(&mut NullObserver).expect("it steps");
                limited += usize::from(sim.plant().drives.coupled[0].is_limited);
            }
        });
        assert!(limited > 0, "{integrator}: no limit acts");
        assert_eq!(allocations, 0, "{integrator}");
    }
}

#[test]
fn forces_allocate_nothing() {
    let more = "
        [[force]]
        type = \"spring\"
        link = \"torso\"
        stiffness = 20.0
        damping = 1.0
        anchor = { waypoints = [{ at = 0, position = [0, 0, 0.3] }, { at = 40, position = [0.01, 0, 0.3] }] }
        [[force]]
        type = \"drag\"
        linear = 0.1
        quadratic = 0.1
        [[force]]
        type = \"random-pushes\"
        links = [\"torso\"]
        number = 1000
        magnitude = [0.1, 0.2]
        [[force]]
        type = \"carried-object\"
        link = \"torso\"
        mass = 0.1\n";
    let mut sim = simulation(&format!("{}{more}", pushed("exact", "method = \"dopri5\"", "")));
    sim.begin(&mut NullObserver).expect("it begins");
    sim.step(&mut NullObserver).expect("it steps");
    // Reporting a push allocates its message: count the steps in which none begins.
    let quiet = (0..200).filter(|_| count(|| sim.step(&mut NullObserver).expect("it steps")) == 0).count();
    assert!(quiet > 150, "{quiet} of 200 steps");
}

/// Objects with joints, servos, forces and contacts.
#[test]
fn objects_allocate_nothing() {
    for integrator in
        ["method = \"dopri5\"", "method = \"rk4\", step = 1e-3", "method = \"semi-implicit\", step = 1e-3"]
    {
        let method = if integrator.starts_with("method = \"semi") { "one-step" } else { "exact" };
        let mut sim = simulation(&format!(
            "duration = 10.0
            robot = {{ model = \"robots/ground/ground.urdf\" }}
            integrator = {{ {integrator} }}
            contact = {{ method = \"{method}\" }}
            log = {{ rate = 0 }}
            floor = {{ friction = 0.5, patches = [{{ polygon = [[2, -9], [9, -9], [9, 9], [2, 9]], friction = 0.2 }}] }}
            [[object]]
            type = \"model\"
            name = \"swing\"
            model = \"robots/pendulum/pendulum.urdf\"
            posture = {{ shoulder = 1.0 }}
            servo = [{{ joints = \"elbow\", stiffness = 5, damping = 0.5 }}]
            [[object]]
            type = \"box\"
            name = \"box\"
            size = [0.2, 0.2, 0.1]
            mass = 1
            position = [-3, 2, 0.05]
            linear_velocity = [6, 0, 0]
            [[force]]
            type = \"spring\"
            object = \"swing\"
            link = \"lower\"
            stiffness = 3
            damping = 0.1
            [[force]]
            type = \"drag\"
            object = \"swing\"
            linear = 0.1
            [[force]]
            type = \"joint-friction\"
            object = \"swing\"
            all = {{ viscous = 0.01 }}
            [[force]]
            type = \"constant\"
            object = \"box\"
            force = [3, 0, 0]\n"
        ));
        sim.begin(&mut NullObserver).expect("it begins");
        // The first steps may allocate their lists.
        (0..3).for_each(|_| sim.step(&mut NullObserver).expect("it steps"));
        let allocations = count(|| (0..100).for_each(|_| sim.step(&mut NullObserver).expect("it steps")));
        let plant = sim.plant();
        assert!(plant.polygons.len() == 1 && plant.objects.list[1].state.v[0] > 1.0, "the box slides");
        assert_eq!(allocations, 0, "{integrator}");
    }
}

/// More polygons than are stored inline: twenty boxes on each other at rest, and twenty that slide side by side.
#[test]
fn twenty_boxes_allocate_nothing() {
    let stacked = |i: usize| format!("position = [0, 0, {}]", 0.05 + 0.1 * i as f64);
    let sliding = |i: usize| format!("position = [0, {i}, 0.05], linear_velocity = [9, {}, 0]", 0.1 * i as f64);
    let integrators =
        ["{ method = \"dopri5\" }", "{ method = \"rk4\", step = 1e-3 }", "{ method = \"semi-implicit\", step = 1e-3 }"];
    for (integrator, is_stack) in integrators.iter().flat_map(|i| [(i, true), (i, false)]) {
        let boxes = (0..20).map(|i| {
            let motion = if is_stack { stacked(i) } else { sliding(i) };
            format!(
                "[[object]]\ntype = \"box\"\nsize = [0.2, 0.2, 0.1]\nmass = 1\n{}\n",
                motion.replace(", linear", "\nlinear")
            )
        });
        let boxes = boxes.collect::<String>();
        let mut sim = simulation(&format!(
            "duration = 10.0
            robot = {{ model = \"robots/ground/ground.urdf\" }}
            integrator = {integrator}
            log.rate = 0
            floor.friction = 0.2\n{boxes}"
        ));
        sim.begin(&mut NullObserver).expect("it begins");
        (0..10).for_each(|_| sim.step(&mut NullObserver).expect("it steps"));
        let allocations = count(|| (0..100).for_each(|_| sim.step(&mut NullObserver).expect("it steps")));
        assert_eq!(sim.plant().polygons.len(), 20);
        assert_eq!(allocations, 0, "{integrator}, stacked: {is_stack}");
    }
}

/// A body slides and stops: the robot's block on the floor, a box on a box, and a box on terrain. Where the
/// corners of contacts stay the same, an event between bodies allocates what one of a sole does: its texts.
#[test]
fn events_of_objects_allocate_only_their_texts() {
    let of_sole = allocations_until_stop(
        "robot.model = \"robots/block/block.toml\"
        robot.base = { position = [0, 0, 0.05], linear_velocity = [2, 0, 0] }",
    );
    assert!(of_sole > 0, "the texts are counted");
    let sliding =
        "{ type = \"box\", size = [0.2, 0.1, 0.1], mass = 1, position = [0, 0, 0.15], linear_velocity = [2, 0, 0] }";
    let below = [
        format!("object = [{sliding}, {{ type = \"box\", size = [4, 1, 0.1], mass = 2, position = [0, 0, 0.05] }}]"),
        format!("object = [{sliding}]\nterrain = [{{ type = \"box\", size = [4, 1, 0.1], position = [0, 0, 0.05] }}]"),
    ];
    for scene in below {
        let robot = "robot = { model = \"robots/ground/ground.urdf\" }\n".to_owned();
        assert_eq!(allocations_until_stop(&(robot + &scene)), of_sole, "{scene}");
    }
}

/// Allocations of the second half of a slide at 2 m/s, up to the step in which it stops.
fn allocations_until_stop(scene: &str) -> usize {
    let mut sim = simulation(&format!("duration = 10.0\nfloor.friction = 0.2\nlog.rate = 0\n{scene}"));
    sim.begin(&mut NullObserver).expect("it begins");
    // Lists grow in the first half.
    while sim.plant().state.time < 0.5 {
        sim.step(&mut NullObserver).expect("it steps");
    }
    assert!(sim.metrics().first_stick_s.is_none(), "it slides");
    let allocations = count(|| {
        while sim.metrics().first_stick_s.is_none() {
            sim.step(&mut NullObserver).expect("it steps");
        }
    });
    assert_eq!(sim.metrics().state_changes, 1, "{scene}");
    allocations
}
