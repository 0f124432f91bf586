//! Fits: parameters recovered from the program's own data, intervals that cover the truth as often as
//! they state, directions that no data determine, and errors of fit files.

mod blind;
mod broken;
mod command;
mod coverage;
mod recovery;

use std::fmt::Write;
use std::path::{Path, PathBuf};

use stiction::fit::{Fit, FitFile};
use stiction::random::Stream;

/// A temporary folder with a scenario, tables and fit files.
struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        Bench { folder: tempfile::tempdir().unwrap() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, text: &str) -> &Self {
        std::fs::write(self.path(name), text).unwrap();
        self
    }

    /// A table of zeros at `count` instants, to be filled.
    fn grid(&self, name: &str, columns: &[&str], rate: f64, count: usize) -> &Self {
        let mut text = format!("time_s,{}\n", columns.join(","));
        for k in 0..count {
            writeln!(text, "{}{}", k as f64 / rate, ",0".repeat(columns.len())).unwrap();
        }
        self.write(name, &text)
    }

    /// Loads a fit file with this text.
    fn fit(&self, text: &str) -> Fit {
        let file = FitFile::parse(&self.path("test.toml"), text).unwrap_or_else(|errors| panic!("{errors}"));
        Fit::of_file(file).unwrap_or_else(|findings| {
            panic!("{}", findings.iter().map(|finding| finding.render(false)).collect::<Vec<_>>().join("\n"))
        })
    }
}

/// A path of the repository.
fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Replaces the data by those of the parameters `truth`.
fn fill(fit: &mut Fit, truth: &[f64]) {
    let simulated = fit.simulated(truth).unwrap();
    fit.experiments.iter_mut().zip(simulated).for_each(|(experiment, recording)| experiment.recording = recording);
}

/// Adds normal noise of the standard deviations of the signals.
fn add_noise(fit: &mut Fit, sigma: &[f64], seed: u64) {
    for (e, experiment) in fit.experiments.iter_mut().enumerate() {
        for (c, channel) in experiment.recording.channels.iter_mut().enumerate() {
            let mut stream = Stream::new(seed, &["fit", &e.to_string(), &c.to_string()]);
            channel.values.iter_mut().for_each(|value| *value += sigma[channel.signal] * stream.normal());
        }
    }
}
