//! Reads a [`Trajectory`]: collects the messages of each topic, checks that all have the same ticks
//! and bodies, and turns rows into columns.

use crate::log::messages::{
    Contact, Estimate, Event, Force, Point, Residual, SelfCollision, Sole, State, Vector3 as VectorMessage,
};
use crate::log::read::log_error::{LogDamage, LogError};
use crate::log::read::log_file::{LogFile, read_bytes};
use crate::log::read::message_values::{quaternion, vector, vector_or_zero};
use crate::log::read::object_series::ObjectFrames;
use crate::log::read::trajectory::{
    Attachment, ContactPoint, JointSeries, LoggedEvent, Motion, PointSeries, RunInfo, SoleSeries, Trajectory,
    VertexSeries,
};
use crate::log::read::{estimate_series, self_collision_series};
use prost::Message as _;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

impl Trajectory {
    /// Reads a log.
    ///
    /// # Errors
    /// No such file; a file that is not MCAP or not a log of this program; a log that was truncated
    /// or changed since it was written.
    pub fn read(path: &Path) -> Result<Self, LogError> {
        Self::from_bytes(path, &read_bytes(path)?)
    }

    /// Reads a log from memory; errors name it `path`.
    ///
    /// # Errors
    /// As [`Trajectory::read`].
    pub fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self, LogError> {
        let file = LogFile::open(path, bytes)?;
        let (info, complete, attachments) = (file.info()?, file.is_complete()?, file.attachments()?);
        let messages = TopicMessages::read(&file)?;
        Ok(messages.into_trajectory(info, complete, attachments))
    }
}

/// The messages of a log, by topic. `None` where the topic was not logged.
#[derive(Default)]
struct TopicMessages {
    joints: Vec<(String, bool)>,
    state: Option<Vec<State>>,
    contact: Option<Vec<Contact>>,
    residual: Option<Vec<Residual>>,
    estimate: Option<Vec<Estimate>>,
    estimated_soles: Vec<String>,
    self_collision: Option<Vec<SelfCollision>>,
    objects: ObjectFrames,
    events: Vec<Event>,
}

impl TopicMessages {
    fn read(file: &LogFile<'_>) -> Result<Self, LogError> {
        let mut all = Self::default();
        for (topic, metadata) in file.channels() {
            match topic {
                "/state" => {
                    all.joints = joints(metadata).map_err(|damage| file.damage(damage))?;
                    all.state = Some(Vec::new());
                }
                "/contact" => all.contact = Some(Vec::new()),
                "/residual" => all.residual = Some(Vec::new()),
                "/estimate" => {
                    all.estimated_soles = list("/estimate", metadata, "soles").map_err(|damage| file.damage(damage))?;
                    all.estimate = Some(Vec::new());
                }
                "/self_collision" => all.self_collision = Some(Vec::new()),
                "/objects" => {
                    let names = list("/objects", metadata, "objects").map_err(|damage| file.damage(damage))?;
                    all.objects = ObjectFrames::named(names);
                }
                _ => {}
            }
        }
        for message in file.messages()? {
            let message = message?;
            all.decode(&message.channel.topic, &message.data)
                .map_err(|source| file.damage(LogDamage::Message { topic: message.channel.topic.clone(), source }))?;
        }
        all.align();
        all.check().map_err(|damage| file.damage(damage))?;
        Ok(all)
    }

    fn decode(&mut self, topic: &str, data: &[u8]) -> Result<(), prost::DecodeError> {
        match topic {
            "/state" => self.state.get_or_insert_default().push(State::decode(data)?),
            "/contact" => self.contact.get_or_insert_default().push(Contact::decode(data)?),
            "/residual" => self.residual.get_or_insert_default().push(Residual::decode(data)?),
            "/estimate" => self.estimate.get_or_insert_default().push(Estimate::decode(data)?),
            "/self_collision" => self.self_collision.get_or_insert_default().push(SelfCollision::decode(data)?),
            "/objects" => self.objects.decode(data)?,
            "/tf" => self.objects.decode_frames(data)?,
            "/events" => self.events.push(Event::decode(data)?),
            _ => {}
        }
        Ok(())
    }

    /// Drops the last tick if a failed run wrote it on some topics only.
    fn align(&mut self) {
        let counts = [
            self.state.as_ref().map(Vec::len),
            self.contact.as_ref().map(Vec::len),
            self.residual.as_ref().map(Vec::len),
            self.estimate.as_ref().map(Vec::len),
            self.self_collision.as_ref().map(Vec::len),
            self.objects.ticks().filter(|_| self.state.is_some() || self.contact.is_some()),
        ];
        let known = || counts.iter().flatten().copied();
        let (Some(least), Some(most)) = (known().min(), known().max()) else { return };
        if most - least == 1 {
            self.state.iter_mut().for_each(|v| v.truncate(least));
            self.contact.iter_mut().for_each(|v| v.truncate(least));
            self.residual.iter_mut().for_each(|v| v.truncate(least));
            self.estimate.iter_mut().for_each(|v| v.truncate(least));
            self.self_collision.iter_mut().for_each(|v| v.truncate(least));
            self.objects.truncate(least);
        }
    }

    fn times(&self) -> Vec<f64> {
        let of_contact = || self.contact.iter().flatten().map(|c| c.time).collect();
        self.state.as_ref().map_or_else(of_contact, |s| s.iter().map(|s| s.time).collect())
    }

    /// Checks that all topics have the same ticks, and each the same bodies at every tick.
    fn check(&self) -> Result<(), LogDamage> {
        let times = self.times();
        let same = |topic: &'static str, other: &mut dyn ExactSizeIterator<Item = f64>| {
            let count = other.len();
            if count != times.len() || !other.zip(&times).all(|(a, b)| a.to_bits() == b.to_bits()) {
                return Err(LogDamage::Ticks { topic, found: count, expected: times.len() });
            }
            Ok(())
        };
        if let Some(all) = &self.contact {
            same("/contact", &mut all.iter().map(|c| c.time))?;
            let shape = |c: &Contact| c.soles.iter().map(|s| (s.name.clone(), s.positions.len())).collect::<Vec<_>>();
            let first = all.first().map(shape);
            for c in all {
                let complete = c.soles.iter().all(|s| {
                    let k = s.positions.len();
                    s.clamped.len() == k && s.velocities.len() == k && s.forces.len() == k
                });
                if !complete || Some(shape(c)) != first {
                    return Err(LogDamage::Soles(c.time));
                }
            }
        }
        if let Some(all) = &self.residual {
            same("/residual", &mut all.iter().map(|r| r.time))?;
        }
        if let Some(all) = &self.estimate {
            same("/estimate", &mut all.iter().map(|e| e.time))?;
            estimate_series::check(all, self.joints.len(), self.estimated_soles.len())?;
        }
        if let Some(all) = &self.self_collision {
            same("/self_collision", &mut all.iter().map(|e| e.time))?;
            self_collision_series::check(all, self.joints.len())?;
        }
        if self.state.is_some() || self.contact.is_some() {
            self.objects.check(&times)?;
        }
        let mut points: &[Point] = &[];
        for s in self.state.iter().flatten() {
            // Tasks started during the run add their points.
            if s.points.len() < points.len() || points.iter().zip(&s.points).any(|(a, b)| a.name != b.name) {
                return Err(LogDamage::Points(s.time));
            }
            points = &s.points;
            let arrays = [&s.q, &s.qd, &s.q_desired, &s.qd_desired, &s.effort];
            if let Some(odd) = arrays.into_iter().find(|a| a.len() != self.joints.len()) {
                return Err(LogDamage::Joints { time: s.time, found: odd.len(), joints: self.joints.len() });
            }
        }
        Ok(())
    }

    fn into_trajectory(self, info: RunInfo, complete: bool, attachments: Vec<Attachment>) -> Trajectory {
        let times = self.times();
        // Frames alone have no times of ours.
        let objects = if times.is_empty() { Vec::new() } else { self.objects.into_series() };
        Trajectory {
            info,
            complete,
            attachments,
            times,
            objects,
            estimate: self.estimate.map(|rows| estimate_series::series(&self.joints, &self.estimated_soles, &rows)),
            self_collision: self.self_collision.map(|rows| self_collision_series::series(&self.joints, &rows)),
            motion: self.state.map(|rows| motion(&self.joints, &rows)),
            soles: self.contact.map(|rows| soles(&rows)),
            residuals: self.residual,
            events: self.events.into_iter().map(event).collect(),
        }
    }
}

/// Names of the joints, and whether each is prismatic.
fn joints(metadata: &BTreeMap<String, String>) -> Result<Vec<(String, bool)>, LogDamage> {
    let (names, kinds) = (list("/state", metadata, "joints")?, list("/state", metadata, "joint_kinds")?);
    if names.len() != kinds.len() {
        return Err(LogDamage::JointKinds { joints: names.len(), kinds: kinds.len() });
    }
    Ok(names.into_iter().zip(kinds).map(|(name, kind)| (name, kind == "prismatic")).collect())
}

/// A list of names in the metadata of a channel.
fn list(
    topic: &'static str,
    metadata: &BTreeMap<String, String>,
    entry: &'static str,
) -> Result<Vec<String>, LogDamage> {
    let text = metadata.get(entry).ok_or(LogDamage::ChannelEntry { topic, entry })?;
    serde_json::from_str(text).map_err(|source| LogDamage::ChannelList { topic, entry, source })
}

fn motion(joints: &[(String, bool)], rows: &[State]) -> Motion {
    let column = |get: fn(&State) -> &Vec<f64>, j: usize| rows.iter().map(|s| get(s)[j]).collect();
    let joint = |(j, (name, prismatic)): (usize, &(String, bool))| JointSeries {
        name: name.clone(),
        prismatic: *prismatic,
        position: column(|s| &s.q, j),
        velocity: column(|s| &s.qd, j),
        desired_position: column(|s| &s.q_desired, j),
        desired_velocity: column(|s| &s.qd_desired, j),
        effort: column(|s| &s.effort, j),
        // Logs of earlier versions lack it.
        desired_effort: rows.iter().map(|s| s.effort_desired.get(j).copied().unwrap_or(f64::NAN)).collect(),
    };
    let triples = |get: fn(&State) -> &Option<VectorMessage>| rows.iter().map(|s| vector_or_zero(get(s))).collect();
    let force_at = |f: &Force| (vector_or_zero(&f.point), vector_or_zero(&f.force));
    Motion {
        base_position: triples(|s| &s.base_position),
        base_orientation: rows.iter().map(|s| quaternion(s.base_orientation)).collect(),
        base_linear_velocity: triples(|s| &s.base_linear_velocity),
        base_angular_velocity: triples(|s| &s.base_angular_velocity),
        joints: joints.iter().enumerate().map(joint).collect(),
        com: triples(|s| &s.com),
        com_velocity: triples(|s| &s.com_velocity),
        cop: rows.iter().map(|s| s.cop.as_ref().map(vector)).collect(),
        stable_point: rows.iter().map(|s| s.stable_point.as_ref().map(vector)).collect(),
        support_polygon: rows.iter().map(|s| s.support_polygon.iter().map(vector).collect()).collect(),
        points: points(rows),
        external: rows.iter().map(|s| s.external.iter().map(force_at).collect()).collect(),
    }
}

fn points(rows: &[State]) -> Vec<PointSeries> {
    let Some(last) = rows.last() else { return Vec::new() };
    let at = |row: &State, k: usize| row.points.get(k).and_then(|point| point.position.as_ref()).map(vector);
    let series = |(k, point): (usize, &Point)| PointSeries {
        name: point.name.clone(),
        position: rows.iter().map(|row| at(row, k)).collect(),
    };
    last.points.iter().enumerate().map(series).collect()
}

fn soles(rows: &[Contact]) -> Vec<SoleSeries> {
    let Some(first) = rows.first() else { return Vec::new() };
    let of = |s: usize| rows.iter().map(move |row| &row.soles[s]);
    let vertex = |s: usize, v: usize| VertexSeries {
        clamped: of(s).map(|sole| sole.clamped[v]).collect(),
        position: of(s).map(|sole| vector(&sole.positions[v])).collect(),
        velocity: of(s).map(|sole| vector(&sole.velocities[v])).collect(),
        force: of(s).map(|sole| vector(&sole.forces[v])).collect(),
    };
    let sole = |(s, of_first): (usize, &Sole)| SoleSeries {
        name: of_first.name.clone(),
        is_link: false,
        state: of(s).map(|sole| sole.state.clone()).collect(),
        force: of(s).map(|sole| vector_or_zero(&sole.force)).collect(),
        vertices: (0..of_first.positions.len()).map(|v| vertex(s, v)).collect(),
        points: Vec::new(),
    };
    first.soles.iter().enumerate().map(sole).chain(links(rows)).collect()
}

/// The other contacts that are closed at some tick.
fn links(rows: &[Contact]) -> impl Iterator<Item = SoleSeries> {
    let names: BTreeSet<&str> = rows.iter().flat_map(|row| row.links.iter().map(|link| link.name.as_str())).collect();
    names.into_iter().map(|name| {
        let of = || rows.iter().map(|row| row.links.iter().find(|link| link.name == name));
        SoleSeries {
            name: name.to_owned(),
            is_link: true,
            state: of().map(|link| link.map_or("free".to_owned(), |link| link.state.clone())).collect(),
            force: of()
                .map(|link| link.map_or(nalgebra::Vector3::zeros(), |link| vector_or_zero(&link.force)))
                .collect(),
            vertices: Vec::new(),
            points: of().map(|link| link.map(contact_points).unwrap_or_default()).collect(),
        }
    })
}

fn contact_points(contact: &Sole) -> Vec<ContactPoint> {
    let vertices = contact.clamped.iter().zip(&contact.positions).zip(&contact.forces);
    let point = |((clamped, position), force): ((&bool, &VectorMessage), &VectorMessage)| ContactPoint {
        clamped: *clamped,
        position: vector(position),
        force: vector(force),
    };
    vertices.map(point).collect()
}

fn event(e: Event) -> LoggedEvent {
    LoggedEvent { time: e.time, kind: e.kind, subject: e.subject, message: e.message }
}
