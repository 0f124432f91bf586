//! `spring` from its entry.

use super::names;
use crate::force::Force;
use crate::force::anchor::{Anchor, Path};
use crate::force::spring::{Hold, Spring};
use crate::robot::Model;
use crate::scenario::{AnchorSpec, Diagnostic, PathShape, Run, SpringForce};
use nalgebra::Point3;

/// The spring of entry `i`; a link that the robot does not have is an error at its place.
pub(super) fn spring(
    run: &Run,
    model: &Model,
    i: usize,
    spec: &SpringForce,
    errors: &mut Vec<Diagnostic>,
) -> Option<Box<dyn Force>> {
    let (link, pose) = names::moving_link(model, run, &format!("force.{i}.link"), &spec.link, errors)?;
    let hold = Hold {
        name: spec.link.clone(),
        link,
        point: (pose * Point3::from(spec.point)).coords,
        stiffness: spec.stiffness,
        damping: spec.damping,
        rest_length: spec.rest_length,
    };
    let AnchorSpec { position, waypoints, .. } = &spec.anchor;
    let anchor = Anchor { origin: position.unwrap_or_default().into(), start: spec.start, path: path(&spec.anchor) };
    let from_point = position.is_none() && waypoints.is_empty();
    Some(Box::new(Spring::new(hold, anchor, from_point, spec.start, spec.duration.unwrap_or(f64::INFINITY))))
}

fn path(spec: &AnchorSpec) -> Path {
    if let Some(velocity) = spec.velocity {
        return Path::Line(velocity.into());
    }
    if let Some(sine) = spec.sine {
        return Path::Sine { amplitude: sine.amplitude.into(), frequency: sine.frequency, phase: sine.phase };
    }
    if spec.waypoints.is_empty() {
        return Path::Still;
    }
    let knots = spec.waypoints.iter().map(|w| (w.at, w.position.into())).collect();
    Path::Waypoints { knots, smooth: spec.path == PathShape::MinimumJerk }
}
