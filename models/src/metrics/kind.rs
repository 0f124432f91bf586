//! Kinds of metrics: type of the field, initial and unmeasured values, and entry in `run.json`.

use super::number::{Measure, Real};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Storage of a metric.
pub(super) trait Kind {
    /// Type of the field of [`Metrics`](super::Metrics).
    type Value;
    /// Type of the entry in `run.json`.
    type Record: Serialize + DeserializeOwned;
    /// Value before the first step of a simulation.
    const AT_START: Self::Value;
    /// Value if nothing was measured.
    const UNMEASURED: Self::Value;
    /// Whether its columns in the summary contain whole numbers.
    const IS_COUNT: bool = false;
    /// The value from its entry in `run.json`.
    fn read(record: Self::Record) -> Self::Value;
    /// The entry for `run.json`.
    fn write(value: Self::Value) -> Self::Record;
    /// The cell of the summary; `axis` is the column's index within its row of the table.
    fn measure(value: &Self::Value, axis: usize) -> Measure;
}

/// A whole number, counted from 0.
pub(super) struct Count;

impl Kind for Count {
    type Value = u64;
    type Record = u64;
    const AT_START: u64 = 0;
    const UNMEASURED: u64 = 0;
    const IS_COUNT: bool = true;
    fn read(record: u64) -> u64 {
        record
    }
    fn write(value: u64) -> u64 {
        value
    }
    fn measure(value: &u64, _: usize) -> Measure {
        Measure::Count(*value)
    }
}

/// A [`Count`] that is missing in records of earlier versions.
pub(super) struct LaterCount;

impl Kind for LaterCount {
    type Value = u64;
    type Record = Option<u64>;
    const AT_START: u64 = 0;
    const UNMEASURED: u64 = 0;
    const IS_COUNT: bool = true;
    fn read(record: Option<u64>) -> u64 {
        record.unwrap_or(0)
    }
    fn write(value: u64) -> Option<u64> {
        Some(value)
    }
    fn measure(value: &u64, _: usize) -> Measure {
        Measure::Count(*value)
    }
}

/// A real number that is measured at the end of a run; NaN until then.
pub(super) struct AtEnd;

impl Kind for AtEnd {
    type Value = f64;
    type Record = Real;
    const AT_START: f64 = f64::NAN;
    const UNMEASURED: f64 = f64::NAN;
    fn read(record: Real) -> f64 {
        record.0
    }
    fn write(value: f64) -> Real {
        Real(value)
    }
    fn measure(value: &f64, _: usize) -> Measure {
        Measure::Real(*value)
    }
}

/// A running maximum, which starts at 0.
pub(super) struct Running;

impl Kind for Running {
    type Value = f64;
    type Record = Real;
    const AT_START: f64 = 0.0;
    const UNMEASURED: f64 = f64::NAN;
    fn read(record: Real) -> f64 {
        record.0
    }
    fn write(value: f64) -> Real {
        Real(value)
    }
    fn measure(value: &f64, _: usize) -> Measure {
        Measure::Real(*value)
    }
}

/// Three real numbers, measured at the end of a run.
pub(super) struct Vector;

impl Kind for Vector {
    type Value = [f64; 3];
    type Record = [Real; 3];
    const AT_START: [f64; 3] = [f64::NAN; 3];
    const UNMEASURED: [f64; 3] = [f64::NAN; 3];
    fn read(record: [Real; 3]) -> [f64; 3] {
        record.map(|x| x.0)
    }
    fn write(value: [f64; 3]) -> [Real; 3] {
        value.map(Real)
    }
    fn measure(value: &[f64; 3], axis: usize) -> Measure {
        Measure::Real(value[axis])
    }
}

/// A real number that some runs lack, such as the time of an event that did not happen.
pub(super) struct OptionalReal;

impl Kind for OptionalReal {
    type Value = Option<f64>;
    type Record = Option<Real>;
    const AT_START: Option<f64> = None;
    const UNMEASURED: Option<f64> = None;
    fn read(record: Option<Real>) -> Option<f64> {
        record.map(|x| x.0)
    }
    fn write(value: Option<f64>) -> Option<Real> {
        value.map(Real)
    }
    fn measure(value: &Option<f64>, _: usize) -> Measure {
        value.map_or(Measure::Nothing, Measure::Real)
    }
}

/// A whole number that some runs lack; its column contains reals, since cells may be empty.
pub(super) struct OptionalCount;

impl Kind for OptionalCount {
    type Value = Option<u64>;
    type Record = Option<u64>;
    const AT_START: Option<u64> = None;
    const UNMEASURED: Option<u64> = None;
    fn read(record: Option<u64>) -> Option<u64> {
        record
    }
    fn write(value: Option<u64>) -> Option<u64> {
        value
    }
    fn measure(value: &Option<u64>, _: usize) -> Measure {
        value.map_or(Measure::Nothing, |n| Measure::Real(n as f64))
    }
}
