//! Creates the force `random-pushes` from its entry.

use crate::assemble::forces::{names, shape};
use crate::assemble::names::Owner;
use crate::force::Force;
use crate::force::random_pushes::{Count, Distribution, RandomPushes};
use crate::random::Stream;
use crate::scenario::{Diagnostic, Directions, RandomPushes as Spec, Run};
use nalgebra::Point3;

/// Greatest expected number of pushes: ten standard deviations of a Poisson number below
/// [`MAX_PUSHES`](crate::force::random_pushes::MAX_PUSHES).
const MAX_EXPECTED: usize = 9_000;

/// The pushes of entry `i`, drawn from the run's seed and the entry's index. Unknown links and too
/// many pushes are errors at their positions.
pub(super) fn pushes(
    run: &Run,
    owner: Owner,
    i: usize,
    spec: &Spec,
    errors: &mut Vec<Diagnostic>,
) -> Option<Box<dyn Force>> {
    let mut targets = Vec::new();
    for (n, name) in spec.links.iter().enumerate() {
        let (link, pose) = names::moving_link(owner, run, &format!("force.{i}.links.{n}"), name, errors)?;
        targets.push((owner.part(name), link, (pose * Point3::from(spec.point)).coords));
    }
    if targets.is_empty() {
        let root = names::root_frame(owner, run, i, errors)?;
        targets.push((root.name, root.link, (root.pose * Point3::from(spec.point)).coords));
    }
    let seconds = spec.duration.unwrap_or(run.scenario.duration - spec.start).max(0.0);
    let (count, key, expected) = match (spec.number, spec.rate) {
        (Some(number), _) => (Count::Number(number as usize), "number", f64::from(number)),
        (None, rate) => {
            let rate = rate.unwrap_or(0.0);
            (Count::Rate(rate), "rate", rate * seconds)
        }
    };
    if expected > MAX_EXPECTED as f64 {
        let message = format!("`force.{i}.{key}` makes about {expected} pushes; at most {MAX_EXPECTED} are allowed");
        errors.push(run.error_at(&format!("force.{i}.{key}"), message, None));
        return None;
    }
    let from = Distribution {
        start: spec.start,
        span: seconds,
        count,
        targets,
        magnitude: spec.magnitude,
        duration: spec.push_duration,
        horizontal: spec.direction == Directions::Horizontal,
        shape: shape(spec.profile),
    };
    let purpose = ["run".to_owned(), "force".to_owned(), i.to_string()];
    Some(Box::new(RandomPushes::draw(&from, &mut Stream::new(run.scenario.seed, &purpose))))
}
