//! Queries Slurm's controller.

use std::process::Command;

use super::super::SubmitError;
use super::super::engine_command::{CommandOutput, EngineCommand, status_text};
use super::NAME;

/// Checks that a controller answers and accepts arrays of this size.
pub(super) fn check_array_size(parts: u64) -> Result<(), SubmitError> {
    let command = command("scontrol", &["show", "config"]);
    let output = command.run()?;
    let most = output.stdout.lines().filter_map(|line| line.split_once('=')).find_map(|(name, value)| {
        // Indices of tasks are below `MaxArraySize`.
        (name.trim() == "MaxArraySize").then(|| value.trim().parse::<u64>().ok()).flatten()
    });
    match most {
        _ if !output.status.success() => Err(no_answer(&command, &output)),
        Some(most) if parts > most => {
            Err(SubmitError::ArrayTooLarge { parts, most, engine: NAME, because: "MaxArraySize of its slurm.conf" })
        }
        // Without a stated limit, sbatch itself rejects an array that is too large.
        _ => Ok(()),
    }
}

/// Lists these jobs that have not ended, with their states; empty if all have.
pub(super) fn unfinished(ids: &[String]) -> Result<String, SubmitError> {
    let jobs = format!("--jobs={}", ids.join(","));
    let command = command("squeue", &["--noheader", "--format=%F %T", &jobs]);
    let output = command.run()?;
    // The controller forgets jobs some minutes after their end.
    if !output.status.success() && !output.stderr.contains("Invalid job id") {
        return Err(no_answer(&command, &output));
    }
    let mut lines: Vec<String> = output.stdout.lines().map(|line| line.trim().to_lowercase()).collect();
    lines.sort();
    lines.dedup();
    Ok(lines.join(", "))
}

/// Removes variables by which the environment would change the job, such as an array or waiting.
pub(super) fn without_inherited_options(mut command: Command) -> Command {
    for name in ["SBATCH_ARRAY_INX", "SBATCH_WAIT", "SBATCH_OUTPUT", "SBATCH_OPEN_MODE"] {
        command.env_remove(name);
    }
    command
}

fn command(program: &'static str, arguments: &[&str]) -> EngineCommand {
    EngineCommand {
        engine: NAME,
        program,
        arguments: arguments.iter().map(|argument| (*argument).to_owned()).collect(),
    }
}

fn no_answer(command: &EngineCommand, output: &CommandOutput) -> SubmitError {
    let text = if output.stderr.is_empty() { &output.stdout } else { &output.stderr };
    let (command, status) = (command.as_text(), status_text(&output.status));
    SubmitError::NoAnswer { engine: NAME, command, status, output: text.clone() }
}
