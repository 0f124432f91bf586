//! The friction region of one vertex, with a border that widens while the vertex chatters over it.
//!
//! Regions are held while a step is integrated, so that its equations are smooth. A clamped vertex
//! that slides over a border changes its region at an event, when it is the border's width beyond
//! the border. A vertex on a border, or sliding along it, thus keeps its region despite rounding.

use super::friction_regions::RegionId;

/// A vertex that crosses a border back and forth within this time chatters, s.
const CHATTER: f64 = 1e-3;
/// Chattering makes a border ten times as wide each time, up to this factor: a micrometre. Friction
/// that drives a vertex to a border from both sides then costs some hundred events per second, not
/// an unbounded number.
const WIDEST: f64 = 1e6;

/// The region of one vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VertexRegion {
    /// The region whose friction the vertex has.
    pub region: RegionId,
    /// The region before it.
    before: RegionId,
    /// When the region last changed, s.
    changed: f64,
    /// Distance beyond the border that counts as crossed, in widths of the border.
    pub widths: f64,
}

impl VertexRegion {
    /// A vertex in a region, without history.
    pub fn new(region: RegionId) -> Self {
        VertexRegion { region, before: region, changed: f64::NEG_INFINITY, widths: 1.0 }
    }

    /// Enters a region at a time, s.
    pub fn enter(&mut self, region: RegionId, time: f64) {
        let chatters = region == self.before && time - self.changed < CHATTER;
        self.widths = if chatters { (10.0 * self.widths).min(WIDEST) } else { 1.0 };
        (self.before, self.region, self.changed) = (self.region, region, time);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chattering_widens_the_border_and_a_single_crossing_does_not() {
        let mut vertex = VertexRegion { region: Some(0), before: Some(0), changed: f64::NEG_INFINITY, widths: 1.0 };
        for k in 0..20 {
            vertex.enter(if k % 2 == 0 { None } else { Some(0) }, 1e-5 * f64::from(k));
        }
        assert_eq!(vertex.widths, WIDEST);
        // A later crossing, or one into another region, restores the narrow border.
        vertex.enter(None, 1.0);
        assert_eq!(vertex.widths, 1.0);
        vertex.enter(Some(1), 1.0 + 1e-5);
        assert_eq!(vertex.widths, 1.0);
    }
}
