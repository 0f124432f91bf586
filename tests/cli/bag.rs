//! Tests of `export --bag`: ROS 2 bags, read back with the library `mcap`.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use mcap::{MessageStream, Summary};
use nalgebra::Vector3;
use serde::de::DeserializeOwned;
use stiction::export::bag::messages::{self, Clock, MarkerArray, TfMessage, TransformStamped, WrenchStamped};
use stiction::log::Trajectory;
use stiction::log::ros::{JointState, Text, Time};

use super::{Place, Table};

/// HOAP-2 stands and is pushed from 0.1 s on; a box falls next to it.
const PUSHED: &str = r#"
duration = 0.3
[robot]
[log]
rate = 100
[[force]]
type = "push"
link = "torso"
point = [0, 0, 0.05]
force = [16, 0, 0]
start = 0.1
duration = 2.0
[[object]]
name = "crate"
type = "box"
size = [0.2, 0.1, 0.05]
mass = 1.0
position = [1, 0, 0.2]
"#;

/// The relative folder of a finished run. Its robot, of the repository, becomes the first key of `[robot]`.
fn finished_run(place: &Place, name: &str, robot: &str, text: &str) -> String {
    let robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(robot);
    let text = text.replacen("[robot]", &format!("[robot]\nmodel = {:?}", robot.to_str().unwrap()), 1);
    place.write(&format!("{name}.toml"), text);
    place.runner(&[&format!("{name}.toml")]).exits(0);
    let results = format!("results/{name}");
    let key = fs::read_dir(place.path(&results)).unwrap().next().unwrap().unwrap().file_name();
    format!("{results}/{}", key.to_str().unwrap())
}

fn pushed_run(place: &Place) -> String {
    finished_run(place, "pushed", "hoap2/hoap2.toml", PUSHED)
}

fn log(place: &Place, folder: &str) -> Trajectory {
    Trajectory::read(&place.path(folder).join("log.mcap")).unwrap()
}

/// A bag: its MCAP file and the lines of `metadata.yaml`.
struct Bag {
    bytes: Vec<u8>,
    metadata: Vec<String>,
}

impl Bag {
    fn read(folder: &Path) -> Self {
        let name = format!("{}_0.mcap", folder.file_name().unwrap().to_str().unwrap());
        let metadata = fs::read_to_string(folder.join("metadata.yaml")).unwrap();
        let entries = fs::read_dir(folder).unwrap().count();
        assert_eq!(entries, 2, "no other file");
        Self { bytes: fs::read(folder.join(name)).unwrap(), metadata: metadata.lines().map(str::to_owned).collect() }
    }

    fn summary(&self) -> Summary {
        Summary::read(&self.bytes).unwrap().expect("an index")
    }

    /// Type and number of messages of each topic, by the statistics of the file.
    fn topics(&self) -> BTreeMap<String, (String, u64)> {
        let summary = self.summary();
        let counts = &summary.stats.as_ref().unwrap().channel_message_counts;
        let topic = |c: &std::sync::Arc<mcap::Channel>| {
            (c.topic.clone(), (c.schema.as_ref().unwrap().name.clone(), counts.get(&c.id).copied().unwrap_or(0)))
        };
        summary.channels.values().map(topic).collect()
    }

    /// The messages of a topic with their log times, ns.
    fn messages<M: DeserializeOwned>(&self, topic: &str) -> Vec<(u64, M)> {
        let all = MessageStream::new(&self.bytes).unwrap().map(Result::unwrap);
        all.filter(|m| m.channel.topic == topic).map(|m| (m.log_time, cdr::deserialize(&m.data).unwrap())).collect()
    }

    /// The value of the first line of `metadata.yaml` with this key.
    fn value(&self, key: &str) -> &str {
        let lines = self.metadata.iter().map(|line| line.trim_start().trim_start_matches("- "));
        let values = lines.filter_map(|line| line.strip_prefix(key)?.strip_prefix(": "));
        values.take(1).last().unwrap_or_else(|| panic!("no {key}"))
    }
}

fn nanoseconds(stamp: Time) -> u64 {
    stamp.sec as u64 * 1_000_000_000 + u64::from(stamp.nanosec)
}

fn vector(v: &messages::Vector3) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

fn bits(v: &Vector3<f64>) -> [u64; 3] {
    [v.x, v.y, v.z].map(f64::to_bits)
}

#[test]
fn a_bag_has_the_form_that_rosbag2_reads() {
    let place = Place::new();
    let run = pushed_run(&place);
    let done = place.runner(&["export", &run, "--bag", "-o", "out/push"]).exits(0);
    assert_eq!(done.stdout, "");
    let bag = Bag::read(&place.path("out/push"));
    let topics = bag.topics();
    let expected = [
        ("/clock", "rosgraph_msgs/msg/Clock", 31),
        ("/contact_markers", "visualization_msgs/msg/MarkerArray", 16),
        ("/external_wrench", "geometry_msgs/msg/WrenchStamped", 31),
        ("/joint_states", "sensor_msgs/msg/JointState", 31),
        ("/robot_description", "std_msgs/msg/String", 1),
        ("/scene_markers", "visualization_msgs/msg/MarkerArray", 1),
        ("/soles/left/wrench", "geometry_msgs/msg/WrenchStamped", 31),
        ("/soles/right/wrench", "geometry_msgs/msg/WrenchStamped", 31),
        ("/tf", "tf2_msgs/msg/TFMessage", 31),
        ("/tf_static", "tf2_msgs/msg/TFMessage", 1),
    ];
    assert_eq!(topics, expected.map(|(topic, of, n)| (topic.to_owned(), (of.to_owned(), n))).into());
    let count: u64 = expected.iter().map(|(_, _, n)| n).sum();
    assert!(done.stderr.contains(&format!("out/push: 10 topics, {count} messages")), "{}", done.stderr);

    // The header has profile and program as strings with their lengths.
    let header = &bag.bytes[mcap::MAGIC.len() + 9..];
    assert!(header.starts_with(b"\x04\0\0\0ros2\x0e\0\0\0stiction"), "{:?}", &header[..24]);
    let summary = bag.summary();
    assert!(summary.chunk_indexes.iter().all(|chunk| chunk.compression == "zstd"));
    assert_eq!(summary.stats.as_ref().unwrap().message_count, count);
    for channel in summary.channels.values() {
        let schema = channel.schema.as_ref().unwrap();
        assert_eq!((channel.message_encoding.as_str(), schema.encoding.as_str()), ("cdr", "ros2msg"));
        let qos = &channel.metadata["offered_qos_profiles"];
        let is_latched = topics[&channel.topic].1 == 1;
        assert!(qos.starts_with("- history: 1\n  depth: ") && qos.contains("\n  reliability: 1\n"), "{qos}");
        assert!(qos.contains(if is_latched { "durability: 1\n" } else { "durability: 2\n" }), "{}", channel.topic);
    }
    let times: Vec<u64> = MessageStream::new(&bag.bytes).unwrap().map(|m| m.unwrap().log_time).collect();
    assert!(times.is_sorted() && times[0] == 0 && times[times.len() - 1] == 300_000_000);

    for (key, value) in [
        ("version", "5"),
        ("storage_identifier", "mcap"),
        ("nanoseconds", "300000000"),
        ("nanoseconds_since_epoch", "0"),
        ("compression_format", "\"\""),
        ("compression_mode", "\"\""),
        ("path", "\"push_0.mcap\""),
        ("message_count", &count.to_string()),
    ] {
        assert_eq!(bag.value(key), value, "{key}");
    }
    assert!(bag.metadata.contains(&"    - \"push_0.mcap\"".to_owned()), "{:?}", bag.metadata);
    for (topic, of, n) in expected {
        let at = bag.metadata.iter().position(|line| line.ends_with(&format!("name: \"{topic}\""))).unwrap();
        let lines: Vec<&str> = bag.metadata[at + 1..at + 5].iter().map(|line| line.trim()).collect();
        assert_eq!(lines[..2], [format!("type: {of}"), "serialization_format: cdr".to_owned()]);
        assert!(lines[2].starts_with("offered_qos_profiles: \"- history: 1\\n  depth: "), "{}", lines[2]);
        assert_eq!(lines[3], format!("message_count: {n}"));
    }
    // The same entries are in the file.
    let index = summary.metadata_indexes.iter().find(|index| index.name == "rosbag2").unwrap();
    let inside = mcap::read::metadata(&bag.bytes, index).unwrap().metadata;
    let entries: Vec<&str> = bag.metadata[1..].iter().map(|line| &line[2..]).collect();
    assert_eq!(inside["serialized_metadata"].lines().collect::<Vec<_>>(), entries);
}

#[test]
fn messages_have_the_numbers_of_the_log_to_the_last_bit() {
    let place = Place::new();
    let run = pushed_run(&place);
    place.runner(&["export", &run, "--bag", "-o", "push"]).exits(0);
    let (bag, log) = (Bag::read(&place.path("push")), log(&place, &run));
    let (motion, soles) = (log.motion.as_ref().unwrap(), log.soles.as_ref().unwrap());
    let instants: Vec<u64> = log.times.iter().map(|t| (t * 1e9).round() as u64).collect();

    let clock = bag.messages::<Clock>("/clock");
    assert_eq!(clock.iter().map(|(t, _)| *t).collect::<Vec<_>>(), instants);
    assert!(clock.iter().all(|(t, m)| nanoseconds(m.clock) == *t));

    let joints = bag.messages::<JointState>("/joint_states");
    assert_eq!(joints.iter().map(|(t, _)| *t).collect::<Vec<_>>(), instants);
    for (i, (time, message)) in joints.iter().enumerate() {
        assert_eq!(nanoseconds(message.header.stamp), *time);
        assert!(message.name.iter().eq(motion.joints.iter().map(|j| &j.name)));
        let same = |values: &[f64], series: fn(&stiction::log::JointSeries) -> &Vec<f64>| {
            let expected = motion.joints.iter().map(|j| series(j)[i].to_bits());
            assert!(values.iter().map(|x| x.to_bits()).eq(expected), "{time}");
        };
        same(&message.position, |j| &j.position);
        same(&message.velocity, |j| &j.velocity);
        same(&message.effort, |j| &j.effort);
    }
    assert_eq!(bag.messages::<Text>("/robot_description")[0].1.data, log.urdf_text().unwrap());

    for sole in soles.iter().filter(|sole| !sole.is_link) {
        let wrenches = bag.messages::<WrenchStamped>(&format!("/soles/{}/wrench", sole.name));
        assert_eq!(wrenches.len(), instants.len());
        for (i, (time, message)) in wrenches.iter().enumerate() {
            assert_eq!((nanoseconds(message.header.stamp), *time), (instants[i], instants[i]));
            assert_eq!(message.header.frame_id, format!("sole/{}/world_axes", sole.name));
            assert_eq!(bits(&vector(&message.wrench.force)), bits(&sole.force[i]));
            let vertices = || sole.vertices.iter().map(|v| (v.position[i], v.force[i]));
            let mean = vertices().map(|(p, _)| p).sum::<Vector3<f64>>() / sole.vertices.len() as f64;
            let about_origin: Vector3<f64> = vertices().map(|(p, f)| p.cross(&f)).sum();
            // The moment about another point; tens of N at tenths of m, each with a few roundings.
            let expected = about_origin - mean.cross(&sole.force[i]);
            assert!((vector(&message.wrench.torque) - expected).norm() < 1e-13, "{time}");
        }
        assert!(wrenches[30].1.wrench.force.z > 10.0, "it stands");
    }
    for (i, (_, message)) in bag.messages::<WrenchStamped>("/external_wrench").iter().enumerate() {
        let forces = &motion.external[i];
        assert_eq!(forces.len(), usize::from(log.times[i] >= 0.1), "the push");
        let force = forces.iter().map(|(_, f)| f).sum();
        assert_eq!((bits(&vector(&message.wrench.force)), message.header.frame_id.as_str()), (bits(&force), "world"));
        let moment: Vector3<f64> = forces.iter().map(|(p, f)| p.cross(f)).sum();
        assert_eq!(bits(&vector(&message.wrench.torque)), bits(&moment));
    }
}

/// Position of a frame in the world at one instant.
fn position(name: &str, frames: &BTreeMap<&str, &TransformStamped>) -> Vector3<f64> {
    let Some(frame) = frames.get(name) else {
        assert_eq!(name, "world");
        return Vector3::zeros();
    };
    let mut at = vector(&frame.transform.translation);
    let mut parent = frame.header.frame_id.as_str();
    while let Some(next) = frames.get(parent) {
        let q = &next.transform.rotation;
        let turn = nalgebra::UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(q.w, q.x, q.y, q.z));
        at = turn * at + vector(&next.transform.translation);
        parent = next.header.frame_id.as_str();
    }
    assert_eq!(parent, "world");
    at
}

#[test]
fn frames_connect_base_links_soles_and_objects() {
    let place = Place::new();
    let run = pushed_run(&place);
    place.runner(&["export", &run, "--bag", "-o", "push"]).exits(0);
    let (bag, log) = (Bag::read(&place.path("push")), log(&place, &run));
    let (motion, soles) = (log.motion.as_ref().unwrap(), log.soles.as_ref().unwrap());
    let fixed = bag.messages::<TfMessage>("/tf_static");
    let fixed: Vec<_> = fixed[0].1.transforms.iter().collect();
    let names: Vec<&str> = fixed.iter().map(|t| t.child_frame_id.as_str()).collect();
    assert!(names.contains(&"sole/left") && names.contains(&"sole/right"), "{names:?}");
    let urdf = log.urdf_text().unwrap();
    let document = roxmltree::Document::parse(urdf).unwrap();
    let links: Vec<&str> = document
        .root_element()
        .children()
        .filter_map(|n| n.has_tag_name("link").then(|| n.attribute("name"))?)
        .collect();
    for (i, (time, message)) in bag.messages::<TfMessage>("/tf").iter().enumerate() {
        let mut frames: BTreeMap<&str, &TransformStamped> =
            message.transforms.iter().map(|t| (t.child_frame_id.as_str(), t)).collect();
        assert_eq!(frames.len(), message.transforms.len(), "each frame once");
        assert!(names.iter().all(|name| !frames.contains_key(name)), "fixed frames are not repeated");
        assert!(frames.values().all(|t| nanoseconds(t.header.stamp) == *time));
        let roots: Vec<_> = frames.values().filter(|t| t.header.frame_id == "world").collect();
        let base = roots.iter().find(|t| !t.child_frame_id.contains('/')).unwrap();
        assert_eq!(bits(&vector(&base.transform.translation)), bits(&motion.base_position[i]));
        assert_eq!(base.transform.rotation.w.to_bits(), motion.base_orientation[i].w.to_bits());
        let object = frames["object/crate"];
        assert_eq!(bits(&vector(&object.transform.translation)), bits(&log.objects[0].position[i]));
        for sole in soles.iter().filter(|sole| !sole.is_link) {
            let mean = sole.vertices.iter().map(|v| v.position[i]).sum::<Vector3<f64>>() / sole.vertices.len() as f64;
            let axes = frames[format!("sole/{}/world_axes", sole.name).as_str()];
            assert_eq!(bits(&vector(&axes.transform.translation)), bits(&mean));
            assert_eq!(axes.transform.rotation, messages::Quaternion::default());
        }
        // Every other instant of the log has all links.
        if i % 2 == 0 {
            frames.extend(fixed.iter().map(|t| (t.child_frame_id.as_str(), *t)));
            for sole in ["left", "right"] {
                let (own, axes) = (format!("sole/{sole}"), format!("sole/{sole}/world_axes"));
                // Poses are composed over a few links, each with a few roundings of 1e-16 m.
                assert!((position(&own, &frames) - position(&axes, &frames)).norm() < 1e-13, "{time}");
            }
            links.iter().for_each(|link| assert!(position(link, &frames).norm() < 2.0, "{link}"));
        }
    }
}

#[test]
fn markers_show_shapes_contacts_and_forces() {
    let place = Place::new();
    let run = pushed_run(&place);
    place.runner(&["export", &run, "--bag", "-o", "push"]).exits(0);
    let bag = Bag::read(&place.path("push"));
    let shapes = &bag.messages::<MarkerArray>("/scene_markers")[0].1.markers;
    let of = |namespace: &str| shapes.iter().filter(|m| m.ns == namespace).collect::<Vec<_>>();
    let object = of("object/crate");
    assert_eq!((object.len(), object[0].r#type, object[0].header.frame_id.as_str()), (1, 1, "object/crate"));
    assert_eq!(vector(&object[0].scale), Vector3::new(0.2, 0.1, 0.05));
    // A slab and its grid.
    assert_eq!(of("floor").iter().map(|m| (m.id, m.r#type)).collect::<Vec<_>>(), [(0, 1), (1, 5)]);
    assert!(shapes.iter().any(|m| m.ns.starts_with("link/") && m.header.frame_id == m.ns[5..]));
    assert!(shapes.iter().all(|m| m.action == 0 && m.frame_locked && m.color.a > 0.0));
    assert!(shapes.iter().all(|m| m.r#type != 11 || !m.points.is_empty() && m.points.len() % 3 == 0));

    let drawn = bag.messages::<MarkerArray>("/contact_markers");
    for (time, message) in &drawn {
        let [removal, markers @ ..] = message.markers.as_slice() else { panic!("no marker") };
        assert_eq!(removal.action, 3, "removes those before");
        let names: std::collections::BTreeSet<_> = markers.iter().map(|m| (&m.ns, m.id)).collect();
        assert_eq!(names.len(), markers.len());
        assert!(markers.iter().all(|m| m.header.frame_id == "world" && nanoseconds(m.header.stamp) == *time));
        let arrows = markers.iter().filter(|m| m.r#type == 0);
        assert!(arrows.clone().all(|m| m.points.len() == 2 && m.points[1].x > 0.0));
        assert_eq!(arrows.filter(|m| m.ns == "external").count(), usize::from(*time >= 100_000_000), "{time}");
    }
    let last = &drawn[drawn.len() - 1].1.markers;
    assert!(last.iter().any(|m| m.ns == "contact/left" && m.r#type == 0), "forces");
    assert!(last.iter().any(|m| m.ns == "contact/left" && m.r#type == 2), "contacts");
    assert!(last.iter().any(|m| m.ns == "balance" && m.r#type == 4), "support polygon");
}

/// The block falls and comes to rest.
const FALL: &str = "duration = 0.3\n[robot]\nbase = { position = [0, 0, 0.06] }\n[log]\nrate = 100\n";

fn fallen_block(place: &Place, topics: &str) -> String {
    finished_run(place, "fall", "block/block.toml", &format!("{FALL}{topics}\n"))
}

#[test]
fn time_limits_are_inclusive_and_other_instants_are_left_out() {
    let place = Place::new();
    let run = fallen_block(&place, "");
    place.runner(&["export", &run, "--bag", "-o", "part", "--from", "0.1", "--to", "0.2"]).exits(0);
    let bag = Bag::read(&place.path("part"));
    let times: Vec<u64> = bag.messages::<Clock>("/clock").iter().map(|(t, _)| *t).collect();
    assert_eq!(times, (10..=20).map(|k| k * 10_000_000).collect::<Vec<_>>());
    // Shapes and URDF come with the first instant.
    assert_eq!(bag.messages::<Text>("/robot_description")[0].0, 100_000_000);
    assert_eq!(bag.value("nanoseconds_since_epoch"), "100000000");
    assert_eq!(bag.value("nanoseconds"), "100000000");
    let arguments = ["export", &run, "--bag", "-o", "none", "--from", "7"];
    let done = place.runner(&arguments).exits(2);
    assert!(done.stderr.contains("nothing to export from 7 s to 0.3 s: the log reaches from 0 s to 0.3 s"));
    let done = place.runner(&["export", &run, "--bag", "-o", "none", "--to", "-1"]).exits(2);
    assert!(done.stderr.contains("nothing to export"), "{}", done.stderr);
    assert!(!place.path("none").exists());
}

#[test]
fn topics_follow_those_of_the_log() {
    let place = Place::new();
    let topics = |list: &str, folder: &str| {
        let run = fallen_block(&place, &format!("topics = {list}"));
        place.runner(&["export", &run, "--bag", "-o", folder]).exits(0);
        fs::remove_dir_all(place.path("results")).unwrap();
        Bag::read(&place.path(folder)).topics().into_keys().collect::<Vec<_>>().join(" ")
    };
    assert_eq!(topics("[\"state\"]", "state"), "/clock /joint_states /robot_description");
    assert_eq!(topics("[\"contact\"]", "contact"), "/clock /robot_description /soles/bottom/wrench /tf");
    let scene = "/clock /contact_markers /robot_description /scene_markers /tf /tf_static";
    assert_eq!(topics("[\"scene\"]", "scene"), scene);
    let run = fallen_block(&place, "topics = []");
    let done = place.runner(&["export", &run, "--bag", "-o", "empty"]).exits(2);
    assert!(done.stderr.contains("the log has no topics for a bag"), "{}", done.stderr);
    assert!(!place.path("empty").exists());
}

#[test]
fn equal_logs_give_equal_bags_and_a_bag_replaces_its_predecessor() {
    let place = Place::new();
    let run = fallen_block(&place, "");
    let log = format!("{run}/log.mcap");
    place.runner(&["export", &log, "--bag", "-o", "bag"]).exits(0);
    let first = Bag::read(&place.path("bag"));
    place.runner(&["export", &run, "--bag", "-o", "bag", "--to", "0.1"]).exits(0);
    assert_eq!(Bag::read(&place.path("bag")).value("nanoseconds"), "100000000");
    place.runner(&["export", &run, "--bag", "-o", "bag/"]).exits(0);
    assert!(Bag::read(&place.path("bag")).bytes == first.bytes);
    // Without a name the folder has that of scenario and key.
    let done = place.runner(&["export", &run, "--bag"]).exits(0);
    let name = format!("fall_{}", run.rsplit('/').next().unwrap());
    assert!(done.stderr.contains(&format!("{name}: 8 topics")), "{}", done.stderr);
    let named = Bag::read(&place.path(&name));
    assert_eq!(named.value("path"), format!("\"{name}_0.mcap\""));
    // The tables are those of the log, still.
    let table = Table::parse(&place.runner(&["export", &run, "--columns", "base_z_m"]).exits(0).stdout);
    assert_eq!(table.rows.len(), 31);
}

#[test]
fn other_files_are_not_replaced_and_errors_leave_nothing() {
    let place = Place::new();
    let run = fallen_block(&place, "");
    let refused = |arguments: &[&str], text: &str| {
        let done = place.runner(&[&["export", "--bag"], arguments].concat()).exits(2);
        assert!(done.stderr.contains(text), "{text:?} in\n{}", done.stderr);
        assert_eq!(done.stdout, "");
    };
    place.write("mine/notes.txt", "x").write("file", "x");
    refused(&[&run, "-o", "mine"], "mine: exists and is not a bag of this program, since it contains `notes.txt`");
    refused(&[&run, "-o", &run], "exists and is not a bag of this program");
    refused(&[&run, "-o", "file"], "file: exists and is not a folder: choose another folder");
    refused(&[&run, "-o", &format!("{run}/log.mcap")], "is the log itself");
    refused(&[&run, "-o", "file/bag"], "file/bag");
    assert_eq!(fs::read_dir(place.path("mine")).unwrap().count(), 1);
    assert_eq!(fs::read_to_string(place.path("file")).unwrap(), "x");

    let bytes = fs::read(place.path(&run).join("log.mcap")).unwrap();
    place.write("cut.mcap", &bytes[..bytes.len() / 2]).write("text.mcap", "x");
    refused(&["cut.mcap", "-o", "out"], "cut.mcap: cut short");
    refused(&["text.mcap", "-o", "out"], "text.mcap: not a log of this program");
    refused(&["none.mcap", "-o", "out"], "none.mcap: No such file");
    refused(&["mine", "-o", "out"], "there is no log.mcap in it");
    place.runner(&["export", &run, "--bag", "-o", "other"]).exits(0);
    refused(&["other/other_0.mcap", "-o", "out"], "not a log of this program");
    for option in [
        ["--rate", "10"],
        ["--columns", "*"],
        ["--format", "csv"],
        ["--separator", "tab"],
        ["--numbers", "exact"],
        ["--header", "none"],
        ["--comment", "#"],
        ["--missing", "x"],
        ["--time-unit", "ms"],
        ["--blocks", "base_z_m"],
    ] {
        refused(&[&[run.as_str(), "-o", "out"], &option[..]].concat(), "cannot be used with");
    }
    refused(&[&run, "-o", "out", "--events"], "cannot be used with");
    refused(&[&run, "--list-columns"], "cannot be used with");
    assert!(!place.path("out").exists());
}

#[test]
fn a_log_that_ends_early_gives_a_bag_with_a_warning() {
    let place = Place::new();
    let run = fallen_block(&place, "");
    let bytes = fs::read(place.path(&run).join("log.mcap")).unwrap();
    place.write("cut.mcap", &bytes[..bytes.len() * 9 / 10]);
    place.runner(&["salvage", "cut.mcap", "-o", "part.mcap"]).exits(0);
    let done = place.runner(&["export", "part.mcap", "--bag", "-o", "part"]).exits(0);
    assert!(done.stderr.contains("warning: the run did not end by itself"), "{}", done.stderr);
    assert!(Bag::read(&place.path("part")).topics().contains_key("/clock"));
}
