//! Encodes and decodes the packets of a link: one datagram each, little-endian, fixed layout,
//! specified in `docs/wire.md`.
//!
//! ```text
//! 0  "stic"          4 bytes
//! 4  version         u16, 2
//! 6  kind            u8, see Kind
//! 7  flags           u8, see flags
//! 8  length          u32, of the datagram with its tag
//! 12 (zero)          u32
//! 16 session         u64
//! 24 sequence        u64, of its sender in this session, from 1 on
//! 32 tick            u64, of the control clock
//! 40 time            f64, the sender's clock, s
//! 48 body
//!    tag             32 bytes, if the packet is authenticated
//! ```
//!
//! A packet is validated before any of it is used. One that is truncated, of another version or
//! length, for other joints, with a number that is not finite or with a wrong authentication tag is
//! rejected as a whole ([`Rejection`]).

mod authentication;
mod bytes;
mod control;
mod handshake;
mod sensing;

pub use authentication::{Key, MIN_SECRET, TAG_SIZE};
use bytes::{Reader, Writer};
pub use control::{read_control, write_control};
pub use handshake::{CHALLENGE_SIZE, Confirm, Hello, Welcome, fingerprint, session_of};
pub use sensing::{read_sensing, write_sensing};

/// Version of the format.
pub const VERSION: u16 = 2;
/// First bytes of every packet.
pub const MAGIC: [u8; 4] = *b"stic";
/// Bytes before the body.
pub const HEADER: usize = 48;
/// Largest length of a datagram, bytes.
pub const MAX_DATAGRAM: usize = 65_507;

/// Bits of the header's flags.
pub mod flags {
    /// An authentication tag follows the body.
    pub const AUTHENTICATED: u8 = 1;
    /// Sensing: contains pose and velocity of the base.
    pub const BASE: u8 = 2;
    /// Sensing: contains the forces on the vertices of each sole.
    pub const VERTICES: u8 = 4;
    /// Sensing: the last packet of the run.
    pub const LAST: u8 = 8;
    /// All flags.
    pub const ALL: u8 = AUTHENTICATED | BASE | VERTICES | LAST;
}

/// Kind of a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// The task side requests a session.
    Hello = 1,
    /// The robot side offers it, with a challenge.
    Welcome = 2,
    /// Joint commands.
    Control = 3,
    /// Sensor readings.
    Sensing = 4,
    /// The sender ends the session.
    Bye = 5,
    /// The task side begins the offered session by returning the challenge.
    Confirm = 6,
}

impl Kind {
    fn of(byte: u8) -> Option<Kind> {
        let all = [Kind::Hello, Kind::Welcome, Kind::Control, Kind::Sensing, Kind::Bye, Kind::Confirm];
        all.into_iter().find(|k| *k as u8 == byte)
    }
}

/// Header of every packet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Header {
    /// Kind of the packet.
    pub kind: Kind,
    /// See [`flags`].
    pub flags: u8,
    /// Session number; in a hello, a number that the welcome repeats.
    pub session: u64,
    /// Sequence number of its sender in this session, from 1.
    pub sequence: u64,
    /// Tick of the control clock.
    pub tick: u64,
    /// Clock of the sender, s.
    pub time: f64,
}

/// Why a packet is rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rejection {
    /// Its length is not as stated, or not that of its kind for this robot.
    Length,
    /// It lacks the magic bytes or is of an unknown kind.
    Foreign,
    /// Another version of the format.
    Version,
    /// A value is not finite or not valid in its position.
    Value,
    /// The authentication tag is missing, unexpected or wrong.
    Tag,
    /// It belongs to another session.
    Session,
    /// It is a duplicate, or older than an accepted packet.
    Replayed,
}

impl Rejection {
    /// All reasons.
    pub const ALL: [Rejection; 7] = [
        Rejection::Length,
        Rejection::Foreign,
        Rejection::Version,
        Rejection::Value,
        Rejection::Tag,
        Rejection::Session,
        Rejection::Replayed,
    ];

    /// Short text of it.
    pub fn name(self) -> &'static str {
        match self {
            Rejection::Length => "wrong length",
            Rejection::Foreign => "foreign",
            Rejection::Version => "other version",
            Rejection::Value => "invalid value",
            Rejection::Tag => "wrong authentication tag",
            Rejection::Session => "other session",
            Rejection::Replayed => "late or replayed",
        }
    }
}

/// If a datagram is a hello of another version, its session field and its length.
pub fn foreign_hello(datagram: &[u8]) -> Option<(u64, usize)> {
    let mut r = Reader(datagram);
    let (magic, version, [kind, _]) = (r.bytes::<4>()?, r.u16()?, r.bytes::<2>()?);
    let _ = r.u64()?;
    let session = r.u64()?;
    (magic == MAGIC && version != VERSION && kind == Kind::Hello as u8).then_some((session, datagram.len()))
}

/// Clears `out` and writes the header of a packet.
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

/// Completes a packet: writes its length and, with a key, its tag.
pub fn end(key: Option<&Key>, out: &mut Vec<u8>) {
    let tag = if key.is_some() { authentication::TAG_SIZE } else { 0 };
    let length = (out.len() + tag) as u32;
    out[8..12].copy_from_slice(&length.to_le_bytes());
    if let Some(key) = key {
        out[7] |= flags::AUTHENTICATED;
        let tag = key.tag(out);
        out.extend_from_slice(&tag);
    }
}

/// Validates a datagram and returns its header and body.
///
/// # Errors
/// See [`Rejection`]; the tag is verified before the values that it covers are used.
pub fn open<'a>(datagram: &'a [u8], key: Option<&Key>) -> Result<(Header, &'a [u8]), Rejection> {
    let mut r = Reader(datagram);
    let magic = r.bytes::<4>().ok_or(Rejection::Length)?;
    if magic != MAGIC {
        return Err(Rejection::Foreign);
    }
    let version = r.u16().ok_or(Rejection::Length)?;
    if version != VERSION {
        return Err(Rejection::Version);
    }
    let [kind, set] = r.bytes::<2>().ok_or(Rejection::Length)?;
    let length = r.u32().ok_or(Rejection::Length)?;
    let zero = r.u32().ok_or(Rejection::Length)?;
    if length as usize != datagram.len() || datagram.len() < HEADER {
        return Err(Rejection::Length);
    }
    let kind = Kind::of(kind).ok_or(Rejection::Foreign)?;
    let allowed = if kind == Kind::Sensing { flags::ALL } else { flags::AUTHENTICATED };
    if zero != 0 || set & !allowed != 0 {
        return Err(Rejection::Value);
    }
    let authenticated = set & flags::AUTHENTICATED != 0;
    if authenticated != key.is_some() {
        return Err(Rejection::Tag);
    }
    let mut end = datagram.len();
    if let Some(key) = key {
        end = end.checked_sub(authentication::TAG_SIZE).filter(|end| *end >= HEADER).ok_or(Rejection::Length)?;
        if !key.verifies(&datagram[..end], &datagram[end..]) {
            return Err(Rejection::Tag);
        }
    }
    let short = Rejection::Length;
    let (session, sequence) = (r.u64().ok_or(short)?, r.u64().ok_or(short)?);
    let tick = r.u64().ok_or(short)?;
    let time = r.f64().ok_or(short)?;
    if !time.is_finite() {
        return Err(Rejection::Value);
    }
    Ok((Header { kind, flags: set, session, sequence, tick, time }, &datagram[HEADER..end]))
}
