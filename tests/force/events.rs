//! Events on forces: unchanged forces continue, and the log reports only actual changes.

use super::End;
use crate::analytic::body::Body;
use crate::support::runs::{Recording, TIGHT, finish, simulation};
use nalgebra::Vector3;

/// A box in the air without gravity: its final state, and the events of a kind.
fn flight(kind: &str, duration: f64, text: &str) -> (End, Vec<(f64, String)>) {
    let body = Body::new([0.1, 0.1, 0.05], 2.0);
    let robot = body.floating("position = [0, 0, 1], linear_velocity = [0, 0.05, 0]");
    let mut sim = simulation(&format!("duration = {duration:?}\ngravity = [0, 0, 0]\n{robot}{TIGHT}{text}"));
    let mut recorded = Recording::default();
    let metrics = finish(&mut sim, &mut recorded);
    let state = &sim.plant().state;
    let (position, velocity) = (state.position, Vector3::new(state.v[0], state.v[1], state.v[2]));
    let events = recorded.events.into_iter().filter(|e| e.kind == kind).map(|e| (e.time, e.message)).collect();
    (End { position, velocity, metrics }, events)
}

fn spring(anchor: &str) -> String {
    format!("[[force]]\ntype = \"spring\"\nlink = \"block\"\nstiffness = 50\ndamping = 2\nstart = 0.2\n{anchor}\n")
}

fn event(at: f64, set: &str) -> String {
    format!("[[event]]\nat = {at}\nset = {{ {set} }}\n")
}

#[test]
fn setting_a_spring_to_its_current_values_does_not_move_it() {
    for anchor in [
        "",
        "anchor = { velocity = [0.3, 0, 0] }",
        "anchor = { position = [0.1, 0, 1], velocity = [0.3, 0, 0] }",
        "anchor = { sine = { amplitude = [0.1, 0, 0.1], frequency = 1, phase = 0.5 } }",
        "anchor = { waypoints = [{ at = 0, position = [0, 0, 1] }, { at = 1, position = [0.2, 0, 1] }] }",
    ] {
        let (alone, events_alone) = flight("spring", 1.5, &spring(anchor));
        let same = "\"force.0.stiffness\" = 50, \"force.0.damping\" = 2.0, \"force.0.rest_length\" = 0";
        let (set, events_set) = flight("spring", 1.5, &(spring(anchor) + &event(0.7, same)));
        // Steps end at the event: integration at 1e-9 over some hundred steps.
        let apart = (set.position - alone.position).norm() + (set.velocity - alone.velocity).norm();
        assert!(apart < 1e-7, "{anchor}: {apart:e}");
        assert_eq!(events_alone.len(), 1, "{events_alone:?}");
        assert_eq!(events_set, events_alone, "{anchor}");
    }
}

#[test]
fn a_newly_attached_spring_exerts_no_force() {
    // Another velocity of the hand: it grips at the current position of the point and moves from
    // there.
    let hand = spring("anchor = { velocity = [0.3, 0, 0] }").replace("damping = 2", "damping = 0");
    let (text, w) = (hand + &event(0.7, "\"force.0.anchor\" = { velocity = [-0.2, 0, 0] }"), 5.0);
    let (at, _) = flight("spring", 0.7, &text);
    let (end, recorded) = flight("spring", 1.0, &text);
    // x'' = w^2 (hand - x) from x = hand = 0 with the speed v: x = u t + (v - u) sin(w t) / w.
    let [u, v, t]: [f64; 3] = [-0.2, at.velocity.x, 1.0 - 0.7];
    let way = u * t + (v - u) * (w * t).sin() / w;
    // Integration at 1e-9.
    assert!((end.position.x - at.position.x - way).abs() < 1e-7, "{} {way}", end.position.x - at.position.x);
    let messages: Vec<_> = recorded.iter().map(|(t, messages)| (*t, &messages[..8])).collect();
    assert_eq!(messages, [(0.2, "attached"), (0.7, "attached")], "{recorded:?}");
}

#[test]
fn past_events_are_not_reported_again() {
    let short = spring("duration = 0.3\nanchor = { position = [0.1, 0, 1] }");
    let (_, recorded) = flight("spring", 1.5, &(short + &event(1.0, "\"force.0.stiffness\" = 60")));
    assert_eq!(recorded.iter().map(|(t, _)| *t).collect::<Vec<_>>(), [0.2, 0.5], "{recorded:?}");
    // The hand releases when an event puts its end into the past, and grips again when one
    // postpones it.
    let set = event(0.7, "\"force.0.duration\" = 0.1") + &event(1.0, "\"force.0.duration\" = 9");
    let (_, recorded) = flight("spring", 1.5, &(spring("") + &set));
    let messages: Vec<_> = recorded.iter().map(|(t, messages)| (*t, &messages[..8])).collect();
    assert_eq!(messages, [(0.2, "attached"), (0.7, "released"), (1.0, "attached")]);

    let pushes = "[[force]]\ntype = \"random-pushes\"\nlinks = [\"block\"]\nnumber = 12\nmagnitude = [1, 1]\n";
    let (_, alone) = flight("push", 1.5, pushes);
    let (_, recorded) = flight("push", 1.5, &(pushes.to_owned() + &event(0.7, "\"force.0.magnitude\" = [2, 2]")));
    let times = |recorded: &[(f64, String)]| recorded.iter().map(|(t, _)| *t).collect::<Vec<_>>();
    assert_eq!((times(&recorded), alone.len()), (times(&alone), 12));
    assert!(alone.iter().any(|(t, _)| *t < 0.7) && alone.iter().any(|(t, _)| *t > 0.7));
    for ((t, before), (_, after)) in alone.iter().zip(&recorded) {
        assert_eq!(before == after, *t < 0.7, "those to come are of the new size: {t} {before} {after}");
    }
}

#[test]
fn all_forces_are_listed() {
    let constant = "[[force]]\ntype = \"constant\"\nlink = \"block\"\nforce = [1, 0, 0]\n";
    let body = Body::new([0.1, 0.1, 0.05], 2.0);
    let more = "[[force]]\ntype = \"random-pushes\"\nlinks = [\"block\"]\nnumber = 30\nmagnitude = [1, 1]
        push_duration = [1, 1]\nduration = 0.4\n";
    let text = format!("duration = 0.5\n{}{}{more}", body.floating("position = [0, 0, 1]"), constant.repeat(20));
    let mut recorded = Recording::default();
    finish(&mut simulation(&text), &mut recorded);
    let listed: Vec<usize> = recorded.snapshots.iter().map(|s| s.external.len()).collect();
    assert_eq!((listed[0], listed.last()), (20, Some(&50)), "{listed:?}");
}
