//! Many simulations, stepped in parallel.

use std::num::NonZero;
use std::sync::{MutexGuard, PoisonError};
use std::time::Instant;

use pyo3::exceptions::PyValueError;
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use rayon::ThreadPool;
use rayon::prelude::*;
use stiction::RunError;

use crate::arrays::{Shared, of_kind};
use crate::callables::check_finite;
use crate::errors::refused;
use crate::simulation::Simulation;
use crate::state::base_velocity;
use crate::stepped::{PATIENCE, Stepped};

/// m simulations of robots with n joints, stepped in parallel with the interpreter's lock released. The
/// arrays are allocated once; each step refreshes those of motion and reads those of commands.
#[pyclass(frozen, subclass, module = "stiction._native")]
pub struct Batch {
    /// The simulations.
    #[pyo3(get)]
    simulations: Vec<Py<Simulation>>,
    pool: ThreadPool,
    motion: Vec<(Quantity, Shared)>,
    commands: [Shared; 3],
    has_ended: Py<PyAny>,
    /// The process that has the threads.
    process: u32,
}

/// A quantity of motion with a row per simulation.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Quantity {
    Time,
    Q,
    Qd,
    Position,
    Orientation,
    LinearVelocity,
    AngularVelocity,
}

impl Quantity {
    /// All, with their numbers per simulation of n joints.
    fn all(n: usize) -> [(Quantity, usize); 7] {
        [
            (Quantity::Time, 1),
            (Quantity::Q, n),
            (Quantity::Qd, n),
            (Quantity::Position, 3),
            (Quantity::Orientation, 4),
            (Quantity::LinearVelocity, 3),
            (Quantity::AngularVelocity, 3),
        ]
    }

    /// Appends the values of a simulation.
    fn append(self, stepped: &Stepped, all: &mut Vec<f64>) {
        let state = stepped.run.state();
        match self {
            Quantity::Time => all.push(state.time),
            Quantity::Q => all.extend_from_slice(&state.joints),
            Quantity::Qd => all.extend_from_slice(state.rates()),
            Quantity::Position => all.extend_from_slice(state.position.as_slice()),
            Quantity::Orientation => all.extend_from_slice(state.rotation.coords.as_slice()),
            Quantity::LinearVelocity => all.extend_from_slice(&base_velocity(state)[..3]),
            Quantity::AngularVelocity => all.extend_from_slice(&base_velocity(state)[3..]),
        }
    }
}

#[pymethods]
impl Batch {
    /// Steps `simulations` on `jobs` threads, by default one per processor.
    #[new]
    #[pyo3(signature = (simulations, jobs=None))]
    fn new(py: Python<'_>, simulations: Vec<Py<Simulation>>, jobs: Option<usize>) -> PyResult<Self> {
        let default = std::thread::available_parallelism().map_or(1, NonZero::get);
        let jobs = jobs.unwrap_or(default);
        if jobs == 0 {
            return Err(PyValueError::new_err("jobs: found 0, expected a number of at least 1"));
        }
        let mut joints = None;
        for (i, simulation) in simulations.iter().enumerate() {
            if simulations[..i].iter().any(|other| other.is(simulation)) {
                return Err(PyValueError::new_err(format!("simulations: entry {i} is there twice")));
            }
            let mut guard = simulation.get().lock(py)?;
            guard.tick_always();
            let found = guard.run.model().nj();
            let expected = *joints.get_or_insert(found);
            if found != expected {
                let message = format!("simulations: entry {i} has {found} joints, the first has {expected}");
                return Err(PyValueError::new_err(message));
            }
        }
        let (m, n) = (simulations.len(), joints.unwrap_or(0));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs.min(m.max(1))).build();
        let shape = |quantity, columns| if quantity == Quantity::Time { vec![m] } else { vec![m, columns] };
        let motion = Quantity::all(n).into_iter().map(|(q, columns)| Ok((q, Shared::zeros(py, &shape(q, columns))?)));
        let commands = || Shared::zeros(py, &[m, n]);
        let batch = Batch {
            simulations,
            pool: pool.map_err(|error| refused(py, &error.to_string()))?,
            motion: motion.collect::<PyResult<_>>()?,
            commands: [commands()?, commands()?, commands()?],
            has_ended: of_kind(py, vec![false; m], "bool")?,
            process: std::process::id(),
        };
        batch.refresh(py)?;
        batch.read_commands(py)?;
        Ok(batch)
    }

    /// Without this, a task that refers to the batch of its simulation would keep both for ever.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.simulations.iter().try_for_each(|simulation| visit.call(simulation))
    }

    fn __len__(&self) -> usize {
        self.simulations.len()
    }

    /// Sends the commands and advances all by control ticks. Runs that have ended stay as they are; the
    /// first error is raised after all have been stepped.
    #[pyo3(signature = (ticks=1))]
    fn step(&self, py: Python<'_>, ticks: u64) -> PyResult<()> {
        let mut guards = self.lock_all(py)?;
        let n = guards.first().map_or(0, |guard| guard.run.model().nj());
        let mut given = [const { Vec::new() }; 3];
        if std::process::id() != self.process {
            return Err(refused(py, "the batch was made before this process was forked: make it again"));
        }
        for ((array, values), name) in self.commands.iter().zip(&mut given).zip(["position", "velocity", "effort"]) {
            values.resize(guards.len() * n, 0.0);
            array.read(py, values)?;
            values.chunks(n.max(1)).enumerate().try_for_each(|(i, row)| check_finite(&format!("{name}[{i}]"), row))?;
        }
        let [position, velocity, effort] = given;
        for (i, guard) in guards.iter().enumerate() {
            let mut commanded = guard.commanded.lock().unwrap_or_else(PoisonError::into_inner);
            let row = i * n..(i + 1) * n;
            set(&mut commanded.position, &position[row.clone()]);
            set(&mut commanded.velocity, &velocity[row.clone()]);
            set(&mut commanded.effort, &effort[row]);
        }
        let mut all: Vec<&mut Stepped> = guards.iter_mut().map(|guard| &mut **guard).collect();
        let mut errors: Vec<Option<(RunError, f64)>> = all.iter().map(|_| None).collect();
        let interruption = py.detach(|| {
            let (mut left, mut part) = (ticks, 1);
            loop {
                let (now, start) = (left.min(part), Instant::now());
                let step = |(stepped, error): (&mut &mut Stepped, &mut Option<(RunError, f64)>)| {
                    if stepped.end.is_none()
                        && let Err(found) = stepped.step(now, || false)
                    {
                        *error = Some((found, stepped.run.time()));
                    }
                };
                self.pool.install(|| all.par_iter_mut().zip(&mut errors).for_each(step));
                left -= now;
                if left == 0 {
                    return None;
                }
                // Parts that take about the time between two checks for signals.
                let share = PATIENCE.as_secs_f64() / start.elapsed().as_secs_f64().max(1e-6);
                part = (part as f64 * share.clamp(0.1, 10.0)).max(1.0) as u64;
                if let Err(error) = Python::attach(|py| py.check_signals()) {
                    return Some(error);
                }
            }
        });
        drop(all);
        drop(guards);
        self.refresh(py)?;
        // Of several exceptions one is raised; none is left for a later step.
        let mut first = None;
        for (simulation, error) in self.simulations.iter().zip(errors) {
            if let Some((error, time)) = error {
                let exception = simulation.get().exception(py, &error, time);
                first.get_or_insert(exception);
            }
            simulation.get().take_raised();
        }
        interruption.or(first).map_or(Ok(()), Err)
    }

    /// Reads the motion of all simulations again, for example after one was restored.
    fn refresh(&self, py: Python<'_>) -> PyResult<()> {
        let guards = self.lock_all(py)?;
        let mut all = Vec::new();
        for (quantity, array) in &self.motion {
            all.clear();
            guards.iter().for_each(|guard| quantity.append(guard, &mut all));
            array.write(py, &all)?;
        }
        let ended: Vec<bool> = guards.iter().map(|guard| guard.end.is_some()).collect();
        self.has_ended.bind(py).set_item(py.Ellipsis(), ended)
    }

    /// Simulated times, s, (m,).
    #[getter]
    fn time(&self, py: Python<'_>) -> Py<PyAny> {
        self.array(py, Quantity::Time)
    }

    /// Joint positions, rad or m, (m, n).
    #[getter]
    fn q(&self, py: Python<'_>) -> Py<PyAny> {
        self.array(py, Quantity::Q)
    }

    /// Joint velocities, rad/s or m/s, (m, n).
    #[getter]
    fn qd(&self, py: Python<'_>) -> Py<PyAny> {
        self.array(py, Quantity::Qd)
    }

    /// Origins of the root links, m, (m, 3).
    #[getter]
    fn base_position(&self, py: Python<'_>) -> Py<PyAny> {
        self.array(py, Quantity::Position)
    }

    /// Their orientations, quaternions x, y, z, w, (m, 4).
    #[getter]
    fn base_orientation(&self, py: Python<'_>) -> Py<PyAny> {
        self.array(py, Quantity::Orientation)
    }

    /// Velocities of their origins, m/s, (m, 3).
    #[getter]
    fn base_linear_velocity(&self, py: Python<'_>) -> Py<PyAny> {
        self.array(py, Quantity::LinearVelocity)
    }

    /// Their angular velocities, rad/s, (m, 3).
    #[getter]
    fn base_angular_velocity(&self, py: Python<'_>) -> Py<PyAny> {
        self.array(py, Quantity::AngularVelocity)
    }

    /// Whether each run has ended, (m,).
    #[getter]
    fn has_ended(&self, py: Python<'_>) -> Py<PyAny> {
        self.has_ended.clone_ref(py)
    }

    /// Desired joint positions, rad or m, (m, n), which the caller writes.
    #[getter]
    fn position(&self, py: Python<'_>) -> Py<PyAny> {
        self.commands[0].array(py)
    }

    /// Desired joint velocities, rad/s or m/s, (m, n), which the caller writes.
    #[getter]
    fn velocity(&self, py: Python<'_>) -> Py<PyAny> {
        self.commands[1].array(py)
    }

    /// Desired efforts in mode `force`, feed-forward efforts in the others, N m or N, (m, n), which the
    /// caller writes.
    #[getter]
    fn effort(&self, py: Python<'_>) -> Py<PyAny> {
        self.commands[2].array(py)
    }
}

impl Batch {
    fn lock_all(&self, py: Python<'_>) -> PyResult<Vec<MutexGuard<'_, Stepped>>> {
        self.simulations.iter().map(|simulation| simulation.get().lock(py)).collect()
    }

    fn array(&self, py: Python<'_>, quantity: Quantity) -> Py<PyAny> {
        let found = self.motion.iter().find(|(q, _)| *q == quantity);
        found.map_or_else(|| py.None(), |(_, shared)| shared.array(py))
    }

    /// Writes the commands of the caller so far, or those that hold, into the arrays.
    fn read_commands(&self, py: Python<'_>) -> PyResult<()> {
        let mut parts = [const { Vec::new() }; 3];
        for guard in self.lock_all(py)? {
            let (held, given) = (&guard.run.tasks().command, guard.commanded.lock());
            let given = given.unwrap_or_else(PoisonError::into_inner);
            let all =
                [(&given.position, &held.position), (&given.velocity, &held.velocity), (&given.effort, &held.effort)];
            for (part, (given, held)) in parts.iter_mut().zip(all) {
                part.extend_from_slice(given.as_ref().unwrap_or(held));
            }
        }
        self.commands.iter().zip(&parts).try_for_each(|(array, values)| array.write(py, values))
    }
}

/// Replaces values without allocating again.
fn set(values: &mut Option<Vec<f64>>, row: &[f64]) {
    match values {
        Some(values) => values.copy_from_slice(row),
        None => *values = Some(row.to_vec()),
    }
}
