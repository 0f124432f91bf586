//! Finds the interval of a lattice at whose ends a condition has different results.
//!
//! The lattice has the positions 0 to `last`. Each probe gives the result of the condition at one
//! position. While the results allow at most one change, the bracket is the interval between the
//! highest position with the lower side's result and the lowest with the other. An end that was not
//! probed counts as if the change could be beyond it, so that it is probed only if no change is found
//! before. Further positions, evenly spaced, are then probed to find other changes.
//!
//! The next positions follow from the results alone.

use std::collections::BTreeMap;

use super::prior::Prior;

/// Probes above those of plain bisection that a prior may cost, before plain bisection takes over.
const EXTRA: u32 = 4;

/// The results at some positions of a lattice.
#[derive(Clone, Debug)]
pub struct Bisection {
    last: u64,
    checks: u64,
    prior: Option<Prior>,
    results: BTreeMap<u64, bool>,
}

/// Number of halvings that reduce this number of intervals to one.
fn halvings(intervals: u64) -> u32 {
    intervals.max(1).next_power_of_two().trailing_zeros()
}

/// Greatest number of probes of a lattice of `last` steps with this number of checks.
pub fn most_probes(last: u64, checks: u64, has_prior: bool) -> u64 {
    let plain = 1 + halvings(last + 1);
    // The prior, then both ends and the other direction.
    let all = if has_prior { halvings(last + 2) + EXTRA + 2 + halvings(last) } else { plain };
    let checks = if checks == 0 { 0 } else { checks + 2 };
    u64::from(all).saturating_add(checks).min(last + 1)
}

impl Bisection {
    /// Begins without results on a lattice of `last` steps, at least 1. `checks` positions, evenly
    /// spaced, and both ends are probed after a change is found; none if it is 0.
    pub fn new(last: u64, checks: u64, prior: Option<Prior>) -> Self {
        Bisection { last: last.max(1), checks, prior, results: BTreeMap::new() }
    }

    /// Adds the result at a position.
    pub fn add(&mut self, at: u64, holds: bool) {
        self.results.insert(at, holds);
    }

    /// Number of results.
    pub fn probes(&self) -> usize {
        self.results.len()
    }

    /// The next positions to probe, in ascending order; none if the search is at its end. Their
    /// results must all be added before the next call.
    pub fn next_positions(&self) -> Vec<u64> {
        match self.next_of_bracket() {
            Some(at) => vec![at],
            None => self.unchecked(),
        }
    }

    /// Neighbouring positions of known result between which it changes, in ascending order. One of
    /// them is a single interval of the lattice once the search is at its end, unless there is none.
    pub fn changes(&self) -> Vec<(u64, u64)> {
        let known: Vec<(u64, bool)> = self.results.iter().map(|(at, holds)| (*at, *holds)).collect();
        known.windows(2).filter(|pair| pair[0].1 != pair[1].1).map(|pair| (pair[0].0, pair[1].0)).collect()
    }

    /// The narrowest interval between two positions with different results, the lowest of several.
    pub fn bracket(&self) -> Option<(u64, u64)> {
        self.changes().into_iter().min_by_key(|(low, high)| high - low)
    }

    /// The result at a position, if it is known.
    pub fn result(&self, at: u64) -> Option<bool> {
        self.results.get(&at).copied()
    }

    fn next_of_bracket(&self) -> Option<u64> {
        let last = self.last as i64;
        let (first_end, last_end) = (self.result(0), self.result(self.last));
        let expected = self.prior.map(|prior| prior.below);
        let lower_side = match (first_end, last_end, expected) {
            // The results are not as expected: the other end shows whether there is a change.
            (Some(found), None, Some(expected)) if found != expected => return Some(self.last),
            (None, Some(found), Some(expected)) if found == expected => return Some(0),
            (Some(found), ..) => found,
            (None, _, Some(expected)) => expected,
            (None, _, None) => return Some(0),
        };
        if let Some((low, high)) = self.bracket().filter(|_| first_end.is_some() && last_end.is_some()) {
            return (high - low > 1).then(|| low + (high - low) / 2);
        }
        if first_end.is_some() && last_end.is_some() {
            return None;
        }
        let of_side = |side: bool| move |(_, holds): &(&u64, &bool)| **holds == side;
        let low = self.results.iter().filter(of_side(lower_side)).map(|(at, _)| *at as i64).max().unwrap_or(-1);
        let high = self.results.iter().filter(of_side(!lower_side)).map(|(at, _)| *at as i64).min().unwrap_or(last + 1);
        if high - low <= 1 {
            return None;
        }
        let left = (halvings(self.last + 2) + EXTRA).saturating_sub(self.results.len() as u32);
        let at = match &self.prior {
            Some(prior) if (high - low) as f64 > Prior::scale(self.last) && halvings((high - low) as u64) < left => {
                prior.median(low, high, self.last)
            }
            _ => low + (high - low) / 2,
        };
        Some(at as u64)
    }

    /// Positions of the check that are not probed yet.
    fn unchecked(&self) -> Vec<u64> {
        if self.checks == 0 {
            return Vec::new();
        }
        let parts = u128::from(self.checks) + 1;
        let mut all: Vec<u64> = (0..=parts).map(|i| (i * u128::from(self.last) / parts) as u64).collect();
        all.dedup();
        all.retain(|at| !self.results.contains_key(at));
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Searches to the end; returns the results and the number of probes.
    fn search(last: u64, checks: u64, prior: Option<Prior>, holds: impl Fn(u64) -> bool) -> Bisection {
        let mut bisection = Bisection::new(last, checks, prior);
        loop {
            let next = bisection.next_positions();
            if next.is_empty() {
                return bisection;
            }
            for at in next {
                assert_eq!(bisection.result(at), None, "position {at} is probed twice");
                assert!(at <= last);
                bisection.add(at, holds(at));
            }
            assert!(bisection.probes() as u64 <= most_probes(last, checks, prior.is_some()));
        }
    }

    #[test]
    fn every_change_is_found_whatever_is_expected() {
        for last in [1, 2, 3, 7, 40, 97] {
            for change in 0..last {
                for above in [false, true] {
                    let holds = |at: u64| (at > change) == above;
                    let priors = (0..=last).flat_map(|at| [true, false].map(|below| Prior { at: at as f64, below }));
                    for prior in priors.map(Some).chain([None]) {
                        let found = search(last, 0, prior, holds);
                        assert_eq!(found.bracket(), Some((change, change + 1)), "{last} {change} {above} {prior:?}");
                        assert_eq!(found.changes().len(), 1);
                    }
                }
            }
        }
    }

    #[test]
    fn without_a_change_both_ends_are_probed() {
        for last in [1, 2, 40, 97] {
            for result in [false, true] {
                let priors = [true, false].map(|below| Some(Prior { at: 0.3 * last as f64, below }));
                for prior in priors.into_iter().chain([None]) {
                    let found = search(last, 0, prior, |_| result);
                    assert_eq!(found.bracket(), None);
                    assert_eq!((found.result(0), found.result(last)), (Some(result), Some(result)));
                }
            }
        }
    }

    #[test]
    fn plain_bisection_halves() {
        // One end, then 10 halvings of 1024 intervals, one of which is beyond the other end.
        for change in [0, 1, 511, 1000, 1022] {
            assert!(search(1023, 0, None, |at| at > change).probes() <= 11);
        }
        assert_eq!(most_probes(1023, 0, false), 11);
    }

    #[test]
    fn a_good_expectation_saves_probes_and_a_bad_one_costs_few() {
        let (last, change) = (600, 250);
        let probes = |at: f64| search(last, 0, Some(Prior { at, below: false }), |at| at > change).probes();
        let plain = search(last, 0, None, |at| at > change).probes();
        assert!(probes(250.5) + 3 <= plain, "{} and {plain}", probes(250.5));
        assert!(probes(600.0) <= plain + 3, "{} and {plain}", probes(600.0));
    }

    #[test]
    fn checks_find_other_changes() {
        let holds = |at: u64| at > 30 && !(50..70).contains(&at);
        let blind = search(100, 0, None, |at| at > 30 && !(60..70).contains(&at));
        assert_eq!(blind.changes(), [(30, 31)]);
        let found = search(100, 9, None, holds);
        assert!(found.changes().len() > 1, "{:?}", found.changes());
        let (low, high) = found.bracket().unwrap();
        assert_eq!(high - low, 1);
        assert_eq!(search(100, 9, None, |at| at > 30).changes(), [(30, 31)]);
        // Of several changes the one that is known to a step counts, not the lowest.
        let found = search(100, 9, None, |at| (25..35).contains(&at) || at > 60);
        assert_eq!((found.bracket(), found.changes().len()), (Some((60, 61)), 3), "{:?}", found.changes());
        // A change and its reverse between two equal ends.
        assert_eq!(search(100, 3, None, |at| (40..60).contains(&at)).changes().len(), 2);
    }
}
