//! Tests of the Pareto comparison: groups of comparable runs, the front and its table.

use super::run::record;
use proptest::prelude::*;
use stiction::results::pareto::{Group, NotComparable, Work, front, front_as_shown, groups, pareto_table};
use stiction::results::{Comparison, ParamValue, Repeats, SummaryRow, TruthError};
use stiction::sim::Outcome;

/// A run of 2 simulated seconds.
pub fn run(method: &str, parameters: &[(&str, ParamValue)], cost: f64, error: Option<f64>) -> SummaryRow {
    let mut row = record().summary_row();
    row.scenario = "work".into();
    row.outcome = Outcome::Passed;
    row.message.clear();
    row.verdicts.clear();
    row.method = method.into();
    row.integrator = if method == "exact" { "dopri5" } else { "semi-implicit" }.into();
    row.parameters = parameters.iter().map(|(n, v)| ((*n).to_owned(), v.clone())).collect();
    row.metrics.duration_s = 2.0;
    row.cpu_s = 2.0 * cost;
    row.wall_s = 3.0 * cost;
    row.real_time_factor = row.metrics.duration_s / row.wall_s;
    row.repeats = None;
    row.comparison = Comparison { error_position_rms_m: error, ..Comparison::default() };
    let plain: Vec<String> = row.parameters.iter().map(|(_, v)| v.to_string()).collect();
    row.key = format!("{method}-{}", plain.join("-"));
    row
}

fn works(rows: &[SummaryRow]) -> Vec<Work<'_>> {
    rows.iter().map(Work::of).collect()
}

/// Groups as plain data: the problem, and for each curve its name, its varied parameter and its
/// rows.
type PlainGroups = Vec<(String, Vec<(String, Option<String>, Vec<usize>)>)>;

fn plain(groups: Vec<Group>) -> PlainGroups {
    let curves = |g: &Group| g.curves.iter().map(|c| (c.name(), c.along.clone(), c.rows.clone())).collect();
    groups.iter().map(|g| (g.problem.clone(), curves(g))).collect()
}

fn curve(name: &str, along: Option<&str>, rows: &[usize]) -> (String, Option<String>, Vec<usize>) {
    (name.into(), along.map(String::from), rows.to_vec())
}

proptest! {
    /// Compares the definition with the sweep along the cost. Few different values give ties.
    #[test]
    fn no_point_dominates_the_front(points in prop::collection::vec((1_u8..8, 0_u8..8), 0..40)) {
        let points: Vec<(f64, f64)> = points.iter().map(|&(c, e)| (f64::from(c), f64::from(e))).collect();
        let dominates = |a: (f64, f64), b: (f64, f64)| a.0 <= b.0 && a.1 <= b.1 && (a.0 < b.0 || a.1 < b.1);
        let expected: Vec<bool> = points.iter().map(|&p| !points.iter().any(|&q| dominates(q, p))).collect();
        prop_assert_eq!(front(&points), expected);
    }
}

#[test]
fn nan_is_not_on_the_front() {
    let points = [(1.0, f64::NAN), (f64::NAN, 0.0), (2.0, 3.0), (0.5, f64::INFINITY), (3.0, 0.0)];
    assert_eq!(front(&points), [false, false, true, false, true]);
    assert_eq!(front(&[]), Vec::<bool>::new());
}

#[test]
fn points_equal_to_three_digits_are_equal() {
    let points = [(0.1, 1e-3), (0.2, 0.999_99e-3), (0.100_01, 1e-3), (0.3, 0.99e-3)];
    assert_eq!(front(&points), [true, true, false, true]);
    assert_eq!(front_as_shown(&points), [true, false, true, true]);
    assert_eq!(front_as_shown(&[(1.0, 0.0), (2.0, 0.0), (0.5, f64::NAN)]), [true, false, false]);
}

#[test]
fn cost_is_processor_time_per_simulated_second() {
    let mut row = run("exact", &[], 0.25, Some(1e-3));
    assert_eq!(Work::of(&row).cost, Some(0.25));
    row.repeats = Some(Repeats { count: 3, wall_min_s: 9.0, wall_median_s: 9.0, cpu_min_s: 0.2, cpu_median_s: 9.0 });
    let work = Work::of(&row);
    assert_eq!((work.cost, work.real_time_factor), (Some(0.1), 2.0 / 9.0), "the minimum of repeated times");
    row.metrics.duration_s = 0.0;
    assert_eq!(Work::of(&row).cost, None);
}

#[test]
fn errors_are_the_error_columns() {
    let mut row = run("exact", &[], 1.0, Some(1e-3));
    row.comparison.error_force_rms_n = Some(0.5);
    row.comparison.contact_state_agreement = Some(1.0);
    let truth = |metric: &str, error| TruthError { metric: metric.into(), error };
    row.comparison.truth = vec![truth("final_base_x", Some(1e-4)), truth("jams", None)];
    let work = Work::of(&row);
    let errors: Vec<(&str, f64)> = work.errors.iter().map(|(name, error)| (name.as_str(), *error)).collect();
    assert_eq!(errors, [("error_position_rms_m", 1e-3), ("error_force_rms_N", 0.5), ("error_final_base_x", 1e-4)]);
    assert_eq!(work.point("error_final_base_x"), Ok((1.0, 1e-4)));
    assert_eq!(work.point("error_jams"), Err(NotComparable::NotMeasured));
    row.comparison.error_position_rms_m = Some(f64::INFINITY);
    assert_eq!(Work::of(&row).point("error_position_rms_m"), Err(NotComparable::NotFinite(f64::INFINITY)));
}

#[test]
fn an_unfinished_run_is_not_compared() {
    let mut row = run("exact", &[], 1.0, Some(1e-17));
    row.comparison.truth = vec![TruthError { metric: "final_base_x".into(), error: Some(1e-4) }];
    row.comparison.until_s = Some(0.1);
    row.comparison.whole = true;
    for outcome in [Outcome::Diverged, Outcome::Stalled, Outcome::TimedOut, Outcome::Cancelled, Outcome::Error] {
        row.outcome = outcome;
        for column in ["error_position_rms_m", "error_final_base_x"] {
            assert_eq!(Work::of(&row).point(column), Err(NotComparable::Ended(outcome)));
        }
    }
    // One of run and reference fell, and the other continued.
    row.outcome = Outcome::Fallen;
    assert!(Work::of(&row).point("error_position_rms_m").is_ok());
    row.comparison.whole = false;
    assert_eq!(Work::of(&row).point("error_position_rms_m"), Err(NotComparable::Until(0.1)));
    assert_eq!(Work::of(&row).point("error_final_base_x"), Ok((1.0, 1e-4)));
}

#[test]
fn a_sweep_of_steps_is_one_curve_per_method_in_order_of_the_step() {
    let step = |method: &str, h: f64| {
        run(method, &[("contact.method", method.into()), ("integrator.step", h.into())], 1.0, None)
    };
    let rows = [step("lcp", 1e-3), step("lcp", 1e-2), step("ncp", 1e-2), step("lcp", 1e-4)];
    let expected = vec![(
        String::new(),
        vec![curve("lcp semi-implicit", Some("integrator.step"), &[3, 0, 1]), curve("ncp semi-implicit", None, &[2])],
    )];
    assert_eq!(plain(groups(&works(&rows))), expected);
}

#[test]
fn problems_separate_groups_and_methods_separate_curves() {
    let cell = |mu: f64, h: f64, stiffness: f64| {
        let parameters = [
            ("floor.friction", mu.into()),
            ("integrator.step", h.into()),
            ("contact.penalty.stiffness", stiffness.into()),
            ("expect.0.value", mu.into()),
        ];
        run("penalty", &parameters, 1.0, None)
    };
    let (stiff, soft) = ("contact.penalty.stiffness=100000.0", "contact.penalty.stiffness=1000.0");
    let rows: Vec<SummaryRow> = [(0.4, 1e5), (0.4, 1e3), (0.8, 1e5)]
        .iter()
        .flat_map(|&(mu, k)| [1e-2, 1e-3, 1e-4].map(|h| cell(mu, h, k)))
        .collect();
    let along = Some("integrator.step");
    let expected = vec![
        (
            "floor.friction=0.4".to_owned(),
            vec![
                curve(&format!("penalty semi-implicit {stiff}"), along, &[2, 1, 0]),
                curve(&format!("penalty semi-implicit {soft}"), along, &[5, 4, 3]),
            ],
        ),
        ("floor.friction=0.8".to_owned(), vec![curve("penalty semi-implicit", along, &[8, 7, 6])]),
    ];
    assert_eq!(plain(groups(&works(&rows))), expected);
}

#[test]
fn parameters_that_change_together_form_one_curve() {
    let zipped = |rtol: f64, gap: f64, seed: u64| {
        let parameters = [("integrator.relative_tolerance", rtol.into()), ("contact.distance_tolerance", gap.into())];
        SummaryRow { seed, ..run("exact", &parameters, 1.0, None) }
    };
    let rows = [zipped(1e-4, 1e-3, 1), zipped(1e-6, 1e-4, 1), zipped(1e-4, 1e-3, 2), zipped(1e-6, 1e-4, 2)];
    let along = Some("integrator.relative_tolerance");
    let expected =
        vec![(String::new(), vec![curve("exact dopri5", along, &[1, 0]), curve("exact dopri5", along, &[3, 2])])];
    assert_eq!(plain(groups(&works(&rows))), expected);
    let bouncy = |e: f64| run("exact", &[("contact.restitution", e.into())], 1.0, None);
    assert_eq!(groups(&works(&[bouncy(0.0), bouncy(0.5)])).len(), 2, "restitution belongs to the problem");
}

#[test]
fn the_table_is_sorted_by_cost_and_marks_the_front() {
    let step = |h: f64| [("integrator.step", h.into())];
    let mut rows = vec![
        run("lcp", &step(1e-3), 0.5, Some(1e-3)),
        run("exact", &[("integrator.relative_tolerance", 1e-6.into())], 1.0, Some(0.0)),
        run("lcp", &step(1e-2), 0.125, Some(1e-2)),
        run("ncp", &step(1e-3), 2.0, Some(2e-3)),
        run("penalty", &step(1e-2), 0.25, None),
    ];
    rows[4].outcome = Outcome::Diverged;
    let text = pareto_table(&works(&rows), 120);
    let lines: Vec<Vec<&str>> =
        text.lines().map(|l| l.split("  ").map(str::trim).filter(|w| !w.is_empty()).collect()).collect();
    assert_eq!(lines[0], ["work"]);
    assert_eq!(
        lines[1],
        ["method", "integrator", "parameters", "error_position_rms_m", "cpu s / sim s", "x real time"]
    );
    assert_eq!(lines[2], ["lcp", "semi-implicit", "step=0.01", "1.00e-2*", "1.25e-1", "5.3"]);
    assert_eq!(lines[3], ["lcp", "semi-implicit", "step=0.001", "1.00e-3*", "5.00e-1", "1.3"]);
    assert_eq!(lines[4], ["exact", "dopri5", "relative_tolerance=1e-6", "0*", "1.00e0", "0.7"]);
    assert_eq!(lines[5], ["ncp", "semi-implicit", "step=0.001", "2.00e-3", "2.00e0", "0.3"]);
    assert_eq!(lines[6], ["1 left out: it ended as diverged"]);
    assert!(text.ends_with("more accurate\n"), "{text}");
    assert_eq!(pareto_table(&works(&rows[4..]), 120), "", "no runs to compare");
    assert_eq!(pareto_table(&[], 120), "");
}

#[test]
fn a_long_table_keeps_fronts_and_the_best_of_each_method() {
    let mut rows: Vec<SummaryRow> = (0..50)
        .map(|i| run("lcp", &[("integrator.step", f64::from(i).into())], 2.0 + f64::from(i), Some(0.5)))
        .collect();
    rows.push(run("ncp", &[("integrator.step", 3.5.into())], 60.0, Some(0.75)));
    rows.push(run("exact", &[("integrator.relative_tolerance", 1e-6.into())], 50.5, Some(0.25)));
    let text = pareto_table(&works(&rows), 120);
    let count_lines = |word: &str| text.lines().filter(|l| l.starts_with(word)).count();
    assert_eq!((count_lines("lcp"), count_lines("ncp"), count_lines("exact")), (1, 1, 1), "{text}");
    assert!(text.contains("\n49 more are in the report and the summary\n"), "{text}");
}
