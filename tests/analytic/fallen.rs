//! Robots whose links touch the floor besides their soles (`robot.contact = "bodies"`).

use super::body::G;
use crate::support::runs::{finish, root, run, simulation, watch};
use stiction::contact::methods::registry::METHODS;
use stiction::robot;
use stiction::sim::floor::LinkHull;
use stiction::sim::{Metrics, NullObserver};

/// Tolerances at which the closed forms below hold to 1e-9.
const TIGHT: &str = "integrator = { relative_tolerance = 1e-9, absolute_tolerance = 1e-11 }
    contact = { distance_tolerance = 1e-8, velocity_tolerance = 1e-8, acceleration_tolerance = 1e-8 }\n";

/// The block on its side: two corners of its sole, and two of its upper face, touch the floor.
fn block_on_its_side(height: f64, velocity: f64, more: &str) -> Metrics {
    run(&format!(
        "duration = 1.0
        floor = {{ friction = 0.5 }}
        robot = {{ model = \"robots/block/block.toml\", contact = \"bodies\", base = {{ position = [0, 0, {height}], rpy = [\"90 deg\", 0, 0], linear_velocity = [{velocity}, 0, 0] }} }}
        {more}"
    ))
}

/// Falls flat onto its side by h: m g h are lost in one plastic impact, after sqrt(2 h / g).
#[test]
fn a_block_lands_on_its_side() {
    let m = block_on_its_side(0.12, 0.0, TIGHT);
    assert!((m.final_base_position[2] - 0.1).abs() < 1e-9, "{:?}", m.final_base_position);
    assert!((m.first_touchdown_s.unwrap() - (2.0 * 0.02 / G).sqrt()).abs() < 1e-9);
    assert!((m.impact_loss_j - G * 0.02).abs() < 1e-9, "{}", m.impact_loss_j);
    assert!(m.max_penetration_m < 1e-9 && m.energy_error_j.abs() < 1e-9 && m.inconsistent == 0, "{m:?}");
    assert!((m.final_normal_force_n.unwrap() - G).abs() < 1e-9);
}

/// A box without soles stands on an edge, its centre 7 mm beside it, and falls flat: the polygon that
/// touches at first is the face which the floor faces most, and the corners that land belong to
/// another. All energy is lost.
#[test]
fn corners_outside_the_polygon_land_at_located_events() {
    let (s, c) = 60f64.to_radians().sin_cos();
    let height = 0.1 * s + 0.05 * c;
    let m = run(&format!(
        "duration = 1.5
        floor = {{ friction = 2.0 }}
        robot = {{ model = \"robots/block/block.toml\", soles = [], contact = \"bodies\", base = {{ position = [0, 0, {height}], rpy = [0, \"60 deg\", 0] }} }}
        {TIGHT}"
    ));
    assert!((m.final_base_position[2] - 0.05).abs() < 1e-9, "{:?}", m.final_base_position);
    assert!((m.impact_loss_j + m.friction_loss_j - G * (height - 0.05)).abs() < 1e-9, "{m:?}");
    assert!(m.max_penetration_m < 1e-9 && m.energy_error_j.abs() < 1e-9 && m.inconsistent == 0, "{m:?}");
}

/// Slides from v0 over v0^2 / (2 mu g), on corners of two polygons of one link.
#[test]
fn a_block_slides_on_its_side_and_stops() {
    let m = block_on_its_side(0.1, 2.0, TIGHT);
    let way = 4.0 / (2.0 * 0.5 * G);
    assert!((m.final_base_position[0] - way).abs() < 1e-9, "{} {way}", m.final_base_position[0]);
    assert!((m.friction_loss_j - 2.0).abs() < 1e-9 && m.energy_error_j.abs() < 1e-9, "{m:?}");
    assert!((m.first_stick_s.unwrap() - 2.0 / (0.5 * G)).abs() < 1e-9);
}

/// Fixed steps of every method stop within the error of order one of the first step.
#[test]
fn every_method_holds_a_block_on_its_side() {
    for method in METHODS {
        let step = 1e-4;
        let fixed = format!(
            "integrator = {{ method = \"semi-implicit\", step = {step} }}\ncontact = {{ method = \"{}\" }}\n",
            method.name
        );
        let m = block_on_its_side(0.1, 2.0, &fixed);
        let way = 4.0 / (2.0 * 0.5 * G);
        // v0 h / 2 of the first step; `penalty` also slides while its springs load, and creeps.
        let allowed = if method.name == "penalty" { 2e-3 } else { 2.0 * 2.0 * step };
        assert!((m.final_base_position[0] - way).abs() < allowed, "{}: {:?}", method.name, m.final_base_position);
        assert!((m.final_base_position[2] - 0.1).abs() < 1e-4, "{}: {:?}", method.name, m.final_base_position);
    }
}

/// Thrown down by a push of 60 N for 0.3 s.
const FALL: &str = "duration = 5.0
    robot = { model = \"robots/hoap2/hoap2.toml\", contact = \"bodies\" }
    force = [{ type = \"push\", link = \"torso\", force = [60, 0, 0], start = 0.1, duration = 0.3 }]
    log = { rate = 0 }\n";

#[test]
fn a_fallen_humanoid_comes_to_rest_with_nothing_below_the_floor() {
    let mut sim = simulation(FALL);
    let m = finish(&mut sim, &mut NullObserver);
    assert!(m.final_base_position[2] < 0.1, "it has fallen: {:?}", m.final_base_position);
    // Speeds of base and joints.
    assert!(sim.plant().state.v.iter().all(|v| v.abs() < 1e-9), "{:?}", sim.plant().state.v);
    assert!(m.max_penetration_m < 1e-9 && m.energy_error_j.abs() < 1e-6 && m.inconsistent == 0, "{m:?}");
    let weight = sim.plant().model.mass() * G;
    assert!((m.final_normal_force_n.unwrap() / weight - 1.0).abs() < 1e-9);
    // All corners of all links, touching or not.
    let plant = sim.plant();
    let hulls = LinkHull::of_model(&plant.model, 16, |_, _| false);
    assert!(hulls.len() > 10);
    let (mut lowest, mut touching) = (f64::INFINITY, 0);
    for hull in &hulls {
        hull.heights(&plant.ws, &plant.floor, 0.0, |_, height| {
            lowest = lowest.min(height);
            touching += usize::from(height < 1e-9);
        });
    }
    assert!(lowest > -1e-9 && touching >= 3, "{lowest} {touching}");
}

#[test]
fn every_method_and_integrator_brings_a_fallen_humanoid_to_rest() {
    for method in METHODS {
        for integrator in ["dopri5", "semi-implicit"] {
            if integrator == "dopri5" && method.only_semi_implicit.is_some() {
                continue;
            }
            let text = format!(
                "{FALL}contact = {{ method = \"{}\" }}\nintegrator = {{ method = \"{integrator}\" }}\n",
                method.name
            );
            let mut sim = simulation(&text);
            let m = finish(&mut sim, &mut NullObserver);
            let case = format!("{} {integrator}", method.name);
            assert!((0.0..0.1).contains(&m.final_base_position[2]), "{case}: {:?}", m.final_base_position);
            // `penalty` creeps.
            assert!(sim.plant().state.v.iter().all(|v| v.abs() < 1e-6), "{case}: {:?}", sim.plant().state.v);
            let weight = sim.plant().model.mass() * G;
            assert!((m.final_normal_force_n.unwrap() / weight - 1.0).abs() < 1e-5, "{case}");
        }
    }
}

/// A robot whose links stay above the floor moves as with its soles alone, to the last bit.
#[test]
fn links_that_do_not_touch_change_no_bit() {
    let text = |contact: &str| {
        format!(
            "duration = 1.0
            robot = {{ model = \"robots/hoap2/hoap2.toml\", contact = \"{contact}\" }}
            force = [{{ type = \"push\", link = \"torso\", force = [15, 10, 0], start = 0.1, duration = 0.1 }}]\n"
        )
    };
    let (a, b) = (run(&text("soles")), run(&text("bodies")));
    assert_eq!(a.final_base_position.map(f64::to_bits), b.final_base_position.map(f64::to_bits));
    assert_eq!((a.steps, a.events, a.selections), (b.steps, b.events, b.selections));
    assert!(a.events > 0);
}

/// A state saved while arms and knees touch is restored with its polygons: the motion repeats.
#[test]
fn a_restored_state_has_its_links_on_the_floor() {
    let tail = 0.2;
    let text = |duration: f64, more: &str| FALL.replace("5.0", &duration.to_string()) + more;
    let event = "event = [{ at = 1.0, save = \"lying\" }, { at = 1.5, restore = \"lying\" }]\n";
    let once = run(&text(1.0 + tail, ""));
    let (again, events) = watch(&text(1.5 + tail, event));
    // The links need not land again.
    let landings = events.events.iter().filter(|e| e.time == 1.5 && e.kind == "touchdown").count();
    assert_eq!(landings, 0, "{:?}", events.events);
    for (a, b) in once.final_base_position.iter().zip(again.final_base_position) {
        // Steps begin anew at the events: the error of the integrator.
        assert!((a - b).abs() < 1e-5, "{a} {b}");
    }
    let (_, recording) = watch(&text(1.0, ""));
    let end = recording.snapshots.last().expect("the end is reported");
    assert!(!end.links.is_empty(), "something touches at 1 s");
}

/// Points near a sole are left out, those of the upper face stay.
#[test]
fn the_hull_of_a_block_with_a_sole_is_its_upper_face() {
    let block = robot::load(&root().join("robots/block/block.toml")).unwrap().model;
    let hulls = LinkHull::of_model(&block, 16, |_, _| false);
    assert_eq!((hulls.len(), hulls[0].points.len(), hulls[0].faces.len()), (1, 4, 1));
    assert!(hulls[0].points.iter().all(|p| p.z == 0.05));
}

/// A fall of `robot` from this height, orientation and velocities.
fn fall(robot: &str, base: [f64; 6], duration: f64) -> Metrics {
    let [height, roll, pitch, yaw, velocity, spin] = base;
    run(&format!(
        "duration = {duration}
        robot = {{ model = \"robots/{robot}/{robot}.toml\", contact = \"bodies\", base = {{ position = [0, 0, {height}], rpy = [{roll}, {pitch}, {yaw}], linear_velocity = [{velocity}, 0, 0], angular_velocity = [0, {spin}, 0] }} }}
        log.rate = 0\n"
    ))
}

/// HOAP-2 rests on three edges, which share its weight in a way that statics leaves open. The split of least
/// norm is outside a friction cone, another is not: the robot rests, and does not stay in a sliding mode.
#[test]
fn a_split_of_an_indeterminate_load_inside_all_friction_cones_holds() {
    let base =
        [1.0, -1.267026788724912, 0.7058867422892279, -2.7394275229357787, -0.6825288651699101, -1.3679945856187865];
    let m = fall("hoap2", base, 2.5);
    assert!(m.sliding_mode_s < 0.1, "{}", m.sliding_mode_s);
    assert!(m.max_cone_excess < 1e-9 && m.max_tension_n < 1e-9 && m.inconsistent == 0, "{m:?}");
    // Velocities that the servos damp for the rest of 2.5 s.
    assert!(m.final_base_velocity.iter().all(|v| v.abs() < 1e-5), "{:?}", m.final_base_velocity);
}

/// HOAP-2 rests on torso and thighs, whose joints have the 8 digits of its URDF: three of the 15 conditions are redundant,
/// one of them up to these digits only (2e-11 of the others). To hold it exactly takes forces outside the friction
/// cones, and 4e-10 m/s^2 without. The robot rests, where it stayed in a sliding mode from 1.2 s on.
#[test]
fn conditions_that_are_redundant_up_to_the_digits_of_a_urdf_let_a_robot_rest() {
    let mut sim = simulation(
        "duration = 2.0
        floor = { friction = 0.5 }
        robot = { model = \"robots/hoap2/hoap2.toml\", contact = \"bodies\" }
        force = [{ type = \"push\", link = \"torso\", force = [60, 0, 0], start = 0.1, duration = 0.3 }]",
    );
    let m = finish(&mut sim, &mut NullObserver);
    let speed = sim.plant().each_velocity().fold(0.0, |most: f64, v| most.max(v.abs()));
    assert!(m.sliding_mode_s == 0.0 && m.inconsistent == 0 && speed < 1e-12, "{} s, {speed}", m.sliding_mode_s);
    assert!(m.max_cone_excess < 1e-6 && m.energy_error_j.abs() < 1e-6, "{m:?}");
}
