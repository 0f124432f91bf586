//! Pieces of terrain near moving bodies.
//!
//! Terrain may have many pieces. A moving body forms pairs with those that meet a box around it: the least one,
//! extended by a distance. It is computed again between steps, when the body may have moved by a part of that
//! distance ([`Placement::way_from`]). A step in which it may have moved by more is shortened.

use super::placements::Placements;
use crate::dynamics::reduced::BodyId;
use crate::patches::Placement;
use crate::sim::bodies::{Body, Pair, PairFriction};
use crate::sim::plant::Plant;
use crate::terrain::{PieceRef, Terrain, TerrainPiece};
use nalgebra::Vector3;
use std::collections::HashMap;
use std::sync::Arc;

/// Extension of a new box for a body at rest, m.
const SLACK: f64 = 0.01;
/// Time, s, for which a new box suffices at the present speeds.
const HORIZON: f64 = 0.02;
/// Part of the distance that must be left between steps.
const LEFT: f64 = 0.5;
/// Share of what is left that a shortened step aims at, and the least fraction to which it is shortened at once.
const SHARE: f64 = 0.9;
const LEAST: f64 = 1e-3;
/// Steps without located events for which a new box suffices at least.
const STEPS: f64 = 4.0;

/// A body that may touch terrain.
#[derive(Clone)]
struct Moving {
    body: usize,
    link: BodyId,
    /// Its box.
    region: Option<Region>,
    /// Its pairs with the pieces that meet the box.
    pairs: Vec<Pair>,
}

/// The placement from which a body may move by `reach`, m, within its box.
#[derive(Clone)]
struct Region {
    placement: Placement,
    reach: f64,
}

/// Terrain, and the bodies that may touch it.
#[derive(Clone)]
pub struct TerrainPairs {
    terrain: Arc<Terrain>,
    moving: Vec<Moving>,
    /// Bodies of the plant that stand for pieces.
    pieces: HashMap<PieceRef, Option<usize>>,
    buffer: TerrainPiece,
    /// Pieces that meet a box.
    near: Vec<PieceRef>,
    /// Pairs of a body before an update.
    before: Vec<Pair>,
}

impl TerrainPairs {
    /// For the bodies of a plant that move.
    pub fn new(terrain: Arc<Terrain>, plant: &Plant) -> Self {
        let mechanisms = plant.objects.mechanisms(&plant.ws);
        let moving = |(body, of): (usize, &Body)| {
            let link = of.link().filter(|_| of.moves(mechanisms))?;
            Some(Moving { body, link, region: None, pairs: Vec::new() })
        };
        TerrainPairs {
            moving: plant.bodies.iter().enumerate().filter_map(moving).collect(),
            terrain,
            pieces: HashMap::new(),
            buffer: TerrainPiece::prism_buffer(),
            near: Vec::new(),
            before: Vec::new(),
        }
    }

    /// If a body may have left its box in a step from the placements `starts` to `ends` of the plant's bodies, the
    /// fraction of the step after which it is probably inside.
    pub fn part_inside(&self, plant: &Plant, starts: &Placements, ends: &Placements) -> Option<f64> {
        let part = |moving: &Moving| {
            let region = moving.region.as_ref()?;
            let way = |at: &Placements| at[moving.body].way_from(&region.placement, &plant.bodies[moving.body].shape);
            let (from, to) = (way(starts), way(ends));
            (to > region.reach).then(|| (SHARE * (region.reach - from) / (to - from)).max(LEAST))
        };
        self.moving.iter().filter_map(part).min_by(f64::total_cmp)
    }

    /// Distance by which body `i` may still move within its box, m; negative without one.
    fn left(&self, plant: &Plant, placements: &Placements, i: usize) -> f64 {
        let moving = &self.moving[i];
        let shape = &plant.bodies[moving.body].shape;
        let left = |region: &Region| region.reach - placements[moving.body].way_from(&region.placement, shape);
        moving.region.as_ref().map_or(-1.0, left)
    }

    /// Updates the boxes to these placements of the plant's bodies, and adds bodies for new pieces to the plant.
    /// `step` is the size of a step without located events. Returns whether pairs have changed.
    pub fn update(&mut self, plant: &mut Plant, placements: &Placements, step: Option<f64>) -> bool {
        let horizon = HORIZON.max(STEPS * step.unwrap_or(0.0));
        let mut changed = false;
        for i in 0..self.moving.len() {
            let reach = self.moving[i].region.as_ref().map_or(0.0, |region| region.reach);
            if self.left(plant, placements, i) > LEFT * reach {
                continue;
            }
            let moving = &mut self.moving[i];
            let (shape, placement) = (&plant.bodies[moving.body].shape, placements[moving.body]);
            let (velocity, turn) = placement.speeds(shape);
            let reach = SLACK + horizon * (velocity.norm() + turn);
            let (min, max) = shape.bounds(&placement);
            let (min, max) = (min.add_scalar(-reach), max.add_scalar(reach));
            moving.region = Some(Region { placement, reach });
            changed |= self.find_pairs(plant, i, (&min, &max));
        }
        changed
    }

    /// The pairs, body by body.
    pub fn pairs(&self) -> impl Iterator<Item = &Pair> {
        self.moving.iter().flat_map(|moving| &moving.pairs)
    }

    /// Finds the pairs of body `i` with the pieces that meet a box. Returns whether they have changed.
    fn find_pairs(&mut self, plant: &mut Plant, i: usize, (min, max): (&Vector3<f64>, &Vector3<f64>)) -> bool {
        let moving = &mut self.moving[i];
        self.near.clear();
        self.terrain.near(min, max, |piece| self.near.push(piece));
        std::mem::swap(&mut self.before, &mut moving.pairs);
        moving.pairs.clear();
        for piece in &self.near {
            let (terrain, buffer) = (&self.terrain, &mut self.buffer);
            let body = self.pieces.entry(*piece).or_insert_with(|| {
                plant.bodies.push(Body::of_piece(terrain.piece(*piece, buffer))?);
                Some(plant.bodies.len() - 1)
            });
            let Some(body) = *body else { continue };
            let (one, other) = (&plant.bodies[moving.body], &plant.bodies[body]);
            if !plant.pair_rules.touches(&one.name, &other.name) {
                continue;
            }
            let rule = plant.pair_rules.friction(&one.name, &other.name);
            let friction = rule.map_or_else(|| PairFriction::of(one, other), PairFriction::given);
            moving.pairs.push(Pair { bodies: (moving.body, body), links: (moving.link, None), friction });
        }
        !moving.pairs.iter().map(|pair| pair.bodies).eq(self.before.iter().map(|pair| pair.bodies))
    }
}
