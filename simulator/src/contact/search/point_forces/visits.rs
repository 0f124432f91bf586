//! Visits to the points in turn, for where the alternating directions do not converge.

use super::{DIVERGED, Point, PointForces, motion_at, project};
use crate::contact::model::problem::Problem;
use crate::contact::model::solution::wrench_at;
use crate::math;
use nalgebra::Vector3;

impl PointForces {
    /// Begins the visits. Returns false if a moving vertex jams: its normal response is not
    /// positive.
    pub(super) fn begin_visits(&mut self, p: &Problem) -> bool {
        let n = p.dim();
        for point in &mut self.points {
            let own = |f: &Vector3<f64>| {
                let wrench = wrench_at(&point.r, f);
                let motion: [f64; 6] = std::array::from_fn(|i| {
                    let row = &p.w[(6 * point.sole + i) * n + 6 * point.sole..][..6];
                    row.iter().zip(wrench).map(|(w, x)| w * x).sum()
                });
                motion_at(&motion, &point.r)
            };
            let (x, y) = (own(&Vector3::x()), own(&Vector3::y()));
            let (mean, half) = (0.5 * (x.x + y.y), 0.5 * (x.x - y.y));
            point.tangential = mean + math::hypot(half, x.y);
            let u = point.direction.unwrap_or_default() * -point.mu;
            point.normal = own(&Vector3::new(u.x, u.y, 1.0)).z;
        }
        self.points.iter_mut().for_each(|point| point.force = point.split);
        self.motion(p);
        (self.is_visiting, self.iterations) = (true, 0);
        self.points.iter().all(|point| point.normal > 0.0 && point.tangential > 0.0)
    }

    /// Visits all points once.
    pub(super) fn visit(&mut self, p: &Problem) {
        let n = p.dim();
        for point in &mut self.points {
            let (before, m) = (point.force, point.motion(p, &self.motion));
            let normal = (before.z - m.z / point.normal).max(0.0);
            let tangent = match point.direction {
                Some(u) => u * (-point.mu * normal),
                None => (before.xy() - m.xy() / point.tangential).cap_magnitude(point.mu * normal),
            };
            point.force = Vector3::new(tangent.x, tangent.y, normal);
            let wrench = wrench_at(&point.r, &(point.force - before));
            for (m, row) in self.motion.iter_mut().zip(p.w.chunks_exact(n)) {
                *m += row[6 * point.sole..].iter().zip(wrench).map(|(w, x)| w * x).sum::<f64>();
            }
        }
        self.points.iter_mut().for_each(|point| point.split = point.force);
        self.set_duals(p);
        let (drive, rho) = (self.drive().max(f64::MIN_POSITIVE), self.rho);
        let load = self.points.iter().map(|point| point.split.norm()).fold(f64::MIN_POSITIVE, f64::max);
        let change =
            |point: &Point| (point.split - project(point.split + point.dual / rho, point.mu, point.direction)).norm();
        let change = self.points.iter().map(change).fold(0.0, f64::max);
        self.residual = (change / load).max(change * rho / drive);
        // Several vertices may jam together although none does alone.
        if !(load * rho < DIVERGED * drive) || !self.motion.iter().all(|m| m.is_finite()) {
            for point in &mut self.points {
                (point.split, point.dual) = (Vector3::zeros(), Vector3::zeros());
            }
            (self.residual, self.is_done) = (f64::INFINITY, true);
        }
    }

    /// Keeps the forces if no visit has come nearer to the laws.
    pub(super) fn keep_best(&mut self) {
        if self.residual < self.best {
            self.best = self.residual;
            self.points.iter_mut().for_each(|point| point.best = point.split);
        }
    }

    /// Returns to the best forces of all visits: close to a jam they do not settle.
    pub(super) fn restore_best(&mut self, p: &Problem) {
        if self.best < self.residual {
            self.residual = self.best;
            self.points.iter_mut().for_each(|point| point.split = point.best);
            self.motion(p);
            self.set_duals(p);
        }
    }
}
