//! Tests of `log.mcap` as a file: topics, schemas, counts, attachments, equal bytes, interruption.

use super::sample::{self, ROBOT, SCENARIO, URDF};
use mcap::{MessageStream, Summary};
use std::collections::BTreeMap;
use stiction::log::{LogWriter, TopicGroups};
use stiction::sim::Observer;

const TICKS: usize = 20;
const EVENTS: u64 = 4;

/// Topic to (schema, schema encoding, message encoding, messages), from the file's own summary.
fn channels(bytes: &[u8]) -> BTreeMap<String, (String, String, String, u64)> {
    let summary = Summary::read(bytes).unwrap().expect("a finished log has a summary");
    let counts = &summary.stats.as_ref().unwrap().channel_message_counts;
    summary
        .channels
        .values()
        .map(|c| {
            let schema = c.schema.as_ref().unwrap();
            let count = counts.get(&c.id).copied().unwrap_or(0);
            (c.topic.clone(), (schema.name.clone(), schema.encoding.clone(), c.message_encoding.clone(), count))
        })
        .collect()
}

#[test]
fn every_topic_has_its_schema_and_one_message_per_tick() {
    let found = channels(&sample::log(TICKS, TopicGroups::ALL));
    let ticks = TICKS as u64;
    let expected = [
        ("/contact", "stiction.Contact", "protobuf", "protobuf", ticks),
        ("/events", "stiction.Event", "protobuf", "protobuf", EVENTS),
        ("/joint_states", "sensor_msgs/msg/JointState", "ros2msg", "cdr", ticks),
        ("/log", "foxglove.Log", "protobuf", "protobuf", EVENTS),
        ("/residual", "stiction.Residual", "protobuf", "protobuf", ticks),
        ("/robot_description", "std_msgs/msg/String", "ros2msg", "cdr", 1),
        ("/scene", "foxglove.SceneUpdate", "protobuf", "protobuf", 1),
        ("/scene/contact", "foxglove.SceneUpdate", "protobuf", "protobuf", ticks),
        ("/self_collision", "stiction.SelfCollision", "protobuf", "protobuf", ticks),
        ("/state", "stiction.State", "protobuf", "protobuf", ticks),
        ("/tf", "foxglove.FrameTransforms", "protobuf", "protobuf", ticks),
    ];
    let expected = expected.map(|(t, s, e, m, n)| (t.to_owned(), (s.to_owned(), e.to_owned(), m.to_owned(), n)));
    assert_eq!(found, BTreeMap::from(expected));
}

#[test]
fn only_selected_topics_are_written() {
    let topics = |names: &[&str]| {
        let found = channels(&sample::log(2, TopicGroups::from_names(names).unwrap()));
        found.into_keys().collect::<Vec<_>>().join(" ")
    };
    assert_eq!(topics(&[]), "/events /log");
    assert_eq!(topics(&["state"]), "/events /joint_states /log /robot_description /self_collision /state");
    assert_eq!(topics(&["contact"]), "/contact /events /log /residual");
    assert_eq!(topics(&["scene", "contact"]), "/contact /events /log /residual /scene /scene/contact /tf");
    assert!(TopicGroups::from_names(&["state", "colour"]).unwrap_err().to_string().contains("`colour`"));
}

#[test]
fn log_times_are_simulated_nanoseconds() {
    let bytes = sample::log(TICKS, TopicGroups::ALL);
    let times = |topic: &str| -> Vec<u64> {
        let messages = MessageStream::new(&bytes).unwrap().map(Result::unwrap);
        messages.filter(|m| m.channel.topic == topic).map(|m| m.log_time).collect()
    };
    let ticks: Vec<u64> = (0..TICKS as u64).map(|t| t * 5_000_000).collect();
    for topic in ["/state", "/contact", "/tf", "/scene/contact", "/joint_states"] {
        assert_eq!(times(topic), ticks, "{topic}");
    }
    assert_eq!(times("/events"), [1_234_568, 6_234_568, 11_234_568, 16_234_568]);
    assert_eq!(times("/scene"), [0]);
}

#[test]
fn scenario_robot_and_urdf_are_attached() {
    let bytes = sample::log(1, TopicGroups::ALL);
    let summary = Summary::read(&bytes).unwrap().unwrap();
    let found: Vec<_> = summary
        .attachment_indexes
        .iter()
        .map(|index| {
            let a = mcap::read::attachment(&bytes, index).unwrap();
            assert_eq!((a.log_time, a.create_time), (0, 0));
            (a.name, a.media_type, String::from_utf8(a.data.into_owned()).unwrap())
        })
        .collect();
    let expected = [
        ("sample.toml", "application/toml", SCENARIO),
        ("robot.toml", "application/toml", ROBOT),
        ("sample.urdf", "application/xml", URDF),
    ];
    assert_eq!(found, expected.map(|(n, t, x)| (n.to_owned(), t.to_owned(), x.to_owned())));
}

fn metadata(bytes: &[u8], name: &str) -> BTreeMap<String, String> {
    let summary = Summary::read(bytes).unwrap().unwrap();
    let index = summary.metadata_indexes.iter().find(|i| i.name == name).expect(name);
    mcap::read::metadata(bytes, index).unwrap().metadata
}

#[test]
fn metadata_names_the_run() {
    let bytes = sample::log(1, TopicGroups::ALL);
    let run = metadata(&bytes, "run");
    let get = |key: &str| run[key].as_str();
    assert_eq!([get("scenario"), get("key"), get("method"), get("robot")], ["sample", "0123abcd", "exact", "sample"]);
    assert_eq!(get("program"), format!("stiction {}", env!("CARGO_PKG_VERSION")));
    assert_eq!(metadata(&bytes, "end")["complete"], "true");
}

#[test]
fn equal_runs_give_equal_bytes_and_others_do_not() {
    // Long enough for several compressed chunks of 1 MiB.
    let ticks = 1500;
    let first = sample::log(ticks, TopicGroups::ALL);
    assert!(Summary::read(&first).unwrap().unwrap().chunk_indexes.len() >= 2);
    assert!(first == sample::log(ticks, TopicGroups::ALL));
    assert!(first != sample::log(ticks - 1, TopicGroups::ALL));
}

#[test]
fn a_log_appears_only_when_it_is_complete() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("runs/a/log.mcap");
    let log = sample::open_log(&path, 3, TopicGroups::ALL);
    assert!(!path.exists());
    log.finish().unwrap();
    assert!(path.exists());
    assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 1, "no other file");
}

#[test]
fn a_run_that_panics_leaves_a_readable_log() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    let run = std::panic::catch_unwind(|| {
        let _log = sample::open_log(&path, TICKS, TopicGroups::ALL);
        std::panic::resume_unwind(Box::new("a run failed"));
    });
    assert!(run.is_err());
    let bytes = std::fs::read(&path).unwrap();
    assert_eq!(channels(&bytes)["/state"].3, TICKS as u64);
    assert_eq!(metadata(&bytes, "end")["complete"], "false");
}

#[test]
fn a_snapshot_of_another_robot_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut log = sample::open_log(&folder.path().join("log.mcap"), 1, TopicGroups::ALL);
    let mut snapshot = sample::snapshot(1);
    snapshot.q.pop();
    let message = log.snapshot(&snapshot).unwrap_err().to_string();
    assert!(message.contains("1 joint positions") && message.contains("the model has 2"), "{message}");
    let mut snapshot = sample::snapshot(1);
    snapshot.soles.clear();
    assert!(log.snapshot(&snapshot).unwrap_err().to_string().contains("0 soles"));
}

#[test]
fn an_error_names_the_folder_that_cannot_be_created() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "").unwrap();
    let result = LogWriter::create(&file.join("log.mcap"), &sample::model(), &sample::header(TopicGroups::ALL));
    assert!(result.err().unwrap().to_string().contains("file"));
}

/// Writes the sample log to the path in `STICTION_KEEP_LOG`, for `tests/oracles/check_log.py`.
#[test]
fn a_log_can_be_kept_for_other_readers() {
    let bytes = sample::log(200, TopicGroups::ALL);
    assert!(bytes.starts_with(mcap::MAGIC) && bytes.ends_with(mcap::MAGIC));
    if let Some(path) = std::env::var_os("STICTION_KEEP_LOG") {
        std::fs::write(path, bytes).unwrap();
    }
}
