//! Computes run keys: equal for equal runs, wherever their files are.

use crate::robot::Robot;
use crate::scenario::{CompareSpec, Run, Scenario, key};

/// Hashes the resolved scenario (seed included), the bytes of the robot's files in reading order,
/// the bytes of files that the scenario names, and the program version. The robot's path and
/// repetitions for timing are excluded.
///
/// # Errors
/// The scenario cannot be written as TOML.
pub(in crate::batch) fn of(run: &Run, robot: &Robot) -> Result<String, toml::ser::Error> {
    let mut scenario: Scenario = run.scenario.clone();
    scenario.robot.model.clear();
    let compare = scenario.compare.take().map(|compare| CompareSpec { timing_repeats: None, ..compare });
    scenario.compare = compare.filter(|compare| *compare != CompareSpec::default());
    let text = toml::to_string(&scenario)?;
    let labels: Vec<String> = (0..robot.files.len()).map(|i| format!("robot file {i}")).collect();
    let files = labels.iter().zip(&robot.files).map(|(label, (_, bytes))| (label.as_str(), bytes.as_slice()));
    let own = [("scenario", text.as_bytes()), ("program", env!("CARGO_PKG_VERSION").as_bytes())];
    let inputs = run.inputs.iter().map(|input| (input.key.as_str(), &*input.bytes));
    Ok(key(&own.into_iter().chain(files).chain(inputs).collect::<Vec<_>>()))
}
