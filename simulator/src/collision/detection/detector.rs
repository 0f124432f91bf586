//! Distance and collision queries for a sequence of postures.
//!
//! Two layers: first axis-aligned boxes, then the exact distance of the polyhedra. Coherence: each
//! pair starts at the vertices of its last result. This changes only the time: each result is
//! proven ([`super::gjk`]), so it is the same from any start up to rounding.

use nalgebra::Vector3;

use super::epa::Epa;
use super::gjk::{self, Nearest, Outcome, Warm};
use super::posed_bodies::PosedBodies;
use super::support_mapping::SupportMapping;
use crate::collision::CollisionModel;
use crate::collision::kinematics::LinkPose;

/// Distance of a pair of bodies.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Proximity {
    /// Index into [`CollisionModel::pairs`].
    pub pair: usize,
    /// Distance, m; below 0 the bodies overlap, and its magnitude is the shortest translation that
    /// separates them.
    pub distance: f64,
    /// Unit vector from the first body to the second, along which moving the second changes the
    /// distance at rate 1.
    pub normal: Vector3<f64>,
    /// The first body's nearest (or deepest) point, in the frame of the poses, m.
    pub on_a: Vector3<f64>,
    /// The second body's point: `on_a + distance * normal`.
    pub on_b: Vector3<f64>,
}

/// Work done since the counters were reset.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Counts {
    /// Postures set.
    pub postures: u64,
    /// Pairs of boxes compared.
    pub boxes: u64,
    /// Pairs of polyhedra compared.
    pub exact: u64,
    /// Overlapping pairs among them, whose depth was found.
    pub depths: u64,
}

/// Workspace: set a posture by [`Detector::set_poses`], then query. Nothing is allocated after
/// construction. A posture that is not finite counts as a collision.
///
/// # Panics
/// May panic when given another model than the one it was built for.
#[derive(Clone, Debug)]
pub struct Detector {
    scene: PosedBodies,
    warm: Vec<Warm>,
    epa: Epa,
    /// The pairs' bodies.
    pairs: Vec<[usize; 2]>,
    /// Squares of the box gaps of the pairs, for the current query.
    gaps: Vec<f32>,
    /// The nearest pair of the last query, which is probably nearest again.
    nearest: usize,
    /// The colliding pair of the last query.
    hit: usize,
    found: Vec<Proximity>,
    colliding: Vec<usize>,
    /// Work done.
    pub counts: Counts,
}

impl Detector {
    /// For a model's pairs.
    pub fn new(model: &CollisionModel) -> Self {
        let n = model.pairs.len();
        Self {
            scene: PosedBodies::new(&model.bodies),
            warm: vec![Warm::COLD; n],
            epa: Epa::default(),
            pairs: model.pairs.iter().map(|p| p.bodies).collect(),
            gaps: vec![0.0; n],
            nearest: 0,
            hit: 0,
            found: Vec::with_capacity(n),
            colliding: Vec::with_capacity(n),
            counts: Counts::default(),
        }
    }

    /// Discards earlier results, so that later ones do not depend on them, not even in the last
    /// bits.
    pub fn forget(&mut self) {
        self.warm.fill(Warm::COLD);
        (self.nearest, self.hit) = (0, 0);
    }

    /// Moves the bodies to the posture of the next queries. `poses` has one entry per link of the
    /// robot, in any shared frame.
    pub fn set_poses(&mut self, model: &CollisionModel, poses: &[LinkPose]) {
        self.counts.postures += 1;
        self.scene.set_poses(&model.bodies, poses);
    }

    /// Distances and nearest points of all pairs, in the pairs' order.
    pub fn distances(&mut self, model: &CollisionModel) -> &[Proximity] {
        self.found.clear();
        self.scene.transform_vertices(&model.bodies);
        for pair in 0..model.pairs.len() {
            // No distance exceeds infinity.
            let [a, b] = self.scene.transformed(&model.bodies, self.pairs[pair]);
            let work = (&mut self.warm[pair], &mut self.epa, &mut self.counts);
            self.found.extend(exact(pair, &a, &b, f64::INFINITY, work));
        }
        &self.found
    }

    /// The nearest pair (or the one that overlaps most) if it is nearer than `limit`, m.
    pub fn closest(&mut self, model: &CollisionModel, limit: f64) -> Option<Proximity> {
        let mut first = 0;
        for (i, pair) in self.pairs.iter().enumerate() {
            self.gaps[i] = self.scene.gap_squared(*pair);
            if self.gaps[i] < self.gaps[first] {
                first = i;
            }
        }
        self.counts.boxes += model.pairs.len() as u64;
        // Probable pairs first: the sooner a small distance is known, the fewer pairs are compared
        // exactly.
        let likely = [self.nearest, first];
        let mut best = None;
        let mut least = limit;
        for pair in likely.into_iter().chain(0..model.pairs.len()).take_while(|_| !model.pairs.is_empty()) {
            let reach = least.max(0.0);
            if f64::from(self.gaps[pair]) > reach * reach {
                continue;
            }
            // Each pair is compared once.
            self.gaps[pair] = f32::INFINITY;
            let [a, b] = self.scene.posed(&model.bodies, self.pairs[pair]);
            let work = (&mut self.warm[pair], &mut self.epa, &mut self.counts);
            if let Some(found) = exact(pair, &a, &b, reach, work)
                && found.distance < least
            {
                (least, self.nearest) = (found.distance, pair);
                best = Some(found);
            }
        }
        best
    }

    /// Whether any pair is closer than `margin`, m (0: overlaps). Stops at the first.
    pub fn intersects(&mut self, model: &CollisionModel, margin: f64) -> bool {
        // The pair that collided last probably collides again.
        let (n, last) = (model.pairs.len(), self.hit);
        let hit =
            (last..n.min(last + 1)).chain((0..n).filter(|i| *i != last)).find(|&i| self.is_within(model, i, margin));
        self.hit = hit.unwrap_or(last);
        hit.is_some()
    }

    /// All pairs nearer than `margin`, m (0: those that overlap), in ascending order.
    pub fn colliding(&mut self, model: &CollisionModel, margin: f64) -> &[usize] {
        self.colliding.clear();
        for pair in 0..model.pairs.len() {
            if self.is_within(model, pair, margin) {
                self.colliding.push(pair);
            }
        }
        &self.colliding
    }

    /// Proximity of one pair; exact at any distance.
    pub fn proximity(&mut self, model: &CollisionModel, pair: usize) -> Proximity {
        let [a, b] = self.scene.posed(&model.bodies, self.pairs[pair]);
        let work = (&mut self.warm[pair], &mut self.epa, &mut self.counts);
        exact(pair, &a, &b, f64::INFINITY, work).expect("no distance exceeds infinity")
    }

    /// A lower bound of the distance of one pair, m: the distance itself if it is less than
    /// `enough`; 0 when they overlap.
    pub fn clearance(&mut self, model: &CollisionModel, pair: usize, enough: f64) -> f64 {
        self.counts.boxes += 1;
        let bodies = self.pairs[pair];
        let gap = f64::from(self.scene.gap_squared(bodies)).sqrt();
        if gap > enough {
            return gap;
        }
        self.counts.exact += 1;
        let [a, b] = self.scene.posed(&model.bodies, bodies);
        match gjk::distance(&a, &b, &mut self.warm[pair], enough) {
            Outcome::Beyond => enough,
            Outcome::Apart { v, .. } => v.norm(),
            Outcome::Overlap { .. } => 0.0,
        }
    }

    /// Whether one pair is closer than `margin`, m. A pair that is not proven to be farther counts
    /// as closer.
    pub fn is_within(&mut self, model: &CollisionModel, pair: usize, margin: f64) -> bool {
        self.counts.boxes += 1;
        let bodies = self.pairs[pair];
        if f64::from(self.scene.gap_squared(bodies)) > margin * margin {
            return false;
        }
        self.counts.exact += 1;
        let [a, b] = self.scene.posed(&model.bodies, bodies);
        !matches!(gjk::distance(&a, &b, &mut self.warm[pair], margin), Outcome::Beyond)
    }
}

/// The exact layer for one pair; `None` when it is farther apart than `beyond`.
fn exact(
    pair: usize,
    a: &impl SupportMapping,
    b: &impl SupportMapping,
    beyond: f64,
    (warm, epa, counts): (&mut Warm, &mut Epa, &mut Counts),
) -> Option<Proximity> {
    counts.exact += 1;
    match gjk::distance(a, b, warm, beyond) {
        Outcome::Beyond => None,
        Outcome::Apart { v, simplex } => {
            let Nearest { distance, normal, on_a, on_b } = gjk::nearest(a, b, &v, &simplex);
            Some(Proximity { pair, distance, normal, on_a, on_b })
        }
        Outcome::Overlap { simplex } => {
            counts.depths += 1;
            let depth = epa.depth(a, b, &simplex);
            let (on_a, on_b) = (depth.on_a, depth.on_b);
            Some(Proximity { pair, distance: -depth.depth, normal: depth.normal, on_a, on_b })
        }
    }
}
