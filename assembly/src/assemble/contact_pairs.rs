//! Rules for pairs of bodies, and pairs of links of the robot that may touch each other.

use crate::collision::shared_model;
use crate::dynamics::{State, Workspace, kinematics};
use crate::patches::touchable_depth;
use crate::robot::{LinkId, Model, Robot};
use crate::scenario::{ContactPair, Diagnostic, Run, TouchingParts};
use crate::sim::bodies::{Body, FLOOR, Friction, PairRule, PairRules};
use crate::sim::plant::objects::named_links;
use crate::sim::setup::Start;
use crate::text::{pattern, suggest};

use super::friction::extra;
use super::objects::Object;

/// The rules of `[[contact.pair]]`. A name that no body has is an error.
pub(super) fn rules(run: &Run, model: &Model, objects: &[Object], errors: &mut Vec<Diagnostic>) -> PairRules {
    let s = &run.scenario;
    let soles = model.soles.iter().map(|sole| sole.name.as_str());
    // Only with bodies do links have contacts of their own.
    let links = model.links.iter().filter(|_| s.robot.contact == TouchingParts::Bodies);
    let links = links.map(|link| link.name.as_str());
    let of_robot: Vec<&str> = soles.chain(links).collect();
    let objects = named_links(objects.iter().map(|o| (&*o.setup.name, &*o.setup.model)));
    let terrain: Vec<String> = s.terrain.iter().enumerate().map(|(i, spec)| spec.name(i)).collect();
    let mut names = of_robot.clone();
    names.extend(objects.iter().map(|link| link.name.as_str()));
    names.extend(terrain.iter().map(String::as_str));
    names.extend(s.floor.plane.then_some(FLOOR));
    let mut rules = Vec::new();
    for (i, ContactPair { bodies, friction, touch }) in s.contact.pair.iter().enumerate() {
        for (k, name) in bodies.iter().enumerate() {
            if !names.iter().any(|known| pattern::matches(name, known)) {
                let help = suggest::help(name, names.iter().copied());
                errors.push(run.error_at(
                    &format!("contact.pair.{i}.bodies.{k}"),
                    format!("no sole, link, object or terrain is called `{name}`"),
                    Some(help),
                ));
            }
        }
        let [a, b] = bodies;
        let is_robot = |name: &str| of_robot.iter().any(|known| pattern::matches(name, known));
        let is_floor = |name: &str| pattern::matches(name, FLOOR);
        if !touch && s.floor.plane && (is_robot(a) && is_floor(b) || is_robot(b) && is_floor(a)) {
            errors.push(run.error_at(
                &format!("contact.pair.{i}.touch"),
                "soles and links of the robot always touch the floor",
                Some("`robot.soles` and `robot.contact` choose them; `floor.plane = false` removes the plane".into()),
            ));
        }
        let friction = friction.map(|f| Friction { mu_s: f.static_, mu_k: f.kinetic, extra: extra(f) });
        rules.push(PairRule { bodies: bodies.clone(), friction, touch: *touch });
    }
    PairRules(rules)
}

/// Pairs of the robot's links that may touch: those that self-collision monitors, without those that overlap
/// at the start, which a note names.
pub(super) fn own_pairs(
    robot: &Robot,
    model: &Model,
    start: &Start,
    bodies: &[Body],
    notes: &mut Vec<String>,
) -> Vec<[LinkId; 2]> {
    let mut ws = Workspace::new(model);
    let mut state = State::home(model);
    state.joints.copy_from_slice(&start.joints);
    kinematics::update(model, &state, &mut ws);
    let collision = shared_model(model, &robot.self_collision);
    let of_link = |link: LinkId| bodies.iter().filter(move |body| body.link().is_some_and(|of| of.link == link));
    let overlaps = |[a, b]: &[LinkId; 2]| {
        let placement = |body: &Body| body.placement((&ws).into());
        let depth = |a: &Body, b: &Body| touchable_depth(&a.shape, &placement(a), &b.shape, &placement(b));
        of_link(*a).any(|a| of_link(*b).any(|b| depth(a, b) > 0.0))
    };
    let links = collision.pairs.iter().map(|pair| pair.bodies.map(|b| collision.bodies[b].link));
    let (apart, overlapping): (Vec<_>, Vec<_>) = links.partition(|pair| !overlaps(pair));
    if !overlapping.is_empty() {
        let name = |[a, b]: &[LinkId; 2]| format!("`{}` and `{}`", model.links[a.0].name, model.links[b.0].name);
        let list: Vec<String> = overlapping.iter().map(name).collect();
        notes.push(format!("`robot.self_contact`: overlap at the start and do not touch: {}", list.join(", ")));
    }
    apart
}
