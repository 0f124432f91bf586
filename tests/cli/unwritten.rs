//! Tests of unwritable output, and of the exit codes in help, manual pages and documentation.
#![cfg(unix)]

use std::path::Path;

use super::{Done, Place};

/// Runs the program with standard output redirected to a full device.
fn run_with_full_stdout(place: &Place, arguments: &str) -> Done {
    place.shell(&format!("exec \"$0\" {arguments} > /dev/full"))
}

fn with_results() -> Place {
    let place = Place::new();
    place.block("s.toml", "[sweep]\ngrid = { \"floor.friction\" = [0.2, 0.4] }\n").block("rest.toml", "");
    place.runner(&["rest.toml", "--set", "duration=0.05"]).exits(0);
    place
}

fn folder_of_run(results: &Path) -> std::path::PathBuf {
    std::fs::read_dir(results.join("rest")).unwrap().next().unwrap().unwrap().path()
}

#[test]
fn unwritable_standard_output_exits_with_3_for_every_command() {
    let place = with_results();
    let run = folder_of_run(&place.path("results")).display().to_string();
    for arguments in [
        "check s.toml",
        "check s.toml --message-format json",
        "list s.toml",
        "list s.toml --format json",
        "inspect block/block.toml",
        "compare results results",
        "report results",
        "schema scenario",
        "completions bash",
        "man",
        "--help",
        "-h",
        "--version",
        "help",
        "check --help",
        &format!("export {run}"),
        &format!("replay {run}"),
    ] {
        let done = run_with_full_stdout(&place, arguments).exits(3);
        let count = done.stderr.matches("error: cannot write to standard output: No space left on device").count();
        assert_eq!(count, 1, "{arguments}: {}", done.stderr);
    }
}

/// Usage errors go to standard error, so a full standard output does not change them.
#[test]
fn usage_errors_exit_with_2_despite_a_full_standard_output() {
    let place = Place::new();
    for arguments in ["", "chek --nothing", "run --format", "list"] {
        let done = run_with_full_stdout(&place, arguments).exits(2);
        assert!(done.stderr.contains("Usage: ") && !done.stderr.contains("cannot write"), "{}", done.stderr);
    }
}

#[test]
fn runs_finish_although_standard_output_is_full() {
    for (format, results) in [("human", "human"), ("json", "json")] {
        let place = Place::new();
        place.block("s.toml", "[sweep]\ngrid = { \"floor.friction\" = [0.2, 0.4] }\n");
        let done =
            run_with_full_stdout(&place, &format!("s.toml --set duration=0.05 -o {results} --message-format {format}"))
                .exits(3);
        assert_eq!(done.stderr.matches("cannot write to standard output").count(), 1, "{}", done.stderr);
        assert_eq!(place.summary(results).column("outcome"), ["passed", "passed"]);
    }
}

#[test]
fn a_pipe_closed_by_head_is_no_error() {
    let place = with_results();
    place.block("many.toml", "[sweep]\nrepeat = 5000\n");
    for arguments in
        ["list many.toml", "list many.toml --format json", "check many.toml --message-format json", "run --help"]
    {
        let done = place.shell(&format!("{{ \"$0\" {arguments}; echo $? > code; }} | head -1"));
        assert_eq!((done.stderr.as_str(), std::fs::read_to_string(place.path("code")).unwrap().trim()), ("", "0"));
    }
}

/// A path that cannot hold a file is a usage error (2). A full disk is not (3).
#[test]
fn unwritable_files_exit_with_2_or_3() {
    let place = with_results();
    let run = folder_of_run(&place.path("results")).display().to_string();
    place.write("file", "");
    for arguments in [format!("export {run} -o"), format!("view {run} -o")] {
        let ending = if arguments.starts_with("export") { "csv" } else { "html" };
        let done = place.shell(&format!("exec \"$0\" {arguments} file/below.{ending}")).exits(2);
        assert!(done.stderr.starts_with("error: file: "), "{}", done.stderr);
        let limited = format!("trap '' XFSZ; ulimit -f 1; exec \"$0\" {arguments} small.{ending}");
        let done = place.shell(&limited).exits(3);
        assert!(done.stderr.contains(&format!("small.{ending}: File too large")), "{}", done.stderr);
        assert!(!place.path(&format!("small.{ending}")).exists(), "a partial file is left");
        // Missing folders are created, as for all outputs.
        place.shell(&format!("exec \"$0\" {arguments} new/{ending}/it.{ending}")).exits(0);
        assert!(place.path(&format!("new/{ending}/it.{ending}")).exists());
    }
}

/// Exit codes and their meanings from the help of a command.
fn exit_codes_in_help(place: &Place, command: &[&str]) -> Vec<(String, String)> {
    let help = place.runner(&[command, &["--help"]].concat()).exits(0).stdout;
    let (_, below) = help.split_once("Exit codes:\n").unwrap_or_else(|| panic!("{command:?} has none:\n{help}"));
    let mut codes: Vec<(String, String)> = Vec::new();
    // Other text may follow after an empty line.
    for line in below.lines().take_while(|line| !line.is_empty()) {
        assert!(line.chars().count() <= 80, "{line}");
        match line.strip_prefix("  ").and_then(|l| l.split_once(' ')).filter(|(code, _)| code.parse::<u8>().is_ok()) {
            Some((code, text)) => codes.push((code.into(), text.trim().into())),
            None => codes.last_mut().unwrap().1 += &format!(" {}", line.trim()),
        }
    }
    codes
}

#[test]
fn help_manual_and_documentation_agree_on_exit_codes() {
    let place = Place::new();
    let docs = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/ci.md")).unwrap();
    let mut documented: Vec<(String, String, String)> = Vec::new();
    let table = docs.lines().skip_while(|line| *line != "| command | code | meaning |").skip(2);
    for line in table.take_while(|line| line.starts_with('|')) {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [commands, code, meaning] = cells[..] else { panic!("{line}") };
        let commands = match commands {
            "" => documented.last().unwrap().0.clone(),
            some => some.replace('`', ""),
        };
        documented.push((commands, code.into(), meaning.into()));
    }
    place.runner(&["man", "--folder", "man"]).exits(0);
    for command in super::shells::commands(&place) {
        let from_help = exit_codes_in_help(&place, &[&command]);
        let from_docs = documented.iter().filter(|(commands, ..)| commands.split(", ").any(|c| c == command));
        let from_docs: Vec<(String, String)> = from_docs.map(|(_, code, text)| (code.clone(), text.clone())).collect();
        assert_eq!(from_help, from_docs, "`runner {command} --help` and docs/ci.md");
        let page = std::fs::read_to_string(place.path(&format!("man/runner-{command}.1"))).unwrap();
        let (_, status) = page.split_once(".SH \"EXIT STATUS\"").unwrap_or_else(|| panic!("{page}"));
        for (code, text) in &from_help {
            // Manual pages escape hyphens.
            let expected = format!(".TP\n\\fB{code}\\fR\n{}", text.replace('-', "\\-"));
            assert!(status.contains(&expected), "{command}: no {expected} in {status}");
        }
        assert!(!page.contains("EXTRA"), "{page}");
    }
    assert_eq!(exit_codes_in_help(&place, &[]), exit_codes_in_help(&place, &["run"]));
    let submit = std::fs::read_to_string(place.path("man/runner-submit.1")).unwrap();
    let (_, notes) = submit.split_once(".SH NOTES").expect("notes after the exit codes");
    assert!(notes.contains("The same command again completes what is missing"), "{notes}");
    let run = std::fs::read_to_string(place.path("man/runner-run.1")).unwrap();
    assert!(run.contains("<\\fISCENARIO\\fR>..."), "{run}");
}

/// The table and the written files are still printed.
#[test]
fn unwritable_test_results_exit_with_3_after_the_table() {
    let place = Place::new();
    place.block("s.toml", "");
    let arguments = ["s.toml", "--set", "duration=0.05", "--junit", "/dev/full"];
    let done = place.runner(&arguments).exits(3);
    assert!(done.stdout.contains("written:\n  results/summary.csv\n"), "{}", done.stdout);
    assert!(done.stderr.ends_with("error: /dev/full: No space left on device (os error 28)\n"), "{}", done.stderr);
    let done = place.runner(&[&arguments[..], &["--message-format", "json"]].concat()).exits(3);
    let last = done.stdout.lines().last().unwrap();
    assert!(last.contains("results/summary.csv") && last.contains("No space left on device"), "{last}");
}
