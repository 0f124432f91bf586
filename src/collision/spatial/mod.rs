//! The robot as convex bodies, and which pairs of them can meet.

mod body;
mod inner;
mod model;
mod oriented_box;
mod paths;
mod polytope;
mod reach;
mod tessellate;

pub use body::{Body, DroppedBody, WhyBody};
pub use model::{CollisionModel, DroppedPair, Pair, WhyPair};
pub use oriented_box::OrientedBox;
pub use polytope::Polytope;
pub use reach::Search;
