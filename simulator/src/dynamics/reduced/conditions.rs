//! Couplings and loops in the reduced problem: `x = P x_free + Q d` by mechanism, `P Y` by side, and the
//! multipliers; [`crate::dynamics::constraints`] has the equations.

use super::Mechanisms;
use crate::dynamics::constraints::{Constraints, LeastNorm};
use crate::dynamics::workspace::Workspace;

/// The parts of couplings and loops in a reduced problem.
#[derive(Clone, Debug)]
pub(super) struct Conditions {
    /// By mechanism: d, and `R lambda` without contacts.
    targets: Vec<Vec<f64>>,
    changes: Vec<Vec<f64>>,
    /// `Y^T Q d` of each side.
    pub(super) constrained: Vec<[f64; 6]>,
    /// `Q^T Y` of each side, and its first row.
    along: Vec<[f64; 6]>,
    start: Vec<usize>,
    /// Scratch, and `R lambda`.
    least_norm: LeastNorm,
    sum: Vec<f64>,
}

impl Conditions {
    pub(super) fn new(ws: Mechanisms) -> Self {
        let number = |m: usize| ws.get(m).constraints.number();
        let zeros: Vec<Vec<f64>> = (0..ws.number()).map(|m| vec![0.0; number(m)]).collect();
        let most = (0..ws.number()).map(number).max().unwrap_or_default();
        Conditions {
            targets: zeros.clone(),
            changes: zeros,
            constrained: Vec::new(),
            along: Vec::new(),
            start: Vec::new(),
            least_norm: LeastNorm::new(most),
            sum: vec![0.0; most],
        }
    }

    /// Allocates for sides on these mechanisms.
    pub(super) fn add_sides(&mut self, mechanisms: impl Iterator<Item = usize>) {
        for m in mechanisms {
            self.start.push(self.along.len());
            self.along.resize(self.along.len() + self.targets[m].len(), [0.0; 6]);
            self.constrained.push([0.0; 6]);
        }
    }

    /// Turns the half-solved free acceleration of mechanism `m` into the constrained one.
    pub(super) fn constrain(&mut self, m: usize, ws: &Workspace, half: &mut [f64]) {
        ws.constraints.constrain(&ws.v, half, &mut self.targets[m], &mut self.changes[m]);
    }

    /// Removes from Y of a side on mechanism `m` what the conditions do not permit.
    pub(super) fn project(&mut self, side: usize, m: usize, constraints: &Constraints, y: &mut [[f64; 6]]) {
        let mut constrained = [0.0; 6];
        let parts = &mut self.along[self.start[side]..];
        for ((q, d), along) in constraints.basis().zip(&self.targets[m]).zip(parts) {
            *along = [0.0; 6];
            for (q, y) in q.iter().zip(&*y) {
                along.iter_mut().zip(y).for_each(|(sum, y)| *sum += q * y);
            }
            constrained.iter_mut().zip(&*along).for_each(|(sum, along)| *sum += d * along);
            for (q, y) in q.iter().zip(&mut *y) {
                y.iter_mut().zip(&*along).for_each(|(y, along)| *y -= q * along);
            }
        }
        self.constrained[side] = constrained;
    }

    /// The multipliers for wrenches on sides of mechanism `m`.
    pub(super) fn multipliers<'a>(
        &mut self,
        m: usize,
        constraints: &Constraints,
        loads: impl Iterator<Item = (usize, &'a [f64])>,
        lambda: &mut [f64],
    ) {
        let sum = &mut self.sum[..constraints.rank()];
        sum.copy_from_slice(&self.changes[m][..constraints.rank()]);
        for (side, w) in loads {
            for (sum, along) in sum.iter_mut().zip(&self.along[self.start[side]..]) {
                *sum -= along.iter().zip(w).map(|(a, w)| a * w).sum::<f64>();
            }
        }
        constraints.multipliers(sum, &mut self.least_norm, lambda);
    }
}
