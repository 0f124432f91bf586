//! Creates the force `drag` from its entry.

use crate::assemble::forces::{names, span};
use crate::assemble::names::Owner;
use crate::force::Force;
use crate::force::drag::Drag;
use crate::robot::{Base, LinkId};
use crate::scenario::{Diagnostic, DragForce, Run};
use nalgebra::Point3;

/// The drag of entry `i`; a link that the robot or object does not have is an error at its position.
pub(super) fn drag(
    run: &Run,
    owner: Owner,
    i: usize,
    spec: &DragForce,
    errors: &mut Vec<Diagnostic>,
) -> Option<Box<dyn Force>> {
    let model = owner.model;
    let points = match &spec.link {
        Some(name) => {
            let (link, pose) = names::moving_link(owner, run, &format!("force.{i}.link"), name, errors)?;
            let point = spec.point.map(|p| (pose * Point3::from(p)).coords);
            vec![(link, point.unwrap_or(model.links[link.0].com))]
        }
        None => {
            let moving = usize::from(model.base == Base::Fixed);
            model.links.iter().enumerate().skip(moving).map(|(l, link)| (LinkId(l), link.com)).collect()
        }
    };
    Some(Box::new(Drag {
        points,
        linear: spec.linear,
        quadratic: spec.quadratic,
        wind: spec.wind.into(),
        span: span(spec.start, spec.duration),
    }))
}
