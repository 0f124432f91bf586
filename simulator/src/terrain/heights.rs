//! Heights of a height field, read from a file.

use super::{csv_heights, png_heights};
use std::ops::Range;

/// Greatest number of rows, and of columns.
pub const MAX_POINTS: usize = 4096;

/// Greatest size of a height, m.
const MAX_HEIGHT: f64 = 1e6;

/// A grid of heights.
#[derive(Clone, Debug, PartialEq)]
pub struct Heights {
    /// Number of rows, along y: at least 2.
    pub rows: usize,
    /// Number of columns, along x: at least 2.
    pub columns: usize,
    /// Heights, m, row by row; the first row is at the least y.
    pub values: Vec<f64>,
}

/// Why a file gives no heights.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct HeightsError {
    /// The bytes concerned, for a file of text.
    pub span: Option<Range<usize>>,
    /// What is wrong.
    pub message: String,
}

impl HeightsError {
    pub(super) fn new(message: impl Into<String>) -> Self {
        HeightsError { span: None, message: message.into() }
    }

    pub(super) fn at(span: Range<usize>, message: impl Into<String>) -> Self {
        HeightsError { span: Some(span), message: message.into() }
    }
}

impl Heights {
    /// Reads a table of numbers v; heights are `scale` v + `offset`.
    ///
    /// # Errors
    /// A cell that is not a finite number; rows of different lengths; fewer than two or more than
    /// [`MAX_POINTS`] rows or columns; a height beyond 1e6 m.
    pub fn from_csv(text: &str, scale: f64, offset: f64) -> Result<Self, HeightsError> {
        csv_heights::read(text)?.map_values(|v| scale * v + offset)
    }

    /// Takes rows of numbers v; heights are `scale` v + `offset`.
    ///
    /// # Errors
    /// As in [`Heights::from_csv`].
    pub fn from_rows(rows: &[Vec<f64>], scale: f64, offset: f64) -> Result<Self, HeightsError> {
        let columns = rows.first().map_or(0, Vec::len);
        if let Some((r, row)) = rows.iter().enumerate().find(|(_, row)| row.len() != columns) {
            let message = format!("row {} has {} heights, the first one has {columns}", r + 1, row.len());
            return Err(HeightsError::new(message));
        }
        check_size(rows.len(), columns)?;
        let heights = Heights { rows: rows.len(), columns, values: rows.concat() };
        heights.map_values(|v| scale * v + offset)
    }

    /// Reads a 16-bit greyscale PNG; black is at `low` and white at `high`, m.
    ///
    /// # Errors
    /// A file that is not such a PNG or is damaged; sizes and heights as in [`Heights::from_csv`].
    pub fn from_png(bytes: &[u8], low: f64, high: f64) -> Result<Self, HeightsError> {
        let white = f64::from(u16::MAX);
        png_heights::read(bytes)?.map_values(|v| low + (high - low) * (v / white))
    }

    fn map_values(mut self, f: impl Fn(f64) -> f64) -> Result<Self, HeightsError> {
        self.values.iter_mut().for_each(|v| *v = f(*v));
        match self.values.iter().position(|height| !(height.abs() <= MAX_HEIGHT)) {
            None => Ok(self),
            Some(k) => {
                let (row, column, height) = (k / self.columns + 1, k % self.columns + 1, self.values[k]);
                let message = format!("the height {height} m in row {row}, column {column} is beyond {MAX_HEIGHT} m");
                Err(HeightsError::new(message))
            }
        }
    }

    /// Heights of a row.
    pub fn row(&self, row: usize) -> &[f64] {
        &self.values[row * self.columns..(row + 1) * self.columns]
    }

    /// The height of a point.
    pub fn at(&self, row: usize, column: usize) -> f64 {
        self.values[row * self.columns + column]
    }
}

/// Checks the size of a grid.
pub(super) fn check_size(rows: usize, columns: usize) -> Result<(), HeightsError> {
    let fits = |n: usize| (2..=MAX_POINTS).contains(&n);
    if fits(rows) && fits(columns) {
        return Ok(());
    }
    let allowed = format!("from 2 to {MAX_POINTS} rows and columns are allowed");
    Err(HeightsError::new(format!("the grid has {rows} x {columns} heights (rows x columns); {allowed}")))
}

#[cfg(test)]
mod tests {
    use super::png_heights::tests::encode;
    use super::*;

    #[test]
    fn png_and_csv_give_the_same_grid() {
        let values = [0u16, 1, 257, 65535, 30000, 42];
        for filter in 0..5 {
            let png = Heights::from_png(&encode(3, 2, &values, filter), -1.0, 5.5535).unwrap();
            let csv = Heights::from_csv("0,1,257\n65535, 30000,42\n", 1e-4, -1.0).unwrap();
            assert_eq!((png.rows, png.columns), (2, 3));
            assert_eq!((csv.rows, csv.columns), (2, 3));
            for (a, b) in png.values.iter().zip(&csv.values) {
                assert!((a - b).abs() < 1e-12, "filter {filter}: {a} is not {b}");
            }
        }
    }

    #[test]
    fn heights_have_bounds() {
        let error = Heights::from_csv("0 1\n2 3", 1e6, 0.0).unwrap_err();
        assert_eq!(error.message, "the height 2000000 m in row 2, column 1 is beyond 1000000 m");
        let error = Heights::from_csv("0 1\n2 3", 1e308, 1e308).unwrap_err();
        assert!(error.message.contains("in row 1, column 1"), "{error}");
        let error = |rows: &[Vec<f64>]| Heights::from_rows(rows, 1.0, 0.0).unwrap_err().message;
        assert!(error(&[vec![0.0, 1.0], vec![f64::NAN, 1.0]]).contains("in row 2, column 1"));
        assert_eq!(error(&[vec![0.0, 1.0], vec![0.0]]), "row 2 has 1 heights, the first one has 2");
        assert!(error(&[vec![0.0], vec![0.0]]).starts_with("the grid has 2 x 1 heights"));
    }
}
