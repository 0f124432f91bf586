//! Links that touch the floor besides the soles, each with one polygon.
//!
//! The contact problem of a run has the soles, and a polygon for each link that is near the floor:
//! a face of the link's hull with its lowest point ([`LinkHull::face`]). A polygon is kept while all
//! points near the floor belong to it. When another one arrives, at an event, the polygon becomes
//! a face that has it too. When no point is near, the polygon is removed.
//!
//! Methods that know no states, only points, get all points near the floor instead of a face.
//!
//! *Near* is, with located events, what touches, since every other point meets the floor in an event
//! of its own. In a step of size h without located events it is what may touch within the step,
//!
//! ```text
//! height <= d + 2 h (v + g h)        v: greatest speed of the link's points
//! ```

use crate::contact::methods::contact_method::Scheme;
use crate::sim::floor::LinkHull;
use crate::sim::floor::link_hull::MAX_CORNERS;
use crate::sim::plant::Plant;

/// A polygon is kept up to this multiple of the height at which it is made, so that it does not
/// come and go.
const KEPT: f64 = 2.0;

/// The polygon of a link: index of its hull, and of its corners among the points of the hull.
pub type LinkPolygon = (usize, Vec<u16>);

/// Hulls of the links that may touch, and their polygons.
#[derive(Clone)]
pub struct LinkContacts {
    pub(super) hulls: Vec<LinkHull>,
    /// Present polygons, in the order of the plant's polygons after the soles.
    pub present: Vec<LinkPolygon>,
    heights: Vec<f64>,
}

impl LinkContacts {
    /// No link touches yet.
    pub fn new(hulls: Vec<LinkHull>) -> Self {
        let most = hulls.iter().map(|hull| hull.points.len()).max().unwrap_or(0);
        LinkContacts { present: Vec::new(), heights: vec![0.0; most], hulls }
    }

    /// Number of links.
    pub fn number(&self) -> usize {
        self.hulls.len()
    }

    /// Height above the floor of the lowest point of a link that belongs to no polygon, or a lower
    /// bound for it above zero, m.
    pub fn gap(&self, plant: &Plant, h: usize) -> f64 {
        let bound = self.hulls[h].bound(&plant.ws, &plant.floor);
        if bound > 0.0 {
            return bound;
        }
        let polygon = self.present_polygon(h);
        let mut least = f64::INFINITY;
        self.hulls[h].heights(&plant.ws, &plant.floor, 0.0, |k, height| {
            if height < least && !polygon.contains(&(k as u16)) {
                least = height;
            }
        });
        least
    }

    fn present_polygon(&self, h: usize) -> &[u16] {
        self.present.iter().find(|(hull, _)| *hull == h).map_or(&[], |(_, corners)| corners)
    }

    /// The polygons of the plant's present state, if they differ from the present ones. Needs its
    /// kinematics. Allocates only if they differ.
    pub(super) fn find(&mut self, plant: &Plant, distance: f64, step: Option<f64>) -> Option<Vec<LinkPolygon>> {
        let mut changes = Vec::new();
        for h in 0..self.hulls.len() {
            match self.find_polygon(plant, h, distance, step) {
                Found::Present => {}
                Found::Away => changes.extend(self.is_present(h).then_some((h, Vec::new()))),
                Found::Corners(corners) => changes.push((h, corners)),
            }
        }
        if changes.is_empty() {
            return None;
        }
        let changed = |h: usize| changes.iter().any(|(hull, _)| *hull == h);
        let mut next: Vec<LinkPolygon> = self.present.iter().filter(|(h, _)| !changed(*h)).cloned().collect();
        next.extend(changes.into_iter().filter(|(_, corners)| !corners.is_empty()));
        next.sort_unstable_by_key(|(h, _)| *h);
        Some(next)
    }

    fn is_present(&self, h: usize) -> bool {
        self.present.iter().any(|(hull, _)| *hull == h)
    }

    fn find_polygon(&mut self, plant: &Plant, h: usize, distance: f64, step: Option<f64>) -> Found {
        let (ws, floor) = (&plant.ws, &plant.floor);
        let hull = &self.hulls[h];
        let bound = hull.bound(ws, floor);
        let way = step.map_or(0.0, |dt| 2.0 * dt * (hull.fastest(ws) + plant.gravity.norm() * dt));
        let near = distance + way;
        if bound > KEPT * near {
            return Found::Away;
        }
        let heights = &mut self.heights[..hull.points.len()];
        hull.heights(ws, floor, step.unwrap_or(0.0), |k, height| heights[k] = height);
        let by_height = |a: &(usize, &f64), b: &(usize, &f64)| a.1.total_cmp(b.1);
        let Some((lowest, &height)) = heights.iter().enumerate().min_by(by_height) else { return Found::Away };
        let present = self.present.iter().find(|(hull, _)| *hull == h).map_or(&[][..], |(_, corners)| corners);
        if height > if present.is_empty() { near } else { KEPT * near } {
            return Found::Away;
        }
        // In a step, the points that arrive within it decide; without them those that are near.
        let arrive = height <= 0.0 && step.is_some();
        let is_near = |k: u16| heights[k as usize] <= if arrive { 0.0 } else { near };
        let all = || 0..heights.len() as u16;
        if !present.is_empty() && all().all(|k| !is_near(k) || present.contains(&k)) {
            return Found::Present;
        }
        if matches!(plant.method.scheme(), Scheme::Compliant | Scheme::TimeStepping) {
            return Found::Corners(all().filter(|&k| is_near(k) || present.contains(&k)).take(MAX_CORNERS).collect());
        }
        match hull.face(lowest as u16, is_near, present, ws, floor) {
            Some(face) if face.corners == present => Found::Present,
            Some(face) => Found::Corners(face.corners.clone()),
            None => Found::Away,
        }
    }
}

/// What a link has near the floor.
enum Found {
    /// Nothing.
    Away,
    /// Its present polygon.
    Present,
    /// Another polygon.
    Corners(Vec<u16>),
}
