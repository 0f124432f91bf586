//! Forces on objects by closed forms and against the same forces on a robot, and friction of the floor
//! that changes below objects.

use super::body::G;
use super::object_models::{File, finished, joint, jointed, link, object, velocity};
use crate::support::runs::{finish, root, simulation};
use nalgebra::Vector3;
use stiction::dynamics::State;
use stiction::sim::NullObserver;
use stiction::{assemble, robot, scenario};

const BOX: &str = "type = \"box\", name = \"box\", size = [0.4, 0.2, 0.1], mass = 2.0";

/// x = F t^2 / 2m and w = M t / I, and the work of both is the kinetic energy.
#[test]
fn a_pushed_object_has_the_acceleration_of_the_force() {
    let (sim, m) = finished(&format!(
        "duration = 1.5
        gravity = [0, 0, 0]
        object = [{{ {BOX}, position = [0, 0, 1] }}]
        force = [{{ type = \"constant\", object = \"box\", force = [3, 0, -1], moment = [0, 0, 0.04] }}]"
    ));
    let t = 1.5;
    let moved = object(&sim, 0).position - Vector3::new(0.0, 0.0, 1.0);
    assert!((moved - Vector3::new(3.0, 0.0, -1.0) * (0.5 * t * t / 2.0)).norm() < 1e-9, "{moved}");
    let inertia = 2.0 * (0.4 * 0.4 + 0.2 * 0.2) / 12.0;
    assert!((object(&sim, 0).v[5] - 0.04 * t / inertia).abs() < 1e-9, "{:?}", object(&sim, 0).v);
    let work = 10.0 * t * t / 4.0 + 0.04 * 0.04 * t * t / (2.0 * inertia);
    assert!((m.external_work_j - work).abs() < 1e-9 && m.energy_error_j.abs() < 1e-9, "{m:?}");
}

/// x = A cos(w t) for a spring, and v = v0 exp(-c t / m) in a medium with linear drag.
#[test]
fn a_spring_swings_an_object_and_drag_stops_one() {
    let (k, a, c) = (50.0, 0.3, 1.2);
    let (sim, m) = finished(&format!(
        "duration = 1.0
        gravity = [0, 0, 0]
        object = [
            {{ {BOX}, position = [{a}, 0, 1] }},
            {{ type = \"sphere\", name = \"ball\", radius = 0.1, mass = 0.5, position = [0, 3, 1], linear_velocity = [0, 2, 0] }},
        ]
        force = [
            {{ type = \"spring\", object = \"box\", stiffness = {k}, anchor = {{ position = [0, 0, 1] }} }},
            {{ type = \"drag\", object = \"ball\", linear = {c} }},
        ]"
    ));
    let w = (k / 2.0f64).sqrt();
    assert!((object(&sim, 0).position.x - a * w.cos()).abs() < 1e-9, "{}", object(&sim, 0).position);
    assert!((velocity(&sim, 0).x + a * w * w.sin()).abs() < 1e-9);
    assert!((velocity(&sim, 1).y - 2.0 * (-c / 0.5f64).exp()).abs() < 1e-9, "{}", velocity(&sim, 1));
    assert!(m.energy_error_j.abs() < 1e-9, "{}", m.energy_error_j);
}

/// A door that a servo holds against a force at its handle comes to rest at F l / k, a drawer at F / k. The
/// work of the forces is (F l)^2 / k and F^2 / k.
#[test]
fn servos_hold_a_door_and_a_drawer_against_a_force() {
    let (force, lever, stiffness) = (6.0, 0.8, 20.0);
    let body = link("leaf", 3.0, [0.4, 0.0, 0.0], 0.2, Some([0.8, 0.04, 1.0]));
    for (kind, axis, arm) in [("continuous", [0.0, 0.0, 1.0], lever), ("prismatic", [0.0, 1.0, 0.0], 1.0)] {
        let limit = "<limit lower=\"-3\" upper=\"3\" effort=\"100\" velocity=\"100\"/>";
        let hinge = joint("hinge", kind, ["world", "leaf"], [0.0; 3], axis, limit);
        let file = jointed(&body, &hinge);
        let (sim, m) = finished(&format!(
            "duration = 20
            object = [{{ type = \"model\", name = \"door\", model = {:?}, position = [0, 0, 1],
                servo = [{{ stiffness = {stiffness}, damping = 9.0 }}] }}]
            force = [{{ type = \"constant\", object = \"door\", link = \"leaf\", point = [{lever}, 0, 0], force = [0, {force}, 0], frame = \"link\" }}]",
            file.path()
        ));
        let expected = force * arm / stiffness;
        let state = object(&sim, 0);
        assert!((state.joints[0] - expected).abs() < 1e-9, "{kind}: {} {expected}", state.joints[0]);
        assert!(state.v[0].abs() < 1e-9, "{}", state.v[0]);
        assert!((m.external_work_j - force * arm * expected).abs() < 1e-9, "{}", m.external_work_j);
        assert!(m.energy_error_j.abs() < 1e-9, "{}", m.energy_error_j);
    }
}

/// Servos by pattern, of which the last one counts, hold other positions than the initial ones.
#[test]
fn servos_hold_their_targets() {
    let file = chain();
    let (sim, _) = finished(&format!(
        "duration = 30
        gravity = [0, 0, 0]
        object = [{{ type = \"model\", model = {:?}, position = [0, 0, 3], posture = {{ one = 0.2, two = 0.1 }},
            servo = [{{ stiffness = 5, damping = 2 }}, {{ joints = \"t*\", stiffness = 9, damping = 2 }}],
            target = {{ one = 0.4, three = \"-30 deg\" }} }}]
        force = [{{ type = \"joint-friction\", object = \"object.0\", joints = {{ two = {{ viscous = 0.5 }} }} }}]",
        file.path()
    ));
    let expected = [0.4, 0.1, -std::f64::consts::PI / 6.0];
    let q = &object(&sim, 0).joints;
    assert!(q.iter().zip(expected).all(|(q, e)| (q - e).abs() < 1e-9), "{q:?}");
    let drives = &sim.plant().objects.list[0].model.joints;
    assert_eq!([drives[0].drive.kp, drives[1].drive.kp, drives[2].drive.kp], [5.0, 9.0, 9.0]);
}

/// A fixed chain of three links.
fn chain() -> File {
    let limit = "<limit lower=\"-3\" upper=\"3\" effort=\"100\" velocity=\"100\"/>";
    let part = |name: &str| link(name, 0.7, [0.02, 0.01, -0.15], 0.01, None);
    let hinge = |name: &str, links: [&str; 2], axis: [f64; 3]| {
        joint(name, "revolute", links, [0.0, 0.0, if name == "one" { 2.0 } else { -0.3 }], axis, limit)
    };
    File::new(
        "chain.urdf",
        &format!(
            "<robot name=\"chain\"><link name=\"world\"/>{}{}{}{}{}{}</robot>",
            part("a"),
            part("b"),
            part("c"),
            hinge("one", ["world", "a"], [0.0, 1.0, 0.0]),
            hinge("two", ["a", "b"], [1.0, 0.0, 0.0]),
            hinge("three", ["b", "c"], [0.0, 0.6, 0.8]),
        ),
    )
}

/// Entries of forces that act alike on a robot and, with `object`, on an object.
const FORCES: [&str; 8] = [
    "type = \"push\", link = \"c\", point = [0, 0, -0.1], force = [2, 1, 0], duration = 0.2, profile = \"half-sine\"",
    "type = \"constant\", link = \"b\", force = [1, 0, 0.5], moment = [0, 0.1, 0], frame = \"link\"",
    "type = \"ramp\", link = \"a\", point = [0, 0, -0.2], force = [2, 0, 0], start = 0.05, duration = 0.1",
    "type = \"spring\", link = \"c\", stiffness = 40, damping = 3, start = 0.05, rest_length = 0.01, anchor = { velocity = [0.2, 0, 0] }",
    "type = \"random-pushes\", links = [\"b\", \"c\"], number = 5, magnitude = [1, 3]",
    "type = \"drag\", linear = 0.4, quadratic = 0.3, wind = [1, 0, 0]",
    "type = \"joint-friction\", all = { coulomb = 0.05, viscous = 0.1 }",
    "type = \"script\", file = \"FILE\"",
];

const SCRIPT: &str = "function run(robot)
    return { { link = \"c\", force = { 1, -2 * robot.time, 0 } }, { joint = \"two\", effort = -0.2 * robot.qd[robot.joint.two] } }
end\n";

fn moved(settings: &str, robot: &str, objects: &str, force: &str) -> (State, f64, f64) {
    let mut sim = simulation(&format!("{settings}{robot}\n{objects}\nforce = [{{ {force} }}]"));
    let m = finish(&mut sim, &mut NullObserver);
    let plant = sim.plant();
    let state = plant.objects.list.first().map_or(&plant.state, |object| &object.state);
    (state.clone(), m.external_work_j, m.energy_error_j)
}

#[test]
fn forces_act_alike_on_a_robot_and_on_an_object() {
    let (file, script) = (chain(), File::new("force.luau", SCRIPT));
    let start = "posture = { one = 0.5, three = 0.3 }, velocity = { two = 1.0 }";
    for integrator in ["method = \"rk4\", step = 1e-3", "method = \"semi-implicit\", step = 1e-3"] {
        let settings = format!("duration = 0.3\nseed = 5\nlog = {{ rate = 0 }}\nintegrator = {{ {integrator} }}\n");
        let robot = format!(
            "robot = {{ model = {:?}, soles = [], joint_default = {{ mode = \"passive\" }}, {start} }}",
            file.path()
        );
        let ground = "robot = { model = \"robots/ground/ground.urdf\" }";
        let objects =
            format!("object = [{{ type = \"model\", name = \"chain\", model = {:?}, {start} }}]", file.path());
        let free = moved(&settings, ground, &objects, "type = \"drag\", object = \"chain\", linear = 1e-300");
        for force in FORCES.map(|force| force.replace("FILE", script.path().to_str().unwrap())) {
            let (a, work, error) = moved(&settings, &robot, "", &force);
            let (b, same_work, same_error) =
                moved(&settings, ground, &objects, &format!("object = \"chain\", {force}"));
            let apart = |a: &State, b: &State| {
                let pairs = a.joints.iter().chain(&a.v).zip(b.joints.iter().chain(&b.v));
                pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
            };
            // Rounding over 300 steps.
            assert!(apart(&a, &b) < 1e-12, "{integrator} {force}: {:e}", apart(&a, &b));
            assert!(
                (work - same_work).abs() < 1e-12 && (error - same_error).abs() < 1e-12,
                "{force}: {work} {same_work}"
            );
            assert!(apart(&free.0, &b) > 1e-3, "{force} acts");
            assert!(work != 0.0, "{force} works");
        }
    }
}

/// A force changes during the run, and another one moves to another object.
#[test]
fn events_change_forces_on_objects() {
    let (sim, m) = finished(&format!(
        "duration = 1.0
        gravity = [0, 0, 0]
        object = [
            {{ {BOX}, position = [0, 0, 1] }},
            {{ type = \"sphere\", name = \"ball\", radius = 0.1, mass = 0.5, position = [0, 3, 1] }},
        ]
        force = [{{ type = \"constant\", object = \"box\", force = [4, 0, 0] }}]
        event = [
            {{ at = 0.5, set = {{ \"force.0.force\" = [-2, 0, 0] }} }},
            {{ at = 0.75, set = {{ \"force.0.object\" = \"ball\" }} }},
        ]"
    ));
    let speeds = [2.0 * 0.5, 2.0 * 0.5 - 0.25];
    assert!((velocity(&sim, 0).x - speeds[1]).abs() < 1e-9, "{}", velocity(&sim, 0));
    let way = 0.5 * 2.0 * 0.25 + 0.25 * (speeds[0] + speeds[1]) / 2.0 + 0.25 * speeds[1];
    assert!((object(&sim, 0).position.x - way).abs() < 1e-9, "{} {way}", object(&sim, 0).position.x);
    assert!((velocity(&sim, 1).x + 2.0 * 0.25 / 0.5).abs() < 1e-9, "{}", velocity(&sim, 1));
    assert!(m.energy_error_j.abs() < 1e-9);
}

/// A spring is anchored where the object is at the start, and stays there when an event makes it stiffer:
/// x = v sin(w t) / w, then a swing with twice the rate about the same point.
#[test]
fn a_spring_on_an_object_keeps_its_anchor_when_it_changes() {
    let (k, v, t1, t2) = (18.0, 0.6, 0.3, 0.5);
    let (sim, m) = finished(&format!(
        "duration = {t2}
        gravity = [0, 0, 0]
        object = [{{ {BOX}, position = [0.7, 0, 1], linear_velocity = [{v}, 0, 0] }}]
        force = [{{ type = \"spring\", object = \"box\", stiffness = {k} }}]
        event = [{{ at = {t1}, set = {{ \"force.0.stiffness\" = {} }} }}]",
        4.0 * k
    ));
    let w = (k / 2.0f64).sqrt();
    let (x, speed) = (v * (w * t1).sin() / w, v * (w * t1).cos());
    let (sin, cos) = (2.0 * w * (t2 - t1)).sin_cos();
    let expected = x * cos + speed * sin / (2.0 * w);
    assert!((object(&sim, 0).position.x - 0.7 - expected).abs() < 1e-9, "{}", object(&sim, 0).position.x - 0.7);
    // The event does the work that the stiffer spring stores: external forces have done all of it.
    let energy = velocity(&sim, 0).norm_squared() - v * v;
    assert!((m.external_work_j - energy).abs() < 1e-9 && m.energy_error_j.abs() < 1e-9, "{m:?}");
}

#[test]
fn a_force_that_does_not_fit_its_object_is_refused() {
    let file = chain();
    for (force, key, message) in [
        ("type = \"push\", object = \"cha\", force = [1, 0, 0]", "cha", "the scenario has no object `cha`"),
        (
            "type = \"push\", object = \"chain\", force = [1, 0, 0]",
            "chain",
            "of the object `chain` is fixed and cannot",
        ),
        (
            "type = \"push\", object = \"chain\", link = \"d\", force = [1, 0, 0]",
            "d",
            "the object `chain` has no link `d`",
        ),
        (
            "type = \"spring\", object = \"ball\", end_effector = \"e\", stiffness = 1",
            "e",
            "the object `ball` has no end eff",
        ),
        (
            "type = \"random-pushes\", object = \"chain\", number = 1, magnitude = [1, 1]",
            "chain",
            "is fixed and cannot move",
        ),
        (
            "type = \"joint-friction\", object = \"ball\", all = { viscous = 1 }",
            "[[force]]",
            "the object `ball` has no joints",
        ),
        (
            "type = \"joint-friction\", object = \"chain\", joints = { four = { viscous = 1 } }",
            "four",
            "the object `chain` has no joint `four`",
        ),
    ] {
        let text = format!(
            "[robot]\nmodel = \"robots/ground/ground.urdf\"\n[[object]]\ntype = \"model\"\nname = \"chain\"\nmodel = {:?}\n\
            [[object]]\ntype = \"sphere\"\nname = \"ball\"\nradius = 0.1\nmass = 1\nposition = [9, 0, 1]\n[[force]]\n{}\n",
            file.path(),
            force.replace(", ", "\n").replace("[1\n0\n0]", "[1, 0, 0]").replace("[1\n1]", "[1, 1]")
        );
        let runs = scenario::parse(&root().join("test.toml"), &text).and_then(|f| f.expand(&[])).expect("it is sound");
        let robot = robot::load(&root().join("robots/ground/ground.urdf")).expect("it is there");
        let Err(wrong) = assemble::setup(&runs[0], &robot) else { panic!("accepted: {force}") };
        let [error] = &wrong.0[..] else { panic!("{force}\n{wrong}") };
        assert!(error.message.contains(message) && error.to_string().contains(key), "{force}\n{wrong}");
    }
}

/// A ball slides over the border of a patch: v' = -mu g with the coefficient of each region.
#[test]
fn an_object_has_the_friction_of_its_patch() {
    let (v0, mu, slippery, border, t) = (3.0, 0.2, 0.05, 0.6, 0.5);
    for own in [None, Some(0.1)] {
        let friction = own.map_or(String::new(), |mu| format!(", friction = {mu}"));
        let [first, second] = [mu, slippery].map(|mu| own.unwrap_or(1.0f64).min(mu));
        let (sim, m) = finished(&format!(
            "duration = {t}
            floor = {{ friction = {mu}, patches = [{{ polygon = [[{border}, -1], [9, -1], [9, 1], [{border}, 1]], friction = {slippery} }}] }}
            object = [{{ type = \"sphere\", radius = 0.1, mass = 2.0, position = [0, 0, 0.1], linear_velocity = [{v0}, 0, 0]{friction} }}]"
        ));
        let v1 = (v0 * v0 - 2.0 * first * G * border).sqrt();
        let t1 = (v0 - v1) / (first * G);
        let way = border + v1 * (t - t1) - 0.5 * second * G * (t - t1) * (t - t1);
        let omega = 2.5 / 0.1 * (first * G * t1 + second * G * (t - t1));
        assert!(omega * 0.1 < v1 - second * G * (t - t1), "it still slides");
        assert!((object(&sim, 0).position.x - way).abs() < 1e-9, "{own:?}: {} {way}", object(&sim, 0).position.x);
        assert!((object(&sim, 0).v[4] - omega).abs() < 1e-8, "{} {omega}", object(&sim, 0).v[4]);
        assert!(m.energy_error_j.abs() < 1e-9, "{}", m.energy_error_j);
    }
}

/// A ball rolls down an incline onto a patch without friction, where it keeps its spin.
#[test]
fn a_rolling_ball_crosses_the_border_of_a_patch() {
    let (tilt, r, s, t) = (0.2f64, 0.1, 0.3, 1.0);
    let border = s * tilt.cos();
    let (sim, m) = finished(&format!(
        "duration = {t}
        floor = {{ friction = 0.5, rpy = [0, {tilt}, 0], patches = [{{ polygon = [[{border}, -1], [9, -1], [9, 1], [{border}, 1]], friction = 0 }}] }}
        object = [{{ type = \"sphere\", radius = {r}, mass = 2.0, position = [{}, 0, {}] }}]",
        r * tilt.sin(),
        r * tilt.cos()
    ));
    let (slow, fast) = (5.0 / 7.0 * G * tilt.sin(), G * tilt.sin());
    let t1 = (2.0 * s / slow).sqrt();
    let (v1, rest) = (slow * t1, t - t1);
    let down = Vector3::new(tilt.cos(), 0.0, -tilt.sin());
    let start = Vector3::new(tilt.sin(), 0.0, tilt.cos()) * r;
    let way = s + v1 * rest + 0.5 * fast * rest * rest;
    assert!((object(&sim, 0).position - start - down * way).norm() < 1e-9, "{}", object(&sim, 0).position - start);
    assert!((object(&sim, 0).v[4] - v1 / r).abs() < 1e-8, "{} {}", object(&sim, 0).v[4], v1 / r);
    assert!(m.energy_error_j.abs() < 1e-9, "{}", m.energy_error_j);
}

/// An event changes the friction of the floor and of terrain without its own, below objects too.
#[test]
fn an_event_changes_the_friction_below_objects() {
    let (v0, mu, later, own) = (3.0, 0.3, 0.1, 0.2);
    let block = |y: f64, z: f64| {
        format!(
            "{{ type = \"box\", size = [0.2, 0.2, 0.1], mass = 2.0, position = [0, {y}, {z}], linear_velocity = [{v0}, 0, 0] }}"
        )
    };
    let terrain =
        |y: f64, more: &str| format!("{{ type = \"box\", size = [8, 1, 0.5], position = [0, {y}, 0.25]{more} }}");
    let (sim, m) = finished(&format!(
        "duration = 0.8
        floor = {{ friction = {mu} }}
        terrain = [{}, {}]
        object = [{}, {}, {}, {}]
        event = [{{ at = 0.4, set = {{ \"floor.friction\" = {later} }} }}]",
        terrain(3.0, ""),
        terrain(5.0, &format!(", friction = {own}")),
        block(0.0, 0.05),
        block(3.0, 0.55),
        block(5.0, 0.55),
        block(-3.0, 0.05).replace("mass", "friction = 0.05, mass"),
    ));
    let after = |first: f64, second: f64| v0 - (first + second) * G * 0.4;
    for (o, expected) in
        [after(mu, later), after(mu, later), after(own, own), after(0.05, 0.05)].into_iter().enumerate()
    {
        assert!((velocity(&sim, o).x - expected).abs() < 1e-9, "{o}: {} {expected}", velocity(&sim, o).x);
    }
    assert!(m.energy_error_j.abs() < 1e-9 && m.inconsistent == 0, "{m:?}");
}

/// Two objects without friction of their own have the floor's, also after it changes.
#[test]
fn two_objects_take_the_friction_of_the_floor() {
    let (v0, mu, later) = (1.0, 0.2, 0.05);
    let (sim, _) = finished(&format!(
        "duration = 0.3
        floor = {{ friction = {mu} }}
        object = [
            {{ type = \"box\", size = [3, 0.4, 0.1], mass = 200.0, position = [0, 0, 0.05] }},
            {{ type = \"box\", size = [0.2, 0.1, 0.1], mass = 1.0, position = [-0.1, 0, 0.15], linear_velocity = [{v0}, 0, 0] }},
        ]
        event = [{{ at = 0.1, set = {{ \"floor.friction\" = {later} }} }}]"
    ));
    let expected = v0 - mu * G * 0.1 - later * G * 0.2;
    assert!((velocity(&sim, 1).x - expected).abs() < 1e-9, "{} {expected}", velocity(&sim, 1).x);
    assert!(velocity(&sim, 0).norm() < 1e-12, "the floor holds the lower one");
}

/// A block slides over the seam of two terrain boxes of different friction: each corner has that of its box.
#[test]
fn a_corner_takes_the_friction_of_the_terrain_below_it() {
    let (v0, near, far, t) = (3.0, 0.3, 0.1, 0.5);
    let (sim, m) = finished(&format!(
        "duration = {t}
        floor = {{ friction = 0.8 }}
        terrain = [
            {{ type = \"box\", size = [1, 1, 0.5], position = [0, 0, 0.25], friction = {near} }},
            {{ type = \"box\", size = [4, 1, 0.5], position = [2.5, 0, 0.25], friction = {far} }},
        ]
        object = [{{ type = \"sphere\", radius = 0.1, mass = 2.0, position = [0, 0, 0.6], linear_velocity = [{v0}, 0, 0] }}]"
    ));
    let v1 = (v0 * v0 - 2.0 * near * G * 0.5_f64).sqrt();
    let t1 = (v0 - v1) / (near * G);
    let way = 0.5 + v1 * (t - t1) - 0.5 * far * G * (t - t1) * (t - t1);
    assert!((object(&sim, 0).position.x - way).abs() < 1e-9, "{} {way}", object(&sim, 0).position.x);
    assert!(m.energy_error_j.abs() < 1e-9);
}
