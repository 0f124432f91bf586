//! Packets of the link between tasks and a robot, as a socket gives them: raw, or sound ones of each kind with some of their
//! bytes exchanged, so that what lies behind lengths and seals is reached too.
//!
//! Whatever is taken is written again, and must come out as it came in.

use stiction::dynamics::chain::FrameMotion;
use stiction::remote::wire::{
    self, HEADER, Header, Hello, Key, Kind, Welcome, fingerprint, flags, read_control, read_sensing, write_control,
    write_sensing,
};
use stiction::robot::Model;
use stiction::task::{Command, Sensed};

use super::tree;

/// Letters of the first byte: what the rest is laid over.
pub const KINDS: [u8; 7] = *b"rhwcsvb";
/// Letters of the second: no key; a key, and the seal of the sound packet; sealed anew; no key, and its length set anew.
pub const SEALS: [u8; 4] = *b"nksl";

thread_local! {
    static MODEL: Model = tree::robot(&tree::run("robot.model = \"../robots/hoap2/hoap2.toml\"")).expect("HOAP-2").model.clone();
}

/// Takes two letters and the bytes of a packet, or for kinds other than `r` how much longer or shorter it is than a sound
/// one (a signed byte) and changes of it: twice a byte for the place, and one for what stands there.
pub fn take(data: &[u8]) {
    let [kind, seal, rest @ ..] = data else { return };
    MODEL.with(|model| {
        let key = Key::of(b"a secret of the fuzz target").expect("long enough");
        let key = matches!(seal, b'k' | b's').then_some(&key);
        let mut packet = Vec::new();
        if *kind == b'r' {
            packet.extend_from_slice(rest);
        } else {
            let Some(()) = sound(*kind, model, &mut packet) else { return };
            wire::end(key.filter(|_| *seal == b'k'), &mut packet);
            let [longer, changes @ ..] = rest else { return };
            packet.resize(packet.len().saturating_add_signed(isize::from(*longer as i8)), 0x5a);
            for change in changes.chunks_exact(3) {
                let at = usize::from(u16::from_le_bytes([change[0], change[1]]));
                if let Some(byte) = packet.get_mut(at) {
                    *byte = change[2];
                }
            }
        }
        if matches!(seal, b's' | b'l') && packet.len() >= HEADER {
            wire::end(key, &mut packet);
        }
        let _ = look(&packet, key, model);
    });
}

fn sound(kind: u8, model: &Model, packet: &mut Vec<u8>) -> Option<()> {
    let robot = fingerprint(model);
    let header = |kind| Header { kind, flags: 0, session: 7, sequence: 3, tick: 12, time: 0.012 };
    match kind {
        b'h' => {
            wire::begin(&header(Kind::Hello), packet);
            Hello { robot, rate: 1000.0 }.write(packet);
        }
        b'w' => {
            wire::begin(&header(Kind::Welcome), packet);
            Welcome { answers: 5, robot, rate: 1000.0, pace: 0.5 }.write(packet);
        }
        b'c' => {
            wire::begin(&header(Kind::Control), packet);
            write_control(&Command::hold(model, &model.home), Some(13), packet);
        }
        b's' | b'v' => {
            wire::begin(&header(Kind::Sensing), packet);
            let mut sensed = Sensed::blank(model);
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

/// What either side does with a packet that came.
fn look(packet: &[u8], key: Option<&Key>, model: &Model) -> Result<(), wire::Refused> {
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
        Kind::Control => {
            let mut command = Command::hold(model, &model.home);
            let next = read_control(body, &mut command)?;
            for column in [&command.position, &command.velocity, &command.effort, &command.kp, &command.kd] {
                assert!(column.iter().all(|x| x.is_finite()), "control that is not finite");
            }
            write_control(&command, next, &mut again);
        }
        Kind::Sensing => {
            let mut sensed = Sensed::blank(model);
            read_sensing(&header, body, &mut sensed)?;
            for column in [&sensed.position, &sensed.velocity, &sensed.load] {
                assert!(column.iter().all(|x| x.is_finite()), "sensing that is not finite");
            }
            let known = flags::BASE | flags::VERTICES;
            assert_eq!(write_sensing(&sensed, &mut again), header.flags & known, "flags");
        }
        Kind::Bye => again.extend_from_slice(body),
    }
    assert_eq!(&again[HEADER..], body, "what was read is not what is written");
    Ok(())
}
