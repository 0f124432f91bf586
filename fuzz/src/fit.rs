//! Fit files among the repository's, and data that one of them names; the first byte selects the kind.

use stiction::fit::{Fit, FitFile};

use super::{scenario, scratch, tree};

/// A fit of two signals to the file `DATA`.
const TO_DATA: &str = r#"
scenario = "base/cart.toml"
data = [{ file = "DATA" }]
parameter = [{ key = "floor.friction.kinetic", start = 0.3, min = 0.05, max = 0.5 }]
signal = [{ column = "base_x_m", sigma = 0.001 }, { column = "joint.swing.position_rad", sigma = 0.002 }]
"#;

/// Reads a fit file (`f`), a table (`t`) or a log (`l`) up to the start of the first run.
pub fn take(data: &[u8]) {
    is_valid(data);
}

/// The same; returns whether it is valid.
pub fn is_valid(data: &[u8]) -> bool {
    match data.split_first() {
        Some((b'f', bytes)) => std::str::from_utf8(bytes).is_ok_and(load),
        Some((b't', bytes)) => with_data("measured.csv", bytes),
        Some((b'l', bytes)) => with_data("measured.mcap", bytes),
        _ => false,
    }
}

fn with_data(name: &str, bytes: &[u8]) -> bool {
    let file = scratch::folder("fit").join(name);
    scratch::write(&file, bytes);
    load(&TO_DATA.replace("DATA", file.to_str().expect("UTF-8")))
}

fn load(text: &str) -> bool {
    let path = tree::root().join("scenarios/fits/fuzzed.toml");
    let file = match FitFile::parse(&path, text) {
        Ok(file) => file,
        Err(wrong) => {
            scenario::show(&wrong);
            return false;
        }
    };
    match Fit::of_file(file) {
        Ok(fit) => {
            let starts: Vec<f64> = fit.parameters.iter().map(|parameter| parameter.start).collect();
            assert!(fit.key_values(&starts).len() >= starts.len());
            for parameter in &fit.parameters {
                let (least, greatest) = parameter.bounds;
                assert!(least <= parameter.start && parameter.start <= greatest, "a start out of bounds");
                assert!(parameter.scaled(parameter.start).is_finite());
            }
            true
        }
        Err(findings) => {
            findings.iter().for_each(|finding| drop(finding.render(true)));
            false
        }
    }
}
