//! The server without a program around it: late clients, time that goes back, memory.

use std::time::{Duration, Instant};

use stiction::live::Live;
use stiction::log::{ChannelInfo, LogWriter, MessageSink, TopicGroups};
use stiction::sim::Observer;

use super::viewer::{Said, Viewer};
use crate::identities::allocations::count;
use crate::record::sample;

fn server() -> Live {
    Live::start("127.0.0.1:0".parse().unwrap()).unwrap()
}

fn writer(outlet: Box<dyn MessageSink>) -> LogWriter {
    LogWriter::open(None, Some(outlet), &sample::model(), &sample::header(TopicGroups::ALL)).unwrap()
}

/// Waits for something that another thread does.
#[track_caller]
fn until(mut done: impl FnMut() -> bool) {
    let end = Instant::now() + Duration::from_secs(60);
    while !done() {
        assert!(Instant::now() < end, "it does not come");
        std::thread::yield_now();
    }
}

/// Topics and times of messages up to one of this topic and time.
fn heard(viewer: &mut Viewer, topic: &str, time: u64) -> Vec<String> {
    let mut all = Vec::new();
    loop {
        match viewer.hear().expect("it goes on") {
            Said::Words(words) => all.push(words["op"].to_string()),
            Said::Time(time) => all.push(format!("time {time}")),
            Said::Message(t, at, _) => {
                all.push(format!("{t} {at}"));
                if t == topic && at == time {
                    return all;
                }
            }
        }
    }
}

#[test]
fn a_late_client_is_told_what_holds_for_the_run() {
    let server = server();
    let mut log = writer(server.outlet());
    (0..3).for_each(|tick| log.snapshot(&sample::snapshot(tick)).unwrap());
    let mut viewer = Viewer::connect(server.address().port(), "foxglove.sdk.v1");
    // The first snapshot opens this topic; nobody listened, so it was not told.
    until(|| viewer.topics().contains_key("/self_collision") || viewer.hear().is_none());
    viewer.subscribe(|topic| ["/scene", "/robot_description", "/state"].contains(&topic));
    until(|| server.subscriptions() == 3);
    log.snapshot(&sample::snapshot(3)).unwrap();
    let (state, time) = ("/state", 15_000_000);
    assert_eq!(
        heard(&mut viewer, state, time),
        ["/robot_description 0", "/scene 0", "time 15000000", "/state 15000000"]
    );
    // Another one of whom the first must not notice anything.
    let mut second = Viewer::connect(server.address().port(), "foxglove.sdk.v1");
    second.subscribe(|topic| topic == "/scene");
    assert!(heard(&mut second, "/scene", 0).contains(&"time 15000000".to_owned()));
    // It stays, but wants nothing any more.
    viewer.unsubscribe();
    second.unsubscribe();
    // What is said in between is answered in order: the status shows that the others were read.
    second.say(&serde_json::json!({ "op": "subscribe", "subscriptions": [{ "id": 7, "channelId": 700 }] }));
    viewer.say(&serde_json::json!({ "op": "subscribe", "subscriptions": [{ "id": 7, "channelId": 700 }] }));
    for viewer in [&mut viewer, &mut second] {
        assert!(matches!(viewer.hear(), Some(Said::Words(words)) if words["op"] == "status"));
    }
    log.snapshot(&sample::snapshot(4)).unwrap();
    drop(log);
    let told = server.settle();
    assert_eq!((told.clients, told.sent, told.dropped, told.missed), (2, 4, 0, 0));
    drop(server);
    assert_eq!((viewer.hear(), second.hear()), (None, None));
}

/// An interactive run jumps back, then another run begins whose robot has no scene.
#[test]
fn time_may_go_back_and_another_run_may_begin() {
    let server = server();
    let mut log = writer(server.outlet());
    let mut viewer = Viewer::connect(server.address().port(), "foxglove.sdk.v1");
    viewer.subscribe(|topic| topic == "/scene" || topic == "/state");
    until(|| server.subscriptions() == 2);
    [0, 4, 2].iter().for_each(|tick| log.snapshot(&sample::snapshot(*tick)).unwrap());
    let all = heard(&mut viewer, "/state", 10_000_000);
    // The advertisement is of the topic that the first snapshot opens.
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
    let of = |wanted: &str| all.iter().filter(|said| said.contains(wanted)).cloned().collect::<Vec<_>>();
    assert_eq!(of(" "), expected.into_iter().filter(|said| said.contains(' ')).collect::<Vec<_>>());
    assert_eq!(of("advertise").len(), 1);
    drop(log);
    let header = sample::header(TopicGroups { scene: false, ..TopicGroups::ALL });
    let mut log = LogWriter::open(None, Some(server.outlet()), &sample::model(), &header).unwrap();
    log.snapshot(&sample::snapshot(1)).unwrap();
    let all = heard(&mut viewer, "/state", 5_000_000);
    assert!(all.contains(&"\"unadvertise\"".to_owned()), "{all:?}");
    assert_eq!(all.last().unwrap(), "/state 5000000", "it is still subscribed");
    let topics: Vec<String> = viewer.topics().into_keys().collect();
    assert!(!topics.iter().any(|topic| topic.starts_with("/scene")) && topics.len() == 8, "{topics:?}");
}

/// Takes everything, and does nothing with it.
struct Nowhere;

impl MessageSink for Nowhere {
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

/// Whoever simulates allocates nothing for clients, and does not even encode for none.
#[test]
fn nothing_is_allocated_for_clients() {
    let snapshots: Vec<_> = (0..200).map(sample::snapshot).collect();
    let server = server();
    let mut log = writer(server.outlet());
    log.snapshot(&snapshots[0]).unwrap();
    assert_eq!(count(|| snapshots.iter().for_each(|s| log.snapshot(s).unwrap())), 0, "nobody listens");

    let mut encoding = writer(Box::new(Nowhere));
    snapshots.iter().for_each(|s| encoding.snapshot(s).unwrap());
    let mut viewer = Viewer::connect(server.address().port(), "foxglove.sdk.v1");
    until(|| viewer.topics().len() > 10 || viewer.hear().is_none());
    viewer.subscribe(|_| true);
    until(|| server.subscriptions() > 10);
    // The first time messages grow to their size.
    for round in 0..2 {
        for (at, s) in snapshots.iter().enumerate() {
            let needed = count(|| encoding.snapshot(s).unwrap());
            let taken = count(|| log.snapshot(s).unwrap());
            // It has been everywhere when it is heard.
            heard(&mut viewer, "/tf", at as u64 * 5_000_000);
            assert!(round == 0 || taken == needed, "instant {at}: {taken} allocations, {needed} without clients");
        }
    }
    assert_eq!(server.told().missed, 0);
}
