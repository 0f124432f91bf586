//! Expectations: when they are met, and their messages when they are not.

use stiction::scenario::{Expect, METRICS};

use super::{SMALLEST, runs};

fn expect(text: &str) -> Expect {
    runs(&format!("{SMALLEST}[[expect]]\n{text}\n")).remove(0).scenario.expect.remove(0)
}

#[test]
fn a_value_is_met_within_its_tolerance() {
    let e = expect("metric = \"final_base_x\"\nvalue = 0.5\ntolerance = 0.25");
    for (value, holds) in
        [(0.5, true), (0.25, true), (0.75, true), (0.7500001, false), (f64::NAN, false), (f64::INFINITY, false)]
    {
        assert_eq!(e.check(value).is_ok(), holds, "{value}");
    }
    let message = e.check(1.0).unwrap_err().to_string();
    assert!(message.contains("final_base_x is 1") && message.contains("0.5"), "{message}");
}

#[test]
fn a_relative_tolerance_is_a_fraction_of_the_value_and_adds_to_the_other() {
    let e = expect("metric = \"final_base_x\"\nvalue = -4\nrelative_tolerance = 0.25");
    for (value, holds) in [(-5.0, true), (-3.0, true), (-2.9, false), (-5.1, false), (4.0, false)] {
        assert_eq!(e.check(value).is_ok(), holds, "{value}");
    }
    assert_eq!((e.allowed(), e.error(-5.0)), (Some(1.0), -1.0));
    let e = expect("metric = \"final_base_x\"\nvalue = -4\ntolerance = 0.5\nrelative_tolerance = 0.25");
    assert_eq!(e.allowed(), Some(1.5));
    assert!(e.check(-5.5).is_ok() && e.check(-5.6).is_err());
    let limits = expect("metric = \"steps\"\nmin = 10\nmax = 20");
    assert_eq!([9.0, 15.0, 22.0].map(|x| limits.error(x)), [-1.0, 0.0, 2.0]);
    assert!(limits.error(f64::NAN).is_nan() && limits.allowed().is_none());
}

#[test]
fn limits_are_included() {
    let e = expect("metric = \"steps\"\nmin = 10\nmax = 20");
    for (value, holds) in [(9.9, false), (10.0, true), (20.0, true), (20.1, false), (f64::NAN, false)] {
        assert_eq!(e.check(value).is_ok(), holds, "{value}");
    }
    assert!(expect("metric = \"steps\"\nmin = 10").check(1e9).is_ok());
    assert!(expect("metric = \"steps\"\nmax = 10").check(-1e9).is_ok());
    let zero = expect("metric = \"impacts\"\nvalue = 0\ntolerance = 0");
    assert!(zero.check(0.0).is_ok() && zero.check(1.0).is_err());
}

#[test]
fn a_metric_without_a_value_is_not_met() {
    let e = expect("metric = \"first_slip_s\"\nmax = 10");
    assert_eq!(e.judge("passed", |_| None).unwrap_err().to_string(), "first_slip_s has no value");
    assert!(e.judge("fallen", |name| (name == "first_slip_s").then_some(3.0)).is_ok());
}

#[test]
fn outcomes_are_expected_by_name() {
    let e = expect("outcome = \"timed-out\"");
    assert!(e.judge("timed-out", |_| None).is_ok());
    assert_eq!(e.judge("passed", |_| None).unwrap_err().to_string(), "outcome is passed, not timed-out");
}

#[test]
fn every_metric_that_is_available_can_be_expected() {
    let available = METRICS.iter().filter(|m| !m.starts_with("error_") && **m != "contact_state_agreement");
    for metric in available {
        assert_eq!(expect(&format!("metric = \"{metric}\"\nmin = 0")).metric.as_deref(), Some(*metric));
    }
}
