//! Writes and reads hello and welcome, the packets that open a session.
//!
//! ```text
//! hello     robot       32 bytes, see `fingerprint`
//!           rate        f64, control ticks per second of the sender, Hz
//! welcome   answers     u64, the session of the hello it answers
//!           robot       32 bytes
//!           rate        f64, Hz
//!           pace        f64, seconds of the robot's clock per second; 0: each tick waits for
//!                       its command
//! ```
//!
//! The sender of a hello chooses a random number, so that packets of an earlier session are invalid
//! in a later one.

use crate::remote::wire::{Reader, Rejection, Writer};
use crate::robot::Model;

/// Request for a session.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hello {
    /// See [`fingerprint`].
    pub robot: [u8; 32],
    /// Control ticks per second, Hz.
    pub rate: f64,
}

/// Answer that grants a session.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Welcome {
    /// The session of the hello it answers.
    pub answers: u64,
    /// See [`fingerprint`].
    pub robot: [u8; 32],
    /// Control ticks per second, Hz.
    pub rate: f64,
    /// Seconds of the robot's clock per second; 0: each tick waits for its command.
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
    pub fn read(body: &[u8]) -> Result<Self, Rejection> {
        let mut r = Reader(body);
        let hello = Hello { robot: r.bytes().ok_or(Rejection::Length)?, rate: positive(&mut r)? };
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
    pub fn read(body: &[u8]) -> Result<Self, Rejection> {
        let mut r = Reader(body);
        let (answers, robot) = (r.u64().ok_or(Rejection::Length)?, r.bytes().ok_or(Rejection::Length)?);
        let welcome = Welcome { answers, robot, rate: positive(&mut r)?, pace: r.number()? };
        r.done()?;
        if welcome.pace < 0.0 { Err(Rejection::Value) } else { Ok(welcome) }
    }
}

fn positive(r: &mut Reader) -> Result<f64, Rejection> {
    let value = r.number()?;
    if value > 0.0 { Ok(value) } else { Err(Rejection::Value) }
}

/// Hash of the properties on which both sides must agree: joint names in order, sole names and
/// their numbers of vertices. Counts and names are hashed as text after its length (u64).
pub fn fingerprint(model: &Model) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new_derive_key("stiction 2026 wire format 1, robot");
    let mut add = |text: &str| {
        hasher.update(&(text.len() as u64).to_le_bytes());
        hasher.update(text.as_bytes());
    };
    add(&model.joints.len().to_string());
    model.joints.iter().for_each(|joint| add(&joint.name));
    add(&model.soles.len().to_string());
    for sole in &model.soles {
        add(&sole.name);
        add(&sole.vertices.len().to_string());
    }
    *hasher.finalize().as_bytes()
}
