//! Pieces of terrain near moving bodies.
//!
//! Terrain may have many pieces. A moving body forms pairs with those that meet a box around it, which is
//! computed again when the body's sphere reaches the border of the box, an event:
//!
//! ```text
//! inside = min over the axes of (box_max - (c + r), (c - r) - box_min)
//! ```
//!
//! with the centre c and the radius r of the sphere.

use crate::dynamics::reduced::BodyId;
use crate::sim::bodies::{Body, Pair, PairFriction};
use crate::sim::plant::Plant;
use crate::terrain::{PieceRef, Terrain, TerrainPiece};
use nalgebra::Vector3;
use std::collections::HashMap;
use std::sync::Arc;

/// Distance of the border of a new box from the sphere, m.
const SLACK: f64 = 0.02;
/// Time, s, for which a new box suffices at the present speed.
const HORIZON: f64 = 0.05;

/// A body that may touch terrain.
struct Moving {
    body: usize,
    link: BodyId,
    /// Least and greatest corner of its box, m.
    bounds: (Vector3<f64>, Vector3<f64>),
}

/// Terrain, and the bodies that may touch it.
pub struct TerrainPairs {
    terrain: Arc<Terrain>,
    moving: Vec<Moving>,
    /// Bodies of the plant that stand for pieces.
    pieces: HashMap<PieceRef, Option<usize>>,
    buffer: TerrainPiece,
}

impl TerrainPairs {
    /// For the bodies of a plant that move.
    pub fn new(terrain: Arc<Terrain>, plant: &Plant) -> Self {
        let nowhere = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        let mechanisms = plant.objects.mechanisms(&plant.ws);
        let moving = |(body, of): (usize, &Body)| {
            let link = of.link().filter(|_| of.moves(mechanisms))?;
            Some(Moving { body, link, bounds: nowhere })
        };
        TerrainPairs {
            moving: plant.bodies.iter().enumerate().filter_map(moving).collect(),
            terrain,
            pieces: HashMap::new(),
            buffer: TerrainPiece::prism_buffer(),
        }
    }

    /// Number of functions [`inside`](Self::inside).
    pub fn number(&self) -> usize {
        self.moving.len()
    }

    /// Positive while body `i` is inside its box, m.
    pub fn inside(&self, plant: &Plant, i: usize) -> f64 {
        let moving = &self.moving[i];
        let (centre, radius, _) = sphere(plant, moving);
        let (min, max) = &moving.bounds;
        let inside = |k: usize| (max[k] - centre[k] - radius).min(centre[k] - radius - min[k]);
        (0..3).map(inside).fold(f64::INFINITY, f64::min)
    }

    /// Updates the boxes to the plant's kinematics, and adds bodies for new pieces to the plant. Returns the
    /// pairs if a box has changed.
    pub fn update(&mut self, plant: &mut Plant) -> Option<Vec<Pair>> {
        let mut changed = false;
        for i in 0..self.moving.len() {
            if self.inside(plant, i) >= 0.0 {
                continue;
            }
            let moving = &mut self.moving[i];
            let (centre, radius, speed) = sphere(plant, moving);
            let reach = Vector3::repeat(radius + SLACK + HORIZON * speed);
            moving.bounds = (centre - reach, centre + reach);
            changed = true;
        }
        changed.then(|| self.pairs(plant))
    }

    fn pairs(&mut self, plant: &mut Plant) -> Vec<Pair> {
        let mut near = Vec::new();
        let mut pairs = Vec::new();
        for moving in &self.moving {
            near.clear();
            let (min, max) = &moving.bounds;
            self.terrain.near(min, max, |piece| near.push(piece));
            for piece in &near {
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
                pairs.push(Pair { bodies: (moving.body, body), links: (moving.link, None), friction });
            }
        }
        pairs
    }
}

/// Centre and radius of the sphere around a body, m, and a bound of the speed of its points, m/s.
fn sphere(plant: &Plant, moving: &Moving) -> (Vector3<f64>, f64, f64) {
    let body = &plant.bodies[moving.body];
    let placement = body.placement(plant.objects.mechanisms(&plant.ws));
    let (centre, radius) = (placement.point(&body.shape.centre), body.shape.radius);
    (centre, radius, placement.velocity_at(&centre).norm() + placement.omega.norm() * radius)
}
