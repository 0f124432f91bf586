//! Writes protobuf messages directly into a byte buffer, in the wire format of proto3.
//!
//! Each value is copied once. A message type would be filled, measured and then encoded. As in
//! proto3, zeros, empty texts and empty lists are left out. The readers decode with the types of
//! [`crate::log::messages`] and of Foxglove; tests compare the two.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

/// Wire types.
const VARINT: u32 = 0;
const FIXED_64: u32 = 1;
const DELIMITED: u32 = 2;

/// Appends the fields of one message. Fields are numbered as in the schema.
pub(super) struct ProtoWriter<'a>(&'a mut Vec<u8>);

impl<'a> ProtoWriter<'a> {
    pub fn new(bytes: &'a mut Vec<u8>) -> Self {
        Self(bytes)
    }

    #[inline]
    fn varint(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.0.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.0.push(value as u8);
    }

    #[inline]
    fn key(&mut self, field: u32, wire_type: u32) {
        self.varint(u64::from(field << 3 | wire_type));
    }

    /// A number.
    #[inline]
    pub fn double(&mut self, field: u32, x: f64) {
        if x != 0.0 {
            self.key(field, FIXED_64);
            self.0.extend_from_slice(&x.to_le_bytes());
        }
    }

    /// A whole number that is not negative.
    #[inline]
    pub fn uint(&mut self, field: u32, n: u64) {
        if n != 0 {
            self.key(field, VARINT);
            self.varint(n);
        }
    }

    /// A text.
    #[inline]
    pub fn text(&mut self, field: u32, text: &str) {
        if !text.is_empty() {
            self.key(field, DELIMITED);
            self.varint(text.len() as u64);
            self.0.extend_from_slice(text.as_bytes());
        }
    }

    /// A packed list of numbers.
    #[inline]
    pub fn doubles(&mut self, field: u32, list: &[f64]) {
        if !list.is_empty() {
            self.key(field, DELIMITED);
            self.varint(8 * list.len() as u64);
            extend_with_doubles(self.0, list);
        }
    }

    /// A packed list of truth values.
    pub fn bools(&mut self, field: u32, list: &[bool]) {
        if !list.is_empty() {
            self.key(field, DELIMITED);
            self.varint(list.len() as u64);
            self.0.extend(list.iter().map(|on| u8::from(*on)));
        }
    }

    /// A message whose fields 1 to N are numbers. `N` is at most 13: its length has one byte.
    #[inline]
    pub fn numbers<const N: usize>(&mut self, field: u32, numbers: [f64; N]) {
        const { assert!(9 * N < 0x80) };
        self.key(field, DELIMITED);
        let start = self.0.len();
        self.0.resize(start + 1 + 9 * N, 0);
        let mut length = 0;
        let body = &mut self.0[start + 1..];
        for (k, x) in numbers.into_iter().enumerate() {
            // Written in any case: the next number replaces a zero.
            let to = &mut body[length..length + 9];
            to[0] = ((k as u8 + 1) << 3) | FIXED_64 as u8;
            to[1..].copy_from_slice(&x.to_le_bytes());
            length += if x == 0.0 { 0 } else { 9 };
        }
        self.0[start] = length as u8;
        self.0.truncate(start + 1 + length);
    }

    /// A vector, of this program's messages and of Foxglove's.
    #[inline]
    pub fn vector(&mut self, field: u32, v: &Vector3<f64>) {
        self.numbers(field, [v.x, v.y, v.z]);
    }

    /// A quaternion of this program's messages: w, x, y, z.
    #[inline]
    pub fn quaternion(&mut self, field: u32, q: &UnitQuaternion<f64>) {
        self.numbers(field, [q.w, q.i, q.j, q.k]);
    }

    /// Vectors, one message each.
    pub fn vectors(&mut self, field: u32, list: &[Vector3<f64>]) {
        list.iter().for_each(|v| self.vector(field, v));
    }

    /// A message of any length.
    #[inline]
    pub fn message(&mut self, field: u32, write: impl FnOnce(&mut ProtoWriter)) {
        self.key(field, DELIMITED);
        let start = self.0.len();
        self.0.push(0);
        write(&mut ProtoWriter(self.0));
        let length = self.0.len() - start - 1;
        if length < 0x80 {
            self.0[start] = length as u8;
            return;
        }
        // The length needs more bytes than the one reserved: the content moves up.
        let more = (length.ilog2() / 7) as usize;
        self.0.resize(start + 1 + length + more, 0);
        self.0.copy_within(start + 1..start + 1 + length, start + 1 + more);
        for (k, to) in self.0[start..=start + more].iter_mut().enumerate() {
            let continues = if k < more { 0x80 } else { 0 };
            *to = (length >> (7 * k)) as u8 & 0x7f | continues;
        }
    }

    /// Fields that were encoded before.
    #[inline]
    pub fn encoded(&mut self, fields: &[u8]) {
        self.0.extend_from_slice(fields);
    }

    /// A `google.protobuf.Timestamp`.
    #[inline]
    pub fn timestamp(&mut self, field: u32, ns: u64) {
        self.message(field, |to| {
            to.uint(1, ns / 1_000_000_000);
            to.uint(2, ns % 1_000_000_000);
        });
    }

    /// A `foxglove.Quaternion`: x, y, z, w.
    #[inline]
    pub fn foxglove_quaternion(&mut self, field: u32, q: &UnitQuaternion<f64>) {
        self.numbers(field, [q.i, q.j, q.k, q.w]);
    }

    /// A `foxglove.Pose`.
    pub fn foxglove_pose(&mut self, field: u32, pose: &Isometry3<f64>) {
        self.message(field, |to| {
            to.vector(1, &pose.translation.vector);
            to.foxglove_quaternion(2, &pose.rotation);
        });
    }

    /// A `foxglove.Color`.
    pub fn foxglove_colour(&mut self, field: u32, rgba: [f32; 4]) {
        self.numbers(field, rgba.map(f64::from));
    }
}

/// Appends numbers, lowest byte first.
#[inline]
pub(super) fn extend_with_doubles(bytes: &mut Vec<u8>, list: &[f64]) {
    let start = bytes.len();
    bytes.resize(start + 8 * list.len(), 0);
    for (to, x) in bytes[start..].as_chunks_mut::<8>().0.iter_mut().zip(list) {
        *to = x.to_le_bytes();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::messages;
    use prost::Message as _;

    fn sole(texts: usize) -> messages::Sole {
        let vector = |x: f64| messages::Vector3 { x, y: 0.0, z: -1.5 * x };
        messages::Sole {
            name: "n".repeat(texts),
            state: String::new(),
            clamped: vec![true, false, true],
            positions: vec![vector(0.0), vector(f64::MIN_POSITIVE), vector(f64::INFINITY)],
            velocities: Vec::new(),
            forces: vec![vector(7.25)],
            force: None,
        }
    }

    /// Lengths of one, two and three bytes, with both of their limits.
    #[test]
    fn bytes_equal_those_of_prost() {
        let rest = sole(0).encoded_len();
        for texts in
            [0, 1, 124 - rest, 126 - rest, 127 - rest, 300, 16_383 - rest, 16_379 - rest, 16_380 - rest, 40_000]
        {
            let contact = messages::Contact { time: 0.25, soles: vec![sole(texts), sole(3)], links: Vec::new() };
            let mut bytes = Vec::new();
            let mut to = ProtoWriter::new(&mut bytes);
            to.double(1, contact.time);
            for sole in &contact.soles {
                to.message(2, |to| {
                    to.text(1, &sole.name);
                    to.text(2, &sole.state);
                    to.bools(3, &sole.clamped);
                    let vectors =
                        |all: &[messages::Vector3]| all.iter().map(|v| Vector3::new(v.x, v.y, v.z)).collect::<Vec<_>>();
                    to.vectors(4, &vectors(&sole.positions));
                    to.vectors(5, &vectors(&sole.velocities));
                    to.vectors(6, &vectors(&sole.forces));
                });
            }
            assert_eq!(bytes, contact.encode_to_vec(), "{texts} letters");
        }
    }

    #[test]
    fn lists_numbers_and_fields_beyond_15_equal_those_of_prost() {
        let state = messages::State {
            time: -0.5,
            q: (0..40).map(|k| f64::from(k) * 0.1).collect(),
            effort_desired: vec![0.0, -3.0],
            ..Default::default()
        };
        let mut bytes = Vec::new();
        let mut to = ProtoWriter::new(&mut bytes);
        to.double(1, state.time);
        to.doubles(6, &state.q);
        to.doubles(8, &[]);
        to.doubles(17, &state.effort_desired);
        assert_eq!(bytes, state.encode_to_vec());

        let avoidance = messages::SelfCollision { cycles: 300, tests: 0, ..Default::default() };
        bytes.clear();
        let mut to = ProtoWriter::new(&mut bytes);
        to.uint(7, avoidance.cycles);
        to.uint(8, avoidance.tests);
        assert_eq!(bytes, avoidance.encode_to_vec());
    }
}
