//! The texts of the two batch scripts.
//!
//! A line of `#SBATCH` is read by `sbatch`, which takes words between double quotes as one and a backslash for the character
//! after it; all below is read by a shell. In the path of `--output` moreover `%` is special and doubled, and a backslash
//! would end that, so the folder may have none (seen with Slurm 22.05).

use std::path::Path;

use super::super::{SubmitError, Sweep, text};
use super::Options;

/// One task for each part.
pub(super) fn array(sweep: &Sweep, options: &Options) -> Result<String, SubmitError> {
    let last = sweep.parts.get() - 1;
    let mut lines = vec![
        "#!/bin/sh".to_owned(),
        "# A part of a sweep, written by `runner submit`. --resume lets a task that was preempted or requeued go on where it was;".to_owned(),
        "# SIGINT a minute before the end of its time lets it finish its running runs, and reaches it because of exec.".to_owned(),
        format!("#SBATCH --array=0-{last}"),
        format!("#SBATCH --cpus-per-task={}", options.cpus),
        "#SBATCH --signal=B:INT@60".to_owned(),
        "#SBATCH --requeue".to_owned(),
    ];
    lines.extend(common(sweep, options, "", "task-%a.txt")?);
    let run = text::command(&checked(sweep)?);
    let jobs = sweep.jobs.map_or_else(|| "\"$SLURM_CPUS_PER_TASK\"".to_owned(), |jobs| jobs.to_string());
    // Only the number of the part is left to the shell.
    let part = text::shell(&format!("{}/part-", path("the folder", &sweep.folder)?));
    lines.push(format!("exec {run} --shard env --resume --jobs {jobs} --output {part}\"$SLURM_ARRAY_TASK_ID\""));
    Ok(lines.join("\n") + "\n")
}

/// What comes after them.
pub(super) fn merge(sweep: &Sweep, options: &Options) -> Result<String, SubmitError> {
    let mut lines = vec![
        "#!/bin/sh".to_owned(),
        "# Submitted with --dependency=afterany: an array of which a task found expectations that failed has failed for Slurm."
            .to_owned(),
        "# Whether the parts are whole is what the merge looks at.".to_owned(),
        "#SBATCH --requeue".to_owned(),
    ];
    lines.extend(common(sweep, options, "-merge", "merge.txt")?);
    let mut words = vec![path("the program", &sweep.runner)?.to_owned(), "merge".to_owned()];
    for number in 0..sweep.parts.get() {
        words.push(path("the folder", &sweep.part(number))?.to_owned());
    }
    words.extend(["--output".to_owned(), path("the folder", &sweep.results())?.to_owned()]);
    lines.push(format!("exec {}", text::command(&words)));
    Ok(lines.join("\n") + "\n")
}

/// What all parts run, but for which part they are.
pub(super) fn command(sweep: &Sweep) -> Vec<String> {
    let begin = [super::super::shown(&sweep.runner), "run".to_owned()];
    begin.into_iter().chain(sweep.arguments.iter().cloned()).collect()
}

fn checked(sweep: &Sweep) -> Result<Vec<String>, SubmitError> {
    path("the program", &sweep.runner)?;
    let words = command(sweep);
    words.iter().try_for_each(|word| text::line("an argument", word).map(|_| ()))?;
    Ok(words)
}

/// What both jobs say: their place, and what was chosen.
fn common(sweep: &Sweep, options: &Options, suffix: &str, output: &str) -> Result<Vec<String>, SubmitError> {
    let folder = path("the folder", &sweep.folder)?;
    if folder.contains('\\') {
        let (what, why) = ("the folder", "a backslash, which Slurm does not take in names of files");
        return Err(SubmitError::Word { what, why, word: folder.to_owned() });
    }
    let scripts = sweep.scripts();
    let scripts = path("the folder", &scripts)?;
    let mut lines = vec![
        format!("#SBATCH --job-name={}{suffix}", name(&sweep.folder)),
        "#SBATCH --open-mode=append".to_owned(),
        format!("#SBATCH --chdir={}", quoted(scripts)),
        format!("#SBATCH --output={}", quoted(&format!("{}/{output}", scripts.replace('%', "%%")))),
    ];
    let chosen = [
        ("--time", &options.time),
        ("--partition", &options.partition),
        ("--account", &options.account),
        ("--mem", &options.mem),
    ];
    for (option, value) in chosen {
        if let Some(value) = value {
            lines.push(format!("#SBATCH {option}={}", quoted(text::line("an option", value)?)));
        }
    }
    // After the others, so that they are what counts.
    lines.extend(options.more.iter().map(|option| format!("#SBATCH {option}")));
    Ok(lines)
}

/// A value on a line of `#SBATCH`.
fn quoted(value: &str) -> String {
    format!("\"{}\"", value.replace('\\', "\\\\").replace('"', "\\\""))
}

/// The folder's name as that of a job, in which tools expect plain words.
fn name(folder: &Path) -> String {
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    name.chars().map(|c| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' }).collect()
}

fn path<'a>(what: &'static str, path: &'a Path) -> Result<&'a str, SubmitError> {
    text::path(what, path)
}
