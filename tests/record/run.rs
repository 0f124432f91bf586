//! Tests of `run.json` and `runs.jsonl`: written and read back.

use std::path::Path;
use stiction::files::RecordError;
use stiction::results::{
    Comparison, LogFingerprint, Machine, ParamValue, RUN_SCHEMA, Repeats, RunRecord, RunsLog, Timing, TruthError,
    Verdict, hash_input,
};
use stiction::sim::{AvoidanceTime, Metrics, Outcome};

/// Metrics with values that reveal any rounding.
pub fn metrics() -> Metrics {
    Metrics {
        remote_robot: false,
        duration_s: 0.1 + 0.2,
        steps: u64::MAX,
        rejected_steps: 2,
        evaluations: 3,
        events: 4,
        state_changes: 5,
        selections: 3,
        states_tested: 10,
        confirmed: 0,
        states_tested_max: 7,
        full_searches: 1,
        impacts: 8,
        jams: 9,
        sliding_mode_s: 0.25,
        inconsistent: 11,
        final_base_position: [1.0 / 3.0, -2e-308, 1e300],
        final_base_rpy: [5e-324, -0.0, std::f64::consts::PI],
        final_base_velocity: [f64::MAX, f64::MIN_POSITIVE, 123_456_789.123_456_79],
        max_penetration_m: 1.1e-7,
        max_static_creep_m: 2.2e-16,
        max_projection_m: 1e-13,
        max_lift_m: Some(0.3),
        max_cone_excess: 1e-17,
        energy_error_j: -4.900_000_000_000_001,
        first_touchdown_s: Some(0.049_999_999_999_999_99),
        first_liftoff_s: None,
        first_slip_s: Some(0.0),
        first_stick_s: None,
        first_fall_s: Some(1.0 / 7.0),
        rms_penetration_m: 1.1e-09,
        max_tension_n: 2.5e-13,
        rms_tension_n: 0.1,
        max_signorini_nm: 3e-16,
        rms_signorini_nm: 5e-324,
        rms_cone_excess_n: 0.7,
        max_dissipation_gap_w: 0.3333333333333333,
        rms_dissipation_gap_w: 1e-17,
        max_creep_speed_m_per_s: 2e-12,
        rms_creep_speed_m_per_s: 1e-15,
        max_resultant_gap_n: 4e-14,
        force_flickers: 12,
        max_energy_error_j: 6.6e-09,
        rms_energy_error_j: 0.3,
        energy_change_j: -4.9,
        actuator_work_j: 0.12345678901234568,
        external_work_j: 1e-300,
        joint_loss_j: 0.2,
        friction_loss_j: 4.905,
        impact_loss_j: 0.6,
        final_base_angular_velocity: [0.7, -1e-9, 6.25],
        final_com_position: [1e-3, -2.5, 0.3],
        final_com_velocity: [4e5, -0.01, 9.81],
        final_base_shift_m: 0.2,
        final_base_sideways_m: Some(6e-3),
        final_normal_force_n: None,
        final_cop_offset_m: Some(f64::INFINITY),
        first_tip_s: Some(2.5),
        last_impact_s: None,
        first_impact_speed_ratio: Some(0.75),
        max_flight_path_drift_m: Some(3e-12),
        max_flight_spin_drift_nms: Some(4e-13),
        final_object_shift_m: Some(0.3),
        final_object_turn_rad: Some(0.4),
        final_object_speed_m_per_s: None,
        max_loop_error_m: Some(1e-15),
        max_estimate_error_m: Some(0.002),
        max_estimate_error_rad: None,
        final_estimate_error_m: Some(1e-3),
        final_estimate_error_rad: Some(0.004),
        min_self_distance_m: Some(-0.011),
        self_collisions: Some(13),
        self_near_s: Some(0.17),
        avoidance_cycles: Some(14),
        avoidance_early_cycles: Some(15),
        avoidance_blocked_cycles: Some(16),
        avoidance_tests_mean: Some(1.7),
        avoidance_tests_max: Some(18),
        avoidance_held_share: Some(0.19),
        avoidance_rms_deviation: Some(0.021),
        avoidance_max_deviation: Some(0.22),
    }
}

/// Three verdicts: near the expected value, beyond the limit, and not measured.
pub fn verdicts() -> Vec<Verdict> {
    let near = Verdict {
        metric: "final_base_x".into(),
        measured: Some(1.0 / 3.0),
        truth: Some(0.3),
        allowed: Some(0.1),
        error: Some(1.0 / 3.0 - 0.3),
        held: true,
        ..Verdict::default()
    };
    let beyond = Verdict {
        metric: "final_cop_offset_m".into(),
        measured: Some(f64::INFINITY),
        max: Some(1e-9),
        error: Some(f64::INFINITY),
        message: "final_cop_offset_m is inf, above 0.000000001".into(),
        ..Verdict::default()
    };
    let never = Verdict { metric: "first_stick_s".into(), min: Some(0.5), ..Verdict::default() };
    vec![near, beyond, never]
}

/// One infinite error, one missing error, and two truths.
fn comparison() -> Comparison {
    Comparison {
        reference: Some("89abcdef01234567".into()),
        whole: true,
        instants: 201,
        until_s: Some(0.1 + 0.2),
        error_position_rms_m: Some(1e-9 / 3.0),
        error_joint_rms_rad: None,
        error_force_rms_n: Some(f64::INFINITY),
        contact_state_agreement: Some(2.0 / 3.0),
        error_final_position_m: Some(4e-10),
        error_final_rotation_rad: Some(5e-324),
        error_object_position_rms_m: Some(1e-3),
        error_object_joint_rms_rad: None,
        error_final_object_position_m: Some(2e-3),
        truth: vec![
            TruthError { metric: "final_base_x".into(), error: Some(0.7e-6) },
            TruthError { metric: "first_slip_s".into(), error: None },
        ],
    }
}

fn repeats() -> Repeats {
    Repeats { count: 5, wall_min_s: 0.3, wall_median_s: 0.31, cpu_min_s: 0.2, cpu_median_s: 0.1 + 0.11 }
}

pub fn record() -> RunRecord {
    RunRecord {
        schema: RUN_SCHEMA,
        scenario: "push".into(),
        key: "0123abcd".into(),
        outcome: Outcome::Fallen,
        message: "base below 0.2 m\nat 1.5 s, \"left\" foot first".into(),
        method: "exact".into(),
        integrator: "dopri5".into(),
        seed: u64::MAX,
        parameters: vec![
            ("floor.friction".into(), ParamValue::Number(0.1 + 0.2)),
            ("contact.method".into(), "exact".into()),
            ("repeat".into(), 3.into()),
            ("log.on".into(), true.into()),
        ],
        verdicts: verdicts(),
        metrics: metrics(),
        comparison: comparison(),
        notes: vec!["a note for the user".into()],
        program: "stiction 0.1.0".into(),
        inputs: vec![hash_input("block.urdf", b"abc")],
        resolved: "schema = 1\n[robot]\nmodel = \"größe.urdf\"\n".into(),
        log: Some(LogFingerprint { bytes: 3, blake3: hash_input("log.mcap", b"abc").blake3 }),
        timing: Timing {
            wall_s: 0.7,
            cpu_s: 0.1 + 0.7,
            machine: Machine::here(),
            file: None,
            build: Some("0123456789abcdef".into()),
            repeats: Some(repeats()),
            avoidance: Some(AvoidanceTime { total_s: 0.015, cycles_s: 0.005 }),
        },
    }
}

fn read_back(record: &RunRecord) -> RunRecord {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("push/0123abcd/run.json");
    record.write(&path).unwrap();
    RunRecord::read(&path).unwrap()
}

#[test]
fn a_record_reads_back_to_the_last_bit() {
    let record = record();
    let back = read_back(&record);
    assert_eq!(back, record);
    // Equality of floats does not see the sign of zero.
    assert!(back.metrics.final_base_rpy[1].is_sign_negative());
}

#[test]
fn a_record_without_comparison_omits_it_and_reads_back() {
    let mut record = RunRecord { comparison: Comparison::default(), ..record() };
    record.timing.repeats = None;
    let json = serde_json::to_value(&record).unwrap();
    assert!(json.get("comparison").is_none() && json["timing"].get("repeats").is_none(), "as older programs wrote it");
    assert_eq!(read_back(&record), record);
}

#[test]
fn every_outcome_has_a_name() {
    use Outcome::*;
    for outcome in [Passed, Failed, Fallen, Diverged, Stalled, TimedOut, Error, Cancelled] {
        assert_eq!(read_back(&RunRecord { outcome, ..record() }).outcome, outcome);
    }
}

#[test]
fn values_of_a_diverged_run_read_back() {
    let mut record = record();
    record.metrics.final_base_position = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    record.metrics.energy_error_j = f64::INFINITY;
    let back = read_back(&record).metrics;
    assert!(back.final_base_position[0].is_nan());
    assert_eq!(back.final_base_position[1..], [f64::INFINITY, f64::NEG_INFINITY]);
    assert_eq!(back.energy_error_j, f64::INFINITY);
}

#[test]
fn inputs_are_hashed_with_blake3() {
    // BLAKE3 of "abc", from the test vectors of its authors' tool.
    assert_eq!(hash_input("x", b"abc").blake3, "6437b3ac38465133ffb63b75273a8db548c558465d79db03fd359c6cd5bd9d85");
}

#[test]
fn timings_and_machine_are_separate_from_results() {
    let json: serde_json::Value = serde_json::to_value(record()).unwrap();
    let timing = json["timing"].as_object().unwrap();
    assert_eq!(timing.keys().collect::<Vec<_>>(), ["avoidance", "build", "cpu_s", "machine", "repeats", "wall_s"]);
    assert_eq!(timing["machine"]["os"], std::env::consts::OS);
    assert_eq!(json["outcome"], "fallen");
    assert_eq!(json["metrics"]["energy_error_J"], -4.900_000_000_000_001);
    assert_eq!(json["metrics"]["first_liftoff_s"], serde_json::Value::Null);
}

#[test]
fn an_invalid_record_is_refused_with_its_path() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.json");
    let refused = |text: &str| {
        std::fs::write(&path, text).unwrap();
        let error = RunRecord::read(&path).unwrap_err();
        assert!(error.to_string().contains("run.json"), "{error}");
        error
    };
    assert!(matches!(refused("{\"schema\": 2}"), RecordError::Version { found: 2, .. }));
    assert!(matches!(refused("{\"schema\": 1}"), RecordError::Json { .. }));
    assert!(matches!(refused("{"), RecordError::Json { .. }));
    let unknown = serde_json::to_string(&record()).unwrap().replace("\"fallen\"", "\"flown\"");
    assert!(refused(&unknown).to_string().contains("flown"));
    assert!(matches!(RunRecord::read(Path::new("/no/such/run.json")), Err(RecordError::Io { .. })));
}

#[test]
fn runs_jsonl_has_a_complete_line_for_every_run() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out/runs.jsonl");
    let row = record().summary_row();
    let lines = || -> Vec<serde_json::Value> {
        std::fs::read_to_string(&path).unwrap().lines().map(|l| serde_json::from_str(l).unwrap()).collect()
    };
    let log = RunsLog::append(&path).unwrap();
    log.push(&row).unwrap();
    assert_eq!(lines().len(), 1, "the line is on disk while the log is open");
    log.push(&row).unwrap();
    drop(log);
    RunsLog::append(&path).unwrap().push(&row).unwrap();
    let lines = lines();
    assert_eq!(lines.len(), 3, "a later batch appends");
    assert_eq!(lines[0]["contact.method"], "exact");
    assert_eq!(lines[0]["floor.friction"].as_f64(), Some(0.1 + 0.2));
    assert_eq!(lines[0]["seed"].as_u64(), Some(u64::MAX));
    assert_eq!(lines[0]["final_base_x"].as_f64(), Some(1.0 / 3.0));
    assert_eq!(lines[0]["first_liftoff_s"], serde_json::Value::Null);
    assert_eq!(lines[0]["error_final_base_x"].as_f64(), Some(0.7e-6));
    assert_eq!(lines[0]["error_first_slip_s"], serde_json::Value::Null);
}

#[test]
fn an_incomplete_last_line_is_removed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("runs.jsonl");
    let torn = format!("{{\"scenario\":\"{}", "x".repeat(10_000));
    for before in ["", "{\"scenario\":\"s\",\"key\":\"k\"}\n"] {
        std::fs::write(&path, format!("{before}{torn}")).unwrap();
        let log = RunsLog::append(&path).unwrap();
        log.push(&record().summary_row()).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let rest = text.strip_prefix(before).expect("whole lines stay");
        assert_eq!(rest.lines().count(), 1);
        assert!(serde_json::from_str::<serde_json::Value>(rest).is_ok(), "{rest}");
        assert_eq!(log.logged().unwrap().len(), before.lines().count() + 1);
    }
}

#[test]
fn every_changed_bit_of_a_record_is_detected() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.json");
    record().write(&path).unwrap();
    let whole = std::fs::read(&path).unwrap();
    assert_eq!(RunRecord::read(&path).unwrap(), record());
    // A change of the name of the checksum changes nothing of the record.
    let name = whole.windows(13).rposition(|window| window == b",\n  \"checksum").unwrap();
    let digits = name + ",\n  \"checksum\": \"".len();
    let mut checksums = 0;
    for at in (0..name).chain(digits..whole.len()) {
        let mut damaged = whole.clone();
        damaged[at] ^= 1 << (at % 8);
        std::fs::write(&path, &damaged).unwrap();
        let error = RunRecord::read(&path).expect_err("a damaged record");
        checksums += usize::from(matches!(error, RecordError::Checksum { .. }));
    }
    assert!(checksums > whole.len() / 8, "many changes leave valid JSON: {checksums} of {}", whole.len());
}

#[test]
fn damaged_lines_are_removed_and_their_runs_listed_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("runs.jsonl");
    let log = RunsLog::append(&path).unwrap();
    let row = |key: &str| RunRecord { key: key.into(), ..record() }.summary_row();
    ["a", "b", "c"].iter().for_each(|key| log.push(&row(key)).unwrap());
    let whole = std::fs::read_to_string(&path).unwrap();
    let lines: Vec<&str> = whole.split_inclusive('\n').collect();
    // Still a line of run `b`, with another time.
    let damaged = lines[1].replacen("\"seed\":", "\"seed\":1", 1);
    assert_ne!(damaged, lines[1]);
    std::fs::write(&path, [lines[0], &damaged, lines[2]].concat()).unwrap();
    let logged = log.logged().unwrap();
    let scenario = record().scenario;
    let found = ["a", "b", "c"].map(|key| logged.contains(&scenario, key));
    assert_eq!(found, [true, false, true]);
    assert_eq!(std::fs::read_to_string(&path).unwrap(), [lines[0], lines[2]].concat());
    log.push(&row("b")).unwrap();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), [lines[0], lines[2], lines[1]].concat());
    let refused = RunsLog::append(&path).map(|_| ()).unwrap_err();
    assert!(matches!(refused, RecordError::InUse { .. }), "the file kept its lock");
}

#[test]
fn lines_of_several_threads_are_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("runs.jsonl");
    let log = RunsLog::append(&path).unwrap();
    let names = |thread: usize| (0..200).map(move |k| format!("{thread}-{k}"));
    std::thread::scope(|scope| {
        for thread in 0..4 {
            let log = &log;
            scope.spawn(move || {
                names(thread).for_each(|key| log.push(&RunRecord { key, ..record() }.summary_row()).unwrap());
            });
        }
    });
    let whole = std::fs::read_to_string(&path).unwrap();
    let logged = log.logged().unwrap();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), whole, "no line is damaged");
    assert_eq!((whole.lines().count(), logged.len()), (800, 800));
    assert!((0..4).flat_map(names).all(|key| logged.contains(&record().scenario, &key)));
}

#[test]
fn only_one_program_at_a_time_appends() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("runs.jsonl");
    let first = RunsLog::append(&path).unwrap();
    let refused = RunsLog::append(&path).map(|_| ()).unwrap_err();
    assert!(matches!(refused, RecordError::InUse { .. }) && refused.to_string().contains("runs.jsonl"), "{refused}");
    drop(first);
    RunsLog::append(&path).unwrap();
}
