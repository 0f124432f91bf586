//! A data set with the run that repeats it: from parameter values to the columns of the data.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::assemble;
use crate::batch::{Finding, Findings, Overrides, prepare_loaded};
use crate::export::{self, Selection, Values};
use crate::files::catch_panic;
use crate::fit::fit_file::FitFile;
use crate::fit::frame_recorder::FrameRecorder;
use crate::fit::recording::{self, Recording};
use crate::robot::{Model, Robot};
use crate::scenario::{self, IntegratorSpec, Run, ScenarioFile};
use crate::sim::setup::IntegratorSetup;
use crate::sim::{Outcome, Setup, Simulation};
use crate::text::{Diagnostic, Diagnostics};

/// Instants of frames and data that are nearer than this are the same, s.
const SAME_INSTANT: f64 = 1e-9;

/// A data set and the scenario that repeats it.
#[derive(Clone)]
pub struct Experiment {
    /// Name of the data.
    pub name: String,
    /// The data are checked, not fitted.
    pub hold_out: bool,
    /// The data.
    pub recording: Recording,
    file: ScenarioFile,
    overrides: Overrides,
    robot: Arc<Robot>,
    objects: Vec<Arc<Robot>>,
    integrator: IntegratorSpec,
}

/// Values by dotted keys.
pub type KeyValues<'a> = &'a [(String, f64)];

impl Experiment {
    /// Reads the data at an index of the fit file and checks their run at the values `start`.
    ///
    /// # Errors
    /// Errors of the data, of the scenario, of an override or a parameter, or of the robot.
    pub fn load(fit: &FitFile, index: usize, start: KeyValues) -> Result<Self, Findings> {
        let refused = |diagnostic: Box<Diagnostic>| {
            let mut findings = Findings::default();
            findings.push(Finding::Scenario(diagnostic));
            findings
        };
        let all = |diagnostics: Diagnostics| {
            let mut findings = Findings::default();
            findings.extend(diagnostics);
            findings
        };
        let recording = recording::read(fit, index).map_err(refused)?;
        let file = scenario::load(&fit.resolve(&fit.spec.scenario)).map_err(all)?;
        let overrides: Overrides = fit.spec.data[index].set.clone().into_iter().collect();
        check_keys(fit, index, &file, &overrides, start)?;
        let (name, hold_out) = (fit.data_name(index), fit.spec.data[index].hold_out);
        let with_start: Overrides = with_values(&overrides, start);
        let (plan, _) = prepare_loaded([(&file, &with_start)], 1)?;
        let job = plan.job(0);
        if job.run.scenario.robot.backend.is_some() {
            let message = "the scenario drives a robot in another process, which a fit cannot repeat";
            return Err(refused(fit.error_at("scenario", message, None)));
        }
        let (last, end) = (recording.times[recording.times.len() - 1], job.run.scenario.end());
        if last > end + SAME_INSTANT {
            let message = format!("the data `{name}` reach to {last} s, the scenario ends at {end} s");
            let help = format!("set `duration` of the scenario, here by `set = {{ duration = {last} }}`, or `to`");
            return Err(refused(fit.error_at(&format!("data.{index}.file"), message, Some(help))));
        }
        let integrator = job.run.scenario.integrator.clone();
        let (robot, objects) = (job.robot, job.objects);
        let experiment = Experiment { name, hold_out, recording, file, overrides, robot, objects, integrator };
        experiment.check_columns(fit, &job.run)?;
        Ok(experiment)
    }

    /// The robot.
    pub fn model(&self) -> &Model {
        &self.robot.model
    }

    /// The integrator of its run.
    pub fn integrator(&self) -> &IntegratorSpec {
        &self.integrator
    }

    /// Checks that the run has the columns of the data.
    fn check_columns(&self, fit: &FitFile, run: &Run) -> Result<(), Findings> {
        let mut findings = Findings::default();
        let simulation = assemble::setup_with(run, &self.robot, &self.objects)
            .map_err(|errors| errors.to_string())
            .and_then(|setup| {
                let names = FrameRecorder::new(&setup).column_names();
                Simulation::new(setup).map_err(|error| error.to_string()).map(|_| names)
            });
        match simulation {
            Ok(names) => {
                for channel in self.recording.channels.iter().filter(|channel| !names.contains(&channel.column)) {
                    let message = format!("the scenario for `{}` has no column `{}`", self.name, channel.column);
                    let help = crate::text::suggest::nearest(&channel.column, names.iter().map(String::as_str));
                    let help = help.map(|near| format!("did you mean `{near}`?"));
                    let at = format!("signal.{}.column", channel.signal);
                    findings.push(Finding::Scenario(fit.error_at(&at, message, help)));
                }
            }
            Err(message) => findings.push(Finding::Plan(message)),
        }
        if findings.errors() > 0 { Err(findings) } else { Ok(()) }
    }

    /// The columns of the data at their instants, for these values of parameters: one list per
    /// channel.
    ///
    /// # Errors
    /// The values are not valid, the run does not reach the last instant, or a column has no value
    /// where the data have one.
    pub fn simulate(&self, values: KeyValues, cancel: &AtomicBool) -> Result<Vec<Vec<f64>>, String> {
        catch_panic(|| self.simulate_checked(values, cancel)).unwrap_or_else(Err)
    }

    fn simulate_checked(&self, values: KeyValues, cancel: &AtomicBool) -> Result<Vec<Vec<f64>>, String> {
        let run = self.run(values).map_err(|errors| errors.to_string())?;
        let setup = assemble::setup_with(&run, &self.robot, &self.objects).map_err(|errors| errors.to_string())?;
        let setup = self.with_instants(setup);
        let mut recorder = FrameRecorder::new(&setup);
        let mut simulation = Simulation::new(setup).map_err(|error| error.to_string())?;
        let (outcome, message) = simulation.run(&mut recorder, cancel);
        if outcome != Outcome::Passed {
            let at = simulation.metrics().duration_s;
            return Err(format!(
                "the run of `{}` ended at {at} s with outcome {}: {message}",
                self.name,
                outcome.name()
            ));
        }
        self.sampled(recorder)
    }

    fn run(&self, values: KeyValues) -> Result<Run, Diagnostics> {
        let expansion = self.file.expansion(&with_values(&self.overrides, values), 1)?;
        let mut run = None;
        expansion.check(&mut |created| run = Some(created))?;
        run.ok_or_else(|| Diagnostic::whole_file(self.file.path.display().to_string(), "has no run").into())
    }

    /// Snapshots at the instants of the data, up to the last. Fixed steps have no dense output: their
    /// snapshots are all steps.
    fn with_instants(&self, mut setup: Setup) -> Setup {
        let times = &self.recording.times;
        setup.duration = setup.duration.min(times[times.len() - 1]);
        match setup.integrator {
            IntegratorSetup::Controlled { .. } => setup.log_instants = times.clone(),
            IntegratorSetup::Stepped { step, .. } | IntegratorSetup::SemiImplicit { step } => {
                setup.log_rate = step.recip();
            }
        }
        setup
    }

    /// The columns of the data at their instants; linear between two frames.
    fn sampled(&self, recorder: FrameRecorder) -> Result<Vec<Vec<f64>>, String> {
        let frames = recorder.into_trajectory();
        let columns = self.recording.channels.iter().map(|channel| channel.column.clone()).collect();
        let selection = Selection { columns, ..Selection::default() };
        let table = export::series(&frames, &selection).map_err(|error| error.to_string())?;
        let of_channel = |channel: &recording::Channel| {
            let Some(Values::Real(values)) = table.column(&channel.column) else {
                return Err(format!("`{}` is not a number", channel.column));
            };
            let at = |(&time, measured): (&f64, &f64)| {
                let value = sample(&frames.times, values, time);
                if measured.is_finite() && !value.is_finite() {
                    return Err(format!("`{}` of `{}` has no value at {time} s", channel.column, self.name));
                }
                Ok(value)
            };
            self.recording.times.iter().zip(&channel.values).map(at).collect()
        };
        self.recording.channels.iter().map(of_channel).collect()
    }
}

/// The value at a time, linear between two frames; NaN where there is none.
fn sample(times: &[f64], values: &[Option<f64>], time: f64) -> f64 {
    let after = times.partition_point(|t| *t < time - SAME_INSTANT);
    let value = |i: usize| values.get(i).copied().flatten().unwrap_or(f64::NAN);
    match times.get(after) {
        Some(t) if *t <= time + SAME_INSTANT => value(after),
        Some(t) if after > 0 => {
            let (t0, a, b) = (times[after - 1], value(after - 1), value(after));
            a + (b - a) * ((time - t0) / (t - t0))
        }
        _ => f64::NAN,
    }
}

fn with_values(overrides: &Overrides, values: KeyValues) -> Overrides {
    let values = values.iter().map(|(key, value)| (key.clone(), toml::Value::Float(*value)));
    overrides.iter().cloned().chain(values).collect()
}

/// Checks each key of `set` and of the parameters on its own, so that an error is shown at the key.
fn check_keys(
    fit: &FitFile,
    index: usize,
    file: &ScenarioFile,
    overrides: &Overrides,
    start: KeyValues,
) -> Result<(), Findings> {
    let mut findings = Findings::default();
    let check = |set: &Overrides| {
        let expansion = file.expansion(set, 1)?;
        expansion.check(&mut |_| {}).map(|_| ())
    };
    if let Err(errors) = check(&Overrides::new()) {
        // An override may be what the scenario lacks.
        if check(&with_values(overrides, start)).is_ok() {
            return Ok(());
        }
        let all = file.expansion(&Overrides::new(), scenario::DEFAULT_MAX_RUNS);
        if all.is_ok_and(|expansion| expansion.runs() > 1) {
            let message = "the scenario has a sweep or a search: a fit needs a single run";
            findings.push(Finding::Scenario(fit.error_at("scenario", message, None)));
        }
        findings.extend(errors);
        return Err(findings);
    }
    let mut refuse = |at: String, errors: Diagnostics| {
        if let Some(error) = errors.0.into_iter().next() {
            let message = format!("`{at}`: {}", error.message);
            findings.push(Finding::Scenario(fit.error_at(&at, message, error.help)));
        }
    };
    for (key, value) in overrides {
        if let Err(errors) = check(&vec![(key.clone(), value.clone())]) {
            refuse(format!("data.{index}.set.{key:?}"), errors);
        }
    }
    for (i, parameter) in fit.spec.parameter.iter().enumerate() {
        let values = |value: f64| -> Overrides {
            with_values(overrides, &parameter.key.all().iter().map(|key| (key.clone(), value)).collect::<Vec<_>>())
        };
        if let Err(errors) = check(&values(parameter.start)) {
            refuse(format!("parameter.{i}.key"), errors);
        }
    }
    if findings.errors() > 0 { Err(findings) } else { Ok(()) }
}
