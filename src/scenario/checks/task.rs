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
            TaskSpec::Balance(balance) => {
                if balance.soles.as_ref().is_some_and(Vec::is_empty) {
                    self.error(&format!("{path}.soles"), "must name at least one sole, or be left out: all");
                }
                balance.start
            }
        };
        self.starts_in_time(path, start, end);
    }
}
