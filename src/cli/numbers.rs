//! Parses numeric arguments, with error messages.

use std::num::{IntErrorKind, ParseIntError};
use std::str::FromStr;
use std::time::Duration;

/// A whole number of 1 or more, for types without 0.
pub fn count<N: FromStr<Err = ParseIntError>>(text: &str) -> Result<N, String> {
    text.trim().parse().map_err(|error: ParseIntError| match error.kind() {
        IntErrorKind::PosOverflow => "it is larger than any that is taken here".into(),
        _ => "a whole number of 1 or more is wanted".into(),
    })
}

/// A span of time above 0.
pub fn seconds(text: &str) -> Result<Duration, String> {
    let given = text.trim().parse().ok().and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    given.filter(|span| !span.is_zero()).ok_or_else(|| "a number of seconds above 0 is wanted".into())
}

/// Any number.
pub fn finite(text: &str) -> Result<f64, String> {
    text.trim().parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| "a finite number is wanted".into())
}

/// A number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|x| *x > 0.0).ok_or_else(|| "a number above 0 is wanted".into())
}

/// A number of 0 or more, or infinity.
pub fn allowed(text: &str) -> Result<f64, String> {
    text.trim().parse().ok().filter(|x: &f64| *x >= 0.0).ok_or_else(|| "a number of 0 or more is wanted".into())
}

/// A number of 1 or more.
pub fn ratio(text: &str) -> Result<f64, String> {
    text.trim().parse().ok().filter(|x: &f64| *x >= 1.0).ok_or_else(|| "a number of 1 or more is wanted".into())
}
