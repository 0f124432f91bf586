//! Writes and reads hello, welcome and confirm, the packets that open a session.
//!
//! ```text
//! hello     robot       32 bytes, see `fingerprint`
//!           rate        f64, control ticks per second of the sender, Hz
//! welcome   answers     u64, the session of the hello it answers
//!           robot       32 bytes
//!           rate        f64, Hz
//!           pace        f64, seconds of the robot's clock per second; 0: each tick waits for
//!                       its command
//!           challenge   32 bytes; the first 8 are the number of the session
//! confirm   answers     u64
//!           challenge   32 bytes
//! ```
//!
//! The sender of a hello chooses a random number and the robot side a random challenge, so recorded
//! packets of an earlier session neither answer the one nor the other.

use crate::remote::wire::{Reader, Rejection, Writer};
use crate::robot::Model;

/// Length of a challenge, bytes.
pub const CHALLENGE_SIZE: usize = 32;

/// Number of the session that a challenge offers.
pub fn session_of(challenge: &[u8; CHALLENGE_SIZE]) -> u64 {
    challenge.iter().take(8).rev().fold(0, |number, byte| number << 8 | u64::from(*byte))
}

/// Request for a session.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hello {
    /// See [`fingerprint`].
    pub robot: [u8; 32],
    /// Control ticks per second, Hz.
    pub rate: f64,
}

/// Answer that offers a session.
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
    /// Unpredictable bytes, which the confirm repeats.
    pub challenge: [u8; CHALLENGE_SIZE],
}

/// Answer to a welcome, which begins the session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Confirm {
    /// The session of the hello.
    pub answers: u64,
    /// The challenge of the welcome.
    pub challenge: [u8; CHALLENGE_SIZE],
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
        w.bytes(&self.challenge);
    }

    /// Reads a body.
    pub fn read(body: &[u8]) -> Result<Self, Rejection> {
        let mut r = Reader(body);
        let (answers, robot) = (r.u64().ok_or(Rejection::Length)?, r.bytes().ok_or(Rejection::Length)?);
        let (rate, pace) = (positive(&mut r)?, r.number()?);
        let welcome = Welcome { answers, robot, rate, pace, challenge: r.bytes().ok_or(Rejection::Length)? };
        r.done()?;
        if welcome.pace < 0.0 { Err(Rejection::Value) } else { Ok(welcome) }
    }
}

impl Confirm {
    /// Appends the body.
    pub fn write(&self, out: &mut Vec<u8>) {
        let mut w = Writer(out);
        w.u64(self.answers);
        w.bytes(&self.challenge);
    }

    /// Reads a body.
    pub fn read(body: &[u8]) -> Result<Self, Rejection> {
        let mut r = Reader(body);
        let (answers, challenge) = (r.u64().ok_or(Rejection::Length)?, r.bytes().ok_or(Rejection::Length)?);
        r.done().map(|()| Confirm { answers, challenge })
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
