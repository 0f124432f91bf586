//! Checks rules between the values of `[search]`.

use super::Check;
use crate::scenario::decode::NodeDeserializer;
use crate::scenario::findings::Findings;
use crate::scenario::format::compare::CompareSpec;
use crate::scenario::format::expect::Expect;
use crate::scenario::format::search::SearchSpec;
use crate::text::toml_tree::Node;
use serde::Deserialize;

/// Greatest number of values that are run as a check.
const MAX_CHECKS: u32 = 10_000;

/// Greatest number of keys whose boundary, and whose best values are searched.
const MAX_KEYS: [usize; 2] = [2, 6];

/// Least and greatest number of squares along each side.
const SQUARES: [u32; 2] = [4, 1024];

/// Least number of runs chosen at once.
const MIN_POPULATION: u32 = 4;

/// Reports values that contradict each other; false if there is one.
pub fn check_search(search: &SearchSpec, root: &Node, findings: &mut Findings) -> bool {
    let before = findings.errors();
    // An error in `[compare]` is reported when it is read.
    let compare = root.get("compare").and_then(|node| CompareSpec::deserialize(NodeDeserializer(node)).ok());
    let mut check = Check { root, findings };
    check.search(search);
    for (path, condition) in [("search.boundary", &search.boundary), ("search.require", &search.require)] {
        if let Some(condition) = condition {
            check.expect(path, condition);
            check.error_metric(&format!("{path}.metric"), condition, compare.as_ref());
        }
    }
    for (path, metric) in [("search.minimize", &search.minimize), ("search.maximize", &search.maximize)] {
        let condition = Expect { metric: metric.clone(), ..Expect::default() };
        check.error_metric(path, &condition, compare.as_ref());
    }
    if compare.is_some_and(|compare| compare.reference.is_some()) {
        check.error("compare.reference", "must not be given together with `[search]`: its runs have no reference");
    }
    if root.get("claim").is_some() {
        check.error("claim", "must not be given together with `[search]`, which chooses its runs by their results");
    }
    check.findings.errors() == before
}

impl Check<'_> {
    fn search(&mut self, search: &SearchSpec) {
        let goals = ["boundary", "minimize", "maximize"];
        let given: Vec<&str> = goals.into_iter().filter(|key| self.has("search", key)).collect();
        let is_boundary = match given[..] {
            [goal] => goal == "boundary",
            [] => return self.error("search", "lacks the key `boundary`, `minimize` or `maximize`"),
            _ => return self.error("search", format!("must have one of `{}`", given.join("`, `"))),
        };
        let keys = search.over.len();
        let most = MAX_KEYS[usize::from(!is_boundary)];
        if keys == 0 {
            self.error("search", "lacks the key `over`, or has no key in it");
        } else if keys > most {
            self.error("search.over", format!("must have at most {most} keys with `{}`, not {keys}", given[0]));
        }
        self.uses(is_boundary, keys);
        let has_budget = !(is_boundary && keys == 1);
        match search.runs {
            None if has_budget && keys > 0 => self.error("search", "lacks the key `runs`, the greatest number of runs"),
            Some(0) => self.error("search.runs", "must be at least 1, not 0"),
            _ => {}
        }
        if search.check > MAX_CHECKS {
            self.error("search.check", format!("must be at most {MAX_CHECKS}, not {}", search.check));
        }
        let [least, greatest] = SQUARES;
        if let Some(n) = search.squares.filter(|n| !(n.is_power_of_two() && (least..=greatest).contains(n))) {
            self.error("search.squares", format!("must be a power of two from {least} to {greatest}, not {n}"));
        }
        if let Some(n) = search.population.filter(|n| *n < MIN_POPULATION) {
            self.error("search.population", format!("must be at least {MIN_POPULATION}, not {n}"));
        }
    }

    /// Reports keys that another kind of search uses.
    fn uses(&mut self, is_boundary: bool, keys: usize) {
        let one = ("a boundary over one key", is_boundary && keys <= 1);
        let two = ("a boundary over two keys", is_boundary && keys != 1);
        let best = ("`minimize` or `maximize`", !is_boundary);
        let budget = ("two keys, or `minimize` or `maximize`", !is_boundary || keys != 1);
        let uses = [
            ("check", one),
            ("follow", one),
            ("squares", two),
            ("runs", budget),
            ("require", best),
            ("population", best),
            ("seed", best),
        ];
        for (key, (use_, is_used)) in uses {
            if !is_used && self.has("search", key) {
                self.error(&format!("search.{key}"), format!("must not be given: it is for {use_}"));
            }
        }
    }
}
