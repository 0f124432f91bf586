//! The bodies of the packets by which a session begins.
//!
//! ```text
//! hello     robot       32 bytes, see `fingerprint`
//!           rate        f64, control ticks per second that the sender wants, Hz
//! welcome   answers     u64, the session of the hello it answers
//!           robot       32 bytes
//!           rate        f64, Hz
//!           pace        f64, seconds of the robot's clock per second; 0: as fast as control comes
//! ```
//!
//! A sender makes up its part of a session's number, so that packets of an earlier session fit no later one.

use crate::remote::wire::{Reader, Refused, Writer};
use crate::robot::Model;

/// What asks for a session.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hello {
    /// See [`fingerprint`].
    pub robot: [u8; 32],
    /// Control ticks per second, Hz.
    pub rate: f64,
}

/// What grants one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Welcome {
    /// The session of the hello it answers.
    pub answers: u64,
    /// See [`fingerprint`].
    pub robot: [u8; 32],
    /// Control ticks per second, Hz.
    pub rate: f64,
    /// Seconds of the robot's clock per second; 0: as fast as control comes.
    pub pace: f64,
}

impl Hello {
    /// Appends the body.
    pub fn write(&self, out: &mut Vec<u8>) {
        let mut w = Writer(out);
        w.bytes(&self.robot);
        w.f64(self.rate);
    }

    /// Reads a body.
    pub fn read(body: &[u8]) -> Result<Self, Refused> {
        let mut r = Reader(body);
        let hello = Hello { robot: r.bytes().ok_or(Refused::Length)?, rate: positive(&mut r)? };
        r.done().map(|()| hello)
    }
}

impl Welcome {
    /// Appends the body.
    pub fn write(&self, out: &mut Vec<u8>) {
        let mut w = Writer(out);
        w.u64(self.answers);
        w.bytes(&self.robot);
        w.f64(self.rate);
        w.f64(self.pace);
    }

    /// Reads a body.
    pub fn read(body: &[u8]) -> Result<Self, Refused> {
        let mut r = Reader(body);
        let (answers, robot) = (r.u64().ok_or(Refused::Length)?, r.bytes().ok_or(Refused::Length)?);
        let welcome = Welcome { answers, robot, rate: positive(&mut r)?, pace: r.number()? };
        r.done()?;
        if welcome.pace < 0.0 { Err(Refused::Value) } else { Ok(welcome) }
    }
}

fn positive(r: &mut Reader) -> Result<f64, Refused> {
    let value = r.number()?;
    if value > 0.0 { Ok(value) } else { Err(Refused::Value) }
}

/// What both sides must agree on: names of the joints in their order, names of the soles and how many vertices each has.
pub fn fingerprint(model: &Model) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new_derive_key("stiction 2026 wire format 1, robot");
    let mut word = |text: &str| {
        hasher.update(&(text.len() as u64).to_le_bytes());
        hasher.update(text.as_bytes());
    };
    word(&model.joints.len().to_string());
    model.joints.iter().for_each(|joint| word(&joint.name));
    word(&model.soles.len().to_string());
    for sole in &model.soles {
        word(&sole.name);
        word(&sole.vertices.len().to_string());
    }
    *hasher.finalize().as_bytes()
}
