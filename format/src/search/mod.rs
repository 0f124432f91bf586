//! Chooses positions of a lattice by the results at earlier ones.
//!
//! - `bisection`: where a condition changes along one key, near an expected position (`prior`).
//! - `contour`: where it changes over two keys.
//! - `evolution`: where a value is least over several keys.
//! - `method`: one of them.
//!
//! Imports: `math`, `random`. Used by: `scenario`, `batch`.

mod bisection;
mod contour;
mod evolution;
mod method;
mod prior;

pub use bisection::{Bisection, most_probes};
pub use contour::{Contour, Crossing};
pub use evolution::{Evolution, population_for};
pub use method::{Answer, Method};
pub use prior::Prior;

/// A position of a lattice: a whole number of steps along each key.
pub type Position = Vec<u64>;
