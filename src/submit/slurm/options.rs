//! What can be chosen about the jobs.

use std::num::NonZero;

use super::super::{SubmitError, text};

/// What is asked of Slurm for each job; what is not said is for the cluster to decide.
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

/// Options that say what is said already, and who says it.
const TAKEN: [(&[&str], &str); 4] = [
    (&["--array", "-a"], "--parts says how many tasks there are"),
    (
        &["--dependency", "-d", "--parsable", "--wait", "-W", "--test-only", "--wrap"],
        "it is given where the jobs are submitted",
    ),
    (&["--chdir", "-D", "--output", "-o", "--open-mode"], "-o says which folder the jobs work in"),
    (&["--clusters", "-M"], "the array and its merge are submitted to the cluster at hand; see SLURM_CONF"),
];

impl Options {
    /// Can all of them stand in a script?
    pub(super) fn check(&self) -> Result<(), SubmitError> {
        for option in &self.more {
            text::line("an option of --sbatch", option)?;
            if !option.starts_with('-') {
                let word = option.clone();
                return Err(SubmitError::Word { what: "--sbatch", why: "no hyphen before it", word });
            }
            for word in option.split_whitespace() {
                let name = word.split_once('=').map_or(word, |(name, _)| name);
                if let Some((_, why)) = TAKEN.iter().find(|(names, _)| names.iter().any(|taken| is(name, taken))) {
                    return Err(SubmitError::Taken { option: option.clone(), why });
                }
            }
        }
        Ok(())
    }
}

/// Is it this option, or would Slurm take it for that? It takes the beginning of a long one for the whole, and a short one may have its
/// value behind it.
fn is(word: &str, option: &str) -> bool {
    word == option
        || word.len() > 2 && option.starts_with("--") && option.starts_with(word)
        || !option.starts_with("--") && !word.starts_with("--") && word.starts_with(option)
}
