//! Distributes a desired wrench on the body over contact points: least squares within the friction
//! cones.
//!
//! ```text
//! minimise  1/2 sum |f_i|^2   subject to   sum f_i = F,   sum r_i x f_i = N,   f_i in K_i                          (1)
//! K_i = { f : f_n >= 0, |f_t| <= mu f_n }    about the normal n_i of the contact
//! ```
//!
//! **Inside all cones** the solution is the pseudo-inverse, in closed form: with
//! `G_i = (1; [r_i]x)` and `y = (sum G_i G_i^T)^-1 (F, N)`, `f_i = G_i^T y`, an affine field over
//! the points. This is the least-norm distribution at the desired centre of pressure of [Hyon 2007,
//! section III].
//!
//! **Otherwise** (1) is solved by its dual, in six unknowns for any number of contacts: its
//! minimiser has the form `f_i = P_i(G_i^T y)`, P_i the projection on K_i, and y maximises a
//! concave function with the gradient `w - sum G_i P_i(G_i^T y)`, w = (F, N). Each step of the
//! method of multipliers
//!
//! ```text
//! y_k+1 = argmin  1/2 sum |P_i(G_i^T y)|^2 - w . y + eps/2 |y - y_k|^2                                             (2)
//! ```
//!
//! is once continuously differentiable, strongly convex, and solved by Newton's method with the
//! derivative of P_i (a semi-smooth Newton method) and a line search. If no forces in the cones add
//! up to w, the same steps lead to the nearest feasible wrench [Chiche 2016], in the norm of
//! [`Measure`]. It divides moments by a length smaller than the height of the centre of mass. Thus
//! a push past the edge of the soles reduces the horizontal force rather than adding a moment that
//! would tip the body over.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// A force (N) and its moment (N m) about the common reference point.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Wrench {
    /// Force, N.
    pub force: Vector3<f64>,
    /// Moment, N m.
    pub moment: Vector3<f64>,
}

/// Norm of the difference between an infeasible desired wrench and its substitute.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Measure {
    /// Reference force, N: the robot's weight. Above zero.
    pub force: f64,
    /// Length by which moments are divided for comparison with forces, m. Above zero.
    pub length: f64,
    /// Unit vector upwards; a missing force along it has the weight [`VERTICAL`].
    pub up: Vector3<f64>,
}

/// Weight of a missing vertical force: without it the robot would jump rather than yield.
pub const VERTICAL: f64 = 10.0;

/// Weights eps of the first steps of (2), relative to the number of contacts: the early steps bring
/// the later ones close.
const WEIGHTS: [f64; 2] = [1e-1, 1e-3];
/// Weight of all further steps. Each reduces the remaining error to about this fraction.
const LAST_WEIGHT: f64 = 1e-5;
/// Limit on these further steps; two to four are usual.
const LAST_STEPS: usize = 8;
/// Limit on Newton steps for one step of (2): convergence takes about ten.
const NEWTON_STEPS: usize = 40;
/// Smallest fraction of a Newton step that is tried: below it rounding dominates.
const SHORTEST: f64 = 1e-8;
/// Remainder of w, relative to it, that counts as rounding.
const ROUNDING: f64 = 1e-15;

/// The contacts of one instant and their forces. `add` within the capacity allocates nothing.
#[derive(Clone, Debug)]
pub struct Distribution {
    contacts: Vec<Contact>,
    forces: Vec<Vector3<f64>>,
}

#[derive(Clone, Copy, Debug)]
struct Contact {
    arm: Vector3<f64>,
    normal: Vector3<f64>,
}

impl Distribution {
    /// Reserves memory for `capacity` contacts.
    pub fn new(capacity: usize) -> Self {
        Distribution { contacts: Vec::with_capacity(capacity), forces: Vec::with_capacity(capacity) }
    }

    /// Removes all contacts.
    pub fn clear(&mut self) {
        self.contacts.clear();
        self.forces.clear();
    }

    /// Adds a contact at `arm` from the reference point (m) with the unit normal `normal` towards
    /// the robot.
    pub fn add(&mut self, arm: Vector3<f64>, normal: Vector3<f64>) {
        self.contacts.push(Contact { arm, normal });
        self.forces.push(Vector3::zeros());
    }

    /// Forces on the robot from the last solution, N, in the order of [`add`](Self::add).
    pub fn forces(&self) -> &[Vector3<f64>] {
        &self.forces
    }

    /// Computes the forces and returns their sum, which is `desired` if the cones of coefficient
    /// `friction` allow it.
    pub fn solve(&mut self, desired: &Wrench, friction: f64, measure: &Measure) -> Wrench {
        let map = Map {
            lift: Matrix3::identity() + measure.up * measure.up.transpose() * (VERTICAL - 1.0),
            length: measure.length,
        };
        let force = map.lift * desired.force;
        let moment = desired.moment / measure.length;
        let w = Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z) / measure.force;
        if !self.solve_closed_form(&map, &w, friction) {
            self.solve_dual(&map, &w, friction);
        }
        for f in &mut self.forces {
            *f *= measure.force;
        }
        self.sum()
    }

    /// Sum of the forces.
    fn sum(&self) -> Wrench {
        let mut sum = Wrench { force: Vector3::zeros(), moment: Vector3::zeros() };
        for (contact, f) in self.contacts.iter().zip(&self.forces) {
            sum.force += f;
            sum.moment += contact.arm.cross(f);
        }
        sum
    }

    /// The closed form. Returns false if it leaves a cone, or if the contacts cannot produce every
    /// wrench.
    fn solve_closed_form(&mut self, map: &Map, w: &Vector6<f64>, friction: f64) -> bool {
        let mut gram = Matrix6::zeros();
        for contact in &self.contacts {
            let g = map.columns(&contact.arm);
            gram += g * g.transpose();
        }
        let scale = gram.diagonal().max();
        let Some(factor) = gram.cholesky() else { return false };
        let l = factor.l_dirty();
        if (0..6).any(|k| l[(k, k)] * l[(k, k)] < 1e-12 * scale) {
            return false;
        }
        let mut y = Vector6::zeros();
        // The second round removes the rounding of the first.
        for _ in 0..2 {
            let mut rest = *w;
            for contact in &self.contacts {
                rest -= map.wrench(&contact.arm, &map.field(&y, &contact.arm));
            }
            y += factor.solve(&rest);
        }
        for (contact, f) in self.contacts.iter().zip(&mut self.forces) {
            *f = map.field(&y, &contact.arm);
            let normal = f.dot(&contact.normal);
            if (*f - contact.normal * normal).norm() > friction * normal {
                return false;
            }
        }
        true
    }

    /// The dual method.
    fn solve_dual(&mut self, map: &Map, w: &Vector6<f64>, friction: f64) {
        let size = w.norm().max(f64::MIN_POSITIVE);
        let mut y = Vector6::zeros();
        let mut missing = f64::INFINITY;
        for weight in WEIGHTS.into_iter().chain([LAST_WEIGHT; LAST_STEPS]) {
            let eps = weight * self.contacts.len() as f64;
            y = self.proximal(map, w, friction, &y, eps);
            let mut rest = *w;
            for (contact, f) in self.contacts.iter().zip(&mut self.forces) {
                *f = project(&map.field(&y, &contact.arm), &contact.normal, friction).0;
                rest -= map.wrench(&contact.arm, f);
            }
            let remaining = rest.norm() / size;
            // Either w is reached, or progress has stopped: w is infeasible.
            if remaining <= ROUNDING || (weight == LAST_WEIGHT && remaining > 0.5 * missing) {
                return;
            }
            missing = remaining;
        }
    }

    /// One step of (2) from `centre`.
    fn proximal(&self, map: &Map, w: &Vector6<f64>, friction: f64, centre: &Vector6<f64>, eps: f64) -> Vector6<f64> {
        let mut y = *centre;
        let (mut value, mut gradient) = self.dual(map, w, friction, &y, centre, eps);
        for _ in 0..NEWTON_STEPS {
            if gradient.norm() <= ROUNDING * (w.norm() + eps * y.norm()) {
                break;
            }
            let Some(factor) = self.curvature(map, friction, &y, eps).cholesky() else { break };
            let step = -factor.solve(&gradient);
            let slope = gradient.dot(&step);
            let mut length = 1.0;
            let better = loop {
                let next = y + step * length;
                let (v, g) = self.dual(map, w, friction, &next, centre, eps);
                // Where rounding hides the decrease of the value, the gradient decides.
                let hidden = (v - value).abs() <= 8.0 * f64::EPSILON * value.abs();
                if v <= value + 1e-4 * length * slope || (hidden && g.norm() < gradient.norm()) {
                    break Some((next, v, g));
                }
                length *= 0.5;
                if length < SHORTEST {
                    break None;
                }
            };
            let Some(better) = better else { break };
            (y, value, gradient) = better;
        }
        y
    }

    /// The function of (2) and its gradient.
    fn dual(
        &self,
        map: &Map,
        w: &Vector6<f64>,
        friction: f64,
        y: &Vector6<f64>,
        centre: &Vector6<f64>,
        eps: f64,
    ) -> (f64, Vector6<f64>) {
        let away = y - centre;
        let mut value = 0.5 * eps * away.norm_squared() - w.dot(y);
        let mut gradient = away * eps - w;
        for contact in &self.contacts {
            let f = project(&map.field(y, &contact.arm), &contact.normal, friction).0;
            value += 0.5 * f.norm_squared();
            gradient += map.wrench(&contact.arm, &f);
        }
        (value, gradient)
    }

    /// A generalised second derivative of the function of (2), positive definite.
    fn curvature(&self, map: &Map, friction: f64, y: &Vector6<f64>, eps: f64) -> Matrix6<f64> {
        let mut h = Matrix6::identity() * eps;
        for contact in &self.contacts {
            let g = map.columns(&contact.arm);
            let derivative = project(&map.field(y, &contact.arm), &contact.normal, friction).1;
            h += g * derivative * g.transpose();
        }
        h
    }
}

/// Wrenches in the norm of a [`Measure`].
struct Map {
    lift: Matrix3<f64>,
    length: f64,
}

impl Map {
    /// `G f`.
    fn wrench(&self, arm: &Vector3<f64>, f: &Vector3<f64>) -> Vector6<f64> {
        let (force, moment) = (self.lift * f, arm.cross(f) / self.length);
        Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z)
    }

    /// `G^T y`.
    fn field(&self, y: &Vector6<f64>, arm: &Vector3<f64>) -> Vector3<f64> {
        self.lift * y.fixed_rows::<3>(0) + y.fixed_rows::<3>(3).cross(arm) / self.length
    }

    /// G.
    fn columns(&self, arm: &Vector3<f64>) -> nalgebra::SMatrix<f64, 6, 3> {
        let mut g = nalgebra::SMatrix::<f64, 6, 3>::zeros();
        g.fixed_view_mut::<3, 3>(0, 0).copy_from(&self.lift);
        g.fixed_view_mut::<3, 3>(3, 0).copy_from(&(arm.cross_matrix() / self.length));
        g
    }
}

/// Nearest point to `x` of the cone of coefficient `friction` about `normal`, and its derivative.
fn project(x: &Vector3<f64>, normal: &Vector3<f64>, friction: f64) -> (Vector3<f64>, Matrix3<f64>) {
    let up = x.dot(normal);
    let tangent = x - normal * up;
    let side = tangent.norm();
    if side <= friction * up {
        return (*x, Matrix3::identity());
    }
    if friction * side <= -up {
        return (Vector3::zeros(), Matrix3::zeros());
    }
    // The nearest point is on the edge of the cone in the plane of x and the normal.
    let t = tangent / side;
    let slant = (1.0 + friction * friction).sqrt();
    let edge = (normal + t * friction) / slant;
    let along = edge.dot(x);
    let turn = Matrix3::identity() - normal * normal.transpose() - t * t.transpose();
    (edge * along, edge * edge.transpose() + turn * (along * friction / (slant * side)))
}
