//! `runner`: simulates scenarios of legged-robot contact and writes logs, verdicts and a summary.

#![forbid(unsafe_code)]

fn main() -> stiction::cli::Exit {
    stiction::cli::main()
}
