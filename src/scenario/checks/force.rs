//! Rules for `[[force]]`.

use super::Check;
use crate::scenario::spec::force::ForceSpec;

impl Check<'_> {
    /// `path` is the entry's, `end` the run's, s.
    pub(super) fn force(&mut self, path: &str, force: &ForceSpec, end: f64) {
        let start = match force {
            ForceSpec::Push(push) => push.start,
            ForceSpec::Constant(constant) => constant.start,
            ForceSpec::JointFriction(friction) => {
                if friction.all.is_none() && friction.joints.is_empty() {
                    self.error(path, "needs `all`, or `joints` with at least one joint");
                }
                let all = friction.all.iter().map(|f| ("all".to_owned(), f));
                let joints = friction.joints.iter().map(|(name, f)| (format!("joints.{name}"), f));
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
}
