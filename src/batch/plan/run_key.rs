//! Run keys: equal for equal runs, wherever their files lie.

use crate::robot::Robot;
use crate::scenario::{CompareSpec, Run, Scenario, key};

/// The key of a run with its robot: resolved scenario (seed included), bytes of the robot's files in the order in which
/// they are read, bytes of the files that the scenario names, version of this program. The robot's path and repetitions for timing are no part of it.
///
/// # Errors
/// The scenario cannot be written as TOML, in words.
pub(in crate::batch) fn of(run: &Run, robot: &Robot) -> Result<String, String> {
    let mut scenario: Scenario = run.scenario.clone();
    scenario.robot.model.clear();
    let compare = scenario.compare.take().map(|compare| CompareSpec { timing_repeats: None, ..compare });
    scenario.compare = compare.filter(|compare| *compare != CompareSpec::default());
    let text = toml::to_string(&scenario).map_err(|e| format!("the scenario cannot be written out: {e}"))?;
    let labels: Vec<String> = (0..robot.files.len()).map(|i| format!("robot file {i}")).collect();
    let files = labels.iter().zip(&robot.files).map(|(label, (_, bytes))| (label.as_str(), bytes.as_slice()));
    let own = [("scenario", text.as_bytes()), ("program", env!("CARGO_PKG_VERSION").as_bytes())];
    let inputs = run.inputs.iter().map(|input| (input.key.as_str(), &*input.bytes));
    Ok(key(&own.into_iter().chain(files).chain(inputs).collect::<Vec<_>>()))
}
