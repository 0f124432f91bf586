//! Splits a plan into shards for several machines. A run's shard depends on the name of its scenario
//! and on its number in the sweep: filters, order and additional scenarios do not move it.
//!
//! Of N consecutive runs of a scenario each shard has one: the runs are dealt in turn, beginning
//! with a shard that a hash chooses for every N runs. Shards thus have equal numbers of runs, no
//! value of the sweep belongs to one shard, and a shard finds its runs without the others.

use std::collections::BTreeMap;
use std::num::NonZero;
use std::str::FromStr;

use crate::batch::Plan;
use crate::batch::plan::batch_plan::Ticket;
use crate::results::{PlanHash, ShardHead, ShardRun};

/// One of N equal parts of a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// From 1 to `of`.
    number: u64,
    of: NonZero<u64>,
}

/// Why a shard cannot be determined.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ShardError {
    /// Not `I/N`.
    #[error("expected I/N, such as 3/8, or `env`")]
    Form,
    /// There is no such part.
    #[error("there is no part {number} of {of}: parts are numbered from 1")]
    NoPart {
        /// The requested part.
        number: u64,
        /// The number of parts.
        of: u64,
    },
    /// A variable that is not a number.
    #[error("{name}={text} is not a whole number")]
    NotANumber {
        /// Its name.
        name: &'static str,
        /// Its value.
        text: String,
    },
    /// The number of parts is missing.
    #[error("{set} is set, but not {missing}, which gives the number of parts")]
    MissingCount {
        /// The variable that is set.
        set: &'static str,
        /// The variable that is not.
        missing: &'static str,
    },
    /// Variables of Slurm and of Kubernetes.
    #[error("both {} and {} are set", SLURM[0], KUBERNETES[0])]
    TwoArrays,
    /// Variables of neither.
    #[error("neither {} nor {} is set", SLURM[0], KUBERNETES[0])]
    NoArray,
    /// A task number that the array does not contain.
    #[error("{}={id} is not {first} plus a multiple of {step}", SLURM[0])]
    NotAStep {
        /// The task number.
        id: u64,
        /// First task number.
        first: u64,
        /// Distance of task numbers.
        step: u64,
    },
    /// A part beyond the number of parts.
    #[error("{name} gives part {number} of {of}")]
    Beyond {
        /// The variable.
        name: &'static str,
        /// The part, from 1.
        number: u64,
        /// The number of parts.
        of: u64,
    },
}

/// Slurm variables: task number, first number, step, number of tasks.
const SLURM: [&str; 4] =
    ["SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_MIN", "SLURM_ARRAY_TASK_STEP", "SLURM_ARRAY_TASK_COUNT"];

/// Index from 0 and number of parts. Kubernetes itself sets only the index.
const KUBERNETES: [&str; 2] = ["JOB_COMPLETION_INDEX", "JOB_COMPLETION_COUNT"];

impl Shard {
    /// Part `number` (from 1) of `of`; none if there is no such part.
    pub fn new(number: u64, of: u64) -> Option<Self> {
        Some(Shard { number: Some(number).filter(|n| (1..=of).contains(n))?, of: NonZero::new(of)? })
    }

    /// Reads this process's part from a Slurm job array or an indexed Kubernetes job.
    ///
    /// # Errors
    /// A variable is missing, is not a number, or contradicts another.
    pub fn from_environment(variable: impl Fn(&str) -> Option<String>) -> Result<Self, ShardError> {
        let number = |name: &'static str| match variable(name) {
            None => Ok(None),
            Some(text) => text.trim().parse::<u64>().map(Some).map_err(|_| ShardError::NotANumber { name, text }),
        };
        let count = |missing: &'static str, set: &'static str| {
            number(missing)?.ok_or(ShardError::MissingCount { set, missing })
        };
        let (index, of, name) = match (number(SLURM[0])?, number(KUBERNETES[0])?) {
            (Some(_), Some(_)) => return Err(ShardError::TwoArrays),
            (Some(id), None) => {
                // An array need not begin at 0 nor be without gaps: `--array=10-50:10` has 5 tasks.
                let (first, step) = (number(SLURM[1])?.unwrap_or(0), number(SLURM[2])?.unwrap_or(1).max(1));
                if id < first || !(id - first).is_multiple_of(step) {
                    return Err(ShardError::NotAStep { id, first, step });
                }
                ((id - first) / step, count(SLURM[3], SLURM[0])?, SLURM[0])
            }
            (None, Some(index)) => (index, count(KUBERNETES[1], KUBERNETES[0])?, KUBERNETES[0]),
            (None, None) => return Err(ShardError::NoArray),
        };
        let number = index.saturating_add(1);
        Shard::new(number, of).ok_or(ShardError::Beyond { name, number, of })
    }

    /// True for the whole batch.
    pub fn is_whole(&self) -> bool {
        self.of.get() == 1
    }

    /// True if it contains the run with this number, from 0, of a scenario.
    pub fn contains(&self, scenario: &str, number: usize) -> bool {
        let of = self.of.get();
        self.in_round(scenario, number as u64 / of) == number as u64 % of
    }

    /// Numbers of its runs of a scenario with `runs` runs, ascending.
    pub fn numbers(self, scenario: &str, runs: usize) -> impl Iterator<Item = usize> + use<> {
        let (of, runs, scenario) = (self.of.get(), runs as u64, scenario.to_owned());
        let numbers = (0..runs.div_ceil(of)).map(move |round| round * of + self.in_round(&scenario, round));
        numbers.filter(move |number| *number < runs).map(|number| number as usize)
    }

    /// Position of its run among the `of` runs of a round.
    fn in_round(&self, scenario: &str, round: u64) -> u64 {
        let of = self.of.get();
        let mut hasher = blake3::Hasher::new();
        hasher.update(&round.to_le_bytes()).update(scenario.as_bytes());
        let mut first = [0; 8];
        first.copy_from_slice(&hasher.finalize().as_bytes()[..8]);
        // The shard of the first run of the round.
        let begin = u64::from_le_bytes(first) % of;
        let own = self.number - 1;
        if own >= begin { own - begin } else { of - begin + own }
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Shard {
    type Err = ShardError;

    /// Parses `I/N`, or `env` for the environment of a job array.
    fn from_str(text: &str) -> Result<Self, ShardError> {
        if text == "env" {
            return Self::from_environment(|name| std::env::var(name).ok());
        }
        let parts = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        let (number, of) = parts.ok_or(ShardError::Form)?;
        Shard::new(number, of).ok_or(ShardError::NoPart { number, of })
    }
}

/// The shard that a plan is.
#[derive(Clone, Debug)]
pub struct Part {
    pub(in crate::batch) head: ShardHead,
}

impl Part {
    /// Number of runs of all shards.
    pub fn total(&self) -> usize {
        self.head.runs
    }
}

impl Plan {
    /// Hashes the names, sizes and values of its scenarios, and its filter; equal for all shards on
    /// any machine.
    pub fn hash(&self) -> String {
        let mut hash = PlanHash::default();
        for source in &self.sources {
            hash.add(source.name.as_bytes());
            hash.add(&(source.expansion.runs() as u64).to_le_bytes());
            hash.add(source.expansion.definition());
        }
        if let Some(filter) = &self.filter {
            hash.add(filter.as_bytes());
        }
        hash.end()
    }

    /// Hashes of the files that its runs use, by their names in the scenarios.
    pub fn used_files(&self) -> &BTreeMap<String, String> {
        &self.used
    }

    /// Keeps the runs of a shard, in order, and the references they need.
    pub fn take_shard(&mut self, shard: Shard) {
        let all = self.runs();
        let is_own = |index: &usize| {
            let Ticket { source, number, .. } = self.runs[*index];
            let unit = self.sources[source as usize].expansion.unit(number as usize);
            shard.contains(self.scenario(*index), unit)
        };
        let positions: Vec<usize> = (0..all).filter(is_own).collect();
        self.keep(&positions);
        self.set_part(shard, all);
    }

    /// States that its runs are those of a shard, of `all` runs.
    pub(super) fn set_part(&mut self, shard: Shard, all: usize) {
        let head = ShardHead::new(shard.number, shard.of.get(), all, self.hash(), self.used.clone());
        let head = ShardHead { claims: self.claims.heads.clone(), ..head };
        self.part = Some(Part { head });
    }

    /// Entries of the shard's run list, without runs that its searches have not chosen.
    pub(in crate::batch) fn shard_runs(&self) -> impl Iterator<Item = ShardRun> {
        (0..self.runs()).filter(|i| self.is_known(*i)).map(|i| ShardRun {
            at: self.position_in_whole(i),
            scenario: self.scenario(i).to_owned(),
            key: self.key(i),
            levels: self.levels(i),
            claims: self.claims_of(i).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn environment(pairs: &[(&str, &str)]) -> Result<String, String> {
        let value = |name: &str| pairs.iter().find(|(n, _)| *n == name).map(|(_, v)| (*v).to_owned());
        Shard::from_environment(value).map(|shard| shard.to_string()).map_err(|error| error.to_string())
    }

    #[test]
    fn parts_parse_to_themselves() {
        for text in ["1/1", "3/8", "8/8", "1000000/1000000"] {
            assert_eq!(text.parse::<Shard>().unwrap().to_string(), text);
        }
        for wrong in ["0/8", "9/8", "3", "3/", "/8", "a/b", "-1/3", "1/0", "", "3 / 8"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn every_run_is_in_one_part_and_parts_are_equal() {
        for (runs, of) in [(8000, 8), (10_003, 100), (5, 8), (1, 1), (0, 3), (50, 7)] {
            let parts: Vec<Shard> = (1..=of).map(|i| Shard::new(i, of).unwrap()).collect();
            let mut seen = vec![0; runs];
            for part in &parts {
                let numbers: Vec<usize> = part.numbers("s", runs).collect();
                let contained: Vec<usize> = (0..runs).filter(|number| part.contains("s", *number)).collect();
                assert_eq!(numbers, contained, "{part}");
                assert!(numbers.len().abs_diff(runs / of as usize) <= 1, "{part}: {}", numbers.len());
                numbers.iter().for_each(|number| seen[*number] += 1);
            }
            assert!(seen.iter().all(|parts| *parts == 1));
        }
    }

    #[test]
    fn no_value_of_a_sweep_belongs_to_one_part() {
        // Two methods alternate, and eight parts: each part has about as many of both.
        for part in (1..=8).map(|i| Shard::new(i, 8).unwrap()) {
            let even = part.numbers("s", 8000).filter(|number| number % 2 == 0).count();
            // Binomial: mean 500, standard deviation 16; the hashes are fixed.
            assert!((420..580).contains(&even), "{part}: {even}");
        }
    }

    #[test]
    fn job_array_variables_give_the_part() {
        let slurm = |id: &'static str, min, step, count| {
            let names = SLURM.into_iter().zip([id, min, step, count]);
            environment(&names.filter(|(_, value)| !value.is_empty()).collect::<Vec<_>>())
        };
        assert_eq!(slurm("0", "0", "1", "4").unwrap(), "1/4");
        assert_eq!(slurm("4", "1", "1", "4").unwrap(), "4/4");
        assert_eq!(slurm("30", "10", "10", "5").unwrap(), "3/5");
        assert_eq!(slurm("3", "", "", "4").unwrap(), "4/4");
        assert!(slurm("4", "0", "1", "4").unwrap_err().contains("part 5 of 4"), "an array with gaps");
        assert!(slurm("15", "10", "10", "5").is_err());
        assert!(slurm("1", "", "", "").unwrap_err().contains("SLURM_ARRAY_TASK_COUNT"));
        assert!(slurm("x", "", "", "4").unwrap_err().contains("SLURM_ARRAY_TASK_ID=x"));
        let kubernetes = [("JOB_COMPLETION_INDEX", "2"), ("JOB_COMPLETION_COUNT", "3")];
        assert_eq!(environment(&kubernetes).unwrap(), "3/3");
        assert!(environment(&kubernetes[..1]).unwrap_err().contains("JOB_COMPLETION_COUNT"));
        assert!(environment(&[]).unwrap_err().contains("neither"));
        assert!(environment(&[kubernetes[0], ("SLURM_ARRAY_TASK_ID", "1")]).unwrap_err().contains("both"));
    }
}
