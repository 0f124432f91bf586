//! `spring`: a spring and damper between a point of a link and an anchor that may move, such as a
//! person's hand.
//!
//! ```text
//! f = k (1 - l0 / |d|) d + c d',    d = p_anchor - p_point
//! ```
//!
//! k stiffness, c damping, l0 rest length: Hooke's law along the connecting line and a viscous
//! damper. With l0 = 0 the spring is linear in all three directions. The damper acts on the whole
//! relative velocity, also across the line, as that of an arm does. Where point and anchor coincide
//! (`d = 0`), a spring with a rest length has no direction and exerts no force.

use super::anchor::Anchor;
use super::profile::{Profile, Shape};
use super::{AppliedForces, Damper, Force, ForceContext, ReportEvent, Slope};
use crate::dynamics::jacobian;
use crate::robot::LinkId;
use nalgebra::{Matrix3, Vector3};
use std::any::Any;

/// Parameters of a spring.
#[derive(Clone, Debug, PartialEq)]
pub struct SpringParameters {
    /// Name of the link, for messages.
    pub name: String,
    /// Link it pulls on.
    pub link: LinkId,
    /// Point in the link's internal frame, m.
    pub point: Vector3<f64>,
    /// Stiffness k, N/m.
    pub stiffness: f64,
    /// Damping c, N s/m.
    pub damping: f64,
    /// Rest length l0, m.
    pub rest_length: f64,
}

/// A spring with its anchor and time span.
#[derive(Clone, Debug)]
pub struct Spring {
    parameters: SpringParameters,
    anchor: Anchor,
    /// True if the anchor's path starts at the position of the point when the spring is attached.
    from_point: bool,
    start: f64,
    end: f64,
    /// 1 while it is attached.
    span: Profile,
    corners: Vec<f64>,
    /// True while it is attached, as last reported.
    attached: bool,
    /// True if it must be attached again: it has replaced one that was attached elsewhere.
    reattach: bool,
}

/// The line from a spring's point to its anchor, world, m, and the velocity of the anchor, m/s.
struct Line {
    point: Vector3<f64>,
    d: Vector3<f64>,
    velocity: Vector3<f64>,
}

impl Spring {
    /// A spring attached from `start` for `duration` seconds, which may be infinite. With
    /// `from_point` the anchor's path begins at the position of the point when it is attached.
    pub fn new(parameters: SpringParameters, anchor: Anchor, from_point: bool, start: f64, duration: f64) -> Self {
        let span = Profile::new(Shape::Constant, start, duration);
        let mut corners = span.corners().to_vec();
        corners.extend(anchor.corners());
        let end = start + duration;
        Spring { parameters, anchor, from_point, start, end, span, corners, attached: false, reattach: false }
    }

    /// True if the other spring has the same anchor and point.
    fn has_same_ends(&self, other: &Spring) -> bool {
        let (a, b) = (&self.anchor, &other.anchor);
        let origin = self.from_point || (a.origin, a.start) == (b.origin, b.start);
        let point = (self.parameters.link, self.parameters.point) == (other.parameters.link, other.parameters.point);
        point && origin && self.from_point == other.from_point && a.path == b.path
    }

    fn point(&self, context: &ForceContext) -> Vector3<f64> {
        let (rotation, origin) = context.frame(self.parameters.link);
        origin + rotation * self.parameters.point
    }

    /// The line; none while the spring is not attached.
    fn line(&self, context: &ForceContext) -> Option<Line> {
        let is_attached = self.span.factor(context.time, context.within) != 0.0;
        is_attached.then(|| {
            let point = self.point(context);
            let (anchor, velocity) = self.anchor.at(context.time, context.within);
            Line { point, d: anchor - point, velocity }
        })
    }
}

impl Force for Spring {
    fn continue_from(&mut self, former: &dyn Any, _time: f64) {
        let Some(former) = former.downcast_ref::<Spring>().filter(|former| former.attached) else { return };
        self.attached = true;
        self.reattach = !self.has_same_ends(former);
        if !self.reattach {
            self.anchor.clone_from(&former.anchor);
        }
    }

    fn on_corner(&mut self, context: &ForceContext, report: &mut ReportEvent) {
        let attach = (self.start..self.end).contains(&context.time);
        if attach && (!self.attached || self.reattach) {
            if self.from_point {
                (self.anchor.origin, self.anchor.start) = (self.point(context), context.time);
            }
            let [x, y, z] = self.anchor.at(context.time, context.within).0.into();
            report("spring", &self.parameters.name, format!("attached to ({x:.4}, {y:.4}, {z:.4})"));
        } else if self.attached && !attach {
            report("spring", &self.parameters.name, "released".into());
        }
        (self.attached, self.reattach) = (attach, false);
    }

    fn evaluate(&mut self, context: &ForceContext, applied: &mut AppliedForces) {
        let Some(Line { point, d, velocity }) = self.line(context) else { return };
        let SpringParameters { link, stiffness, damping, rest_length, .. } = self.parameters;
        let length = d.norm();
        let elastic = match rest_length {
            0.0 => d * stiffness,
            rest if length > 0.0 => d * (stiffness * (1.0 - rest / length)),
            _ => Vector3::zeros(),
        };
        let approach = velocity - jacobian::point_velocity(context.kinematics, link, &point);
        applied.wrench(context, link, &point, &(elastic + approach * damping), &Vector3::zeros());
    }

    fn dampers(&self, context: &ForceContext, damper: &mut dyn FnMut(Damper)) {
        let SpringParameters { link, damping, .. } = self.parameters;
        if damping > 0.0 && self.span.factor(context.time, context.within) != 0.0 {
            damper(Damper { link, point: self.point(context), coefficient: damping });
        }
    }

    fn slopes(&self, context: &ForceContext, each: &mut dyn FnMut(Slope)) {
        let Some(Line { point, d, velocity }) = self.line(context) else { return };
        let SpringParameters { link, stiffness, damping, rest_length, .. } = self.parameters;
        let length = d.norm();
        // Along the line k, across it k (1 - l0 / |d|).
        let share = if rest_length > 0.0 && length > 0.0 { rest_length / length } else { 0.0 };
        let along = if length > 0.0 { d * d.transpose() / (length * length) } else { Matrix3::zeros() };
        let stiffness = (Matrix3::identity() * (1.0 - share) + along * share) * stiffness;
        let damper = Damper { link, point, coefficient: damping };
        each(Slope::Point { damper, stiffness, by_time: stiffness * velocity });
    }

    fn corners(&self) -> &[f64] {
        &self.corners
    }
}
