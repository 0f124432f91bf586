//! Which friction each vertex has: that of the zone of the floor it is in (see [`super::patch`]).
//!
//! Zones are held while a step is integrated, so that its equations are smooth; a clamped vertex that slides over a
//! border changes its zone at an event. It must be the border's width beyond it for that, so that one which lies on
//! a border, or slides along it, keeps its zone whatever rounding says.

use super::error::Stop;
use super::patch::{Zone, border_width};
use super::plant::Plant;
use super::report::Observer;
use super::simulation::Simulation;
use nalgebra::Vector2;

/// A vertex that goes back and forth over a border within this time chatters, s.
const CHATTER: f64 = 1e-3;
/// Chattering makes a border ten times as wide each time, up to this factor: a micrometre. Friction that draws a vertex to a border from both
/// sides then costs some hundred events per second, not an endless number.
const WIDEST: f64 = 1e6;

/// Where one vertex is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Place {
    zone: Zone,
    before: Zone,
    /// When the zone last changed, s.
    changed: f64,
    /// How far beyond the border counts as crossed, in widths of it.
    widths: f64,
}

impl Place {
    /// In a zone, with no past.
    pub fn new(zone: Zone) -> Self {
        Place { zone, before: zone, changed: f64::NEG_INFINITY, widths: 1.0 }
    }

    fn enter(&mut self, zone: Zone, time: f64) {
        let chatters = zone == self.before && time - self.changed < CHATTER;
        self.widths = if chatters { (10.0 * self.widths).min(WIDEST) } else { 1.0 };
        (self.before, self.zone, self.changed) = (self.zone, zone, time);
    }
}

impl Plant {
    /// A vertex seen from above: world x and y, m.
    pub fn seen_from_above(&self, s: usize, i: usize) -> Vector2<f64> {
        let r = self.floor.rotation * self.problem.soles[s].vertices[i].r;
        (self.reduced.reference[s] + r).xy()
    }

    /// The zone whose friction a vertex has.
    pub fn zone(&self, s: usize, i: usize) -> Zone {
        self.places[s][i].zone
    }

    /// Positive until a vertex has left its zone, m.
    pub fn border(&self, s: usize, i: usize) -> f64 {
        let (place, p) = (&self.places[s][i], self.seen_from_above(s, i));
        self.floor.inside(place.zone, &p) + place.widths * border_width(&p)
    }

    /// Looks a vertex's friction up; true when it is another than before. What is not clamped has no past to hold on to.
    fn find_friction(&mut self, s: usize, i: usize) -> bool {
        let held = self.states[s].clamps(i, self.problem.soles[s].vertices.len());
        let p = self.seen_from_above(s, i);
        // An event ends where this is zero, but for rounding.
        if held && self.border(s, i) > 0.25 * border_width(&p) {
            return false;
        }
        let zone = self.floor.zone(&p);
        let place = &mut self.places[s][i];
        let changed = zone != place.zone;
        if !held {
            *place = Place::new(zone);
        } else if changed {
            place.enter(zone, self.state.time);
        }
        let v = &mut self.problem.soles[s].vertices[i];
        (v.mu_s, v.mu_k) = self.floor.friction(zone);
        changed
    }
}

impl Simulation {
    /// Gives every vertex the friction of the place where it is. Needs the vertices at the present state.
    pub(super) fn find_friction(&mut self, observer: &mut dyn Observer) -> Result<(), Stop> {
        if self.plant.floor.patches.is_empty() {
            return Ok(());
        }
        for s in 0..self.plant.problem.soles.len() {
            let k = self.plant.problem.soles[s].vertices.len();
            for i in 0..k {
                let changed = self.plant.find_friction(s, i);
                if changed && self.plant.states[s].clamps(i, k) {
                    let sole = self.plant.model.soles[s].name.clone();
                    let onto = self.plant.zone(s, i).map_or("the floor".to_owned(), |z| format!("patch {z}"));
                    self.event(observer, "border", &sole, &format!("vertex {i} onto {onto}"))?;
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chattering_widens_the_border_and_a_passage_does_not() {
        let mut place = Place { zone: Some(0), before: Some(0), changed: f64::NEG_INFINITY, widths: 1.0 };
        for k in 0..20 {
            place.enter(if k % 2 == 0 { None } else { Some(0) }, 1e-5 * f64::from(k));
        }
        assert_eq!(place.widths, WIDEST);
        // Later, or on to somewhere else: as narrow as ever.
        place.enter(None, 1.0);
        assert_eq!(place.widths, 1.0);
        place.enter(Some(1), 1.0 + 1e-5);
        assert_eq!(place.widths, 1.0);
    }
}
