//! Terrain: fixed bodies of the world as convex pieces, and the pieces near a box.
//!
//! - `shapes`: a box, a ramp and stairs as convex solids; `mesh_shapes`: meshes as one hull, or a
//!   prism for each triangle.
//! - `height_grid`: a height field, whose prisms are computed when they are needed; `heights`: its
//!   heights, read from a table (`csv_heights`) or a picture (`png_heights`).
//! - `extra_friction`: terms of friction besides the coefficients.
//! - `piece`: a convex solid in the world, its friction, and which of its faces can be touched.
//! - `bounds_tree`: the broad phase.
//!
//! Faces between two pieces of one entry, undersides, and faces at or below the floor cannot be
//! touched: the pieces overlap or end there, the body does not.
//!
//! Imports: `geometry`, `input`. Used by: `sim`, `log`, `assemble`, `batch`.

mod bounds_tree;
mod csv_heights;
mod extra_friction;
mod height_grid;
mod heights;
pub mod mesh_shapes;
mod piece;
mod png_heights;
pub mod shapes;

pub use extra_friction::ExtraFriction;
pub use height_grid::{Cell, Half, HeightGrid};
pub use heights::{Heights, HeightsError, MAX_POINTS};
pub use piece::{Entry, Solid, TerrainFace, TerrainPiece};

use crate::geometry::Plane;
use bounds_tree::{Bounds, BoundsTree};
use nalgebra::Vector3;

/// Height above the floor up to which a face counts as part of the floor, m.
const FLOOR_TOLERANCE: f64 = 1e-9;

/// A piece of a [`Terrain`]; equal values mean the same piece throughout a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PieceRef {
    /// Index into [`Terrain::pieces()`].
    Piece(u32),
    /// A prism of a height field.
    Prism {
        /// Index into [`Terrain::grids()`].
        grid: u32,
        /// Its cell and half.
        cell: Cell,
    },
}

/// All fixed bodies of the world except the floor.
#[derive(Clone, Debug, Default)]
pub struct Terrain {
    pieces: Vec<TerrainPiece>,
    grids: Vec<HeightGrid>,
    tree: BoundsTree,
    floor: Option<Plane>,
}

impl Terrain {
    /// Terrain of these pieces and height fields. Faces at or below `floor` become untouchable.
    pub fn new(mut pieces: Vec<TerrainPiece>, grids: Vec<HeightGrid>, floor: Option<Plane>) -> Self {
        pieces.iter_mut().for_each(|piece| hide_below_floor(piece, floor.as_ref()));
        let tree = BoundsTree::new(pieces.iter().map(|piece| Bounds::of(&piece.points)).collect());
        Terrain { pieces, grids, tree, floor }
    }

    /// True without any piece.
    pub fn is_empty(&self) -> bool {
        self.pieces.is_empty() && self.grids.is_empty()
    }

    /// The pieces of all entries but height fields.
    pub fn pieces(&self) -> &[TerrainPiece] {
        &self.pieces
    }

    /// The height fields.
    pub fn grids(&self) -> &[HeightGrid] {
        &self.grids
    }

    /// Calls `f` once with each piece that meets the box from `min` to `max`, world, m, and with
    /// some near it: those whose bounding box meets it. The order depends on terrain and box alone.
    /// Does not allocate.
    pub fn near(&self, min: &Vector3<f64>, max: &Vector3<f64>, mut f: impl FnMut(PieceRef)) {
        let bounds = Bounds { min: *min, max: *max };
        self.tree.near(&bounds, |piece| f(PieceRef::Piece(piece)));
        for (grid, heights) in self.grids.iter().enumerate() {
            heights.near(&bounds, |cell| f(PieceRef::Prism { grid: grid as u32, cell }));
        }
    }

    /// A piece. That of a height field is written to `buffer`; with one buffer from
    /// [`TerrainPiece::prism_buffer`] for each piece in use, this does not allocate.
    pub fn piece<'a>(&'a self, piece: PieceRef, buffer: &'a mut TerrainPiece) -> &'a TerrainPiece {
        match piece {
            PieceRef::Piece(index) => &self.pieces[index as usize],
            PieceRef::Prism { grid, cell } => {
                self.grids[grid as usize].write_prism(cell, buffer);
                hide_below_floor(buffer, self.floor.as_ref());
                buffer
            }
        }
    }
}

/// Marks faces that the floor covers as untouchable.
fn hide_below_floor(piece: &mut TerrainPiece, floor: Option<&Plane>) {
    let Some(floor) = floor else { return };
    let TerrainPiece { points, faces, .. } = piece;
    for face in faces.iter_mut().filter(|face| face.touchable) {
        face.touchable = face.corners.iter().any(|&k| floor.height(&points[usize::from(k)]) > FLOOR_TOLERANCE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;

    /// An entry without rotation at the origin.
    pub(super) fn entry() -> Entry {
        Entry {
            name: "terrain.0".into(),
            index: 0,
            rotation: Matrix3::identity(),
            position: Vector3::zeros(),
            mu_s: 0.8,
            mu_k: 0.6,
            extra: ExtraFriction::default(),
            is_like_floor: false,
        }
    }

    /// The volume by the divergence theorem, m^3: a third of the sum of p . n dA over the faces.
    pub(super) fn volume(points: &[Vector3<f64>], faces: &[TerrainFace]) -> f64 {
        let point = |k: u16| points[usize::from(k)];
        let fan = |face: &TerrainFace| {
            let corners: Vec<Vector3<f64>> = face.corners.iter().map(|&k| point(k)).collect();
            (2..corners.len()).map(|i| corners[0].dot(&corners[i - 1].cross(&corners[i])) / 6.0).sum::<f64>()
        };
        faces.iter().map(fan).sum()
    }

    /// Asserts that faces are flat, convex and closed, with outward normals: every point is on or
    /// behind the plane of every face, and each edge has its opposite in exactly one other face.
    pub(super) fn assert_convex(points: &[Vector3<f64>], faces: &[TerrainFace], tolerance: f64) {
        let mut edges = std::collections::HashSet::new();
        for face in faces {
            let corner = |i: usize| points[usize::from(face.corners[i % face.corners.len()])];
            let normal = crate::geometry::convex_polygon::area_vector(
                &face.corners.iter().map(|&k| points[usize::from(k)]).collect::<Vec<_>>(),
            )
            .normalize();
            for p in points {
                assert!(normal.dot(&(p - corner(0))) <= tolerance, "{p} is outside of {face:?}");
            }
            for i in 0..face.corners.len() {
                assert!(normal.dot(&(corner(i) - corner(0))).abs() <= tolerance, "{face:?} is not flat");
                let turn = (corner(i + 1) - corner(i)).cross(&(corner(i + 2) - corner(i + 1)));
                assert!(turn.dot(&normal) >= -tolerance, "{face:?} is not convex");
                let edge = (face.corners[i], face.corners[(i + 1) % face.corners.len()]);
                assert!(edges.insert(edge), "{edge:?} is in two faces");
            }
        }
        assert!(edges.iter().all(|(a, b)| edges.contains(&(*b, *a))), "the surface is not closed");
    }

    fn box_at(x: f64, z: f64) -> TerrainPiece {
        let mut entry = entry();
        entry.position = Vector3::new(x, 0.0, z);
        entry.place(&shapes::block(&Vector3::new(1.0, 1.0, 0.2)))
    }

    #[test]
    fn faces_at_or_below_the_floor_cannot_be_touched() {
        let touchable = |piece: &TerrainPiece| piece.faces.iter().filter(|face| face.touchable).count();
        let pieces = || vec![box_at(0.0, 0.1), box_at(2.0, 0.2), box_at(4.0, -0.1), box_at(6.0, -1.0)];
        let on_floor = Terrain::new(pieces(), Vec::new(), Some(Plane::LEVEL));
        assert_eq!(on_floor.pieces().iter().map(touchable).collect::<Vec<_>>(), [5, 6, 0, 0]);
        let without = Terrain::new(pieces(), Vec::new(), None);
        assert!(without.pieces().iter().all(|piece| touchable(piece) == 6));
    }

    #[test]
    fn the_broad_phase_finds_what_a_search_through_all_finds() {
        let mut grid = entry();
        grid.position = Vector3::new(0.3, -0.2, 0.05);
        grid.rotation = *nalgebra::Rotation3::from_euler_angles(0.3, -0.2, 0.7).matrix();
        let wave = |k: usize| 0.1 * ((k * 7 % 11) as f64 / 11.0);
        let heights = Heights { rows: 9, columns: 12, values: (0..108).map(wave).collect() };
        let grids = vec![HeightGrid::new(&grid, heights, [0.25, 0.3])];
        let pieces = (0..200).map(|k| box_at((k * 37 % 200) as f64 * 0.1 - 10.0, (k % 7) as f64)).collect();
        let terrain = Terrain::new(pieces, grids, None);
        let mut all = Vec::new();
        let everything = Vector3::repeat(1e3);
        terrain.near(&-everything, &everything, |piece| all.push(piece));
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 200 + 2 * 8 * 11);
        let mut buffer = TerrainPiece::prism_buffer();
        let (mut found_any, mut extra) = (0, 0);
        for k in 0..300 {
            let centre =
                Vector3::new((k % 17) as f64 * 0.4 - 3.0, (k % 5) as f64 * 0.5 - 1.0, (k % 13) as f64 * 0.1 - 0.4);
            let half = Vector3::new(0.05, 0.1, 0.02 * (k % 4) as f64);
            let (min, max) = (centre - half, centre + half);
            let mut near = Vec::new();
            terrain.near(&min, &max, |piece| near.push(piece));
            let meets = |piece: &PieceRef| {
                let piece = terrain.piece(*piece, &mut buffer);
                Bounds::of(&piece.points).meets(&Bounds { min, max })
            };
            let expected: Vec<PieceRef> = all.iter().copied().filter(meets).collect();
            let of_solids = |list: &[PieceRef]| {
                let mut solids: Vec<_> = list.iter().copied().filter(|p| matches!(p, PieceRef::Piece(_))).collect();
                solids.sort_unstable();
                solids
            };
            assert_eq!(of_solids(&near), of_solids(&expected));
            // A box of the world is larger in the axes of a tilted field, and one of its prisms is
            // larger in the world: prisms of other cells than those below the box are left out.
            let inside = |piece: &PieceRef| {
                let piece = terrain.piece(*piece, &mut TerrainPiece::prism_buffer()).clone();
                piece.contains(&centre)
            };
            assert!(expected.iter().filter(|p| inside(p)).all(|p| near.contains(p)));
            let mut unique = near.clone();
            unique.sort_unstable();
            unique.dedup();
            assert_eq!(unique.len(), near.len(), "no piece twice");
            found_any += usize::from(!near.is_empty());
            extra += near.iter().filter(|p| !expected.contains(p)).count();
        }
        assert!(found_any > 50 && extra < 300, "{found_any} {extra}");
    }
}
