//! Creates the force `spring` from its entry.

use crate::assemble::names::GripFrame;
use crate::force::Force;
use crate::force::anchor::{Anchor, AnchorPath};
use crate::force::spring::{Spring, SpringParameters};
use crate::scenario::{AnchorSpec, PathShape, SpringForce};
use nalgebra::Point3;

/// The spring of the entry.
pub(super) fn spring(frame: GripFrame, spec: &SpringForce) -> Box<dyn Force> {
    let parameters = SpringParameters {
        point: (frame.pose * Point3::from(spec.point)).coords,
        name: frame.name,
        link: frame.link,
        stiffness: spec.stiffness,
        damping: spec.damping,
        rest_length: spec.rest_length,
    };
    let AnchorSpec { position, waypoints, .. } = &spec.anchor;
    let anchor = Anchor { origin: position.unwrap_or_default().into(), start: spec.start, path: path(&spec.anchor) };
    let from_point = position.is_none() && waypoints.is_empty();
    Box::new(Spring::new(parameters, anchor, from_point, spec.start, spec.duration.unwrap_or(f64::INFINITY)))
}

fn path(spec: &AnchorSpec) -> AnchorPath {
    if let Some(velocity) = spec.velocity {
        return AnchorPath::Line(velocity.into());
    }
    if let Some(sine) = spec.sine {
        return AnchorPath::Sine { amplitude: sine.amplitude.into(), frequency: sine.frequency, phase: sine.phase };
    }
    if spec.waypoints.is_empty() {
        return AnchorPath::Still;
    }
    let knots = spec.waypoints.iter().map(|w| (w.at, w.position.into())).collect();
    AnchorPath::Waypoints { knots, smooth: spec.path == PathShape::MinimumJerk }
}
