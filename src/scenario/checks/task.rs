//! Rules for `[[task]]`.

use super::Check;
use crate::scenario::spec::change::ChangeSpec;
use crate::scenario::spec::task::TaskSpec;

impl Check<'_> {
    /// `path` is the entry's, `end` the run's, s.
    pub(super) fn task(&mut self, path: &str, task: &TaskSpec, end: f64) {
        let start = match task {
            TaskSpec::Posture(posture) => {
                if posture.joints.is_empty() {
                    self.error(&format!("{path}.joints"), "must name at least one joint");
                }
                posture.start
            }
            TaskSpec::Balance(balance) => {
                self.stands(path, balance.soles.as_deref());
                for (joint, mobility) in balance.position.mobility.iter().filter(|(_, w)| **w < 0.0) {
                    let message = format!("must be 0 or greater, not {mobility}");
                    self.error(&format!("{path}.position.mobility.{joint}"), message);
                }
                balance.start
            }
            TaskSpec::GravityCompensation(task) => {
                self.stands(path, task.soles.as_deref());
                task.start
            }
            TaskSpec::Script(script) => {
                self.changes(path, &script.change);
                script.start
            }
            TaskSpec::Squat(squat) => squat.start,
            TaskSpec::Walk(walk) => {
                if walk.double_support >= walk.step_time {
                    let message =
                        format!("must be less than `step_time` = {}, not {}", walk.step_time, walk.double_support);
                    self.error(&format!("{path}.double_support"), message);
                }
                walk.start
            }
        };
        self.starts_in_time(path, start, end);
    }

    /// Changes come one after the other.
    pub(super) fn changes(&mut self, path: &str, changes: &[ChangeSpec]) {
        for (i, pair) in changes.windows(2).enumerate() {
            if pair[1].at <= pair[0].at {
                let place = format!("{path}.change.{}.at", i + 1);
                self.error(&place, format!("must be after the change before, at {}, not {}", pair[0].at, pair[1].at));
            }
        }
    }

    /// Named soles are at least one.
    fn stands(&mut self, path: &str, soles: Option<&[String]>) {
        if soles.is_some_and(<[String]>::is_empty) {
            self.error(&format!("{path}.soles"), "must name at least one sole, or be left out: all");
        }
    }
}
