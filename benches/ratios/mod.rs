//! Tables of ratios: each case is timed in turn, several times, so that a change of the machine's speed meets all of
//! them. They are printed as Markdown.
//!
//! `stiff_drives` and `logs` run with all benches or by name. `scaling` runs by name alone: it takes minutes and two cores.

mod interleaved;
mod logs;
mod scaling;
mod stiff_drives;

/// Prints the tables that the command line selects.
pub fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let is_named = |name: &str| arguments.iter().any(|argument| argument == name);
    if arguments.is_empty() || is_named("stiff_drives") {
        stiff_drives::print();
    }
    if arguments.is_empty() || is_named("logs") {
        logs::print();
    }
    if is_named("scaling") {
        scaling::print();
    } else if arguments.is_empty() {
        println!("\nscaling: skipped, since it takes minutes; run it with `-- scaling`");
    }
}
