//! `scenarios/validation/`: contact against closed forms, in scenarios that every user can run.
//!
//! These tests compute every expected value again from its equation and the scenario's own numbers.
//! They use other means than the original computation: a closed form, or the fixed-step integrator
//! of the tests. They also run the program over the folder.

mod case;
mod command;
mod flight;
mod impact;
mod objects;
mod rocking;
mod sliding;
mod standing;
mod studies;
mod tipping;

use std::collections::BTreeSet;

use case::{Case, cases, files};

/// The true value of the expectation with this index and metric; `None` if the case has none.
type Truth = fn(&Case, usize, &str) -> Option<f64>;

/// The rows of the table of analytic cases, the scenarios of each, and the true values of their
/// expectations. The Painleve rod has its own scenario and tests.
const ROWS: &[(&str, &[(&str, Truth)])] = &[
    ("free fall, then flat landing", &[("flat-landing", impact::landing)]),
    ("block slides and stops", &[("slide-and-stop", sliding::stop), ("feet-slide", sliding::stop)]),
    (
        "incline below / above the friction angle",
        &[
            ("slope-holds", standing::still),
            ("slope-slides", sliding::slope),
            ("creep-on-slope", standing::still),
            ("creep-under-load", standing::still),
        ],
    ),
    ("breakaway by a ramped push", &[("breakaway-push", sliding::push)]),
    ("breakaway by a ramped yaw moment", &[("breakaway-turn", sliding::turn)]),
    ("spin to rest", &[("spin-to-rest", sliding::spin)]),
    ("slide with spin", &[("slide-with-spin", sliding::slide_and_spin)]),
    ("hop", &[("no-hop", sliding::stop)]),
    (
        "tip or slide",
        &[
            ("pushed-low-slides", tipping::onset),
            ("pushed-high-tips", tipping::onset),
            ("tipping-pendulum", tipping::pendulum),
            ("feet-tip", tipping::pendulum),
        ],
    ),
    ("rocking block", &[("rocking", rocking::housner)]),
    ("restitution", &[("bounce-heights", impact::heights), ("bounce-to-rest", impact::rest)]),
    (
        "double support, standing biped",
        &[("biped-stands", standing::still), ("feet-stand", standing::still), ("biped-on-slope", standing::still)],
    ),
    ("flight", &[("flight-of-boxes", flight::boxes), ("flight-of-biped", flight::boxes)]),
    (
        "balls and boxes, terrain",
        &[
            ("ball-rolls-down", objects::rolls_down),
            ("ball-begins-to-roll", objects::begins_to_roll),
            ("box-over-edge", objects::over_edge),
            ("box-over-seams", objects::over_seams),
            ("block-slips-on-box", objects::slips_on_box),
            ("boxes-in-line", objects::slip_in_line),
        ],
    ),
    (
        "double pendulum, torque-free top",
        &[
            ("double-pendulum", flight::double_pendulum),
            ("symmetric-top", flight::symmetric_top),
            ("asymmetric-top", flight::asymmetric_top),
        ],
    ),
];

/// Scenarios of the folder that other tests prove.
const ELSEWHERE: &[&str] = &["painleve", "patch", "forced"];

/// Quantities that are zero wherever a scenario expects a value.
const ZERO: &[&str] = &[
    "energy_error_J",
    "final_base_pitch",
    "final_base_roll",
    "final_base_shift_m",
    "final_base_sideways_m",
    "final_base_vz",
    "final_base_wz_rad_s",
    "final_base_yaw",
    "final_cop_offset_m",
    "max_flight_path_drift_m",
    "max_flight_spin_drift_Nms",
    "max_lift_m",
    "max_penetration_m",
    "max_static_creep_m",
    "state_changes",
];

#[test]
fn every_row_of_the_table_has_scenarios_and_every_scenario_a_row() {
    let mapped: BTreeSet<&str> = ROWS.iter().flat_map(|(_, files)| files.iter().map(|(name, _)| *name)).collect();
    let found: BTreeSet<String> = files().into_iter().map(|(name, _)| name).collect();
    let own: BTreeSet<&str> =
        found.iter().map(String::as_str).filter(|f| !ELSEWHERE.iter().any(|e| f.starts_with(e))).collect();
    assert_eq!(own, mapped);
    assert!(ROWS.iter().all(|(row, _)| !row.is_empty()) && ROWS.len() == 15);
}

#[test]
fn every_expected_value_follows_from_its_equation() {
    let mut proved = 0;
    for (name, truth) in ROWS.iter().flat_map(|(_, files)| *files) {
        for case in cases(name) {
            for (i, expect) in case.run.scenario.expect.iter().enumerate() {
                let Some(typed) = expect.value else { continue };
                let metric = expect.metric.as_deref().expect("a value has a metric");
                let zero = ZERO.contains(&metric).then_some(0.0);
                let Some(truth) = truth(&case, i, metric).or(zero) else {
                    panic!("{name}: nothing proves {metric} = {typed}");
                };
                // The rounding of a typed number may use a tenth of its tolerance.
                let allowed = 0.1 * expect.allowed().expect("there is a value");
                assert!((typed - truth).abs() <= allowed, "{name} {metric}: {typed} {truth} {}", case.run.index);
                proved += 1;
            }
        }
    }
    assert!(proved > 1000, "{proved} values");
}

#[test]
fn studies_cover_headings_sizes_and_frictions() {
    for (name, least) in [("slide-and-stop", 24), ("breakaway-push", 40), ("slope-holds", 24), ("no-hop", 25)] {
        let cases = cases(name);
        assert!(cases.len() >= least, "{name}");
        let sizes: BTreeSet<_> = cases.iter().map(|c| c.run.scenario.robot.model.clone()).collect();
        let frictions: BTreeSet<_> = cases.iter().map(|c| c.mu_s().to_bits()).collect();
        assert!(sizes.len() >= 4 && frictions.len() >= 4, "{name}");
    }
}
