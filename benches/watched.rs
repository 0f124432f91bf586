//! The cost of observing a run and of driving one over a link: HOAP-2 squats repeatedly, 1000
//! control ticks a second, 200 log instants a second. An iteration is a tenth of a second, **100
//! control ticks**: divide by 100 for the cost of one.

use divan::Bencher;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use stiction::assemble;
use stiction::log::{AttachedText, LogHeader, LogWriter, MessageSink, TopicGroups};
use stiction::remote::{Address, MotorServer, Pace, RobotClient};
use stiction::robot;
use stiction::scenario;
use stiction::sim::RemoteRun;
use stiction::sim::sensing::EstimatorSetup;
use stiction::sim::{NullObserver, Observer, Setup, Simulation};

/// 100 control ticks, s.
const TICKS: f64 = 0.1;

fn setup() -> Setup {
    setup_with("")
}

/// With further lines of the scenario.
fn setup_with(lines: &str) -> Setup {
    let text = format!(
        "duration = 1e6
        robot = {{ model = \"robots/hoap2/hoap2.toml\" }}
        {lines}
        [[task]]
        type = \"squat\"
        depth = 0.02
        period = 1.0
        repetitions = 1000000\n"
    );
    let root = crate::repository();
    let file = scenario::parse(&root.join("bench.toml"), &text).expect("our own scenario");
    let run = file.expand(&[]).expect("a single run").remove(0);
    let robot = robot::load(&run.resolve(&run.scenario.robot.model)).expect("our own robot");
    assemble::setup(&run, &robot).unwrap_or_else(|e| panic!("{e}"))
}

/// Times a tenth of a second of a continuing run.
fn each(bencher: Bencher, setup: Setup, observer: &mut dyn Observer) {
    let mut sim = Simulation::new(setup).expect("the physics can do it");
    sim.begin(observer).expect("it begins");
    let mut end = 0.5;
    let mut advance = |sim: &mut Simulation| {
        while sim.plant().state.time < end {
            sim.step(observer).expect("it steps");
        }
        end += TICKS;
    };
    advance(&mut sim);
    super::each(bencher, || advance(&mut sim));
}

/// A log in this folder, and other outputs.
pub fn log(setup: &Setup, folder: Option<&Path>, outlet: Option<Box<dyn MessageSink>>) -> LogWriter {
    let file = crate::repository().join("robots/hoap2/hoap2.urdf");
    let urdf = std::fs::read_to_string(file).expect("our own robot");
    let header = LogHeader {
        scenario_name: "bench",
        key: "bench",
        method: "exact",
        scenario: AttachedText { name: "bench.toml", text: "" },
        robot: None,
        urdf: AttachedText { name: "hoap2.urdf", text: &urdf },
        inputs: &[],
        floor: Some(nalgebra::Isometry3::identity()),
        patches: &[],
        objects: &[],
        terrain: &setup.terrain,
        topics: TopicGroups::ALL,
        viewer_rate: 50.0,
    };
    let path = folder.map(|folder| folder.join("log.mcap"));
    LogWriter::open(path.as_deref(), outlet, &setup.model, &header).expect("a log can be written")
}

/// No client, no log file.
#[divan::bench]
fn nothing(bencher: Bencher) {
    each(bencher, Setup { log_rate: 0.0, ..setup() }, &mut NullObserver);
}

#[divan::bench]
fn log_file(bencher: Bencher) {
    let (setup, folder) = (setup(), tempfile::tempdir().expect("a folder"));
    let mut log = log(&setup, Some(folder.path()), None);
    each(bencher, setup, &mut log);
}

/// `runner run --live --no-log` and `runner run --live`.
mod live {
    use super::*;
    use std::io::{Read, Write};
    use std::net::{SocketAddr, TcpStream};
    use std::time::Duration;

    #[derive(Debug, Clone, Copy, PartialEq)]
    enum Client {
        Absent,
        Reads,
        NeverReads,
    }

    const CLIENTS: [Client; 3] = [Client::Absent, Client::Reads, Client::NeverReads];

    /// Subscribes to all twenty topics.
    fn connect(at: SocketAddr) -> TcpStream {
        let mut stream = TcpStream::connect(at).expect("it listens");
        let request = "GET / HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
            Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\
            Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n";
        let subscriptions: Vec<String> = (0..20).map(|n| format!("{{\"id\":{n},\"channelId\":{n}}}")).collect();
        let text = format!("{{\"op\":\"subscribe\",\"subscriptions\":[{}]}}", subscriptions.join(","));
        let mut frame = vec![0x81, 0xfe];
        frame.extend((text.len() as u16).to_be_bytes());
        // Masked with zeros.
        frame.extend([0; 4]);
        frame.extend(text.as_bytes());
        stream.write_all(&[request.as_bytes(), &frame].concat()).expect("it reads");
        stream
    }

    fn watched(bencher: Bencher, client: Client, folder: Option<&Path>) {
        let setup = setup();
        let server = stiction::live::LiveServer::start("127.0.0.1:0".parse().expect("an address")).expect("it listens");
        let mut log = log(&setup, folder, Some(server.sink()));
        let stream = (client != Client::Absent).then(|| connect(server.address()));
        let is_connected =
            server.wait(Duration::from_secs(if stream.is_some() { 60 } else { 0 }), &AtomicBool::new(false));
        assert_eq!(is_connected, stream.is_some());
        let reader = stream.as_ref().filter(|_| client == Client::Reads).map(|stream| {
            let mut stream = stream.try_clone().expect("a second handle");
            std::thread::spawn(move || {
                let mut piece = vec![0; 1 << 20];
                while stream.read(&mut piece).is_ok_and(|length| length > 0) {}
            })
        });
        each(bencher, setup, &mut log);
        drop(log);
        let received = server.flush();
        eprint!(" [{received}] ");
        drop(server);
        reader.into_iter().for_each(|reader| reader.join().expect("it reads"));
    }

    #[divan::bench(args = CLIENTS)]
    fn alone(bencher: Bencher, client: Client) {
        watched(bencher, client, None);
    }

    #[divan::bench(args = CLIENTS)]
    fn with_log(bencher: Bencher, client: Client) {
        let folder = tempfile::tempdir().expect("a folder");
        watched(bencher, client, Some(folder.path()));
    }
}

/// The same robot driven by tasks in another thread, over UDP on loopback: each tick waits for its
/// command.
#[divan::bench]
fn lock_step(bencher: Bencher) {
    let free = Address { at: "127.0.0.1:0".parse().expect("an address"), key: None };
    let mut here = Setup { log_rate: 0.0, ..setup() };
    let server = MotorServer::bind(&free, &here.model, &here.tasks.command, (1000.0, Pace::Free), None, None);
    let mut server = server.expect("it binds");
    let at = server.local().expect("it has an address");
    // The thread ends when no packet arrives within its timeout.
    std::thread::spawn(move || {
        let there = Setup { log_rate: 0.0, ..setup() };
        let address = Address { at, key: None };
        let mut robot = RobotClient::connect(&address, &there.model, 1000.0, None, None).expect("the robot answers");
        RemoteRun::new(there).run(&mut robot, &mut NullObserver, &AtomicBool::new(false))
    });
    server.wait(None).expect("tasks come");
    here.command_source = Some(Box::new(server));
    here.estimator = EstimatorSetup::Truth;
    each(bencher, here, &mut NullObserver);
}
