//! Checks rules between the values of each `[[claim]]`.

use super::{Check, MAX_ENTRIES};
use crate::scenario::decode::NodeDeserializer;
use crate::scenario::findings::Findings;
use crate::scenario::format::claim::ClaimSpec;
use crate::scenario::format::compare::CompareSpec;
use crate::scenario::format::expect::Expect;
use crate::text::toml_tree::Node;
use serde::Deserialize;

/// Reports claims whose values contradict each other; false if there is one.
pub fn check_claims(claims: &[ClaimSpec], root: &Node, findings: &mut Findings) -> bool {
    let before = findings.errors();
    // An error in `[compare]` is reported when it is read.
    let compare = root.get("compare").and_then(|node| CompareSpec::deserialize(NodeDeserializer(node)).ok());
    let mut check = Check { root, findings };
    if claims.len() > MAX_ENTRIES {
        check.error("claim", format!("has {} entries, at most {MAX_ENTRIES} are allowed", claims.len()));
        return false;
    }
    for (i, claim) in claims.iter().enumerate() {
        let path = format!("claim.{i}");
        if claims[..i].iter().any(|other| other.name == claim.name) && !claim.name.is_empty() {
            check.error(&format!("{path}.name"), format!("is the name of two claims: `{}`", claim.name));
        }
        check.claim(&path, claim, compare.as_ref());
    }
    check.findings.errors() == before
}

impl Check<'_> {
    fn claim(&mut self, path: &str, claim: &ClaimSpec, compare: Option<&CompareSpec>) {
        let at = |key: &str| format!("{path}.{key}");
        if claim.name.trim().is_empty() {
            match self.has(path, "name") {
                true => self.error(&at("name"), "must not be empty"),
                false => self.error(path, "lacks the key `name`"),
            }
        }
        self.subject(path, claim);
        match (claim.at_least, claim.at_most) {
            (Some(_), Some(_)) => self.error(&at("at_most"), "must not be given together with `at_least`"),
            (None, None) => self.error(path, "lacks the key `at_least` (or `at_most`)"),
            _ => {}
        }
        let limit = if claim.at_least.is_some() { "at_least" } else { "at_most" };
        let inside = |x: f64| x > 0.0 && x < 1.0;
        let shares = [
            (
                limit,
                claim.share.as_ref().and(claim.at_least.or(claim.at_most)),
                "no number of runs shows a share of exactly",
            ),
            ("quantile", claim.quantile, "no number of runs shows the quantile"),
        ];
        for (key, value, why) in shares {
            if let Some(value) = value.filter(|value| !inside(*value)) {
                let ends = if value == 0.0 || value == 1.0 { format!("; {why} {value}") } else { String::new() };
                self.error(&at(key), format!("must be greater than 0 and less than 1, not {value}{ends}"));
            }
        }
        // With less, a claim and its opposite could both be shown.
        if !(claim.confidence > 0.5 && claim.confidence < 1.0) {
            self.error(
                &at("confidence"),
                format!("must be greater than 0.5 and less than 1, not {}", claim.confidence),
            );
        }
        if let Some(share) = &claim.share {
            self.share(&at("share"), share, claim.change.as_deref());
            self.error_metric(&at("share.metric"), share, compare);
        }
        if claim.change.is_some() && claim.early {
            self.error(
                &at("early"),
                "must not be given together with `change`, which the end of a batch does not judge",
            );
        }
        let columns = [("metric", &claim.metric), ("difference", &claim.difference), ("change", &claim.change)];
        for (key, metric) in columns {
            if metric.is_some() {
                self.error_metric(&at(key), &Expect { metric: metric.clone(), ..Expect::default() }, compare);
            }
        }
    }

    /// The condition of a share: of runs, or of the changes of a column.
    fn share(&mut self, path: &str, share: &Expect, change: Option<&str>) {
        let Some(column) = change else { return self.expect(path, share) };
        for (key, given) in [("metric", share.metric.is_some()), ("outcome", share.outcome.is_some())] {
            if given {
                self.error(
                    &format!("{path}.{key}"),
                    format!("must not be given: the limits are of the change of `{column}`"),
                );
                return;
            }
        }
        self.expect(path, &Expect { metric: Some(column.to_owned()), ..share.clone() });
    }

    /// Exactly one of the forms, with the keys that belong to it.
    fn subject(&mut self, path: &str, claim: &ClaimSpec) {
        let at = |key: &str| format!("{path}.{key}");
        let ClaimSpec { share, quantile, metric, difference, between, change, .. } = claim;
        if change.is_some() {
            for (key, given) in
                [("metric", metric.is_some()), ("difference", difference.is_some()), ("between", !between.is_empty())]
            {
                if given {
                    self.error(&at(key), "must not be given together with `change`");
                }
            }
            if share.is_some() && quantile.is_some() {
                self.error(&at("quantile"), "must not be given together with `share`");
            }
            return;
        }
        match (share, difference, metric) {
            (Some(_), None, None) => {
                if quantile.is_some() {
                    self.error(&at("quantile"), "must not be given together with `share`");
                }
            }
            (None, None, Some(_)) if quantile.is_none() => {
                self.error(path, "has `metric` and lacks the key `quantile`");
            }
            (None, Some(_), None) if between.is_empty() => {
                self.error(path, "has `difference` and lacks the key `between`");
            }
            (None, Some(_), None) => match between.values().next() {
                Some(values) if between.len() == 1 && values.len() == 2 => {}
                Some(values) if between.len() == 1 => {
                    self.error(&at("between"), format!("must have two values of its key, not {}", values.len()));
                }
                _ => self.error(&at("between"), format!("must have one key, not {}", between.len())),
            },
            (None, None, Some(_)) => {}
            (None, None, None) if quantile.is_some() => {
                self.error(path, "has `quantile` and lacks the key `metric` (or `difference` or `change`)");
            }
            (None, None, None) => {
                self.error(path, "lacks the key `share` (or `quantile` with `metric`, or `difference`, or `change`)")
            }
            _ => self.error(path, "must have one of `share`, `metric`, `difference` and `change`"),
        }
        if difference.is_none() && !between.is_empty() {
            self.error(&at("between"), "requires `difference`, which is missing");
        }
    }
}
