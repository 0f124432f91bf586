//! Python functions as tasks and as external forces.

use std::sync::{Arc, Mutex, PoisonError};

use pyo3::exceptions::{PyAttributeError, PyValueError};
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyString};
use stiction::dynamics::jacobian::link_twist;
use stiction::force::ForceError;
use stiction::nalgebra::Vector3;
use stiction::robot::DriveMode;
use stiction::task::{Needs, TaskError};
use stiction::{AppliedForces, Command, Context, Force, ForceContext, LinkId, Model, Status, Task, TaskResult};

use crate::arrays::{Shared, array, numbers, shaped, vector, vectors};
use crate::state::State;

/// The exception of a function called during a step; the step raises it.
#[derive(Clone, Default)]
pub struct Raised(Arc<Mutex<Option<PyErr>>>);

impl Raised {
    fn set(&self, error: PyErr) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }

    /// Takes the exception out.
    pub fn take(&self) -> Option<PyErr> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    fn is_set(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }
}

/// A Python function that a task or force calls. The garbage collector clears it where only cycles refer to
/// its simulation.
#[derive(Clone)]
pub struct Callable(Arc<Mutex<Option<Py<PyAny>>>>);

impl Callable {
    /// Wraps a function.
    pub fn new(function: Py<PyAny>) -> Self {
        Callable(Arc::new(Mutex::new(Some(function))))
    }

    fn function(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let guard = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        guard.as_ref().map(|function| function.clone_ref(py)).ok_or_else(|| {
            pyo3::exceptions::PyRuntimeError::new_err("the simulation was removed by the garbage collector")
        })
    }

    /// Shows the function to the garbage collector.
    pub fn visit(&self, visit: &PyVisit<'_>) -> Result<(), PyTraverseError> {
        match self.0.try_lock() {
            Ok(guard) => guard.as_ref().map_or(Ok(()), |function| visit.call(function)),
            Err(_) => Ok(()),
        }
    }

    /// Drops the function.
    pub fn clear(&self) {
        let function = self.0.lock().unwrap_or_else(PoisonError::into_inner).take();
        drop(function);
    }

    /// Address that distinguishes functions.
    pub fn id(&self) -> usize {
        let guard = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        guard.as_ref().map_or(0, |function| function.as_ptr() as usize)
    }
}

/// Refuses numbers that are not finite. `name` is that of the array.
pub fn check_finite(name: &str, numbers: &[f64]) -> PyResult<()> {
    match numbers.iter().position(|x| !x.is_finite()) {
        Some(i) => Err(PyValueError::new_err(format!("{name}[{i}]: found {}, expected a finite number", numbers[i]))),
        None => Ok(()),
    }
}

/// Names of drive modes, as in robot files.
const MODES: [(&str, DriveMode); 5] = [
    ("position", DriveMode::Position),
    ("force", DriveMode::Force),
    ("velocity", DriveMode::Velocity),
    ("kinematic", DriveMode::Kinematic),
    ("passive", DriveMode::Passive),
];

/// The drive mode of that name.
pub fn mode(name: &str) -> PyResult<DriveMode> {
    let found = MODES.iter().find(|(n, _)| *n == name).map(|(_, mode)| *mode);
    let all = MODES.map(|(n, _)| n).join(", ");
    found.ok_or_else(|| PyValueError::new_err(format!("mode: found {name:?}, expected one of {all}")))
}

fn mode_name(mode: DriveMode) -> &'static str {
    MODES.iter().find(|(_, m)| *m == mode).map_or("passive", |(name, _)| name)
}

/// Numbers of an array or sequence, as many as `count`.
pub fn numbers_of(value: &Bound<'_, PyAny>, name: &str, count: usize) -> PyResult<Vec<f64>> {
    let found = numbers(value)?;
    if found.len() != count {
        let message = format!("{name}: found {} numbers, expected {count}", found.len());
        return Err(PyValueError::new_err(message));
    }
    check_finite(name, &found)?;
    Ok(found)
}

/// Joint commands that a task may write, n entries each; see [`Command`].
#[pyclass(frozen, module = "stiction._native")]
pub struct JointCommand {
    position: Shared,
    velocity: Shared,
    effort: Shared,
    kp: Shared,
    kd: Shared,
    /// Modes by joint, a list of n texts.
    #[pyo3(get)]
    mode: Py<PyList>,
    /// The texts that were written into it last, with their modes.
    written: Mutex<Vec<(DriveMode, Py<PyString>)>>,
}

#[pymethods]
impl JointCommand {
    /// Desired positions, rad or m, (n,).
    #[getter]
    fn position(&self, py: Python<'_>) -> Py<PyAny> {
        self.position.array(py)
    }

    /// Desired velocities, rad/s or m/s, (n,).
    #[getter]
    fn velocity(&self, py: Python<'_>) -> Py<PyAny> {
        self.velocity.array(py)
    }

    /// Desired efforts in mode `force`, feed-forward efforts in the others, N m or N, (n,).
    #[getter]
    fn effort(&self, py: Python<'_>) -> Py<PyAny> {
        self.effort.array(py)
    }

    /// Position gains, N m/rad or N/m, (n,).
    #[getter]
    fn kp(&self, py: Python<'_>) -> Py<PyAny> {
        self.kp.array(py)
    }

    /// Velocity gains, N m s/rad or N s/m, (n,).
    #[getter]
    fn kd(&self, py: Python<'_>) -> Py<PyAny> {
        self.kd.array(py)
    }
}

impl JointCommand {
    fn new(py: Python<'_>, command: &Command) -> PyResult<Self> {
        let zeros = || Shared::zeros(py, &[command.position.len()]);
        Ok(JointCommand {
            position: zeros()?,
            velocity: zeros()?,
            effort: zeros()?,
            kp: zeros()?,
            kd: zeros()?,
            mode: PyList::new(py, command.mode.iter().map(|_| ""))?.unbind(),
            written: Mutex::new(Vec::new()),
        })
    }

    /// Writes the values of a command into the arrays.
    fn fill(&self, py: Python<'_>, command: &Command) -> PyResult<()> {
        self.position.write(py, &command.position)?;
        self.velocity.write(py, &command.velocity)?;
        self.effort.write(py, &command.effort)?;
        self.kp.write(py, &command.kp)?;
        self.kd.write(py, &command.kd)?;
        let modes = self.mode.bind(py);
        let mut written = self.written.lock().unwrap_or_else(PoisonError::into_inner);
        for (j, mode) in command.mode.iter().enumerate() {
            if written.len() <= j {
                written.push((*mode, PyString::new(py, mode_name(*mode)).unbind()));
            } else if written[j].0 != *mode {
                written[j] = (*mode, PyString::new(py, mode_name(*mode)).unbind());
            }
            modes.set_item(j, &written[j].1)?;
        }
        Ok(())
    }

    /// Reads the values of the arrays into a command.
    fn read(&self, py: Python<'_>, command: &mut Command) -> PyResult<()> {
        self.position.read(py, &mut command.position)?;
        self.velocity.read(py, &mut command.velocity)?;
        self.effort.read(py, &mut command.effort)?;
        self.kp.read(py, &mut command.kp)?;
        self.kd.read(py, &mut command.kd)?;
        let all = [
            ("position", &command.position),
            ("velocity", &command.velocity),
            ("effort", &command.effort),
            ("kp", &command.kp),
            ("kd", &command.kd),
        ];
        all.iter().try_for_each(|(name, values)| check_finite(&format!("command.{name}"), values))?;
        let (modes, written) = (self.mode.bind(py), self.written.lock().unwrap_or_else(PoisonError::into_inner));
        for (j, entry) in command.mode.iter_mut().enumerate() {
            let text = modes.get_item(j)?;
            // The text that was written means that the mode is as it was.
            if !text.is(&written[j].1) {
                *entry = mode(&text.extract::<String>()?)?;
            }
        }
        Ok(())
    }
}

/// What a task reads at a control tick. Further attributes exist for the parts that the task needs.
#[pyclass(frozen, module = "stiction._native")]
pub struct TaskContext {
    /// Start of the task, s.
    #[pyo3(get)]
    start: f64,
    state: Py<State>,
    /// Parts by name.
    parts: Py<PyDict>,
}

#[pymethods]
impl TaskContext {
    fn __getattr__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        if let Some(part) = self.parts.bind(py).get_item(name)? {
            return Ok(part);
        }
        if PARTS.iter().any(|(part, _)| *part == name) {
            let message = format!("the task does not need {name:?}: name it in `needs`");
            return Err(PyAttributeError::new_err(message));
        }
        self.state
            .bind(py)
            .getattr(name)
            .map_err(|_| PyAttributeError::new_err(format!("the context of a task has no attribute {name:?}")))
    }

    fn __dir__(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        let own = self.state.bind(py).dir()?.extract::<Vec<String>>()?;
        let parts = self.parts.bind(py).keys().extract::<Vec<String>>()?;
        Ok(own.into_iter().chain(parts).chain(["start".to_owned()]).collect())
    }
}

/// Names of the parts of the data for tasks.
const PARTS: [(&str, Needs); 11] = [
    ("com", Needs::COM),
    ("com_velocity", Needs::COM),
    ("com_jacobian", Needs::COM_JACOBIAN),
    ("mass_matrix", Needs::MASS),
    ("bias", Needs::BIAS),
    ("gravity_effort", Needs::GRAVITY),
    ("sole_forces", Needs::LOADS),
    ("sole_moments", Needs::LOADS),
    ("zmp", Needs::ZMP),
    ("support_polygon", Needs::SUPPORT),
    ("link_poses", Needs::LINKS),
];

/// The needs with these names.
fn needs(names: &[String]) -> PyResult<Needs> {
    names.iter().try_fold(Needs::NONE, |all, name| {
        let found = PARTS.iter().find(|(part, _)| part == name).map(|(_, needs)| *needs);
        let known = PARTS.map(|(part, _)| part).join(", ");
        let wrong = || PyValueError::new_err(format!("needs: found {name:?}, expected names of {known}"));
        Ok(all | found.ok_or_else(wrong)?)
    })
}

fn part(py: Python<'_>, context: &Context<'_>, name: &str) -> PyResult<Py<PyAny>> {
    let (data, model) = (context.data, context.model);
    let nv = model.nv();
    match name {
        "com" => vector(py, &data.com),
        "com_velocity" => vector(py, &data.com_velocity),
        "com_jacobian" => {
            // Stored column by column.
            let by_rows: Vec<f64> = (0..3 * nv).map(|k| data.com_jacobian[k % nv * 3 + k / nv]).collect();
            shaped(py, &by_rows, &[3, nv])
        }
        "mass_matrix" => {
            let entries: Vec<f64> = (0..nv * nv).map(|k| data.workspace.mass.get(k / nv, k % nv)).collect();
            shaped(py, &entries, &[nv, nv])
        }
        "bias" => array(py, &data.workspace.bias),
        "gravity_effort" => array(py, &data.gravity_effort),
        "sole_forces" => vectors(py, context.sensed.soles.iter().map(|sole| &sole.force)),
        "sole_moments" => vectors(py, context.sensed.soles.iter().map(|sole| &sole.moment)),
        "zmp" => data.zmp.map_or(Ok(py.None()), |point| vector(py, &point)),
        "support_polygon" => vectors(py, &data.support_polygon),
        _ => {
            let poses = PyDict::new(py);
            for (i, link) in model.links.iter().enumerate() {
                let pose = data.link_pose(model, LinkId(i));
                let rotation = array(py, pose.rotation.coords.as_slice())?;
                poses.set_item(&link.name, (vector(py, &pose.translation.vector)?, rotation))?;
            }
            Ok(poses.into_any().unbind())
        }
    }
}

/// A Python function as a task: `function(context, command)`, called at each control tick.
pub struct PythonTask {
    name: String,
    function: Callable,
    names: Vec<String>,
    needs: Needs,
    command: Option<Py<JointCommand>>,
    raised: Raised,
}

impl PythonTask {
    /// A task that reads the named parts.
    pub fn new(name: String, function: Callable, names: Vec<String>, raised: Raised) -> PyResult<Self> {
        Ok(PythonTask { name, function, needs: needs(&names)?, names, command: None, raised })
    }

    fn call(&mut self, py: Python<'_>, context: &Context<'_>, command: &mut Command) -> PyResult<Status> {
        let parts = PyDict::new(py);
        for name in &self.names {
            parts.set_item(name, part(py, context, name)?)?;
        }
        let state = Py::new(py, State::new(context.state, &context.sensed.load))?;
        let seen = TaskContext { start: context.start, state, parts: parts.unbind() };
        let written = match &self.command {
            Some(written) => written.clone_ref(py),
            None => {
                let written = Py::new(py, JointCommand::new(py, command)?)?;
                self.command = Some(written.clone_ref(py));
                written
            }
        };
        written.get().fill(py, command)?;
        let answer = self.function.function(py)?.call1(py, (seen, written.clone_ref(py)))?;
        written.get().read(py, command)?;
        // Only `False` ends the task: functions without a return value continue.
        let ends = answer.bind(py).extract::<bool>().is_ok_and(|continues| !continues);
        Ok(if ends { Status::Done } else { Status::Running })
    }
}

impl Task for PythonTask {
    fn init(&mut self, _: &Context, _: &Command) -> TaskResult {
        Ok(Status::Running)
    }

    fn run(&mut self, context: &Context, command: &mut Command) -> TaskResult {
        Python::attach(|py| {
            self.call(py, context, command).map_err(|error| {
                let text = error.to_string();
                self.raised.set(error);
                TaskError::other(text)
            })
        })
    }

    fn has_memory(&self) -> bool {
        // Variables of the function belong to the caller.
        false
    }

    fn needs(&self) -> Needs {
        self.needs
    }

    fn name(&self) -> &str {
        &self.name
    }
}

/// A Python function as an external force on a point of a link: `function(time, position, velocity)`.
pub struct PythonForce {
    name: String,
    link: LinkId,
    /// The point in the link's internal frame, m.
    point: Vector3<f64>,
    function: Callable,
    corners: Vec<f64>,
    raised: Raised,
}

impl PythonForce {
    /// A force on the point of a link that is at `point` in its URDF frame, m.
    pub fn new(
        name: String,
        model: &Model,
        (link, point): (&str, [f64; 3]),
        function: Callable,
        corners: Vec<f64>,
        raised: Raised,
    ) -> PyResult<Self> {
        check_finite("point", &point)?;
        check_finite("corners", &corners)?;
        let found = model.link(link).ok_or_else(|| {
            let help = stiction::text::suggest(link, model.links.iter().map(|l| l.name.as_str()));
            PyValueError::new_err(format!("the robot has no link `{link}`; {help}"))
        })?;
        let point = (found.1 * stiction::nalgebra::Point3::from(point)).coords;
        Ok(PythonForce { name, link: found.0, point, function, corners, raised })
    }

    /// Force and moment, world axes.
    fn call(&self, py: Python<'_>, context: &ForceContext, point: &Vector3<f64>) -> PyResult<[Vector3<f64>; 2]> {
        let velocity = link_twist(context.kinematics, self.link, point).linear;
        // At a discontinuity both sides have the same time; the function tells them apart by it.
        let is_before = context.within < context.time && self.corners.contains(&context.time);
        let time = if is_before { context.time.next_down() } else { context.time };
        let answer = self.function.function(py)?.call1(py, (time, vector(py, point)?, vector(py, &velocity)?))?;
        let found = numbers(answer.bind(py))?;
        check_finite(&format!("force `{}`", self.name), &found)?;
        match found[..] {
            [x, y, z] => Ok([Vector3::new(x, y, z), Vector3::zeros()]),
            [x, y, z, a, b, c] => Ok([Vector3::new(x, y, z), Vector3::new(a, b, c)]),
            _ => {
                let expected = "expected a force of 3, or force and moment of 6";
                Err(PyValueError::new_err(format!("force `{}`: found {} numbers, {expected}", self.name, found.len())))
            }
        }
    }
}

impl Force for PythonForce {
    fn evaluate(&mut self, context: &ForceContext, applied: &mut AppliedForces) {
        if self.raised.is_set() {
            return;
        }
        let (rotation, origin) = context.frame(self.link);
        let point = origin + rotation * self.point;
        match Python::attach(|py| self.call(py, context, &point)) {
            Ok([force, moment]) => applied.wrench(context, self.link, &point, &force, &moment),
            Err(error) => self.raised.set(error),
        }
    }

    fn corners(&self) -> &[f64] {
        &self.corners
    }

    fn failure(&self) -> Option<ForceError> {
        let why = || format!("the function of force `{}` raised an exception", self.name);
        self.raised.is_set().then(|| ForceError::new(why()))
    }
}
