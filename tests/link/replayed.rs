//! Tests of recorded packets that are sent again: they neither begin nor end nor replace a session.

use std::net::{SocketAddr, UdpSocket};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use stiction::remote::wire::{self, Confirm, Header, Hello, Key, Kind, Welcome, fingerprint, session_of};
use stiction::remote::{Address, LinkError, MotorServer, Pace, RobotClient};
use stiction::robot::{Model, load};
use stiction::task::Command;

use super::session::{Server, hoap2, motion};
use crate::cli::Place;

const SECRET: &str = "a secret of both sides";

fn key() -> Key {
    Key::of(SECRET.as_bytes()).unwrap()
}

fn model() -> Model {
    load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/hoap2/hoap2.toml")).unwrap().model
}

fn packet(kind: Kind, (session, sequence): (u64, u64), key: Option<&Key>, body: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let mut out = Vec::new();
    wire::begin(&Header { kind, flags: 0, session, sequence, tick: 0, time: 0.0 }, &mut out);
    body(&mut out);
    wire::end(key, &mut out);
    out
}

fn hello(number: u64, model: &Model) -> Vec<u8> {
    let hello = Hello { robot: fingerprint(model), rate: 1000.0 };
    packet(Kind::Hello, (number, 1), Some(&key()), |out| hello.write(out))
}

fn confirm(session: u64, confirm: Confirm) -> Vec<u8> {
    packet(Kind::Confirm, (session, 2), Some(&key()), |out| confirm.write(out))
}

/// A socket that sends recorded packets, and reads the packets of the server.
struct Recorded(UdpSocket);

impl Recorded {
    fn new(server: SocketAddr) -> Self {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.connect(server).unwrap();
        // Far longer than an answer takes, so a failing test does not hang.
        socket.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        Recorded(socket)
    }

    /// Sends a hello and receives the welcome, which shows that all earlier packets were read and
    /// that the server still waits.
    fn greet(&self, hello: &[u8]) -> Welcome {
        self.0.send(hello).unwrap();
        let mut inbox = [0; 65_536];
        let length = self.0.recv(&mut inbox).expect("the server waits for a client");
        let (header, body) = wire::open(&inbox[..length], Some(&key())).unwrap();
        let welcome = Welcome::read(body).unwrap();
        assert_eq!((header.kind, header.session), (Kind::Welcome, session_of(&welcome.challenge)));
        welcome
    }
}

/// A server that waits for a client in another thread.
struct Waiting {
    at: SocketAddr,
    cancel: Arc<AtomicBool>,
    thread: JoinHandle<(MotorServer, Result<(), LinkError>)>,
}

impl Waiting {
    fn start(model: &Model, key: Option<Key>) -> Self {
        let cancel = Arc::new(AtomicBool::new(false));
        let address = Address { at: "127.0.0.1:0".parse().unwrap(), key };
        let command = Command::hold(model, &model.home);
        let pace = (1000.0, Pace::Free);
        let mut server = MotorServer::bind(&address, model, &command, pace, None, Some(cancel.clone())).unwrap();
        let at = server.local().unwrap();
        let thread = std::thread::spawn(move || {
            let result = server.wait(None);
            (server, result)
        });
        Waiting { at, cancel, thread }
    }

    /// Ends the wait, which must have lasted so far.
    fn cancel(self) -> MotorServer {
        self.cancel.store(true, Ordering::Relaxed);
        let (server, result) = self.thread.join().unwrap();
        assert!(matches!(result, Err(LinkError::Cancelled)), "the wait has ended: {result:?}");
        server
    }
}

/// The packets of a session, recorded at one server, begin none at another.
#[test]
fn a_recorded_session_begins_no_other() {
    let model = model();
    let first = Waiting::start(&model, Some(key()));
    let client = Recorded::new(first.at);
    let recorded_hello = hello(7, &model);
    let welcome = client.greet(&recorded_hello);
    let recorded = confirm(session_of(&welcome.challenge), Confirm { answers: 7, challenge: welcome.challenge });
    client.0.send(&recorded).unwrap();
    let (_, began) = first.thread.join().unwrap();
    began.expect("the confirm begins the session");

    let second = Waiting::start(&model, Some(key()));
    let attacker = Recorded::new(second.at);
    for _ in 0..1000 {
        attacker.greet(&recorded_hello);
        attacker.0.send(&recorded).unwrap();
    }
    attacker.greet(&recorded_hello);
    let counts = second.cancel().counts();
    assert_eq!(counts.rejected(wire::Rejection::Session), 1000, "{counts}");
}

/// A confirm that returns anything but its own challenge begins no session.
#[test]
fn wrong_answers_to_the_challenge_are_ignored() {
    let model = model();
    let server = Waiting::start(&model, Some(key()));
    let (client, other) = (Recorded::new(server.at), Recorded::new(server.at));
    let Welcome { challenge, .. } = client.greet(&hello(7, &model));
    let mut changed = challenge;
    changed[31] ^= 1;
    let right = Confirm { answers: 7, challenge };
    let session = session_of(&challenge);
    client.0.send(&confirm(session, Confirm { challenge: changed, ..right })).unwrap();
    client.0.send(&confirm(session, Confirm { answers: 8, ..right })).unwrap();
    client.0.send(&confirm(session + 1, right)).unwrap();
    client.0.send(&packet(Kind::Confirm, (session, 2), None, |out| right.write(out))).unwrap();
    client.0.send(&packet(Kind::Control, (session, 2), Some(&key()), |_| ())).unwrap();
    // The right answer from another port.
    other.0.send(&confirm(session, right)).unwrap();
    other.greet(&hello(7, &model));
    let mut again = client.greet(&hello(7, &model));
    again.challenge[0] ^= 1;
    client.0.send(&confirm(session_of(&again.challenge), Confirm { answers: 7, challenge: again.challenge })).unwrap();
    // The right one begins the session.
    client.0.send(&confirm(session, right)).unwrap();
    let (server, began) = server.thread.join().unwrap();
    began.unwrap();
    let counts = server.counts();
    let rejected = [wire::Rejection::Session, wire::Rejection::Tag].map(|reason| counts.rejected(reason));
    assert_eq!((rejected, counts.received), ([6, 1], 1), "{counts}");
}

/// Thousands of recorded hellos before and during a run: the client connects, and the run has the
/// bits of a local one.
#[test]
fn replayed_hellos_do_not_disturb_a_run() {
    let place = Place::new();
    place.write("key", SECRET);
    let task = "task = [{ type = \"squat\", start = 0.1, depth = 0.02, period = 0.6, repetitions = 1 }]";
    hoap2(&place, "s.toml", task);
    place.runner(&["s.toml", "--set", "duration=0.4", "-o", "l"]).exits(0);
    let server = Server::start(&place, &["s.toml", "--set", "duration=0.4", "-o", "r", "--key", "key"]);
    let at = SocketAddr::from(([127, 0, 0, 1], server.port));
    let recorded = hello(7, &model());
    let before: Vec<_> = (0..4).map(|_| Recorded::new(at)).collect();
    for _ in 0..500 {
        for attacker in &before {
            attacker.greet(&recorded);
        }
    }
    let stop = Arc::new(AtomicBool::new(false));
    let flood = {
        let (stop, recorded) = (stop.clone(), recorded.clone());
        std::thread::spawn(move || {
            let mut sent = 0;
            while !stop.load(Ordering::Relaxed) {
                // An error is that of a server that has ended.
                before.iter().for_each(|attacker| drop(attacker.0.send(&recorded)));
                sent += before.len();
                // Some thousands a second.
                std::thread::sleep(Duration::from_micros(500));
            }
            sent
        })
    };
    let backend = format!("robot.backend=\"udp://127.0.0.1:{}\"", server.port);
    let more = ["--set", "robot.backend_key=\"key\"", "-o", "t"];
    let done =
        place.runner(&[&["s.toml", "--set", "duration=0.4", "--set", backend.as_str()][..], &more].concat()).exits(0);
    let there = server.end().exits(0);
    stop.store(true, Ordering::Relaxed);
    let sent = flood.join().unwrap();
    assert!(sent > 100 && there.stdout.contains("dropped (other session)"), "{sent}: {}", there.stdout);
    // On a busy machine the server repeats a sensing after 4 ms; the client drops the second one.
    let dropped: Vec<&str> = done.stdout.split(", ").filter(|part| part.contains("dropped")).collect();
    assert!(dropped.iter().all(|part| part.contains("dropped (late or replayed)")), "{}", done.stdout);
    assert_eq!(motion(&place, "l", "s").rows, motion(&place, "r", "s").rows);
}

/// A hello of version 1 is answered by a packet of version 2, and the error of the client names the
/// version.
#[test]
fn other_versions_are_reported() {
    let model = model();
    let server = Waiting::start(&model, None);
    let client = Recorded::new(server.at);
    let body = Hello { robot: fingerprint(&model), rate: 1000.0 };
    let mut old = packet(Kind::Hello, (7, 1), None, |out| body.write(out));
    old[4] = 1;
    client.0.send(&old).unwrap();
    let mut inbox = [0; 65_536];
    let length = client.0.recv(&mut inbox).unwrap();
    let (header, _) = wire::open(&inbox[..length], None).unwrap();
    assert_eq!((header.kind, header.session), (Kind::Bye, 7));
    assert!(length < old.len(), "{length} bytes");
    // Other packets of version 1, and hellos shorter than the answer can be, have none.
    for kind in [Kind::Bye, Kind::Control] {
        let mut other = packet(kind, (7, 2), None, |out| body.write(out));
        other[4] = 1;
        client.0.send(&other).unwrap();
    }
    let mut short = packet(Kind::Hello, (7, 3), None, |_| ());
    short[4] = 1;
    client.0.send(&short).unwrap();
    client.0.send(&packet(Kind::Hello, (8, 4), None, |out| body.write(out))).unwrap();
    let length = client.0.recv(&mut inbox).unwrap();
    assert_eq!(wire::open(&inbox[..length], None).unwrap().0.kind, Kind::Welcome);
    server.cancel();

    // A server of version 1 that answers.
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let at = socket.local_addr().unwrap();
    let thread = std::thread::spawn(move || {
        let mut inbox = [0; 65_536];
        let (_, from) = socket.recv_from(&mut inbox).unwrap();
        let mut bye = packet(Kind::Bye, (7, 1), None, |_| ());
        bye[4] = 1;
        socket.send_to(&bye, from).unwrap();
        socket
    });
    let error = RobotClient::connect(&Address { at, key: None }, &model, 1000.0, None, None).map(|_| ()).unwrap_err();
    drop(thread.join().unwrap());
    let text = error.to_string();
    assert!(text.ends_with("; 1 dropped (other version): both sides need wire format 2"), "{text}");
}
