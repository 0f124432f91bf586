//! A search with its cells (the runs of the sweep, each of which becomes a search of its own) and the
//! values at which they are run.
//!
//! Each cell has a fixed number of run numbers, its slots. A slot gets its values, a position on the
//! lattice of equal steps between the ends of each key, when the results before it are known.

use std::sync::OnceLock;

use crate::math;
use crate::scenario::format::search::{SearchSpec, SearchedKey};
use crate::scenario::key_path::KeyPath;
use crate::scenario::sweep::decimal;
use crate::search::{Bisection, Contour, Evolution, Method, Position, Prior, most_probes, population_for};
use crate::text::source::Span;
use crate::text::toml_tree::{Node, Value};

/// A search, planned for all cells of the sweep.
#[derive(Debug)]
pub struct PlannedSearch {
    /// The search.
    pub spec: SearchSpec,
    /// The searched keys, in the order of the file.
    pub axes: Vec<SearchAxis>,
    /// Where a search for the best value begins.
    pub(super) start: Position,
    /// All dimensions of the sweep: distance of neighbours, length, and whether it is followed.
    pub(super) dimensions: Vec<(usize, usize, bool)>,
    /// Positions of the runs on the lattice, by run number.
    pub(super) slots: Vec<OnceLock<Position>>,
}

/// A searched key.
#[derive(Clone, Debug)]
pub struct SearchAxis {
    /// Its dotted path.
    pub name: String,
    /// Its ends.
    pub between: [f64; 2],
    /// True if the values are in equal ratios.
    pub logarithmic: bool,
    pub(super) path: KeyPath,
    /// Number of steps between the ends.
    pub(super) steps: u64,
    /// True if the values are written as whole numbers.
    pub(super) whole: bool,
    /// Position of the ends in the file.
    pub(super) span: Span,
}

impl SearchAxis {
    /// Number of steps between the ends for a tolerance; with `squares` a multiple of it by a power of
    /// two.
    pub(super) fn steps_for(key: &SearchedKey, squares: Option<u64>) -> u64 {
        let SearchedKey { between: [from, to], tolerance, logarithmic } = *key;
        let exact = match logarithmic {
            true => math::ln(to / from) / math::ln(1.0 + tolerance),
            false => (to - from) / tolerance,
        };
        // Rounding of the quotient must not add a step.
        let least = (exact * (1.0 - 1e-12)).ceil().max(1.0) as u64;
        match squares {
            Some(squares) => squares * least.div_ceil(squares).next_power_of_two(),
            None => least,
        }
    }

    /// Number of steps between the ends.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The value at a position.
    pub fn value(&self, at: u64) -> f64 {
        let [from, to] = self.between;
        match at {
            0 => from,
            at if at >= self.steps => to,
            at if self.logarithmic => {
                let value = from * math::powf(to / from, at as f64 / self.steps as f64);
                decimal(value, value)
            }
            at => decimal(from + at as f64 * (to - from) / self.steps as f64, from.abs().max(to.abs())),
        }
    }

    /// The position nearest to a value between the ends; the middle for others.
    pub(super) fn nearest(&self, value: Option<f64>) -> u64 {
        let [from, to] = self.between;
        match value.filter(|value| (from..=to).contains(value)) {
            Some(value) => {
                let share = match self.logarithmic {
                    true => math::ln(value / from) / math::ln(to / from),
                    false => (value - from) / (to - from),
                };
                (share * self.steps as f64).round() as u64
            }
            None => self.steps / 2,
        }
    }

    fn node(&self, at: u64) -> Node {
        let value = match self.value(at) {
            x if self.whole => Value::Integer(x as i64),
            x => Value::Float(x),
        };
        Node::computed(value, &self.span)
    }
}

/// A cell whose boundary others follow, from which they expect theirs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FollowedCell {
    /// The cell before, along one followed dimension.
    pub before: usize,
    /// Along another followed dimension, where there is one: the cell before, and the one before both.
    pub across: Option<(usize, usize)>,
}

impl PlannedSearch {
    /// Greatest number of runs of a cell.
    pub fn slots_per_cell(&self) -> usize {
        match (&self.axes[..], self.spec.runs) {
            (_, Some(runs)) => runs as usize,
            ([axis], None) => most_probes(axis.steps, u64::from(self.spec.check), self.follows()) as usize,
            _ => 1,
        }
    }

    /// True if cells depend on others.
    pub fn follows(&self) -> bool {
        self.dimensions.iter().any(|(_, length, follows)| *follows && *length > 1)
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.slots.len() / self.slots_per_cell()
    }

    /// Names of the searched keys, such as `a, b`.
    pub fn keys(&self) -> String {
        self.axes.iter().map(|axis| axis.name.as_str()).collect::<Vec<_>>().join(", ")
    }

    /// The values at a position, in the order of the keys.
    pub fn values(&self, at: &[u64]) -> Vec<f64> {
        self.axes.iter().zip(at).map(|(axis, at)| axis.value(*at)).collect()
    }

    /// Begins the search of a cell; `prior` is where its boundary is expected.
    pub fn begin(&self, prior: Option<Prior>) -> Method {
        match (&self.axes[..], self.spec.objective()) {
            ([axis], None) => Method::Bisection(Bisection::new(axis.steps, u64::from(self.spec.check), prior)),
            (axes, None) => {
                let squares = self.spec.squares();
                Method::Contour(Contour::new(squares, [0, 1].map(|i| axes[i].steps / squares)))
            }
            (axes, Some(_)) => {
                let steps = axes.iter().map(|axis| axis.steps).collect();
                let population = self.spec.population.map_or_else(|| population_for(axes.len()), |n| n as usize);
                let limits = (self.slots_per_cell(), population);
                Method::Evolution(Box::new(Evolution::new(steps, &self.start, limits, self.spec.seed)))
            }
        }
    }

    /// Sets the position of a run; the first one stays.
    pub fn assign(&self, number: usize, at: &[u64]) {
        if let Some(slot) = self.slots.get(number) {
            let _ = slot.set(at.to_vec());
        }
    }

    /// Paths and values of the keys in a run. A run whose position is not known has the lower ends or,
    /// the second run of a cell, the upper ones.
    pub(in crate::scenario) fn parameters(&self, number: usize) -> Vec<(KeyPath, Node)> {
        let known = self.slots.get(number).and_then(OnceLock::get);
        let is_first = number.is_multiple_of(self.slots_per_cell());
        let end = |axis: &SearchAxis| if is_first { 0 } else { axis.steps };
        let of = |(i, axis): (usize, &SearchAxis)| {
            (axis.path.clone(), axis.node(known.map_or_else(|| end(axis), |at| at[i])))
        };
        self.axes.iter().enumerate().map(of).collect()
    }

    /// True if the key, a part of it or a value that contains it is searched.
    pub(in crate::scenario) fn overlaps(&self, path: &KeyPath) -> bool {
        self.axes.iter().any(|axis| axis.path.overlaps(path))
    }

    /// Number of the group of cells that depend on each other.
    pub fn group(&self, cell: usize) -> usize {
        let own = self.dimensions.iter().filter(|(_, _, follows)| !follows);
        own.fold(0, |above, (stride, length, _)| above * length + cell / stride % length)
    }

    /// Cells that must be at their end before this one begins.
    pub fn followed(&self, cell: usize) -> Vec<FollowedCell> {
        let before: Vec<usize> = self
            .dimensions
            .iter()
            .filter(|(stride, length, follows)| *follows && !(cell / stride).is_multiple_of(*length))
            .map(|(stride, ..)| cell - stride)
            .collect();
        let across = |at: usize| {
            let other = before.get(if at == 0 { 1 } else { 0 })?;
            // Both are one step away from this cell.
            Some((*other, before[at] + other - cell))
        };
        before.iter().enumerate().map(|(at, cell)| FollowedCell { before: *cell, across: across(at) }).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(between: [f64; 2], tolerance: f64, squares: Option<u64>) -> SearchAxis {
        scaled(between, tolerance, squares, false)
    }

    fn scaled(between: [f64; 2], tolerance: f64, squares: Option<u64>, logarithmic: bool) -> SearchAxis {
        let steps = SearchAxis::steps_for(&SearchedKey { between, tolerance, logarithmic }, squares);
        let (name, path) = ("duration".to_owned(), KeyPath::internal("duration"));
        SearchAxis { name, between, logarithmic, path, steps, whole: false, span: 0..0 }
    }

    #[test]
    fn logarithmic_values_have_equal_ratios() {
        let search = scaled([1e-8, 1e-2], 9.0, None, true);
        assert_eq!(search.steps, 6);
        assert_eq!([0, 1, 3, 5, 6].map(|at| search.value(at)), [1e-8, 1e-7, 1e-5, 1e-3, 1e-2]);
        assert_eq!([Some(2e-5), Some(1.0)].map(|value| search.nearest(value)), [3, 3]);
        assert_eq!(scaled([1.0, 8.0], 0.5, Some(4), true).steps, 8);
    }

    #[test]
    fn values_are_decimal_and_no_step_is_wider_than_the_tolerance() {
        let search = axis([8.0, 40.0], 0.1, None);
        assert_eq!((search.steps, search.value(3), search.value(320)), (320, 8.3, 40.0));
        let search = axis([0.0, 1.0], 0.3, None);
        assert_eq!((search.steps, search.value(1)), (4, 0.25));
        // In f64, 0.6 / 0.1 is 5.999999999999999 or 6.000000000000001, by its terms.
        assert_eq!(axis([0.1, 0.7], 0.1, None).steps, 6);
        assert_eq!(axis([0.0, 60.0], 1e-9, None).steps, 60_000_000_000);
        assert_eq!([0.1, 0.03].map(|tolerance| axis([0.0, 1.0], tolerance, Some(8)).steps), [16, 64]);
    }

    #[test]
    fn a_search_begins_at_the_value_of_the_file() {
        let search = axis([8.0, 40.0], 0.1, None);
        assert_eq!([Some(8.34), Some(40.0), Some(7.0), None].map(|value| search.nearest(value)), [3, 320, 160, 160]);
    }

    #[test]
    fn cells_follow_those_before_and_groups_are_independent() {
        // 2 x 3 x 5 cells; the first and the last dimension are followed.
        let dimensions = vec![(15, 2, true), (5, 3, false), (1, 5, true)];
        let axes = vec![axis([0.0, 1.0], 0.1, None)];
        let search =
            PlannedSearch { spec: SearchSpec::default(), axes, start: Vec::new(), dimensions, slots: Vec::new() };
        assert_eq!(search.followed(0), []);
        assert_eq!(search.followed(5), []);
        assert_eq!(search.followed(7), [FollowedCell { before: 6, across: None }]);
        let [first, last] = &search.followed(22)[..] else { panic!("two cells before") };
        assert_eq!(*first, FollowedCell { before: 7, across: Some((21, 6)) });
        assert_eq!(*last, FollowedCell { before: 21, across: Some((7, 6)) });
        for cell in 0..30 {
            assert_eq!(search.group(cell), cell / 5 % 3);
            assert!(search.followed(cell).iter().all(|f| search.group(f.before) == search.group(cell)));
        }
    }
}
