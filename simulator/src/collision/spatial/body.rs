//! One convex body per link: the hull of all its collision shapes, those of welded links included.

use nalgebra::Vector3;

use super::polytope::Polytope;
use super::tessellate;
use crate::robot::{Link, LinkId};

/// A link as a convex polyhedron.
#[derive(Clone, Debug)]
pub struct Body {
    /// The link that carries it.
    pub link: LinkId,
    /// The link's name.
    pub name: String,
    /// In the link's internal frame.
    pub polytope: Polytope,
}

/// A link with collision shapes that is not a body.
#[derive(Clone, PartialEq, Debug)]
pub struct DroppedBody {
    /// The link.
    pub link: LinkId,
    /// Its name.
    pub name: String,
    /// Reason.
    pub why: WhyBody,
}

/// Reason why a link is not a body.
#[derive(Clone, PartialEq, Debug)]
pub enum WhyBody {
    /// The robot file lists the bodies, without this link.
    NotListed,
    /// Its hull stays inside that of the named link, which is therefore touched first.
    Inside(String),
    /// Its shapes have no hull: they are flat, or have more than 65 535 corners.
    NoHull,
}

impl Body {
    /// The body of a link; `None` without collision shapes, an error when they have no hull.
    pub(super) fn new(link: &Link, id: LinkId, resolution: usize) -> Option<Result<Self, DroppedBody>> {
        if link.collisions.is_empty() {
            return None;
        }
        let points: Vec<Vector3<f64>> =
            link.collisions.iter().flat_map(|s| tessellate::points(s, resolution)).collect();
        let name = link.name.clone();
        Some(match Polytope::hull(&points) {
            Some(polytope) => Ok(Self { link: id, name, polytope }),
            None => Err(DroppedBody { link: id, name, why: WhyBody::NoHull }),
        })
    }
}
