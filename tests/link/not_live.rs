//! Tests of a program built without the feature `live`.

use crate::cli::Place;

#[test]
fn the_error_states_the_build_command() {
    let place = Place::new();
    place.block("s.toml", "");
    for arguments in
        [&["s.toml", "--live"][..], &["motor-server", "s.toml", "--live=127.0.0.1:0"], &["console", "s.toml", "--live"]]
    {
        let done = place.runner(arguments).exits(2);
        assert!(done.stderr.contains("`cargo build --release --features live`"), "{}", done.stderr);
        assert!(!place.path("results").exists() && !place.path("results-robot").exists());
    }
}
