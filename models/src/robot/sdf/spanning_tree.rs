//! The tree of a model's links: which joint moves each link, and which joints close loops.

use super::convert;
use crate::robot::robot_error::RobotError;
use crate::sdf::{Resolved, SdfError};

/// The tree.
pub(super) struct SpanningTree {
    /// For each link the joints of the tree of which it is the parent, in file order; last those of
    /// the world.
    pub joints_of: Vec<Vec<usize>>,
    /// Links that no joint moves.
    pub roots: Vec<usize>,
    /// Joints to links that another joint moves, in file order.
    pub closing: Vec<usize>,
}

impl SpanningTree {
    /// The first joint to a link moves it; later ones close loops. Errors: no links, a joint to the
    /// world or to its own parent, links that no root leads to.
    pub fn new(resolved: &Resolved) -> Result<Self, RobotError> {
        let count = resolved.links.len();
        let mut tree = SpanningTree { joints_of: vec![Vec::new(); count + 1], roots: Vec::new(), closing: Vec::new() };
        let mut is_moved = vec![false; count];
        for (j, joint) in resolved.joints.iter().enumerate() {
            let refuse = |message: String, expected: &str| {
                let error = SdfError::new(joint.joint.at.clone(), message).element(format!("joint `{}`", joint.name));
                convert(error.expected(expected))
            };
            let Some(child) = joint.child else {
                let message = format!("the child of joint `{}` is the world", joint.name);
                return Err(refuse(message, "the world as parent"));
            };
            if joint.parent == Some(child) {
                let message = format!("joint `{}` connects a link with itself", joint.name);
                return Err(refuse(message, "two links"));
            }
            match std::mem::replace(&mut is_moved[child], true) {
                true => tree.closing.push(j),
                false => tree.joints_of[joint.parent.unwrap_or(count)].push(j),
            }
        }
        tree.roots = (0..count).filter(|link| !is_moved[*link]).collect();
        tree.check_connected(resolved)?;
        Ok(tree)
    }

    fn check_connected(&self, resolved: &Resolved) -> Result<(), RobotError> {
        let world = resolved.links.len();
        let mut reached = vec![false; world + 1];
        let mut stack: Vec<usize> = self.roots.iter().copied().chain([world]).collect();
        while let Some(link) = stack.pop() {
            reached[link] = true;
            stack.extend(self.joints_of[link].iter().filter_map(|&j| resolved.joints[j].child));
        }
        let Some(lost) = (0..world).find(|link| !reached[*link]) else { return Ok(()) };
        let link = &resolved.links[lost];
        let message = format!("the joints above link `{}` form a ring without a root", link.name);
        let error = SdfError::new(link.link.at.clone(), message).element(format!("link `{}`", link.name));
        Err(convert(error.expected("a link that is the child of no joint")))
    }
}
