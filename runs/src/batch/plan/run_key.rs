//! Computes run keys: equal for equal runs, wherever their files are.
//!
//! A key hashes the resolved scenario (seed included, as JSON, which is faster to write than TOML;
//! all numbers of scenarios are finite), the bytes of the files of robot and objects in reading order,
//! the bytes of files that the scenario names, and the program version. The paths of robot and objects
//! and repetitions for timing are excluded.
//!
//! Repetitions differ in the digits of their seed alone, so their scenario is written once.

use std::sync::Arc;

use crate::files::json;
use crate::robot::Robot;
use crate::scenario::{CompareSpec, Input, KeyHasher, ObjectSpec, Run, Scenario};

/// Label of the resolved scenario among the hashed inputs.
const SCENARIO: &str = "scenario";

/// Two seeds of equal length without a common digit.
const MARKERS: [u64; 2] = [1_111_111_111_111_111_111, 2_222_222_222_222_222_222];

/// Keys of runs that differ in their seeds alone.
pub(super) struct RunKeys {
    scenario: Scenario,
    /// The text of the scenario before and after its seed; none if it is written for each run.
    parts: Option<[Vec<u8>; 2]>,
    files: Arc<HashedFiles>,
}

/// Hashes of the files of a run.
struct HashedFiles {
    robot: Arc<Robot>,
    objects: Vec<Arc<Robot>>,
    inputs: Vec<Input>,
    /// The inputs whose labels precede that of the scenario.
    before: KeyHasher,
    /// Labels and bytes of the others.
    after: Vec<(String, Arc<[u8]>)>,
}

/// The robot of a run and the models of its objects.
pub(super) type Robots<'a> = (&'a Arc<Robot>, &'a [Arc<Robot>]);

/// The files of the last run: those of the next one are mostly the same.
#[derive(Default)]
pub(super) struct LastFiles(Option<Arc<HashedFiles>>);

impl LastFiles {
    fn of(&mut self, run: &Run, robots: Robots) -> Arc<HashedFiles> {
        match &self.0 {
            Some(last) if last.are_those_of(run, robots) => last.clone(),
            _ => self.0.insert(Arc::new(HashedFiles::new(run, robots))).clone(),
        }
    }
}

impl HashedFiles {
    fn new(run: &Run, (robot, objects): Robots) -> Self {
        let files = |robot: &Robot, of: String| (0..robot.files.len()).map(move |i| format!("{of} file {i}"));
        let of_objects = run.object_models().zip(objects);
        let of_objects = of_objects.flat_map(|((o, _), object)| files(object, format!("object {o}")));
        let labels: Vec<String> = files(robot, "robot".into()).chain(of_objects).collect();
        let all_files = std::iter::once(robot).chain(objects).flat_map(|robot| &robot.files);
        let of_robots = labels.iter().zip(all_files).map(|(label, (_, bytes))| (label.as_str(), bytes.as_slice()));
        let own = [("program", env!("CARGO_PKG_VERSION").as_bytes())];
        let of_run = run.inputs.iter().map(|input| (input.key.as_str(), &*input.bytes));
        let mut all: Vec<(&str, &[u8])> = own.into_iter().chain(of_robots).chain(of_run).collect();
        all.sort_unstable();
        let (first, last) = all.split_at(all.partition_point(|(label, _)| *label < SCENARIO));
        let mut before = KeyHasher::default();
        first.iter().for_each(|(label, bytes)| before.add(label, &[bytes]));
        let after = last.iter().map(|(label, bytes)| ((*label).to_owned(), Arc::from(*bytes))).collect();
        HashedFiles { robot: robot.clone(), objects: objects.to_vec(), inputs: run.inputs.clone(), before, after }
    }

    fn are_those_of(&self, run: &Run, (robot, objects): Robots) -> bool {
        let same = |(a, b): (&Input, &Input)| a.key == b.key && Arc::ptr_eq(&a.bytes, &b.bytes);
        Arc::ptr_eq(&self.robot, robot)
            && self.objects.len() == objects.len()
            && self.objects.iter().zip(objects).all(|(a, b)| Arc::ptr_eq(a, b))
            && self.inputs.len() == run.inputs.len()
            && self.inputs.iter().zip(&run.inputs).all(same)
    }
}

impl RunKeys {
    /// Keys of a run and, if there are several, of its repetitions.
    ///
    /// # Errors
    /// The scenario cannot be written as JSON.
    pub fn new(run: &Run, robots: Robots, repetitions: usize, last: &mut LastFiles) -> Result<Self, serde_json::Error> {
        let mut scenario: Scenario = run.scenario.clone();
        scenario.robot.model.clear();
        for object in &mut scenario.object {
            if let ObjectSpec::Model(object) = object {
                // The model of a file with several is part of the key, the path is not.
                object.model = object.model.rsplit_once('#').map_or(String::new(), |(_, name)| name.to_owned());
            }
        }
        let compare = scenario.compare.take().map(|compare| CompareSpec { timing_repeats: None, ..compare });
        scenario.compare = compare.filter(|compare| *compare != CompareSpec::default());
        let parts = if repetitions > 2 { split(&scenario)? } else { None };
        Ok(RunKeys { scenario, parts, files: last.of(run, robots) })
    }

    /// The key of the run with this seed.
    ///
    /// # Errors
    /// The scenario cannot be written as JSON.
    pub fn key(&mut self, seed: u64) -> Result<u64, serde_json::Error> {
        let mut hasher = self.files.before.clone();
        match &self.parts {
            Some([before, after]) => {
                hasher.add(SCENARIO, &[before, seed.to_string().as_bytes(), after]);
            }
            None => {
                self.scenario.seed = seed;
                hasher.add(SCENARIO, &[&json::compact(self.scenario.erased())?]);
            }
        }
        self.files.after.iter().for_each(|(label, bytes)| hasher.add(label, &[bytes]));
        Ok(hasher.key())
    }
}

/// The text of a scenario before and after its seed: what two texts with different seeds share.
/// None if they differ elsewhere.
fn split(scenario: &Scenario) -> Result<Option<[Vec<u8>; 2]>, serde_json::Error> {
    let mut scenario = scenario.clone();
    let mut written = |seed: u64| {
        scenario.seed = seed;
        json::compact(scenario.erased())
    };
    let (a, b) = (written(MARKERS[0])?, written(MARKERS[1])?);
    let Some(at) = a.iter().zip(&b).position(|(a, b)| a != b) else { return Ok(None) };
    let parts = |text: &[u8], seed: u64| {
        let (before, rest) = text.split_at_checked(at)?;
        Some([before.to_vec(), rest.strip_prefix(seed.to_string().as_bytes())?.to_vec()])
    };
    Ok(parts(&a, MARKERS[0]).filter(|found| parts(&b, MARKERS[1]).as_ref() == Some(found)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_split_at_its_seed() {
        // A description that looks like the line of the seed.
        let description = r#""seed":1111111111111111111,"seed":1"#.to_owned();
        let scenario = Scenario { description, seed: 7, ..Scenario::default() };
        let [before, after] = split(&scenario).unwrap().expect("only the seed differs");
        for seed in [0, 7, 12_345, i64::MAX as u64] {
            let written = serde_json::to_string(&Scenario { seed, ..scenario.clone() }).unwrap();
            assert_eq!([&before[..], seed.to_string().as_bytes(), &after].concat(), written.as_bytes());
        }
    }
}
