//! Creates the tasks `balance` and `gravity-compensation` from their entries.

use crate::assemble::{names, planned};
use crate::robot::{Base, JointId, Model, SoleId};
use crate::scenario::{BalanceControl, BalanceTask, Contacts, Diagnostic, GravityCompensationTask, Run};
use crate::task::Task;
use crate::task::balance::force_balance::{Change, ForceBalance, Gains, Settings};
use crate::task::balance::position_balance::{self, PositionBalance};
use crate::task::kinematic::planned_robot;
use nalgebra::{Vector2, Vector3};

/// The task of the entry at `path`; `None`, with an error, for a robot that cannot stand.
pub(super) fn balance(
    run: &Run,
    model: &Model,
    path: &str,
    spec: &BalanceTask,
    errors: &mut Vec<Diagnostic>,
) -> Option<Box<dyn Task>> {
    let soles = supporting_soles(run, model, path, spec.soles.as_deref(), errors);
    let task: Box<dyn Task> = match spec.control {
        BalanceControl::Force => {
            let (s, rate) = (&spec.force, run.scenario.control.rate);
            let gains = |g: crate::scenario::Gains| Gains { kp: g.kp, kd: g.kd };
            let settings = Settings {
                duration: spec.duration.unwrap_or(f64::INFINITY),
                com: gains(s.com),
                orientation: s.orientation.map_or_else(|| limited_gains(100.0, 20.0, rate / 50.0), gains),
                joints: s.joints.map_or_else(|| limited_gains(25.0, 10.0, rate / 100.0), gains),
                offset: s.offset.into(),
                approach: s.approach,
                friction: s.friction,
                margin: s.margin,
                sensed: s.contacts == Contacts::Sensed,
            };
            let changes = spec.change.iter().filter_map(|c| Some((c.at, c.force.as_ref()?))).map(|(at, c)| {
                let change = Change {
                    com: c.com.map(gains),
                    orientation: c.orientation.map(gains),
                    joints: c.joints.map(gains),
                    offset: c.offset.map(Vector3::from),
                    approach: c.approach,
                    friction: c.friction,
                    margin: c.margin,
                };
                (at, change)
            });
            Box::new(ForceBalance::new("balance", model, soles, settings, changes.collect()))
        }
        BalanceControl::Position => {
            planned::require_plannable(run, path, "a foot", planned_robot::check(model), errors)?;
            let s = &spec.position;
            let mut mobility = vec![0.0; model.nj()];
            planned_robot::carrying_joints(model).into_iter().for_each(|j| mobility[j] = 1.0);
            for (JointId(j), w) in
                names::joints(model, run, &format!("{path}.position.mobility"), s.mobility.iter(), errors)
            {
                mobility[j] = w;
            }
            let settings = position_balance::Settings {
                duration: spec.duration.unwrap_or(f64::INFINITY),
                proportional: s.proportional,
                damping: s.damping,
                integral: s.integral,
                leaning: s.leaning,
                reach: s.reach,
                posture: s.posture,
                approach: s.approach,
                offset: s.offset.into(),
                mobility,
                feed_forward: s.feed_forward,
            };
            let changes = spec.change.iter().filter_map(|c| Some((c.at, c.position.as_ref()?))).map(|(at, c)| {
                let change = position_balance::Change {
                    proportional: c.proportional,
                    damping: c.damping,
                    integral: c.integral,
                    leaning: c.leaning,
                    posture: c.posture,
                    offset: c.offset.map(Vector2::from),
                    approach: c.approach,
                };
                (at, change)
            });
            Box::new(PositionBalance::new(model, soles, settings, changes.collect()))
        }
    };
    Some(task)
}

/// Default gains with a damping of at most `max_damping`. Efforts are constant between ticks, so
/// stronger damping would oscillate. The stiffness is reduced with the damping, so that the gains
/// stay critically damped or better.
fn limited_gains(kp: f64, kd: f64, max_damping: f64) -> Gains {
    let kd = kd.min(max_damping);
    Gains { kp: kp.min(0.25 * kd * kd), kd }
}

/// The task of the entry at `path`.
pub(super) fn gravity_compensation(
    run: &Run,
    model: &Model,
    path: &str,
    spec: &GravityCompensationTask,
    errors: &mut Vec<Diagnostic>,
) -> Box<dyn Task> {
    let soles = supporting_soles(run, model, path, spec.soles.as_deref(), errors);
    let settings = Settings {
        duration: spec.duration.unwrap_or(f64::INFINITY),
        com: Gains::default(),
        orientation: Gains::default(),
        joints: Gains { kp: 0.0, kd: spec.damping },
        offset: Vector3::zeros(),
        approach: 0.0,
        friction: spec.friction,
        margin: spec.margin,
        sensed: false,
    };
    let changes = spec.change.iter().map(|c| {
        let joints = c.damping.map(|kd| Gains { kp: 0.0, kd });
        (c.at, Change { joints, friction: c.friction, margin: c.margin, ..Change::default() })
    });
    Box::new(ForceBalance::new("gravity-compensation", model, soles, settings, changes.collect()))
}

/// The supporting soles of the entry at `path`. Unknown soles are errors, and so is a free robot
/// without soles.
fn supporting_soles(
    run: &Run,
    model: &Model,
    path: &str,
    named: Option<&[String]>,
    errors: &mut Vec<Diagnostic>,
) -> Vec<SoleId> {
    if model.soles.is_empty() && model.base == Base::Floating {
        let message = format!("the robot `{}` has no soles to stand on", model.name);
        errors.push(run.error_at(&format!("{path}.type"), message, Some("give it `robot.soles`".into())));
    }
    match named {
        None => (0..model.soles.len()).map(SoleId).collect(),
        Some(named) => names::soles(model, run, &format!("{path}.soles"), named, errors),
    }
}
