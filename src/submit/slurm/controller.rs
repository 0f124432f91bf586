//! What Slurm's controller is asked.

use std::process::Command;

use super::super::SubmitError;
use super::super::tool::{Answer, Tool, ended};
use super::NAME;

/// Does a controller answer, and does it take arrays of so many tasks?
pub(super) fn takes(parts: u64) -> Result<(), SubmitError> {
    let tool = tool("scontrol", &["show", "config"]);
    let answer = tool.run()?;
    let most = answer.stdout.lines().filter_map(|line| line.split_once('=')).find_map(|(name, value)| {
        // `MaxArraySize = 1001`: tasks are numbered below that.
        (name.trim() == "MaxArraySize").then(|| value.trim().parse::<u64>().ok()).flatten()
    });
    match most {
        _ if !answer.status.success() => Err(silent(&tool, &answer)),
        Some(most) if parts > most => {
            Err(SubmitError::TooMany { parts, most, engine: NAME, because: "MaxArraySize of its slurm.conf" })
        }
        // What does not say its limit tells it when it refuses.
        _ => Ok(()),
    }
}

/// Which of these jobs have not ended, with their states; empty when all have.
pub(super) fn alive(ids: &[String]) -> Result<String, SubmitError> {
    let jobs = format!("--jobs={}", ids.join(","));
    let tool = tool("squeue", &["--noheader", "--format=%F %T", &jobs]);
    let answer = tool.run()?;
    // It forgets jobs some minutes after their end.
    if !answer.status.success() && !answer.stderr.contains("Invalid job id") {
        return Err(silent(&tool, &answer));
    }
    let mut lines: Vec<String> = answer.stdout.lines().map(|line| line.trim().to_lowercase()).collect();
    lines.sort();
    lines.dedup();
    Ok(lines.join(", "))
}

/// Without what the environment would add: an array, or waiting, where none is meant.
pub(super) fn unswayed(mut command: Command) -> Command {
    for name in ["SBATCH_ARRAY_INX", "SBATCH_WAIT", "SBATCH_OUTPUT", "SBATCH_OPEN_MODE"] {
        command.env_remove(name);
    }
    command
}

fn tool(program: &'static str, words: &[&str]) -> Tool {
    Tool { engine: NAME, program, arguments: words.iter().map(|word| (*word).to_owned()).collect() }
}

fn silent(tool: &Tool, answer: &Answer) -> SubmitError {
    let said = if answer.stderr.is_empty() { &answer.stdout } else { &answer.stderr };
    SubmitError::Silent { engine: NAME, command: tool.typed(), status: ended(&answer.status), said: said.clone() }
}
