//! Steps a humanoid that is pushed, and reads its motion, contact states and forces during the run.
//!
//!     cargo run --release --example step_and_read

use std::error::Error;
use stiction::Scenario;

pub fn main() -> Result<(), Box<dyn Error>> {
    let scenario = Scenario::load("scenarios/hoap2-pushed.toml")?.set("duration", 2.0);
    let run = scenario.runs()?.remove(0);
    let mut simulation = run.simulation()?;
    for tenth in 1..=20 {
        simulation.advance_to(0.1 * f64::from(tenth), &mut ())?;
        // A snapshot has the content of a log at one instant; world axes, SI units.
        let snapshot = simulation.snapshot();
        let states: Vec<String> = simulation.contact_states().map(|state| state.to_string()).collect();
        let normal: f64 = snapshot.soles.iter().flat_map(|sole| &sole.forces).map(|force| force.z).sum();
        println!(
            "{:.3} s: centre of mass {:.4} m high, {}, {normal:.2} N",
            simulation.time(),
            snapshot.com.z,
            states.join(" and "),
        );
    }
    simulation.run_to_end(&mut ())?;
    println!("largest excess over the friction cone: {:e}", simulation.metrics().max_cone_excess);
    Ok(())
}
