//! Placements of the bodies of a plant, one for each link that carries bodies.
//!
//! A link may carry many bodies, and terrain has many pieces: bodies with one host share a placement.

use crate::patches::Placement;
use crate::sim::bodies::Body;
use crate::sim::plant::Plant;
use std::ops::Index;

/// Placements of bodies, by the index of the body.
#[derive(Clone, Default)]
pub struct Placements {
    /// One for each host.
    of_hosts: Vec<Placement>,
    /// Indices of the placements of the bodies.
    of_bodies: Vec<usize>,
    /// Links that carry bodies.
    links: Vec<Carried>,
    /// Indices of the placements of other hosts.
    fixed: Vec<usize>,
}

/// The bodies of a link, of which it has at least one.
#[derive(Clone)]
struct Carried {
    bodies: Vec<usize>,
    /// Index of their placement.
    at: usize,
}

impl Placements {
    /// Computes them for the present kinematics of a plant, whose bodies may have become more.
    pub fn update(&mut self, plant: &Plant) {
        for body in self.of_bodies.len()..plant.bodies.len() {
            self.add(plant, body);
        }
        let mechanisms = plant.objects.mechanisms(&plant.ws);
        for link in &self.links {
            self.of_hosts[link.at] = plant.bodies[link.bodies[0]].placement(mechanisms);
        }
    }

    /// Adds a body at the end.
    fn add(&mut self, plant: &Plant, index: usize) {
        let body = &plant.bodies[index];
        let placement = body.placement(plant.objects.mechanisms(&plant.ws));
        let new = self.of_hosts.len();
        let at = match body.link() {
            Some(link) => match self.links.iter_mut().find(|of| plant.bodies[of.bodies[0]].link() == Some(link)) {
                Some(known) => {
                    known.bodies.push(index);
                    known.at
                }
                None => {
                    self.links.push(Carried { bodies: vec![index], at: new });
                    new
                }
            },
            None => self.fixed.iter().copied().find(|at| self.of_hosts[*at] == placement).unwrap_or(new),
        };
        if at == new {
            self.of_hosts.push(placement);
            self.fixed.extend(body.link().is_none().then_some(new));
        }
        self.of_bodies.push(at);
    }

    /// Number of bodies.
    pub fn len(&self) -> usize {
        self.of_bodies.len()
    }

    /// Copies placements of the same plant, which may have more bodies.
    pub fn copy_from(&mut self, other: &Placements) {
        if self.len() != other.len() {
            self.clone_from(other);
        }
        for link in &other.links {
            self.of_hosts[link.at] = other.of_hosts[link.at];
        }
    }

    /// Computes the bounds of the ways of the bodies that links carry, m, from the placements `start`; see
    /// [`Placement::way_from`].
    pub fn ways_from(&self, start: &Placements, bodies: &[Body], ways: &mut [f64]) {
        for link in &self.links {
            let (from, to) = (&start.of_hosts[link.at], &self.of_hosts[link.at]);
            let turn = to.turn_from(from);
            for &body in &link.bodies {
                ways[body] = to.way_with_turn(from, turn, &bodies[body].shape);
            }
        }
    }
}

impl Index<usize> for Placements {
    type Output = Placement;

    fn index(&self, body: usize) -> &Placement {
        &self.of_hosts[self.of_bodies[body]]
    }
}
