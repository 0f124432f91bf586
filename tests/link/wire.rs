//! Tests of the packet format: packets are read bit for bit as written, and invalid ones rejected.

use std::path::Path;

use nalgebra::{UnitQuaternion, Vector3};
use stiction::dynamics::chain::FrameMotion;
use stiction::random::Stream;
use stiction::remote::wire::{
    self, Confirm, HEADER, Header, Hello, Key, Kind, Rejection, VERSION, Welcome, fingerprint, flags, read_control,
    read_sensing, session_of, write_control, write_sensing,
};
use stiction::robot::{DriveMode, Model, load};
use stiction::task::{Command, SensorReadings};

fn model() -> Model {
    load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/hoap2/hoap2.toml")).expect("HOAP-2 loads").model
}

fn key() -> Key {
    Key::of(b"sixteen bytes or more").expect("long enough")
}

const CONTROL: Header = Header { kind: Kind::Control, flags: 0, session: 7, sequence: 3, tick: 12, time: 0.012 };

/// A command of random numbers.
fn command(model: &Model, stream: &mut Stream) -> Command {
    let mut command = Command::hold(model, &model.home);
    let modes = [DriveMode::Position, DriveMode::Velocity, DriveMode::Force, DriveMode::Kinematic, DriveMode::Passive];
    for (j, mode) in command.mode.iter_mut().enumerate() {
        *mode = modes[j % 5];
    }
    for column in [&mut command.position, &mut command.velocity, &mut command.effort] {
        column.iter_mut().for_each(|x| *x = stream.normal());
    }
    for column in [&mut command.kp, &mut command.kd] {
        column.iter_mut().for_each(|x| *x = 100.0 * stream.unit());
    }
    command
}

fn vector(stream: &mut Stream) -> Vector3<f64> {
    Vector3::from_fn(|_, _| stream.normal())
}

fn sensed(model: &Model, stream: &mut Stream, base: bool, vertices: bool) -> SensorReadings {
    let mut sensed = SensorReadings::blank(model);
    sensed.time = 0.012;
    for column in [&mut sensed.position, &mut sensed.velocity, &mut sensed.load] {
        column.iter_mut().for_each(|x| *x = stream.normal());
    }
    sensed.orientation = UnitQuaternion::from_scaled_axis(vector(stream));
    (sensed.angular_velocity, sensed.specific_force) = (vector(stream), vector(stream));
    if base {
        sensed.base = Some(FrameMotion {
            position: vector(stream),
            rotation: UnitQuaternion::from_scaled_axis(vector(stream)),
            velocity: vector(stream),
            omega: vector(stream),
        });
    }
    for sole in &mut sensed.soles {
        (sole.force, sole.mean_force, sole.moment) = (vector(stream), vector(stream), vector(stream));
        sole.resolved = vertices;
        if vertices {
            sole.vertices.iter_mut().for_each(|force| *force = vector(stream));
            sole.clamped.iter_mut().enumerate().for_each(|(i, clamped)| *clamped = i % 2 == 0);
        } else {
            // Sensors that do not resolve a sole report one state for it.
            sole.clamped.fill(stream.unit() < 0.5);
        }
    }
    sensed
}

fn control_packet(command: &Command, next: Option<u64>, key: Option<&Key>) -> Vec<u8> {
    let mut out = Vec::new();
    wire::begin(&CONTROL, &mut out);
    write_control(command, next, &mut out);
    wire::end(key, &mut out);
    out
}

fn sensing_packet(sensed: &SensorReadings) -> Vec<u8> {
    let mut out = Vec::new();
    wire::begin(&Header { kind: Kind::Sensing, ..CONTROL }, &mut out);
    let set = write_sensing(sensed, &mut out);
    out[7] |= set;
    wire::end(None, &mut out);
    out
}

#[test]
fn control_round_trips_bit_for_bit() {
    let model = model();
    let mut stream = Stream::new(1, &["wire"]);
    for key in [None, Some(key())] {
        for next in [None, Some(0), Some(13), Some(u64::MAX - 1)] {
            let command = command(&model, &mut stream);
            let packet = control_packet(&command, next, key.as_ref());
            let (header, body) = wire::open(&packet, key.as_ref()).unwrap();
            let set = if key.is_some() { flags::AUTHENTICATED } else { 0 };
            assert_eq!(header, Header { flags: set, ..CONTROL });
            let mut read = Command::hold(&model, &model.home);
            assert_eq!(read_control(body, &mut read), Ok(next));
            assert_eq!(read, command);
        }
    }
}

#[test]
fn sensing_round_trips_bit_for_bit() {
    let model = model();
    let mut stream = Stream::new(2, &["wire"]);
    for (base, vertices) in [(false, false), (true, false), (false, true), (true, true)] {
        let expected = sensed(&model, &mut stream, base, vertices);
        let packet = sensing_packet(&expected);
        let (header, body) = wire::open(&packet, None).unwrap();
        let mut read = SensorReadings::blank(&model);
        read_sensing(&header, body, &mut read).unwrap();
        assert_eq!(read, expected);
    }
}

#[test]
fn packets_of_the_handshake_round_trip() {
    let robot = fingerprint(&model());
    let challenge: [u8; 32] = std::array::from_fn(|at| at as u8 + 1);
    let hello = Hello { robot, rate: 500.0 };
    let welcome = Welcome { answers: 9, robot, rate: 500.0, pace: 0.5, challenge };
    let confirm = Confirm { answers: 9, challenge };
    let [mut a, mut b, mut c] = [const { Vec::new() }; 3];
    hello.write(&mut a);
    welcome.write(&mut b);
    confirm.write(&mut c);
    assert_eq!((Hello::read(&a), Welcome::read(&b), Confirm::read(&c)), (Ok(hello), Ok(welcome), Ok(confirm)));
    for (body, read) in [
        (&mut a, &(|body: &[u8]| Hello::read(body).map(|_| ())) as &dyn Fn(&[u8]) -> Result<(), Rejection>),
        (&mut b, &|body| Welcome::read(body).map(|_| ())),
        (&mut c, &|body| Confirm::read(body).map(|_| ())),
    ] {
        for cut in 0..body.len() {
            assert_eq!(read(&body[..cut]), Err(Rejection::Length));
        }
        body.push(0);
        assert_eq!(read(body), Err(Rejection::Length));
    }
}

/// The layout of docs/wire.md, byte by byte.
#[test]
fn packets_of_the_handshake_have_the_documented_bytes() {
    let (robot, challenge) = ([0xab; 32], std::array::from_fn(|at| at as u8 + 1));
    let packet = |kind, body: &dyn Fn(&mut Vec<u8>)| {
        let mut out = Vec::new();
        let header = Header { kind, flags: 0, session: session_of(&challenge), sequence: 2, tick: 3, time: 1.0 };
        wire::begin(&header, &mut out);
        body(&mut out);
        wire::end(None, &mut out);
        out
    };
    let header = |kind: u8, length: u8| {
        let mut bytes = b"stic\x02\x00".to_vec();
        bytes.extend([kind, 0, length, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8]);
        bytes.extend([2, 0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f]);
        bytes
    };
    let (answers, one) = ([9, 0, 0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0, 0xf0, 0x3f]);
    assert_eq!(
        packet(Kind::Hello, &|out| Hello { robot, rate: 1.0 }.write(out)),
        [&header(1, 88)[..], &robot, &one].concat()
    );
    assert_eq!(
        packet(Kind::Welcome, &|out| Welcome { answers: 9, robot, rate: 1.0, pace: 1.0, challenge }.write(out)),
        [&header(2, 136)[..], &answers, &robot, &one, &one, &challenge].concat()
    );
    assert_eq!(
        packet(Kind::Confirm, &|out| Confirm { answers: 9, challenge }.write(out)),
        [&header(6, 88)[..], &answers, &challenge].concat()
    );
}

/// Rejects every wrong length, whether the header states the true length or not.
#[test]
fn rejects_truncated_and_padded_packets() {
    let model = model();
    let mut stream = Stream::new(3, &["wire"]);
    let control = control_packet(&command(&model, &mut stream), Some(1), None);
    let sensing = sensing_packet(&sensed(&model, &mut stream, true, true));
    let mut command = Command::hold(&model, &model.home);
    let mut blank = SensorReadings::blank(&model);
    for packet in [&control, &sensing] {
        for length in (0..packet.len()).chain([packet.len() + 1, packet.len() + 8]) {
            let mut changed = packet.clone();
            changed.resize(length, 0);
            assert_eq!(wire::open(&changed, None), Err(Rejection::Length), "{length}");
            if length < HEADER {
                continue;
            }
            // The header states the wrong length as well.
            changed[8..12].copy_from_slice(&(length as u32).to_le_bytes());
            let (header, body) = wire::open(&changed, None).unwrap();
            let result = match header.kind {
                Kind::Control => read_control(body, &mut command).map(|_| ()),
                _ => read_sensing(&header, body, &mut blank),
            };
            // Zeros in place of the removed bytes may also be invalid values.
            assert!(matches!(result, Err(Rejection::Length | Rejection::Value)), "{length}: {result:?}");
        }
    }
}

#[test]
fn invalid_headers_have_the_right_error() {
    let model = model();
    let packet = control_packet(&command(&model, &mut Stream::new(4, &["wire"])), None, None);
    let with = |at: usize, bytes: &[u8]| {
        let mut changed = packet.clone();
        changed[at..at + bytes.len()].copy_from_slice(bytes);
        wire::open(&changed, None).map(|_| ())
    };
    assert_eq!(with(0, b"STIC"), Err(Rejection::Foreign));
    for version in [1, VERSION + 1] {
        assert_eq!(with(4, &version.to_le_bytes()), Err(Rejection::Version));
    }
    assert_eq!(with(6, &[0]), Err(Rejection::Foreign));
    assert_eq!(with(6, &[7]), Err(Rejection::Foreign));
    assert_eq!(with(7, &[64]), Err(Rejection::Value), "an unknown flag");
    assert_eq!(with(12, &[1]), Err(Rejection::Value), "a reserved field");
    assert_eq!(with(40, &f64::NAN.to_le_bytes()), Err(Rejection::Value));
    assert_eq!(with(40, &f64::INFINITY.to_le_bytes()), Err(Rejection::Value));
    assert_eq!(wire::open(b"", None), Err(Rejection::Length));
    assert_eq!(wire::open(b"GET / HTTP/1.1\r\n", None), Err(Rejection::Foreign));
}

/// Replaces each number by an invalid one; only gains must not be negative.
#[test]
fn rejects_invalid_numbers() {
    let model = model();
    let n = model.nj();
    let packet = control_packet(&command(&model, &mut Stream::new(5, &["wire"])), None, None);
    let first = HEADER + 8 + 4 + n;
    let mut read = Command::hold(&model, &model.home);
    for number in 0..5 * n {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0] {
            let mut changed = packet.clone();
            changed[first + 8 * number..first + 8 * number + 8].copy_from_slice(&bad.to_le_bytes());
            let (_, body) = wire::open(&changed, None).unwrap();
            let gain = number >= 3 * n;
            let expected = if bad.is_finite() && !gain { Ok(None) } else { Err(Rejection::Value) };
            assert_eq!(read_control(body, &mut read), expected, "{number} {bad}");
        }
    }
    let mut changed = packet.clone();
    changed[HEADER + 12] = 5;
    assert_eq!(read_control(wire::open(&changed, None).unwrap().1, &mut read), Err(Rejection::Value), "a mode");
    let other = model.nj() as u32 + 1;
    let mut changed = packet;
    changed[HEADER + 8..HEADER + 12].copy_from_slice(&other.to_le_bytes());
    assert_eq!(read_control(wire::open(&changed, None).unwrap().1, &mut read), Err(Rejection::Length), "joints");
}

#[test]
fn rejects_quaternions_that_are_not_unit() {
    let model = model();
    let mut stream = Stream::new(6, &["wire"]);
    let packet = sensing_packet(&sensed(&model, &mut stream, true, true));
    let orientation = HEADER + 8 + 8 * 3 * model.nj();
    let base = orientation + 8 * (4 + 3 + 3 + 3);
    for at in [orientation, base] {
        let mut changed = packet.clone();
        changed[at..at + 8].copy_from_slice(&1.5f64.to_le_bytes());
        let (header, body) = wire::open(&changed, None).unwrap();
        assert_eq!(read_sensing(&header, body, &mut SensorReadings::blank(&model)), Err(Rejection::Value));
    }
}

/// With a key, rejects a packet with any changed bit, without a tag, or with the tag of another
/// key.
#[test]
fn authentication_detects_every_change() {
    let model = model();
    let command = command(&model, &mut Stream::new(7, &["wire"]));
    let (key, other) = (key(), Key::of(b"another secret of some length").unwrap());
    let authenticated = control_packet(&command, None, Some(&key));
    assert!(wire::open(&authenticated, Some(&key)).is_ok());
    for bit in 0..8 * authenticated.len() {
        let mut changed = authenticated.clone();
        changed[bit / 8] ^= 1 << (bit % 8);
        assert!(wire::open(&changed, Some(&key)).is_err(), "bit {bit}");
    }
    assert_eq!(wire::open(&authenticated, Some(&other)), Err(Rejection::Tag));
    assert_eq!(
        wire::open(&authenticated, None),
        Err(Rejection::Tag),
        "a receiver without the key rejects authenticated packets"
    );
    assert_eq!(wire::open(&control_packet(&command, None, None), Some(&key)), Err(Rejection::Tag));
    assert!(Key::of(b"fifteen bytes..").is_none() && Key::of(b"sixteen bytes...").is_some());
}

/// Random bytes, with and without a valid header: the reader may reject them but must not panic.
#[test]
fn random_bytes_do_not_panic() {
    let model = model();
    let mut stream = Stream::new(8, &["wire"]);
    let valid = sensing_packet(&sensed(&model, &mut stream, true, true));
    let mut blank = SensorReadings::blank(&model);
    let mut command = Command::hold(&model, &model.home);
    for round in 0..20_000 {
        let mut bytes: Vec<u8> = if round % 2 == 0 {
            (0..stream.below(200)).map(|_| stream.below(256) as u8).collect()
        } else {
            let mut bytes = valid.clone();
            for _ in 0..1 + stream.below(4) {
                let at = stream.below(bytes.len() as u64) as usize;
                bytes[at] = stream.below(256) as u8;
            }
            bytes
        };
        if round % 4 == 2 && bytes.len() >= HEADER {
            bytes[..6].copy_from_slice(&valid[..6]);
            let length = bytes.len() as u32;
            bytes[8..12].copy_from_slice(&length.to_le_bytes());
            bytes[12..16].fill(0);
        }
        let Ok((header, body)) = wire::open(&bytes, None) else { continue };
        let _ = read_sensing(&header, body, &mut blank);
        let _ = read_control(body, &mut command);
        let _ = (Hello::read(body), Welcome::read(body), Confirm::read(body));
    }
}

/// Rejects flags of sensing on other packets.
#[test]
fn rejects_flags_of_another_kind() {
    let model = model();
    let mut stream = Stream::new(9, &["wire"]);
    let packet = control_packet(&command(&model, &mut stream), None, None);
    for flag in [flags::BASE, flags::VERTICES, flags::LAST] {
        let mut other = packet.clone();
        other[7] |= flag;
        assert_eq!(wire::open(&other, None), Err(Rejection::Value), "{flag}");
    }
    assert!(wire::open(&packet, None).is_ok());
}

#[test]
fn fingerprints_of_different_robots_differ() {
    let hoap2 = model();
    let mut other = hoap2.clone();
    other.joints[3].name.push('x');
    assert!(fingerprint(&hoap2) == fingerprint(&model()) && fingerprint(&other) != fingerprint(&hoap2));
    let mut other = hoap2.clone();
    other.soles[1].vertices.pop();
    assert!(fingerprint(&other) != fingerprint(&hoap2));
}
