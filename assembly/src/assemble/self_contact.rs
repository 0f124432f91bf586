//! Creates the collision detection and avoidance of a run.

use crate::collision::avoidance::{Limits, Settings};
use crate::collision::{Detector, LinkPose, link_poses, shared_model};
use crate::robot::{DriveMode, Joint, Model, Robot};
use crate::scenario::{Diagnostic, JointLimits, Run};
use crate::sim::self_collision::SelfCollisionSetup;
use crate::sim::setup::Start;

/// Least control rate, Hz, at which kinematic joints follow their commands between ticks to some
/// micrometres.
const MIN_RATE: f64 = 100.0;

/// The collision settings of `[self_collision]`. With avoidance, a start too close to a collision
/// is an error.
pub(super) fn self_contact(
    run: &Run,
    robot: &Robot,
    model: &Model,
    start: &Start,
    notes: &mut Vec<String>,
    errors: &mut Vec<Diagnostic>,
) -> Option<SelfCollisionSetup> {
    let spec = run.scenario.self_collision.as_ref()?;
    let collision = shared_model(model, &robot.self_collision);
    if collision.pairs.is_empty() {
        notes.push(format!("`self_collision`: no two bodies of `{}` are checked", model.name));
    }
    let mut setup = SelfCollisionSetup { collision: collision.clone(), margin: spec.margin, avoid: None };
    if spec.method == 0 {
        return Some(setup);
    }
    if run.scenario.control.rate < MIN_RATE && model.joints.iter().any(|j| j.drive.mode == DriveMode::Kinematic) {
        let rate = run.scenario.control.rate;
        notes.push(format!(
            "`control.rate` = {rate} Hz: kinematic joints deviate from the commands of `self_collision` between such \
             distant ticks; {MIN_RATE} Hz or more avoids this"
        ));
    }
    let is_unlimited = run.scenario.robot.joint_limits == JointLimits::Ignore;
    // A joint that starts outside its range may stay there.
    let limit = |(joint, start): (&Joint, &f64)| {
        let limits = Limits::new(joint, spec.max_speed, spec.max_acceleration, spec.max_jerk);
        let (lower, upper) = if is_unlimited {
            (f64::NEG_INFINITY, f64::INFINITY)
        } else {
            (limits.lower.min(*start), limits.upper.max(*start))
        };
        Limits { lower, upper, ..limits }
    };
    let settings = Settings {
        method: spec.method,
        rate: spec.rate,
        margin: spec.margin,
        limits: model.joints.iter().zip(&start.joints).map(limit).collect(),
        seed: run.scenario.seed,
    };
    let mut detector = Detector::new(&collision);
    let mut poses = vec![LinkPose::IDENTITY; model.links.len()];
    link_poses(model, &start.joints, &mut poses);
    detector.set_poses(&collision, &poses);
    for pair in detector.colliding(&collision, spec.margin).to_vec() {
        let distance = detector.proximity(&collision, pair).distance;
        let [a, b] = collision.pairs[pair].bodies.map(|b| collision.bodies[b].name.as_str());
        let gap = if distance > 0.0 {
            format!("{distance:.4} m apart")
        } else {
            format!("{:.4} m into each other", -distance)
        };
        let message = format!(
            "`{a}` and `{b}` start {gap}: closer than `self_collision.margin` = {} m, so avoidance cannot guarantee the margin",
            spec.margin
        );
        let help = "start elsewhere, make the margin smaller, or list the pair under `ignore` in the robot file's \
                    `[self_collision]`";
        errors.push(run.error_at("self_collision.margin", message, Some(help.into())));
    }
    setup.avoid = Some(settings);
    Some(setup)
}
