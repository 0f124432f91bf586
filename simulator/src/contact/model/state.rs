//! Contact states of a sole.
//!
//! A convex planar sole on a plane is free or touches with a vertex, an edge or its face; each
//! touching pattern sticks or slides: 1 + 2 (k + k + 1) states for k >= 3 vertices (19 for a
//! rectangle), 7 for a line foot, 3 for a point. A biped on rectangles has 19 x 19 = 361.
//! `Pivoting` refines sliding: the sole turns about one clamped vertex at rest. It is reported as
//! dynamic and not counted as a separate state.

use super::per_sole::PerSole;
use std::fmt;

/// Which vertices are clamped to the floor.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub enum Pattern {
    /// None.
    #[default]
    Free,
    /// One vertex.
    Vertex(u8),
    /// Vertices `i` and `i + 1` (cyclic).
    Edge(u8),
    /// All.
    Face,
}

impl Pattern {
    /// The smallest pattern of `k` vertices that clamps all for which `clamp` holds.
    pub fn covering(k: usize, clamp: impl Fn(usize) -> bool) -> Pattern {
        SoleState::patterns(k)
            .find(|&p| (0..k).all(|i| !clamp(i) || SoleState::fixed(p).clamps(i, k)))
            .filter(|_| (0..k).any(&clamp))
            .unwrap_or(Pattern::Free)
    }
}

/// Sticking or sliding.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub enum Mode {
    /// The clamped vertices do not move.
    #[default]
    Static,
    /// Every clamped vertex slides.
    Sliding,
    /// The sole slides by turning about this clamped vertex.
    Pivoting(u8),
}

/// The contact state of one sole.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub struct SoleState {
    /// Clamped vertices.
    pub pattern: Pattern,
    /// Sticking or sliding; `Static` when free.
    pub mode: Mode,
}

impl SoleState {
    /// The state of a sole without contact.
    pub const FREE: SoleState = SoleState { pattern: Pattern::Free, mode: Mode::Static };

    /// The static state of a pattern.
    pub fn fixed(pattern: Pattern) -> Self {
        SoleState { pattern, mode: Mode::Static }
    }

    /// The sliding state of a pattern.
    pub fn sliding(pattern: Pattern) -> Self {
        SoleState { pattern, mode: Mode::Sliding }
    }

    /// Whether vertex `i` of `k` is clamped.
    pub fn clamps(self, i: usize, k: usize) -> bool {
        match self.pattern {
            Pattern::Free => false,
            Pattern::Vertex(j) => i == j as usize,
            Pattern::Edge(j) => i == j as usize || i == (j as usize + 1) % k,
            Pattern::Face => true,
        }
    }

    /// Whether the sole slides.
    pub fn is_dynamic(self) -> bool {
        self.pattern != Pattern::Free && self.mode != Mode::Static
    }

    /// Whether the sole touches and sticks.
    pub fn is_static(self) -> bool {
        self.pattern != Pattern::Free && self.mode == Mode::Static
    }

    /// Number of normal constraints: 0 free, 1 vertex, 2 edge, 3 face.
    pub fn normal_rows(self) -> usize {
        match self.pattern {
            Pattern::Free => 0,
            Pattern::Vertex(_) => 1,
            Pattern::Edge(_) => 2,
            Pattern::Face => 3,
        }
    }

    /// Total number of constraint rows: static 3, 5, 6; sliding 1, 2, 3; pivoting two more than
    /// sliding.
    pub fn rows(self) -> usize {
        let n = self.normal_rows();
        match (self.mode, self.pattern) {
            (_, Pattern::Free) => 0,
            (Mode::Static, Pattern::Vertex(_)) => 3,
            (Mode::Static, Pattern::Edge(_)) => 5,
            (Mode::Static, Pattern::Face) => 6,
            (Mode::Sliding, _) => n,
            (Mode::Pivoting(_), _) => n + 2,
        }
    }

    /// Every touching pattern of a sole with `k` vertices.
    pub fn patterns(k: usize) -> impl Iterator<Item = Pattern> {
        let vertices = (0..k).map(|i| Pattern::Vertex(i as u8));
        let edges = (0..if k > 2 { k } else { k - 1 }).map(|i| Pattern::Edge(i as u8));
        vertices.chain(edges).chain((k > 2).then_some(Pattern::Face))
    }

    /// Every state with its refinements: those of [`all`](Self::all) and turning about each clamped
    /// vertex.
    pub fn refined(k: usize) -> impl Iterator<Item = SoleState> {
        let pivots = Self::patterns(k).filter(|p| !matches!(p, Pattern::Vertex(_))).flat_map(move |pattern| {
            let about = move |j: usize| SoleState { pattern, mode: Mode::Pivoting(j as u8) };
            (0..k).filter(move |&j| SoleState::fixed(pattern).clamps(j, k)).map(about)
        });
        Self::all(k).chain(pivots)
    }

    /// Every state of a sole with `k` vertices.
    pub fn all(k: usize) -> impl Iterator<Item = SoleState> {
        std::iter::once(SoleState::FREE)
            .chain(Self::patterns(k).flat_map(|p| [SoleState::fixed(p), SoleState::sliding(p)]))
    }
}

impl fmt::Display for SoleState {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.pattern {
            Pattern::Free => return write!(f, "free"),
            Pattern::Vertex(i) => write!(f, "vertex-{i}")?,
            Pattern::Edge(i) => write!(f, "edge-{i}")?,
            Pattern::Face => write!(f, "face")?,
        }
        write!(f, "-{}", if self.mode == Mode::Static { "static" } else { "dynamic" })
    }
}

/// The states of all soles of a problem; those not set are free.
pub type States = PerSole<SoleState>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_states_by_number_of_vertices() {
        for (k, n) in [(1, 3), (2, 7), (3, 15), (4, 19), (6, 27)] {
            assert_eq!(SoleState::all(k).count(), n, "{k} vertices");
        }
        let biped = SoleState::all(4).flat_map(|l| SoleState::all(4).map(move |r| (l, r))).count();
        assert_eq!(biped, 361);
        let points = |n| SoleState::all(1).count().pow(n);
        assert_eq!([points(3), points(4), points(6)], [27, 81, 729]);
    }

    #[test]
    fn edges_wrap_around() {
        let e = SoleState::fixed(Pattern::Edge(3));
        assert!(e.clamps(3, 4) && e.clamps(0, 4) && !e.clamps(1, 4));
    }
}
