//! One run, stepped by its caller.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};

use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use stiction::assemble::setup_with;
use stiction::batch::{Job, open_log};
use stiction::metrics::{Measure, NUMERIC_COLUMNS};
use stiction::robot::DriveMode;
use stiction::sim::{RunError, SimEvent, Simulation as Run, Snapshot};

use crate::arrays::vector;
use crate::callables::{Callable, PythonForce, PythonTask, Raised, mode, numbers_of};
use crate::checkpoint::Checkpoint;
use crate::errors::{of_findings, of_results, of_run, refused};
use crate::scenario_file::{ScenarioFile, Selected};
use crate::state::{Contact, State};
use crate::stepped::{Commanded, PATIENCE, Recorder, Stepped};

/// One run, stepped by its caller. SI units, world axes, quaternions x, y, z, w.
#[pyclass(frozen, subclass, module = "stiction._native")]
pub struct Simulation {
    inner: Mutex<Stepped>,
    job: Job,
    raised: Raised,
    /// Functions that are called while it steps.
    functions: Vec<Callable>,
}

impl Simulation {
    /// Locks the run, unless another thread steps it.
    pub fn lock(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, Stepped>> {
        match self.inner.try_lock() {
            Ok(guard) => Ok(guard),
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => {
                Err(refused(py, "the simulation is being stepped: use it again when the call has returned"))
            }
        }
    }

    /// Takes the exception of a Python function out.
    pub fn take_raised(&self) -> Option<PyErr> {
        self.raised.take()
    }

    /// The exception for an error: that of the Python function which caused it, if one did.
    pub fn exception(&self, py: Python<'_>, error: &RunError, time: f64) -> PyErr {
        self.raised.take().unwrap_or_else(|| of_run(py, error, Some(time)))
    }

    /// Works on the run with the interpreter's lock released.
    fn work<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Stepped) -> Result<T, RunError> + Send,
    ) -> PyResult<T> {
        let mut guard = self.lock(py)?;
        let stepped = &mut *guard;
        let done = py.detach(|| work(stepped).map_err(|error| (error, stepped.run.time())));
        done.map_err(|(error, time)| self.exception(py, &error, time))
    }

    /// Like [`work`](Self::work) on a thread of its own, while this one checks for signals.
    fn work_interruptibly<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Stepped) -> Result<T, RunError> + Send,
    ) -> PyResult<T> {
        let mut guard = self.lock(py)?;
        let cancel = guard.cancel.clone();
        let stepped = &mut *guard;
        let (done, interrupted) = py.detach(|| {
            std::thread::scope(|scope| {
                let (sender, ended) = std::sync::mpsc::channel();
                let worker = scope.spawn(move || {
                    let done = work(stepped).map_err(|error| (error, stepped.run.time()));
                    let _ = sender.send(());
                    done
                });
                let mut interrupted = None;
                while ended.recv_timeout(PATIENCE) == Err(std::sync::mpsc::RecvTimeoutError::Timeout) {
                    if let Err(error) = Python::attach(|py| py.check_signals()) {
                        interrupted = Some(error);
                        cancel.store(true, Ordering::Relaxed);
                    }
                }
                (worker.join(), interrupted)
            })
        });
        if let Some(error) = interrupted {
            return Err(error);
        }
        match done {
            Ok(done) => done.map_err(|(error, time)| self.exception(py, &error, time)),
            Err(_) => Err(refused(py, "the simulation ended by an internal error")),
        }
    }
}

/// Tasks of the caller: name, function, start in s, needs.
type TaskEntry = (String, Py<PyAny>, f64, Vec<String>);
/// Forces of the caller: name, link, function, point in the link's frame in m, times at which the function is
/// discontinuous in s.
type ForceEntry = (String, String, Py<PyAny>, [f64; 3], Vec<f64>);

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (file, overrides=Vec::new(), run=0, tasks=Vec::new(), forces=Vec::new(), log=None))]
    fn new(
        py: Python<'_>,
        file: PyRef<'_, ScenarioFile>,
        overrides: Vec<(String, Bound<'_, PyAny>)>,
        run: usize,
        tasks: Vec<TaskEntry>,
        forces: Vec<ForceEntry>,
        log: Option<PathBuf>,
    ) -> PyResult<Self> {
        let (plan, _) = Selected::new(&[file], &overrides, None, None)?.plan(py)?;
        if run >= plan.runs() {
            let message = format!("run: found {run}, the scenario has {} runs, counted from 0", plan.runs());
            return Err(PyIndexError::new_err(message));
        }
        let job = plan.job(run);
        if job.run.scenario.robot.backend.is_some() {
            return Err(refused(py, "the scenario's robot is remote (`robot.backend`): it cannot be stepped here"));
        }
        let built = py.detach(|| setup_with(&job.run, &job.robot, &job.objects));
        let mut setup = built.map_err(|found| {
            let mut findings = stiction::batch::Findings::default();
            findings.extend(found);
            of_findings(py, &findings)
        })?;
        let raised = Raised::default();
        let mut functions = Vec::new();
        let has_tasks = !tasks.is_empty();
        for (name, function, start, needs) in tasks {
            if !start.is_finite() {
                return Err(PyValueError::new_err(format!("task `{name}`: found the start {start} s")));
            }
            let function = Callable::new(function);
            functions.push(function.clone());
            setup.tasks.add(start, Box::new(PythonTask::new(name, function, needs, raised.clone())?));
        }
        for (name, link, function, point, corners) in forces {
            let function = Callable::new(function);
            functions.push(function.clone());
            let force = PythonForce::new(name, &setup.model, (&link, point), function, corners, raised.clone())?;
            setup.forces.push(Box::new(force));
        }
        if let Some(path) = log.as_ref().filter(|path| path.exists() && !path.is_file()) {
            return Err(PyValueError::new_err(format!("log: {} is not a file", path.display())));
        }
        let opened = log.map(|path| open_log(Some(&path), None, &job, &setup)).transpose();
        let recorder = Recorder { log: opened.map_err(|error| of_results(py, error))?, events: Vec::new() };
        if recorder.log.is_none() {
            setup.log_rate = 0.0;
        }
        let rate = job.run.scenario.control.rate;
        let mut simulation = Run::new(setup).map_err(|error| of_run(py, &error, None))?;
        let cancel = Arc::new(AtomicBool::new(false));
        simulation.cancel_on(cancel.clone());
        let commanded = Arc::default();
        let mut stepped = Stepped { run: simulation, recorder, commanded, ticks: false, rate, end: None, cancel };
        if has_tasks {
            stepped.tick_always();
        }
        Ok(Simulation { inner: Mutex::new(stepped), job, raised, functions })
    }

    /// Simulated time, s.
    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.lock(py)?.run.time())
    }

    /// End of the run, s.
    #[getter]
    fn end(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.lock(py)?.run.end())
    }

    /// Time between control ticks, s.
    #[getter]
    fn tick(&self) -> f64 {
        1.0 / self.job.run.scenario.control.rate
    }

    /// Whether the run has ended, at its end or early.
    #[getter]
    fn has_ended(&self, py: Python<'_>) -> PyResult<bool> {
        Ok(self.lock(py)?.end.is_some())
    }

    /// Outcome after the end, such as `passed`.
    #[getter]
    fn outcome(&self, py: Python<'_>) -> PyResult<Option<&'static str>> {
        Ok(self.lock(py)?.end.as_ref().map(|(outcome, _)| outcome.name()))
    }

    /// Why the run ended early; empty if it did not.
    #[getter]
    fn message(&self, py: Python<'_>) -> PyResult<String> {
        Ok(self.lock(py)?.end.as_ref().map(|(_, message)| message.clone()).unwrap_or_default())
    }

    /// Notes on the run.
    #[getter]
    fn notes(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        Ok(self.lock(py)?.run.notes().to_vec())
    }

    /// Key of the run, as the command has it.
    #[getter]
    fn key(&self) -> &str {
        &self.job.key
    }

    /// Names of the joints, in the order of all joint arrays.
    #[getter]
    fn joint_names(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        Ok(self.lock(py)?.run.model().joints.iter().map(|joint| joint.name.clone()).collect())
    }

    /// Names of the links.
    #[getter]
    fn link_names(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        Ok(self.lock(py)?.run.model().links.iter().map(|link| link.name.clone()).collect())
    }

    /// Names of the soles.
    #[getter]
    fn sole_names(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        Ok(self.lock(py)?.run.model().soles.iter().map(|sole| sole.name.clone()).collect())
    }

    /// Mass of the robot, kg.
    #[getter]
    fn mass(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.lock(py)?.run.model().mass())
    }

    /// Advances by control ticks; returns whether the run continues.
    #[pyo3(signature = (ticks=1))]
    fn step(&self, py: Python<'_>, ticks: u64) -> PyResult<bool> {
        let mut interruption = None;
        let continues = self.work(py, |stepped| {
            stepped.step(ticks, || {
                interruption = Python::attach(|py| py.check_signals()).err();
                interruption.is_some()
            })
        })?;
        interruption.map_or(Ok(continues), Err)
    }

    /// Takes one step of the integrator; returns whether the run continues.
    fn step_once(&self, py: Python<'_>) -> PyResult<bool> {
        self.work(py, |stepped| {
            let next = stepped.run.time().next_up();
            stepped.advance(next)
        })
    }

    /// Advances to the first end of a step at or after `time`, s; returns whether the run continues.
    fn advance_to(&self, py: Python<'_>, time: f64) -> PyResult<bool> {
        if !time.is_finite() {
            return Err(PyValueError::new_err(format!("time: found {time}, expected a finite time in s")));
        }
        self.work_interruptibly(py, |stepped| stepped.advance(time))
    }

    /// Runs to the end; returns the outcome. An early end is no exception here.
    fn run(&self, py: Python<'_>) -> PyResult<&'static str> {
        let done = self.work_interruptibly(py, |stepped| {
            let _ = stepped.finish();
            Ok(stepped.end.as_ref().map_or("error", |(outcome, _)| outcome.name()))
        })?;
        self.raised.take().map_or(Ok(done), Err)
    }

    /// Motion of the robot now.
    #[getter]
    fn state(&self, py: Python<'_>) -> PyResult<State> {
        let guard = self.lock(py)?;
        Ok(State::new(guard.run.state(), &guard.run.plant().drives.efforts))
    }

    /// Contacts now: of each sole, then of other links with the floor and of pairs of bodies.
    #[getter]
    fn contacts(&self, py: Python<'_>) -> PyResult<Vec<Contact>> {
        let snapshot = self.present(py)?;
        let guard = self.lock(py)?;
        let soles = guard.run.model().soles.iter().map(|sole| sole.name.as_str()).zip(&snapshot.soles);
        let others = snapshot.links.iter().map(|(name, contact)| (name.as_str(), contact));
        soles.chain(others).map(|(name, contact)| Contact::new(py, name, contact)).collect()
    }

    /// Centre of mass, centre of pressure, energies and residuals now, by name.
    fn snapshot<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let snapshot = self.present(py)?;
        let (energy, residual) = (&snapshot.energy, &snapshot.residual);
        let values = PyDict::new(py);
        values.set_item("time", snapshot.time)?;
        values.set_item("com", vector(py, &snapshot.com)?)?;
        values.set_item("com_velocity", vector(py, &snapshot.com_velocity)?)?;
        values
            .set_item("centre_of_pressure", snapshot.centre_of_pressure.map(|point| vector(py, &point)).transpose()?)?;
        let energies = [
            ("change", energy.change),
            ("actuators", energy.actuators),
            ("external", energy.external),
            ("joint_loss", energy.joint_loss),
            ("friction_loss", energy.friction_loss),
            ("impact_loss", energy.impact_loss),
            ("error", energy.error()),
        ];
        values.set_item("energy", energies.into_py_dict(py)?)?;
        let residuals = [
            ("penetration", residual.penetration),
            ("tension", residual.tension),
            ("signorini", residual.signorini),
            ("cone_excess", residual.cone_excess),
            ("dissipation_gap", residual.dissipation_gap),
            ("creep_speed", residual.creep_speed),
            ("resultant_gap", residual.resultant_gap),
        ];
        values.set_item("residual", residuals.into_py_dict(py)?)?;
        Ok(values)
    }

    /// Metrics so far, by the names of the summary's columns; missing where not measured.
    #[getter]
    fn metrics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let guard = self.lock(py)?;
        let metrics = guard.run.metrics();
        let values = PyDict::new(py);
        for name in NUMERIC_COLUMNS {
            match metrics.measure(name) {
                Measure::Real(value) => values.set_item(name, value)?,
                Measure::Count(value) => values.set_item(name, value)?,
                Measure::Nothing => {}
            }
        }
        Ok(values)
    }

    /// Events so far: time in s, kind, subject, message.
    #[getter]
    fn events(&self, py: Python<'_>) -> PyResult<Vec<(f64, String, String, String)>> {
        let guard = self.lock(py)?;
        let event = |e: &SimEvent| (e.time, e.kind.as_str().to_owned(), e.subject.clone(), e.message.clone());
        Ok(guard.recorder.events.iter().map(event).collect())
    }

    /// Commands joints from the next control tick on, which after `step` is now. Arrays have an entry per
    /// joint; values that are not given are left to the tasks.
    #[pyo3(signature = (position=None, velocity=None, effort=None, kp=None, kd=None, mode=None))]
    #[allow(clippy::too_many_arguments)]
    fn command(
        &self,
        py: Python<'_>,
        position: Option<Bound<'_, PyAny>>,
        velocity: Option<Bound<'_, PyAny>>,
        effort: Option<Bound<'_, PyAny>>,
        kp: Option<Bound<'_, PyAny>>,
        kd: Option<Bound<'_, PyAny>>,
        mode: Option<Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let mut guard = self.lock(py)?;
        let count = guard.run.model().nj();
        let array = |value: Option<Bound<'_, PyAny>>, name: &str| {
            value.map(|value| numbers_of(&value, name, count)).transpose()
        };
        let given = Commanded {
            position: array(position, "position")?,
            velocity: array(velocity, "velocity")?,
            effort: array(effort, "effort")?,
            kp: array(kp, "kp")?,
            kd: array(kd, "kd")?,
            mode: mode.map(|names| modes(&names, count)).transpose()?,
        };
        guard.tick_always();
        *guard.commanded.lock().unwrap_or_else(PoisonError::into_inner) = given;
        Ok(())
    }

    /// The present state, for `restore`.
    fn save(&self, py: Python<'_>) -> PyResult<Checkpoint> {
        let mut guard = self.lock(py)?;
        guard.tick_always();
        let kept = match guard.run.has_begun() {
            true => {
                let kept = guard.run.checkpoint();
                Some(Mutex::new(kept.map_err(|error| of_run(py, &error, Some(guard.run.time())))?))
            }
            false => None,
        };
        let commanded = guard.commanded.lock().unwrap_or_else(PoisonError::into_inner).clone();
        Ok(Checkpoint {
            key: self.job.key.clone(),
            time: guard.run.time(),
            kept,
            commanded,
            end: guard.end.clone(),
            events: guard.recorder.events.clone(),
            functions: self.function_ids(),
        })
    }

    /// Returns to a saved state of this run, or of another simulation of the same run.
    fn restore(&self, py: Python<'_>, checkpoint: &Checkpoint) -> PyResult<()> {
        let mut guard = self.lock(py)?;
        if checkpoint.key != self.job.key {
            return Err(refused(py, "the state was saved from another run"));
        }
        if checkpoint.functions != self.function_ids() {
            return Err(refused(py, "the state was saved from a simulation with other Python functions"));
        }
        if guard.recorder.log.is_some() {
            return Err(refused(py, "the run writes a log, whose times cannot go back"));
        }
        guard.tick_always();
        match &checkpoint.kept {
            Some(kept) => {
                let kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
                let done = guard.run.return_to(&kept);
                done.map_err(|error| of_run(py, &error, Some(guard.run.time())))?;
            }
            None => {
                if !self.functions.is_empty() {
                    return Err(refused(py, "a state saved before the first step, of a run with Python functions"));
                }
                let built = setup_with(&self.job.run, &self.job.robot, &self.job.objects);
                let mut setup = built.map_err(|error| refused(py, &error.to_string()))?;
                setup.log_rate = 0.0;
                let cancel = guard.cancel.clone();
                guard.run = Run::new(setup).map_err(|error| of_run(py, &error, None))?;
                guard.run.cancel_on(cancel);
                guard.ticks = false;
                guard.tick_always();
            }
        }
        *guard.commanded.lock().unwrap_or_else(PoisonError::into_inner) = checkpoint.commanded.clone();
        guard.end = checkpoint.end.clone();
        guard.recorder.events.clone_from(&checkpoint.events);
        guard.cancel.store(false, Ordering::Relaxed);
        self.raised.take();
        Ok(())
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.functions.iter().try_for_each(|function| function.visit(&visit))
    }

    fn __clear__(&self) {
        self.functions.iter().for_each(Callable::clear);
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let guard = self.lock(py)?;
        Ok(format!("<Simulation {} {} at {} s>", self.job.run.name, self.job.key, guard.run.time()))
    }
}

impl Simulation {
    fn function_ids(&self) -> Vec<usize> {
        self.functions.iter().map(Callable::id).collect()
    }

    fn present(&self, py: Python<'_>) -> PyResult<Snapshot> {
        let mut guard = self.lock(py)?;
        let stepped = &mut *guard;
        Ok(py.detach(|| stepped.run.snapshot()))
    }
}

/// A mode for all joints, or one for each.
fn modes(names: &Bound<'_, PyAny>, count: usize) -> PyResult<Vec<DriveMode>> {
    if let Ok(name) = names.extract::<String>() {
        return Ok(vec![mode(&name)?; count]);
    }
    let names: Vec<String> = names.extract()?;
    if names.len() != count {
        return Err(PyValueError::new_err(format!("mode: found {} texts, expected {count}", names.len())));
    }
    names.iter().map(|name| mode(name)).collect()
}
