//! Boxes, ramps and stairs as convex solids.

use super::piece::{Solid, TerrainFace};
use nalgebra::Vector3;

/// A box with its edges along the axes and its centre at the origin. All its faces can be touched.
pub fn block(size: &Vector3<f64>) -> Solid {
    let half = size / 2.0;
    cuboid(-half, half, Touchable { back: true, front: true, underside: true })
}

/// A wedge that rises along x from 0 to the height `size.z` over the length `size.x`. The origin is
/// the middle of its lower front edge. Its underside cannot be touched.
pub fn ramp(size: &Vector3<f64>) -> Solid {
    let (l, w, h) = (size.x, size.y / 2.0, size.z);
    let points = vec![
        Vector3::new(0.0, -w, 0.0),
        Vector3::new(0.0, w, 0.0),
        Vector3::new(l, -w, 0.0),
        Vector3::new(l, w, 0.0),
        Vector3::new(l, -w, h),
        Vector3::new(l, w, h),
    ];
    let faces = vec![
        TerrainFace::new(&[0, 4, 5, 1], true),
        TerrainFace::new(&[0, 1, 3, 2], false),
        TerrainFace::new(&[2, 3, 5, 4], true),
        TerrainFace::new(&[0, 2, 4], true),
        TerrainFace::new(&[1, 5, 3], true),
    ];
    Solid { points, faces }
}

/// Dimensions of stairs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stairs {
    /// Number of steps.
    pub steps: u32,
    /// Height of each step, m.
    pub rise: f64,
    /// Length of each step, m.
    pub run: f64,
    /// Width, m.
    pub width: f64,
    /// Additional length of the last step, m.
    pub landing: f64,
}

/// Stairs that rise along x from the origin, the middle of their lower front edge: for each step a
/// column from height 0 to its tread.
///
/// A column's rear wall is covered by the next, higher column and cannot be touched, except for the
/// last one. Undersides cannot be touched.
pub fn stairs(stairs: &Stairs) -> Vec<Solid> {
    let w = stairs.width / 2.0;
    let column = |step: u32| {
        let is_last = step + 1 == stairs.steps;
        let landing = if is_last { stairs.landing } else { 0.0 };
        let end = f64::from(step + 1);
        let min = Vector3::new(f64::from(step) * stairs.run, -w, 0.0);
        let max = Vector3::new(end * stairs.run + landing, w, end * stairs.rise);
        cuboid(min, max, Touchable { back: is_last, front: true, underside: false })
    };
    (0..stairs.steps).map(column).collect()
}

/// Which faces of a cuboid can be touched, besides its top and its sides along y.
struct Touchable {
    /// The face at the greatest x.
    back: bool,
    /// The face at the least x.
    front: bool,
    /// The face at the least z.
    underside: bool,
}

/// The cuboid between two corners; point k has its greater x, y, z where bits 0, 1, 2 of k are set.
fn cuboid(min: Vector3<f64>, max: Vector3<f64>, touchable: Touchable) -> Solid {
    let corner = |k: usize| Vector3::from_fn(|axis, _| if k >> axis & 1 == 1 { max[axis] } else { min[axis] });
    let faces = vec![
        TerrainFace::new(&[4, 5, 7, 6], true),
        TerrainFace::new(&[0, 2, 3, 1], touchable.underside),
        TerrainFace::new(&[0, 4, 6, 2], touchable.front),
        TerrainFace::new(&[1, 3, 7, 5], touchable.back),
        TerrainFace::new(&[0, 1, 5, 4], true),
        TerrainFace::new(&[2, 6, 7, 3], true),
    ];
    Solid { points: (0..8).map(corner).collect(), faces }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_convex, volume};
    use super::*;

    fn check(solid: &Solid, expected: f64) {
        assert_convex(&solid.points, &solid.faces, 1e-12);
        let found = volume(&solid.points, &solid.faces);
        assert!((found - expected).abs() < 1e-12, "{found} is not {expected}");
    }

    #[test]
    fn boxes_and_ramps_have_their_volume_and_outward_normals() {
        let size = Vector3::new(0.7, 0.4, 0.3);
        let solid = block(&size);
        check(&solid, 0.7 * 0.4 * 0.3);
        assert!(solid.faces.iter().all(|face| face.touchable));
        assert!(solid.points.iter().sum::<Vector3<f64>>().norm() < 1e-12, "the centre is the origin");
        let solid = ramp(&size);
        check(&solid, 0.7 * 0.4 * 0.3 / 2.0);
        let hidden: Vec<_> = solid.faces.iter().filter(|face| !face.touchable).collect();
        assert!(hidden.len() == 1 && hidden[0].corners.iter().all(|&k| solid.points[usize::from(k)].z == 0.0));
        // The slope passes through the lower front edge, whose middle is the origin.
        let slope: Vec<_> = solid.faces[0].corners.iter().map(|&k| solid.points[usize::from(k)]).collect();
        assert!(slope.iter().all(|p| (p.z - p.x * 0.3 / 0.7).abs() < 1e-12 && p.y.abs() == 0.2));
    }

    #[test]
    fn walls_between_steps_cannot_be_touched() {
        let spec = Stairs { steps: 4, rise: 0.15, run: 0.3, width: 1.2, landing: 0.5 };
        let columns = stairs(&spec);
        assert_eq!(columns.len(), 4);
        for (i, column) in columns.iter().enumerate() {
            let (steps, landing) = ((i + 1) as f64, if i == 3 { 0.5 } else { 0.0 });
            check(column, (0.3 + landing) * 1.2 * 0.15 * steps);
            let rear = column.points.iter().map(|p| p.x).fold(0.0, f64::max);
            for face in &column.faces {
                let all = |holds: &dyn Fn(&Vector3<f64>) -> bool| {
                    face.corners.iter().all(|&k| holds(&column.points[usize::from(k)]))
                };
                let covered = all(&|p| p.z == 0.0) || all(&|p| p.x == rear) && i < 3;
                assert_eq!(face.touchable, !covered, "step {i}, {face:?}");
            }
            // The next column begins where this one ends and is higher.
            if let Some(next) = columns.get(i + 1) {
                assert!((next.points[0].x - rear).abs() < 1e-15 && next.points[7].z > column.points[7].z);
            }
        }
    }
}
