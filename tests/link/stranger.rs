//! Tests of foreign packets: another process sends them during the session of a hand-written
//! client.

use std::net::UdpSocket;
use std::path::Path;
use std::time::Duration;

use stiction::remote::wire::{
    self, Confirm, Header, Hello, Kind, Welcome, fingerprint, flags, read_sensing, write_control,
};
use stiction::robot::{Model, load};
use stiction::task::{Command, SensorReadings};

use super::session::{Server, hoap2, motion};
use crate::cli::Place;

struct Client {
    socket: UdpSocket,
    session: u64,
    sequence: u64,
}

impl Client {
    fn new(port: u16) -> Self {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.connect(("127.0.0.1", port)).unwrap();
        // Far longer than a response takes, so a failing test does not hang.
        socket.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        Client { socket, session: 77, sequence: 0 }
    }

    fn send(&mut self, kind: Kind, tick: u64, body: impl FnOnce(&mut Vec<u8>)) {
        self.sequence += 1;
        let header = Header { kind, flags: 0, session: self.session, sequence: self.sequence, tick, time: 0.0 };
        let mut packet = Vec::new();
        wire::begin(&header, &mut packet);
        body(&mut packet);
        wire::end(None, &mut packet);
        self.socket.send(&packet).unwrap();
    }

    fn receive(&self) -> (Header, Vec<u8>) {
        let mut inbox = [0; 65_536];
        let length = self.socket.recv(&mut inbox).unwrap();
        let (header, body) = wire::open(&inbox[..length], None).unwrap();
        (header, body.to_vec())
    }

    fn greet(&mut self, model: &Model) {
        let hello = Hello { robot: fingerprint(model), rate: 100.0 };
        self.send(Kind::Hello, 0, |out| hello.write(out));
        let (header, body) = self.receive();
        let welcome = Welcome::read(&body).unwrap();
        assert_eq!((header.kind, welcome.answers, welcome.rate), (Kind::Welcome, 77, 100.0));
        self.session = header.session;
        let confirm = Confirm { answers: welcome.answers, challenge: welcome.challenge };
        self.send(Kind::Confirm, 0, |out| confirm.write(out));
    }
}

/// Holds the posture during a run of 0.1 s. Before each response `inject` may send packets.
fn hold(place: &Place, results: &str, inject: impl Fn(&Client, u16, u64, &Command)) -> String {
    let model = load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/hoap2/hoap2.toml")).unwrap().model;
    let server = Server::start(place, &["s.toml", "--set", "duration=0.1", "-o", results]);
    let mut client = Client::new(server.port);
    client.greet(&model);
    let command = Command::hold(&model, &model.home);
    let mut deviating = command.clone();
    deviating.position.iter_mut().for_each(|q| *q += 0.3);
    let mut answered = None;
    loop {
        let (header, body) = client.receive();
        if header.kind != Kind::Sensing {
            continue;
        }
        read_sensing(&header, &body, &mut SensorReadings::blank(&model)).unwrap();
        if header.flags & flags::LAST != 0 {
            client.send(Kind::Bye, header.tick, |_| ());
            break;
        }
        // Sent again since the answer is on its way.
        if answered == Some(header.tick) {
            continue;
        }
        inject(&client, server.port, header.tick, &deviating);
        answered = Some(header.tick);
        client.send(Kind::Control, header.tick, |out| write_control(&command, Some(header.tick + 1), out));
    }
    server.end().exits(0).stdout
}

/// Commands of another sender, session or tick are counted but have no effect, like a foreign
/// `Hello` and `Bye`.
#[test]
fn foreign_packets_have_no_effect() {
    let place = Place::new();
    hoap2(&place, "s.toml", "control = { rate = 100 }");
    let alone = hold(&place, "alone", |_, _, _, _| ());
    assert!(!alone.contains("dropped"), "{alone}");
    let control = |tick: u64, session: u64, deviating: &Command| {
        let mut packet = Vec::new();
        let header = Header { kind: Kind::Control, flags: 0, session, sequence: 1_000_000, tick, time: 0.0 };
        wire::begin(&header, &mut packet);
        write_control(deviating, Some(tick + 1), &mut packet);
        wire::end(None, &mut packet);
        packet
    };
    let output = hold(&place, "met", |client, port, tick, deviating| {
        let stranger = UdpSocket::bind("127.0.0.1:0").unwrap();
        stranger.send_to(&control(tick, client.session, deviating), ("127.0.0.1", port)).unwrap();
        let mut bye = Vec::new();
        let header = Header { kind: Kind::Bye, flags: 0, session: client.session, sequence: 1, tick, time: 0.0 };
        wire::begin(&header, &mut bye);
        wire::end(None, &mut bye);
        stranger.send_to(&bye, ("127.0.0.1", port)).unwrap();
        let mut hello = Vec::new();
        let header = Header { kind: Kind::Hello, flags: 0, session: 5, sequence: 1, tick: 0, time: 0.0 };
        wire::begin(&header, &mut hello);
        Hello { robot: [0; 32], rate: 100.0 }.write(&mut hello);
        wire::end(None, &mut hello);
        stranger.send_to(&hello, ("127.0.0.1", port)).unwrap();
        client.socket.send(&control(tick, client.session + 1, deviating)).unwrap();
        client.socket.send(&control(tick + 5, client.session, deviating)).unwrap();
    });
    // At each of ten ticks: three packets of another session and a `Hello`, and one command of
    // another tick.
    assert!(output.contains("40 dropped (other session)"), "{output}");
    assert!(output.contains("10 dropped (late or replayed)"), "{output}");
    assert_eq!(motion(&place, "alone", "s").rows, motion(&place, "met", "s").rows);
}
