//! Rules for tasks of type `policy`.

use super::Check;
use crate::scenario::format::task::{PolicyMode, PolicyNumbers, PolicyObservation, PolicyTask, PolicyTerm};

/// Longest history; all of it is the input of a network.
const LONGEST_HISTORY: u32 = 1000;

impl Check<'_> {
    /// `path` is that of the entry, `end` the end of the run, s.
    pub(super) fn policy(&mut self, path: &str, policy: &PolicyTask, end: f64) {
        self.file(path, &policy.file, &["onnx"]);
        if policy.observations.is_empty() {
            self.error(&format!("{path}.observations"), "must have at least one term");
        }
        for (i, observation) in policy.observations.iter().enumerate() {
            self.observation(&format!("{path}.observations.{i}"), observation);
        }
        if policy.history > LONGEST_HISTORY {
            let must = format!("must be at most {LONGEST_HISTORY}, not {}", policy.history);
            self.error(&format!("{path}.history"), must);
        }
        self.action(path, policy);
        for (i, state) in policy.state.iter().enumerate() {
            let before = &policy.state[..i];
            if before.iter().any(|other| other.input == state.input) {
                self.error(&format!("{path}.state.{i}.input"), format!("names {:?} a second time", state.input));
            }
        }
        let times = policy.change.iter().map(|change| change.at);
        self.spaced_changes(path, times, policy.start, 0.0, "", end);
        self.new_commands(path, policy);
    }

    /// Keys must belong to the term.
    fn observation(&mut self, path: &str, observation: &PolicyObservation) {
        use PolicyTerm::*;
        let term = observation.term;
        let of_joints = matches!(term, JointPositions | JointVelocities);
        let of_soles = matches!(term, SoleForces | Contacts);
        let periodic = matches!(term, Sine | Cosine);
        let given = [
            ("joints", observation.joints.is_some(), of_joints),
            ("relative", !observation.relative, term == JointPositions),
            ("soles", observation.soles.is_some(), of_soles),
            ("threshold", observation.threshold.is_some(), term == Contacts),
            ("values", !observation.values.is_empty(), term == Command),
            ("period", observation.period.is_some(), periodic),
            ("phase", observation.phase != 0.0, periodic),
        ];
        for (key, _, _) in given.into_iter().filter(|(_, given, meant)| *given && !meant) {
            self.error(&format!("{path}.{key}"), "has no meaning with this `term`: leave it out");
        }
        for (key, list) in [("joints", &observation.joints), ("soles", &observation.soles)] {
            if list.as_ref().is_some_and(Vec::is_empty) {
                self.error(&format!("{path}.{key}"), "must have at least one name, or be left out");
            }
        }
        if term == Command && observation.values.is_empty() {
            self.error(path, "needs `values`");
        }
        if periodic && observation.period.is_none() {
            self.error(path, "needs `period`");
        }
    }

    fn action(&mut self, path: &str, policy: &PolicyTask) {
        let action = &policy.action;
        if action.joints.is_empty() {
            self.error(&format!("{path}.action.joints"), "must name at least one joint");
        }
        for (key, gains) in [("kp", &action.kp), ("kd", &action.kd)] {
            let Some(gains) = gains else { continue };
            let key = format!("{path}.action.{key}");
            if action.mode == PolicyMode::Force {
                self.error(&key, "has no meaning with `mode = \"force\"`: leave it out");
            }
            match gains {
                PolicyNumbers::All(gain) if *gain < 0.0 => {
                    self.error(&key, format!("must be 0 or greater, not {gain}"));
                }
                PolicyNumbers::Each(gains) => {
                    for (i, gain) in gains.iter().enumerate().filter(|(_, gain)| **gain < 0.0) {
                        self.error(&format!("{key}.{i}"), format!("must be 0 or greater, not {gain}"));
                    }
                }
                PolicyNumbers::All(_) => {}
            }
        }
    }

    /// Changes replace the values of one term.
    fn new_commands(&mut self, path: &str, policy: &PolicyTask) {
        if policy.change.is_empty() {
            return;
        }
        let commands: Vec<_> = policy.observations.iter().filter(|o| o.term == PolicyTerm::Command).collect();
        let [command] = commands[..] else {
            let must = format!("requires one term `command` in `observations`, not {}", commands.len());
            return self.error(&format!("{path}.change"), must);
        };
        for (i, change) in policy.change.iter().enumerate().filter(|(_, c)| c.values.len() != command.values.len()) {
            let (given, wanted) = (change.values.len(), command.values.len());
            let must = format!("must have {wanted} numbers, as the term `command` has, not {given}");
            self.error(&format!("{path}.change.{i}.values"), must);
        }
    }
}
