//! Parses numeric arguments, with error messages.

use std::num::{IntErrorKind, ParseIntError};
use std::str::FromStr;
use std::time::Duration;

/// Why an argument is not a number of the expected kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NumberError {
    #[error("the number is too large")]
    TooLarge,
    #[error("expected a whole number of at least 1")]
    Count,
    #[error("expected a number of seconds greater than 0")]
    Seconds,
    #[error("expected a finite number")]
    Finite,
    #[error("expected a number greater than 0")]
    Positive,
    #[error("expected a number of at least 0")]
    NotNegative,
    #[error("expected a number of at least 1")]
    Ratio,
    #[error("expected a number greater than 0 and less than 1")]
    Level,
}

/// A whole number of 1 or more, for types without 0.
pub fn count<N: FromStr<Err = ParseIntError>>(text: &str) -> Result<N, NumberError> {
    text.trim().parse().map_err(|error: ParseIntError| match error.kind() {
        IntErrorKind::PosOverflow => NumberError::TooLarge,
        _ => NumberError::Count,
    })
}

/// A span of time above 0.
pub fn seconds(text: &str) -> Result<Duration, NumberError> {
    let given = text.trim().parse().ok().and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    given.filter(|span| !span.is_zero()).ok_or(NumberError::Seconds)
}

/// Any number.
pub fn finite(text: &str) -> Result<f64, NumberError> {
    text.trim().parse().ok().filter(|x: &f64| x.is_finite()).ok_or(NumberError::Finite)
}

/// A number above 0.
pub fn positive(text: &str) -> Result<f64, NumberError> {
    finite(text).ok().filter(|x| *x > 0.0).ok_or(NumberError::Positive)
}

/// A number of 0 or more, or infinity.
pub fn allowed(text: &str) -> Result<f64, NumberError> {
    text.trim().parse().ok().filter(|x: &f64| *x >= 0.0).ok_or(NumberError::NotNegative)
}

/// A probability between 0 and 1.
pub fn level(text: &str) -> Result<f64, NumberError> {
    finite(text).ok().filter(|x| *x > 0.0 && *x < 1.0).ok_or(NumberError::Level)
}

/// A number of 1 or more.
pub fn ratio(text: &str) -> Result<f64, NumberError> {
    text.trim().parse().ok().filter(|x: &f64| *x >= 1.0).ok_or(NumberError::Ratio)
}
