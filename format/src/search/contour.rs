//! Traces the boundary of a condition over two keys.
//!
//! The range of the keys is divided into squares. Results are wanted at the corners of a few large
//! squares first. A square that has different results on its sides is divided into four, down to the
//! smallest size, so that most results are near the boundary. Each side of a smallest square whose ends
//! have different results is then bisected to one step of the lattice. The points found so are joined
//! across the squares.
//!
//! The next positions follow from the results alone.

use std::collections::{BTreeMap, BTreeSet};

use super::Position;

/// Number of squares along each side at the beginning.
const FIRST: u64 = 8;

/// A square of the lattice of corners: its lowest corner and its size, both in smallest squares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Square {
    corner: [u64; 2],
    size: u64,
}

/// A side of a smallest square: its lower end, in smallest squares, and its direction (0 or 1).
type Side = ([u64; 2], usize);

/// A point of the boundary: the condition has different results at two neighbours of the lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crossing {
    /// The lower neighbour.
    pub lower: [u64; 2],
    /// The upper one, which differs in one coordinate.
    pub upper: [u64; 2],
    /// The result at the upper neighbour.
    pub holds_above: bool,
}

/// The results at some positions of a lattice with two directions.
#[derive(Clone, Debug)]
pub struct Contour {
    /// Number of smallest squares along each side, a power of two.
    squares: u64,
    /// Number of steps of the lattice along a side of a smallest square, by direction.
    steps: [u64; 2],
    results: BTreeMap<[u64; 2], bool>,
    leaves: Vec<Square>,
    /// Sides that are bisected, with positions along them, in steps, of different results.
    sides: BTreeMap<Side, (u64, u64)>,
}

impl Contour {
    /// Begins without results. `squares` is a power of two.
    pub fn new(squares: u64, steps: [u64; 2]) -> Self {
        let size = (squares / FIRST).max(1);
        let corners = || (0..squares).step_by(size as usize);
        let leaves = corners().flat_map(|x| corners().map(move |y| Square { corner: [x, y], size })).collect();
        Contour { squares, steps, results: BTreeMap::new(), leaves, sides: BTreeMap::new() }
    }

    /// Number of results.
    pub fn probes(&self) -> usize {
        self.results.len()
    }

    /// Adds the result at a position.
    pub fn add(&mut self, at: &[u64], holds: bool) {
        self.results.insert([at[0], at[1]], holds);
    }

    /// The next positions to probe, in ascending order; none at the end. Their results must all be
    /// added before the next call.
    pub fn next_positions(&mut self) -> Vec<Position> {
        loop {
            let wanted: BTreeSet<[u64; 2]> = self
                .leaves
                .iter()
                .flat_map(|leaf| self.corners(leaf))
                .filter(|at| !self.results.contains_key(at))
                .collect();
            if !wanted.is_empty() {
                return wanted.into_iter().map(|at| at.to_vec()).collect();
            }
            let (divided, kept): (Vec<Square>, Vec<Square>) =
                self.leaves.iter().partition(|leaf| leaf.size > 1 && self.is_mixed(leaf));
            if divided.is_empty() {
                return self.next_of_sides();
            }
            self.leaves = kept;
            for Square { corner: [x, y], size } in divided {
                let size = size / 2;
                let corners = [[x, y], [x + size, y], [x, y + size], [x + size, y + size]];
                self.leaves.extend(corners.map(|corner| Square { corner, size }));
            }
            self.leaves.sort_unstable();
        }
    }

    /// Points of the boundary in the order of their sides, each with its side.
    fn crossings(&self) -> BTreeMap<Side, Crossing> {
        let of = |(side, (low, high)): (&Side, &(u64, u64))| {
            let (lower, upper) = (self.along(side, *low), self.along(side, *high));
            (*side, Crossing { lower, upper, holds_above: self.results.get(&upper).copied().unwrap_or(false) })
        };
        self.sides.iter().map(of).collect()
    }

    /// The boundary: lines of points, those of a closed one with the first point again at the end. Empty
    /// before the end of the search.
    ///
    /// Where the condition holds at two opposite corners of a smallest square only, they count as not
    /// connected.
    pub fn lines(&self) -> Vec<Vec<Crossing>> {
        if self.sides.values().any(|(low, high)| high - low > 1) {
            return Vec::new();
        }
        let crossings = self.crossings();
        if crossings.is_empty() {
            return Vec::new();
        }
        let mut joined: BTreeMap<Side, Vec<Side>> = crossings.keys().map(|side| (*side, Vec::new())).collect();
        for leaf in self.leaves.iter().filter(|leaf| leaf.size == 1) {
            for (a, b) in self.segments(leaf) {
                joined.entry(a).or_default().push(b);
                joined.entry(b).or_default().push(a);
            }
        }
        let mut left: BTreeSet<Side> = joined.keys().copied().collect();
        let mut lines = Vec::new();
        // Lines with ends begin at one; the others are closed.
        while let Some(start) = left.iter().find(|side| joined[*side].len() < 2).or(left.first()).copied() {
            let (mut line, mut at) = (vec![start], start);
            left.remove(&start);
            while let Some(next) = joined[&at].iter().find(|side| left.contains(side)) {
                at = *next;
                left.remove(&at);
                line.push(at);
            }
            if line.len() > 2 && joined[&at].contains(&start) {
                line.push(start);
            }
            lines.push(line.iter().filter_map(|side| crossings.get(side).copied()).collect());
        }
        lines
    }

    /// Pairs of sides of a smallest square between which the boundary crosses it.
    fn segments(&self, leaf: &Square) -> Vec<(Side, Side)> {
        let [x, y] = leaf.corner;
        // Corners and sides counter-clockwise; side i leads from corner i to corner i + 1.
        let corners = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]];
        let sides: [Side; 4] = [([x, y], 0), ([x + 1, y], 1), ([x, y + 1], 0), ([x, y], 1)];
        let holds = corners.map(|corner| self.at_corner(corner));
        let crossed: Vec<usize> = (0..4).filter(|i| holds[*i] != holds[(i + 1) % 4]).collect();
        match crossed[..] {
            [a, b] => vec![(sides[a], sides[b])],
            // Each corner where it holds is cut off: the sides before and after it.
            [_, _, _, _] => (0..4).filter(|i| holds[*i]).map(|i| (sides[(i + 3) % 4], sides[i])).collect(),
            _ => Vec::new(),
        }
    }

    /// The next positions on the sides whose ends have different results.
    fn next_of_sides(&mut self) -> Vec<Position> {
        for leaf in self.leaves.clone().iter().filter(|leaf| leaf.size == 1) {
            for side in self.segments(leaf).into_iter().flat_map(|(a, b)| [a, b]) {
                let steps = self.steps[side.1];
                self.sides.entry(side).or_insert((0, steps));
            }
        }
        let mut wanted = Vec::new();
        for (side, (mut low, mut high)) in self.sides.clone() {
            let below = self.results.get(&self.along(&side, low)).copied();
            while high - low > 1 {
                let middle = low + (high - low) / 2;
                let at = self.along(&side, middle);
                match self.results.get(&at).copied() {
                    Some(holds) if Some(holds) == below => low = middle,
                    Some(_) => high = middle,
                    None => {
                        wanted.push(at.to_vec());
                        break;
                    }
                }
            }
            self.sides.insert(side, (low, high));
        }
        wanted
    }

    /// The position this many steps along a side.
    fn along(&self, (corner, direction): &Side, steps: u64) -> [u64; 2] {
        let mut at = self.position(*corner);
        at[*direction] += steps;
        at
    }

    fn position(&self, [x, y]: [u64; 2]) -> [u64; 2] {
        [x * self.steps[0], y * self.steps[1]]
    }

    fn at_corner(&self, corner: [u64; 2]) -> bool {
        self.results.get(&self.position(corner)).copied().unwrap_or(false)
    }

    fn corners(&self, Square { corner: [x, y], size }: &Square) -> [[u64; 2]; 4] {
        let (right, top) = (x + size, y + size);
        [[*x, *y], [right, *y], [*x, top], [right, top]].map(|corner| self.position(corner))
    }

    /// True if results in the square or on its sides differ. Those on its sides may be of smaller
    /// neighbours.
    fn is_mixed(&self, Square { corner, size }: &Square) -> bool {
        let [x, y] = self.position(*corner);
        let [right, top] = self.position(corner.map(|at| at + size));
        let of = self.results.range([x, y]..=[right, top]).filter(|(at, _)| (y..=top).contains(&at[1]));
        let mut results = of.map(|(_, holds)| *holds);
        let first = results.next();
        results.any(|holds| Some(holds) != first)
    }

    /// Number of smallest squares along each side.
    pub fn squares(&self) -> u64 {
        self.squares
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trace(squares: u64, steps: [u64; 2], holds: impl Fn(f64, f64) -> bool) -> Contour {
        let mut contour = Contour::new(squares, steps);
        let scale = [0, 1].map(|i| 1.0 / (squares * steps[i]) as f64);
        loop {
            let next = contour.next_positions();
            if next.is_empty() {
                return contour;
            }
            for at in next {
                assert!(!contour.results.contains_key(&[at[0], at[1]]), "{at:?} is probed twice");
                assert!(at[0] <= squares * steps[0] && at[1] <= squares * steps[1]);
                contour.add(&at, holds(at[0] as f64 * scale[0], at[1] as f64 * scale[1]));
            }
        }
    }

    /// The middle of a crossing, in fractions of the range.
    fn middle(contour: &Contour, crossing: &Crossing) -> [f64; 2] {
        let scale = |i: usize| 0.5 / (contour.squares * contour.steps[i]) as f64;
        [0, 1].map(|i| (crossing.lower[i] + crossing.upper[i]) as f64 * scale(i))
    }

    #[test]
    fn a_circle_is_one_closed_line_of_few_probes() {
        let inside = |x: f64, y: f64| (x - 0.52).powi(2) + (y - 0.47).powi(2) < 0.09;
        let contour = trace(32, [8, 16], inside);
        let lines = contour.lines();
        assert_eq!(lines.len(), 1);
        let line = &lines[0];
        assert_eq!(line.first(), line.last());
        for crossing in line {
            let [x, y] = middle(&contour, crossing);
            let radius = (x - 0.52).hypot(y - 0.47);
            // Half a step of the coarser direction.
            assert!((radius - 0.3).abs() <= 0.5 / 256.0, "{radius}");
            assert_eq!(crossing.upper[0] - crossing.lower[0] + crossing.upper[1] - crossing.lower[1], 1);
        }
        // The area of the polygon by its corners.
        let points: Vec<[f64; 2]> = line.iter().map(|crossing| middle(&contour, crossing)).collect();
        let area: f64 = points.windows(2).map(|p| 0.5 * (p[0][0] * p[1][1] - p[1][0] * p[0][1])).sum();
        // A chord of length h cuts off h^3 / (12 r) of the disc.
        assert!((area.abs() - std::f64::consts::PI * 0.09).abs() < 2e-3, "{area}");
        // The whole lattice has 131 841 positions.
        assert!(contour.probes() < 700, "{}", contour.probes());
    }

    #[test]
    fn every_line_that_the_first_squares_see_is_found() {
        for slope in [-3.0, -0.5, 0.0, 0.3, 1.0, 2.5] {
            let contour = trace(64, [4, 4], |x, y| y - 0.48 > slope * (x - 0.51));
            let lines = contour.lines();
            assert_eq!(lines.len(), 1, "{slope}");
            let ends = [lines[0].first(), lines[0].last()].map(|end| middle(&contour, end.unwrap()));
            for [x, y] in ends {
                assert!([x, y].iter().any(|at| *at == 0.0 || *at == 1.0), "{slope}: {x} {y}");
            }
        }
    }

    #[test]
    fn a_bulge_between_two_corners_is_found_from_its_neighbours() {
        // The stripe ends within a first square, whose corners are all outside.
        let stripe = |x: f64, y: f64| (y - 0.55).abs() < 0.08 && x < 0.58;
        let lines = trace(64, [1, 1], stripe).lines();
        assert_eq!(lines.len(), 1);
        let deepest = lines[0].iter().map(|crossing| crossing.upper[0]).max().unwrap();
        assert_eq!(deepest, (0.58 * 64.0_f64).ceil() as u64);
    }

    #[test]
    fn opposite_corners_are_not_connected() {
        let quarters = |x: f64, y: f64| (x > 0.51) == (y > 0.52);
        let contour = trace(32, [4, 4], quarters);
        let lines = contour.lines();
        assert_eq!(lines.len(), 2);
        // Each goes around one quarter in which the condition holds, not around one in which it does not.
        for line in lines {
            let ends = [line.first(), line.last()].map(|end| middle(&contour, end.unwrap()));
            let at_low_side = ends.map(|[x, y]| x == 0.0 || y == 0.0);
            assert!(at_low_side == [true; 2] || at_low_side == [false; 2], "{ends:?}");
        }
    }

    #[test]
    fn without_a_boundary_only_the_first_corners_are_probed() {
        let contour = trace(64, [4, 4], |_, _| true);
        assert_eq!((contour.probes(), contour.lines().len()), (81, 0));
        assert_eq!(trace(4, [2, 2], |_, _| false).probes(), 25);
    }
}
