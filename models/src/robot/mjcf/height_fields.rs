//! Height fields of `<asset>`: heights in metres.
//!
//! MuJoCo scales the data to 0 to 1, and these to the third number of `size`. The first row of
//! `elevation`, and the first line of a picture, is at the greatest y; the first row of a binary
//! file is at the least. Of a picture the red values count, with 8 bits.

use std::path::{Path, PathBuf};

use super::compiler::Compiler;
use super::document::{Document, Id};
use super::view::View;
use crate::input::{self, png};
use crate::robot::robot_error::RobotError;
use crate::sdf::{Heights, MAX_HEIGHTS};

/// Reads height fields of a file in `folder`.
pub(super) struct HeightFields<'a> {
    document: &'a Document,
    compiler: &'a Compiler,
    folder: PathBuf,
}

impl<'a> HeightFields<'a> {
    pub fn new(document: &'a Document, compiler: &'a Compiler, folder: &Path) -> Self {
        Self { document, compiler, folder: folder.join(&compiler.mesh_folder) }
    }

    /// The heights that a geom names, or why its file cannot be read.
    ///
    /// # Errors
    /// No height field of that name; values that are not valid.
    pub fn get(&self, geom: &View) -> Result<Result<Heights, String>, RobotError> {
        let name = geom.required("hfield")?;
        let assets = self.document.assets("hfield");
        let Some(&id) = assets.iter().find(|&&id| self.name(id) == Some(name)) else {
            let fault = geom.fault("hfield", "the name of an <hfield> in <asset>");
            return Err(fault.suggest(name, assets.iter().filter_map(|&id| self.name(id))).invalid());
        };
        let view = View::bare(self.document, id);
        let Some([x, y, z, base]) = view.array::<4>("size")? else { return Err(view.missing("size")) };
        if ![x, y, z, base].iter().all(|size| *size > 0.0) {
            return Err(view.fault("size", "4 numbers above 0").invalid());
        }
        let rows = match view.text("file") {
            Some(file) => match self.file(Path::new(file)) {
                Ok(rows) => rows,
                Err(reason) => return Ok(Err(reason)),
            },
            None => written(&view)?,
        };
        let values = || rows.iter().flatten().copied();
        let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
        let span = if high > low { high - low } else { f64::INFINITY };
        let scaled = |row: &Vec<f64>| row.iter().map(|value| z * ((value - low) / span)).collect();
        Ok(Ok(Heights { rows: rows.iter().map(scaled).collect(), size: [2.0 * x, 2.0 * y] }))
    }

    fn name(&self, id: Id) -> Option<&'a str> {
        let stem = |file: &'a str| Path::new(file).file_stem()?.to_str();
        let own = self.document.text(id, "name").filter(|name| !name.is_empty());
        own.or_else(|| self.document.text(id, "file").and_then(stem))
    }

    /// Rows of a file, the first one at the least y.
    fn file(&self, file: &Path) -> Result<Vec<Vec<f64>>, String> {
        let name = if self.compiler.strip_path { file.file_name().map_or(file, Path::new) } else { file };
        let path = self.folder.join(name);
        let bytes = input::read(&path, input::MOST_DATA);
        let bytes = bytes.map_err(|error| format!("cannot read {}: {error}", path.display()))?;
        let is_picture = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
        let rows = if is_picture { picture(&bytes) } else { binary(&bytes) };
        rows.map_err(|reason| format!("{}: {reason}", path.display()))
    }
}

/// Rows of `elevation`, or of zeros.
fn written(view: &View) -> Result<Vec<Vec<f64>>, RobotError> {
    let count = |key| -> Result<usize, RobotError> {
        let number = view.number(key)?.ok_or_else(|| view.missing(key))?;
        let is_count = number.fract() == 0.0 && (2.0..=MAX_HEIGHTS as f64).contains(&number);
        if is_count { Ok(number as usize) } else { Err(view.fault(key, "a whole number, at least 2").invalid()) }
    };
    let (rows, columns) = (count("nrow")?, count("ncol")?);
    Heights::check_size(rows, columns).map_err(|why| view.fault("nrow", why).invalid())?;
    let number = rows * columns;
    let values = view.list("elevation", number, number)?.unwrap_or_else(|| vec![0.0; number]);
    Ok(values.chunks(columns).rev().map(<[f64]>::to_vec).collect())
}

fn picture(bytes: &[u8]) -> Result<Vec<Vec<f64>>, String> {
    let png = png::read(bytes)?;
    let (rows, columns) = (png.rows as usize, png.columns as usize);
    Heights::check_size(rows, columns)?;
    let (values, greatest) = png.values()?;
    let shift = if greatest > 255 { 8 } else { 0 };
    let row = |row: &[u16]| row.iter().map(|value| f64::from(value >> shift)).collect();
    Ok(values.chunks(columns).rev().map(row).collect())
}

/// MuJoCo's own format: two 32-bit numbers of rows and columns, then 32-bit floats.
fn binary(bytes: &[u8]) -> Result<Vec<Vec<f64>>, String> {
    let words: Vec<[u8; 4]> = bytes.chunks_exact(4).filter_map(|word| word.try_into().ok()).collect();
    let [rows, columns, values @ ..] = &words[..] else { return Err("it has no numbers of rows and columns".into()) };
    let count = |word: &[u8; 4]| usize::try_from(i32::from_le_bytes(*word)).unwrap_or(0);
    let (rows, columns) = (count(rows), count(columns));
    Heights::check_size(rows, columns)?;
    let values: Vec<f64> = values.iter().map(|word| f64::from(f32::from_le_bytes(*word))).collect();
    if values.len() != rows * columns || values.iter().any(|value| !value.is_finite()) {
        return Err(format!("it must have {} finite heights after the numbers of rows and columns", rows * columns));
    }
    Ok(values.chunks(columns).map(<[f64]>::to_vec).collect())
}
