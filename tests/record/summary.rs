//! Tests of `summary.csv` and `summary.parquet`, read back, and of the printed tables.

use super::run::record;
use polars::prelude::{AnyValue, DataFrame, DataType};
use polars_io::SerReader;
use polars_io::csv::read::CsvReadOptions;
use polars_io::parquet::read::ParquetReader;
use std::fs::File;
use stiction::results::{
    Comparison, ListedVerdicts, NUMERIC_COLUMNS, ParamValue, SummaryRow, Verdict, endings, metric, table, verdicts,
    write_summary,
};
use stiction::sim::Outcome;

/// The documented columns, copied from the description for users.
const BEFORE: &str = "scenario, key, outcome, message, method, integrator, seed";
const AFTER: &str = "duration_s, wall_s, cpu_s, real_time_factor, steps, rejected_steps, evaluations, events, \
    state_changes, states_tested_mean, states_tested_max, full_searches, impacts, jams, sliding_mode_s, inconsistent, final_base_x, \
    final_base_y, \
    final_base_z, final_base_roll, final_base_pitch, final_base_yaw, final_base_vx, final_base_vy, final_base_vz, \
    max_penetration_m, max_static_creep_m, max_lift_m, max_cone_excess, energy_error_J, error_position_rms_m, \
    error_joint_rms_rad, error_force_rms_N, contact_state_agreement, first_touchdown_s, first_liftoff_s, \
    first_slip_s, first_stick_s, first_fall_s, max_projection_m, rms_penetration_m, max_tension_N, rms_tension_N, max_signorini_Nm, rms_signorini_Nm, rms_cone_excess_N, max_dissipation_gap_W, rms_dissipation_gap_W, max_creep_speed_m_per_s, rms_creep_speed_m_per_s, max_resultant_gap_N, force_flickers, max_energy_error_J, rms_energy_error_J, energy_change_J, actuator_work_J, external_work_J, joint_loss_J, friction_loss_J, impact_loss_J, final_base_wx_rad_s, final_base_wy_rad_s, final_base_wz_rad_s, final_com_x_m, final_com_y_m, final_com_z_m, final_com_vx_m_s, final_com_vy_m_s, final_com_vz_m_s, final_base_shift_m, final_base_sideways_m, final_normal_force_N, final_cop_offset_m, first_tip_s, last_impact_s, first_impact_speed_ratio, max_flight_path_drift_m, max_flight_spin_drift_Nms, final_object_shift_m, final_object_turn_rad, final_object_speed_m_per_s, max_loop_error_m, max_estimate_error_m, max_estimate_error_rad, final_estimate_error_m, final_estimate_error_rad, min_self_distance_m, self_collisions, self_near_s, avoidance_cycles, avoidance_early_cycles, avoidance_blocked_cycles, avoidance_tests_mean, avoidance_tests_max, avoidance_held_share, avoidance_rms_deviation, avoidance_max_deviation, error_final_position_m, error_final_rotation_rad, error_object_position_rms_m, error_object_joint_rms_rad, error_final_object_position_m, \
    timing_wall_min_s, timing_wall_median_s, timing_cpu_min_s, timing_cpu_median_s, avoidance_cpu_s, avoidance_cycles_cpu_s";

/// Columns of truths that some rows have.
const TRUTHS: [&str; 2] = ["error_final_base_x", "error_first_slip_s"];

fn row(parameters: &[(&str, ParamValue)]) -> SummaryRow {
    let parameters = parameters.iter().map(|(n, v)| ((*n).to_owned(), v.clone())).collect();
    SummaryRow { parameters, ..record().summary_row() }
}

/// Three rows with different parameters: whole numbers, mixed numbers, numbers and text.
fn rows() -> Vec<SummaryRow> {
    let mut last = row(&[("n", 3.into()), ("mu", 1.into()), ("contact.method", "one-step".into())]);
    last.outcome = Outcome::Passed;
    last.message.clear();
    last.metrics.selections = 0;
    last.comparison = Comparison::default();
    last.metrics.first_liftoff_s = Some(0.1 + 0.2);
    last.metrics.final_base_position[2] = f64::NAN;
    vec![
        row(&[("mu", 0.3.into()), ("n", 1.into())]),
        row(&[("mu", (0.1 + 0.2).into()), ("step", 1e-3.into()), ("contact.method", 2.5.into())]),
        last,
    ]
}

/// Both files as tables, and the text of the CSV file.
fn written(rows: &[SummaryRow]) -> (DataFrame, DataFrame, String) {
    let folder = tempfile::tempdir().unwrap();
    let files = write_summary(&folder.path().join("results"), rows).unwrap();
    assert_eq!(std::fs::read_dir(folder.path().join("results")).unwrap().count(), 2, "no other files");
    let text = std::fs::read_to_string(&files.csv).unwrap();
    let csv = CsvReadOptions::default()
        // Reads cells as text; `number` parses them independently of the writer's library.
        .with_infer_schema_length(Some(0))
        .try_into_reader_with_file_path(Some(files.csv))
        .unwrap()
        .finish()
        .unwrap();
    (csv, ParquetReader::new(File::open(files.parquet).unwrap()).finish().unwrap(), text)
}

fn names(frame: &DataFrame) -> Vec<String> {
    frame.get_column_names().into_iter().map(ToString::to_string).collect()
}

/// A cell as a number; `None` when empty.
fn number(frame: &DataFrame, column: &str, row: usize) -> Option<f64> {
    match frame.column(column).unwrap().get(row).unwrap() {
        AnyValue::Null => None,
        AnyValue::Float64(x) => Some(x),
        AnyValue::UInt64(n) => Some(n as f64),
        AnyValue::Int64(n) => Some(n as f64),
        AnyValue::String(text) => Some(text.parse().unwrap()),
        other => panic!("{column} is not a number: {other:?}"),
    }
}

#[test]
fn columns_and_their_order_are_as_documented() {
    let (csv, parquet, _) = written(&rows());
    let expected: Vec<&str> = BEFORE
        .split(", ")
        .chain(["mu", "n", "step", "contact.method"])
        .chain(AFTER.split(", "))
        .chain(TRUTHS)
        .collect();
    assert_eq!(names(&csv), expected);
    assert_eq!(names(&parquet), expected);
    assert_eq!(NUMERIC_COLUMNS.to_vec(), AFTER.split(", ").collect::<Vec<_>>());
}

#[test]
fn the_results_page_lists_the_columns() {
    let page = std::fs::read_to_string("docs/results.md").unwrap();
    let table = stiction::metrics::column_reference();
    assert!(page.contains(&table), "docs/results.md shall contain this table:\n{table}");
}

#[test]
fn numbers_read_back_to_the_last_bit_from_both_files() {
    let rows = rows();
    let (csv, parquet, _) = written(&rows);
    for (i, row) in rows.iter().enumerate() {
        for column in NUMERIC_COLUMNS.into_iter().chain(TRUTHS) {
            let expected = metric(row, column).map(f64::to_bits);
            assert_eq!(number(&parquet, column, i).map(f64::to_bits), expected, "parquet {column} {i}");
            // Text keeps every value exactly, except for the bits of a NaN.
            let found = number(&csv, column, i);
            let same = found.map(f64::to_bits) == expected || found.is_some_and(f64::is_nan);
            assert!(same, "csv {column} {i}: {found:?}");
        }
        assert_eq!(parquet.column("seed").unwrap().get(i).unwrap(), AnyValue::UInt64(row.seed));
    }
    assert_eq!(number(&parquet, "energy_error_J", 0), Some(-4.900_000_000_000_001));
    assert_eq!(parquet.column("steps").unwrap().get(0).unwrap(), AnyValue::UInt64(u64::MAX));
}

#[test]
fn unmeasured_cells_are_empty() {
    let (csv, parquet, text) = written(&rows());
    for frame in [&csv, &parquet] {
        assert_eq!(frame.column("first_stick_s").unwrap().null_count(), 3);
        assert_eq!(frame.column("error_position_rms_m").unwrap().null_count(), 1, "no reference");
        assert_eq!(frame.column("error_joint_rms_rad").unwrap().null_count(), 3);
        assert_eq!(frame.column("error_final_base_x").unwrap().null_count(), 1, "a truth of other rows only");
        assert_eq!(number(frame, "first_liftoff_s", 0), None);
        assert_eq!(number(frame, "first_liftoff_s", 2), Some(0.1 + 0.2));
        assert_eq!(number(frame, "first_slip_s", 0), Some(0.0), "zero is a time, not a missing value");
        assert_eq!(number(frame, "states_tested_mean", 0), Some(10.0 / 3.0));
        assert_eq!(number(frame, "states_tested_mean", 2), None, "no selection, no mean");
    }
    let empty = ",,,,,0.04999999999999999,0.30000000000000004,0.0,,0.14285714285714285,1e-13,";
    assert!(text.lines().last().unwrap().contains(empty), "{text}");
    assert!(
        text.lines()
            .last()
            .unwrap()
            .contains(",,,,,0.04999999999999999,0.30000000000000004,0.0,,0.14285714285714285,1e-13,"),
        "{text}"
    );
}

#[test]
fn parameters_are_a_union_typed_by_their_values() {
    let (_, parquet, _) = written(&rows());
    let column = |name: &str| parquet.column(name).unwrap().clone();
    assert_eq!(*column("n").dtype(), DataType::Int64);
    assert_eq!(column("n").get(1).unwrap(), AnyValue::Null);
    assert_eq!(*column("mu").dtype(), DataType::Float64);
    assert_eq!(column("mu").get(1).unwrap(), AnyValue::Float64(0.1 + 0.2));
    assert_eq!(column("mu").get(2).unwrap(), AnyValue::Float64(1.0));
    assert_eq!(column("step").null_count(), 2);
    let mixed = column("contact.method");
    assert_eq!(mixed.str().unwrap().iter().collect::<Vec<_>>(), [None, Some("2.5"), Some("one-step")]);
}

#[test]
fn text_with_commas_and_quotes_stays_on_one_line_per_run() {
    let (csv, parquet, text) = written(&rows());
    for frame in [&csv, &parquet] {
        let messages = frame.column("message").unwrap().str().unwrap();
        assert_eq!(messages.get(0), Some("base below 0.2 m at 1.5 s, \"left\" foot first"));
        assert_eq!(messages.get(2), None, "no message");
        let outcomes = frame.column("outcome").unwrap().str().unwrap();
        assert_eq!(outcomes.iter().flatten().collect::<Vec<_>>(), ["fallen", "fallen", "passed"]);
    }
    assert_eq!(text.lines().count(), 4, "{text}");
    assert!(text.lines().last().unwrap().starts_with("push,0123abcd,passed,,exact,"), "{text}");
}

#[test]
fn a_summary_replaces_the_last_one_and_may_be_empty() {
    let folder = tempfile::tempdir().unwrap();
    write_summary(folder.path(), &rows()).unwrap();
    let files = write_summary(folder.path(), &[]).unwrap();
    assert_eq!(std::fs::read_to_string(files.csv).unwrap(), format!("{BEFORE}, {AFTER}\n").replace(", ", ","));
}

#[test]
fn a_parameter_named_like_a_column_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let error = write_summary(folder.path(), &[row(&[("steps", 1.into())])]).unwrap_err();
    assert!(error.to_string().contains("steps"), "{error}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn every_column_has_its_own_metric() {
    let expected = [
        ("duration_s", Some(0.1 + 0.2)),
        ("wall_s", Some(0.7)),
        ("cpu_s", Some(0.1 + 0.7)),
        ("real_time_factor", Some((0.1 + 0.2) / 0.7)),
        ("steps", Some(u64::MAX as f64)),
        ("rejected_steps", Some(2.0)),
        ("evaluations", Some(3.0)),
        ("events", Some(4.0)),
        ("state_changes", Some(5.0)),
        ("states_tested_mean", Some(10.0 / 3.0)),
        ("states_tested_max", Some(7.0)),
        ("full_searches", Some(1.0)),
        ("impacts", Some(8.0)),
        ("jams", Some(9.0)),
        ("sliding_mode_s", Some(0.25)),
        ("inconsistent", Some(11.0)),
        ("final_base_x", Some(1.0 / 3.0)),
        ("final_base_y", Some(-2e-308)),
        ("final_base_z", Some(1e300)),
        ("final_base_roll", Some(5e-324)),
        ("final_base_pitch", Some(-0.0)),
        ("final_base_yaw", Some(std::f64::consts::PI)),
        ("final_base_vx", Some(f64::MAX)),
        ("final_base_vy", Some(f64::MIN_POSITIVE)),
        ("final_base_vz", Some(123_456_789.123_456_79)),
        ("max_penetration_m", Some(1.1e-7)),
        ("max_static_creep_m", Some(2.2e-16)),
        ("max_lift_m", Some(0.3)),
        ("max_cone_excess", Some(1e-17)),
        ("energy_error_J", Some(-4.900_000_000_000_001)),
        ("error_position_rms_m", Some(1e-9 / 3.0)),
        ("error_joint_rms_rad", None),
        ("error_force_rms_N", Some(f64::INFINITY)),
        ("contact_state_agreement", Some(2.0 / 3.0)),
        ("first_touchdown_s", Some(0.049_999_999_999_999_99)),
        ("first_liftoff_s", None),
        ("first_slip_s", Some(0.0)),
        ("first_stick_s", None),
        ("first_fall_s", Some(1.0 / 7.0)),
        ("max_projection_m", Some(1e-13)),
        ("rms_penetration_m", Some(1.1e-09)),
        ("max_tension_N", Some(2.5e-13)),
        ("rms_tension_N", Some(0.1)),
        ("max_signorini_Nm", Some(3e-16)),
        ("rms_signorini_Nm", Some(5e-324)),
        ("rms_cone_excess_N", Some(0.7)),
        ("max_dissipation_gap_W", Some(0.3333333333333333)),
        ("rms_dissipation_gap_W", Some(1e-17)),
        ("max_creep_speed_m_per_s", Some(2e-12)),
        ("rms_creep_speed_m_per_s", Some(1e-15)),
        ("max_resultant_gap_N", Some(4e-14)),
        ("force_flickers", Some(12.0)),
        ("max_energy_error_J", Some(6.6e-09)),
        ("rms_energy_error_J", Some(0.3)),
        ("energy_change_J", Some(-4.9)),
        ("actuator_work_J", Some(0.12345678901234568)),
        ("external_work_J", Some(1e-300)),
        ("joint_loss_J", Some(0.2)),
        ("friction_loss_J", Some(4.905)),
        ("impact_loss_J", Some(0.6)),
        ("final_base_wx_rad_s", Some(0.7)),
        ("final_base_wy_rad_s", Some(-1e-9)),
        ("final_base_wz_rad_s", Some(6.25)),
        ("final_com_x_m", Some(1e-3)),
        ("final_com_y_m", Some(-2.5)),
        ("final_com_z_m", Some(0.3)),
        ("final_com_vx_m_s", Some(4e5)),
        ("final_com_vy_m_s", Some(-0.01)),
        ("final_com_vz_m_s", Some(9.81)),
        ("final_base_shift_m", Some(0.2)),
        ("final_base_sideways_m", Some(6e-3)),
        ("final_normal_force_N", None),
        ("final_cop_offset_m", Some(f64::INFINITY)),
        ("first_tip_s", Some(2.5)),
        ("last_impact_s", None),
        ("first_impact_speed_ratio", Some(0.75)),
        ("max_flight_path_drift_m", Some(3e-12)),
        ("max_flight_spin_drift_Nms", Some(4e-13)),
        ("final_object_shift_m", Some(0.3)),
        ("final_object_turn_rad", Some(0.4)),
        ("final_object_speed_m_per_s", None),
        ("max_loop_error_m", Some(1e-15)),
        ("max_estimate_error_m", Some(0.002)),
        ("max_estimate_error_rad", None),
        ("final_estimate_error_m", Some(1e-3)),
        ("final_estimate_error_rad", Some(0.004)),
        ("min_self_distance_m", Some(-0.011)),
        ("self_collisions", Some(13.0)),
        ("self_near_s", Some(0.17)),
        ("avoidance_cycles", Some(14.0)),
        ("avoidance_early_cycles", Some(15.0)),
        ("avoidance_blocked_cycles", Some(16.0)),
        ("avoidance_tests_mean", Some(1.7)),
        ("avoidance_tests_max", Some(18.0)),
        ("avoidance_held_share", Some(0.19)),
        ("avoidance_rms_deviation", Some(0.021)),
        ("avoidance_max_deviation", Some(0.22)),
        ("error_final_position_m", Some(4e-10)),
        ("error_final_rotation_rad", Some(5e-324)),
        ("error_object_position_rms_m", Some(1e-3)),
        ("error_object_joint_rms_rad", None),
        ("error_final_object_position_m", Some(2e-3)),
        ("timing_wall_min_s", Some(0.3)),
        ("timing_wall_median_s", Some(0.31)),
        ("timing_cpu_min_s", Some(0.2)),
        ("timing_cpu_median_s", Some(0.1 + 0.11)),
        ("avoidance_cpu_s", Some(0.015)),
        ("avoidance_cycles_cpu_s", Some(0.005)),
    ];
    let found = NUMERIC_COLUMNS.map(|column| (column, metric(&rows()[0], column)));
    assert_eq!(found, expected);
    // Two times that are missing above must not be exchanged.
    let mut row = rows().remove(0);
    row.metrics.first_stick_s = Some(0.25);
    assert_eq!((metric(&row, "first_stick_s"), metric(&row, "first_liftoff_s")), (Some(0.25), None));
    for name in ["scenario", "seed", "nonsense"] {
        assert_eq!(metric(&row, name), None);
    }
}

#[test]
fn the_table_is_aligned_and_lists_failures() {
    let text = table(&rows(), 160) + &endings(&rows(), true);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 6, "header, three runs, two reasons\n{text}");
    assert_eq!(endings(&rows(), false), "", "a fall that no expectation excludes is no failure");
    let end = |line: &str, cell: &str| line.find(cell).map(|at| line[..at].chars().count() + cell.len());
    assert_eq!(end(lines[0], "wall s"), end(lines[1], "0.700"));
    assert_eq!(lines[0].find("mu"), lines[1].find("0.3"));
    assert_eq!(lines[0].find("outcome"), lines[3].find("passed"));
    assert!(lines[3].contains("one-step"));
    assert_eq!(lines[4], "fallen push 0123abcd (mu=0.3 n=1): base below 0.2 m at 1.5 s, \"left\" foot first");
    assert!(lines.iter().all(|l| !l.ends_with(' ')));
    // A narrow table has one column for all parameters, and clips names.
    let narrow = table(&rows(), 72);
    assert!(narrow.lines().all(|line| line.chars().count() <= 72), "{narrow}");
    assert!(narrow.contains("paramet…") && narrow.contains("0.700"), "{narrow}");
}

#[test]
fn scenarios_with_different_parameters_have_separate_tables() {
    let mut other = row(&[("force.0.force", "[1, 0, 0]".into()), ("expect.0.value", 0.25.into())]);
    other.scenario = "pull".into();
    let text = table(&[row(&[("mu", 0.3.into())]), row(&[("n", 1.into())]), other], 200);
    let headers: Vec<&str> = text.lines().filter(|l| l.starts_with("scenario")).collect();
    assert_eq!(headers.len(), 2, "{text}");
    assert!(headers[0].contains("mu") && headers[0].contains(" n ") && !headers[0].contains("force"), "{text}");
    assert!(headers[1].contains("force.0.force") && !headers[1].contains("mu"), "{text}");
    assert!(!text.contains("expect.0.value"), "it is in the table of verdicts: {text}");
}

#[test]
fn verdicts_name_their_run_briefly() {
    let shown = |parameters: &[(&str, ParamValue)]| {
        let text = verdicts(&[row(parameters)], ListedVerdicts::All, 120);
        text.lines().nth(1).unwrap().strip_prefix("push ").unwrap().to_owned()
    };
    let robot = ("robot.model", "../../robots/block/block.toml".into());
    assert_eq!(shown(&[robot, ("expect.0.value", 0.5.into())]), "model=block.toml");
    assert_eq!(shown(&[("robot.velocity.knee", "30 deg/s".into())]), "knee=30 deg/s");
    assert_eq!(shown(&[("force.0.force.2", 2.into()), ("force.1.force", 3.into())]), "force.2=2 force=3");
}

#[test]
fn verdicts_show_measured_and_expected_value_and_error() {
    let rows =
        [row(&[("robot.base.rpy", "[0, 0, 1]".into()), ("floor.rpy", 2.into()), ("floor.friction", 0.5.into())])];
    let cells = |shown: ListedVerdicts| -> Vec<Vec<String>> {
        let text = verdicts(&rows, shown, 100);
        assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
        text.lines()
            .map(|l| l.split("  ").map(str::trim).filter(|w| !w.is_empty()).map(str::to_owned).collect())
            .collect()
    };
    let value = cells(ListedVerdicts::Values);
    // Names with the same last part are written in full, and the run is named once.
    assert_eq!(value[1], ["push robot.base.rpy=[0, 0, 1] floor.rpy=2 friction=0…"]);
    assert_eq!(value[2], ["final_base_x", "0.333333", "0.3", "3.3e-2", "1.1e-1", "1.0e-1", "yes"]);
    assert_eq!(value[3], ["final_cop_offset_m", "inf", "<= 1e-9", "inf", "-", "-", "NO"]);
    assert_eq!(value[4], ["first_stick_s", "-", ">= 0.5", "-", "-", "-", "NO"]);
    assert_eq!(value[5], ["1 of 3 expectations held"]);
    let failed = cells(ListedVerdicts::Failed);
    assert_eq!(failed[1..3], [value[1].clone(), value[3].clone()]);
    assert_eq!(failed[4], ["1 of 3 expectations held; 1 not shown here, see --verdicts"]);
    assert_eq!(cells(ListedVerdicts::All), value);
    // An error far below the value is visible in it.
    let mut close = rows[0].clone();
    let near = Verdict { measured: Some(0.3 + 1e-9), error: Some(1e-9), held: false, ..close.verdicts[0].clone() };
    close.verdicts = vec![near];
    let text = verdicts(&[close], ListedVerdicts::Failed, 100);
    assert!(text.contains(" 0.300000001 ") && text.contains(" 0.3 "), "{text}");
    assert_eq!(
        verdicts(&[SummaryRow { verdicts: Vec::new(), ..rows[0].clone() }], ListedVerdicts::All, 100),
        "",
        "no expectations"
    );
}
