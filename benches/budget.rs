//! The performance budget, on one core. Compare figures only within one run: machines differ.
//!
//! `cargo bench --bench budget --profile release` (the release profile avoids a second
//! compilation).

use divan::{Bencher, black_box};
use std::path::Path;

mod collision;
mod dynamics;
mod objects;
mod ratios;
mod scripts;
mod standing;
mod stepping;
mod watched;

fn main() {
    divan::main();
    ratios::main();
}

/// Folder of robots and scenarios.
fn repository() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// Times `f` on one robot.
fn each<T>(bencher: Bencher, mut f: impl FnMut() -> T) {
    bencher.bench_local(|| black_box(f()));
}
