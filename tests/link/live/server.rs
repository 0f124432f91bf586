//! Tests of the live server as a library: late clients, time that goes back, allocations.

use std::time::{Duration, Instant};

use stiction::live::LiveServer;
use stiction::log::{ChannelInfo, LogWriter, MessageSink, TopicGroups};
use stiction::sim::Observer;

use super::viewer::{ServerMessage, Viewer};
use crate::record::sample;
use crate::support::counting::count;

fn server() -> LiveServer {
    LiveServer::start("127.0.0.1:0".parse().unwrap()).unwrap()
}

fn writer(sink: Box<dyn MessageSink>) -> LogWriter {
    LogWriter::open(None, Some(sink), &sample::model(), &sample::header(TopicGroups::ALL)).unwrap()
}

/// Waits until another thread has made a condition true.
#[track_caller]
fn until(mut done: impl FnMut() -> bool) {
    let end = Instant::now() + Duration::from_secs(60);
    while !done() {
        assert!(Instant::now() < end, "the condition stays false");
        std::thread::yield_now();
    }
}

/// Receives messages until one of this topic and time; returns their topics and times.
fn receive_until(viewer: &mut Viewer, topic: &str, time: u64) -> Vec<String> {
    let mut all = Vec::new();
    loop {
        match viewer.receive().expect("another message") {
            ServerMessage::Text(text) => all.push(text["op"].to_string()),
            ServerMessage::Time(time) => all.push(format!("time {time}")),
            ServerMessage::Data(t, at, _) => {
                all.push(format!("{t} {at}"));
                if t == topic && at == time {
                    return all;
                }
            }
        }
    }
}

#[test]
fn a_late_client_receives_the_retained_messages() {
    let server = server();
    let mut log = writer(server.sink());
    (0..3).for_each(|tick| log.snapshot(&sample::snapshot(tick)).unwrap());
    let mut viewer = Viewer::connect(server.address().port(), "foxglove.sdk.v1");
    // The first snapshot opens this topic; without subscribers it was not sent.
    until(|| viewer.topics().contains_key("/self_collision") || viewer.receive().is_none());
    viewer.subscribe(|topic| ["/scene", "/robot_description", "/state"].contains(&topic));
    until(|| server.subscriptions() == 3);
    log.snapshot(&sample::snapshot(3)).unwrap();
    let (state, time) = ("/state", 15_000_000);
    assert_eq!(
        receive_until(&mut viewer, state, time),
        ["/robot_description 0", "/scene 0", "time 15000000", "/state 15000000"]
    );
    // A second client must not affect the first.
    let mut second = Viewer::connect(server.address().port(), "foxglove.sdk.v1");
    second.subscribe(|topic| topic == "/scene");
    assert!(receive_until(&mut second, "/scene", 0).contains(&"time 15000000".to_owned()));
    // Both stay connected without subscriptions.
    viewer.unsubscribe();
    second.unsubscribe();
    // Requests are answered in order, so this status shows that the earlier ones were handled.
    second.send(&serde_json::json!({ "op": "subscribe", "subscriptions": [{ "id": 7, "channelId": 700 }] }));
    viewer.send(&serde_json::json!({ "op": "subscribe", "subscriptions": [{ "id": 7, "channelId": 700 }] }));
    for viewer in [&mut viewer, &mut second] {
        assert!(matches!(viewer.receive(), Some(ServerMessage::Text(text)) if text["op"] == "status"));
    }
    log.snapshot(&sample::snapshot(4)).unwrap();
    drop(log);
    let counts = server.flush();
    assert_eq!((counts.clients, counts.sent, counts.dropped, counts.missed), (2, 4, 0, 0));
    drop(server);
    assert_eq!((viewer.receive(), second.receive()), (None, None));
}

/// An interactive run jumps back, then another run begins without the topics of the scene.
#[test]
fn time_may_go_back_and_another_run_may_begin() {
    let server = server();
    let mut log = writer(server.sink());
    let mut viewer = Viewer::connect(server.address().port(), "foxglove.sdk.v1");
    viewer.subscribe(|topic| topic == "/scene" || topic == "/state");
    until(|| server.subscriptions() == 2);
    [0, 4, 2].iter().for_each(|tick| log.snapshot(&sample::snapshot(*tick)).unwrap());
    let all = receive_until(&mut viewer, "/state", 10_000_000);
    // The first snapshot opens the advertised topic.
    let expected = [
        "/scene 0",
        "\"advertise\"",
        "time 0",
        "/state 0",
        "time 20000000",
        "/state 20000000",
        "time 10000000",
        "/scene 0",
        "/state 10000000",
    ];
    let of = |part: &str| all.iter().filter(|text| text.contains(part)).cloned().collect::<Vec<_>>();
    assert_eq!(of(" "), expected.into_iter().filter(|text| text.contains(' ')).collect::<Vec<_>>());
    assert_eq!(of("advertise").len(), 1);
    drop(log);
    let header = sample::header(TopicGroups { scene: false, ..TopicGroups::ALL });
    let mut log = LogWriter::open(None, Some(server.sink()), &sample::model(), &header).unwrap();
    log.snapshot(&sample::snapshot(1)).unwrap();
    let all = receive_until(&mut viewer, "/state", 5_000_000);
    assert!(all.contains(&"\"unadvertise\"".to_owned()), "{all:?}");
    assert_eq!(all.last().unwrap(), "/state 5000000", "the topic is still subscribed");
    let topics: Vec<String> = viewer.topics().into_keys().collect();
    assert!(!topics.iter().any(|topic| topic.starts_with("/scene")) && topics.len() == 8, "{topics:?}");
}

/// A sink that discards all messages.
struct Discard;

impl MessageSink for Discard {
    fn open_channel(&mut self, _: &ChannelInfo) -> u32 {
        0
    }
    fn end_description(&mut self) {}
    fn has_subscribers(&self) -> bool {
        true
    }
    fn is_subscribed(&self, _: u32) -> bool {
        true
    }
    fn message(&mut self, _: u32, _: u64, _: &[u8]) {}
    fn end_tick(&mut self, _: u64) {}
}

/// The simulating thread allocates nothing for clients, and encodes nothing without subscribers.
#[test]
fn nothing_is_allocated_for_clients() {
    let snapshots: Vec<_> = (0..200).map(sample::snapshot).collect();
    let server = server();
    let mut log = writer(server.sink());
    log.snapshot(&snapshots[0]).unwrap();
    assert_eq!(count(|| snapshots.iter().for_each(|s| log.snapshot(s).unwrap())), 0, "without subscribers");

    let mut encoding = writer(Box::new(Discard));
    snapshots.iter().for_each(|s| encoding.snapshot(s).unwrap());
    let mut viewer = Viewer::connect(server.address().port(), "foxglove.sdk.v1");
    until(|| viewer.topics().len() > 10 || viewer.receive().is_none());
    viewer.subscribe(|_| true);
    until(|| server.subscriptions() > 10);
    // In the first round the buffers grow to their size.
    for round in 0..2 {
        for (at, s) in snapshots.iter().enumerate() {
            let needed = count(|| encoding.snapshot(s).unwrap());
            let taken = count(|| log.snapshot(s).unwrap());
            // A received instant has passed through all queues.
            receive_until(&mut viewer, "/tf", at as u64 * 5_000_000);
            assert!(round == 0 || taken == needed, "instant {at}: {taken} allocations, {needed} without clients");
        }
    }
    assert_eq!(server.counts().missed, 0);
}
