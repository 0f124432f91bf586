//! The time-stepping methods `lcp` and `ncp`: agreement with `exact`, and their known errors as
//! predicted.

use super::body::{Body, G};
use crate::support::runs::{root, run, simulation, watch};
use nalgebra::{Rotation2, Vector2};
use std::f64::consts::{PI, TAU};
use stiction::assemble;
use stiction::sim::Metrics;

const STEP: f64 = 1e-3;

/// A block that slides on friction 0.5 from `velocity`.
fn sliding(velocity: &Vector2<f64>, contact: &str, step: f64) -> Metrics {
    run(&format!(
        "duration = 1.2
        robot = {{ model = \"robots/block/block.toml\", base = {{ linear_velocity = [{}, {}, 0.0] }} }}
        floor = {{ friction = 0.5 }}
        contact = {{ {contact} }}
        integrator = {{ method = \"semi-implicit\", step = {step} }}\n",
        velocity.x, velocity.y
    ))
}

fn at(heading: f64, size: f64) -> Vector2<f64> {
    Rotation2::new(heading) * Vector2::new(size, 0.0)
}

/// End position and duration of a slide that begins with speed `v` at angle `theta` from a
/// direction of the polygon, 0 to pi / m, in axes along that direction.
///
/// Maximum dissipation selects the corner of the polygon nearest to the opposite of the motion.
/// Friction therefore opposes the component along the direction with mu g and does not affect the
/// other: the motion veers. Once it points between two directions both act: it stays on that line,
/// slowed by their mean, mu g cos(pi / m).
fn veering(v: f64, theta: f64, m: f64, mu: f64) -> (Vector2<f64>, f64) {
    let (a, half) = (mu * G, PI / m);
    let across = v * theta.sin();
    let along = across / half.tan();
    let first = (v * theta.cos() - along) / a;
    let way = Vector2::new(first * 0.5 * (v * theta.cos() + along), across * first);
    let (speed, slower) = (across / half.sin(), a * half.cos());
    (way + at(half, speed * speed / (2.0 * slower)), first + speed / slower)
}

#[test]
fn the_polygon_of_lcp_makes_a_sliding_block_veer_as_predicted() {
    let (v, mu) = (2.0, 0.5);
    for m in [4.0, 6.0, 8.0, 16.0] {
        for sector in [0.0, 1.0, m - 1.0] {
            for part in [0.0, 0.1, 0.5, 0.9, 1.0] {
                let (theta, turn) = (part * PI / m, sector * TAU / m);
                let launch = at(theta + turn, v);
                let recording = sliding(&launch, &format!("method = \"lcp\", lcp = {{ facets = {m} }}"), STEP);
                let (way, time) = veering(v, theta, m, mu);
                // Velocities at the ends of steps: the launch is short by half a step.
                let truth = Rotation2::new(turn) * way - launch * (0.5 * STEP);
                let found = Vector2::new(recording.final_base_position[0], recording.final_base_position[1]);
                // The bend falls within a step and so does the stop: mu g dt^2 for each.
                assert!((found - truth).norm() < 1.5 * mu * G * STEP * STEP, "{m} {sector} {part} {found} {truth}");
                let stick = recording.first_stick_s.expect("it stops");
                assert!((stick - time).abs() < 2.0 * STEP, "{stick} {time}");
                assert!(
                    recording.inconsistent == 0 && recording.max_lift_m.unwrap() < 1e-15,
                    "{:?}",
                    recording.max_lift_m
                );
                assert!(recording.final_base_rpy[2].abs() < 1e-9, "it does not turn");
            }
        }
    }
}

#[test]
fn the_extra_distance_of_lcp_between_two_directions_decreases_with_the_facets() {
    let (v, mu) = (2.0, 0.5);
    let way = |m: f64| {
        let heading = PI / m;
        let recording = sliding(&at(heading, v), &format!("method = \"lcp\", lcp = {{ facets = {m} }}"), STEP);
        Vector2::new(recording.final_base_position[0], recording.final_base_position[1]).norm() + 0.5 * v * STEP
    };
    let truth = v * v / (2.0 * mu * G);
    for m in [4.0, 8.0, 16.0, 32.0, 64.0] {
        // Friction lacks 1 - cos(pi / m): 0.293 with four facets, 0.076, 0.019, 0.0048, 0.0012. The
        // stop falls within a step, mu g dt^2 / 8 of a distance of 0.4 m.
        let lacks = 1.0 - truth / way(m);
        assert!((lacks - (1.0 - f64::cos(PI / m))).abs() < 2e-6, "{m} {lacks}");
    }
}

#[test]
fn lcp_along_a_facet_direction_and_ncp_in_any_direction_slide_like_exact() {
    for step in [4e-3, 1e-3] {
        for k in 0..8 {
            let launch = at(TAU * f64::from(k) / 8.0, 2.0);
            let exact = sliding(&launch, "method = \"exact\"", step);
            let lcp = sliding(&launch, "method = \"lcp\"", step);
            let oblique = at(0.3 + f64::from(k), 2.0);
            let pair = [sliding(&oblique, "method = \"exact\"", step), sliding(&oblique, "method = \"ncp\"", step)];
            for axis in 0..3 {
                // The same equations in the same steps; rounding, and for ncp its tolerance, 1e-9 m/s over half a second.
                assert!((exact.final_base_position[axis] - lcp.final_base_position[axis]).abs() < 1e-12);
                assert!((pair[0].final_base_position[axis] - pair[1].final_base_position[axis]).abs() < 1e-9);
            }
            assert_eq!(exact.first_stick_s, lcp.first_stick_s);
            assert_eq!(pair[0].first_stick_s, pair[1].first_stick_s);
        }
    }
}

/// Final speed after 0.2 s of a block of friction 0.5 that is pushed at the height of the floor.
fn pushed(body: &Body, force: &Vector2<f64>, contact: &str) -> f64 {
    let recording = run(&format!(
        "duration = 0.2\nfloor = {{ friction = {{ static = 0.9, kinetic = 0.5 }} }}\n{}
        contact = {{ {contact} }}
        integrator = {{ method = \"semi-implicit\", step = {STEP} }}
        [[force]]
        type = \"constant\"
        link = \"block\"
        point = [0.0, 0.0, {}]
        force = [{}, {}, 0.0]\n",
        body.robot(""),
        -body.half[2],
        force.x,
        force.y
    ));
    assert_eq!(recording.inconsistent, 0);
    Vector2::new(recording.final_base_velocity[0], recording.final_base_velocity[1]).norm()
}

#[test]
fn the_sticking_limit_of_lcp_is_the_polygon() {
    let body = Body::new([0.1, 0.1, 0.05], 1.0);
    // One coefficient, the kinetic one.
    let circle = 0.5 * body.mass * G;
    let check = |heading: f64, limit: f64, contact: &str| {
        let below = pushed(&body, &at(heading, limit * (1.0 - 1e-9)), contact);
        let above = pushed(&body, &at(heading, limit * (1.0 + 1e-9)), contact);
        // 1e-9 mu g for 0.2 s is 9.8e-10 m/s (less the part across the polygon's side).
        assert!(below < 1e-11 && above > 4e-10, "{heading} {contact}: {below:.2e} {above:.2e}");
    };
    for m in [4.0, 6.0, 8.0, 12.0] {
        for k in 0..12 {
            let heading = 0.01 + TAU * f64::from(k) / 12.0;
            // Perpendicular to the side of the polygon in that direction.
            let off = (heading.rem_euclid(TAU / m) - PI / m).abs();
            let limit = circle * f64::cos(PI / m) / off.cos();
            check(heading, limit, &format!("method = \"lcp\", lcp = {{ facets = {m} }}"));
        }
        // The least, in the middle of a side, and the greatest, at a corner.
        check(PI / m, circle * f64::cos(PI / m), &format!("method = \"lcp\", lcp = {{ facets = {m} }}"));
        check(TAU / m, circle, &format!("method = \"lcp\", lcp = {{ facets = {m} }}"));
    }
}

#[test]
fn ncp_holds_up_to_the_circle_but_creeps_near_it_with_few_sweeps() {
    let body = Body::new([0.1, 0.1, 0.05], 1.0);
    let circle = 0.5 * body.mass * G;
    for k in 0..12 {
        let heading = 0.01 + f64::from(k);
        let speed = |part: f64, sweeps: u32| {
            let contact = format!("method = \"ncp\", ncp = {{ iterations = {sweeps}, tolerance = 1e-12 }}");
            pushed(&body, &at(heading, part * circle), &contact)
        };
        let [below, above] = [speed(0.999, 200), speed(1.001, 1000)];
        // Its tolerance, 1e-12 m/s, is reached in 200 sweeps.
        assert!(below < 1e-11, "{below:.2e}");
        // 1e-3 mu g for 0.2 s, less the error of the sweeps of the first step.
        assert!((above / (1e-3 * 0.5 * G * 0.2) - 1.0).abs() < 1e-4, "{above:.2e}");
        // A thousand times nearer to the limit, sweeps hardly converge.
        let near = speed(1.0 - 1e-6, 200);
        assert!(near > 1e-8, "{near:.2e}");
    }
}

const HOAP2: &str = "robot = { model = \"robots/hoap2/hoap2.toml\" }
    floor = { friction = 0.8 }
    integrator = { method = \"semi-implicit\", step = 1e-3 }\n";

/// HOAP-2 stands for a second with `sweeps` sweeps a step. Returns its creep (m/s, root mean
/// square), the greatest penetration (m), and the part of its weight that the floor does not carry
/// at the end.
fn cut_short(sweeps: u32) -> [f64; 3] {
    let (m, recording) = watch(&format!(
        "duration = 1.0\n{HOAP2}contact = {{ method = \"ncp\", ncp = {{ iterations = {sweeps}, tolerance = 1e-15 }} }}\n"
    ));
    let end = recording.snapshots.last().expect("the end is reported");
    let weight = simulation(HOAP2).plant().model.mass() * G;
    let load: f64 = end.soles.iter().flat_map(|s| &s.forces).map(|f| f.z).sum();
    [m.rms_creep_speed_m_per_s, m.max_penetration_m, (load / weight - 1.0).abs()]
}

#[test]
fn the_error_of_ncp_decreases_with_its_sweeps() {
    let all = [1, 2, 5, 10, 20].map(cut_short);
    all.iter().for_each(|x| println!("{x:.2?}"));
    for (few, more) in all.iter().zip(&all[1..]) {
        for part in 0..2 {
            assert!(more[part] < 0.2 * few[part], "{part} {few:?} {more:?}");
        }
    }
    // With one sweep the floor force errs by a tenth of the weight; five suffice.
    assert!(all[0][2] > 0.05 && all[2][2] < 1e-6, "{all:?}");
}

#[test]
fn stepping_methods_refuse_unsupported_settings() {
    let refused = |text: &str| {
        let file = stiction::scenario::parse(
            &root().join("test.toml"),
            format!("robot.model = \"robots/block/block.toml\"\n{text}"),
        );
        let run = file.and_then(|f| f.expand(&[])).unwrap_or_else(|e| panic!("{e}")).remove(0);
        let robot = stiction::robot::load(&run.resolve(&run.scenario.robot.model)).unwrap_or_else(|e| panic!("{e}"));
        assemble::setup(&run, &robot).err().map(|e| e.to_string()).unwrap_or_default()
    };
    let fixed = "integrator = { method = \"semi-implicit\" }\n";
    for method in ["lcp", "ncp"] {
        assert_eq!(refused(&format!("{fixed}contact = {{ method = \"{method}\" }}")), "");
        let adaptive = refused(&format!("contact = {{ method = \"{method}\" }}"));
        assert!(adaptive.contains(&format!("`contact.method` = \"{method}\"")), "{adaptive}");
        assert!(
            adaptive.contains("`integrator.method` = \"dopri5\"") && adaptive.contains("test.toml:2:"),
            "{adaptive}"
        );
        let forced = "forced = [{ sole = \"bottom\", state = \"face-static\" }]";
        let forced = refused(&format!("{fixed}contact = {{ method = \"{method}\", {forced} }}"));
        assert!(forced.contains("`contact.forced` does not work with") && forced.contains(method), "{forced}");
    }
    let corners: Vec<[f64; 3]> =
        (0..63).map(|k| [f64::cos(0.1 * f64::from(k)), f64::sin(0.1 * f64::from(k)), 0.0]).collect();
    let many = refused(&format!(
        "robot.soles = [{{ name = \"round\", link = \"block\", polygon = {corners:?} }}]\n{fixed}
        contact = {{ method = \"lcp\", lcp = {{ facets = 64 }} }}"
    ));
    assert!(many.contains("`contact.lcp.facets` = 64 makes 4158 unknowns of the 63 vertices"), "{many}");
}

#[test]
fn a_slope_holds_below_the_least_friction_of_the_polygon_for_any_heading() {
    for (m, part, holds) in [(4.0, 0.999, true), (4.0, 1.001, false), (8.0, 0.999, true), (8.0, 1.001, false)] {
        // The descent direction is between the first two directions.
        let angle = part * f64::atan(0.5 * f64::cos(PI / m));
        let (s, c) = f64::sin_cos(PI / m);
        let axis = nalgebra::Unit::new_unchecked(nalgebra::Vector3::new(-s, c, 0.0));
        let (roll, pitch, yaw) = nalgebra::UnitQuaternion::from_axis_angle(&axis, angle).euler_angles();
        let recording = run(&format!(
            "duration = 0.5
            robot = {{ model = \"robots/block/block.toml\", base = {{ rpy = [{roll}, {pitch}, {yaw}] }} }}
            floor = {{ friction = 0.5, rpy = [{roll}, {pitch}, {yaw}] }}
            contact = {{ method = \"lcp\", lcp = {{ facets = {m} }} }}
            integrator = {{ method = \"semi-implicit\", step = {STEP} }}\n"
        ));
        let speed = nalgebra::Vector3::from(recording.final_base_velocity).norm();
        let free = G * (angle.sin() - 0.5 * f64::cos(PI / m) * angle.cos()) * 0.5;
        if holds {
            assert!(speed < 1e-12, "{m} {speed}");
        } else {
            assert!((speed - free).abs() < 1e-10 && free > 1e-3, "{m} {speed} {free}");
        }
    }
}

#[test]
fn a_block_falls_and_lands_like_with_exact() {
    for (tilt, height) in [("[0.0, 0.0, 0.0]", 0.15), ("[0.2, 0.1, 0.3]", 0.3)] {
        let fall = |method: &str| {
            let m = run(&format!(
                "duration = 1.5
                robot = {{ model = \"robots/block/block.toml\", base = {{ position = [0, 0, {height}], rpy = {tilt} }} }}
                floor = {{ friction = 0.6 }}
                contact = {{ method = \"{method}\", lcp = {{ facets = 32 }} }}
                integrator = {{ method = \"semi-implicit\", step = {STEP} }}\n"
            ));
            println!("{tilt} {method} {:?} {:?}", m.final_base_position, m.final_base_rpy);
            m
        };
        let [exact, lcp, ncp] = ["exact", "lcp", "ncp"].map(fall);
        for m in [&lcp, &ncp] {
            assert_eq!((m.inconsistent, m.first_touchdown_s), (0, exact.first_touchdown_s));
            // It rests on the floor: the next step corrects penetration.
            assert!((m.final_base_position[2] - 0.05).abs() < 1e-9, "{}", m.final_base_position[2]);
            assert!(m.max_penetration_m < 1e-5, "{}", m.max_penetration_m);
            // The impact dissipates the whole fall, up to the error of steps of 1 ms.
            let lost = G * (height - 0.05);
            assert!(((m.impact_loss_j + m.friction_loss_j) / lost - 1.0).abs() < 0.02, "{} {lost}", m.impact_loss_j);
        }
    }
}

#[test]
fn a_humanoid_stands_like_with_exact_and_the_floor_carries_it() {
    let standing = |contact: &str| {
        let (m, recording) = watch(&format!("duration = 1.0\n{HOAP2}contact = {{ {contact} }}\n"));
        let end = recording.snapshots.last().expect("the end is reported").clone();
        let load: f64 = end.soles.iter().flat_map(|s| &s.forces).map(|f| f.z).sum();
        let states = end.soles.iter().map(|s| s.state.clone()).collect::<Vec<_>>();
        (m, load, states)
    };
    let weight = simulation(HOAP2).plant().model.mass() * G;
    let (exact, load, states) = standing("method = \"exact\"");
    assert_eq!(states, ["face-static", "face-static"]);
    for contact in ["method = \"lcp\"", "method = \"lcp\", lcp = { facets = 4 }", "method = \"ncp\""] {
        let (m, carried, same) = standing(contact);
        assert_eq!((m.inconsistent, m.state_changes, same), (0, 0, states.clone()), "{contact}");
        for axis in 0..3 {
            // exact leaves vertices below the floor uncorrected, 2e-8 m after the swaying; these
            // methods correct them.
            assert!((m.final_base_position[axis] - exact.final_base_position[axis]).abs() < 5e-8, "{contact}");
        }
        // The same sway; the rest of it after a second accelerates the weight by as much.
        assert!((carried / load - 1.0).abs() < 1e-6, "{contact}: {carried} {load}");
        assert!((carried / weight - 1.0).abs() < 1e-3, "{contact}: {carried} {weight}");
    }
}

/// A push of half-sine profile over one, two or five steps transfers its impulse to a flying block.
/// Midpoint sums of a half-sine over n steps are (pi / 2n) / sin(pi / 2n) of its integral.
#[test]
fn a_short_push_transfers_its_impulse() {
    for n in [1, 2, 5, 50] {
        let duration = 1e-3 * f64::from(n);
        let force = 0.5 * std::f64::consts::PI / duration;
        let m = run(&format!(
            "duration = 0.1\ngravity = [0, 0, 0]\nintegrator = {{ method = \"semi-implicit\", step = 1e-3 }}
            robot = {{ model = \"robots/block/block.toml\", base = {{ position = [0, 0, 1] }} }}
            force = [{{ type = \"push\", link = \"block\", force = [{force:?}, 0, 0], start = 0.02, duration = {duration:?}, profile = \"half-sine\" }}]"
        ));
        let x = std::f64::consts::PI / (2.0 * f64::from(n));
        // 1 N s on 1 kg. The steps' instants are sums of 1e-3 s, with rounding.
        assert!((m.final_base_velocity[0] - x / x.sin()).abs() < 1e-9, "{n}: {}", m.final_base_velocity[0]);
    }
}

#[test]
fn a_remainder_of_rounding_between_two_instants_is_no_motion() {
    // 0.2 + 0.1 is one rounding above the control tick at 0.3 s. Steps between both, 6e-17 s, once closed gaps of
    // rounding at 1e6 m/s. With the shorter push both instants are one.
    for method in ["exact", "one-step", "lcp", "ncp", "penalty"] {
        let end = |duration: f64| {
            let metrics = run(&format!(
                "duration = 0.31
                robot = {{ model = \"robots/hoap2/hoap2.toml\" }}
                floor.friction = {{ static = 0.3, kinetic = 0.2 }}
                contact.method = \"{method}\"
                integrator = {{ method = \"semi-implicit\", step = 1e-3 }}
                force = [{{ type = \"push\", link = \"torso\", force = [25, 5, 0], start = 0.2, duration = {duration} }}]
                [[task]]
                type = \"sine\"
                ramp = 0.1
                duration = 0.31
                joints = {{ left_shoulder_pitch = {{ amplitude = 0.01, frequency = 4 }} }}\n"
            ));
            (metrics.final_base_position, metrics.final_base_velocity)
        };
        let ((p, v), (q, w)) = (end(0.1), end(0.099_999_999_999_999_98));
        for axis in 0..3 {
            // Rounding, amplified by the states of sliding vertices.
            assert!((p[axis] - q[axis]).abs() < 1e-9, "{method}: {p:?} {q:?}");
            assert!((v[axis] - w[axis]).abs() < 1e-7, "{method}: {v:?} {w:?}");
        }
    }
}
