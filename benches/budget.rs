//! The performance budget, one core. Compare figures of one run with each other: machines differ.
//!
//! `cargo bench --bench budget --profile release` (the release profile, so that nothing is compiled
//! twice).

use divan::{Bencher, black_box};

mod collision;
mod dynamics;
mod scripts;
mod stepping;
mod watched;

fn main() {
    divan::main();
}

/// Times `f` on one robot.
fn each<T>(bencher: Bencher, mut f: impl FnMut() -> T) {
    bencher.bench_local(|| black_box(f()));
}
