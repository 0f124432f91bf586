//! NumPy arrays, through the buffer protocol.

use pyo3::buffer::PyBuffer;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;
use stiction::nalgebra::Vector3;

fn numpy<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    static MODULE: PyOnceLock<Py<PyModule>> = PyOnceLock::new();
    let module = MODULE.get_or_try_init(py, || py.import("numpy").map(Bound::unbind))?;
    module.bind(py).getattr(name)
}

/// An array of numbers of 64 bits that Python code shares.
pub struct Shared {
    array: Py<PyAny>,
    buffer: PyBuffer<f64>,
}

impl Shared {
    /// An array of zeros.
    pub fn zeros(py: Python<'_>, shape: &[usize]) -> PyResult<Self> {
        let array = numpy(py, "zeros")?.call1((shape.to_vec(),))?;
        Ok(Shared { buffer: PyBuffer::get(&array)?, array: array.unbind() })
    }

    /// The array.
    pub fn array(&self, py: Python<'_>) -> Py<PyAny> {
        self.array.clone_ref(py)
    }

    /// Writes all numbers, by rows.
    pub fn write(&self, py: Python<'_>, numbers: &[f64]) -> PyResult<()> {
        self.buffer.copy_from_slice(py, numbers)
    }

    /// Reads all numbers, by rows.
    pub fn read(&self, py: Python<'_>, numbers: &mut [f64]) -> PyResult<()> {
        self.buffer.copy_to_slice(py, numbers)
    }
}

/// An array of shape (n,).
pub fn array(py: Python<'_>, numbers: &[f64]) -> PyResult<Py<PyAny>> {
    shaped(py, numbers, &[numbers.len()])
}

/// An array of this shape, from numbers by rows.
pub fn shaped(py: Python<'_>, numbers: &[f64], shape: &[usize]) -> PyResult<Py<PyAny>> {
    let made = Shared::zeros(py, shape)?;
    made.write(py, numbers)?;
    Ok(made.array)
}

/// A vector as an array of shape (3,).
pub fn vector(py: Python<'_>, v: &Vector3<f64>) -> PyResult<Py<PyAny>> {
    array(py, v.as_slice())
}

/// Vectors as an array of shape (n, 3).
pub fn vectors<'a>(py: Python<'_>, all: impl IntoIterator<Item = &'a Vector3<f64>>) -> PyResult<Py<PyAny>> {
    let numbers: Vec<f64> = all.into_iter().flat_map(|v| [v.x, v.y, v.z]).collect();
    shaped(py, &numbers, &[numbers.len() / 3, 3])
}

/// Values of another kind as an array: flags (`bool`) or whole numbers (`int64`).
pub fn of_kind<'py>(py: Python<'py>, values: impl IntoPyObject<'py>, kind: &'static str) -> PyResult<Py<PyAny>> {
    let options = PyDict::new(py);
    options.set_item("dtype", kind)?;
    numpy(py, "array")?.call((values,), Some(&options)).map(Bound::unbind)
}

/// Numbers of an array or sequence.
pub fn numbers(value: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let py = value.py();
    let converted = numpy(py, "ascontiguousarray")?.call1((value, "float64"))?;
    PyBuffer::<f64>::get(&converted)?.to_vec(py)
}
