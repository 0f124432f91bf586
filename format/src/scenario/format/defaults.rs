//! Default values of keys, as functions for serde.

pub fn tenth() -> f64 {
    0.1
}

pub fn half() -> f64 {
    0.5
}

pub fn one() -> f64 {
    1.0
}

pub fn two() -> f64 {
    2.0
}

pub fn yes() -> bool {
    true
}

/// Keys that are written only where they are not 0.
pub fn is_zero(value: &f64) -> bool {
    *value == 0.0
}
