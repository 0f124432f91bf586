//! Tests of recorded contact problems: reading returns the written problem, and solving it again
//! gives the same bits.

use crate::analytic::falls;
use crate::support::runs::simulation;
use std::sync::atomic::AtomicBool;
use stiction::contact::selection_record::{SelectionRecord, SelectionResult};
use stiction::log::{MAX_PROBLEMS, ProblemRecord, ProblemWriter};
use stiction::sim::{Observer, Outcome, Problems, SimEvent, Snapshot};

/// Keeps problems as JSON text.
struct Keep(Problems, Vec<String>);

impl Observer for Keep {
    fn snapshot(&mut self, _: &Snapshot) -> Result<(), stiction::sim::ObserverError> {
        Ok(())
    }
    fn event(&mut self, _: &SimEvent) -> Result<(), stiction::sim::ObserverError> {
        Ok(())
    }
    fn problems(&self) -> Problems {
        self.0
    }
    fn problem(&mut self, record: &SelectionRecord) -> Result<(), stiction::sim::ObserverError> {
        self.1.push(serde_json::to_string(record).map_err(stiction::sim::ObserverError::new)?);
        Ok(())
    }
}

/// The problems of a run, and its counts of selections and of inconsistent ones.
fn problems(text: &str, which: Problems) -> (Vec<SelectionRecord>, u64, u64) {
    let mut keep = Keep(which, vec![]);
    let mut sim = simulation(text);
    let (outcome, message) = sim.run(&mut keep, &AtomicBool::new(false));
    assert_eq!(outcome, Outcome::Passed, "{message}");
    let read = keep.1.iter().map(|text| serde_json::from_str(text).unwrap()).collect();
    (read, sim.metrics().selections, sim.metrics().inconsistent)
}

fn json(answer: &SelectionResult) -> String {
    serde_json::to_string(answer).unwrap()
}

const DROPPED_SLIDING: &str = "
    duration = 0.6
    robot = { model = \"robots/block/block.toml\", base = { position = [0, 0, 0.08], rpy = [0.1, 0.05, 0], linear_velocity = [1, 0.3, 0], angular_velocity = [0, 0, 2] } }
    floor = { friction = { static = 0.5, kinetic = 0.4 } }
";
const HOAP2_PUSHED: &str = "
    duration = 0.25
    robot = { model = \"robots/hoap2/hoap2.toml\", base = { position = [0, 0, 0.315], linear_velocity = [0.2, 0, 0] } }
    floor = { friction = 0.4 }
    [[force]]
    type = \"push\"
    link = \"torso\"
    force = [20.0, 10.0, 0.0]
    start = 0.1
    duration = 0.1
";

#[test]
fn selecting_again_from_the_record_gives_the_same_bits() {
    let (mut total, mut velocity, mut moving, mut suspect) = (0, 0, 0, 0);
    for setting in [
        "",
        "contact = { method = \"one-step\" }",
        "integrator = { method = \"semi-implicit\", step = 2e-3 }",
        "contact = { method = \"one-step\" }\nintegrator = { method = \"semi-implicit\", step = 2e-3 }",
        "contact = { method = \"lcp\", lcp = { facets = 6 } }\nintegrator = { method = \"semi-implicit\", step = 2e-3 }",
        "contact = { method = \"ncp\", ncp = { iterations = 7 } }\nintegrator = { method = \"semi-implicit\", step = 2e-3 }",
    ] {
        for text in [DROPPED_SLIDING, HOAP2_PUSHED] {
            let (problems, selections, _) = problems(&format!("{setting}\n{text}"), Problems::All);
            assert_eq!(problems.len() as u64, selections, "{setting}");
            for record in &problems {
                let again = record.replay().unwrap();
                assert_eq!(json(&again), json(&record.answer), "{setting} at {} s", record.time_s);
                velocity += usize::from(record.units.force == "N s");
                moving += record.soles.iter().flat_map(|s| &s.vertices).filter(|v| v.moving).count();
                suspect += record.soles.iter().filter(|s| s.suspect_normal || s.suspect_friction).count();
            }
            total += problems.len();
        }
    }
    assert!(total > 500 && velocity > 50 && moving > 100 && suspect > 5, "{total} {velocity} {moving} {suspect}");
}

/// A fall of `scenarios/studies/falls.toml` in which slow motion cannot be stopped: states are chosen again for it.
#[test]
fn a_choice_for_motion_that_is_left_is_repeated_from_its_record() {
    let mut sim = falls::simulation((4, 56, 61, 0.85, "slow motion that cannot be stopped"));
    let mut keep = Keep(Problems::All, vec![]);
    assert_eq!(sim.run(&mut keep, &AtomicBool::new(false)).0, Outcome::Passed);
    let records = keep.1.iter().map(|text| serde_json::from_str::<SelectionRecord>(text).unwrap());
    let left: Vec<SelectionRecord> = records.filter(|record| !record.stops).collect();
    assert!(!left.is_empty());
    for record in left {
        assert!(record.answer.consistent);
        assert_eq!(json(&record.replay().unwrap()), json(&record.answer), "{} s", record.time_s);
        // With the motion stopped, vertices slip in other directions.
        let stopped = SelectionRecord { stops: true, ..record.clone() };
        assert_ne!(json(&stopped.replay().unwrap()), json(&record.answer), "{} s", record.time_s);
    }
}

#[test]
fn a_changed_problem_has_another_answer() {
    let (problems, ..) = problems(DROPPED_SLIDING, Problems::All);
    let mut sliding = problems.into_iter().find(|p| p.answer.states[0] == "face-dynamic").expect("it slides");
    for v in &mut sliding.soles[0].vertices {
        v.mu_k += 0.01;
    }
    assert_ne!(json(&sliding.replay().unwrap()), json(&sliding.answer));
    sliding.b.pop();
    assert_eq!(sliding.replay().unwrap_err().to_string(), "`b` has 5 numbers, expected 6");
}

/// Three corners of a block start below the floor and one above it. No state clamps exactly these
/// three, and the search of the paper, unlike the direct one, leaves nothing to velocity-level steps.
#[test]
fn the_observer_selects_inconsistent_problems() {
    let penetrating = "
        duration = 0.1
        contact.exact.search = \"paper\"
        robot = { model = \"robots/block/block.toml\", contact = \"soles\", base = { position = [0, 0, 0.049], rpy = [0.01, 0.02, 0] } }
        stop = { sunk_link = \"ignore\" }
    ";
    let (recorded, selections, inconsistent) = problems(penetrating, Problems::Inconsistent);
    assert!(inconsistent >= 1 && selections > inconsistent, "{selections} {inconsistent}");
    assert_eq!(recorded.len() as u64, inconsistent);
    for record in &recorded {
        let violations = &record.answer.violations;
        let sum = violations.geometric + violations.kinematic + violations.friction;
        assert!(!record.answer.consistent && sum > 0.0, "{:?}", record.answer);
        assert_eq!(json(&record.replay().unwrap()), json(&record.answer));
    }
    assert_eq!(problems(penetrating, Problems::None).0, []);
}

#[test]
fn files_are_numbered_limited_and_replaced_by_the_next_run() {
    let (all, ..) = problems(DROPPED_SLIDING, Problems::All);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("problems");
    let mut writer = ProblemWriter::create(path.clone(), "s", "k", Problems::All).unwrap();
    assert_eq!(writer.folder(), None, "no folder before the first problem");
    let total = MAX_PROBLEMS + 3;
    for record in all.iter().cycle().take(total) {
        writer.write(record).unwrap();
    }
    assert_eq!(std::fs::read_dir(&path).unwrap().count(), MAX_PROBLEMS);
    assert_eq!(writer.summary().unwrap(), "the first 100 of 103 selections are written, 3 more are not");
    let second = ProblemRecord::read(&path.join("0002.json")).unwrap();
    assert_eq!((second.schema, second.number, second.scenario.as_str(), second.key.as_str()), (1, 2, "s", "k"));
    assert_eq!(second.selection, all[1]);
    assert_eq!(second.program, concat!("stiction ", env!("CARGO_PKG_VERSION")));

    let other = std::fs::read_to_string(path.join("0002.json")).unwrap().replace("\"schema\":1", "\"schema\":7");
    std::fs::write(path.join("0002.json"), other).unwrap();
    let error = ProblemRecord::read(&path.join("0002.json")).unwrap_err().to_string();
    assert!(error.ends_with("0002.json: record format 7, this program reads 1"), "{error}");

    let mut writer = ProblemWriter::create(path.clone(), "s", "k", Problems::Inconsistent).unwrap();
    assert!(!path.exists(), "the problems of the previous run are deleted");
    writer.write(&all[0]).unwrap();
    assert_eq!((std::fs::read_dir(&path).unwrap().count(), writer.summary()), (1, None));
}

/// A force pulls a resting block until it slips. The selection finds the directions of slip, and
/// the recorded problem does not contain them.
#[test]
fn a_problem_is_recorded_as_before_the_selection() {
    let pulled = "
        duration = 0.4
        robot = { model = \"robots/block/block.toml\" }
        floor = { friction = 0.3 }
        [[force]]
        type = \"push\"
        link = \"block\"
        point = [0, 0, -0.04]
        force = [6.0, 3.0, 0.0]
        duration = 0.3
        profile = \"ramp\"
    ";
    let (all, ..) = problems(pulled, Problems::All);
    assert!(
        all[0].soles[0].vertices.iter().all(|v| v.last_normal == 0.0),
        "no earlier normal force before the first problem"
    );
    let onset = all.iter().find(|p| p.answer.states[0] == "face-dynamic").expect("it slips");
    assert_eq!(onset.soles[0].previous, "face-static");
    assert!(onset.soles[0].suspect_friction && !onset.soles[0].suspect_normal);
    for (v, t) in onset.soles[0].vertices.iter().zip(&onset.answer.tangent[0]) {
        assert!(!v.moving && v.direction == [0.0; 2], "{v:?}");
        assert!(t[0] < 0.0 && t[1] < 0.0, "friction opposes the incipient slip: {t:?}");
        assert!(v.last_normal > 0.0, "the normal force of the preceding state");
    }
}
