//! Objects that links carry for a time.
//!
//! A held object is part of its link: `I = I_link + sum of the objects' inertias`. Attaching an
//! object that moves with the link changes no velocity, nor does release. An object with a velocity
//! of its own is caught in a perfectly plastic impact, see [`Plant::catch`]. In the energy balance
//! attachment and release count as work of external forces, and the loss of the impact as impact
//! loss.

use super::plant::Plant;
use crate::robot::{LinkId, Model, RigidInertia};
use nalgebra::Vector3;

/// An object and the time during which a link carries it.
#[derive(Clone, Debug)]
pub struct CarriedObject {
    /// Name of the link, for messages.
    pub name: String,
    /// The link that carries it.
    pub link: LinkId,
    /// Its inertia in the link's internal frame.
    pub body: RigidInertia,
    /// Velocity before it is caught, without rotation, world, m/s; none: it moves with the link.
    pub velocity: Option<Vector3<f64>>,
    /// Start, s.
    pub from: f64,
    /// End, s.
    pub to: f64,
}

/// The objects of a run and which of them are held.
pub struct CarriedObjects {
    objects: Vec<(CarriedObject, bool)>,
    /// Inertia of every link without objects.
    bare: Vec<RigidInertia>,
}

impl CarriedObjects {
    /// The objects of a run, none of them held.
    pub fn new(model: &Model, objects: Vec<CarriedObject>) -> Self {
        let bare = model.links.iter().map(|l| l.body()).collect();
        CarriedObjects { objects: objects.into_iter().map(|object| (object, false)).collect(), bare }
    }

    /// Adds objects that are not held yet.
    pub fn extend(&mut self, objects: impl Iterator<Item = CarriedObject>) {
        self.objects.extend(objects.map(|object| (object, false)));
    }

    /// Number of objects.
    pub fn count(&self) -> usize {
        self.objects.len()
    }

    /// The next object, from number `i` on, that is due at time `t`: its number, and whether it is
    /// attached (true) or released (false).
    pub fn due(&self, i: usize, t: f64) -> Option<(usize, bool)> {
        let changes = |(object, held): &(CarriedObject, bool)| match *held {
            true => (object.to <= t).then_some(false),
            false => (object.from <= t && t < object.to).then_some(true),
        };
        (i..self.objects.len()).find_map(|i| changes(&self.objects[i]).map(|attach| (i, attach)))
    }

    /// Marks object `i` as held or released. Returns it with the inertia of its link and all
    /// objects that the link then holds.
    pub fn set_held(&mut self, i: usize, held: bool) -> (CarriedObject, RigidInertia) {
        self.objects[i].1 = held;
        let object = self.objects[i].0.clone();
        let total = self.total(object.link);
        (object, total)
    }

    /// Attaches the held objects to the links of a plant whose model was replaced.
    pub fn reattach(&mut self, plant: &mut Plant) {
        self.bare.iter_mut().zip(&plant.model.links).for_each(|(bare, link)| *bare = link.body());
        for (object, _) in self.objects.iter().filter(|(_, held)| *held) {
            plant.set_body(object.link, &self.total(object.link));
        }
    }

    /// Inertia of a link with the objects it holds, summed again at each change so that a
    /// release leaves no rounding error.
    fn total(&self, link: LinkId) -> RigidInertia {
        let held = self.objects.iter().filter(|(object, held)| *held && object.link == link);
        held.fold(self.bare[link.0], |sum, (object, _)| sum.plus(&object.body))
    }
}
