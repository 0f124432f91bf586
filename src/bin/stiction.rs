//! `stiction`: the program `runner` under the name of the package.

#![forbid(unsafe_code)]

fn main() -> stiction::cli::Exit {
    stiction::cli::main()
}
