//! `log.mcap`: everything a run tells, for viewers and for programs.
//!
//! A mixed log, so that each viewer finds what it draws by itself: frames and scene in Foxglove's protobuf messages,
//! joint states and robot description in ROS 2's CDR, and the tick record in packed protobuf messages of our own. All
//! are described in the file. The log time is the simulated time in nanoseconds; no clock, host name or random number
//! enters, so equal runs give equal bytes.
//!
//! A new topic is a file with a type that implements [`Topic`], and a line in [`open_topics`].

mod contact;
mod convert;
mod descriptor;
mod estimate;
mod events;
mod frames;
mod marks;
pub mod messages;
mod outlet;
mod problems;
mod read;
mod residual;
pub mod ros;
mod self_contact;
mod shapes;
mod sink;
mod state;
mod topics;

use crate::files::RecordError;
use crate::robot::Model;
use crate::sim::{Observer, SimEvent, Snapshot};
use nalgebra::{Isometry3, Vector3};
pub use outlet::{ChannelInfo, Outlet};
pub use problems::{MAX_PROBLEMS, PROBLEM_SCHEMA, ProblemRecord, ProblemWriter};
pub use read::{Attachment, JointSeries, LogError, LoggedEvent, Motion, PointSeries, RunInfo};
pub use read::{EstimateSeries, Frame, JointReadings, Scene, SelfCollisionSeries, SoleReadings};
pub use read::{SoleSeries, Trajectory, VertexSeries};
use sink::Sink;
use std::path::Path;
pub use topics::{ParseTopicError, Topics};

/// A text to be attached.
#[derive(Clone, Copy, Debug)]
pub struct Document<'a> {
    /// File name.
    pub name: &'a str,
    /// Contents.
    pub text: &'a str,
}

/// What a log tells before the first tick.
#[derive(Clone, Copy, Debug)]
pub struct LogHeader<'a> {
    /// Name of the scenario.
    pub scenario_name: &'a str,
    /// Key of the run.
    pub key: &'a str,
    /// Contact method.
    pub method: &'a str,
    /// The resolved scenario, attached.
    pub scenario: Document<'a>,
    /// The robot file, attached; none for a bare URDF.
    pub robot: Option<Document<'a>>,
    /// The URDF, attached and published.
    pub urdf: Document<'a>,
    /// Other texts that the run is made of, attached.
    pub inputs: &'a [Document<'a>],
    /// Pose of the floor in the world: a point of the plane, z its normal.
    pub floor: Isometry3<f64>,
    /// Outlines of the floor's patches, world, m.
    pub patches: &'a [Vec<Vector3<f64>>],
    /// What to log.
    pub topics: Topics,
}

/// One kind of message written at every tick. Implementations keep their message and fill it anew.
trait Topic: Send {
    /// Writes what the snapshot says, at `time` nanoseconds.
    fn record(&mut self, time: u64, snapshot: &Snapshot, sink: &mut Sink) -> Result<(), RecordError>;
}

fn open_topics(sink: &mut Sink, model: &Model, header: &LogHeader) -> Result<Vec<Box<dyn Topic>>, RecordError> {
    let mut topics: Vec<Box<dyn Topic>> = Vec::new();
    if header.topics.state {
        topics.push(Box::new(state::StateTopic::open(sink, model)?));
        topics.push(Box::new(state::JointStates::open(sink, model, header)?));
        topics.push(Box::new(estimate::EstimateTopic::new(model)));
        topics.push(Box::new(self_contact::SelfCollisionTopic::new(model)));
    }
    if header.topics.contact {
        topics.push(Box::new(contact::ContactTopic::open(sink, model)?));
        topics.push(Box::new(residual::ResidualTopic::open(sink)?));
    }
    if header.topics.scene {
        topics.push(Box::new(frames::Frames::open(sink, model, header)?));
        shapes::write(sink, model, header)?;
        topics.push(Box::new(marks::Marks::open(sink, model)?));
    }
    Ok(topics)
}

/// Writes the log of one run. Dropped without [`LogWriter::finish`] (a run that panicked), it still closes the log and
/// gives it its name, with the metadata entry `end` saying that it is not complete.
pub struct LogWriter {
    /// `None` once closed.
    sink: Option<Sink>,
    /// Time of the last snapshot, ns.
    last: u64,
    begun: bool,
    topics: Vec<Box<dyn Topic>>,
    events: events::EventTopics,
    links: usize,
    joints: usize,
    soles: usize,
}

impl LogWriter {
    /// Opens a log that will appear at `path`, and writes what does not change: attachments, metadata, the robot's
    /// description and shapes. The folder is created if need be.
    ///
    /// # Errors
    /// The folder or file cannot be written.
    pub fn create(path: &Path, model: &Model, header: &LogHeader) -> Result<Self, RecordError> {
        Self::open(Some(path), None, model, header)
    }

    /// The same with somebody else who takes all messages, without a file if there is no path.
    ///
    /// # Errors
    /// The folder or file cannot be written.
    pub fn open(
        path: Option<&Path>,
        outlet: Option<Box<dyn Outlet>>,
        model: &Model,
        header: &LogHeader,
    ) -> Result<Self, RecordError> {
        let mut sink = Sink::open(path, outlet)?;
        sink.attach(header.scenario.name, "application/toml", header.scenario.text)?;
        if let Some(robot) = &header.robot {
            sink.attach(robot.name, "application/toml", robot.text)?;
        }
        sink.attach(header.urdf.name, "application/xml", header.urdf.text)?;
        for input in header.inputs {
            sink.attach(input.name, "text/plain", input.text)?;
        }
        sink.metadata(
            "run",
            &[
                ("scenario", header.scenario_name),
                ("key", header.key),
                ("method", header.method),
                ("program", concat!("stiction ", env!("CARGO_PKG_VERSION"))),
                ("robot", &model.name),
                ("world_frame", frames::world_frame(model)),
            ],
        )?;
        let topics = open_topics(&mut sink, model, header)?;
        let events = events::EventTopics::open(&mut sink)?;
        sink.described();
        Ok(Self {
            sink: Some(sink),
            last: 0,
            begun: false,
            topics,
            events,
            links: model.links.len(),
            joints: model.joints.len(),
            soles: model.soles.len(),
        })
    }

    /// Closes the log and gives it its final name. For a run of any outcome that ended by itself.
    ///
    /// # Errors
    /// The file cannot be written; then there is no log.
    pub fn finish(mut self) -> Result<(), RecordError> {
        self.close("true")
    }

    fn close(&mut self, complete: &str) -> Result<(), RecordError> {
        let Some(mut sink) = self.sink.take() else { return Ok(()) };
        // Events after the last snapshot.
        sink.instant(self.last);
        sink.metadata("end", &[("complete", complete)])?;
        sink.finish()
    }

    fn check(&self, s: &Snapshot) -> Result<(), RecordError> {
        let counts = [
            ("link poses", s.link_poses.len(), self.links),
            ("joint positions", s.q.len(), self.joints),
            ("joint velocities", s.qd.len(), self.joints),
            ("soles", s.soles.len(), self.soles),
        ];
        match counts.into_iter().find(|(_, found, expected)| found != expected) {
            Some((what, found, expected)) => Err(RecordError::Shape { time: s.time, what, found, expected }),
            None => Ok(()),
        }
    }
}

impl Observer for LogWriter {
    fn snapshot(&mut self, snapshot: &Snapshot) -> Result<(), String> {
        self.check(snapshot).map_err(|e| e.to_string())?;
        let Some(sink) = &mut self.sink else { return Ok(()) };
        // The first is always gone through: some topics are opened by it.
        if self.begun && !sink.is_wanted() {
            return Ok(());
        }
        let time = convert::nanoseconds(snapshot.time);
        self.topics.iter_mut().try_for_each(|t| t.record(time, snapshot, sink)).map_err(|e| e.to_string())?;
        sink.instant(time);
        (self.last, self.begun) = (time, true);
        Ok(())
    }

    fn event(&mut self, event: &SimEvent) -> Result<(), String> {
        let Some(sink) = self.sink.as_mut().filter(|sink| sink.is_wanted()) else { return Ok(()) };
        self.events.record(event, sink).map_err(|e| e.to_string())
    }
}

impl Drop for LogWriter {
    fn drop(&mut self) {
        // Nobody is left to tell; the run's own outcome says what went wrong.
        let _ = self.close("false");
    }
}
