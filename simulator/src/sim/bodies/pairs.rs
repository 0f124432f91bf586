//! Pairs of bodies that may touch, and their friction.

use super::{Body, FloorFriction, Friction};
use crate::dynamics::reduced::BodyId;

/// Friction of a pair: the smaller coefficients of both bodies. One without friction takes that of the
/// other, two without take the floor's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairFriction {
    /// The smaller coefficients of those that have their own.
    own: Option<Friction>,
    /// The floor's part.
    floor: FloorFriction,
}

impl PairFriction {
    /// Friction between two bodies.
    pub fn of(a: &Body, b: &Body) -> Self {
        let own = Friction::smaller(a.friction, b.friction);
        let floor = a.floor.max(b.floor);
        let is_without = own.is_none() && floor == FloorFriction::None;
        PairFriction { own, floor: if is_without { FloorFriction::Plane } else { floor } }
    }

    /// Friction that is given for a pair.
    pub fn given(friction: Friction) -> Self {
        PairFriction { own: Some(friction), floor: FloorFriction::None }
    }

    /// Whether it depends on the region of the floor.
    pub fn has_regions(&self) -> bool {
        self.floor == FloorFriction::Regions
    }

    /// The coefficients where those of the floor are `floor`.
    pub fn with(&self, floor: Friction) -> Friction {
        let of_floor = (self.floor != FloorFriction::None).then_some(floor);
        Friction::smaller(self.own, of_floor).unwrap_or(floor)
    }
}

/// Two bodies that may touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// Indices of bodies A and B.
    pub bodies: (usize, usize),
    /// The link of A, and that of B unless the world carries it.
    pub links: (BodyId, Option<BodyId>),
    /// Friction between them.
    pub friction: PairFriction,
}

/// All pairs of `bodies` that `may_touch` accepts and of which at least one moves. `between` gives the
/// friction of a pair of its own; others have that of their bodies.
pub fn pairs(
    bodies: &[Body],
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
            let own = || PairFriction::of(first, second);
            let friction = between(first, second).map_or_else(own, PairFriction::given);
            pairs.push(Pair { bodies, links, friction });
        }
    }
    pairs
}
