//! Tables: summaries, time series and events, as columns and as Arrow streams.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use polars::prelude::{
    BooleanChunked, CompatLevel, DataFrame, DataType, Float64Type, Int64Type, SchemaExt, StringChunked,
};
use polars_arrow::array::{Array, StructArray};
use polars_arrow::datatypes::{ArrowDataType, Field};
use polars_arrow::ffi::export_iterator;
use polars_io::SerReader;
use polars_io::parquet::read::ParquetReader;
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use stiction::export::{self, Selection};
use stiction::files::names;
use stiction::log::Trajectory;
use stiction::report::{Pictured, rewrite_results};
use stiction::results::{ResultsLock, list_records};

use crate::arrays::{array, of_kind};
use crate::errors::{check_fork, of_log, of_results};

/// A table of named columns of equal length.
#[pyclass(frozen, subclass, module = "stiction._native")]
pub struct Table {
    frame: DataFrame,
}

#[pymethods]
impl Table {
    /// Names of the columns.
    #[getter]
    fn column_names(&self) -> Vec<String> {
        self.frame.get_column_names().into_iter().map(|name| name.to_string()).collect()
    }

    /// Number of rows.
    #[getter]
    fn rows(&self) -> usize {
        self.frame.height()
    }

    fn __len__(&self) -> usize {
        self.frame.height()
    }

    /// A column: numbers and flags as an array, missing numbers as NaN; others as a list.
    fn column(&self, py: Python<'_>, name: &str) -> PyResult<Py<PyAny>> {
        let column = self.frame.column(name).map_err(|_| PyKeyError::new_err(name.to_owned()))?;
        let polars = |error: polars::error::PolarsError| of_results(py, error);
        match column.dtype() {
            DataType::Boolean if column.null_count() == 0 => {
                let flags: &BooleanChunked = column.bool().map_err(polars)?;
                of_kind(py, flags.iter().map(Option::unwrap_or_default).collect::<Vec<_>>(), "bool")
            }
            DataType::Boolean => {
                let flags: Vec<Option<bool>> = column.bool().map_err(polars)?.iter().collect();
                Ok(flags.into_pyobject(py)?.into_any().unbind())
            }
            DataType::String => {
                let texts: &StringChunked = column.str().map_err(polars)?;
                Ok(texts.iter().collect::<Vec<Option<&str>>>().into_pyobject(py)?.into_any().unbind())
            }
            kind if kind.is_integer() && column.null_count() == 0 => {
                let column = column.cast(&DataType::Int64).map_err(polars)?;
                let numbers = column.as_materialized_series().unpack::<Int64Type>().map_err(polars)?;
                of_kind(py, numbers.iter().map(Option::unwrap_or_default).collect::<Vec<i64>>(), "int64")
            }
            _ => {
                let column = column.cast(&DataType::Float64).map_err(polars)?;
                let numbers = column.as_materialized_series().unpack::<Float64Type>().map_err(polars)?;
                array(py, &numbers.iter().map(|x| x.unwrap_or(f64::NAN)).collect::<Vec<_>>())
            }
        }
    }

    /// The table as a stream of the Arrow C data interface.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // Other types may be requested; consumers must accept those that there are.
        let _ = requested_schema;
        let level = CompatLevel::oldest();
        let fields: Vec<Field> = self.frame.schema().iter_fields().map(|field| field.to_arrow(level)).collect();
        let kind = ArrowDataType::Struct(fields);
        let mut frame = self.frame.clone();
        frame.rechunk_mut();
        let chunks: Vec<Box<dyn Array>> = frame
            .iter_chunks(level, false)
            .map(|chunk| StructArray::new(kind.clone(), chunk.len(), chunk.into_arrays(), None).boxed())
            .collect();
        let stream = export_iterator(Box::new(chunks.into_iter().map(Ok)), Field::new("".into(), kind, false));
        PyCapsule::new_with_value(py, stream, c"arrow_array_stream")
    }
}

/// The summary in a folder of results.
#[pyfunction]
pub fn summary(py: Python<'_>, folder: PathBuf) -> PyResult<Table> {
    check_fork(py)?;
    let path = folder.join(names::SUMMARY_PARQUET);
    let read = py.detach(|| {
        // In memory: a program that shortens a mapped file would end this one.
        let bytes = std::fs::read(&path).map_err(|error| error.to_string())?;
        ParquetReader::new(Cursor::new(bytes)).finish().map_err(|error| error.to_string())
    });
    let frame = read.map_err(|error| of_results(py, format!("{}: {error}", path.display())))?;
    Ok(Table { frame })
}

fn trajectory(py: Python<'_>, log: &Path) -> PyResult<Trajectory> {
    py.detach(|| Trajectory::read(log)).map_err(|error| of_log(py, error))
}

/// Names of the columns of a log's time series.
#[pyfunction]
pub fn columns(py: Python<'_>, log: PathBuf) -> PyResult<Vec<String>> {
    Ok(export::column_names(&trajectory(py, &log)?))
}

/// Time series of a log, as `runner export` writes them.
#[pyfunction]
#[pyo3(signature = (log, columns, rate=None, start=None, end=None))]
pub fn series(
    py: Python<'_>,
    log: PathBuf,
    columns: Vec<String>,
    rate: Option<f64>,
    start: Option<f64>,
    end: Option<f64>,
) -> PyResult<Table> {
    if let Some(rate) = rate.filter(|rate| !(rate.is_finite() && *rate > 0.0)) {
        return Err(PyValueError::new_err(format!("rate: found {rate}, expected a number above 0, Hz")));
    }
    for (name, time) in [("start", start), ("end", end)] {
        if let Some(time) = time.filter(|time| !time.is_finite()) {
            return Err(PyValueError::new_err(format!("{name}: found {time}, expected a finite time, s")));
        }
    }
    let log = trajectory(py, &log)?;
    let selection = Selection { columns, rate, from: start, to: end };
    let made = py.detach(|| export::series(&log, &selection)).map_err(|error| of_log(py, error))?;
    Ok(Table { frame: made.frame().map_err(|error| of_log(py, error))? })
}

/// Events of a log.
#[pyfunction]
pub fn events(py: Python<'_>, log: PathBuf) -> PyResult<Table> {
    let made = export::events(&trajectory(py, &log)?, &Selection::default());
    Ok(Table { frame: made.frame().map_err(|error| of_log(py, error))? })
}

/// Writes summary and report of a folder again from its records; returns the path of the report.
#[pyfunction]
pub fn report(py: Python<'_>, folder: PathBuf) -> PyResult<PathBuf> {
    check_fork(py)?;
    let page = folder.join(names::REPORT);
    let written = py.detach(|| {
        let _lock = ResultsLock::alone(&folder)?;
        let listing = list_records(&folder)?;
        match listing.runs() {
            0 => Ok(None),
            _ => rewrite_results(&folder, &listing, &[], (&page, &Pictured::Few, None)).map(Some),
        }
    });
    match written {
        Ok(Some(_)) => Ok(page),
        Ok(None) => Err(of_results(py, format!("no record of a run below {}", folder.display()))),
        Err(error) => Err(of_results(py, error)),
    }
}
