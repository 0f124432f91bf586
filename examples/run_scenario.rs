//! Executes every run of a scenario and prints its outcome.
//!
//!     cargo run --release --example run_scenario -- scenarios/friction-sweep.toml

use std::error::Error;
use stiction::Scenario;

pub fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).filter(|path| path.ends_with(".toml"));
    let scenario = Scenario::load(path.as_deref().unwrap_or("scenarios/friction-sweep.toml"))?;
    for run in scenario.runs()? {
        let mut simulation = run.simulation()?;
        let outcome = match simulation.run_to_end(&mut ()) {
            Ok(()) => "completed".to_owned(),
            Err(stop) => stop.to_string(),
        };
        let metrics = simulation.metrics();
        let values: Vec<String> = run.parameters.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        let ([x, y, z], changes) = (metrics.final_base_position, metrics.state_changes);
        println!("{}: {outcome}; base at ({x:.4}, {y:.4}, {z:.4}) m, {changes} contact changes", values.join(", "));
    }
    Ok(())
}
