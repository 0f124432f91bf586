//! A table of typed columns of equal length, and its CSV and Parquet formats.

use polars::prelude::{Column, DataFrame, NamedFrom, PolarsResult, Series};
use polars_io::SerWriter;
use polars_io::csv::write::CsvWriter;
use polars_io::parquet::write::ParquetWriter;

/// The values of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Numbers; `None` where a number is absent, such as the centre of pressure in flight.
    Real(Vec<Option<f64>>),
    /// Texts.
    Text(Vec<String>),
    /// Flags.
    Flag(Vec<bool>),
}

/// A table of named columns of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DataTable {
    columns: Vec<(String, Values)>,
}

impl DataTable {
    pub(super) fn push(&mut self, name: impl Into<String>, values: Values) {
        self.columns.push((name.into(), values));
    }

    /// Names and values in order.
    pub fn columns(&self) -> &[(String, Values)] {
        &self.columns
    }

    /// The values of a column.
    pub fn column(&self, name: &str) -> Option<&Values> {
        self.columns.iter().find(|(n, _)| n == name).map(|(_, values)| values)
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, values)| match values {
            Values::Real(v) => v.len(),
            Values::Text(v) => v.len(),
            Values::Flag(v) => v.len(),
        })
    }

    /// The table as a data frame.
    ///
    /// # Errors
    /// Two columns have the same name.
    pub fn frame(&self) -> PolarsResult<DataFrame> {
        let series = |(name, values): &(String, Values)| {
            let name = name.as_str().into();
            Column::from(match values {
                Values::Real(v) => Series::new(name, v),
                Values::Text(v) => Series::new(name, v),
                Values::Flag(v) => Series::new(name, v),
            })
        };
        DataFrame::new(self.rows(), self.columns.iter().map(series).collect())
    }

    pub(super) fn write_csv(&self, out: &mut Vec<u8>) -> PolarsResult<()> {
        CsvWriter::new(out).finish(&mut self.frame()?)
    }

    pub(super) fn write_parquet(&self, out: &mut Vec<u8>) -> PolarsResult<()> {
        ParquetWriter::new(out).finish(&mut self.frame()?).map(|_| ())
    }
}
