//! Rigid-body inertia: frame changes, sums by the parallel axis theorem, physical plausibility.
//!
//! For bodies a, b with masses m, centres c and central tensors J (same axes), the union has m =
//! m_a + m_b, c = (m_a c_a + m_b c_b) / m and J = sum of J_i + m_i (|d_i|^2 1 - d_i d_i^T) with d_i
//! = c_i - c (Huygens-Steiner; any mechanics textbook).

use nalgebra::{Isometry3, Matrix3, Point3, SymmetricEigen, Vector3};

/// Mass (kg), centre (m) and inertia tensor about that centre (kg m^2), all in one frame.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct RigidInertia {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass, m.
    pub com: Vector3<f64>,
    /// Inertia tensor about it, kg m^2.
    pub tensor: Matrix3<f64>,
}

/// Violation of the triangle inequality that is accepted, as a fraction of the largest moment:
/// tables are rounded.
const TRIANGLE_TOLERANCE: f64 = 1e-3;

/// Why no body with volume has a tensor.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::robot) enum Flaw {
    /// A principal moment is negative (beyond rounding).
    Negative,
    /// The largest principal moment exceeds the sum of the others.
    Triangle,
    /// A principal moment is zero: a point or a rod.
    Singular,
}

impl RigidInertia {
    /// The same body seen from the frame in which this one's frame has pose `pose`.
    pub fn transformed(&self, pose: &Isometry3<f64>) -> Self {
        let r = pose.rotation.to_rotation_matrix().into_inner();
        let tensor = r * self.tensor * r.transpose();
        // Rounding must not leave an asymmetric tensor.
        let tensor = 0.5 * (tensor + tensor.transpose());
        Self { mass: self.mass, com: (pose * Point3::from(self.com)).coords, tensor }
    }

    /// Both bodies, rigidly connected, in the same frame.
    pub fn plus(&self, other: &Self) -> Self {
        let mass = self.mass + other.mass;
        // A massless partner must leave mass and centre unchanged to the last bit.
        if other.mass == 0.0 {
            return Self { tensor: self.tensor + other.tensor, ..*self };
        }
        if self.mass == 0.0 {
            return Self { tensor: self.tensor + other.tensor, ..*other };
        }
        let com = (self.com * self.mass + other.com * other.mass) / mass;
        let steiner = |body: &Self| {
            let d = body.com - com;
            body.tensor + body.mass * (Matrix3::identity() * d.norm_squared() - d * d.transpose())
        };
        Self { mass, com, tensor: steiner(self) + steiner(other) }
    }
}

/// Principal moments, ascending, and the worst flaw.
pub(in crate::robot) fn examine(tensor: &Matrix3<f64>) -> ([f64; 3], Option<Flaw>) {
    let mut moments: [f64; 3] = SymmetricEigen::new(*tensor).eigenvalues.into();
    moments.sort_by(f64::total_cmp);
    let [small, middle, large] = moments;
    // Eigenvalues carry an error of some units in the last place of the largest.
    let rounding = 1e-12 * large.abs().max(small.abs());
    let flaw = if small < -rounding {
        Some(Flaw::Negative)
    } else if large - small - middle > TRIANGLE_TOLERANCE * large {
        Some(Flaw::Triangle)
    } else if small <= rounding {
        Some(Flaw::Singular)
    } else {
        None
    };
    (moments, flaw)
}

/// Principal moments as text.
pub(in crate::robot) fn moments_text(moments: [f64; 3]) -> String {
    let [a, b, c] = moments;
    format!("principal moments {a:.6e}, {b:.6e}, {c:.6e} kg m^2")
}
