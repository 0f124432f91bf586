//! Rules for `[[force]]`.

use super::Check;
use crate::scenario::spec::force::{AnchorSpec, ForceSpec};

impl Check<'_> {
    /// `path` is the entry's, `end` the run's, s.
    pub(super) fn force(&mut self, path: &str, force: &ForceSpec, end: f64) {
        let start = match force {
            ForceSpec::Push(push) => push.start,
            ForceSpec::Constant(constant) => constant.start,
            ForceSpec::Ramp(ramp) => ramp.start,
            ForceSpec::Spring(spring) => {
                self.anchor(&format!("{path}.anchor"), &spring.anchor);
                return self.starts_in_time(path, spring.start, end);
            }
            ForceSpec::JointFriction(friction) => {
                if friction.all.is_none() && friction.joints.is_empty() {
                    self.error(path, "needs `all`, or `joints` with at least one joint");
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
            self.error(&format!("{path}.position"), "has no meaning beside `waypoints`");
        }
        for (i, pair) in anchor.waypoints.windows(2).enumerate() {
            if pair[1].at <= pair[0].at {
                let place = format!("{path}.waypoints.{}.at", i + 1);
                self.error(&place, format!("must be after the waypoint before, at {}, not {}", pair[0].at, pair[1].at));
            }
        }
    }
}
