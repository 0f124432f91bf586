//! Fuzzes packets of the link between tasks and a robot: arbitrary bytes, or valid packets of each
//! kind with some bytes changed, so that the code behind lengths and tags is reached.
//!
//! An accepted packet is written again and must yield the same bytes.

use stiction::dynamics::chain::FrameMotion;
use stiction::remote::wire::{
    self, Confirm, HEADER, Header, Hello, Key, Kind, Welcome, fingerprint, flags, read_control, read_sensing,
    write_control, write_sensing,
};
use stiction::robot::Model;
use stiction::task::{Command, SensorReadings};

use super::tree;

/// First byte of the input: the kind of valid packet to change, or `r` for arbitrary bytes.
pub const KINDS: [u8; 8] = *b"rhwfcsvb";
/// Second byte: `n` no key, `k` the tag of the valid packet, `s` a new tag after the changes, `l`
/// no key but a new length after the changes.
pub const TAGS: [u8; 4] = *b"nksl";

thread_local! {
    static MODEL: Model = tree::robot(&tree::run("robot.model = \"../robots/hoap2/hoap2.toml\"")).expect("HOAP-2").model.clone();
}

/// Takes the two letters and the bytes of a packet. For kinds other than `r` the rest is the change
/// in length (a signed byte) and changed bytes: two bytes of position, one of value.
pub fn take(data: &[u8]) {
    let [kind, tag, rest @ ..] = data else { return };
    MODEL.with(|model| {
        let key = Key::of(b"a secret of the fuzz target").expect("long enough");
        let key = matches!(tag, b'k' | b's').then_some(&key);
        let mut packet = Vec::new();
        if *kind == b'r' {
            packet.extend_from_slice(rest);
        } else {
            let Some(()) = valid(*kind, model, &mut packet) else { return };
            wire::end(key.filter(|_| *tag == b'k'), &mut packet);
            let [longer, changes @ ..] = rest else { return };
            packet.resize(packet.len().saturating_add_signed(isize::from(*longer as i8)), 0x5a);
            for change in changes.chunks_exact(3) {
                let at = usize::from(u16::from_le_bytes([change[0], change[1]]));
                if let Some(byte) = packet.get_mut(at) {
                    *byte = change[2];
                }
            }
        }
        if matches!(tag, b's' | b'l') && packet.len() >= HEADER {
            wire::end(key, &mut packet);
        }
        let _ = read(&packet, key, model);
    });
}

fn valid(kind: u8, model: &Model, packet: &mut Vec<u8>) -> Option<()> {
    let robot = fingerprint(model);
    let header = |kind| Header { kind, flags: 0, session: 7, sequence: 3, tick: 12, time: 0.012 };
    match kind {
        b'h' => {
            wire::begin(&header(Kind::Hello), packet);
            Hello { robot, rate: 1000.0 }.write(packet);
        }
        b'w' => {
            wire::begin(&header(Kind::Welcome), packet);
            Welcome { answers: 5, robot, rate: 1000.0, pace: 0.5, challenge: [9; 32] }.write(packet);
        }
        b'f' => {
            wire::begin(&header(Kind::Confirm), packet);
            Confirm { answers: 5, challenge: [9; 32] }.write(packet);
        }
        b'c' => {
            wire::begin(&header(Kind::Control), packet);
            write_control(&Command::hold(model, &model.home), Some(13), packet);
        }
        b's' | b'v' => {
            wire::begin(&header(Kind::Sensing), packet);
            let mut sensed = SensorReadings::blank(model);
            if kind == b'v' {
                sensed.base = Some(FrameMotion::default());
                sensed.soles.iter_mut().for_each(|sole| sole.resolved = true);
            }
            packet[7] |= write_sensing(&sensed, packet);
        }
        b'b' => wire::begin(&header(Kind::Bye), packet),
        _ => return None,
    }
    Some(())
}

/// Reads a packet as either side of the link does.
fn read(packet: &[u8], key: Option<&Key>, model: &Model) -> Result<(), wire::Rejection> {
    let (header, body) = wire::open(packet, key)?;
    assert!(header.time.is_finite(), "a time that is not finite");
    let mut again = Vec::new();
    wire::begin(&header, &mut again);
    match header.kind {
        Kind::Hello => {
            let hello = Hello::read(body)?;
            assert!(hello.rate.is_finite() && hello.rate > 0.0, "a rate of {}", hello.rate);
            hello.write(&mut again);
        }
        Kind::Welcome => {
            let welcome = Welcome::read(body)?;
            assert!(welcome.rate.is_finite() && welcome.rate > 0.0, "a rate of {}", welcome.rate);
            assert!(welcome.pace.is_finite() && welcome.pace >= 0.0, "a pace of {}", welcome.pace);
            welcome.write(&mut again);
        }
        Kind::Confirm => Confirm::read(body)?.write(&mut again),
        Kind::Control => {
            let mut command = Command::hold(model, &model.home);
            let next = read_control(body, &mut command)?;
            for column in [&command.position, &command.velocity, &command.effort, &command.kp, &command.kd] {
                assert!(column.iter().all(|x| x.is_finite()), "control that is not finite");
            }
            write_control(&command, next, &mut again);
        }
        Kind::Sensing => {
            let mut sensed = SensorReadings::blank(model);
            read_sensing(&header, body, &mut sensed)?;
            for column in [&sensed.position, &sensed.velocity, &sensed.load] {
                assert!(column.iter().all(|x| x.is_finite()), "sensing that is not finite");
            }
            let known = flags::BASE | flags::VERTICES;
            assert_eq!(write_sensing(&sensed, &mut again), header.flags & known, "flags");
        }
        Kind::Bye => again.extend_from_slice(body),
    }
    assert_eq!(&again[HEADER..], body, "the packet differs after reading and writing it");
    Ok(())
}
