//! Changes of the polygons of a run's contact problem: those of links over the floor
//! ([`super::link_contacts`]) and those of pairs of bodies ([`super::pair_contacts`]). Vertices that remain
//! keep their contact, friction and anchors.

use super::drift_projection::anchor_vertex;
use super::link_contacts::LinkPolygon;
use crate::contact::model::problem::{Problem, Vertex};
use crate::contact::model::solution::{Solution, wrench_at};
use crate::contact::model::state::{Mode, Pattern, SoleState};
use crate::dynamics::Reduced;
use crate::robot::Sole;
use crate::sim::bodies::PairPatch;
use crate::sim::floor::VertexRegion;
use crate::sim::plant::Polygon;
use crate::sim::run::RunState;
use nalgebra::{Matrix3, Vector2, Vector3};

/// For each polygon the former polygon in its place, and for each vertex its former index.
pub struct Origins(Vec<Option<(usize, Vec<Option<usize>>)>>);

impl Origins {
    /// Former index of polygon `s`.
    pub fn of(&self, s: usize) -> Option<usize> {
        self.0.get(s)?.as_ref().map(|(former, _)| *former)
    }

    /// Former indices of vertex `i` of polygon `s`.
    fn of_vertex(&self, s: usize, i: usize) -> Option<(usize, usize)> {
        let (former, vertices) = self.0[s].as_ref()?;
        Some((*former, vertices[i]?))
    }

    /// Values of all vertices in their new order.
    fn carry<T: Copy>(&self, sizes: &[usize], old: &[Vec<T>], fresh: T) -> Vec<Vec<T>> {
        let value = |s: usize, i: usize| self.of_vertex(s, i).map_or(fresh, |(s, i)| old[s][i]);
        sizes.iter().enumerate().map(|(s, &k)| (0..k).map(|i| value(s, i)).collect()).collect()
    }
}

impl RunState {
    /// Updates the polygons to the plant's present state, before a choice of states or a step of size
    /// `step` without located events. Returns whether they have changed; the plant must then be evaluated
    /// again.
    pub(in crate::sim) fn update_polygons(&mut self, step: Option<f64>) -> bool {
        if self.links.is_none() && self.pairs.is_empty() {
            return false;
        }
        self.plant.update_kinematics();
        self.pairs.update_terrain(&mut self.plant, step);
        let (plant, distance) = (&self.plant, self.tolerances.distance);
        let links = self.links.as_mut().and_then(|links| links.find(plant, distance, step));
        let pairs = self.pairs.find(plant, distance, step);
        self.set_polygons(links, pairs)
    }

    /// Updates the planes of patches to the states in force. Returns whether polygons have changed.
    pub(in crate::sim) fn follow_states(&mut self) -> bool {
        if self.pairs.is_empty() {
            return false;
        }
        let pairs = self.pairs.follow_states(&self.plant);
        self.set_polygons(None, pairs)
    }

    /// Turns the polygons on ends of cylinders towards loads on their sides. Returns whether it has; the states must
    /// then be chosen again.
    pub(in crate::sim) fn turn_rings(&mut self) -> bool {
        if self.pairs.is_empty() {
            return false;
        }
        let pairs = self.pairs.turn_rings(&self.plant);
        self.set_polygons(None, pairs)
    }

    /// Replaces the polygons of links, or those of pairs, or both. Returns whether it has.
    pub(in crate::sim) fn set_polygons(
        &mut self,
        links: Option<Vec<LinkPolygon>>,
        pairs: Option<Vec<PairPatch>>,
    ) -> bool {
        if links.is_none() && pairs.is_none() {
            return false;
        }
        let plant = &self.plant;
        let soles = plant.model.soles.len();
        let mut origins: Vec<_> = plant.model.soles.iter().enumerate().map(|(s, sole)| own_origin(s, sole)).collect();
        let mut polygons: Vec<Polygon> = plant.model.soles.iter().cloned().map(Polygon::Floor).collect();
        let mut former_pairs = soles;
        if let Some(contacts) = &mut self.links {
            let former = std::mem::take(&mut contacts.present);
            former_pairs += former.len();
            contacts.present = links.unwrap_or_else(|| former.clone());
            for (h, corners) in &contacts.present {
                let hull = &contacts.hulls[*h];
                let name = plant.model.links[hull.link.0].name.clone();
                let vertices = corners.iter().map(|k| hull.points[*k as usize]).collect();
                polygons.push(Polygon::Floor(Sole { name, link: hull.link, vertices }));
                let at = former.iter().position(|(hull, _)| hull == h);
                origins.push(at.map(|at| {
                    let old = &former[at].1;
                    (soles + at, corners.iter().map(|k| old.iter().position(|o| o == k)).collect())
                }));
            }
        }
        for mut patch in pairs.unwrap_or_else(|| plant.pair_patches().cloned().collect()) {
            let mut formers = plant.pair_patches().enumerate();
            let first = formers.find(|(_, former)| patch.continues(former));
            // Of patches that become one, the first that carries.
            let carries = |(at, former): &(usize, &PairPatch)| {
                let (state, k) = (plant.states[former_pairs + at], former.len());
                (0..k).any(|v| state.clamps(v, k) && (0..patch.len()).any(|i| patch.is_vertex_of(i, former, v)))
            };
            let former =
                first.into_iter().chain(formers.filter(|(_, former)| patch.continues(former))).find(carries).or(first);
            origins.push(former.map(|(at, former)| {
                let same = |i: usize| (0..former.len()).find(|k| patch.is_vertex_of(i, former, *k));
                let vertices: Vec<Option<usize>> = (0..patch.len()).map(same).collect();
                let kept = vertices.iter().enumerate().filter_map(|(i, old)| Some((i, (*old)?)));
                kept.for_each(|(i, old)| patch.take_anchor(i, former, old));
                (former_pairs + at, vertices)
            }));
            polygons.push(Polygon::Pair(patch));
        }
        self.replace_polygons(polygons, &Origins(origins));
        true
    }

    /// Replaces the plant's polygons and all that belongs to them.
    fn replace_polygons(&mut self, polygons: Vec<Polygon>, origins: &Origins) {
        let plant = &mut self.plant;
        let sizes: Vec<usize> = polygons.iter().map(Polygon::number_of_vertices).collect();
        let old = std::mem::replace(&mut plant.problem, Problem::new(&sizes));
        let problem = &mut plant.problem;
        (problem.level, problem.scale, problem.step) = (old.level, old.scale, old.step);
        for (s, sole) in problem.soles.iter_mut().enumerate() {
            (sole.radius, sole.body) = (polygons[s].radius(), polygons[s].rigid_group(plant.model.links.len() + s));
            for (i, vertex) in sole.vertices.iter_mut().enumerate() {
                *vertex = origins.of_vertex(s, i).map_or(Vertex::default(), |(s, i)| old.soles[s].vertices[i]);
            }
        }
        let before = std::mem::replace(&mut plant.solution, Solution::new(problem));
        plant.solution.normal = origins.carry(&sizes, &before.normal, 0.0);
        plant.solution.tangent = origins.carry(&sizes, &before.tangent, Vector2::zeros());
        let states = std::mem::take(&mut plant.states);
        let (fast, suspect) = (std::mem::take(&mut plant.fast_slips), std::mem::take(&mut self.suspect));
        for (s, &k) in sizes.iter().enumerate() {
            let Some(former) = origins.of(s) else { continue };
            plant.states[s] = carried_state(origins, s, k, states[former], old.soles[former].vertices.len());
            self.suspect[s] = suspect[former];
            let bits = (0..k).filter(|&i| origins.of_vertex(s, i).is_some_and(|(s, i)| fast[s] & 1 << i != 0));
            plant.fast_slips[s] = bits.fold(0, |set, i| set | 1 << i);
        }
        plant.directions = origins.carry(&sizes, &plant.directions, Vector2::zeros());
        turn_with_axes(&polygons, origins, &plant.reduced, &mut plant.directions);
        let axes = plant.reduced.axes.clone();
        plant.carry_turning(sizes.len(), |s| {
            let (at, patch) = (origins.of(s)?, polygons[s].pair());
            Some((at, patch.map_or(Matrix3::identity(), |patch| patch.axes().tr_mul(&axes[at]))))
        });
        plant.problem.set_turning_modes(&plant.turning);
        turn_with_axes(&polygons, origins, &plant.reduced, &mut plant.solution.tangent);
        plant.regions = origins.carry(&sizes, &plant.regions, VertexRegion::default());
        let mechanisms = plant.objects.mechanisms(&plant.ws);
        let frames = polygons.iter().map(|polygon| polygon.frame());
        plant.reduced = plant.reduced.with_contacts(frames, mechanisms);
        plant.polygons = polygons;
        plant.pair_bias = vec![[0.0; 6]; plant.polygons.len()];
        plant.update_floor_rules();
        plant.method = self.contact.method.solver(&plant.problem);
        plant.refresh();
        self.projection = Solution::new(&plant.problem);
        self.before_selection = Solution::new(&plant.problem);
        self.anchors = origins.carry(&sizes, &self.anchors, Vector3::zeros());
        for (s, &k) in sizes.iter().enumerate() {
            let fresh = |i: usize| origins.of_vertex(s, i).is_none();
            for i in 0..k {
                if fresh(i) { self.plant.begin_friction(s, i) } else { self.plant.continue_friction(s, i) }
            }
            (0..k).filter(|i| fresh(*i)).for_each(|i| anchor_vertex(self, s, i));
            self.carry_wrench(s, k, origins, &before);
        }
        self.residuals.replace_polygons(sizes.len(), |s| origins.of(s));
        self.milestones.replace_polygons(sizes.len(), &self.plant.states, |s| origins.of(s));
        self.recorded_problem = None;
    }

    /// The wrench on polygon `s` before the change, about its present reference point.
    fn carry_wrench(&mut self, s: usize, k: usize, origins: &Origins, before: &Solution) {
        let solution = &mut self.plant.solution;
        let wrench = &mut solution.wrench[6 * s..6 * s + 6];
        let same = (0..k).all(|i| origins.of_vertex(s, i).is_some_and(|(_, former)| former == i));
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

/// Turns vectors in the plane of patches from their former to their present axes.
fn turn_with_axes(polygons: &[Polygon], origins: &Origins, former: &Reduced, values: &mut [Vec<Vector2<f64>>]) {
    for (s, values) in values.iter_mut().enumerate() {
        if let (Some(patch), Some(at)) = (polygons[s].pair(), origins.of(s)) {
            let turn = patch.axes().tr_mul(&former.axes[at]);
            values.iter_mut().for_each(|v| *v = (turn * Vector3::new(v.x, v.y, 0.0)).xy());
        }
    }
}

/// A sole, which stays as it is.
fn own_origin(s: usize, sole: &Sole) -> Option<(usize, Vec<Option<usize>>)> {
    Some((s, (0..sole.vertices.len()).map(Some).collect()))
}

/// The state of a polygon of `k` vertices after a change: the greatest pattern of vertices that were
/// clamped.
fn carried_state(origins: &Origins, s: usize, k: usize, former: SoleState, former_k: usize) -> SoleState {
    let clamped = |i: usize| origins.of_vertex(s, i).is_some_and(|(_, i)| former.clamps(i, former_k));
    let keeps = |p: &Pattern| (0..k).all(|i| !SoleState::fixed(*p).clamps(i, k) || clamped(i));
    let pattern = SoleState::patterns(k).filter(keeps).last().unwrap_or(Pattern::Free);
    let mode = match former.mode {
        _ if pattern == Pattern::Free => Mode::Static,
        Mode::Static => Mode::Static,
        _ if k == former_k && (0..k).all(|i| origins.of_vertex(s, i).is_some_and(|(_, j)| i == j)) => former.mode,
        _ => Mode::Sliding,
    };
    SoleState { pattern, mode }
}
