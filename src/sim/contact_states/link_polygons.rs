//! Changes of the polygons of a run's contact problem that belong to links
//! ([`super::link_contacts`]): corners that remain keep their contact, friction and anchors.

use super::drift_projection::anchor_vertex;
use super::link_contacts::LinkPolygon;
use crate::contact::model::problem::{Problem, Vertex};
use crate::contact::model::solution::{Solution, wrench_at};
use crate::contact::model::state::{MAX_SOLES, Mode, Pattern, SoleState, States};
use crate::robot::Sole;
use crate::sim::floor::VertexRegion;
use crate::sim::report::Outcome;
use crate::sim::run::RunState;
use crate::sim::run_error::RunError;
use nalgebra::{Vector2, Vector3};

/// For each polygon the former polygon of its link, and for each corner its former index.
pub struct Origins(Vec<Option<(usize, Vec<Option<usize>>)>>);

impl Origins {
    /// Former index of polygon `s`.
    pub fn of(&self, s: usize) -> Option<usize> {
        self.0.get(s)?.as_ref().map(|(former, _)| *former)
    }

    /// Former indices of corner `i` of polygon `s`.
    fn of_corner(&self, s: usize, i: usize) -> Option<(usize, usize)> {
        let (former, corners) = self.0[s].as_ref()?;
        Some((*former, corners[i]?))
    }

    /// Values of all corners in their new order.
    fn carry<T: Copy>(&self, sizes: &[usize], old: &[Vec<T>], fresh: T) -> Vec<Vec<T>> {
        let value = |s: usize, i: usize| self.of_corner(s, i).map_or(fresh, |(s, i)| old[s][i]);
        sizes.iter().enumerate().map(|(s, &k)| (0..k).map(|i| value(s, i)).collect()).collect()
    }
}

impl RunState {
    /// Updates the polygons of links to the plant's present state, before a choice of states or a
    /// step of size `step` without located events. Returns whether they have changed; the plant must
    /// then be evaluated again.
    ///
    /// # Errors
    /// More links touch than there may be polygons.
    pub(in crate::sim) fn update_link_polygons(&mut self, step: Option<f64>) -> Result<bool, RunError> {
        let Some(links) = &mut self.links else { return Ok(false) };
        self.plant.update_kinematics();
        let Some(next) = links.find(&self.plant, self.tolerances.distance, step) else { return Ok(false) };
        self.set_link_polygons(next)?;
        Ok(true)
    }

    /// Replaces the polygons of links.
    ///
    /// # Errors
    /// See [`update_link_polygons`](Self::update_link_polygons).
    pub(in crate::sim) fn set_link_polygons(&mut self, next: Vec<LinkPolygon>) -> Result<(), RunError> {
        let Some(links) = &mut self.links else { return Ok(()) };
        let plant = &mut self.plant;
        let soles = plant.model.soles.len();
        if soles + next.len() > MAX_SOLES {
            let message = format!(
                "{} links touch the floor at {:.6} s; with {soles} soles at most {} may",
                next.len(),
                plant.state.time,
                MAX_SOLES - soles
            );
            return Err(RunError::new(Outcome::Error, message));
        }
        let mut origins: Vec<_> = plant.model.soles.iter().enumerate().map(|(s, sole)| own_origin(s, sole)).collect();
        let mut polygons = plant.model.soles.clone();
        for (h, corners) in &next {
            let hull = &links.hulls[*h];
            let name = plant.model.links[hull.link.0].name.clone();
            let vertices = corners.iter().map(|k| hull.points[*k as usize]).collect();
            polygons.push(Sole { name, link: hull.link, vertices });
            let former = links.present.iter().position(|(hull, _)| hull == h);
            origins.push(former.map(|at| {
                let old = &links.present[at].1;
                (soles + at, corners.iter().map(|k| old.iter().position(|o| o == k)).collect())
            }));
        }
        links.present = next;
        self.replace_polygons(polygons, &Origins(origins));
        Ok(())
    }

    /// Replaces the plant's polygons and all that belongs to them.
    fn replace_polygons(&mut self, polygons: Vec<Sole>, origins: &Origins) {
        let plant = &mut self.plant;
        let sizes: Vec<usize> = polygons.iter().map(|polygon| polygon.vertices.len()).collect();
        let old = std::mem::replace(&mut plant.problem, Problem::new(&sizes));
        let problem = &mut plant.problem;
        (problem.level, problem.scale, problem.step) = (old.level, old.scale, old.step);
        for (s, sole) in problem.soles.iter_mut().enumerate() {
            (sole.radius, sole.body) = (polygons[s].radius(), polygons[s].link.0);
            for (i, vertex) in sole.vertices.iter_mut().enumerate() {
                *vertex = origins.of_corner(s, i).map_or(Vertex::default(), |(s, i)| old.soles[s].vertices[i]);
            }
        }
        let before = std::mem::replace(&mut plant.solution, Solution::new(problem));
        plant.solution.normal = origins.carry(&sizes, &before.normal, 0.0);
        plant.solution.tangent = origins.carry(&sizes, &before.tangent, Vector2::zeros());
        let states = plant.states;
        plant.states = States::default();
        let (fast, suspect) = (plant.fast_slips, self.suspect);
        (plant.fast_slips, self.suspect) = ([0; MAX_SOLES], [0; MAX_SOLES]);
        for (s, &k) in sizes.iter().enumerate() {
            let Some(former) = origins.of(s) else { continue };
            plant.states[s] = carried_state(origins, s, k, states[former], old.soles[former].vertices.len());
            self.suspect[s] = suspect[former];
            let bits = (0..k).filter(|&i| origins.of_corner(s, i).is_some_and(|(s, i)| fast[s] & 1 << i != 0));
            plant.fast_slips[s] = bits.fold(0, |set, i| set | 1 << i);
        }
        plant.directions = origins.carry(&sizes, &plant.directions, Vector2::zeros());
        plant.regions = origins.carry(&sizes, &plant.regions, VertexRegion::default());
        plant.reduced = plant.reduced.with_soles(&polygons, &plant.ws);
        plant.polygons = polygons;
        plant.method = self.contact.method.solver(&plant.problem);
        plant.refresh();
        self.projection = Solution::new(&plant.problem);
        self.before_selection = Solution::new(&plant.problem);
        self.anchors = origins.carry(&sizes, &self.anchors, Vector3::zeros());
        for (s, &k) in sizes.iter().enumerate() {
            let fresh = |i: usize| origins.of_corner(s, i).is_none();
            (0..k).filter(|i| fresh(*i)).for_each(|i| self.plant.begin_friction(s, i));
            (0..k).filter(|i| fresh(*i)).for_each(|i| anchor_vertex(self, s, i));
            self.carry_wrench(s, k, origins, &before);
        }
        self.residuals.replace_polygons(|s| origins.of(s));
        self.milestones.replace_states(&self.plant.states);
        self.recorded_problem = None;
    }

    /// The wrench on polygon `s` before the change, about its present reference point.
    fn carry_wrench(&mut self, s: usize, k: usize, origins: &Origins, before: &Solution) {
        let solution = &mut self.plant.solution;
        let wrench = &mut solution.wrench[6 * s..6 * s + 6];
        let same = (0..k).all(|i| origins.of_corner(s, i).is_some_and(|(_, former)| former == i));
        match origins.of(s) {
            Some(former) if same && before.normal[former].len() == k => {
                wrench.copy_from_slice(&before.wrench[6 * former..6 * former + 6]);
            }
            _ => {
                for (i, vertex) in self.plant.problem.soles[s].vertices.iter().enumerate() {
                    let t = solution.tangent[s][i];
                    let one = wrench_at(&vertex.r, &Vector3::new(t.x, t.y, solution.normal[s][i]));
                    wrench.iter_mut().zip(one).for_each(|(sum, x)| *sum += x);
                }
            }
        }
    }
}

/// A sole, which stays as it is.
fn own_origin(s: usize, sole: &Sole) -> Option<(usize, Vec<Option<usize>>)> {
    Some((s, (0..sole.vertices.len()).map(Some).collect()))
}

/// The state of a polygon of `k` corners after a change: the greatest pattern of corners that were
/// clamped.
fn carried_state(origins: &Origins, s: usize, k: usize, former: SoleState, former_k: usize) -> SoleState {
    let clamped = |i: usize| origins.of_corner(s, i).is_some_and(|(_, i)| former.clamps(i, former_k));
    let keeps = |p: &Pattern| (0..k).all(|i| !SoleState::fixed(*p).clamps(i, k) || clamped(i));
    let pattern = SoleState::patterns(k).filter(keeps).last().unwrap_or(Pattern::Free);
    let mode = match former.mode {
        _ if pattern == Pattern::Free => Mode::Static,
        Mode::Static => Mode::Static,
        _ if k == former_k && (0..k).all(|i| origins.of_corner(s, i).is_some_and(|(_, j)| i == j)) => former.mode,
        _ => Mode::Sliding,
    };
    SoleState { pattern, mode }
}
