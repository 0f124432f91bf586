//! Null-space motion: the part of a joint motion that moves neither the soles nor the controlled
//! quantities.
//!
//! ```text
//! minimise  sum w_k (v_k - e_k)^2   subject to   A v = 0
//! ```
//!
//! over all velocities v, those of the base at no cost. e is the preferred joint motion, A the
//! Jacobians of the quantities that must not move: the soles, and the centre of mass and the
//! orientation of the base if they are controlled. In the coordinates `sqrt(w) v` the solution is
//! the orthogonal projection on the null space of A. An orthonormal basis of the rows comes from
//! the modified Gram-Schmidt process, applied twice [Bjorck 1996, section 2.4]; dependent rows are
//! dropped.
//!
//! With w the joints' inertias, an effort `w k v` of the result does no work on any motion that
//! keeps the soles in place and is orthogonal, in that metric, to the null space: it cannot
//! displace the controlled centre of mass.

/// A row that shrinks below this fraction of its norm when the earlier rows are removed depends on
/// them.
const DEPENDENT: f64 = 1e-9;
/// Cost of moving the base relative to joints of unit weight. Ideally 0; the error of the result is
/// of this order.
const FREE: f64 = 1e-8;

/// Projector on the null space, with scratch for one robot.
#[derive(Clone, Debug)]
pub struct NullSpaceMotion {
    nv: usize,
    /// Square roots of the weights.
    scale: Vec<f64>,
    /// Orthonormal rows found so far.
    rows: Vec<f64>,
    used: usize,
}

impl NullSpaceMotion {
    /// For up to `rows` constraints on `nb` base velocities and joints with `weights` above zero.
    pub fn new(nb: usize, weights: &[f64], rows: usize) -> Self {
        let mean = weights.iter().sum::<f64>() / weights.len().max(1) as f64;
        let base = std::iter::repeat_n((FREE * mean).sqrt(), nb);
        let scale: Vec<f64> = base.chain(weights.iter().map(|w| w.sqrt())).collect();
        NullSpaceMotion { nv: scale.len(), rows: vec![0.0; rows * scale.len()], scale, used: 0 }
    }

    /// Removes all constraints.
    pub fn clear(&mut self) {
        self.used = 0;
    }

    /// Adds the constraint `sum row(k) v_k = 0`.
    pub fn constrain(&mut self, row: impl Fn(usize) -> f64) {
        let (done, rest) = self.rows.split_at_mut(self.used * self.nv);
        let Some(new) = rest.get_mut(..self.nv) else { return };
        for (k, (x, s)) in new.iter_mut().zip(&self.scale).enumerate() {
            *x = row(k) / s;
        }
        let before = norm(new);
        for _ in 0..2 {
            done.chunks_exact(self.nv).for_each(|q| remove_along(q, new));
        }
        let after = norm(new);
        if after > DEPENDENT * before {
            new.iter_mut().for_each(|x| *x /= after);
            self.used += 1;
        }
    }

    /// Replaces `motion` (nv, laid out as velocities) by its part that keeps all constraints.
    pub fn project(&self, motion: &mut [f64]) {
        motion.iter_mut().zip(&self.scale).for_each(|(m, s)| *m *= s);
        for _ in 0..2 {
            self.rows[..self.used * self.nv].chunks_exact(self.nv).for_each(|q| remove_along(q, motion));
        }
        motion.iter_mut().zip(&self.scale).for_each(|(m, s)| *m /= s);
    }
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Removes the part along the unit vector `q` from `x`.
fn remove_along(q: &[f64], x: &mut [f64]) {
    let along: f64 = q.iter().zip(x.iter()).map(|(q, x)| q * x).sum();
    x.iter_mut().zip(q).for_each(|(x, q)| *x -= along * q);
}
