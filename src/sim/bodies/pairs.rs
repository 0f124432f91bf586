//! Pairs of bodies that may touch.

use super::{Body, Friction};
use crate::dynamics::reduced::BodyId;

/// Two bodies that may touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// Indices of bodies A and B.
    pub bodies: (usize, usize),
    /// The link of A, and that of B unless the world carries it.
    pub links: (BodyId, Option<BodyId>),
    /// Friction between them.
    pub friction: Friction,
}

/// All pairs of `bodies` that `may_touch` accepts and of which at least one moves. `between` gives the
/// friction of a pair of its own; others have that of their bodies, or `default`.
pub fn pairs(
    bodies: &[Body],
    default: Friction,
    may_touch: impl Fn(&Body, &Body) -> bool,
    between: impl Fn(&Body, &Body) -> Option<Friction>,
) -> Vec<Pair> {
    let mut pairs = Vec::new();
    for (i, first) in bodies.iter().enumerate() {
        for (j, second) in bodies.iter().enumerate().skip(i + 1) {
            if first.link() == second.link() || !may_touch(first, second) {
                continue;
            }
            let (bodies, links) = match (first.link(), second.link()) {
                (Some(a), b) => ((i, j), (a, b)),
                (None, Some(b)) => ((j, i), (b, None)),
                (None, None) => continue,
            };
            let own = || Friction::of_pair(first.friction, second.friction).unwrap_or(default);
            let friction = between(first, second).unwrap_or_else(own);
            pairs.push(Pair { bodies, links, friction });
        }
    }
    pairs
}
