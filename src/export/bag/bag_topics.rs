//! Writes the messages of all topics of a bag, in the order of their times.

use crate::export::bag::bag_log::{BagInstant, BagLog};
use crate::export::bag::bag_writer::{BagWriter, Topic};
use crate::export::bag::frame_messages::{Frames, wrench_frame};
use crate::export::bag::messages::{Clock, MarkerArray, TfMessage, WrenchStamped};
use crate::export::bag::metadata::Durability::{TransientLocal, Volatile};
use crate::export::bag::{markers, wrench_messages};
use crate::export::export_error::ExportError;
use crate::log::SoleSeries;
use crate::log::ros::{Header, JointState, Text, Time};
use std::collections::BTreeSet;
use std::io::{Seek, Write};

impl BagLog {
    /// The soles, without other contacts.
    pub(super) fn soles(&self) -> impl Iterator<Item = &SoleSeries> {
        self.trajectory.soles.iter().flatten().filter(|sole| !sole.is_link)
    }

    fn joint_states(&self, tick: usize, stamp: Time) -> Option<JointState> {
        let joints = &self.trajectory.motion.as_ref()?.joints;
        Some(JointState {
            header: Header { stamp, frame_id: String::new() },
            name: joints.iter().map(|joint| joint.name.clone()).collect(),
            position: joints.iter().map(|joint| joint.position[tick]).collect(),
            velocity: joints.iter().map(|joint| joint.velocity[tick]).collect(),
            effort: joints.iter().map(|joint| joint.effort[tick]).collect(),
        })
    }
}

/// The topics with a message at every instant of their series; none where the log lacks the series.
struct Topics {
    clock: Topic<Clock>,
    frames: Option<Topic<TfMessage>>,
    joints: Option<Topic<JointState>>,
    /// Each with the frame of its wrench.
    soles: Vec<(Topic<WrenchStamped>, String)>,
    external: Option<Topic<WrenchStamped>>,
    markers: Option<Topic<MarkerArray>>,
}

/// Writes the messages of a log at these instants.
pub(super) fn write<W: Write + Seek>(
    log: &BagLog,
    instants: &[BagInstant],
    to: &mut BagWriter<W>,
) -> Result<(), ExportError> {
    let frames = Frames::new(log);
    if let Some(first) = instants.first() {
        write_latched(log, &frames, first.time, to)?;
    }
    let topics = open(log, &frames, to)?;
    instants.iter().try_for_each(|at| write_instant(log, &frames, &topics, at, to))
}

/// Writes what subscribers receive at any time: fixed frames, the URDF, and shapes.
fn write_latched<W: Write + Seek>(
    log: &BagLog,
    frames: &Frames,
    time: u64,
    to: &mut BagWriter<W>,
) -> Result<(), ExportError> {
    let stamp = Time::from_nanoseconds(time);
    if let Some(urdf) = log.trajectory.urdf_text() {
        let topic = to.open("/robot_description", TransientLocal)?;
        to.send(&topic, time, &Text { data: urdf.to_owned() })?;
    }
    if let Some(fixed) = frames.fixed(stamp) {
        let topic = to.open("/tf_static", TransientLocal)?;
        to.send(&topic, time, &fixed)?;
    }
    if !log.scene.entities.is_empty() {
        let topic = to.open("/scene_markers", TransientLocal)?;
        to.send(&topic, time, &MarkerArray { markers: markers::markers(&log.scene.entities, stamp) })?;
    }
    Ok(())
}

fn open<W: Write + Seek>(log: &BagLog, frames: &Frames, to: &mut BagWriter<W>) -> Result<Topics, ExportError> {
    let motion = log.trajectory.motion.as_ref();
    let has_external = motion.is_some_and(|motion| motion.external.iter().any(|forces| !forces.is_empty()));
    let has_markers = !log.markers.times.is_empty();
    let names = topic_names(log.soles().map(|sole| sole.name.as_str()));
    let soles = names.iter().zip(log.soles());
    Ok(Topics {
        clock: to.open("/clock", Volatile)?,
        frames: frames.has_moving().then(|| to.open("/tf", Volatile)).transpose()?,
        joints: motion.map(|_| to.open("/joint_states", Volatile)).transpose()?,
        soles: soles
            .map(|(name, sole)| Ok((to.open(&format!("/soles/{name}/wrench"), Volatile)?, wrench_frame(&sole.name))))
            .collect::<Result<_, ExportError>>()?,
        external: has_external.then(|| to.open("/external_wrench", Volatile)).transpose()?,
        markers: has_markers.then(|| to.open("/contact_markers", Volatile)).transpose()?,
    })
}

fn write_instant<W: Write + Seek>(
    log: &BagLog,
    frames: &Frames,
    topics: &Topics,
    at: &BagInstant,
    to: &mut BagWriter<W>,
) -> Result<(), ExportError> {
    let (time, stamp) = (at.time, Time::from_nanoseconds(at.time));
    let world = log.trajectory.info.world_frame.as_str();
    to.send(&topics.clock, time, &Clock { clock: stamp })?;
    if let Some(topic) = &topics.frames {
        let moving = frames.moving(at, stamp);
        if !moving.transforms.is_empty() {
            to.send(topic, time, &moving)?;
        }
    }
    if let Some(tick) = at.tick {
        if let Some((topic, message)) = topics.joints.as_ref().zip(log.joint_states(tick, stamp)) {
            to.send(topic, time, &message)?;
        }
        for ((topic, frame), sole) in topics.soles.iter().zip(log.soles()) {
            to.send(topic, time, &wrench_messages::of_sole(sole, tick, frame, stamp))?;
        }
        if let Some((topic, motion)) = topics.external.as_ref().zip(log.trajectory.motion.as_ref()) {
            to.send(topic, time, &wrench_messages::of_external(&motion.external[tick], world, stamp))?;
        }
    }
    if let Some((topic, i)) = topics.markers.as_ref().zip(at.markers) {
        let mut all = vec![markers::removal(world, stamp)];
        all.extend(markers::markers(&log.markers.entities[i], stamp));
        to.send(topic, time, &MarkerArray { markers: all })?;
    }
    Ok(())
}

/// Names as parts of topics: letters, digits and single underscores, beginning with a letter. Names
/// that would be equal get a number.
fn topic_names<'a>(names: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let unique = |name: &str| {
        let mut part = String::new();
        for c in name.chars() {
            let c = if c.is_ascii_alphanumeric() { c } else { '_' };
            if !(c == '_' && (part.is_empty() || part.ends_with('_'))) {
                part.push(c);
            }
        }
        let part = part.trim_end_matches('_');
        let part = if part.starts_with(|c: char| c.is_ascii_alphabetic()) {
            part.to_owned()
        } else {
            format!("sole_{part}").trim_end_matches('_').to_owned()
        };
        let numbered = (2..).map(|k| format!("{part}_{k}"));
        let name = std::iter::once(part.clone()).chain(numbered).find(|name| !taken.contains(name)).unwrap_or(part);
        taken.insert(name.clone());
        name
    };
    names.map(unique).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_soles_become_parts_of_topics() {
        let names = ["left", "left foot", "left__foot", "left-foot_", "2", "é", "", "_a"];
        let expected = ["left", "left_foot", "left_foot_2", "left_foot_3", "sole_2", "sole", "sole_3", "a"];
        assert_eq!(topic_names(names.into_iter()), expected);
    }
}
