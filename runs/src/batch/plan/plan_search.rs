//! The searches of a plan: which runs belong to them, and the keys of runs whose value has been chosen.

use std::path::Path;

use crate::batch::Finding;
use crate::batch::plan::batch_plan::{Plan, Source, Ticket, cell_label};
use crate::batch::plan::planner::DEFAULT_TIME_LIMIT;
use crate::batch::plan::run_check::{RunCheck, RunFinding};
use crate::scenario::{PlannedSearch, SearchAxis, Severity};

/// The run of a search at a position of the plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::batch) struct ProbePlace {
    pub source: usize,
    pub cell: usize,
    /// Its number among the runs of the cell.
    pub slot: usize,
}

impl Plan {
    /// Searches with the sources to which they belong.
    pub(in crate::batch) fn searches(&self) -> impl Iterator<Item = (usize, &Source, &PlannedSearch)> {
        let sources = self.sources.iter().enumerate();
        sources.filter_map(|(at, source)| Some((at, source.as_ref(), source.expansion.search()?)))
    }

    /// True if a scenario has a search.
    pub fn has_search(&self) -> bool {
        self.searches().next().is_some()
    }

    /// Greatest number of runs of a scenario file's search for each combination of values, if it has one.
    pub fn most_probes_of(&self, file: &Path) -> Option<usize> {
        let mut searches = self.searches();
        let (.., search) = searches.find(|(_, source, _)| source.expansion.file().path == *file)?;
        Some(search.slots_per_cell())
    }

    /// The keys that are searched by the run at a position; none without a search.
    pub fn searched_keys(&self, index: usize) -> Vec<&str> {
        let search = self.sources[self.runs[index].source as usize].expansion.search();
        search.iter().flat_map(|search| &search.axes).map(|axis| axis.name.as_str()).collect()
    }

    /// Describes the search to which the run at a position belongs: its swept values and its limits,
    /// such as `friction=0.5: at most 12 runs of force.0.force.0 from 0 to 60`.
    pub fn search_of(&self, index: usize) -> Option<String> {
        let search = self.sources[self.runs[index].source as usize].expansion.search()?;
        let label = cell_label(&self.job(index).run, &self.searched_keys(index), self.is_repeated(index));
        let above = if label.is_empty() { String::new() } else { format!("{label}: ") };
        let range = |axis: &SearchAxis| format!("{} from {} to {}", axis.name, axis.between[0], axis.between[1]);
        let ranges: Vec<String> = search.axes.iter().map(range).collect();
        Some(format!("{above}at most {} runs of {}", search.slots_per_cell(), ranges.join(", ")))
    }

    /// The search at a position of the plan; none if its run is planned without one.
    pub(in crate::batch) fn probe_place(&self, index: usize) -> Option<ProbePlace> {
        let Ticket { source, number, .. } = self.runs[index];
        let slots = self.sources[source as usize].expansion.search()?.slots_per_cell();
        let number = number as usize;
        Some(ProbePlace { source: source as usize, cell: number / slots, slot: number % slots })
    }

    /// True unless the run belongs to a search that has not chosen its value.
    pub(in crate::batch) fn is_known(&self, index: usize) -> bool {
        let Ticket { source, number, .. } = self.runs[index];
        let keys = &self.sources[source as usize].probe_keys;
        keys.get(number as usize).is_none_or(|key| key.get().is_some())
    }

    /// True unless the run is of a search and not the first of its cell.
    pub fn is_first(&self, index: usize) -> bool {
        self.probe_place(index).is_none_or(|place| place.slot == 0)
    }

    /// Sets the position of a run of a search on its lattice, and computes its key.
    ///
    /// # Errors
    /// The scenario is not valid with this value.
    pub(in crate::batch) fn assign(&self, index: usize, at: &[u64]) -> Result<(), String> {
        let Ticket { source, number, .. } = self.runs[index];
        let source = &self.sources[source as usize];
        let Some(search) = source.expansion.search() else { return Ok(()) };
        search.assign(number as usize, at);
        let check = RunCheck { expansion: &source.expansion, robots: &self.robots, time_limit: DEFAULT_TIME_LIMIT };
        let checked = check.check(&[number]);
        let Some(run) = checked.runs.first() else {
            let found = checked.found.into_iter().find_map(|found| match found {
                RunFinding::Finding(Finding::Scenario(error)) if error.severity == Severity::Error => {
                    Some(error.message)
                }
                _ => None,
            });
            let reason = found.map_or_else(String::new, |message| format!(": {message}"));
            return Err(format!("the scenario is not valid with {}{reason}", values_text(search, at)));
        };
        if let Some(key) = source.probe_keys.get(number as usize) {
            let _ = key.set(run.key);
        }
        Ok(())
    }
}

/// Such as `a = 3, b = 0.5`.
pub(in crate::batch) fn values_text(search: &PlannedSearch, at: &[u64]) -> String {
    let values = search.axes.iter().zip(search.values(at));
    values.map(|(axis, value)| format!("{} = {value}", axis.name)).collect::<Vec<_>>().join(", ")
}
