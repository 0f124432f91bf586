//! Tests of the reader of `log.mcap`: it returns the written values, and refuses files that are no
//! logs.

use super::sample::{self, ROBOT, SCENARIO, URDF};
use nalgebra::Vector3;
use std::path::Path;
use stiction::log::{LogError, LogHeader, LogWriter, TopicGroups, Trajectory, messages};
use stiction::robot::JointKind;
use stiction::sim::{Observer, Snapshot, SoleSnapshot};

const TICKS: usize = 300;

fn written(ticks: usize, topics: TopicGroups) -> Trajectory {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    sample::open_log(&path, ticks, topics).finish().unwrap();
    Trajectory::read(&path).unwrap()
}

fn snapshots() -> impl Iterator<Item = Snapshot> {
    (0..TICKS).map(sample::snapshot)
}

/// Compares one number of every snapshot, bit for bit.
fn same(found: &[f64], get: impl Fn(&Snapshot) -> f64) {
    let expected: Vec<u64> = snapshots().map(|s| get(&s).to_bits()).collect();
    assert_eq!(found.iter().map(|x| x.to_bits()).collect::<Vec<_>>(), expected);
}

/// Compares one vector of every snapshot.
fn same_vectors(found: &[Vector3<f64>], get: impl Fn(&Snapshot) -> Vector3<f64>) {
    assert_eq!(found, snapshots().map(|s| get(&s)).collect::<Vec<_>>());
}

#[test]
fn self_collision_is_read_to_the_last_bit() {
    let read = written(TICKS, TopicGroups::ALL).self_collision.unwrap();
    let self_contact = |s: &Snapshot| s.self_contact.clone().unwrap();
    same(&read.distance, |s| self_contact(s).nearest.unwrap().0);
    same(&read.tests, |s| self_contact(s).tests as f64);
    same(&read.frozen, |s| self_contact(s).frozen.iter().filter(|f| **f).count() as f64);
    let pairs: Vec<String> =
        snapshots().map(|s| self_contact(&s).pairs[self_contact(&s).nearest.unwrap().1].join("/")).collect();
    assert_eq!(read.pair, pairs);
    for (j, (name, prismatic, desired)) in read.desired.iter().enumerate() {
        assert_eq!((name.as_str(), *prismatic), (["hip", "ankle"][j], false));
        same(desired, |s| self_contact(s).desired[j]);
    }
    assert!(written(3, TopicGroups::NONE).self_collision.is_none());
}

#[test]
fn the_motion_is_read_to_the_last_bit() {
    let read = written(TICKS, TopicGroups::ALL);
    assert!(read.complete);
    same(&read.times, |s| s.time);
    let motion = read.motion.unwrap();
    same_vectors(&motion.base_position, |s| s.base_pose.translation.vector);
    same_vectors(&motion.base_linear_velocity, |s| s.base_linear_velocity);
    same_vectors(&motion.base_angular_velocity, |s| s.base_angular_velocity);
    assert_eq!(motion.base_orientation, snapshots().map(|s| s.base_pose.rotation).collect::<Vec<_>>());
    same_vectors(&motion.com, |s| s.com);
    same_vectors(&motion.com_velocity, |s| s.com_velocity);
    assert_eq!(motion.stable_point, snapshots().map(|s| s.stable_point).collect::<Vec<_>>());
    assert_eq!(motion.cop, snapshots().map(|s| s.centre_of_pressure).collect::<Vec<_>>());
    assert_eq!(motion.support_polygon, snapshots().map(|s| s.support_polygon).collect::<Vec<_>>());
    assert_eq!(motion.external, snapshots().map(|s| s.external).collect::<Vec<_>>());
    for (k, name) in ["goal", "now and then"].into_iter().enumerate() {
        assert_eq!(motion.points[k].name, name);
        assert_eq!(motion.points[k].position, snapshots().map(|s| s.points[k].position).collect::<Vec<_>>());
    }
    assert_eq!(motion.joints.len(), 2);
    for (j, (joint, name)) in motion.joints.iter().zip(["hip", "ankle"]).enumerate() {
        assert_eq!((joint.name.as_str(), joint.prismatic), (name, false));
        same(&joint.position, |s| s.q[j]);
        same(&joint.velocity, |s| s.qd[j]);
        same(&joint.desired_position, |s| s.q_desired[j]);
        same(&joint.desired_velocity, |s| s.qd_desired[j]);
        same(&joint.effort, |s| s.effort[j]);
        same(&joint.desired_effort, |s| s.effort_desired[j]);
    }
}

#[test]
fn the_soles_are_read_to_the_last_bit() {
    let soles = written(TICKS, TopicGroups::ALL).soles.unwrap();
    assert_eq!(
        soles.iter().map(|s| (s.name.as_str(), s.vertices.len())).collect::<Vec<_>>(),
        [("left", 4), ("toe", 1), ("shank", 0)]
    );
    // The link is free where the log does not have it.
    let free = || SoleSnapshot { state: "free".into(), ..SoleSnapshot::default() };
    let link = |s: &Snapshot| s.links.first().map_or_else(free, |(_, link)| link.clone());
    assert!(soles[2].is_link && !soles[0].is_link);
    assert_eq!(soles[2].state, snapshots().map(|s| link(&s).state).collect::<Vec<_>>());
    same_vectors(&soles[2].force, |s| link(s).forces.iter().sum());
    for (points, s) in soles[2].points.iter().zip(snapshots()) {
        let link = link(&s);
        assert_eq!(points.iter().map(|p| p.clamped).collect::<Vec<_>>(), link.clamped);
        assert_eq!(points.iter().map(|p| p.position).collect::<Vec<_>>(), link.positions);
        assert_eq!(points.iter().map(|p| p.force).collect::<Vec<_>>(), link.forces);
    }
    for (i, sole) in soles.iter().enumerate().take(2) {
        assert_eq!(sole.state, snapshots().map(|s| s.soles[i].state.clone()).collect::<Vec<_>>());
        same_vectors(&sole.force, |s| s.soles[i].forces.iter().sum());
        for (k, vertex) in sole.vertices.iter().enumerate() {
            assert_eq!(vertex.clamped, snapshots().map(|s| s.soles[i].clamped[k]).collect::<Vec<_>>());
            same_vectors(&vertex.position, |s| s.soles[i].positions[k]);
            same_vectors(&vertex.velocity, |s| s.soles[i].velocities[k]);
            same_vectors(&vertex.force, |s| s.soles[i].forces[k]);
        }
    }
}

#[test]
fn topics_for_viewers_have_a_rate_of_their_own_and_objects_that_of_the_log() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    let objects = [sample::model().links[1].clone(), sample::model().links[2].clone()];
    let header = LogHeader { viewer_rate: 50.0, objects: &objects, ..sample::header(TopicGroups::ALL) };
    let with_objects = |tick: usize| {
        let mut snapshot = sample::snapshot(tick);
        snapshot.object_poses = sample::link_poses_of(&snapshot)[1..3].to_vec();
        snapshot
    };
    let mut log = LogWriter::create(&path, &sample::model(), &header).unwrap();
    for tick in 0..TICKS {
        log.snapshot(&with_objects(tick)).unwrap();
    }
    log.finish().unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let count = |topic: &str| {
        mcap::MessageStream::new(&bytes).unwrap().filter(|m| m.as_ref().unwrap().channel.topic == topic).count()
    };
    for topic in ["/state", "/contact", "/residual", "/objects"] {
        assert_eq!(count(topic), TICKS, "{topic}");
    }
    // 200 instants a second.
    for topic in ["/tf", "/scene/contact", "/joint_states"] {
        assert_eq!(count(topic), TICKS.div_ceil(4), "{topic}");
    }
    let run = Trajectory::read(&path).unwrap();
    assert_eq!(run.objects.len(), 2);
    for (k, series) in run.objects.iter().enumerate() {
        assert_eq!(series.name, objects[k].name);
        let poses = (0..TICKS).map(|tick| with_objects(tick).object_poses[k]);
        assert_eq!(series.position, poses.clone().map(|pose| pose.translation.vector).collect::<Vec<_>>());
        assert_eq!(series.orientation, poses.map(|pose| pose.rotation).collect::<Vec<_>>());
    }
}

#[test]
fn residuals_energies_events_and_texts_are_read() {
    let read = written(TICKS, TopicGroups::ALL);
    let residuals = read.residuals.as_ref().unwrap();
    let column = |get: fn(&messages::Residual) -> f64| residuals.iter().map(get).collect::<Vec<_>>();
    same(&column(|r| r.time), |s| s.time);
    same(&column(|r| r.penetration), |s| s.residual.penetration);
    same(&column(|r| r.cone_excess), |s| s.residual.cone_excess);
    same(&column(|r| r.creep_speed), |s| s.residual.creep_speed);
    same(&column(|r| r.friction_loss), |s| s.energy.friction_loss);
    same(&column(|r| r.energy_error), |s| s.energy.error());

    assert_eq!(read.events.len(), 4);
    for (found, tick) in read.events.iter().zip(0..) {
        let e = sample::event(tick);
        let found = (found.time, found.kind.as_str(), &found.subject, &found.message);
        assert_eq!(found, (e.time, e.kind.as_str(), &e.subject, &e.message));
    }

    let info = &read.info;
    let fields = [&info.scenario, &info.key, &info.method, &info.robot].map(String::as_str);
    assert_eq!(fields, ["sample", "0123abcd", "exact", "sample"]);
    let texts = (read.scenario_text(), read.robot_text(), read.urdf_text());
    assert_eq!(texts, (Some(SCENARIO), Some(ROBOT), Some(URDF)));
    assert_eq!(read.attachments[2].name, "sample.urdf");
}

#[test]
fn topics_that_were_not_logged_are_none() {
    let topics = |names: &[&str]| written(3, TopicGroups::from_names(names).unwrap());
    let contact = topics(&["contact"]);
    assert!(contact.motion.is_none() && contact.soles.is_some() && contact.residuals.is_some());
    assert_eq!(contact.times, [0.0, 0.005, 0.01]);
    let state = topics(&["state"]);
    assert!(state.motion.is_some() && state.soles.is_none() && state.residuals.is_none());
    assert_eq!(state.times, [0.0, 0.005, 0.01]);
    let scene = topics(&["scene"]);
    assert!(scene.times.is_empty() && scene.motion.is_none() && scene.soles.is_none());
    assert_eq!(scene.events.len(), 3, "events are always logged");
    let empty = written(0, TopicGroups::ALL);
    assert!(empty.complete && empty.times.is_empty() && empty.motion.unwrap().joints.len() == 2);
}

#[test]
fn prismatic_joints_are_marked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    let mut model = sample::model();
    model.joints[1].kind = JointKind::Prismatic;
    let mut log = LogWriter::create(&path, &model, &sample::header(TopicGroups::ALL)).unwrap();
    log.snapshot(&sample::snapshot(0)).unwrap();
    log.finish().unwrap();
    let joints = Trajectory::read(&path).unwrap().motion.unwrap().joints;
    assert_eq!(joints.iter().map(|j| j.prismatic).collect::<Vec<_>>(), [false, true]);
}

#[test]
fn the_log_of_a_failed_run_is_readable_and_incomplete() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    drop(sample::open_log(&path, 7, TopicGroups::ALL));
    let read = Trajectory::read(&path).unwrap();
    assert!(!read.complete);
    assert_eq!(read.times.len(), 7);
}

/// Reads a file that is no complete log.
fn refusal(path: &Path) -> (LogError, String) {
    let error = Trajectory::read(path).expect_err("no log");
    let message = error.to_string();
    assert!(message.starts_with(&path.display().to_string()), "{message}");
    (error, message)
}

#[test]
fn missing_and_foreign_files_have_different_errors() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    };
    assert!(matches!(refusal(&folder.path().join("none.mcap")).0, LogError::Io { .. }));
    assert!(matches!(refusal(folder.path()).0, LogError::Io { .. }), "a folder");
    let (error, message) = refusal(&at("empty.mcap", b""));
    assert!(matches!(error, LogError::Foreign { .. }) && message.contains("it is empty"), "{message}");
    let (error, message) = refusal(&at("text.mcap", b"time,x\n0,1\n"));
    assert!(matches!(error, LogError::Foreign { .. }) && message.contains("does not begin as an MCAP"), "{message}");

    // Complete, but of another program.
    let mut other = std::io::Cursor::new(Vec::new());
    mcap::Writer::new(&mut other).unwrap().finish().unwrap();
    let (error, message) = refusal(&at("other.mcap", other.get_ref()));
    assert!(matches!(error, LogError::Foreign { .. }) && message.contains("no metadata table `run`"), "{message}");
}

#[test]
fn truncated_logs_are_refused() {
    let bytes = sample::log(20, TopicGroups::ALL);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    for length in [8, 9, 15, 100, bytes.len() / 2, bytes.len() - 9, bytes.len() - 1] {
        std::fs::write(&path, &bytes[..length]).unwrap();
        let (error, message) = refusal(&path);
        assert!(matches!(error, LogError::Truncated { length: found, .. } if found == length), "{length}: {message}");
    }
}

#[test]
fn a_changed_byte_never_gives_other_values() {
    let bytes = sample::log(20, TopicGroups::ALL);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    std::fs::write(&path, &bytes).unwrap();
    let whole = Trajectory::read(&path).unwrap();
    let (mut refused, mut read) = (0, 0);
    for at in (0..bytes.len()).step_by(bytes.len() / 400) {
        let mut changed = bytes.clone();
        changed[at] ^= 0x55;
        std::fs::write(&path, &changed).unwrap();
        match Trajectory::read(&path) {
            // A checksum of 0 means none; all other changes must be detected.
            Ok(found) => {
                read += 1;
                assert!(found == whole, "byte {at}");
            }
            Err(_) => refused += 1,
        }
    }
    assert!(refused >= 400 && read == 0, "{refused} refused, {read} read without error");
}
