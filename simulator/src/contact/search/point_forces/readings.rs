//! States that the solved contact problem indicates.

use super::{Point, PointForces, SLIPS};
use crate::contact::model::problem::Problem;
use crate::contact::model::state::{Mode, Pattern, SoleState, States};

/// Friction, relative to what holds at most, with which a vertex is at its limit.
const LIMIT: f64 = 1.0 - 1e-9;

impl PointForces {
    /// The states that the solution indicates: the smallest pattern over the carrying vertices, those
    /// with more than `least` of the greatest force. It slides if those slip, by more than `slips` of
    /// the motion without contact, about the only one that does not.
    pub fn states(&self, p: &Problem, least: f64, slips: f64) -> States {
        let mut states = States::default();
        let load = self.load();
        for s in 0..p.soles.len() {
            let k = p.soles[s].vertices.len();
            let carrying = self.points_of(s).filter(|point| point.split.z > least * load);
            let carrying = carrying.fold(0u64, |set, point| set | 1 << point.vertex);
            let pattern = Pattern::covering(k, |i| carrying >> i & 1 == 1);
            if pattern != Pattern::Free {
                states[s] = SoleState { pattern, mode: self.mode(s, carrying, slips) };
            }
        }
        states
    }

    /// Whether the vertices of static soles do not move.
    pub fn rests(&self, states: &States) -> bool {
        let most = SLIPS * self.drive();
        self.points.iter().filter(|point| states[point.sole].is_static()).all(|point| point.dual.norm() <= most)
    }

    /// States of sole `s` on fewer vertices than carry it: edges both of whose vertices do, then
    /// vertices, each by decreasing load. An edge that sticks may turn about its heavier end. Adds at
    /// most `most` to `list`.
    pub fn parts(&self, p: &Problem, s: usize, slips: f64, most: usize, list: &mut Vec<SoleState>) {
        let k = p.soles[s].vertices.len();
        let load = |i: usize| self.points_of(s).find(|point| point.vertex == i).map_or(0.0, |point| point.split.z);
        let patterns =
            SoleState::patterns(k).filter(|pattern| matches!(pattern, Pattern::Vertex(_) | Pattern::Edge(_)));
        let first = list.len();
        for pattern in patterns {
            let state = SoleState::fixed(pattern);
            let vertices = || (0..k).filter(|&i| state.clamps(i, k));
            if vertices().all(|i| load(i) > 0.0) {
                let set = vertices().fold(0u64, |set, i| set | 1 << i);
                let mode = self.mode(s, set, slips);
                list.push(SoleState { pattern, mode });
                if let (Mode::Static, Pattern::Edge(_)) = (mode, pattern)
                    && let Some(i) = vertices().max_by(|&i, &j| load(i).total_cmp(&load(j)))
                {
                    list.push(SoleState { pattern, mode: Mode::Pivoting(i as u8) });
                }
            }
        }
        let sum = |state: &SoleState| (0..k).filter(|&i| state.clamps(i, k)).map(load).sum::<f64>();
        let order = |a: &SoleState, b: &SoleState| {
            b.normal_rows().cmp(&a.normal_rows()).then_with(|| sum(b).total_cmp(&sum(a))).then_with(|| a.cmp(b))
        };
        list[first..].sort_unstable_by(order);
        list.truncate(first + most);
    }

    /// Mode of a sole on a set of its vertices.
    fn mode(&self, s: usize, set: u64, slips: f64) -> Mode {
        let drive = self.drive();
        let slips = |point: &&Point| {
            let at_limit = point.split.xy().norm() >= LIMIT * point.mu * point.split.z;
            point.direction.is_some() || (at_limit && point.dual.xy().norm() > slips * drive)
        };
        let slipping = self.points_of(s).filter(slips).fold(0u64, |set, point| set | 1 << point.vertex) & set;
        let sticking = set & !slipping;
        match (slipping, sticking.count_ones()) {
            (0, _) => Mode::Static,
            (_, 0) => Mode::Sliding,
            (_, 1) => Mode::Pivoting(sticking.trailing_zeros() as u8),
            _ => Mode::Static,
        }
    }

    fn points_of(&self, s: usize) -> impl Iterator<Item = &Point> {
        self.points.iter().filter(move |point| point.sole == s)
    }

    /// The greatest normal force.
    fn load(&self) -> f64 {
        self.points.iter().map(|point| point.split.z).fold(0.0, f64::max)
    }
}
