//! Bodies on any number of feet: three, four and six points (27, 81 and 729 states), lines.
//!
//! Rigid-body physics does not determine how redundant feet share a load, so the tests compare only
//! sums and motions.

use super::body::G;
use super::planar::on_feet;
use crate::support::runs::{Recording, TIGHT, rk4, watch};
use nalgebra::Vector3;
use stiction::sim::Metrics;

/// Points under the block of the tree (1 kg, centre 0.05 m up).
const TRIPOD: &[[f64; 2]] = &[[0.1, 0.0], [-0.08, 0.09], [-0.07, -0.1]];
const QUADRUPED: &[[f64; 2]] = &[[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]];
const HEXAPOD: &[[f64; 2]] = &[[0.1, -0.1], [0.0, -0.12], [-0.1, -0.1], [0.1, 0.1], [0.0, 0.11], [-0.1, 0.1]];

/// `robot.soles` with one point foot per entry, in this order.
fn soles(feet: &[[f64; 2]], order: &[usize]) -> String {
    let entries = order.iter().map(|&i| {
        let [x, y] = feet[i];
        format!("{{ name = \"foot-{i}\", link = \"block\", polygon = [[{x:?}, {y:?}, -0.05]] }}")
    });
    format!("[{}]", entries.collect::<Vec<_>>().join(", "))
}

fn orders(n: usize) -> [Vec<usize>; 3] {
    [(0..n).collect(), (0..n).rev().collect(), (1..n).chain([0]).collect()]
}

fn go(soles: &str, base: &str, mu: &str, duration: f64, rest: &str) -> (Metrics, Recording) {
    let (m, recording) = watch(&format!(
        "duration = {duration}
        floor = {{ friction = {mu} }}
        robot = {{ model = \"robots/block/block.toml\", contact = \"soles\", base = {{ {base} }}, soles = {soles} }}
        {TIGHT}\n{rest}"
    ));
    assert_eq!((m.inconsistent, m.jams), (0, 0), "{soles}");
    (m, recording)
}

/// Runs a case with its feet listed in several orders; all must end equally.
fn in_any_order(feet: &[[f64; 2]], base: &str, mu: &str, duration: f64, rest: &str) -> (Metrics, Recording) {
    let [first, others @ ..] = orders(feet.len());
    let (m, recording) = go(&soles(feet, &first), base, mu, duration, rest);
    for order in others {
        let (other, _) = go(&soles(feet, &order), base, mu, duration, rest);
        let pairs = m.final_base_position.iter().zip(other.final_base_position);
        for (a, b) in pairs.chain(m.final_base_rpy.iter().zip(other.final_base_rpy)) {
            // The same equations in another order: rounding, amplified over a second of motion and
            // some events.
            assert!((a - b).abs() < 1e-9, "{order:?} {a} {b}");
        }
    }
    (m, recording)
}

/// The floor's forces carry weight and moments at the end.
fn assert_carries(recording: &Recording, tangential: Vector3<f64>) {
    let end = recording.snapshots.last().expect("the end is reported");
    let at = end.soles.iter().flat_map(|s| s.positions.iter().zip(&s.forces));
    let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
    for (p, f) in at {
        force += f;
        moment += (p - end.com).cross(f);
    }
    // Rounding of forces of 10 N.
    assert!((force - tangential - Vector3::new(0.0, 0.0, G)).norm() < 1e-10, "{force}");
    let pushed = Vector3::new(0.0, 0.0, -0.05).cross(&tangential);
    assert!((moment - pushed).norm() < 1e-10, "{moment} {pushed}");
}

#[test]
fn bodies_stand_and_the_floor_carries_the_weight() {
    for feet in [TRIPOD, QUADRUPED, HEXAPOD] {
        for base in ["", "rpy = [0, 0, 0.7]"] {
            let (m, recording) = in_any_order(feet, base, "0.5", 1.0, "");
            assert_eq!((m.state_changes, m.events), (0, 0));
            assert!(m.max_static_creep_m < 1e-12 && m.max_lift_m.unwrap() < 1e-12 && m.max_penetration_m < 1e-12);
            assert_carries(&recording, Vector3::zeros());
        }
    }
}

#[test]
fn bodies_hold_a_push_that_every_load_distribution_can_carry() {
    // A fifth of the friction limit.
    let push = "[[force]]\ntype = \"constant\"\nlink = \"block\"\npoint = [0, 0, -0.05]\nforce = [0.8, -0.6, 0]\n";
    for feet in [TRIPOD, QUADRUPED, HEXAPOD] {
        let (m, recording) = in_any_order(feet, "", "0.5", 1.0, push);
        assert_eq!((m.state_changes, m.first_slip_s), (0, None));
        assert!(m.max_static_creep_m < 1e-12);
        assert_carries(&recording, Vector3::new(-0.8, 0.6, 0.0));
    }
}

#[test]
fn bodies_slide_and_stop_after_the_closed_distance_for_any_heading() {
    for feet in [TRIPOD, QUADRUPED, HEXAPOD] {
        for (heading, speed, mu) in [(0.3f64, 1.0, 0.4), (2.0, 2.0, 0.5), (-1.2, 0.7, 0.1)] {
            let (s, c) = heading.sin_cos();
            let base = format!("linear_velocity = [{}, {}, 0]", speed * c, speed * s);
            let (m, _) = in_any_order(feet, &base, &mu.to_string(), 1.0, "");
            let way = speed * speed / (2.0 * mu * G);
            let [x, y, z] = m.final_base_position;
            // Integration at relative tolerance 1e-9 and the location of the stop.
            assert!(((x * c + y * s) / way - 1.0).abs() < 1e-8, "{}", (x * c + y * s) / way - 1.0);
            assert!((x * s - y * c).abs() < 1e-9 && m.final_base_rpy[2].abs() < 1e-9 && (z - 0.05).abs() < 1e-12);
            assert_eq!(m.impacts, 0);
        }
    }
}

#[test]
fn bodies_pushed_beyond_friction_move_the_closed_distance() {
    let (force, mu, time) = (7.280_109_889_280_518, 0.4, 0.2);
    let push = "[[force]]\ntype = \"push\"\nlink = \"block\"\npoint = [0, 0, -0.05]\nforce = [7, 2, 0]
        start = 0.1\nduration = 0.2\n";
    let (a, b) = (force - mu * G, mu * G);
    let way = 0.5 * a * time * time * (1.0 + a / b);
    for feet in [TRIPOD, QUADRUPED, HEXAPOD] {
        let (m, _) = in_any_order(feet, "", "{ static = 0.5, kinetic = 0.4 }", 1.0, push);
        let [x, y, _] = m.final_base_position;
        assert!((x.hypot(y) / way - 1.0).abs() < 1e-8, "{}", x.hypot(y) / way - 1.0);
        assert!((x * 2.0 - y * 7.0).abs() < 1e-9 && m.first_slip_s == Some(0.1), "{x} {y} {:?}", m.first_slip_s);
    }
}

#[test]
fn a_spinning_tripod_follows_the_quadrature() {
    let mu = 0.3;
    let start = [0.0, 0.0, 0.0, 1.0, 0.3, 4.0];
    let duration = 0.25;
    let truth = rk4(start, duration, 5000, |_, s| on_feet(TRIPOD, &[mu; 3], [0.05, 1.0, 0.02 / 3.0], s));
    let base = "linear_velocity = [1.0, 0.3, 0], angular_velocity = [0, 0, 4]";
    let (m, _) = in_any_order(TRIPOD, base, "0.3", duration, "");
    let end = [m.final_base_position[0], m.final_base_position[1], m.final_base_rpy[2]];
    for (a, b) in end.iter().zip(truth) {
        // Both integrate to some 1e-10.
        assert!((a - b).abs() < 1e-8, "{end:?} {truth:?}");
    }
    assert!(truth[3] > 0.1 && truth[5] > 0.5, "still sliding: {truth:?}");
    assert_eq!(m.state_changes, 0);
}

#[test]
fn all_feet_land_at_once_and_continue_sliding() {
    let fall = (2.0 * 0.1 / G).sqrt();
    for feet in [TRIPOD, QUADRUPED, HEXAPOD] {
        for speed in [0.0, 0.8] {
            let base = format!("position = [0, 0, 0.15], linear_velocity = [{speed}, 0, 0]");
            let (m, recording) = in_any_order(feet, &base, "0.2", 1.0, "");
            assert_eq!(m.impacts, 1);
            assert!((m.first_touchdown_s.expect("it lands") - fall).abs() < 1e-10);
            assert!((m.final_base_position[2] - 0.05).abs() < 1e-10 && m.final_base_rpy[2].abs() < 1e-9);
            // Loss of the landing: friction of mu times the impulse m sqrt(2 g h), acting at the
            // floor.
            let left = speed - 0.2 * (2.0 * G * 0.1).sqrt();
            let way = speed * fall + if speed > 0.0 { left * left / (2.0 * 0.2 * G) } else { 0.0 };
            assert!((m.final_base_position[0] - way).abs() < 1e-8, "{} {way}", m.final_base_position[0]);
            assert_carries(&recording, Vector3::zeros());
        }
    }
}

#[test]
fn one_foot_after_the_other_lands_and_energy_is_accounted_for() {
    for (feet, base) in [
        (TRIPOD, "position = [0, 0, 0.15], rpy = [0.1, 0.07, 0.3]"),
        (TRIPOD, "position = [0, 0, 0.15], rpy = [0.1, 0.07, 0.3], linear_velocity = [0.8, 0.2, 0]"),
        (QUADRUPED, "position = [0, 0, 0.15], rpy = [0.1, 0.07, 0.3]"),
    ] {
        let tolerances = "velocity_tolerance = 1e-3\nacceleration_tolerance = 1e-6\n";
        let [first, others @ ..] = orders(feet.len());
        let drop = |order: &[usize]| {
            let (m, recording) = watch(&format!(
                "duration = 1.5\nfloor = {{ friction = {{ static = 0.5, kinetic = 0.4 }} }}
                stop = {{ sunk_link = \"ignore\" }}
                integrator = {{ relative_tolerance = 1e-9, absolute_tolerance = 1e-11 }}
                robot = {{ model = \"robots/block/block.toml\", contact = \"soles\", base = {{ {base} }}, soles = {} }}
                [contact]\n{tolerances}",
                soles(feet, order)
            ));
            assert_eq!((m.inconsistent, m.jams), (0, 0));
            // The integrator's tolerance on energies of a joule.
            assert!(m.energy_error_j.abs() < 1e-8, "{}", m.energy_error_j);
            assert!(m.impacts >= 3 && (m.final_base_position[2] - 0.05).abs() < 1e-9);
            assert_carries(&recording, Vector3::zeros());
            m
        };
        let m = drop(&first);
        for order in others {
            let other = drop(&order);
            for (a, b) in m.final_base_position.iter().zip(other.final_base_position) {
                assert!((a - b).abs() < 1e-9, "{order:?} {a} {b}");
            }
        }
    }
}

const LINE: &str = "[{ name = \"line\", link = \"block\", polygon = [[-0.1, 0, -0.05], [0.1, 0, -0.05]] }]";

#[test]
fn a_body_on_one_line_foot_falls_over_as_a_pendulum() {
    // Starts rotating about the line at 0.3 rad/s; I = m (a^2 + c^2) / 3 + m c^2 about it.
    let (duration, c) = (0.4, 0.05);
    let base = format!("angular_velocity = [0.3, 0, 0], linear_velocity = [0, {}, 0]", -0.3 * c);
    let (m, recording) = go(LINE, &base, "3.0", duration, "stop.sunk_link = \"ignore\"\n");
    let inertia = (0.01 + 0.0025) / 3.0 + c * c;
    let truth = rk4([0.0, 0.3], duration, 4000, |_, [phi, rate]: &[f64; 2]| [*rate, G * c * phi.sin() / inertia]);
    assert!((m.final_base_rpy[0] - truth[0]).abs() < 1e-8, "{} {truth:?}", m.final_base_rpy[0]);
    assert!(truth[0] > 0.3);
    let end = recording.snapshots.last().expect("the end is reported");
    assert_eq!((end.soles[0].state.as_str(), m.state_changes), ("edge-0-static", 0));
}

#[test]
fn a_body_on_one_line_foot_slides_along_its_line() {
    let (m, _) = go(LINE, "linear_velocity = [1, 0, 0]", "0.3", 1.0, "");
    let way = 1.0 / (2.0 * 0.3 * G);
    assert!((m.final_base_position[0] / way - 1.0).abs() < 1e-8);
    assert!((m.final_base_position[2] - 0.05).abs() < 1e-12);
}

#[test]
fn two_line_feet_stand_and_slide() {
    let line = |y: f64| {
        format!("{{ name = \"at {y}\", link = \"block\", polygon = [[-0.1, {y}, -0.05], [0.1, {y}, -0.05]] }}")
    };
    for list in [[line(-0.1), line(0.1)], [line(0.1), line(-0.1)]].map(|l| format!("[{}]", l.join(", "))) {
        let (m, recording) = go(&list, "", "0.5", 1.0, "");
        assert_eq!((m.state_changes, m.events), (0, 0));
        assert_carries(&recording, Vector3::zeros());
        let (m, _) = go(&list, "linear_velocity = [0.6, 0.8, 0]", "0.5", 1.0, "");
        let way = 1.0 / G;
        let [x, y, _] = m.final_base_position;
        assert!((x.hypot(y) / way - 1.0).abs() < 1e-8 && (x * 0.8 - y * 0.6).abs() < 1e-9, "{x} {y}");
    }
}

/// HOAP-2's soles, listed in the order given, each beginning with vertex `first`.
fn humanoid_soles(order: [&str; 2], first: usize) -> String {
    let corners = [[0.0582, 0.031], [-0.0358, 0.031], [-0.0358, -0.031], [0.0582, -0.031]];
    let entries = order.map(|side| {
        let polygon: Vec<_> = (0..4).map(|i| corners[(first + i) % 4]).map(|[x, y]| [x, y, -0.0405]).collect();
        format!("{{ name = \"{side}\", link = \"{side}_foot\", polygon = {polygon:?} }}")
    });
    format!("[{}]", entries.join(", "))
}

#[test]
fn the_order_of_soles_and_vertices_does_not_change_the_motion_of_a_humanoid() {
    for (force, changes) in [([0.0, 0.0, 0.0], false), ([20.0, 0.0, 0.0], true), ([0.0, 15.0, 0.0], true)] {
        let go = |soles: String| {
            let (m, _) = watch(&format!(
                "duration = 1.0
                robot = {{ model = \"robots/hoap2/hoap2.toml\", contact = \"soles\", soles = {soles} }}
                integrator = {{ relative_tolerance = 1e-9, absolute_tolerance = 1e-11 }}
                contact = {{ velocity_tolerance = 0.02 }}
                [[force]]
                type = \"push\"
                link = \"torso\"
                point = [0, 0, 0.05]
                force = {force:?}
                start = 0.1
                duration = 0.1
                profile = \"half-sine\"\n"
            ));
            assert_eq!((m.inconsistent, m.jams), (0, 0));
            m
        };
        let m = go(humanoid_soles(["l", "r"], 0));
        assert_eq!(m.state_changes > 0, changes, "{force:?} {}", m.state_changes);
        for other in [humanoid_soles(["r", "l"], 0), humanoid_soles(["l", "r"], 1), humanoid_soles(["r", "l"], 3)] {
            let other = go(other);
            assert_eq!(m.state_changes, other.state_changes);
            let pairs = m.final_base_position.iter().zip(other.final_base_position);
            for (a, b) in pairs.chain(m.final_base_rpy.iter().zip(other.final_base_rpy)) {
                // Other sums, other rounding, through steps at relative tolerance 1e-9.
                assert!((a - b).abs() < 1e-9, "{force:?} {a} {b}");
            }
        }
    }
}

/// A growing push at the floor, through the point below the mass, slips a body at mu_s m g on any
/// feet: all feet slip together.
#[test]
fn all_feet_slip_together_in_every_direction() {
    for feet in [TRIPOD, QUADRUPED, HEXAPOD] {
        for k in 0..6 {
            let (y, x) = (0.3 + f64::from(k) * std::f64::consts::TAU / 6.0).sin_cos();
            let push = format!(
                "force = [{{ type = \"push\", link = \"block\", point = [0, 0, -0.05], force = [{}, {}, 0], duration = 1.0, profile = \"ramp\" }}]",
                10.0 * x,
                10.0 * y
            );
            let (m, _) = watch(&format!(
                "duration = 0.6\nfloor = {{ friction = {{ static = 0.5, kinetic = 0.4 }} }}\n{push}
                robot = {{ model = \"robots/block/block.toml\", contact = \"soles\", soles = {} }}\n{TIGHT}",
                soles(feet, &(0..feet.len()).collect::<Vec<_>>())
            ));
            let slip = m.first_slip_s.expect("it slips");
            // The margin is a difference of forces of 5 N, located to rounding.
            assert!((slip / (0.5 * G / 10.0) - 1.0).abs() < 1e-9, "{} feet, heading {k}: {slip}", feet.len());
            assert_eq!((m.inconsistent, m.jams), (0, 0));
        }
    }
}
