//! Turns the polygon of a cylinder's end towards the load, see `cylinder`.

use super::flat::Flat;
use super::{ConvexBody, Placement, RESOLUTION, Topology};
use nalgebra::Vector3;

/// The topology with rings turned towards a load at `load`, world, m, on a side of its polygon; `None` if the
/// side does not cut off a part of a rim.
pub fn turn_ring(
    topology: &Topology,
    load: &Vector3<f64>,
    (a, pa): (&ConvexBody, &Placement),
    (b, pb): (&ConvexBody, &Placement),
) -> Option<Topology> {
    let rings = Flat::new(topology, [(a, pa), (b, pb)])?.turned(topology, load)?;
    let mut turned = Topology { rings, ..topology.clone() };
    let (owner, incident) = (topology.owner, topology.incident);
    super::clipping::topology(a, pa, b, pb, RESOLUTION, owner, incident, &mut turned).then_some(turned)
}
