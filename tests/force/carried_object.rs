//! `carried-object`: conservation laws of grasp, carrying and release.

use super::fly;
use crate::analytic::body::{Body, G};
use crate::support::runs::{Recording, TIGHT, finish, run, simulation};
use nalgebra::{Rotation3, Vector3};
use stiction::dynamics::body::momentum;
use stiction::sim::NullObserver;

const M: f64 = 0.5;
const R: f64 = 0.2;

fn body() -> Body {
    Body::new([0.1, 0.1, 0.05], 2.0)
}

fn object(rest: &str) -> String {
    format!("[[force]]\ntype = \"carried-object\"\nlink = \"block\"\nmass = {M}\nposition = [{R}, 0, 0]\n{rest}\n")
}

/// Without gravity, rotating about z with its centre at rest in the origin.
fn spinning(body: &Body, spin: f64, duration: f64, object: &str) -> String {
    let robot = body.floating(&format!("position = [0, 0, 0], angular_velocity = [0, 0, {spin}]"));
    format!("duration = {duration:?}\ngravity = [0, 0, 0]\n{robot}{TIGHT}{object}")
}

#[test]
fn a_spinning_body_that_catches_an_object_keeps_its_angular_momentum() {
    let body = body();
    let (inertia, spin) = (body.inertia()[2], 3.0);
    let reduced = M * body.mass / (M + body.mass);
    // An object at rest next to the rotating box, a flying one, and a long one.
    for (velocity, own) in [([0.0; 3], 0.0), ([0.4, -1.0, 0.0], 0.0), ([0.0; 3], 0.03)] {
        let turn = spin * 0.5_f64;
        let place = Vector3::new(R * turn.cos(), R * turn.sin(), 0.0);
        let velocity = Vector3::from(velocity);
        let text = object(&format!(
            "start = 0.5\ninertia = [0.02, 0.02, {own}, 0, 0, 0]\nvelocity = {:?}",
            <[f64; 3]>::from(velocity)
        ));
        let mut sim = simulation(&spinning(&body, spin, 1.5, &text));
        let metrics = finish(&mut sim, &mut NullObserver);
        // About the common centre of mass: the box's spin, and both on their lever arms with their
        // relative velocity.
        let angular = inertia * spin + reduced * place.cross(&velocity).z;
        let together = inertia + own + reduced * R * R;
        let after = angular / together;
        // Integration at relative tolerance 1e-9 of a steady turn.
        assert!((metrics.final_base_angular_velocity[2] - after).abs() < 1e-8, "{metrics:?} {after}");
        let p = momentum(&sim.plant().ws);
        assert!((p.linear - velocity * M).norm() < 1e-9 && (p.angular.z - angular).abs() < 1e-9, "{p:?}");
        let before = 0.5 * (inertia * spin * spin + M * velocity.norm_squared());
        let remaining = 0.5 * (together * after * after + (velocity * M).norm_squared() / (M + body.mass));
        assert!(
            (metrics.impact_loss_j - (before - remaining)).abs() < 1e-10,
            "{} {}",
            metrics.impact_loss_j,
            before - remaining
        );
        assert!(before - remaining > 0.01, "something is lost");
        assert!((metrics.external_work_j - 0.5 * M * velocity.norm_squared()).abs() < 1e-12, "the object's energy");
        assert!(metrics.max_energy_error_j < 1e-9, "{}", metrics.max_energy_error_j);
    }
}

#[test]
fn grasping_and_releasing_an_object_at_equal_velocity_changes_no_velocity() {
    let body = body();
    let (spin, from, held, after) = (3.0, 0.5, 0.7, 0.4);
    let text = object(&format!("start = {from}\nduration = {held}"));
    let mut sim = simulation(&spinning(&body, spin, from + held + after, &text));
    let metrics = finish(&mut sim, &mut NullObserver);
    // Together they rotate as before about their centre of mass, which keeps its velocity at that
    // instant.
    let turn = |angle: f64| Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
    let (omega, arm) = (Vector3::z() * spin, Vector3::x() * (R * M / (M + body.mass)));
    let joined = turn(spin * from) * arm;
    let centre = omega.cross(&joined);
    let parted = turn(spin * (from + held)) * arm;
    let velocity = centre - omega.cross(&parted);
    let position = joined + centre * held - parted + velocity * after;
    assert!((sim.plant().state.position - position).norm() < 1e-8, "{} {position}", sim.plant().state.position);
    let v = &sim.plant().state.v;
    assert!((Vector3::new(v[0], v[1], v[2]) - velocity).norm() < 1e-8 && (v[5] - spin).abs() < 1e-9, "{v:?}");
    assert_eq!(metrics.impact_loss_j, 0.0);
    // The object adds m (w R)^2 / 2 at the grasp and removes its kinetic energy at the release.
    let speed = |v: Vector3<f64>, arm: Vector3<f64>| (v + omega.cross(&arm)).norm_squared();
    let brought = 0.5 * M * speed(Vector3::zeros(), turn(spin * from) * Vector3::x() * R);
    let taken = 0.5 * M * speed(velocity, turn(spin * (from + held)) * Vector3::x() * R);
    assert!((metrics.external_work_j - (brought - taken)).abs() < 1e-9, "{}", metrics.external_work_j);
    assert!(metrics.max_energy_error_j < 1e-9, "{}", metrics.max_energy_error_j);
    // The box has its initial properties again, to the last bit.
    let link = &sim.plant().model.links[0];
    let whole = simulation(&spinning(&body, spin, 1.0, ""));
    assert_eq!(*link, whole.plant().model.links[0]);
}

#[test]
fn an_object_carried_from_the_start_is_a_payload() {
    let body = body();
    let carried = fly(&body, [0.0, 0.0, 9.0], [1.0, 0.0, 0.0], 0.5, &object("inertia = [0.01, 0.01, 0.01, 0, 0, 0]"));
    let payload = format!(
        "payload = [{{ link = \"block\", mass = {M}, position = [{R}, 0, 0], inertia = [0.01, 0.01, 0.01, 0, 0, 0] }}], soles"
    );
    let robot = body.floating("position = [0, 0, 9], linear_velocity = [1, 0, 0]").replace("soles", &payload);
    let mut sim = simulation(&format!("duration = 0.5\n{robot}{TIGHT}"));
    let metrics = finish(&mut sim, &mut NullObserver);
    assert_eq!(sim.plant().state.position, carried.position, "the same numbers");
    assert_eq!(metrics.energy_change_j, carried.metrics.energy_change_j);
    assert!(carried.metrics.max_flight_path_drift_m.unwrap() < 1e-12, "{:?}", carried.metrics.max_flight_path_drift_m);
}

#[test]
fn energy_balances_through_grasp_and_release_in_flight() {
    let body = body();
    let text = format!(
        "{}{}",
        object("start = 0.1\nduration = 0.4\nvelocity = [1, 0, -1]"),
        object("start = 0.3\nduration = 0.4").replace(&format!("[{R}, 0, 0]"), "[0, 0.1, 0.1]")
    );
    let end = fly(&body, [0.0, 0.0, 9.0], [1.0, 0.5, 2.0], 1.0, &text);
    // Integration at relative tolerance 1e-9 of some 100 J.
    assert!(end.metrics.max_energy_error_j < 1e-7, "{}", end.metrics.max_energy_error_j);
    assert!(
        end.metrics.max_flight_path_drift_m.unwrap() < 1e-8,
        "a parabola between takes: {:?}",
        end.metrics.max_flight_path_drift_m
    );
    assert!(end.metrics.impact_loss_j > 0.1);
}

fn standing(body: &Body, mu: f64, settings: &str, object: &str) -> String {
    let robot = body.robot(&format!("position = [0, 0, {}]", body.half[2]));
    format!("duration = 0.8\nfloor = {{ friction = {mu} }}\n{robot}{settings}{object}")
}

#[test]
fn a_standing_box_that_catches_a_mass_is_held_by_the_floor() {
    let (body, mu) = (Body::new([0.2, 0.2, 0.02], 2.0), 0.3);
    // Dropped on the box, thrown at it, and both: the floor's impulses are m u_z and at most mu
    // times that.
    for (u, slides) in
        [([0.0, 0.0, -2.0], false), ([3.0, 0.0, 0.0], true), ([3.0, 0.0, -2.0], true), ([0.4, 0.0, -2.0], false)]
    {
        let [x, _, z] = u;
        let text = object(&format!("start = 0.2\nvelocity = {u:?}")).replace(&format!("[{R}, 0, 0]"), "[0, 0, 0]");
        let (metrics, sim) = {
            let mut sim = simulation(&standing(&body, mu, TIGHT, &text));
            (finish(&mut sim, &mut NullObserver), sim)
        };
        let whole = M + body.mass;
        let speed = if slides { (M * x - mu * M * -z) / whole } else { 0.0 };
        let way = speed * speed / (2.0 * mu * G);
        let place = sim.plant().state.position;
        // Integration at relative tolerance 1e-9; the event that ends the slide is located to 1e-13
        // of a step.
        assert!((place - Vector3::new(way, 0.0, body.half[2])).norm() < 1e-9, "{u:?}: {place} {way}");
        let normal = metrics.final_normal_force_n.expect("it lies");
        assert!((normal - whole * G).abs() < 1e-9 * whole * G, "{normal}");
        let lost = 0.5 * M * (x * x + z * z) - 0.5 * whole * speed * speed;
        assert!((metrics.impact_loss_j - lost).abs() < 1e-10, "{u:?}: {} {lost}", metrics.impact_loss_j);
        assert!(metrics.max_energy_error_j < 1e-10 && metrics.inconsistent == 0, "{metrics:?}");
    }
}

#[test]
fn every_contact_method_supports_a_carried_object() {
    let body = Body::new([0.2, 0.2, 0.02], 2.0);
    let text = object("start = 0.2\nvelocity = [0, 0, -1]").replace(&format!("[{R}, 0, 0]"), "[0, 0, 0]");
    for (method, integrator) in [
        ("exact", "dopri5"),
        ("exact", "semi-implicit"),
        ("one-step", "dopri5"),
        ("one-step", "semi-implicit"),
        ("penalty", "dopri5"),
        ("lcp", "semi-implicit"),
        ("ncp", "semi-implicit"),
    ] {
        let settings = format!("contact.method = \"{method}\"\nintegrator.method = \"{integrator}\"\n");
        let m = run(&standing(&body, 0.5, &settings, &text));
        let normal = m.final_normal_force_n.expect("it lies");
        // Springs still oscillate slightly, and their floor deflects by m g / (4 k).
        let allowed = if method == "penalty" { 1e-2 } else { 1e-6 };
        assert!((normal / ((M + body.mass) * G) - 1.0).abs() < allowed, "{method} {integrator}: {normal}");
        assert!((m.final_base_position[2] - body.half[2]).abs() < 1e-4, "{method} {integrator}: {m:?}");
        assert!(m.max_energy_error_j < 0.05, "{method} {integrator}: {}", m.max_energy_error_j);
    }
}

#[test]
fn a_standing_robot_picks_up_a_load() {
    let text = "duration = 1.5
        robot = { model = \"robots/hoap2/hoap2.toml\" }
        [[force]]
        type = \"carried-object\"
        link = \"torso\"
        mass = 0.5
        position = [0.05, 0.0, 0.05]
        start = 0.3
        duration = 0.8\n";
    let mut recorded = Recording::default();
    let m = finish(&mut simulation(text), &mut recorded);
    let messages: Vec<_> =
        recorded.events.iter().filter(|e| e.kind == "object").map(|e| (e.time, e.message.as_str())).collect();
    assert_eq!(messages, [(0.3, "0.5 kg taken"), (1.1, "0.5 kg released")]);
    assert_eq!((m.inconsistent, m.impacts), (0, 0));
    // Integration at relative tolerance 1e-6 of energies of some J.
    assert!(m.max_energy_error_j < 1e-5, "{}", m.max_energy_error_j);
    let force = |t: f64| {
        let s = recorded.snapshots.iter().find(|s| (s.time - t).abs() < 1e-9).expect("an instant of the log");
        s.soles.iter().flat_map(|sole| &sole.forces).map(|f| f.z).sum::<f64>()
    };
    // It sways by less than 1 % of its weight.
    assert!((force(1.0) - force(0.2) - 0.5 * G).abs() < 0.5, "{} {}", force(0.2), force(1.0));
}
