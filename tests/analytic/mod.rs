//! Contact against closed forms (`contact.md` section 13).

mod block;
mod body;
mod breakaway;
mod energy;
mod flight;
mod incline;
mod landing;
mod pendulum;
mod planar;
mod spin;
mod standing;
pub mod support;
mod tipping;
