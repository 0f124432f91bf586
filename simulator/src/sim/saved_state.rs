//! States of the robot saved and restored by scenario events.

use super::bodies::PairPatch;
use super::contact_states::link_contacts::{LinkContacts, LinkPolygon};
use super::plant::Plant;
use crate::contact::model::per_sole::PerSole;
use crate::contact::model::solution::Solution;
use crate::contact::model::state::States;
use crate::contact::model::turning::TurningMode;
use crate::dynamics::State;
use nalgebra::{Vector2, Vector3};

/// A state of the robot: motion, actuators and contact.
#[derive(Clone)]
pub struct SavedState {
    state: State,
    objects: Vec<State>,
    /// Polygons of links and pairs, to be set before the state is restored.
    links: Option<Vec<LinkPolygon>>,
    pairs: Vec<PairPatch>,
    states: States,
    directions: Vec<Vec<Vector2<f64>>>,
    turning: Vec<TurningMode>,
    fast_slips: PerSole<u64>,
    anchors: Vec<Vec<Vector3<f64>>>,
    suspect: PerSole<u8>,
    /// Contact forces, from which methods without a search derive the next states.
    solution: Solution,
}

impl SavedState {
    /// Allocates memory for a state.
    pub fn new(plant: &Plant, anchors: &[Vec<Vector3<f64>>]) -> Self {
        SavedState {
            state: plant.state.clone(),
            objects: plant.objects.list.iter().map(|object| object.state.clone()).collect(),
            links: None,
            pairs: Vec::new(),
            states: plant.states.clone(),
            directions: plant.directions.clone(),
            turning: plant.turning.clone(),
            fast_slips: plant.fast_slips.clone(),
            anchors: anchors.to_vec(),
            suspect: PerSole::default(),
            solution: Solution::new(&plant.problem),
        }
    }

    /// The polygons of links, if they touch, and the patches of pairs.
    pub fn polygons(&self) -> (Option<Vec<LinkPolygon>>, Vec<PairPatch>) {
        (self.links.clone(), self.pairs.clone())
    }

    /// Saves the present state.
    pub fn save(
        &mut self,
        plant: &Plant,
        anchors: &[Vec<Vector3<f64>>],
        suspect: &PerSole<u8>,
        links: Option<&LinkContacts>,
    ) {
        self.links = links.map(|links| links.present.clone());
        self.pairs = plant.pair_patches().cloned().collect();
        self.objects.iter_mut().zip(&plant.objects.list).for_each(|(to, object)| to.copy_from(&object.state));
        self.state.copy_from(&plant.state);
        self.states.clone_from(&plant.states);
        self.directions.clone_from(&plant.directions);
        self.turning.clone_from(&plant.turning);
        self.fast_slips.clone_from(&plant.fast_slips);
        anchors.clone_into(&mut self.anchors);
        self.suspect.clone_from(suspect);
        self.solution.copy_from(&plant.solution);
    }

    /// Restores the state at the plant's present time. The plant must have the saved polygons. Kinematic joints stay on their commanded
    /// motion.
    pub fn restore(&self, plant: &mut Plant, anchors: &mut [Vec<Vector3<f64>>], suspect: &mut PerSole<u8>) {
        let time = plant.state.time;
        plant.state.copy_from(&self.state);
        plant.state.time = time;
        plant.objects.list.iter_mut().zip(&self.objects).for_each(|(object, from)| object.state.copy_from(from));
        plant.objects.set_time(time);
        plant.apply_prescribed_motion();
        plant.states.clone_from(&self.states);
        copy(&mut plant.directions, &self.directions);
        plant.turning.clone_from(&self.turning);
        plant.fast_slips.clone_from(&self.fast_slips);
        copy(anchors, &self.anchors);
        suspect.clone_from(&self.suspect);
        plant.solution.copy_from(&self.solution);
        plant.problem.set_directions(&self.directions);
        plant.problem.set_turning_modes(&self.turning);
    }
}

fn copy<T: Copy>(to: &mut [Vec<T>], from: &[Vec<T>]) {
    to.iter_mut().zip(from).for_each(|(to, from)| to.copy_from_slice(from));
}
