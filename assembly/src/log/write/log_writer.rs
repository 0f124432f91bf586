//! Writes the log of one run from the snapshots and events of its simulation.

use crate::files::RecordError;
use crate::log::write::contact_topic::ContactTopic;
use crate::log::write::estimate_topic::EstimateTopic;
use crate::log::write::event_topics::EventTopics;
use crate::log::write::frames_topic::{FramesTopic, world_frame};
use crate::log::write::log_header::LogHeader;
use crate::log::write::log_output::LogOutput;
use crate::log::write::loops_topic::LoopsTopic;
use crate::log::write::marker_topic::MarkerTopic;
use crate::log::write::message_sink::MessageSink;
use crate::log::write::objects_topic::ObjectsTopic;
use crate::log::write::residual_topic::ResidualTopic;
use crate::log::write::self_collision_topic::SelfCollisionTopic;
use crate::log::write::state_topics::{JointStateTopic, StateTopic};
use crate::log::write::topic::Topic;
use crate::log::write::{conversion, scene_shapes};
use crate::robot::Model;
use crate::sim::{Observer, ObserverError, SimEvent, Snapshot};
use std::path::Path;

/// Topics of every logged instant, and those that only viewers read.
#[derive(Default)]
struct Topics {
    all: Vec<Box<dyn Topic>>,
    viewers: Vec<Box<dyn Topic>>,
}

/// Opens the topics of the selected groups.
fn open_topics(output: &mut LogOutput, model: &Model, header: &LogHeader) -> Result<Topics, RecordError> {
    let mut topics = Topics::default();
    if header.topics.state {
        topics.all.push(Box::new(StateTopic::open(output, model)?));
        topics.viewers.push(Box::new(JointStateTopic::open(output, model, header)?));
        topics.all.push(Box::new(EstimateTopic::new(model)));
        topics.all.push(Box::new(SelfCollisionTopic::new(model)));
    }
    if header.topics.contact {
        topics.all.push(Box::new(ContactTopic::open(output, model)?));
        topics.all.push(Box::new(ResidualTopic::open(output)?));
    }
    if !header.objects.is_empty() && (header.topics.state || header.topics.contact) {
        topics.all.push(Box::new(ObjectsTopic::open(output, header.objects)?));
    }
    if !(model.loops.is_empty() && model.couplings.is_empty()) && (header.topics.state || header.topics.contact) {
        topics.all.push(Box::new(LoopsTopic::open(output, model)?));
    }
    if header.topics.scene {
        topics.viewers.push(Box::new(FramesTopic::open(output, model, header)?));
        scene_shapes::write(output, model, header)?;
        topics.viewers.push(Box::new(MarkerTopic::open(output, model)?));
    }
    Ok(topics)
}

/// Writes the log of one run. If it is dropped without [`LogWriter::finish`] (a run that panicked),
/// it still closes and renames the log, and the metadata entry `end` marks it as incomplete.
pub struct LogWriter {
    /// `None` after closing.
    output: Option<LogOutput>,
    /// Time of the last snapshot, ns.
    last: u64,
    begun: bool,
    topics: Topics,
    /// Time from which on the topics of viewers are due, s, and the least time between their messages.
    due: f64,
    viewer_period: f64,
    events: EventTopics,
    joints: usize,
    soles: usize,
}

impl LogWriter {
    /// Opens a log that will appear at `path`, and writes its fixed part: attachments, metadata,
    /// the robot's description and shapes. Creates the folder if necessary.
    ///
    /// # Errors
    /// The folder or file cannot be written.
    pub fn create(path: &Path, model: &Model, header: &LogHeader) -> Result<Self, RecordError> {
        Self::open(Some(path), None, model, header)
    }

    /// Opens a log whose messages also go to `sink`. Without a path there is no file.
    ///
    /// # Errors
    /// The folder or file cannot be written.
    pub fn open(
        path: Option<&Path>,
        sink: Option<Box<dyn MessageSink>>,
        model: &Model,
        header: &LogHeader,
    ) -> Result<Self, RecordError> {
        let mut output = LogOutput::open(path, sink)?;
        output.attach(header.scenario.name, "application/toml", header.scenario.text)?;
        if let Some(robot) = &header.robot {
            output.attach(robot.name, "application/toml", robot.text)?;
        }
        output.attach(header.urdf.name, "application/xml", header.urdf.text)?;
        for input in header.inputs {
            output.attach(input.name, "text/plain", input.text)?;
        }
        output.metadata(
            "run",
            &[
                ("scenario", header.scenario_name),
                ("key", header.key),
                ("method", header.method),
                ("program", concat!("stiction ", env!("CARGO_PKG_VERSION"))),
                ("robot", &model.name),
                ("world_frame", world_frame(model)),
            ],
        )?;
        let topics = open_topics(&mut output, model, header)?;
        let events = EventTopics::open(&mut output)?;
        output.end_description();
        Ok(Self {
            output: Some(output),
            last: 0,
            begun: false,
            topics,
            due: f64::NEG_INFINITY,
            // Instants of the log are rounded.
            viewer_period: 0.99 / header.viewer_rate,
            events,
            joints: model.joints.len(),
            soles: model.soles.len(),
        })
    }

    /// Closes the log and renames it to its final name. For a run of any outcome that ended by
    /// itself.
    ///
    /// # Errors
    /// The file cannot be written; then there is no log.
    pub fn finish(mut self) -> Result<(), RecordError> {
        self.close("true")
    }

    fn close(&mut self, complete: &str) -> Result<(), RecordError> {
        let Some(mut output) = self.output.take() else { return Ok(()) };
        // Events after the last snapshot.
        output.end_tick(self.last);
        output.metadata("end", &[("complete", complete)])?;
        output.finish()
    }

    fn check(&self, s: &Snapshot) -> Result<(), RecordError> {
        let counts = [
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
    fn snapshot(&mut self, snapshot: &Snapshot) -> Result<(), ObserverError> {
        self.check(snapshot).map_err(ObserverError::new)?;
        let Some(output) = &mut self.output else { return Ok(()) };
        // The first snapshot is always written: it opens some topics.
        if self.begun && !output.has_receiver() {
            return Ok(());
        }
        let time = conversion::nanoseconds(snapshot.time);
        let mut record = |t: &mut Box<dyn Topic>| t.record(time, snapshot, output).map_err(ObserverError::new);
        self.topics.all.iter_mut().try_for_each(&mut record)?;
        // A restored state may be earlier.
        if snapshot.time >= self.due || snapshot.time < self.due - self.viewer_period {
            self.topics.viewers.iter_mut().try_for_each(&mut record)?;
            self.due = snapshot.time + self.viewer_period;
        }
        output.end_tick(time);
        (self.last, self.begun) = (time, true);
        Ok(())
    }

    fn event(&mut self, event: &SimEvent) -> Result<(), ObserverError> {
        let Some(output) = self.output.as_mut().filter(|output| output.has_receiver()) else { return Ok(()) };
        self.events.record(event, output).map_err(ObserverError::new)
    }
}

impl Drop for LogWriter {
    fn drop(&mut self) {
        // An error here has no receiver; the run's own outcome reports what went wrong.
        let _ = self.close("false");
    }
}
