//! Contact against closed forms (`contact.md` section 13).

mod block;
pub mod body;
mod breakaway;
mod flight;
mod incline;
mod landing;
pub mod pendulum;
pub mod planar;
mod spin;
mod standing;
pub mod support;
mod tipping;
