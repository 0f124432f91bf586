//! Preview control of the cart-table model: the centre-of-mass motion whose zero-moment point
//! follows a reference.
//!
//! ```text
//! x = (c, c', c''),   x(k+1) = A x(k) + b u(k),   p(k) = C x(k),   C = (1, 0, -h/g)
//! A = [1 T T^2/2; 0 1 T; 0 0 1],   b = (T^3/6, T^2/2, T)                         (u: jerk over the period T)
//! u(k) = -G_i sum_{i<=k} (p - p_ref)(i) - G_x x(k) - sum_{j=1..N} G_p(j) p_ref(k+j)
//! ```
//!
//! which minimises `sum Q (p - p_ref)^2 + R (u(k) - u(k-1))^2`. With the augmented system
//! `A~ = [1 CA; 0 A], b~ = (Cb; b), Q~ = diag(Q, 0, 0, 0)` and the solution P of its Riccati
//! equation
//!
//! ```text
//! (G_i, G_x) = (R + b~^T P b~)^-1 b~^T P A~,     A_c = A~ - b~ (G_i, G_x)
//! G_p(j) = (R + b~^T P b~)^-1 b~^T (A_c^T)^(j-1) P (-1, 0, 0, 0)^T
//! ```
//!
//! Sources: [Kajita 2003, equations 11 to 15]; the gains after [Katayama 1985].
//!
//! Symbols: c is the centre of mass in one horizontal direction, h its height above the floor, p
//! the zero-moment point, g gravity.

use crate::linalg::riccati;
use nalgebra::{Matrix3, Matrix4, RowVector3, Vector3, Vector4};

/// Weight of the jerk's change against that of the error, `R / Q`, m^2 over (m/s^3)^2 [Kajita
/// 2003].
pub const JERK_WEIGHT: f64 = 1e-6;

/// Gains for one height and period.
#[derive(Clone, Debug)]
pub struct Preview {
    /// Period T, s.
    pub period: f64,
    /// h / g, s^2.
    pub lag: f64,
    /// G_i.
    pub integral: f64,
    /// G_x.
    pub state: RowVector3<f64>,
    /// G_p(1), G_p(2), ...
    pub preview: Vec<f64>,
    /// P and its residual.
    pub riccati: riccati::Solution,
}

/// State at the start of a period and the jerk held through it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// c, c', c''.
    pub x: Vector3<f64>,
    /// u, m/s^3.
    pub jerk: f64,
}

impl Sample {
    /// State `t` seconds later: exact under constant jerk.
    pub fn at(&self, t: f64) -> Vector3<f64> {
        let (x, u) = (&self.x, self.jerk);
        Vector3::new(x[0] + t * (x[1] + t * (x[2] / 2.0 + t * u / 6.0)), x[1] + t * (x[2] + t * u / 2.0), x[2] + t * u)
    }
}

impl Preview {
    /// Gains for a centre of mass `height` m above the floor under `gravity` m/s^2 (its magnitude),
    /// with samples every `period` seconds and a preview of `horizon` seconds. `None` when no gains
    /// exist.
    pub fn new(height: f64, gravity: f64, period: f64, horizon: f64) -> Option<Self> {
        let (lag, t) = (height / gravity, period);
        let (a, b, c) = cart_table(lag, t);
        let (ca, cb) = (c * a, (c * b)[0]);
        let mut augmented = Matrix4::zeros();
        augmented[(0, 0)] = 1.0;
        augmented.fixed_view_mut::<1, 3>(0, 1).copy_from(&ca);
        augmented.fixed_view_mut::<3, 3>(1, 1).copy_from(&a);
        let input = Vector4::new(cb, b[0], b[1], b[2]);
        let mut q = Matrix4::zeros();
        q[(0, 0)] = 1.0;
        let riccati = riccati::solve(&augmented, &input, &q, JERK_WEIGHT)?;
        let gain = riccati::gain(&augmented, &input, JERK_WEIGHT, &riccati.p);
        let closed = augmented - input * gain.transpose();
        let scale = JERK_WEIGHT + (input.transpose() * riccati.p * input)[0];
        let mut column: Vector4<f64> = -riccati.p.column(0);
        let preview = (0..(horizon / t).round() as usize).map(|_| {
            let gain = input.dot(&column) / scale;
            column = closed.transpose() * column;
            gain
        });
        Some(Preview {
            period,
            lag,
            integral: gain[0],
            preview: preview.collect(),
            state: RowVector3::new(gain[1], gain[2], gain[3]),
            riccati,
        })
    }

    /// Zero-moment point of a state, m.
    pub fn zmp(&self, x: &Vector3<f64>) -> f64 {
        x[0] - self.lag * x[2]
    }

    /// Motion from rest at `reference[0]`: `count` samples, at most one per entry; the last entry
    /// continues indefinitely.
    pub fn follow(&self, reference: &[f64], count: usize) -> Vec<Sample> {
        let (Some(first), Some(last)) = (reference.first(), reference.last()) else { return Vec::new() };
        // Relative to the start, so that truncating the preview at the horizon has no effect at
        // rest.
        let target = |k: usize| reference.get(k).unwrap_or(last) - first;
        let (mut x, mut sum) = (Vector3::zeros(), 0.0);
        let count = count.min(reference.len());
        let mut samples = Vec::with_capacity(count);
        for k in 0..count {
            sum += self.zmp(&x) - target(k);
            let ahead: f64 = self.preview.iter().enumerate().map(|(j, g)| g * target(k + 1 + j)).sum();
            let jerk = -self.integral * sum - (self.state * x)[0] - ahead;
            samples.push(Sample { x: x + Vector3::new(*first, 0.0, 0.0), jerk });
            x = Sample { x, jerk }.at(self.period);
        }
        samples
    }
}

/// A, b and C.
pub fn cart_table(lag: f64, t: f64) -> (Matrix3<f64>, Vector3<f64>, RowVector3<f64>) {
    let a = Matrix3::new(1.0, t, t * t / 2.0, 0.0, 1.0, t, 0.0, 0.0, 1.0);
    (a, Vector3::new(t * t * t / 6.0, t * t / 2.0, t), RowVector3::new(1.0, 0.0, -lag))
}
