//! Packets between a task and a robot: one datagram each, little-endian, fixed layout. `docs/wire.md` is the same for people.
//!
//! ```text
//! 0  "stic"          4 bytes
//! 4  version         u16, 1
//! 6  kind            u8, see Kind
//! 7  flags           u8, see flags
//! 8  length          u32, of the datagram with its seal
//! 12 (zero)          u32
//! 16 session         u64
//! 24 sequence        u64, of its sender in this session, from 1 on
//! 32 tick            u64, of the control clock
//! 40 time            f64, the sender's clock, s
//! 48 body
//!    seal            32 bytes, when the packet is sealed
//! ```
//!
//! What is read is held against what the robot has before any of it is used: a packet that is cut short, of another version or
//! length, for other joints, with a number that is not finite or with a wrong seal is [`Refused`], as a whole.

mod bytes;
mod control;
mod greeting;
mod seal;
mod sensing;

use bytes::{Reader, Writer};
pub use control::{read_control, write_control};
pub use greeting::{Hello, Welcome, fingerprint};
pub use seal::{Key, SHORTEST_SECRET};
pub use sensing::{read_sensing, write_sensing};

/// Version of the format.
pub const VERSION: u16 = 1;
/// First bytes of every packet.
pub const MAGIC: [u8; 4] = *b"stic";
/// Bytes before the body.
pub const HEADER: usize = 48;
/// Most bytes of a datagram.
pub const LONGEST: usize = 65_507;

/// Bits of the header's flags.
pub mod flags {
    /// A seal follows the body.
    pub const SEALED: u8 = 1;
    /// Of sensing: the base's pose and velocity are in it.
    pub const BASE: u8 = 2;
    /// Of sensing: forces on the vertices of each sole are in it.
    pub const VERTICES: u8 = 4;
    /// Of sensing: the run there is over, this is its last word.
    pub const LAST: u8 = 8;
    /// All there are.
    pub const ALL: u8 = SEALED | BASE | VERTICES | LAST;
}

/// What a packet is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// A task's side asks for a session.
    Hello = 1,
    /// The robot's side grants it.
    Welcome = 2,
    /// What the joints are asked to do.
    Control = 3,
    /// What the sensors say.
    Sensing = 4,
    /// The sender ends the session.
    Bye = 5,
}

impl Kind {
    fn of(byte: u8) -> Option<Kind> {
        [Kind::Hello, Kind::Welcome, Kind::Control, Kind::Sensing, Kind::Bye].into_iter().find(|k| *k as u8 == byte)
    }
}

/// What every packet begins with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Header {
    /// What it is.
    pub kind: Kind,
    /// See [`flags`].
    pub flags: u8,
    /// The session; of a hello, a number by which its sender knows the answer.
    pub session: u64,
    /// Number of the packet among those of its sender in this session, from 1.
    pub sequence: u64,
    /// Tick of the control clock.
    pub tick: u64,
    /// Clock of the sender, s.
    pub time: f64,
}

/// Why a packet is not acted on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Refused {
    /// Shorter or longer than it says, or than its kind is for this robot.
    Length,
    /// Does not begin as a packet does, or is of an unknown kind.
    Foreign,
    /// Another version of the format.
    Version,
    /// A number in it is not finite, or no number that can stand there.
    Value,
    /// No seal where one is needed, one where none is, or a wrong one.
    Seal,
    /// Of another session.
    Session,
    /// Was there before, or is older than what was acted on.
    Replayed,
}

impl Refused {
    /// All there are.
    pub const ALL: [Refused; 7] = [
        Refused::Length,
        Refused::Foreign,
        Refused::Version,
        Refused::Value,
        Refused::Seal,
        Refused::Session,
        Refused::Replayed,
    ];

    /// A word for it.
    pub fn name(self) -> &'static str {
        match self {
            Refused::Length => "wrong length",
            Refused::Foreign => "foreign",
            Refused::Version => "other version",
            Refused::Value => "impossible value",
            Refused::Seal => "wrong seal",
            Refused::Session => "other session",
            Refused::Replayed => "late or replayed",
        }
    }
}

/// Begins a packet in `out`, which it empties.
pub fn begin(header: &Header, out: &mut Vec<u8>) {
    out.clear();
    let mut w = Writer(out);
    w.bytes(&MAGIC);
    w.u16(VERSION);
    w.bytes(&[header.kind as u8, header.flags]);
    w.u32(0);
    w.u32(0);
    w.u64(header.session);
    w.u64(header.sequence);
    w.u64(header.tick);
    w.f64(header.time);
}

/// Ends it: its length, and the seal where there is a key.
pub fn end(key: Option<&Key>, out: &mut Vec<u8>) {
    let seal = if key.is_some() { seal::SIZE } else { 0 };
    let length = (out.len() + seal) as u32;
    out[8..12].copy_from_slice(&length.to_le_bytes());
    if let Some(key) = key {
        out[7] |= flags::SEALED;
        let seal = key.seal(out);
        out.extend_from_slice(&seal);
    }
}

/// Takes a datagram apart: header and body. Nothing of it is to be used but what this returns.
///
/// # Errors
/// See [`Refused`]; the seal is looked at before anything that it covers is believed.
pub fn open<'a>(datagram: &'a [u8], key: Option<&Key>) -> Result<(Header, &'a [u8]), Refused> {
    let mut r = Reader(datagram);
    let magic = r.bytes::<4>().ok_or(Refused::Length)?;
    if magic != MAGIC {
        return Err(Refused::Foreign);
    }
    let version = r.u16().ok_or(Refused::Length)?;
    if version != VERSION {
        return Err(Refused::Version);
    }
    let [kind, set] = r.bytes::<2>().ok_or(Refused::Length)?;
    let length = r.u32().ok_or(Refused::Length)?;
    let zero = r.u32().ok_or(Refused::Length)?;
    if length as usize != datagram.len() || datagram.len() < HEADER {
        return Err(Refused::Length);
    }
    let kind = Kind::of(kind).ok_or(Refused::Foreign)?;
    let own = if kind == Kind::Sensing { flags::ALL } else { flags::SEALED };
    if zero != 0 || set & !own != 0 {
        return Err(Refused::Value);
    }
    let sealed = set & flags::SEALED != 0;
    if sealed != key.is_some() {
        return Err(Refused::Seal);
    }
    let mut end = datagram.len();
    if let Some(key) = key {
        end = end.checked_sub(seal::SIZE).filter(|end| *end >= HEADER).ok_or(Refused::Length)?;
        if !key.fits(&datagram[..end], &datagram[end..]) {
            return Err(Refused::Seal);
        }
    }
    let short = Refused::Length;
    let (session, sequence) = (r.u64().ok_or(short)?, r.u64().ok_or(short)?);
    let tick = r.u64().ok_or(short)?;
    let time = r.f64().ok_or(short)?;
    if !time.is_finite() {
        return Err(Refused::Value);
    }
    Ok((Header { kind, flags: set, session, sequence, tick, time }, &datagram[HEADER..end]))
}
