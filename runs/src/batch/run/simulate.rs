//! Simulates one job: builds its setup, runs it, writes its log and contact problems.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion};

use crate::assemble::setup_with;
use crate::batch::run::live_clients::{LiveClients, Pacer, RATE};
use crate::batch::{Job, Role, RunEnd, RunOutputs, Track};
use crate::contact::selection_record::SelectionRecord;
use crate::convert;
use crate::files::RecordError;
use crate::log::{AttachedText, LogHeader, LogWriter, MessageSink, ProblemWriter, TopicGroups};
use crate::remote::{Address, KeyFile, LinkError, RobotClient};
use crate::results::{Comparator, ReferenceMotion};
use crate::robot::{Link, Model, Robot};
use crate::scenario::{LogTopic, Run, host_and_port};
use crate::script::interruption_flag;
use crate::sim::CommandSource;
use crate::sim::Floor;
use crate::sim::RemoteRun;
use crate::sim::plant::objects::named_links;
use crate::sim::sensing::EstimatorSetup;
use crate::sim::{Observer, ObserverError, Outcome, Problems, RunError, Sample, Setup, SimEvent, Simulation, Snapshot};
use crate::terrain::Terrain;

/// Simulates a job; ends at the next step once `cancel` is set. Loading of scripts ends too if they
/// are [`interruptible`](crate::script::interruptible) by it.
///
/// If the scenario names a remote robot, the tasks drive that robot instead of a simulated one.
pub fn simulate(job: &Job, outputs: &RunOutputs, cancel: &AtomicBool) -> RunEnd {
    simulate_with_clients(job, outputs, cancel, None)
}

/// Like [`simulate`], with live clients; references have none.
pub fn simulate_with_clients(
    job: &Job,
    outputs: &RunOutputs,
    cancel: &AtomicBool,
    clients: Option<&dyn LiveClients>,
) -> RunEnd {
    let clients = clients.filter(|_| job.role != Role::Reference);
    match job.run.scenario.robot.backend {
        Some(_) => {
            drive(job, outputs, cancel, clients, |setup, observer, cancel| drive_remote(job, setup, observer, cancel))
        }
        None => drive(job, outputs, cancel, clients, simulate_here),
    }
}

/// Simulates a job commanded by a [`CommandSource`] instead of its tasks. `make` creates the source
/// and may wait for it until the flag is raised.
pub fn simulate_with_command_source(
    job: &Job,
    outputs: &RunOutputs,
    cancel: &AtomicBool,
    clients: Option<&dyn LiveClients>,
    make: impl FnOnce(&Setup, Option<Arc<AtomicBool>>) -> Result<Box<dyn CommandSource>, RunError>,
) -> RunEnd {
    drive(job, outputs, cancel, clients, |mut setup, observer, cancel| {
        let command_source = match make(&setup, interruption_flag()) {
            Ok(command_source) => command_source,
            Err(error) => return RunEnd { outcome: error.outcome, ..RunEnd::error(error.message) },
        };
        setup.command_source = Some(command_source);
        // State estimation and self-collision avoidance belong to the process of the tasks.
        setup.estimator = EstimatorSetup::Truth;
        setup.self_collision.iter_mut().for_each(|own| own.avoid = None);
        simulate_here(setup, observer, cancel)
    })
}

/// Builds a run, drives it and records its data.
fn drive(
    job: &Job,
    outputs: &RunOutputs,
    cancel: &AtomicBool,
    clients: Option<&dyn LiveClients>,
    driver: impl FnOnce(Setup, &mut dyn Observer, &AtomicBool) -> RunEnd,
) -> RunEnd {
    let setup = match setup_with(&job.run, &job.robot, &job.objects) {
        Ok(setup) => setup,
        // Planning built every setup without an error, so a script was interrupted.
        Err(_) if cancel.load(Ordering::Relaxed) => {
            return RunEnd { message: "interrupted".into(), ..RunEnd::of(Outcome::Cancelled) };
        }
        Err(errors) => return RunEnd::error(errors.to_string()),
    };
    let recorder = match Recorder::open(job, outputs, &setup, (clients, cancel)) {
        Ok(recorder) => recorder,
        Err(error) => return RunEnd::of_unwritten(&error),
    };
    if let Some(clients) = clients {
        clients.wait(cancel);
    }
    let end = drive_recorded(setup, recorder, cancel, driver);
    if let Some(clients) = clients {
        clients.finish();
    }
    end
}

/// Observes a run and writes its requested outputs.
struct Recorder<'a> {
    log: Option<LogWriter>,
    pacer: Option<Pacer>,
    cancel: &'a AtomicBool,
    problems: Option<ProblemWriter>,
    /// A file could not be written because the disk or a quota is full.
    storage_full: bool,
    trajectory: Option<ReferenceMotion>,
    comparator: Option<Comparator>,
}

impl<'a> Recorder<'a> {
    fn open(
        job: &Job,
        outputs: &RunOutputs,
        setup: &Setup,
        (clients, cancel): (Option<&dyn LiveClients>, &'a AtomicBool),
    ) -> Result<Self, RecordError> {
        let problems = |(folder, which): &(PathBuf, Problems)| {
            ProblemWriter::create(folder.clone(), &job.run.name, &job.key, *which)
        };
        let (trajectory, comparator) = match &outputs.track {
            Track::Nothing => (None, None),
            Track::Keep(rate) => (Some(blank_motion(*rate, setup)), None),
            Track::Compare(reference) => (None, Some(Comparator::new(reference.clone()))),
        };
        Ok(Recorder {
            trajectory,
            comparator,
            log: (outputs.log.is_some() || clients.is_some())
                .then(|| open_log(outputs.log.as_deref(), clients.map(LiveClients::sink), job, setup))
                .transpose()?,
            pacer: clients.and_then(LiveClients::pace).map(Pacer::new),
            cancel,
            storage_full: false,
            problems: outputs.problems.as_ref().map(problems).transpose()?,
        })
    }
}

impl Recorder<'_> {
    /// Fails once the run is cancelled: a step may contain any number of logged instants.
    fn check_cancelled(&self) -> Result<(), ObserverError> {
        if self.cancel.load(Ordering::Relaxed) { Err(ObserverError::new("interrupted")) } else { Ok(()) }
    }

    fn note_failure(&mut self, written: Result<(), ObserverError>) -> Result<(), ObserverError> {
        written.inspect_err(|error| {
            self.storage_full |= error.downcast_ref().is_some_and(RecordError::is_storage_full);
        })
    }
}

impl Observer for Recorder<'_> {
    fn snapshot(&mut self, snapshot: &Snapshot) -> Result<(), ObserverError> {
        self.check_cancelled()?;
        self.pacer.iter_mut().for_each(|pacer| pacer.wait(snapshot.time, self.cancel));
        let written = self.log.as_mut().map_or(Ok(()), |log| log.snapshot(snapshot));
        self.note_failure(written)
    }

    fn event(&mut self, event: &SimEvent) -> Result<(), ObserverError> {
        let written = self.log.as_mut().map_or(Ok(()), |log| log.event(event));
        self.note_failure(written)
    }

    fn sample_rate(&self) -> f64 {
        let rate = self.trajectory.as_ref().map(ReferenceMotion::rate);
        rate.or(self.comparator.as_ref().map(Comparator::rate)).unwrap_or(0.0)
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        self.check_cancelled()?;
        self.trajectory.iter_mut().for_each(|trajectory| trajectory.push(sample));
        self.comparator.iter_mut().for_each(|comparator| comparator.take(sample));
        Ok(())
    }

    fn problems(&self) -> Problems {
        self.problems.as_ref().map_or(Problems::None, ProblemWriter::which)
    }

    fn problem(&mut self, record: &SelectionRecord) -> Result<(), ObserverError> {
        let written = self.problems.as_mut().map_or(Ok(()), |p| p.write(record).map_err(ObserverError::new));
        self.note_failure(written)
    }
}

/// The motion of a reference run without samples yet.
fn blank_motion(rate: f64, setup: &Setup) -> ReferenceMotion {
    let joints = setup.objects.iter().map(|object| object.model.nj()).sum();
    let motion = ReferenceMotion::new(rate, setup.model.nj(), setup.model.soles.len());
    motion.with_objects(setup.objects.len(), joints)
}

fn drive_recorded(
    setup: Setup,
    mut recorder: Recorder<'_>,
    cancel: &AtomicBool,
    driver: impl FnOnce(Setup, &mut dyn Observer, &AtomicBool) -> RunEnd,
) -> RunEnd {
    let log_rate = match recorder.log {
        None => 0.0,
        // Live clients of a run without a log.
        Some(_) if setup.log_rate <= 0.0 => RATE,
        Some(_) => setup.log_rate,
    };
    let mut end = driver(Setup { log_rate, ..setup }, &mut recorder, cancel);
    end.notes.extend(recorder.problems.and_then(|p| p.summary()));
    end.comparison = recorder.comparator.map(|c| c.comparison()).unwrap_or_default();
    end.trajectory = recorder.trajectory;
    end.storage_full = recorder.storage_full;
    // When cancelled, dropping the writer leaves a log marked as incomplete.
    let log = recorder.log.filter(|_| end.outcome != Outcome::Cancelled);
    match log.map_or(Ok(()), LogWriter::finish) {
        Ok(()) => end,
        // The first error is reported: nothing could be written after it.
        Err(_) if end.outcome == Outcome::Error => end,
        Err(error) => {
            RunEnd { outcome: Outcome::Error, message: error.to_string(), storage_full: error.is_storage_full(), ..end }
        }
    }
}

fn simulate_here(mut setup: Setup, observer: &mut dyn Observer, cancel: &AtomicBool) -> RunEnd {
    let mut notes = std::mem::take(&mut setup.notes);
    let mut simulation = match Simulation::new(setup) {
        Ok(simulation) => simulation,
        Err(error) => return RunEnd { outcome: error.outcome, ..RunEnd::error(error.message) },
    };
    interruption_flag().into_iter().for_each(|flag| simulation.cancel_on(flag));
    let (outcome, message) = simulation.run(observer, cancel);
    notes.extend_from_slice(simulation.notes());
    let avoidance = simulation.avoidance_time();
    RunEnd { message, metrics: Some(simulation.metrics().clone()), notes, avoidance, ..RunEnd::of(outcome) }
}

/// Runs the tasks here with a remote robot.
fn drive_remote(job: &Job, mut setup: Setup, observer: &mut dyn Observer, cancel: &AtomicBool) -> RunEnd {
    let mut notes = std::mem::take(&mut setup.notes);
    let rate = job.run.scenario.control.rate;
    let spec = &job.run.scenario.robot;
    let (host, port) = spec.backend.as_deref().and_then(host_and_port).unwrap_or_default();
    let mut connect = || -> Result<RobotClient, LinkError> {
        let path = spec.backend_key.as_deref().map(|path| job.run.resolve(path));
        let file = path.as_deref().map(KeyFile::read).transpose()?;
        notes.extend(file.as_ref().and_then(|file| file.warning.clone()));
        let address = Address::resolve(host, port, file.map(|file| file.key))?;
        RobotClient::connect(&address, &setup.model, rate, None, interruption_flag())
    };
    let mut robot = match connect() {
        Ok(robot) => robot,
        Err(error) => {
            let error = RunError::from(error);
            return RunEnd { outcome: error.outcome, notes, ..RunEnd::error(error.message) };
        }
    };
    let mut run = RemoteRun::new(setup);
    let (outcome, message) = run.run(&mut robot, observer, cancel);
    notes.extend(crate::sim::RemoteRobot::leave(&mut robot));
    let avoidance = run.avoidance_time();
    RunEnd { message, metrics: Some(run.metrics().clone()), notes, avoidance, ..RunEnd::of(outcome) }
}

/// Opens the log of a job with this setup: a file, a live stream, or both.
///
/// # Errors
/// The file cannot be written.
pub fn open_log(
    path: Option<&Path>,
    sink: Option<Box<dyn MessageSink>>,
    job: &Job,
    setup: &Setup,
) -> Result<LogWriter, RecordError> {
    let topics = topics(&job.run.scenario.log.topics);
    open_log_of(
        (path, sink),
        &job.run,
        &job.key,
        &job.robot,
        &Scene {
            model: &setup.model,
            floor: &setup.floor,
            objects: named_links(setup.objects.iter().map(|o| (o.name.as_str(), &*o.model))),
            terrain: &setup.terrain,
        },
        setup.contact.method.name(),
        topics,
    )
}

/// What a log shows besides the robot's state.
pub struct Scene<'a> {
    /// The robot.
    pub model: &'a Model,
    /// The floor.
    pub floor: &'a Floor,
    /// Links of the objects.
    pub objects: Vec<Link>,
    /// Fixed bodies.
    pub terrain: &'a Terrain,
}

/// Opens the log of a run in this scene.
pub fn open_log_of(
    (path, sink): (Option<&Path>, Option<Box<dyn MessageSink>>),
    run: &Run,
    key: &str,
    robot: &Robot,
    &Scene { model, floor, ref objects, terrain }: &Scene,
    method: &str,
    topics: TopicGroups,
) -> Result<LogWriter, RecordError> {
    let Documents { robot_file, urdf, other_model } = documents(robot);
    let scenario_name = format!("{}.toml", run.name);
    // Binary inputs, such as a log for playback, are only hashed, and so are terrain and meshes, which are
    // often large.
    let is_shape = |key: &str| key.starts_with("terrain.") || key.starts_with("object.");
    let inputs = run.inputs.iter().filter(|input| !is_shape(&input.key));
    let texts = inputs.filter_map(|i| Some((i.name(), std::str::from_utf8(&i.bytes).ok()?)));
    let texts: Vec<_> = texts.collect();
    let inputs = other_model.iter().map(|(name, text)| (name.as_str(), text.as_ref()));
    let inputs = inputs.chain(texts.iter().map(|(name, text)| (name.as_ref(), *text)));
    let inputs: Vec<_> = inputs.map(|(name, text)| AttachedText { name, text }).collect();
    let patches: Vec<_> = floor.patches.iter().map(|p| floor.outline(p)).collect();
    let header = LogHeader {
        scenario_name: &run.name,
        key,
        method,
        scenario: AttachedText { name: &scenario_name, text: &run.resolved_toml },
        robot: robot_file.as_ref().map(|(name, text)| AttachedText { name, text }),
        urdf: AttachedText { name: &urdf.0, text: &urdf.1 },
        inputs: &inputs,
        floor: (!floor.is_absent).then(|| pose(floor)),
        patches: &patches,
        objects,
        terrain,
        topics,
        // A stream without a log is for viewers.
        viewer_rate: if run.scenario.log.rate > 0.0 { run.scenario.log.viewer_rate } else { f64::INFINITY },
    };
    LogWriter::open(path, sink, model, &header)
}

/// Texts of a robot, with the names of their files.
struct Documents<'a> {
    robot_file: Option<(String, Cow<'a, str>)>,
    /// The URDF; of a model of another format one written from it.
    urdf: (String, Cow<'a, str>),
    /// The model file of another format.
    other_model: Option<(String, Cow<'a, str>)>,
}

/// The texts of a robot. The model file comes after the robot file.
fn documents(robot: &Robot) -> Documents<'_> {
    let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let is_toml = |path: &Path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    let (robot_file, model) = match robot.files.as_slice() {
        [file, model, ..] if is_toml(&file.0) => (Some(file), Some(model)),
        [model, ..] => (None, Some(model)),
        [] => (None, None),
    };
    let robot_file = robot_file.map(|(path, bytes)| (name(path), String::from_utf8_lossy(bytes)));
    if let Some(text) = &robot.urdf_text {
        let name = model.map_or("robot.urdf".into(), |(path, _)| name(path));
        return Documents { robot_file, urdf: (name, text.into()), other_model: None };
    }
    let stem = model.and_then(|(path, _)| path.file_stem()).map_or("robot".into(), |stem| stem.to_string_lossy());
    let urdf = (format!("{stem}.urdf"), convert::description(&robot.model).into());
    let other_model = model.map(|(path, bytes)| (name(path), String::from_utf8_lossy(bytes)));
    Documents { robot_file, urdf, other_model }
}

fn pose(floor: &Floor) -> Isometry3<f64> {
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(floor.rotation));
    Isometry3::from_parts(Translation3::from(floor.point), rotation)
}

/// Topic groups that a scenario logs.
pub fn topics(logged: &[LogTopic]) -> TopicGroups {
    TopicGroups {
        state: logged.contains(&LogTopic::State),
        contact: logged.contains(&LogTopic::Contact),
        scene: logged.contains(&LogTopic::Scene),
    }
}
