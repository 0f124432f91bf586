//! Self-collision: distances with proofs, monitored pairs, results independent of earlier queries.

mod avoidance;
mod coherence;
mod depth;
mod distance;
mod inspect;
mod kinematics;
mod pairs;
mod random_bodies;
mod run;

use std::path::Path;

use stiction::robot::Robot;

/// CB-i as shipped.
pub fn cbi() -> Robot {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/cbi/cbi.toml");
    stiction::robot::load(&path).expect("our own robot")
}
