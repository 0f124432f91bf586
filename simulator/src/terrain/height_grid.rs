//! A height field: a grid of heights, two triangles to a cell, and the solid below them.
//!
//! Row r and column c of the grid are at x = (c - (columns - 1)/2) dx, y = (r - (rows - 1)/2) dy in
//! the axes of the entry. The diagonal of each cell goes from its corner at the least x and y to
//! that at the greatest:
//!
//! ```text
//!  y  d---c      z = z_a + (x - x_a)/dx (z_b - z_a) + (y - y_a)/dy (z_c - z_b)   lower half, a b c
//!  ^  | / |      z = z_a + (x - x_a)/dx (z_c - z_d) + (y - y_a)/dy (z_d - z_a)   upper half, a c d
//!  |  a---b
//!  +---> x
//! ```
//!
//! Below each triangle is a prism with vertical walls down to 1 m under the lowest height.

use super::bounds_tree::Bounds;
use super::heights::Heights;
use super::piece::{Entry, TerrainPiece};
use nalgebra::Vector3;

/// Depth of the solid below the lowest height, m.
const BELOW: f64 = 1.0;

/// Half of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Half {
    /// The triangle at the greater x.
    Lower,
    /// The triangle at the greater y.
    Upper,
}

/// A prism of a height field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell {
    /// Row of its corner at the least x and y.
    pub row: u16,
    /// Column of that corner.
    pub column: u16,
    /// Which of the two triangles.
    pub half: Half,
}

/// A height field in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightGrid {
    entry: Entry,
    heights: Heights,
    /// Distance of columns and of rows, m.
    spacing: [f64; 2],
    /// Height of the prisms' lower ends, m.
    bottom: f64,
    highest: f64,
}

impl HeightGrid {
    /// A height field of an entry; `spacing` is the distance of columns and of rows, m.
    pub fn new(entry: &Entry, heights: Heights, spacing: [f64; 2]) -> Self {
        let lowest = heights.values.iter().copied().fold(f64::INFINITY, f64::min);
        let highest = heights.values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        HeightGrid { entry: entry.clone(), heights, spacing, bottom: lowest - BELOW, highest }
    }

    /// Name, pose and friction.
    pub fn entry(&self) -> &Entry {
        &self.entry
    }

    /// Heights in the axes of the entry, m.
    pub fn heights(&self) -> &Heights {
        &self.heights
    }

    /// Distance of columns and of rows, m.
    pub fn spacing(&self) -> [f64; 2] {
        self.spacing
    }

    /// Number of cells along x and along y.
    fn cells(&self) -> [usize; 2] {
        [self.heights.columns - 1, self.heights.rows - 1]
    }

    /// Coordinate of a grid line along x (axis 0) or y (axis 1), m.
    fn line(&self, axis: usize, index: usize) -> f64 {
        (index as f64 - self.cells()[axis] as f64 / 2.0) * self.spacing[axis]
    }

    /// A point of the grid in the axes of the entry.
    pub fn point(&self, row: usize, column: usize) -> Vector3<f64> {
        Vector3::new(self.line(0, column), self.line(1, row), self.heights.at(row, column))
    }

    /// Height of the surface at a point, in the axes of the entry, m; `None` beyond the border.
    pub fn height(&self, x: f64, y: f64) -> Option<f64> {
        let [i, j] = [(0, x), (1, y)].map(|(axis, at)| {
            let cells = self.cells()[axis];
            let lines = at / self.spacing[axis] + cells as f64 / 2.0;
            // Rounding puts points of the border beyond it.
            (lines >= -1e-9 && lines <= cells as f64 + 1e-9).then(|| (lines as usize).min(cells - 1))
        });
        let (column, row) = (i?, j?);
        let [a, b, c, d] = self.corners(row, column);
        let (u, v) = ((x - a.x) / self.spacing[0], (y - a.y) / self.spacing[1]);
        Some(if u >= v { a.z + u * (b.z - a.z) + v * (c.z - b.z) } else { a.z + u * (c.z - d.z) + v * (d.z - a.z) })
    }

    /// The corners a, b, c, d of a cell.
    fn corners(&self, row: usize, column: usize) -> [Vector3<f64>; 4] {
        [(row, column), (row, column + 1), (row + 1, column + 1), (row + 1, column)].map(|(r, c)| self.point(r, c))
    }

    /// Calls `f` with the prisms that meet a box of the world. In the axes of the entry that is the
    /// bounding box of its corners, so a tilted field may add prisms near it.
    pub(super) fn near(&self, bounds: &Bounds, mut f: impl FnMut(Cell)) {
        let turn = self.entry.rotation.transpose();
        let centre = turn * ((bounds.min + bounds.max) / 2.0 - self.entry.position);
        let half = turn.abs() * ((bounds.max - bounds.min) / 2.0);
        // Rounding of the coordinates must not lose a prism that the box touches.
        let size = bounds.min.amax().max(bounds.max.amax()).max(self.entry.position.amax());
        let half = half.add_scalar(1e-12 * (1.0 + size));
        let (min, max) = (centre - half, centre + half);
        if !(max.z >= self.bottom && min.z <= self.highest) {
            return;
        }
        let range = |axis: usize| {
            let cells = self.cells()[axis];
            let line = |at: f64| at / self.spacing[axis] + cells as f64 / 2.0;
            let (first, last) = ((line(min[axis]) - 1e-9).floor(), (line(max[axis]) + 1e-9).floor());
            // Conversion saturates, also for boxes far away.
            let end = (last + 1.0).clamp(0.0, cells as f64) as usize;
            (first.clamp(0.0, cells as f64) as usize).min(end)..end
        };
        for row in range(1) {
            for column in range(0) {
                let (u, v) = (self.heights.row(row), self.heights.row(row + 1));
                let (a, b, c, d) = (u[column], u[column + 1], v[column + 1], v[column]);
                for (half, third) in [(Half::Lower, b), (Half::Upper, d)] {
                    if min.z <= a.max(c).max(third) {
                        f(Cell { row: row as u16, column: column as u16, half });
                    }
                }
            }
        }
    }

    /// Writes a prism to `piece`. Its walls can be touched at the border of the field only.
    pub(super) fn write_prism(&self, cell: Cell, piece: &mut TerrainPiece) {
        let (row, column) = (usize::from(cell.row), usize::from(cell.column));
        let [a, b, c, d] = self.corners(row, column);
        let [columns, rows] = self.cells();
        let (top, walls) = match cell.half {
            Half::Lower => ([a, b, c], [row == 0, column + 1 == columns, false]),
            Half::Upper => ([a, c, d], [false, row + 1 == rows, column == 0]),
        };
        let below = top.map(|p| Vector3::new(p.x, p.y, self.bottom));
        piece.set_prism(&self.entry, &[top[0], top[1], top[2], below[0], below[1], below[2]], walls);
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_convex, entry, volume};
    use super::super::{PieceRef, Terrain};
    use super::*;

    /// Heights that no plane fits.
    fn heights(rows: usize, columns: usize) -> Heights {
        let height = |k: usize| 0.01 * ((k * k * 31 + k * 17) % 23) as f64;
        Heights { rows, columns, values: (0..rows * columns).map(height).collect() }
    }

    fn everything(terrain: &Terrain) -> Vec<PieceRef> {
        let (mut all, far) = (Vec::new(), Vector3::repeat(1e9));
        terrain.near(&-far, &far, |piece| all.push(piece));
        all
    }

    #[test]
    fn prisms_fill_the_field_and_their_tops_are_its_surface() {
        let spacing = [0.2, 0.1];
        let grid = HeightGrid::new(&entry(), heights(5, 4), spacing);
        let terrain = Terrain::new(Vec::new(), vec![grid.clone()], None);
        let all = everything(&terrain);
        assert_eq!(all.len(), 2 * 4 * 3);
        let mut buffer = TerrainPiece::prism_buffer();
        let (mut sum, mut border) = (0.0, 0.0);
        for piece in all {
            let piece = terrain.piece(piece, &mut buffer);
            assert_convex(&piece.points, &piece.faces, 1e-12);
            sum += volume(&piece.points, &piece.faces);
            assert!(piece.faces[0].touchable && !piece.faces[1].touchable);
            let corners: Vec<Vector3<f64>> =
                piece.faces[0].corners.iter().map(|&k| piece.points[usize::from(k)]).collect();
            let normal = piece.normal(&piece.faces[0]);
            assert!(normal.z > 0.0);
            for k in 0..10 {
                // A point of the triangle, on the plane of the top and on the surface.
                let (s, t) = (0.1 * f64::from(k), 0.09 * f64::from(10 - k));
                let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
                let p = corners[0] + (corners[1] - corners[0]) * s + (corners[2] - corners[0]) * t;
                let surface = grid.height(p.x, p.y).unwrap();
                assert!((surface - p.z).abs() < 1e-12, "{surface} is not {}", p.z);
            }
            for face in piece.faces[2..].iter().filter(|face| face.touchable) {
                let [a, b] = [face.corners[0], face.corners[3]].map(|k| piece.points[usize::from(k)]);
                border += (b - a).xy().norm();
                let on_border = |p: &Vector3<f64>| ((p.x.abs() - 0.3).abs() < 1e-12, (p.y.abs() - 0.2).abs() < 1e-12);
                assert!((on_border(&a).0 && on_border(&b).0) || (on_border(&a).1 && on_border(&b).1));
            }
        }
        assert!((border - 2.0 * (0.6 + 0.4)).abs() < 1e-12, "the whole border, once: {border}");
        // The mean height of a triangle is that of its corners.
        let mut expected = 0.0;
        for (row, column) in (0..4).flat_map(|row| (0..3).map(move |column| (row, column))) {
            let [a, b, c, d] = grid.corners(row, column).map(|p| p.z);
            expected += 0.2 * 0.1 / 2.0 * ((a + b + c) / 3.0 + (a + c + d) / 3.0 - 2.0 * grid.bottom);
        }
        assert!((sum - expected).abs() < 1e-12, "{sum} is not {expected}");
        assert!(grid.bottom <= -1.0);
    }

    #[test]
    fn the_surface_passes_through_the_points_of_the_grid_and_ends_at_its_border() {
        let grid = HeightGrid::new(&entry(), heights(5, 4), [0.2, 0.1]);
        for (row, column) in (0..5).flat_map(|row| (0..4).map(move |column| (row, column))) {
            let p = grid.point(row, column);
            let found = grid.height(p.x, p.y).unwrap();
            assert!((found - grid.heights.at(row, column)).abs() < 1e-12);
        }
        assert_eq!((grid.point(0, 0).x, grid.point(0, 0).y), (-0.30000000000000004, -0.2));
        assert!(grid.height(0.0, 0.21).is_none() && grid.height(-0.31, 0.0).is_none());
    }

    #[test]
    fn a_small_box_gets_few_prisms_of_a_large_field() {
        let grid = HeightGrid::new(&entry(), heights(1000, 1000), [0.1, 0.1]);
        let terrain = Terrain::new(Vec::new(), vec![grid], None);
        let at = Vector3::new(12.34, -7.77, 0.1);
        let mut found = Vec::new();
        terrain.near(&at.add_scalar(-0.05), &at.add_scalar(0.05), |piece| found.push(piece));
        assert!((2..=8).contains(&found.len()), "{found:?}");
        let mut buffer = TerrainPiece::prism_buffer();
        let low = Vector3::new(at.x, at.y, -0.5);
        assert_eq!(found.iter().filter(|piece| terrain.piece(**piece, &mut buffer).contains(&low)).count(), 1);
        // Above the highest height, below the solid, and beside the field.
        for away in [Vector3::new(0.0, 0.0, 0.5), Vector3::new(0.0, 0.0, -1.5), Vector3::new(60.0, 0.0, 0.0)] {
            terrain.near(&away.add_scalar(-0.05), &away.add_scalar(0.05), |piece| panic!("{piece:?} at {away}"));
        }
    }
}
