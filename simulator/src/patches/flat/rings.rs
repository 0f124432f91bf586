//! Turns of the rings of ends: towards the other region, and towards a load.

use super::{Border, ConvexBody, Flat, LEVEL, Placement, RESOLUTION, RING, Roles, Topology, shortest};
use nalgebra::Vector3;

/// Distance of a load from a crossing, m, at which it is there.
const AT_CROSSING: f64 = 1e-6;

impl Flat<'_> {
    /// Turns the rings towards the other region, so that a point of them is where the rim reaches farthest
    /// into it. Returns whether there are any.
    pub(super) fn turn_rings(&mut self) -> bool {
        let Roles { owner, owner_at, face, other, other_at, .. } = self.roles;
        let toward = |body: &ConvexBody, at: &Placement, end: u16, x: Vector3<f64>| {
            body.across(&(at.rotation.tr_mul(&(x - at.position)) - body.vertex(end))).try_normalize(LEVEL)
        };
        let mut turned = false;
        if let Some(end) = self.incident.filter(|_| other.barrel.is_some()) {
            let centre = other_at.point(other.vertex(end));
            if let Some(w) = self.nearest(&centre, true).and_then(|x| toward(other, other_at, end, x)) {
                (self.rings[1], turned) = (w, true);
            }
        }
        if owner.barrel.is_some() && self.has_inside() {
            let centre = owner_at.point(owner.vertex(face));
            if let Some(w) = self.nearest(&centre, false).and_then(|x| toward(owner, owner_at, face, x)) {
                (self.rings[0], turned) = (w, true);
            }
        }
        turned
    }

    /// The rings turned towards the load at `x`, world, m, which is on a side of the polygon between two points
    /// of a ring: `None` if no ring has such a side. In the order of the topology. A crossing is on the rim, and stays
    /// there: a point of the ring in its place would leave it.
    pub(in crate::patches) fn turned(&self, topology: &Topology, x: &Vector3<f64>) -> Option<[Vector3<f64>; 2]> {
        let Roles { owner, owner_at, face, other, other_at, is_owner_b, .. } = self.roles;
        let mut crossings = topology.corners.iter().filter(|corner| self.roles.crossing(corner).is_some());
        if crossings.any(|crossing| (self.corner(crossing).0 - x).norm() <= AT_CROSSING) {
            return None;
        }
        let toward = |body: &ConvexBody, at: &Placement, end: u16, ring: &Vector3<f64>| {
            let radius = body.barrel?;
            let across = body.across(&(at.rotation.tr_mul(&(x - at.position)) - body.vertex(end)));
            let w = across.try_normalize(0.5 * radius)?;
            let rim = body.vertex(end) + w * radius;
            let is_point = (0..RING).any(|k| (body.ring_point(end, k, ring) - rim).norm() <= RESOLUTION);
            // The sides are at R cos(pi/RING) or more from the axis.
            (across.norm() > radius * shortest() - RESOLUTION && !is_point).then_some(w)
        };
        let of_other = self.incident.and_then(|end| toward(other, other_at, end, &self.rings[1]));
        let of_owner = toward(owner, owner_at, face, &self.rings[0]).filter(|_| self.has_inside());
        if of_owner.is_none() && of_other.is_none() {
            return None;
        }
        let rings = [of_owner.unwrap_or(self.rings[0]), of_other.unwrap_or(self.rings[1])];
        Some(if is_owner_b { [rings[1], rings[0]] } else { rings })
    }

    /// Point of the border of O, or else of I, nearest to `x`.
    fn nearest(&self, x: &Vector3<f64>, of_owner: bool) -> Option<Vector3<f64>> {
        let mut best: Option<(f64, Vector3<f64>)> = None;
        self.visit_pairs(&mut |k, l| {
            let point = match if of_owner { self.owner_border(k) } else { self.other_border(l) } {
                Border::Line { start, along, length } => start + along * along.dot(&(x - start)).clamp(0.0, length),
                Border::Circle { centre, .. } => centre,
            };
            let distance = (point - x).norm();
            if best.is_none_or(|(least, _)| distance < least) {
                best = Some((distance, point));
            }
        });
        best.map(|(_, point)| point)
    }
}
