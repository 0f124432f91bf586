//! Decodes the claims of a file and checks them against its sweep.

use serde::Deserialize;

use super::units::{PlannedClaim, SweptKey};
use crate::scenario::checks::check_claims;
use crate::scenario::decode::NodeDeserializer;
use crate::scenario::findings::Findings;
use crate::scenario::format::claim::{ClaimSpec, value_text};
use crate::scenario::format::random::Sampling;
use crate::scenario::key_path::KeyPath;
use crate::scenario::sweep::{Dimension, Grid};
use crate::statistics::{Rule, ShareTest};
use crate::text::suggest;
use crate::text::toml_tree::{Node, Value};

/// Greatest number of groups of a claim; each has a verdict of its own.
const MAX_GROUPS: usize = 10_000;

/// Reads the claims of a scenario's tree; `fixed` are the overridden paths. Claims with an error, and on
/// differences between values that an override replaces, are left out.
pub fn read(root: &Node, grid: &Grid, fixed: &[KeyPath], findings: &mut Findings) -> Vec<PlannedClaim> {
    let Some(node) = root.get("claim") else { return Vec::new() };
    if !matches!(node.value, Value::Array(_)) {
        let message = format!("`claim` must be an array of tables, not {}", node.value);
        findings.error(node.span.clone(), message, Some("write `[[claim]]`".into()));
        return Vec::new();
    }
    let mut specs = Vec::new();
    for (i, item) in node.items().iter().enumerate() {
        match ClaimSpec::deserialize(NodeDeserializer(item)) {
            Ok(spec) => specs.push(spec),
            Err(error) => error.at(&item.span).report(&format!("claim.{i}"), findings),
        }
    }
    // Rules between values are checked only when each value is valid.
    if findings.has_errors() || !check_claims(&specs, root, findings) {
        return Vec::new();
    }
    let mut planned = Vec::new();
    for (i, spec) in specs.into_iter().enumerate() {
        let mut reader = ClaimReader { root, grid, fixed, path: format!("claim.{i}"), findings };
        planned.extend(reader.plan(spec));
    }
    planned
}

/// Checks one claim.
struct ClaimReader<'a, 'f> {
    root: &'a Node,
    grid: &'a Grid,
    fixed: &'a [KeyPath],
    /// Path of the claim.
    path: String,
    findings: &'f mut Findings,
}

impl<'a> ClaimReader<'a, '_> {
    fn plan(&mut self, spec: ClaimSpec) -> Option<PlannedClaim> {
        let per: Option<Vec<SweptKey>> =
            spec.per.iter().enumerate().map(|(i, name)| self.swept(name, &format!("per.{i}"))).collect();
        let pair = match spec.between.first_key_value() {
            Some((name, values)) => Some(self.pair(name, values)?),
            None => None,
        };
        let per = per?;
        let groups = per.iter().map(|swept| swept.dimension.length).fold(1, usize::saturating_mul);
        if groups > MAX_GROUPS {
            self.error("per", format!("has {groups} combinations of values, at most {MAX_GROUPS} are judged alone"));
            return None;
        }
        if let Some((swept, _)) = &pair
            && let Some(i) = per.iter().position(|own| own.stride == swept.stride)
        {
            self.error(&format!("per.{i}"), format!("must not change together with `{}` of `between`", swept.key.name));
            return None;
        }
        let own: Vec<usize> = per.iter().chain(pair.iter().map(|(swept, _)| swept)).map(|s| s.stride).collect();
        self.warn_of_dependence(&own);
        let claim = PlannedClaim::new(spec, &per, pair, self.root);
        self.warn_of_few_runs(&claim);
        if claim.spec.change.is_some() {
            let message = format!("`{}` needs a baseline: this command does not judge it", self.path);
            let span = KeyPath::internal(&format!("{}.change", self.path)).locate(self.root).1;
            self.findings.note(span, message, Some("`runner compare --baseline BASE RESULTS` does".to_owned()));
        }
        Some(claim)
    }

    /// A swept key that the claim names at `at`.
    fn swept(&mut self, name: &str, at: &str) -> Option<SweptKey<'a>> {
        let found = SweptKey::find(self.grid, name);
        if found.is_none() {
            let strided = self.grid.strided();
            let names = strided.iter().flat_map(|(_, dimension)| &dimension.keys).map(|key| key.name.as_str());
            let help = match names.clone().next() {
                Some(_) => suggest::help(name, names),
                None => "the file has no `[sweep]` with keys".to_owned(),
            };
            let span = KeyPath::internal(&format!("{}.{at}", self.path)).locate(self.root).1;
            let message = format!("`{}.{at}` names `{name}`, which is not swept", self.path);
            self.findings.error(span, message, Some(help));
        }
        found
    }

    fn pair(&mut self, name: &str, values: &[toml::Value]) -> Option<(SweptKey<'a>, [usize; 2])> {
        let swept = self.swept(name, "between")?;
        if self.fixed.iter().any(|path| path.equals(&swept.key.path)) {
            let path = format!("{}.between", self.path);
            let span = KeyPath::internal(&path).locate(self.root).1;
            let message = format!("`{}` is not judged: an override replaces the values of `{name}`", self.path);
            self.findings.warning(span, message, None);
            return None;
        }
        let mut sides = [0; 2];
        for (side, value) in sides.iter_mut().zip(values) {
            let text = value_text(value);
            *side = match swept.indices(value, self.root)[..] {
                [index] => index,
                [] => {
                    let all = (0..swept.dimension.length).filter_map(|at| swept.value(at, self.root));
                    let all: Vec<String> = all.take(10).map(|value| value_text(&value)).collect();
                    let message = format!("has the value {text}, which `{name}` does not take: {}", all.join(", "));
                    self.error("between", message);
                    return None;
                }
                [..] => {
                    let message = format!("is not one value: several combinations of the sweep have `{name}` = {text}");
                    self.error("between", message);
                    return None;
                }
            };
        }
        if sides[0] == sides[1] {
            self.error("between", "has the same value twice");
            return None;
        }
        Some((swept, sides))
    }

    /// Warns of runs that are not independent samples: values that share their random samples, which
    /// `own` dimensions keep apart, and samples that are spread evenly.
    fn warn_of_dependence(&mut self, own: &[usize]) {
        let strided = self.grid.strided();
        let is_random =
            |dimension: &Dimension| dimension.sampling.is_some() || dimension.keys.iter().any(|key| key.name == "seed");
        let is_sampled = self.grid.repeat > 1 || strided.iter().any(|(_, dimension)| is_random(dimension));
        let others = || strided.iter().filter(|(stride, _)| !own.contains(stride)).map(|(_, dimension)| dimension);
        let fixed = others().find(|dimension| dimension.length > 1 && !is_random(dimension));
        let spread = others().find(|dimension| dimension.sampling.is_some_and(|how| how != Sampling::Random));
        let path = &self.path;
        let (message, help) = match (fixed.and_then(|dimension| dimension.keys.first()), spread) {
            (Some(key), _) if is_sampled => (
                format!(
                    "`{path}` counts runs that are not independent: each value of `{}` has the same samples",
                    key.name
                ),
                format!("per = [\"{}\"] judges each value alone", key.name),
            ),
            (Some(key), _) => (
                format!("`{path}` takes the values of `{}`, which are not random, for samples", key.name),
                "`sweep.random` or `sweep.repeat` draws samples".to_owned(),
            ),
            (None, Some(_)) => (
                format!("`{path}` takes samples that are spread evenly for independent ones"),
                "`sampling = \"random\"` draws them independently".to_owned(),
            ),
            (None, None) => return,
        };
        let span = KeyPath::internal(path).locate(self.root).1;
        self.findings.warning(span, message, Some(help));
    }

    /// Warns of a claim that cannot hold whatever its runs give.
    fn warn_of_few_runs(&mut self, claim: &PlannedClaim) {
        let mut units = vec![0_usize; claim.groups.len()];
        for number in 0..self.grid.runs() {
            if let Some(place) = claim.any_place(number).filter(|place| place.side == 0) {
                units[place.group] += 1;
            }
        }
        let most = units.into_iter().max().unwrap_or(0);
        let question = claim.spec.question();
        let fewest = |rule: Rule| {
            let test = ShareTest { rule, alpha: 1.0 - claim.spec.confidence };
            match question.at_least {
                true => test.fewest_to_show_at_least(question.threshold),
                false => test.fewest_to_show_at_most(question.threshold),
            }
        };
        let needed = fewest(if claim.spec.early { Rule::Sequential } else { Rule::Fixed });
        if needed <= most {
            return;
        }
        let unit = if claim.is_paired() || claim.spec.change.is_some() { "pairs of runs" } else { "runs" };
        let each = if claim.groups.len() > 1 { " each" } else { "" };
        let message = format!("`{}` cannot hold with {most} {unit}{each}: it needs at least {needed}", self.path);
        let help = match fewest(Rule::Fixed) {
            fixed if claim.spec.early => format!("without `early` it needs at least {fixed}"),
            _ => "more samples, less confidence or another limit".to_owned(),
        };
        let limit = if claim.spec.at_least.is_some() { "at_least" } else { "at_most" };
        let span = KeyPath::internal(&format!("{}.{limit}", self.path)).locate(self.root).1;
        self.findings.warning(span, message, Some(help));
    }

    /// Reports that the value at a key of the claim violates a rule.
    fn error(&mut self, key: &str, must: impl AsRef<str>) {
        let path = format!("{}.{key}", self.path);
        let span = KeyPath::internal(&path).locate(self.root).1;
        self.findings.error(span, format!("`{path}` {}", must.as_ref()), None);
    }
}
