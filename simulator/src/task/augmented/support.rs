//! Support polygon and point of optimal stability.

use super::AugmentedData;
use crate::geometry::{Plane, convex_hull, stable_point};

impl AugmentedData {
    /// Needs the contact points.
    pub(super) fn find_support(&mut self, floor: &Plane) {
        self.support_polygon.clear();
        self.support_polygon.extend(self.contacts.iter().map(|c| floor.project(&c.position)));
        convex_hull(&mut self.support_polygon, floor);
    }

    /// Needs the support polygon.
    pub(super) fn find_stable_point(&mut self, floor: &Plane) {
        let found = stable_point(self.support_polygon.iter().map(|p| floor.flat(p)), &mut self.edges);
        self.stable_point = found.map(|f| floor.world(&f.point));
        self.stable_radius = found.map_or(0.0, |f| f.radius);
    }
}
