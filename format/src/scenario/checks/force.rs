//! Rules for `[[force]]`.

use super::Check;
use crate::scenario::format::force::{AnchorSpec, ForceSpec, Grip, Profile, RandomPushes};
use crate::scenario::segment;

impl Check<'_> {
    /// `path` is that of the entry, `end` the end of the run, s.
    pub(super) fn force(&mut self, path: &str, force: &ForceSpec, end: f64) {
        match force.grip() {
            Some(Grip { link: None, end_effector: None }) if force.object().is_none() => {
                self.error(path, "needs `link` or `end_effector`");
            }
            Some(Grip { link: Some(_), end_effector: Some(_) }) => {
                self.error(&format!("{path}.end_effector"), "has no meaning with `link`; give one of them");
            }
            _ => {}
        }
        let start = match force {
            ForceSpec::Push(push) => push.start,
            ForceSpec::Constant(constant) => constant.start,
            ForceSpec::Ramp(ramp) => ramp.start,
            ForceSpec::Spring(spring) => {
                self.anchor(&format!("{path}.anchor"), &spring.anchor);
                return self.starts_in_time(path, spring.start, end);
            }
            ForceSpec::RandomPushes(pushes) => {
                self.random_pushes(path, pushes);
                return self.starts_in_time(path, pushes.start, end);
            }
            ForceSpec::Drag(drag) => {
                if drag.linear == 0.0 && drag.quadratic == 0.0 {
                    self.error(path, "needs `linear` or `quadratic`");
                }
                if drag.link.is_none() && drag.point.is_some() {
                    self.error(&format!("{path}.point"), "needs `link`: without it the drag acts on every link");
                }
                return self.starts_in_time(path, drag.start, end);
            }
            ForceSpec::CarriedObject(object) => {
                self.inertia(&format!("{path}.inertia"), object.inertia);
                return self.starts_in_time(path, object.start, end);
            }
            ForceSpec::Script(script) => {
                self.changes(path, &script.change);
                return self.starts_in_time(path, script.start, end);
            }
            ForceSpec::JointFriction(friction) => {
                if friction.all.is_none() && friction.joints.is_empty() {
                    self.error(path, "needs `all`, or `joints` with at least one joint");
                }
                let all = friction.all.iter().map(|f| ("all".to_owned(), f));
                let joints = friction.joints.iter().map(|(name, f)| (format!("joints.{}", segment(name)), f));
                for (key, f) in all.chain(joints) {
                    if let Some(value) = f.static_.filter(|s| *s < f.coulomb) {
                        let must = format!("must not be smaller than `coulomb` = {}, not {value}", f.coulomb);
                        self.error(&format!("{path}.{key}.static"), must);
                    }
                }
                return;
            }
        };
        if !self.has(path, "force") && !self.has(path, "moment") {
            self.error(path, "needs `force` or `moment`");
        }
        self.starts_in_time(path, start, end);
    }

    fn anchor(&mut self, path: &str, anchor: &AnchorSpec) {
        let moves = [anchor.velocity.is_some(), anchor.sine.is_some(), !anchor.waypoints.is_empty()];
        if moves.iter().filter(|given| **given).count() > 1 {
            self.error(path, "must move in one way: `velocity`, `sine` or `waypoints`");
        } else if !anchor.waypoints.is_empty() && anchor.position.is_some() {
            self.error(&format!("{path}.position"), "has no meaning with `waypoints`");
        }
        for (i, pair) in anchor.waypoints.windows(2).enumerate() {
            if pair[1].at <= pair[0].at {
                let key = format!("{path}.waypoints.{}.at", i + 1);
                self.error(&key, format!("must be after the previous waypoint, at {}, not {}", pair[0].at, pair[1].at));
            }
        }
    }

    fn random_pushes(&mut self, path: &str, pushes: &RandomPushes) {
        if pushes.number.is_some() == pushes.rate.is_some() {
            self.error(path, "needs either `number` or `rate`");
        }
        if pushes.links.is_empty() && pushes.object.is_none() {
            self.error(&format!("{path}.links"), "must name at least one link");
        }
        if pushes.profile == Profile::Ramp {
            self.error(&format!("{path}.profile"), "cannot be \"ramp\", which has no end");
        }
        let limits = [("magnitude", pushes.magnitude, 0.0), ("push_duration", pushes.push_duration, f64::MIN_POSITIVE)];
        for (key, [low, high], least) in limits {
            if !(least <= low && low <= high) {
                let above = if least > 0.0 { "above 0" } else { "0 or greater" };
                let must = format!("must be [least, greatest], {above} and in order, not [{low}, {high}]");
                self.error(&format!("{path}.{key}"), must);
            }
        }
    }
}
