//! Rules for `[[task]]`.

use super::Check;
use crate::scenario::format::change::ChangeSpec;
use crate::scenario::format::task::{
    BalanceControl, BalanceTask, ForceBalance, MocapTask, PositionBalance, SineTask, TaskSpec, WalkTask,
};
use crate::scenario::segment;
use crate::text::suggest;

/// Shortest step of a walk, s: several samples of its pattern.
const SHORTEST_STEP: f64 = 0.05;
/// Longest walk, s: its pattern takes several hundred MB.
const LONGEST_WALK: f64 = 1e4;

impl Check<'_> {
    /// `path` is that of the entry, `end` the end of the run, s.
    pub(super) fn task(&mut self, path: &str, task: &TaskSpec, end: f64) {
        let start = match task {
            TaskSpec::Posture(posture) => {
                if posture.joints.is_empty() {
                    self.error(&format!("{path}.joints"), "must name at least one joint");
                }
                posture.start
            }
            TaskSpec::Sine(sine) => {
                self.sine(path, sine, end);
                sine.start
            }
            TaskSpec::Playback(playback) => {
                self.file(path, &playback.file, &["toml", "csv", "mcap"]);
                let times = playback.change.iter().map(|c| c.at);
                self.spaced_changes(path, times, playback.start, playback.blend, "blend", end);
                if playback.repeat && playback.ends.is_some() {
                    self.error(&format!("{path}.ends"), "has no meaning with `loop`: there is no end");
                }
                playback.start
            }
            TaskSpec::Mocap(mocap) => {
                self.file(path, &mocap.file, &["bvh", "csv"]);
                self.mocap(path, mocap);
                mocap.start
            }
            TaskSpec::Balance(balance) => {
                self.sole_list(path, balance.soles.as_deref());
                for (joint, mobility) in balance.position.mobility.iter().filter(|(_, w)| **w < 0.0) {
                    let message = format!("must be 0 or greater, not {mobility}");
                    self.error(&format!("{path}.position.mobility.{}", segment(joint)), message);
                }
                self.balance_changes(path, balance, end);
                // A resolved scenario has both tables, the unused one with its defaults.
                let (other, given) = match balance.control {
                    BalanceControl::Force => ("position", balance.position != PositionBalance::default()),
                    BalanceControl::Position => ("force", balance.force != ForceBalance::default()),
                };
                if given {
                    let must = "has no meaning with this `control`: leave it out";
                    self.error(&format!("{path}.{other}"), must);
                }
                balance.start
            }
            TaskSpec::GravityCompensation(task) => {
                self.sole_list(path, task.soles.as_deref());
                let times = task.change.iter().map(|c| c.at);
                self.spaced_changes(path, times, task.start, 0.0, "", end);
                task.start
            }
            TaskSpec::Script(script) => {
                self.changes(path, &script.change);
                let early = script.change.iter().position(|c| c.at < script.start);
                if let Some(i) = early {
                    let must = format!("must not be before `start` = {}, not {}", script.start, script.change[i].at);
                    self.error(&format!("{path}.change.{i}.at"), must);
                }
                script.start
            }
            TaskSpec::Squat(squat) => squat.start,
            TaskSpec::Policy(policy) => {
                self.policy(path, policy, end);
                policy.start
            }
            TaskSpec::Walk(walk) => {
                if walk.double_support >= walk.step_time {
                    let message =
                        format!("must be less than `step_time` = {}, not {}", walk.step_time, walk.double_support);
                    self.error(&format!("{path}.double_support"), message);
                }
                self.walk(path, walk, end);
                walk.start
            }
        };
        self.starts_in_time(path, start, end);
    }

    /// Limits the pattern that is planned when a walk begins: the step time from below, the whole
    /// length from above.
    fn walk(&mut self, path: &str, walk: &WalkTask, end: f64) {
        if walk.step_time < SHORTEST_STEP {
            self.error(
                &format!("{path}.step_time"),
                format!("must be at least {SHORTEST_STEP} s, not {}", walk.step_time),
            );
        }
        let whole = 2.0 * walk.wait + f64::from(walk.steps) * walk.step_time + walk.double_support;
        let planned = whole.min(end - walk.start - walk.settle);
        if planned > LONGEST_WALK {
            let key = if 2.0 * walk.wait > LONGEST_WALK { "wait" } else { "steps" };
            let must =
                format!("makes a walk of {planned:.0} s within the run; at most {LONGEST_WALK:.0} s can be planned");
            self.error(&format!("{path}.{key}"), must);
        }
    }

    /// Times of changes must increase.
    pub(super) fn changes(&mut self, path: &str, changes: &[ChangeSpec]) {
        for (i, pair) in changes.windows(2).enumerate() {
            if pair[1].at <= pair[0].at {
                let key = format!("{path}.change.{}.at", i + 1);
                self.error(&key, format!("must be after the previous change, at {}, not {}", pair[0].at, pair[1].at));
            }
        }
    }

    /// A list of soles must not be empty.
    fn sole_list(&mut self, path: &str, soles: Option<&[String]>) {
        if soles.is_some_and(<[String]>::is_empty) {
            self.error(&format!("{path}.soles"), "must name at least one sole, or be left out: all");
        }
    }

    /// Changes of a balance must set its own `control`.
    fn balance_changes(&mut self, path: &str, balance: &BalanceTask, end: f64) {
        let times = balance.change.iter().map(|c| c.at);
        self.spaced_changes(path, times, balance.start, 0.0, "", end);
        for (i, change) in balance.change.iter().enumerate() {
            let (own, other, has_own, has_other) = match balance.control {
                BalanceControl::Force => ("force", "position", change.force.is_some(), change.position.is_some()),
                BalanceControl::Position => ("position", "force", change.position.is_some(), change.force.is_some()),
            };
            if has_other {
                let message = format!("has no meaning with `control = \"{own}\"`");
                self.error(&format!("{path}.change.{i}.{other}"), message);
            } else if !has_own {
                self.error(&format!("{path}.change.{i}"), format!("needs `{own}`"));
            }
        }
    }

    fn sine(&mut self, path: &str, sine: &SineTask, end: f64) {
        if sine.joints.is_empty() {
            self.error(&format!("{path}.joints"), "must name at least one joint");
        }
        if let Some(duration) = sine.duration.filter(|d| *d < 2.0 * sine.ramp) {
            let must = format!("must be at least twice `ramp` = {}, not {duration}", sine.ramp);
            self.error(&format!("{path}.duration"), must);
        }
        let times = sine.change.iter().map(|c| c.at);
        self.spaced_changes(path, times, sine.start, sine.ramp, "ramp", end);
        for (i, change) in sine.change.iter().enumerate() {
            for name in change.joints.keys().filter(|name| !sine.joints.contains_key(*name)) {
                let help = suggest::help(name, sine.joints.keys().map(String::as_str).collect::<Vec<_>>());
                let key = format!("{path}.change.{i}.joints.\"{name}\"");
                let span = self.spans(&key).0;
                self.findings.error(span, format!("`{path}` does not swing `{name}`"), Some(help));
            }
        }
    }

    fn mocap(&mut self, path: &str, mocap: &MocapTask) {
        if mocap.map.is_empty() {
            self.error(&format!("{path}.map"), "must map at least one channel");
        }
        for (i, (name, target)) in mocap.map.iter().enumerate() {
            if let Some((other, _)) = mocap.map.iter().take(i).find(|(_, other)| other.joint == target.joint) {
                let must = format!("{:?} is moved already by {other:?}", target.joint);
                self.error(&format!("{path}.map.\"{name}\".joint"), must);
            }
        }
    }

    /// Changes must come after the start, each after the end of the previous one.
    pub(super) fn spaced_changes(
        &mut self,
        path: &str,
        times: impl Iterator<Item = f64>,
        start: f64,
        min_gap: f64,
        what: &str,
        end: f64,
    ) {
        let mut previous = None;
        for (i, at) in times.enumerate() {
            let key = format!("{path}.change.{i}.at");
            match previous.replace(at) {
                None if at < start => self.error(&key, format!("must not be before `start` = {start}, not {at}")),
                Some(before) if at <= before => {
                    self.error(&key, format!("must be after the previous change, at {before}, not {at}"));
                }
                Some(before) if at < before + min_gap => {
                    let must = format!("must be at least `{what}` = {min_gap} after the change at {before}, not {at}");
                    self.error(&key, must);
                }
                _ if at >= end => self.warning(&key, format!("`{key}` = {at} s, but the run ends at {end} s")),
                _ => {}
            }
        }
    }
}
