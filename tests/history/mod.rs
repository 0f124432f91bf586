//! The history of results: appended whole and once, compared with closed forms, judged by claims.

mod appends;
mod claims;
mod compared;
mod pages;

use std::fs::File;
use std::path::Path;

use polars::prelude::DataFrame;
use polars_io::SerReader;
use polars_io::parquet::read::ParquetReader;

use crate::cli::Place;

/// Columns of [`table`].
const HEADER: &str =
    "scenario,key,outcome,message,method,integrator,seed,mu,duration_s,wall_s,steps,final_base_x,max_penetration_m";

/// A run of scenario `s`: swept value, steps, position, wall-clock time.
pub struct Row<'a>(pub &'a str, pub u64, pub f64, pub f64);

/// Writes a summary by hand. Keys begin with `version`, as those of other versions differ.
pub fn table(place: &Place, name: &str, version: &str, rows: &[Row]) {
    let line = |Row(mu, steps, x, wall): &Row| {
        format!("s,{version}{mu},passed,,exact,dopri5,1,{mu},1.0,{wall:?},{steps},{x:?},\n")
    };
    place.write(name, format!("{HEADER}\n{}", rows.iter().map(line).collect::<String>()));
}

/// A history as another program reads it.
pub fn frame(path: &Path) -> DataFrame {
    ParquetReader::new(File::open(path).unwrap()).finish().unwrap()
}
