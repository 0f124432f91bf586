//! Convex solids in the axes of an entry, and pieces of terrain: the same in the world.

use super::ExtraFriction;
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// A flat face of a solid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TerrainFace {
    /// Indices of its corners, counter-clockwise seen from outside.
    pub corners: Vec<u16>,
    /// False where another piece or the floor covers the face, or where the solid is cut off.
    pub touchable: bool,
}

impl TerrainFace {
    /// A face with these corners.
    pub(super) fn new(corners: &[u16], touchable: bool) -> Self {
        TerrainFace { corners: corners.to_vec(), touchable }
    }
}

/// A convex solid in the axes of its entry.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// Corners, m.
    pub points: Vec<Vector3<f64>>,
    /// Faces, which enclose it.
    pub faces: Vec<TerrainFace>,
}

/// Faces of a prism with the corners 0, 1, 2 of its top, counter-clockwise seen from outside, and
/// 3, 4, 5 below these: top, bottom, and the walls of the edges 0-1, 1-2 and 2-0.
const PRISM_FACES: [&[u16]; 5] = [&[0, 1, 2], &[5, 4, 3], &[0, 3, 4, 1], &[1, 4, 5, 2], &[2, 5, 3, 0]];

/// The faces of a prism. Its top can be touched, its bottom cannot.
pub(super) fn prism_faces(walls: [bool; 3]) -> Vec<TerrainFace> {
    let touchable = [true, false, walls[0], walls[1], walls[2]];
    PRISM_FACES.iter().zip(touchable).map(|(corners, touchable)| TerrainFace::new(corners, touchable)).collect()
}

/// What all pieces of an entry share.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Its name.
    pub name: Arc<str>,
    /// Its index among the entries of the scenario.
    pub index: usize,
    /// Its axes in the world, as columns.
    pub rotation: Matrix3<f64>,
    /// Its origin, world, m.
    pub position: Vector3<f64>,
    /// Static friction.
    pub mu_s: f64,
    /// Kinetic friction.
    pub mu_k: f64,
    /// Its other terms of friction.
    pub extra: ExtraFriction,
    /// Whether its friction is that of the floor, and changes with it.
    pub is_like_floor: bool,
}

impl Entry {
    /// A point of the entry in the world.
    pub fn to_world(&self, p: &Vector3<f64>) -> Vector3<f64> {
        self.position + self.rotation * p
    }

    /// A solid of the entry in the world.
    pub fn place(&self, solid: &Solid) -> TerrainPiece {
        TerrainPiece {
            name: self.name.clone(),
            entry: self.index,
            points: solid.points.iter().map(|p| self.to_world(p)).collect(),
            faces: solid.faces.clone(),
            mu_s: self.mu_s,
            mu_k: self.mu_k,
            extra: self.extra,
            is_like_floor: self.is_like_floor,
        }
    }
}

/// A convex piece of terrain.
#[derive(Clone, Debug, PartialEq)]
pub struct TerrainPiece {
    /// Name of its entry.
    pub name: Arc<str>,
    /// Index of its entry in the scenario.
    pub entry: usize,
    /// Corners, world, m.
    pub points: Vec<Vector3<f64>>,
    /// Faces, which enclose it.
    pub faces: Vec<TerrainFace>,
    /// Static friction.
    pub mu_s: f64,
    /// Kinetic friction.
    pub mu_k: f64,
    /// Its other terms of friction.
    pub extra: ExtraFriction,
    /// Whether its friction is that of the floor, and changes with it.
    pub is_like_floor: bool,
}

impl TerrainPiece {
    /// A piece with room for a prism of a height field.
    pub fn prism_buffer() -> Self {
        let points = vec![Vector3::zeros(); 6];
        let faces = prism_faces([false; 3]);
        TerrainPiece {
            name: "".into(),
            entry: 0,
            points,
            faces,
            mu_s: 0.0,
            mu_k: 0.0,
            extra: ExtraFriction::default(),
            is_like_floor: false,
        }
    }

    /// Becomes a prism of the entry. Does not allocate in a [`TerrainPiece::prism_buffer`].
    pub(super) fn set_prism(&mut self, entry: &Entry, points: &[Vector3<f64>; 6], walls: [bool; 3]) {
        if !Arc::ptr_eq(&self.name, &entry.name) {
            self.name = entry.name.clone();
        }
        (self.entry, self.mu_s, self.mu_k) = (entry.index, entry.mu_s, entry.mu_k);
        (self.extra, self.is_like_floor) = (entry.extra, entry.is_like_floor);
        self.points.clear();
        self.points.extend(points.iter().map(|p| entry.to_world(p)));
        let is_prism = self.faces.len() == PRISM_FACES.len()
            && self.faces.iter().zip(PRISM_FACES).all(|(face, corners)| face.corners == corners);
        if !is_prism {
            self.faces = prism_faces(walls);
        }
        let touchable = [true, false, walls[0], walls[1], walls[2]];
        self.faces.iter_mut().zip(touchable).for_each(|(face, touchable)| face.touchable = touchable);
    }

    /// Outward unit normal of a face; zero for a face without area.
    pub fn normal(&self, face: &TerrainFace) -> Vector3<f64> {
        let point = |k: u16| self.points[usize::from(k)];
        let origin = face.corners.first().map_or(Vector3::zeros(), |&k| point(k));
        let fan = face.corners.windows(2).map(|edge| (point(edge[0]) - origin).cross(&(point(edge[1]) - origin)));
        fan.sum::<Vector3<f64>>().try_normalize(0.0).unwrap_or_default()
    }

    /// True for points in the piece or on its surface, world, m.
    pub fn contains(&self, p: &Vector3<f64>) -> bool {
        self.faces.iter().all(|face| {
            let corner = face.corners.first().map_or(*p, |&k| self.points[usize::from(k)]);
            self.normal(face).dot(&(p - corner)) <= 0.0
        })
    }
}
