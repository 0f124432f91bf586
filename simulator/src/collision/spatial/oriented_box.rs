//! A small box around a convex polyhedron, with one side along one of its faces.

use nalgebra::{Matrix3, Vector3};

/// At most this many of the polyhedron's triangles are tried, evenly spread, to limit load time.
const MOST_TRIED: usize = 200;

/// A box with axes of its own.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct OrientedBox {
    /// Middle, m.
    pub center: Vector3<f64>,
    /// Axes as columns.
    pub axes: Matrix3<f64>,
    /// Half edges along the axes, m.
    pub half: Vector3<f64>,
}

impl OrientedBox {
    /// The box of least surface among those along the frame's axes and along a face and one of its
    /// edges.
    pub fn around(vertices: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Self {
        let along_frame = Self::along(Matrix3::identity(), vertices);
        let stride = triangles.len().div_ceil(MOST_TRIED).max(1);
        let candidates = triangles.iter().step_by(stride).flat_map(|t| {
            let [a, b, c] = t.map(|k| vertices[k as usize]);
            let normal = (b - a).cross(&(c - a)).normalize();
            [b - a, c - b, a - c].map(|edge| {
                let edge = edge.normalize();
                Matrix3::from_columns(&[edge, normal.cross(&edge), normal])
            })
        });
        let smaller = |least: Self, axes| {
            let next = Self::along(axes, vertices);
            if next.surface() < least.surface() { next } else { least }
        };
        candidates.filter(|axes| axes.iter().all(|x| x.is_finite())).fold(along_frame, smaller)
    }

    fn along(axes: Matrix3<f64>, vertices: &[Vector3<f64>]) -> Self {
        let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        for p in vertices {
            let at = axes.tr_mul(p);
            (low, high) = (low.inf(&at), high.sup(&at));
        }
        Self { center: axes * ((low + high) / 2.0), axes, half: (high - low) / 2.0 }
    }

    /// An eighth of the surface, m^2.
    fn surface(&self) -> f64 {
        let h = &self.half;
        h.x * h.y + h.y * h.z + h.z * h.x
    }
}
