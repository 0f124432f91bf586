//! Elements outside of `<worldbody>` that a world does not use, and the bodies that its constraints
//! hold.

use std::collections::HashSet;

use super::bodies::Bodies;
use super::document::{Document, Id};
use super::ignored::Ignored;

/// Reports each kind of unused element. Returns the bodies under the world that a constraint of
/// `<equality>` holds, alone or to what is fixed.
pub(super) fn report(document: &Document, bodies: &Bodies, ignored: &mut Ignored) -> HashSet<usize> {
    let children = |section| document.section(section).flat_map(|section| document.children(section).iter().copied());
    for id in children("contact") {
        let tag = document.tag(id);
        ignored.note(id, format!("<{tag}> of <contact> is ignored: `[[contact.pair]]` of the scenario sets pairs"));
    }
    for id in children("sensor") {
        ignored.note(id, format!("sensors <{}> are ignored", document.tag(id)));
    }
    for id in children("keyframe") {
        ignored.note(id, "of <key> only the positions of joints count");
    }
    let (tops, mut held) = (bodies.tops(), HashSet::new());
    for id in children("equality") {
        let ends = ends(document, bodies, id);
        let moving: HashSet<usize> =
            ends.into_iter().map(|body| tops[body]).filter(|&top| moves(bodies, &tops, top)).collect();
        match moving.len() {
            0 => {}
            1 => held.extend(moving),
            _ => {
                ignored.note(id, format!("<{}> between different models of a world is ignored", document.tag(id)));
            }
        }
    }
    held
}

/// Bodies that a constraint names, by their joints and sites too.
fn ends(document: &Document, bodies: &Bodies, id: Id) -> Vec<usize> {
    let named = |key: &str| document.text(id, key);
    let of_joint = |name: &str| {
        let is_own = |joint: &super::bodies::Held| document.text(joint.view.id(), "name") == Some(name);
        bodies.bodies.iter().position(|body| body.joints.iter().any(is_own))
    };
    let of_site = |name: &str| {
        let site = bodies.sites.iter().find(|site| site.name.as_deref() == Some(name));
        site.map(|site| site.body)
    };
    let by_body = ["body1", "body2"].into_iter().filter_map(named).filter_map(|name| bodies.named(name));
    let by_joint = ["joint1", "joint2"].into_iter().filter_map(named).filter_map(of_joint);
    let by_site = ["site1", "site2"].into_iter().filter_map(named).filter_map(of_site);
    by_body.chain(by_joint).chain(by_site).collect()
}

/// True for a body under the world that has joints or carries some.
fn moves(bodies: &Bodies, tops: &[usize], top: usize) -> bool {
    top != 0 && bodies.bodies.iter().zip(tops).any(|(body, own)| *own == top && !body.joints.is_empty())
}
