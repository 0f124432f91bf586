//! Pairs of bodies that may touch, and the patches of the present state.
//!
//! Both bodies of a pair are convex, so that it touches in one plane. Its corners appear when the distance
//! is at most that of near points ([`super::link_contacts`]), change when a function of their validity
//! becomes negative, an event, and disappear when the bodies are apart.
//!
//! Within a step the distance of a pair that was apart by g_0 at its start is at least
//! `g_0 - way_A - way_B`, with the bounds of [`Placement::way_from`]. While this is positive it takes the
//! place of the distance.

use super::patch_planes::{self, NEAR, ahead, bodies};
use super::placements::Placements;
use super::terrain_pairs::TerrainPairs;
use crate::contact::model::state::{Pattern, SoleState};
use crate::patches::{self, Owner, Placement, Separation, Topology};
use crate::sim::bodies::{Body, Pair, PairPatch, Part};
use crate::sim::plant::Plant;
use nalgebra::Vector3;
use std::collections::HashMap;

/// Corners are kept up to this multiple of the distance at which they appear, so that they do not come and
/// go.
const KEPT: f64 = 2.0;

/// Validity, m, below which corners are computed again: half of that of new ones. Functions that reach zero
/// together in an event are then all renewed.
const VALID: f64 = 0.5 * patches::RESOLUTION;

/// A pair that may touch.
#[derive(Clone, Debug)]
struct Candidate {
    pair: Pair,
    /// Plane that has separated the bodies last.
    hint: Option<Owner>,
    /// Distance at the start of the step, m; zero if the pair touches.
    start: f64,
}

impl Candidate {
    fn new(pair: Pair) -> Self {
        Candidate { pair, hint: None, start: 0.0 }
    }
}

/// What a pair has.
#[derive(Clone)]
enum Found {
    /// No corners.
    Apart,
    /// Its present corners.
    Present,
    /// Other corners, in a part.
    Changed(Box<Part>),
}

/// Pairs that may touch.
#[derive(Clone)]
pub struct PairContacts {
    /// Pairs of bodies, then bodies with pieces of terrain.
    candidates: Vec<Candidate>,
    /// Number of those without terrain.
    fixed: usize,
    terrain: Option<TerrainPairs>,
    /// Planes of pairs with terrain before an update.
    hints: HashMap<(usize, usize), Owner>,
    /// Results of the last search, in their order.
    found: Vec<Found>,
    /// Placements of the plant's bodies, present and at the start of the step.
    placements: Placements,
    starts: Placements,
    /// Bounds of the ways of the bodies in this step, m.
    ways: Vec<f64>,
    /// Bounds of the speeds of their points, m/s; empty where steps have located events.
    speeds: Vec<f64>,
}

impl PairContacts {
    /// For these pairs of the bodies of a plant, and terrain if there is any.
    pub fn new(pairs: Vec<Pair>, terrain: Option<TerrainPairs>) -> Self {
        let candidates: Vec<Candidate> = pairs.into_iter().map(Candidate::new).collect();
        PairContacts {
            fixed: candidates.len(),
            found: Vec::with_capacity(candidates.len()),
            candidates,
            terrain,
            hints: HashMap::new(),
            placements: Placements::default(),
            starts: Placements::default(),
            ways: Vec::new(),
            speeds: Vec::new(),
        }
    }

    /// Whether no pair can touch.
    pub fn is_empty(&self) -> bool {
        self.candidates.is_empty() && self.terrain.is_none()
    }

    /// Number of functions [`gap`](Self::gap).
    pub fn number(&self) -> usize {
        self.candidates.len()
    }

    /// Adds pieces of terrain that have come near, and removes distant ones. Needs the plant's kinematics.
    /// `step` is the size of a step without located events.
    pub fn update_terrain(&mut self, plant: &mut Plant, step: Option<f64>) {
        let Some(terrain) = &mut self.terrain else { return };
        self.placements.update(plant);
        if !terrain.update(plant, &self.placements, step) {
            return;
        }
        self.hints.clear();
        let known = |candidate: Candidate| Some((candidate.pair.bodies, candidate.hint?));
        self.hints.extend(self.candidates.drain(self.fixed..).filter_map(known));
        let hint = |pair: &Pair| self.hints.get(&pair.bodies).copied();
        let candidate = |pair: &Pair| Candidate { hint: hint(pair), ..Candidate::new(pair.clone()) };
        self.candidates.extend(terrain.pairs().map(candidate));
        self.placements.update(plant);
    }

    /// Begins a step at the plant's present kinematics.
    pub fn begin_step(&mut self, plant: &Plant) {
        self.placements.update(plant);
        self.starts.copy_from(&self.placements);
        self.ways.clear();
        self.ways.resize(self.starts.len(), 0.0);
        for c in 0..self.candidates.len() {
            let is_present = present_part(plant, &self.candidates[c].pair).is_some();
            self.candidates[c].start = if is_present { 0.0 } else { self.distance(plant, &self.candidates[c]) };
        }
    }

    /// Prepares [`gap`](Self::gap) for the plant's present kinematics.
    pub fn update_ways(&mut self, plant: &Plant) {
        self.placements.update(plant);
        self.placements.ways_from(&self.starts, &plant.bodies, &mut self.ways);
    }

    /// If a body may have left the box in which its terrain is known, the fraction of the step after which it is
    /// probably inside. Needs [`update_ways`](Self::update_ways).
    pub fn part_inside(&self, plant: &Plant) -> Option<f64> {
        self.terrain.as_ref()?.part_inside(plant, &self.starts, &self.placements)
    }

    /// Distance of the bodies of a pair, m, or a lower bound for it above zero.
    fn distance(&self, plant: &Plant, candidate: &Candidate) -> f64 {
        let (a, b) = bodies(plant, &candidate.pair);
        let (pa, pb) = self.placements_of(&candidate.pair);
        let bound = spheres_apart((a, pa), (b, pb));
        if bound > 0.0 {
            return bound;
        }
        patches::separation(&a.shape, pa, &b.shape, pb, candidate.hint, 0.0).distance
    }

    fn placements_of(&self, pair: &Pair) -> (&Placement, &Placement) {
        (&self.placements[pair.bodies.0], &self.placements[pair.bodies.1])
    }

    /// Positive while a pair needs no other corners: the distance of one that does not touch, or the
    /// validity of its corners. Needs [`update_ways`](Self::update_ways).
    pub fn gap(&self, plant: &Plant, c: usize) -> f64 {
        let candidate = &self.candidates[c];
        let bound = candidate.start - self.ways[candidate.pair.bodies.0] - self.ways[candidate.pair.bodies.1];
        if bound > 0.0 {
            return bound;
        }
        match present_part(plant, &candidate.pair) {
            Some(part) => {
                let ((a, b), (pa, pb)) = (bodies(plant, &candidate.pair), self.placements_of(&candidate.pair));
                patches::validity(&part.topology, &a.shape, pa, &b.shape, pb, 1.0)
            }
            None => self.distance(plant, candidate),
        }
    }

    /// The patches of the plant's present state, if they differ from its present ones. Needs its kinematics.
    /// `step` is the size of a step without located events. Allocates only if they differ.
    pub fn find(&mut self, plant: &Plant, distance: f64, step: Option<f64>) -> Option<Vec<PairPatch>> {
        self.placements.update(plant);
        self.found.clear();
        self.speeds.clear();
        if step.is_some() {
            let speed = |(k, body): (usize, &Body)| {
                let (centre, turn) = self.placements[k].speeds(&body.shape);
                centre.norm() + turn
            };
            self.speeds.extend(plant.bodies.iter().enumerate().map(speed));
        }
        let parts = plant.pair_patches().map(|patch| patch.parts.len()).sum::<usize>();
        let mut known = 0;
        let mut changed = false;
        for candidate in &mut self.candidates {
            let (i, j) = candidate.pair.bodies;
            let way = step.map_or(0.0, |dt| way_in_step(self.speeds[i] + self.speeds[j], plant, dt));
            let (a, b) = bodies(plant, &candidate.pair);
            if spheres_apart((a, &self.placements[i]), (b, &self.placements[j])) > KEPT * (distance + way) {
                self.found.push(Found::Apart);
                continue;
            }
            let present = present_part(plant, &candidate.pair);
            let found = find_corners(candidate, present, plant, &self.placements, distance, step);
            known += usize::from(present.is_some());
            changed |= match &found {
                Found::Apart => present.is_some(),
                Found::Present => false,
                Found::Changed(_) => true,
            };
            self.found.push(found);
        }
        // Patches of bodies that are far apart are no candidates, or not sought.
        if !changed && known == parts {
            return None;
        }
        let parts = self.candidates.iter().zip(self.found.drain(..)).filter_map(|(candidate, found)| match found {
            Found::Apart => None,
            Found::Present => present_part(plant, &candidate.pair).cloned(),
            Found::Changed(part) => Some(*part),
        });
        Some(PairPatch::merge(parts.collect(), &plant.bodies))
    }

    /// The patches whose states hold only a part of their vertices, with the plane on which these are: it
    /// changes nothing at the instant, and the motion that follows keeps to it. `None` if no plane changes.
    pub fn follow_states(&self, plant: &Plant) -> Option<Vec<PairPatch>> {
        with_topologies(plant, |s, patch, part| {
            if plant.states[s].pattern == Pattern::Face {
                return None;
            }
            let clamped = |c: usize| is_clamped(patch, plant.states[s], part.position(c));
            let near = (0..patch.len()).map(|i| patch.point(i).gap).fold(NEAR, f64::max);
            patch_planes::of_corners(part, plant, clamped, near)
        })
    }

    /// The patches on ends of cylinders with the rings turned, where the state holds only an edge or a vertex of a
    /// patch and the load is between two points of a ring: the rim reaches farther there, and the whole patch may
    /// hold. `None` if there are none.
    pub fn turn_rings(&self, plant: &Plant) -> Option<Vec<PairPatch>> {
        let mechanisms = plant.objects.mechanisms(&plant.ws);
        with_topologies(plant, |s, patch, part| {
            let is_partial = matches!(plant.states[s].pattern, Pattern::Edge(_) | Pattern::Vertex(_));
            let load = is_partial.then(|| centre_of_load(patch, &plant.solution.normal[s])).flatten()?;
            let (a, b) = bodies(plant, &part.pair);
            let (pa, pb) = (a.placement(mechanisms), b.placement(mechanisms));
            patches::turn_ring(&part.topology, &load, (&a.shape, &pa), (&b.shape, &pb))
        })
    }
}

/// The present patches with the corners that `topology` gives for parts, each with its patch and the index of
/// its polygon. `None`, without an allocation, if it gives none.
fn with_topologies(
    plant: &Plant,
    topology: impl Fn(usize, &PairPatch, &Part) -> Option<Topology>,
) -> Option<Vec<PairPatch>> {
    let mechanisms = plant.objects.mechanisms(&plant.ws);
    let first = plant.polygons.len() - plant.pair_patches().count();
    let parts = || {
        let patches = plant.pair_patches().enumerate();
        patches.flat_map(move |(p, patch)| patch.parts.iter().map(move |part| (first + p, patch, part)))
    };
    let changed = parts().enumerate().filter_map(|(i, (s, patch, part))| Some((i, topology(s, patch, part)?)));
    let mut changed = changed.collect::<Vec<_>>().into_iter().peekable();
    changed.peek()?;
    let parts = parts().enumerate().map(|(i, (_, _, part))| match changed.next_if(|(at, _)| *at == i) {
        Some((_, topology)) => Part::new(part.pair.clone(), topology, &plant.bodies, mechanisms),
        None => part.clone(),
    });
    Some(PairPatch::merge(parts.collect(), &plant.bodies))
}

/// Centre of the normal forces on a patch, world, m; `None` without any.
fn centre_of_load(patch: &PairPatch, normal: &[f64]) -> Option<Vector3<f64>> {
    let sum: f64 = normal.iter().sum();
    let moment = normal.iter().enumerate().map(|(i, f)| patch.point(i).position * *f).sum::<Vector3<f64>>();
    (sum > 0.0).then(|| moment / sum)
}

/// Whether a corner of a part is where the state clamps its patch: at a vertex, on an edge, or anywhere.
fn is_clamped(patch: &PairPatch, state: SoleState, corner: &Vector3<f64>) -> bool {
    let position = |i: u8| patch.point(i as usize % patch.len()).position;
    match state.pattern {
        Pattern::Free => false,
        Pattern::Face => true,
        Pattern::Vertex(i) => (corner - position(i)).norm() <= NEAR,
        Pattern::Edge(i) => {
            let (from, to) = (position(i), position(i + 1));
            let along = (to - from).normalize();
            (corner - from).cross(&along).norm() <= NEAR
        }
    }
}

/// The present corners of a pair.
fn present_part<'a>(plant: &'a Plant, pair: &Pair) -> Option<&'a Part> {
    plant.pair_patches().flat_map(|patch| &patch.parts).find(|part| part.pair.bodies == pair.bodies)
}

fn find_corners(
    candidate: &mut Candidate,
    present: Option<&Part>,
    plant: &Plant,
    placements: &Placements,
    distance: f64,
    step: Option<f64>,
) -> Found {
    let (a, b) = bodies(plant, &candidate.pair);
    let (pa, pb) = (placements[candidate.pair.bodies.0], placements[candidate.pair.bodies.1]);
    let way = step.map_or(0.0, |dt| way_in_step(fastest((a, &pa), (b, &pb)), plant, dt));
    let near = distance + way;
    let reach = if present.is_some() { KEPT * near } else { near };
    if spheres_apart((a, &pa), (b, &pb)) > reach {
        return Found::Apart;
    }
    let hint = present.map_or(candidate.hint, |part| Some(part.topology.owner));
    let Separation { distance, owner, .. } = patches::separation(&a.shape, &pa, &b.shape, &pb, hint, reach);
    candidate.hint = owner;
    if distance > reach {
        return Found::Apart;
    }
    // A step without located events needs the corners that hold at its end.
    let (after_a, after_b) = step.map_or((pa, pb), |dt| (ahead(&pa, dt), ahead(&pb, dt)));
    if let Some(part) = present
        && [(&pa, &pb), (&after_a, &after_b)]
            .into_iter()
            .all(|(pa, pb)| patches::validity(&part.topology, &a.shape, pa, &b.shape, pb, 1.0) >= VALID)
        && !(step.is_none()
            && distance <= NEAR
            && owner.is_some_and(|owner| patch_planes::is_other_plane(plant, part, owner)))
    {
        return Found::Present;
    }
    let after = |_| patches::separation(&a.shape, &after_a, &b.shape, &after_b, None, f64::INFINITY).owner;
    // At a seam a wall of the next piece is as near as its upper side.
    let seam = patch_planes::coplanar_face(plant, &candidate.pair, b, &pb);
    let owners = if seam.is_some() { [seam, None] } else { [step.and_then(after), owner] };
    if owners == [None; 2] {
        return Found::Apart;
    }
    let mut topology = present.map_or_else(Topology::default, |part| part.topology.clone());
    let mut is_near = |owner: Owner| {
        let incident = present.filter(|part| part.topology.owner == owner).and_then(|part| part.topology.incident);
        patches::topology(&a.shape, &pa, &b.shape, &pb, reach, owner, incident, &mut topology)
    };
    if !owners.into_iter().flatten().any(&mut is_near) {
        if seam.is_some() {
            return Found::Apart;
        }
        match patches::tied_topology(&a.shape, &pa, &b.shape, &pb, distance, reach) {
            Some(tied) => topology = tied,
            None => return Found::Apart,
        }
    }
    if let Some(part) = present.filter(|_| step.is_none()) {
        let owners = [topology.owner, part.topology.owner];
        if let Some(flat) = patches::flat_topology(owners, &a.shape, &pa, &b.shape, &pb, reach) {
            topology = flat;
        }
    }
    // Even with the same corners: their functions of validity begin anew.
    let mechanisms = plant.objects.mechanisms(&plant.ws);
    let part = Part::new(candidate.pair.clone(), topology, &plant.bodies, mechanisms);
    let part = if step.is_none() { patch_planes::on_touching_features(part, plant, reach) } else { part };
    let opened = if present.is_some() && step.is_none() { patch_planes::opened(&part, plant, reach) } else { None };
    Found::Changed(Box::new(opened.unwrap_or(part)))
}

/// Distance of the spheres around two bodies, m; to a half space that of the sphere around the other.
fn spheres_apart((a, pa): (&Body, &Placement), (b, pb): (&Body, &Placement)) -> f64 {
    let above = |(plane, at): (&Body, &Placement), (body, placement): (&Body, &Placement)| {
        if !plane.shape.is_half_space() {
            return f64::NEG_INFINITY;
        }
        at.rotation.column(2).dot(&(centre(body, placement) - at.position)) - body.shape.radius
    };
    if a.shape.is_half_space() || b.shape.is_half_space() {
        return above((a, pa), (b, pb)).max(above((b, pb), (a, pa)));
    }
    (centre(a, pa) - centre(b, pb)).norm() - a.shape.radius - b.shape.radius
}

fn centre(body: &Body, placement: &Placement) -> Vector3<f64> {
    placement.point(&body.shape.centre)
}

/// Bound of the way of points in a step without located events, m, at this relative speed, m/s.
fn way_in_step(speed: f64, plant: &Plant, dt: f64) -> f64 {
    2.0 * dt * (speed + plant.gravity.norm() * dt)
}

/// Bound of the speed of points of one body relative to the other, m/s.
fn fastest((a, pa): (&Body, &Placement), (b, pb): (&Body, &Placement)) -> f64 {
    let ((va, ta), (vb, tb)) = (pa.speeds(&a.shape), pb.speeds(&b.shape));
    (va - vb).norm() + ta + tb
}
