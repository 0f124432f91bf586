//! Heightmaps of SDFormat: pictures whose values are heights.
//!
//! Gazebo's reader gives the greatest value of the picture the height `|size.z|`, black the height
//! 0, and the first line the greatest y. Of coloured pictures it reads red.

use std::path::Path;

use crate::input::{self, png};
use crate::sdf::Heights;
use nalgebra::Vector3;

/// Reads a picture; `size` is that of the field along x, y and z, m. An error is the reason why it
/// is left out.
pub(super) fn read(path: &Path, size: &Vector3<f64>) -> Result<Heights, String> {
    if !(size.min() > 0.0) {
        return Err(format!("its size {:?} is not above 0", size.as_slice()));
    }
    let bytes = input::read(path, input::MOST_DATA).map_err(|e| format!("cannot read {}: {e}", path.display()))?;
    let read = || -> Result<Heights, String> {
        let png = png::read(&bytes)?;
        let (columns, rows) = (png.columns as usize, png.rows as usize);
        Heights::check_size(rows, columns)?;
        let (values, _) = png.values()?;
        let greatest = values.iter().copied().max().unwrap_or(0).max(1);
        let height = |value: &u16| size.z * f64::from(*value) / f64::from(greatest);
        let rows = values.chunks(columns).rev().map(|row| row.iter().map(height).collect());
        Ok(Heights { rows: rows.collect(), size: [size.x, size.y] })
    };
    read().map_err(|reason| format!("{}: {reason}", path.display()))
}
