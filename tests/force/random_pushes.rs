//! `random-pushes`: reported pushes act as reported, and seeds determine them.

use super::End;
use crate::analytic::body::Body;
use crate::support::runs::{Recording, TIGHT, finish, simulation};
use nalgebra::Vector3;
use stiction::sim::SimEvent;

fn pushed(body: &Body, seed: u64, rest: &str) -> (End, Vec<SimEvent>) {
    let robot = body.floating("position = [0, 0, 1]");
    let text = format!(
        "duration = 3.0\nseed = {seed}\ngravity = [0, 0, 0]\n{robot}{TIGHT}
        [[force]]\ntype = \"random-pushes\"\nlinks = [\"block\"]\nmagnitude = [2, 5]\npush_duration = [0.05, 0.2]
        start = 0.2\nduration = 2.5\n{rest}\n"
    );
    let (mut sim, mut recorded) = (simulation(&text), Recording::default());
    let metrics = finish(&mut sim, &mut recorded);
    let v = &sim.plant().state.v;
    let end = End { position: sim.plant().state.position, velocity: Vector3::new(v[0], v[1], v[2]), metrics };
    (end, recorded.events.into_iter().filter(|e| e.kind == "push").collect())
}

/// Force and duration, parsed from the message of an event.
fn parse_push(event: &SimEvent) -> (Vector3<f64>, f64) {
    let digits = |c: char| !c.is_ascii_digit() && c != '.' && c != '-';
    let n: Vec<f64> = event.message.split(digits).filter_map(|w| w.parse().ok()).collect();
    (Vector3::new(n[0], n[1], n[2]), n[3])
}

#[test]
fn reported_pushes_give_the_momentum() {
    let body = Body::new([0.1, 0.1, 0.05], 2.0);
    for (profile, area) in [("constant", 1.0), ("half-sine", 2.0 / std::f64::consts::PI), ("triangle", 0.5)] {
        let (end, events) = pushed(&body, 3, &format!("number = 8\ndirection = \"any\"\nprofile = \"{profile}\""));
        assert_eq!(events.len(), 8);
        let impulse: Vector3<f64> = events.iter().map(|e| parse_push(e).0 * parse_push(e).1 * area).sum();
        // Forces are reported to 1e-3 N, durations to 1e-4 s: 8 pushes of up to 5 N and 0.2 s.
        assert!((end.velocity * body.mass - impulse).norm() < 8.0 * (0.5e-3 * 0.2 + 5.0 * 0.5e-4), "{impulse}");
        assert!(impulse.norm() > 0.1);
        for event in &events {
            let (force, duration) = parse_push(event);
            assert!((0.2..2.7).contains(&event.time) && event.subject == "block", "{event:?}");
            assert!((1.998..5.002).contains(&force.norm()) && (0.0499..0.2001).contains(&duration), "{event:?}");
        }
        assert!(events.iter().any(|e| parse_push(e).0.z.abs() > 0.5), "not all horizontal");
        assert!(end.metrics.max_energy_error_j < 1e-8, "{}", end.metrics.max_energy_error_j);
    }
}

#[test]
fn pushes_depend_on_the_seed_and_the_position_in_the_file() {
    let body = Body::new([0.1, 0.1, 0.05], 2.0);
    let pushes = |seed, rest| pushed(&body, seed, rest).1.into_iter().map(|e| (e.time, e.message)).collect::<Vec<_>>();
    let first = pushes(1, "rate = 4");
    assert_eq!(first, pushes(1, "rate = 4"));
    assert_ne!(first, pushes(2, "rate = 4"));
    assert!(first.iter().all(|(_, m)| m.contains(", 0.000) N")), "horizontal by default: {first:?}");
    // A second entry draws its own pushes.
    let both =
        pushes(1, "rate = 4\n[[force]]\ntype = \"random-pushes\"\nlinks = [\"block\"]\nmagnitude = [1, 1]\nnumber = 2");
    assert_eq!(both.len(), first.len() + 2);
    assert!(first.iter().all(|push| both.contains(push)));
}
