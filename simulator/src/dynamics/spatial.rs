//! Spatial vectors and inertias in world axes about one common point O.
//!
//! A rigid body of mass m, centre c and inertia I_c has the spatial inertia (m, m c, I_O), ten
//! numbers, with `I_O = I_c + m (|c|^2 1 - c c^T)` and momentum
//! `I V = (m v - m c x omega, m c x v + I_O omega)`.
//!
//! Source: [Featherstone 2008], sections 2.9 to 2.13 (angular first there, linear first here).

use nalgebra::{Matrix3, Vector3};
use std::ops::{Add, AddAssign, Sub};

/// A twist or its rate: velocity (m/s) of the body-fixed point that is at O, and angular velocity
/// (rad/s).
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Motion {
    /// Linear part at O.
    pub linear: Vector3<f64>,
    /// Angular part.
    pub angular: Vector3<f64>,
}

/// A wrench or a momentum: force (N) and moment about O (N m).
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Force {
    /// Force.
    pub linear: Vector3<f64>,
    /// Moment about O.
    pub angular: Vector3<f64>,
}

impl Motion {
    /// No motion.
    pub const ZERO: Motion = Motion { linear: Vector3::new(0.0, 0.0, 0.0), angular: Vector3::new(0.0, 0.0, 0.0) };

    /// From its parts.
    #[inline(always)]
    pub fn new(linear: Vector3<f64>, angular: Vector3<f64>) -> Self {
        Motion { linear, angular }
    }

    /// Reads six numbers, linear first.
    #[inline(always)]
    pub fn from_slice(x: &[f64]) -> Self {
        Motion { linear: Vector3::new(x[0], x[1], x[2]), angular: Vector3::new(x[3], x[4], x[5]) }
    }

    /// Velocity of the body point that is at `r` (from O).
    #[inline(always)]
    pub fn at(&self, r: &Vector3<f64>) -> Vector3<f64> {
        self.linear + self.angular.cross(r)
    }

    /// `V x other`: rate of a motion vector carried along by a body moving with `self`.
    #[inline(always)]
    pub fn cross(&self, other: &Motion) -> Motion {
        Motion {
            linear: self.angular.cross(&other.linear) + self.linear.cross(&other.angular),
            angular: self.angular.cross(&other.angular),
        }
    }

    /// `V x* f`: rate of a force vector carried along by a body moving with `self`.
    #[inline(always)]
    pub fn cross_force(&self, f: &Force) -> Force {
        Force {
            linear: self.angular.cross(&f.linear),
            angular: self.angular.cross(&f.angular) + self.linear.cross(&f.linear),
        }
    }

    /// Power of the wrench `f` on this motion.
    #[inline(always)]
    pub fn dot(&self, f: &Force) -> f64 {
        self.linear.dot(&f.linear) + self.angular.dot(&f.angular)
    }

    /// `self * s`.
    #[inline(always)]
    pub fn scaled(&self, s: f64) -> Motion {
        Motion { linear: self.linear * s, angular: self.angular * s }
    }
}

impl Force {
    /// No force.
    pub const ZERO: Force = Force { linear: Vector3::new(0.0, 0.0, 0.0), angular: Vector3::new(0.0, 0.0, 0.0) };

    /// From its parts.
    #[inline(always)]
    pub fn new(linear: Vector3<f64>, angular: Vector3<f64>) -> Self {
        Force { linear, angular }
    }
}

macro_rules! six_vector {
    ($name:ident) => {
        impl $name {
            /// Six numbers, linear first.
            #[inline(always)]
            pub fn to_array(&self) -> [f64; 6] {
                let (a, b) = (&self.linear, &self.angular);
                [a.x, a.y, a.z, b.x, b.y, b.z]
            }
        }
        impl Add for $name {
            type Output = $name;
            #[inline(always)]
            fn add(self, o: $name) -> $name {
                $name { linear: self.linear + o.linear, angular: self.angular + o.angular }
            }
        }
        impl Sub for $name {
            type Output = $name;
            #[inline(always)]
            fn sub(self, o: $name) -> $name {
                $name { linear: self.linear - o.linear, angular: self.angular - o.angular }
            }
        }
        impl AddAssign for $name {
            #[inline(always)]
            fn add_assign(&mut self, o: $name) {
                *self = *self + o;
            }
        }
    };
}

six_vector!(Motion);
six_vector!(Force);

/// Spatial inertia about O.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Inertia {
    /// Mass m, kg.
    pub mass: f64,
    /// First moment m c, kg m.
    pub moment: Vector3<f64>,
    /// Rotational inertia about O: xx, xy, xz, yy, yz, zz, kg m^2.
    pub rotational: [f64; 6],
}

impl Inertia {
    /// No inertia.
    pub const ZERO: Inertia = Inertia { mass: 0.0, moment: Vector3::new(0.0, 0.0, 0.0), rotational: [0.0; 6] };

    /// Inertia of a body with mass `m` (kg), centre `c` (m, from O) and inertia `R inertia R^T`
    /// about its centre (kg m^2).
    #[inline(always)]
    pub fn of_body(m: f64, c: &Vector3<f64>, r: &Matrix3<f64>, inertia: &Matrix3<f64>) -> Self {
        let t = r * inertia;
        let mc = c * m;
        let (x, y, z) = (mc.x * c.x, mc.y * c.y, mc.z * c.z);
        let entry = |i: usize, j: usize| t[(i, 0)] * r[(j, 0)] + t[(i, 1)] * r[(j, 1)] + t[(i, 2)] * r[(j, 2)];
        Inertia {
            mass: m,
            moment: mc,
            rotational: [
                entry(0, 0) + (y + z),
                entry(0, 1) - mc.x * c.y,
                entry(0, 2) - mc.x * c.z,
                entry(1, 1) + (x + z),
                entry(1, 2) - mc.y * c.z,
                entry(2, 2) + (x + y),
            ],
        }
    }

    /// `I V`: momentum of a twist, or force of an acceleration.
    #[inline(always)]
    pub fn apply(&self, v: &Motion) -> Force {
        Force {
            linear: v.linear * self.mass - self.moment.cross(&v.angular),
            angular: self.moment.cross(&v.linear) + self.rotate(&v.angular),
        }
    }

    /// `I_O w`.
    #[inline(always)]
    pub fn rotate(&self, w: &Vector3<f64>) -> Vector3<f64> {
        let [xx, xy, xz, yy, yz, zz] = self.rotational;
        Vector3::new(xx * w.x + xy * w.y + xz * w.z, xy * w.x + yy * w.y + yz * w.z, xz * w.x + yz * w.y + zz * w.z)
    }
}

impl AddAssign for Inertia {
    #[inline(always)]
    fn add_assign(&mut self, o: Inertia) {
        self.mass += o.mass;
        self.moment += o.moment;
        for (a, b) in self.rotational.iter_mut().zip(&o.rotational) {
            *a += b;
        }
    }
}
