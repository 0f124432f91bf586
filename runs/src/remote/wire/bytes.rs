//! Reads and writes sequences of little-endian numbers.

use nalgebra::Vector3;

use crate::remote::wire::Rejection;

/// Reads numbers from the front.
pub struct Reader<'a>(pub &'a [u8]);

impl Reader<'_> {
    pub fn bytes<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*first)
    }

    pub fn u16(&mut self) -> Option<u16> {
        self.bytes().map(u16::from_le_bytes)
    }

    pub fn u32(&mut self) -> Option<u32> {
        self.bytes().map(u32::from_le_bytes)
    }

    pub fn u64(&mut self) -> Option<u64> {
        self.bytes().map(u64::from_le_bytes)
    }

    pub fn f64(&mut self) -> Option<f64> {
        self.bytes().map(f64::from_le_bytes)
    }

    /// A finite number.
    pub fn number(&mut self) -> Result<f64, Rejection> {
        let value = self.f64().ok_or(Rejection::Length)?;
        if value.is_finite() { Ok(value) } else { Err(Rejection::Value) }
    }

    pub fn numbers(&mut self, to: &mut [f64]) -> Result<(), Rejection> {
        to.iter_mut().try_for_each(|to| self.number().map(|value| *to = value))
    }

    pub fn vector(&mut self) -> Result<Vector3<f64>, Rejection> {
        let mut v = Vector3::zeros();
        self.numbers(v.as_mut_slice())?;
        Ok(v)
    }

    /// An error if bytes remain.
    pub fn done(self) -> Result<(), Rejection> {
        if self.0.is_empty() { Ok(()) } else { Err(Rejection::Length) }
    }
}

/// Appends numbers.
pub struct Writer<'a>(pub &'a mut Vec<u8>);

impl Writer<'_> {
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.0.extend_from_slice(bytes);
    }

    pub fn u16(&mut self, value: u16) {
        self.bytes(&value.to_le_bytes());
    }

    pub fn u32(&mut self, value: u32) {
        self.bytes(&value.to_le_bytes());
    }

    pub fn u64(&mut self, value: u64) {
        self.bytes(&value.to_le_bytes());
    }

    pub fn f64(&mut self, value: f64) {
        self.bytes(&value.to_le_bytes());
    }

    pub fn numbers(&mut self, values: &[f64]) {
        values.iter().for_each(|value| self.f64(*value));
    }
}
