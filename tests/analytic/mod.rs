//! Contact against closed forms (`contact.md` section 13).

mod block;
pub mod body;
mod breakaway;
mod energy;
mod estimators;
mod feet;
mod flight;
mod forced;
mod hard;
mod incline;
mod jump;
mod landing;
mod one_step;
mod orders;
mod painleve;
mod pairing;
mod patches;
mod penalty;
pub mod pendulum;
pub mod planar;
mod spin;
mod stall;
mod standing;
mod stepping;
pub mod support;
mod tipping;
