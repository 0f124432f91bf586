//! Paths through the tree of links.

use crate::robot::{JointId, LinkId, Model};

/// The joints between two links, in ascending order: those on which their relative pose depends.
pub(super) fn joints_between(model: &Model, a: LinkId, b: LinkId) -> Vec<JointId> {
    let (mut a, mut b) = (a.0, b.0);
    let mut joints = Vec::new();
    // A parent has a smaller index, so the larger of the two is never an ancestor of the other.
    while a != b {
        let low = a.max(b);
        joints.push(JointId(low - 1));
        let up = model.links[low].parent.map_or(0, |p| p.0);
        if a > b { a = up } else { b = up }
    }
    joints.sort_unstable();
    joints
}

/// For every link the nearest link that satisfies `is_body`: itself or an ancestor.
pub(super) fn carriers(model: &Model, is_body: impl Fn(LinkId) -> bool) -> Vec<Option<LinkId>> {
    let mut carriers: Vec<Option<LinkId>> = Vec::with_capacity(model.links.len());
    for (i, link) in model.links.iter().enumerate() {
        let own = is_body(LinkId(i)).then_some(LinkId(i));
        carriers.push(own.or_else(|| link.parent.and_then(|p| carriers[p.0])));
    }
    carriers
}
