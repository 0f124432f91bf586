//! Options of the jobs, checked against those that this program sets itself.

use std::num::NonZero;

use super::super::{SubmitError, quoting};

/// Resources of each job; the cluster's defaults apply to those not given.
#[derive(Clone, Debug)]
pub struct Options {
    /// Processors of each part.
    pub cpus: NonZero<u32>,
    /// Time limit.
    pub time: Option<String>,
    /// Partition.
    pub partition: Option<String>,
    /// Account.
    pub account: Option<String>,
    /// Memory of each job.
    pub mem: Option<String>,
    /// Options as they would follow `#SBATCH`.
    pub more: Vec<String>,
}

/// Options that this program sets itself, and what sets them.
const RESERVED: [(&[&str], &str); 4] = [
    (&["--array", "-a"], "--parts sets the number of tasks"),
    (&["--dependency", "-d", "--parsable", "--wait", "-W", "--test-only", "--wrap"], "runner submit sets it"),
    (&["--chdir", "-D", "--output", "-o", "--open-mode"], "-o sets the folder of the jobs"),
    (&["--clusters", "-M"], "the array and its merge are submitted to the cluster at hand; see SLURM_CONF"),
];

impl Options {
    /// Checks that all options can be written into a script.
    pub(super) fn check(&self) -> Result<(), SubmitError> {
        for option in &self.more {
            quoting::line("an option of --sbatch", option)?;
            if !option.starts_with('-') {
                let text = option.clone();
                return Err(SubmitError::Text { what: "--sbatch", why: "no hyphen before it", text });
            }
            for word in option.split_whitespace() {
                let name = word.split_once('=').map_or(word, |(name, _)| name);
                if let Some((_, why)) =
                    RESERVED.iter().find(|(names, _)| names.iter().any(|reserved| matches(name, reserved)))
                {
                    return Err(SubmitError::Reserved { option: option.clone(), why });
                }
            }
        }
        Ok(())
    }
}

/// True if Slurm reads a word as this option. It accepts prefixes of long options, and short ones
/// with their value attached.
fn matches(word: &str, option: &str) -> bool {
    word == option
        || word.len() > 2 && option.starts_with("--") && option.starts_with(word)
        || !option.starts_with("--") && !word.starts_with("--") && word.starts_with(option)
}
