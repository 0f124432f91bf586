//! The first layer: boxes aligned with the axes of the shared frame.
//!
//! ```text
//! gap(A, B) = | max(|c_A - c_B| - (h_A + h_B), 0) |  <=  d(A, B)
//! ```
//!
//! with centres c and half edges h, each maximum by component. The box of a rotated body contains
//! its rotated oriented box: `h = |R| h_0`. Boxes use single precision, four numbers in a row, and
//! are enlarged by more than its rounding errors, so the bound holds.

use crate::collision::kinematics::LinkPose;
use crate::collision::spatial::OrientedBox;

/// Boxes are enlarged by this fraction of their coordinates: an upper bound of the errors of a
/// dozen roundings of 6e-8 each.
const GROWTH: f64 = 1e-6;

/// An axis-aligned box; the fourth components are 0.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct AxisBox {
    /// Middle, m.
    center: [f32; 4],
    /// Half edges, m.
    half: [f32; 4],
}

impl AxisBox {
    /// A point at the origin.
    pub const ORIGIN: Self = AxisBox { center: [0.0; 4], half: [0.0; 4] };

    /// Around the oriented box of a link in its pose.
    #[inline]
    pub fn around(bounds: &OrientedBox, pose: &LinkPose) -> Self {
        let center = pose.point(&bounds.center);
        let half = (pose.rotation * bounds.axes).abs() * bounds.half;
        let grown = half.map(|h| h * (1.0 + GROWTH)) + center.abs() * GROWTH;
        Self {
            center: [center.x as f32, center.y as f32, center.z as f32, 0.0],
            half: [grown.x as f32, grown.y as f32, grown.z as f32, 0.0],
        }
    }

    /// Lower bound of the squared distance of the contents of the boxes, m^2; 0 when they overlap.
    #[inline]
    pub fn gap_squared(&self, other: &Self) -> f32 {
        let mut squares = [0.0f32; 4];
        for (i, square) in squares.iter_mut().enumerate() {
            let apart = (self.center[i] - other.center[i]).abs() - (self.half[i] + other.half[i]);
            let open = apart.max(0.0);
            *square = open * open;
        }
        (squares[0] + squares[1]) + (squares[2] + squares[3])
    }
}
