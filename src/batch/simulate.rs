//! The body of a run: builds it, simulates it, writes its log.

use std::borrow::Cow;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion};

use super::{End, Job};
use crate::record::{Document, LogHeader, LogWriter, RecordError, Topics};
use crate::robot::{Model, Robot};
use crate::scenario::LogTopic;
use crate::sim::build::setup;
use crate::sim::setup::Floor;
use crate::sim::{Blind, Outcome, Setup, Simulation};

/// Simulates a job; the log goes to `log`, if there is to be one. Ends at the next step once `cancel` is set.
pub fn simulate(job: &Job, log: Option<&Path>, cancel: &AtomicBool) -> End {
    let setup = match setup(&job.run, &job.robot) {
        Ok(setup) => setup,
        Err(errors) => return End::error(errors.to_string()),
    };
    match log {
        None => advance(Setup { log_rate: 0.0, ..setup }, &mut Blind, cancel),
        Some(path) => match open_log(path, job, &setup) {
            Ok(writer) => logged(setup, writer, cancel),
            Err(error) => End::error(error.to_string()),
        },
    }
}

fn logged(setup: Setup, mut writer: LogWriter, cancel: &AtomicBool) -> End {
    let end = advance(setup, &mut writer, cancel);
    if end.outcome == Outcome::Cancelled {
        // Dropping it leaves a log that says of itself that it is not complete.
        return end;
    }
    match writer.finish() {
        Ok(()) => end,
        Err(error) => End { outcome: Outcome::Error, message: error.to_string(), ..end },
    }
}

fn advance(setup: Setup, observer: &mut dyn crate::sim::Observer, cancel: &AtomicBool) -> End {
    let mut simulation = match Simulation::new(setup) {
        Ok(simulation) => simulation,
        Err(stop) => return End { outcome: stop.outcome, message: stop.message, metrics: None },
    };
    let (outcome, message) = simulation.run(observer, cancel);
    End { outcome, message, metrics: Some(simulation.metrics().clone()) }
}

fn open_log(path: &Path, job: &Job, setup: &Setup) -> Result<LogWriter, RecordError> {
    let model: &Model = &setup.model;
    let (robot, urdf) = documents(&job.robot);
    let scenario_name = format!("{}.toml", job.run.name);
    let patches: Vec<_> = setup.floor.patches.iter().map(|p| setup.floor.outline(p)).collect();
    let header = LogHeader {
        scenario_name: &job.run.name,
        key: &job.key,
        method: &setup.contact.method,
        scenario: Document { name: &scenario_name, text: &job.run.resolved_toml },
        robot: robot.as_ref().map(|(name, text)| Document { name, text }),
        urdf: Document { name: &urdf, text: &job.robot.urdf_text },
        floor: pose(&setup.floor),
        patches: &patches,
        topics: topics(&job.run.scenario.log.topics),
    };
    LogWriter::create(path, model, &header)
}

/// The robot file's name and text, if there is one, and the URDF's name. The URDF comes after the robot file.
fn documents(robot: &Robot) -> (Option<(String, Cow<'_, str>)>, String) {
    let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let is_toml = |path: &Path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    match robot.files.as_slice() {
        [(file, bytes), (urdf, _), ..] if is_toml(file) => {
            (Some((name(file), String::from_utf8_lossy(bytes))), name(urdf))
        }
        [(urdf, _), ..] => (None, name(urdf)),
        [] => (None, "robot.urdf".into()),
    }
}

fn pose(floor: &Floor) -> Isometry3<f64> {
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(floor.rotation));
    Isometry3::from_parts(Translation3::from(floor.point), rotation)
}

fn topics(wanted: &[LogTopic]) -> Topics {
    Topics {
        state: wanted.contains(&LogTopic::State),
        contact: wanted.contains(&LogTopic::Contact),
        scene: wanted.contains(&LogTopic::Scene),
    }
}
