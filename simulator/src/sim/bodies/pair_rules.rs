//! Rules of a scenario for pairs of bodies: their friction, and which do not touch.

use super::Friction;
use crate::text::pattern::matches;

/// A rule for the pairs of bodies whose names match both patterns, in either order.
#[derive(Clone, Debug, PartialEq)]
pub struct PairRule {
    /// Names, with `*` and `?`.
    pub bodies: [String; 2],
    /// Their friction; none: that of the bodies.
    pub friction: Option<Friction>,
    /// Whether they touch.
    pub touch: bool,
}

impl PairRule {
    fn applies(&self, a: &str, b: &str) -> bool {
        let [first, second] = &self.bodies;
        matches(first, a) && matches(second, b) || matches(first, b) && matches(second, a)
    }
}

/// All rules. Of several that apply to a pair the last one counts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PairRules(pub Vec<PairRule>);

impl PairRules {
    fn between(&self, a: &str, b: &str) -> Option<&PairRule> {
        self.0.iter().rev().find(|rule| rule.applies(a, b))
    }

    /// Whether two bodies touch.
    pub fn touches(&self, a: &str, b: &str) -> bool {
        self.between(a, b).is_none_or(|rule| rule.touch)
    }

    /// Friction that a rule gives two bodies.
    pub fn friction(&self, a: &str, b: &str) -> Option<Friction> {
        self.between(a, b)?.friction
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_rule_that_applies_counts() {
        let rule = |a: &str, b: &str, mu: Option<f64>| PairRule {
            bodies: [a.into(), b.into()],
            friction: mu.map(|mu| Friction { mu_s: mu, mu_k: mu, extra: Default::default() }),
            touch: mu.is_some(),
        };
        let rules = PairRules(vec![rule("*", "floor", Some(0.1)), rule("box", "*", Some(0.2)), rule("a", "b", None)]);
        let mu = |a: &str, b: &str| rules.friction(a, b).map(|f| f.mu_s);
        assert_eq!(
            [mu("left", "floor"), mu("floor", "box"), mu("a", "b"), mu("a", "c")],
            [Some(0.1), Some(0.2), None, None]
        );
        assert!(!rules.touches("b", "a") && rules.touches("a", "c") && rules.touches("floor", "box"));
    }
}
