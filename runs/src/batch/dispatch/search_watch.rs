//! Chooses the runs of searches by the results of earlier ones.
//!
//! Each cell has a search of its own. Its next values depend on its results alone, and its first one
//! also on the boundaries of the cells that it follows, so that all runs are the same for any number of
//! threads and after any interruption.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::batch::Plan;
use crate::batch::plan::batch_plan::cell_label;
use crate::batch::plan::plan_search::{ProbePlace, values_text};
use crate::results::searches::{Best, Interval, LinePoint, Probe, SearchKind, SearchResult, SearchVerdict};
use crate::results::{SummaryRow, metric};
use crate::scenario::{Expect, PlannedSearch};
use crate::search::{Answer, Crossing, Method, Position, Prior};
use crate::sim::Outcome;

/// The searches of a batch.
#[derive(Debug, Default)]
pub(in crate::batch) struct SearchWatch {
    cells: Mutex<Cells>,
}

/// Cells by source and number.
type Cells = BTreeMap<(usize, usize), Cell>;

/// The search for one combination of values.
#[derive(Debug)]
struct Cell {
    /// Position of its first run in the plan.
    first: usize,
    /// None until the cells before it are at their ends.
    method: Option<Method>,
    /// Its runs: their position on the lattice, and what they gave.
    runs: Vec<(Position, Option<Probe>)>,
    state: State,
}

#[derive(Debug, PartialEq)]
enum State {
    Open,
    Ended,
    /// The next runs are more than are allowed.
    Spent,
    /// A run says nothing about the condition; the first of such runs, and the reason.
    Failed(usize, String),
}

impl Cell {
    fn is_waiting(&self) -> bool {
        self.runs.iter().any(|(_, probe)| probe.is_none())
    }

    /// Records that a run says nothing about the condition. Of several, the first one counts,
    /// whichever ends first.
    fn fail(&mut self, slot: usize, reason: String) {
        if !matches!(self.state, State::Failed(first, _) if first < slot) {
            self.state = State::Failed(slot, reason);
        }
    }

    /// The change that it found, as the middle of its interval, and whether the condition holds below.
    fn change(&self) -> Option<Prior> {
        let Some(Method::Bisection(bisection)) = self.method.as_ref().filter(|_| self.state == State::Ended) else {
            return None;
        };
        let (low, high) = bisection.bracket()?;
        Some(Prior { at: 0.5 * (low + high) as f64, below: bisection.result(low)? })
    }
}

impl SearchWatch {
    /// Begins the searches of a plan. Returns the positions of their first runs in it.
    pub fn begin(plan: &Plan) -> (Self, Vec<usize>) {
        let mut cells = Cells::new();
        for index in 0..plan.runs() {
            if let Some(ProbePlace { source, cell, slot: 0 }) = plan.probe_place(index) {
                let own = Cell { first: index, method: None, runs: Vec::new(), state: State::Open };
                cells.insert((source, cell), own);
            }
        }
        let places: Vec<(usize, usize)> = cells.keys().copied().collect();
        let first = places.into_iter().flat_map(|place| advance(&mut cells, plan, place)).collect();
        (SearchWatch { cells: Mutex::new(cells) }, first)
    }

    /// Adds the result of a run. Returns the positions of the runs that are chosen by it.
    pub fn finished(&self, plan: &Plan, index: usize, row: &SummaryRow) -> Vec<usize> {
        let Some(ProbePlace { source, cell: number, slot }) = plan.probe_place(index) else { return Vec::new() };
        let mut cells = self.lock();
        let Some(search) = plan.sources[source].expansion.search() else { return Vec::new() };
        let Some(cell) = cells.get_mut(&(source, number)) else { return Vec::new() };
        let Some((at, probe)) = cell.runs.get_mut(slot) else { return Vec::new() };
        // A cancelled run is as if it had not started.
        if row.outcome == Outcome::Cancelled {
            return Vec::new();
        }
        let answer = answer(search, row);
        let (holds, value) = match answer {
            Ok(Answer::Holds(holds)) => (Some(holds), None),
            Ok(Answer::Value(value)) => (None, Some(value).filter(|value| value.is_finite())),
            Err(_) => (None, None),
        };
        // A greater value is better where the greatest is searched.
        let value = value.map(|value| if is_maximum(search) { -value } else { value });
        let (run, outcome) = (row.key.clone(), row.outcome.name().to_owned());
        *probe = Some(Probe { at: search.values(at), run, outcome, holds, value });
        match (answer, &mut cell.method) {
            (Ok(answer), Some(method)) => method.add(at, answer),
            (Ok(_), None) => {}
            (Err(reason), _) => {
                let reason = format!("with {} the run {reason}", values_text(search, at));
                cell.fail(slot, reason);
            }
        }
        advance(&mut cells, plan, (source, number))
    }

    /// The results so far, in the order of the plan.
    pub fn results(&self, plan: &Plan) -> Vec<SearchResult> {
        let cells = self.lock();
        let in_order: BTreeMap<usize, (&(usize, usize), &Cell)> =
            cells.iter().map(|(place, cell)| (cell.first, (place, cell))).collect();
        let of = |((source, number), cell): (&(usize, usize), &Cell)| {
            let search = plan.sources[*source].expansion.search()?;
            Some(result(plan, *number, cell, search))
        };
        in_order.into_values().filter_map(of).collect()
    }

    /// Number of planned runs that no search needed.
    pub fn unused(&self, plan: &Plan) -> usize {
        let cells = self.lock();
        let of = |((source, _), cell): (&(usize, usize), &Cell)| {
            let slots = plan.sources[*source].expansion.search().map_or(0, PlannedSearch::slots_per_cell);
            slots.saturating_sub(cell.runs.len())
        };
        cells.iter().map(of).sum()
    }

    /// Locks the cells; a panic of another thread never leaves them inconsistent.
    fn lock(&self) -> MutexGuard<'_, Cells> {
        self.cells.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Chooses the next runs of a cell, and of those that follow it once it is at its end.
fn advance(cells: &mut Cells, plan: &Plan, place: (usize, usize)) -> Vec<usize> {
    let (mut due, mut chosen) = (vec![place], Vec::new());
    while let Some((source, number)) = due.pop() {
        let Some(search) = plan.sources[source].expansion.search() else { continue };
        let followed = search.followed(number);
        let is_ready = |cells: &Cells| {
            let mut before = followed.iter().filter_map(|f| cells.get(&(source, f.before)));
            before.all(|cell| cell.state != State::Open)
        };
        if !is_ready(cells) {
            continue;
        }
        let prior = prior(cells, source, search, number);
        let Some(cell) = cells.get_mut(&(source, number)) else { continue };
        if cell.is_waiting() {
            continue;
        }
        if cell.state == State::Open {
            let method = cell.method.get_or_insert_with(|| search.begin(prior));
            let next = method.next_positions();
            let is_minimum = !matches!(method, Method::Evolution(evolution) if !evolution.is_minimum());
            if next.is_empty() {
                cell.state = if is_minimum { State::Ended } else { State::Spent };
            } else if cell.runs.len() + next.len() > search.slots_per_cell() {
                cell.state = State::Spent;
            } else {
                for at in next {
                    let slot = cell.runs.len();
                    if let Err(reason) = plan.assign(cell.first + slot, &at) {
                        cell.fail(slot, reason);
                        break;
                    }
                    cell.runs.push((at, None));
                    chosen.push(cell.first + slot);
                }
            }
        }
        if cell.state != State::Open && search.follows() {
            // Cells that follow have greater numbers.
            let later = cells.range((source, number + 1)..(source + 1, 0)).map(|(place, _)| *place);
            due.extend(later.filter(|(_, other)| search.followed(*other).iter().any(|f| f.before == number)));
        }
    }
    chosen.sort_unstable();
    chosen
}

/// Where a cell expects its boundary: that of the cell before, with the change that the cells across
/// show for this step.
fn prior(cells: &Cells, source: usize, search: &PlannedSearch, number: usize) -> Option<Prior> {
    let change = |cell: usize| cells.get(&(source, cell)).and_then(Cell::change);
    let followed = search.followed(number);
    let of = |wants_across: bool| {
        followed.iter().find_map(|followed| {
            let before = change(followed.before)?;
            let Some((other, both)) = followed.across.filter(|_| wants_across) else {
                return (!wants_across).then_some(before);
            };
            let (other, both) = (change(other)?, change(both)?);
            let is_alike = other.below == before.below && both.below == before.below;
            is_alike.then_some(Prior { at: before.at + other.at - both.at, ..before })
        })
    };
    let prior = of(true).or_else(|| of(false))?;
    Some(Prior { at: prior.at.clamp(0.0, search.axes[0].steps() as f64), ..prior })
}

/// What a run gives for its search: whether the condition holds, or the value to minimise, infinite for
/// a run that must not be chosen.
///
/// # Errors
/// The run ended in a way that says nothing about the condition; how.
fn answer(search: &PlannedSearch, row: &SummaryRow) -> Result<Answer, String> {
    let Some((name, is_greatest)) = search.spec.objective() else {
        let condition = search.spec.boundary.as_ref();
        return condition.map_or(Ok(false), |condition| holds(condition, row)).map(Answer::Holds);
    };
    let meets = search.spec.require.as_ref().is_none_or(|condition| holds(condition, row) == Ok(true));
    let value = metric(row, name).filter(|value| meets && is_usable(row) && value.is_finite());
    Ok(Answer::Value(value.map_or(f64::INFINITY, |value| if is_greatest { -value } else { value })))
}

fn is_maximum(search: &PlannedSearch) -> bool {
    search.spec.objective().is_some_and(|(_, is_greatest)| is_greatest)
}

/// True if the run ended normally, or with a failed expectation.
fn is_usable(row: &SummaryRow) -> bool {
    matches!(row.outcome, Outcome::Passed | Outcome::Fallen | Outcome::Failed)
}

/// Whether a condition holds for a run.
///
/// # Errors
/// The run ended in a way that says nothing about it; how.
fn holds(condition: &Expect, row: &SummaryRow) -> Result<bool, String> {
    let named = condition.outcome.map(|outcome| outcome.name());
    let is_named = named == Some(row.outcome.name());
    match row.outcome {
        _ if is_named => Ok(true),
        Outcome::Passed | Outcome::Fallen => Ok(condition.judge(row.outcome.name(), |name| metric(row, name)).is_ok()),
        // A failed expectation replaces the outcome.
        Outcome::Failed if named.is_none_or(|name| name == Outcome::Passed.name()) => {
            Ok(condition.judge(row.outcome.name(), |name| metric(row, name)).is_ok())
        }
        outcome => {
            let message = if row.message.is_empty() { String::new() } else { format!(": {}", row.message) };
            Err(format!("ended as {}{message}", outcome.name()))
        }
    }
}

fn result(plan: &Plan, number: usize, cell: &Cell, search: &PlannedSearch) -> SearchResult {
    let (job, keys) = (plan.job(cell.first), plan.searched_keys(cell.first));
    let probes: Vec<Probe> = cell.runs.iter().filter_map(|(_, probe)| probe.clone()).collect();
    let found = cell.method.as_ref().map(|method| Found::of(method, search, &probes)).unwrap_or_default();
    let (verdict, message) = match &cell.state {
        State::Failed(_, reason) => (SearchVerdict::Error, reason.clone()),
        State::Open => (SearchVerdict::Unfinished, "the batch ended before this search".to_owned()),
        State::Spent if found.best.is_none() && search.spec.objective().is_some() => {
            (SearchVerdict::NoValue, String::new())
        }
        State::Spent => (SearchVerdict::Unconverged, String::new()),
        State::Ended => (found.verdict(), String::new()),
    };
    let kind = match search.spec.objective() {
        None => SearchKind::Boundary,
        Some((_, false)) => SearchKind::Minimum,
        Some((_, true)) => SearchKind::Maximum,
    };
    SearchResult {
        scenario: job.run.name.clone(),
        search: kind,
        subject: search.spec.subject(),
        keys: keys.iter().map(|key| (*key).to_owned()).collect(),
        logarithmic: search.axes.iter().map(|axis| axis.logarithmic).collect(),
        cell: number,
        label: cell_label(&job.run, &keys, plan.is_repeated(cell.first)),
        parameters: job.parameters().into_iter().filter(|(name, _)| !keys.contains(&name.as_str())).collect(),
        verdict,
        message,
        interval: found.interval,
        lines: found.lines,
        best: found.best,
        runs: probes.len(),
        probes,
    }
}

/// What a search has found so far.
#[derive(Default)]
struct Found {
    interval: Option<Interval>,
    lines: Vec<Vec<LinePoint>>,
    best: Option<Best>,
}

impl Found {
    fn of(method: &Method, search: &PlannedSearch, probes: &[Probe]) -> Self {
        match method {
            Method::Bisection(bisection) => {
                let value = |at: u64| search.axes[0].value(at);
                let interval = bisection.bracket().map(|(low, high)| Interval {
                    lower: value(low),
                    upper: value(high),
                    holds_above: bisection.result(high) == Some(true),
                    changes: bisection.changes().into_iter().map(|(low, high)| [value(low), value(high)]).collect(),
                });
                Found { interval, ..Found::default() }
            }
            Method::Contour(contour) => {
                let value = |at: [u64; 2]| [0, 1].map(|i| search.axes[i].value(at[i]));
                let lines = contour.lines().into_iter().map(|line| {
                    let point = |crossing: Crossing| LinePoint {
                        lower: value(crossing.lower),
                        upper: value(crossing.upper),
                        holds_above: crossing.holds_above,
                    };
                    line.into_iter().map(point).collect()
                });
                Found { lines: lines.collect(), ..Found::default() }
            }
            Method::Evolution(evolution) => {
                let best = evolution.best().and_then(|(at, _)| {
                    let values = search.values(at);
                    let probe = probes.iter().find(|probe| probe.at == values)?;
                    Some(Best { at: values, value: probe.value?, run: probe.run.clone() })
                });
                Found { best, ..Found::default() }
            }
        }
    }

    /// The verdict of a search that is at its end.
    fn verdict(&self) -> SearchVerdict {
        let changes = self.interval.as_ref().map_or(0, |interval| interval.changes.len());
        match (changes, self.lines.is_empty(), self.best.is_some()) {
            (0, true, false) => SearchVerdict::NoBoundary,
            (0 | 1, ..) => SearchVerdict::Found,
            _ => SearchVerdict::NotMonotone,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_runs_that_say_nothing_the_first_counts_whichever_ends_first() {
        for order in [[1, 2, 3], [3, 1, 2], [2, 3, 1]] {
            let mut cell = Cell { first: 0, method: None, runs: Vec::new(), state: State::Open };
            order.into_iter().for_each(|slot| cell.fail(slot, format!("run {slot}")));
            assert_eq!(cell.state, State::Failed(1, "run 1".into()));
        }
    }
}
