//! Rules for `[[task]]`.

use super::Check;
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
            TaskSpec::Squat(squat) => squat.start,
            TaskSpec::Walk(walk) => {
                if walk.double_support >= walk.step_time {
                    let message = format!("must be less than `step_time` = {}, not {}", walk.step_time, walk.double_support);
                    self.error(&format!("{path}.double_support"), message);
                }
                walk.start
            }
        };
        self.starts_in_time(path, start, end);
    }
}
