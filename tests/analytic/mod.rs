//! Contact against closed forms (`contact.md` section 13).

mod block;
mod body;
mod breakaway;
mod feet;
mod flight;
mod forced;
mod hard;
mod incline;
mod jump;
mod landing;
mod painleve;
mod patches;
mod pendulum;
mod planar;
mod spin;
mod stall;
mod standing;
pub mod support;
mod tipping;
