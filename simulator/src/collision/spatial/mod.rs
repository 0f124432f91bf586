//! The robot as convex bodies, and the pairs of them that can meet.

mod body;
mod enclosed_bodies;
mod link_tree;
mod model;
mod oriented_box;
mod pair_search;
mod polytope;
mod tessellate;

pub use body::{Body, DroppedBody, WhyBody};
pub use model::{CollisionModel, DroppedPair, Pair, WhyPair};
pub use oriented_box::OrientedBox;
pub use pair_search::Search;
pub use polytope::Polytope;
pub use tessellate::points as shape_points;
