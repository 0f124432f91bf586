//! Tests that a panic ends only its own run. The program has no deliberate panic, so these
//! tests replace the function that executes a run.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use stiction::batch::{Batch, Job, Options, Plan, Progress, Report, Role, RunEnd, RunOutputs, prepare, simulate};
use stiction::log::{AttachedText, LogHeader, LogWriter, TopicGroups};
use stiction::report::batch_page;
use stiction::results::RunRecord;
use stiction::sim::{Outcome, Problems};

use super::{Place, Table};

fn plan(place: &Place, text: &str) -> Plan {
    place.block("s.toml", text);
    let set = [("duration".to_owned(), toml::Value::Float(0.1))];
    match prepare(&[place.path("s.toml")], &set, 100) {
        Ok((plan, _)) => plan,
        Err(findings) => panic!("{findings:?}"),
    }
}

fn run(place: &Place, plan: Plan, jobs: usize, body: &stiction::batch::Body<'_>) -> Report {
    let options = Options {
        output: place.path("results"),
        jobs,
        log: true,
        timeout: None,
        max_fail: None,
        slow: None,
        problems: Problems::None,
        timing: true,
        resume: false,
    };
    Batch::new(plan, options, batch_page).unwrap().run(Progress::Silent, body).unwrap()
}

/// Opens a log as a run does and then panics.
fn log_and_panic(job: &Job, log: &Path) -> RunEnd {
    let header = LogHeader {
        scenario_name: &job.run.name,
        key: &job.key,
        method: "exact",
        scenario: AttachedText { name: "s.toml", text: &job.run.resolved_toml },
        robot: None,
        urdf: AttachedText { name: "block.urdf", text: job.robot.urdf_text.as_ref().unwrap() },
        floor: Some(nalgebra::Isometry3::identity()),
        patches: &[],
        objects: &[],
        terrain: &Default::default(),
        inputs: &[],
        topics: TopicGroups::ALL,
        viewer_rate: f64::INFINITY,
    };
    let _writer = LogWriter::create(log, &job.robot.model, &header).unwrap();
    let empty: Vec<f64> = Vec::new();
    let missing = job.index + empty.len();
    RunEnd { message: format!("{}", empty[missing]), ..RunEnd::of(Outcome::Passed) }
}

#[test]
fn a_panic_is_an_outcome_with_message_and_location_and_the_others_continue() {
    let place = Place::new();
    let plan = plan(&place, "[sweep]\nrepeat = 8\n");
    let body = |job: &Job, outputs: &RunOutputs, cancel: &AtomicBool| match job.index % 4 {
        1 => log_and_panic(job, outputs.log.as_ref().unwrap()),
        _ => simulate(job, outputs, cancel),
    };
    let report = run(&place, plan, 2, &body);
    assert!(report.has_unfinished() && !report.has_failed());
    let outcomes: Vec<Outcome> = report.finished.iter().map(|f| f.row.outcome).collect();
    let broken = |i: usize| i % 4 == 1;
    for (i, outcome) in outcomes.iter().enumerate() {
        assert_eq!(*outcome, if broken(i) { Outcome::Error } else { Outcome::Passed }, "run {i}");
    }
    let row = &report.finished[5].row;
    assert!(row.message.contains("index out of bounds: the len is 0 but the index is 5"), "{}", row.message);
    assert!(row.message.contains("tests/cli/isolation.rs:"), "{}", row.message);
    // Its record contains the panic, and its log is kept.
    let folder = place.path("results/s").join(&row.key);
    let record = RunRecord::read(&folder.join("run.json")).unwrap();
    assert_eq!((record.outcome, &record.message), (Outcome::Error, &row.message));
    let log = std::fs::read(folder.join("log.mcap")).unwrap();
    assert!(mcap::Summary::read(&log).unwrap().is_some(), "the log is a complete file");
    let table: Table = place.summary("results");
    assert_eq!(table.rows.len(), 8);
    assert_eq!(table.column("final_base_x")[5], "NaN", "nothing was measured");
}

#[test]
fn rows_are_in_plan_order_regardless_of_which_run_ends_first() {
    let place = Place::new();
    let plan = plan(&place, "[sweep]\nrepeat = 6\n");
    let (sender, receiver) = std::sync::mpsc::channel::<()>();
    let (sender, receiver) = (std::sync::Mutex::new(sender), std::sync::Mutex::new(receiver));
    // The first run waits for a signal from the last, which starts after the others have ended.
    let body = |job: &Job, _: &RunOutputs, _: &AtomicBool| {
        match job.index {
            0 => receiver.lock().unwrap().recv().unwrap(),
            5 => sender.lock().unwrap().send(()).unwrap(),
            _ => {}
        }
        RunEnd::of(Outcome::Passed)
    };
    let report = run(&place, plan, 2, &body);
    let seeds: Vec<u64> = report.finished.iter().map(|f| f.row.seed).collect();
    assert_eq!(seeds, [1, 2, 3, 4, 5, 6]);
    let ended = std::fs::read_to_string(place.path("results/runs.jsonl")).unwrap();
    let seed = |line: &str| serde_json::from_str::<serde_json::Value>(line).unwrap()["seed"].as_u64().unwrap();
    let ended: Vec<u64> = ended.lines().map(seed).collect();
    assert_eq!(ended[..4], [2, 3, 4, 5], "runs.jsonl has the order in which runs ended");
    assert_eq!(ended.len(), 6);
}

#[test]
fn an_unwritable_record_is_an_error_of_its_run() {
    let place = Place::new();
    let plan = plan(&place, "[sweep]\nrepeat = 2\n");
    // A file has the path of the first run's folder.
    place.write(&format!("results/s/{}", plan.key(0)), "in the way");
    let report = run(&place, plan, 1, &simulate);
    let outcomes: Vec<Outcome> = report.finished.iter().map(|f| f.row.outcome).collect();
    assert_eq!(outcomes, [Outcome::Error, Outcome::Passed]);
    assert!(report.finished[0].files.is_empty());
}

#[test]
fn a_panic_in_a_reference_leaves_its_runs_without_comparison() {
    let place = Place::new();
    let plan = plan(&place, "[compare]\nreference = { seed = 9 }\n[sweep]\nrepeat = 6\n");
    assert_eq!(plan.references(), 1);
    let empty: Vec<f64> = Vec::new();
    let body = |job: &Job, outputs: &RunOutputs, cancel: &AtomicBool| match job.role {
        Role::Reference => RunEnd::error(format!("{}", empty[job.index])),
        Role::Run { .. } => simulate(job, outputs, cancel),
    };
    let report = run(&place, plan, 2, &body);
    assert!(report.has_unfinished() && report.not_started == 0);
    let reference = &report.references[0].row;
    assert_eq!(reference.outcome, Outcome::Error);
    assert!(reference.message.contains("tests/cli/isolation.rs:"), "{}", reference.message);
    for finished in &report.finished {
        assert_eq!((finished.row.outcome, finished.accepted), (Outcome::Passed, true));
        assert_eq!(finished.row.comparison.error_position_rms_m, None);
        assert!(finished.notes[0].starts_with("not compared: its reference "), "{:?}", finished.notes);
    }
}

#[test]
fn runs_wait_for_their_own_reference_only() {
    let place = Place::new();
    // Two groups with one reference each. The first reference ends only after a run of the second
    // group has started.
    let plan = plan(&place, "[compare]\nreference = {}\n[sweep.grid]\n\"floor.friction\" = [0.2, 0.4]\n");
    assert_eq!((plan.runs(), plan.references()), (2, 2));
    let (sender, receiver) = std::sync::mpsc::channel::<()>();
    let (sender, receiver) = (std::sync::Mutex::new(sender), std::sync::Mutex::new(receiver));
    let order = std::sync::Mutex::new(Vec::new());
    let body = |job: &Job, outputs: &RunOutputs, cancel: &AtomicBool| {
        let is_reference = job.role == Role::Reference;
        match (is_reference, job.index) {
            (true, 0) => receiver.lock().unwrap().recv().unwrap(),
            (false, 1) => sender.lock().unwrap().send(()).unwrap(),
            _ => {}
        }
        let end = simulate(job, outputs, cancel);
        order.lock().unwrap().push((is_reference, job.index));
        end
    };
    let report = run(&place, plan, 2, &body);
    assert!(report.finished.iter().all(|f| f.row.comparison.error_position_rms_m == Some(0.0)));
    let order = order.into_inner().unwrap();
    let at = |what| order.iter().position(|o| *o == what).unwrap();
    assert!(at((true, 0)) < at((false, 0)) && at((true, 1)) < at((false, 1)), "{order:?}");
}
