//! `drag`: air resistance.
//!
//! ```text
//! f = -(c1 + c2 |w|) w,    w = v_point - u
//! ```
//!
//! v_point the velocity of a point of the link, u that of the air, c1 the linear coefficient
//! (Stokes), c2 the quadratic one (Newton: `rho A C_d / 2`). The force acts at the point; it exerts
//! no moment about it.

use super::profile::Profile;
use super::{AppliedForces, Damper, Force, ForceContext};
use crate::dynamics::jacobian;
use crate::robot::LinkId;
use nalgebra::Vector3;

/// Air resistance on points of links.
#[derive(Clone, Debug)]
pub struct Drag {
    /// Points of action in the internal frames of links, m.
    pub points: Vec<(LinkId, Vector3<f64>)>,
    /// Linear coefficient c1 of each point, N s/m.
    pub linear: f64,
    /// Quadratic coefficient c2 of each point, N s^2/m^2.
    pub quadratic: f64,
    /// Velocity u of the air, world, m/s.
    pub wind: Vector3<f64>,
    /// Strength over time.
    pub span: Profile,
}

impl Drag {
    /// Velocity w of a world point through the air, m/s, and the drag coefficient `c1 + c2 |w|`, N
    /// s/m.
    fn relative_velocity(&self, context: &ForceContext, link: LinkId, point: &Vector3<f64>) -> (Vector3<f64>, f64) {
        let relative = jacobian::point_velocity(context.kinematics, link, point) - self.wind;
        (relative, self.linear + self.quadratic * relative.norm())
    }
}

impl Force for Drag {
    fn evaluate(&mut self, context: &ForceContext, applied: &mut AppliedForces) {
        let strength = self.span.factor(context.time, context.within);
        if strength == 0.0 {
            return;
        }
        for &(link, local) in &self.points {
            let point = context.kinematics.point(link, &local);
            let (relative, coefficient) = self.relative_velocity(context, link, &point);
            let force = relative * -coefficient;
            applied.wrench(context, link, &point, &force, &Vector3::zeros());
        }
    }

    fn dampers(&self, context: &ForceContext, damper: &mut dyn FnMut(Damper)) {
        if self.span.factor(context.time, context.within) == 0.0 {
            return;
        }
        for &(link, local) in &self.points {
            let point = context.kinematics.point(link, &local);
            damper(Damper { link, point, coefficient: self.relative_velocity(context, link, &point).1 });
        }
    }

    fn arrows(&self) -> usize {
        self.points.len()
    }

    fn corners(&self) -> &[f64] {
        self.span.corners()
    }
}
