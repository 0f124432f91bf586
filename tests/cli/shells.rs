//! Tests of shell completions, manual pages and colours.

use std::process::Command;

use super::Place;

/// Commands listed by `--help`.
pub fn commands(place: &Place) -> Vec<String> {
    let help = place.runner(&["--help"]).exits(0).stdout;
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| line.starts_with("  "));
    let words = listed.filter(|line| !line.starts_with("   ")).filter_map(|line| line.split_whitespace().next());
    words.filter(|word| *word != "help").map(str::to_owned).collect()
}

#[test]
fn completions_of_every_shell_contain_all_commands_and_options() {
    let place = Place::new();
    let commands = commands(&place);
    assert!(commands.len() >= 10, "{commands:?}");
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = place.runner(&["completions", shell]).exits(0).stdout;
        for word in commands.iter().map(String::as_str).chain(["message-format", "max-fail", "junit", "filter"]) {
            assert!(script.contains(word), "{shell} lacks {word}");
        }
    }
    place.runner(&["completions", "tcsh"]).exits(2);
}

/// Runs the completion in Bash, if Bash is installed.
#[test]
fn bash_completes_commands_and_options() {
    let place = Place::new();
    if Command::new("bash").arg("--version").output().is_err() {
        eprintln!("Bash is not installed: test skipped");
        return;
    }
    place.write("runner.bash", place.runner(&["completions", "bash"]).exits(0).stdout);
    let complete = |words: &[&str]| {
        let script = format!(
            "source runner.bash; COMP_WORDS=({}); COMP_CWORD={}; _runner runner '{}' ''; printf '%s\\n' \"${{COMPREPLY[@]}}\"",
            words.join(" "),
            words.len() - 1,
            words.last().unwrap()
        );
        let done = Command::new("bash").args(["-c", &script]).current_dir(place.path("")).output().unwrap();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        String::from_utf8(done.stdout).unwrap().lines().map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(complete(&["runner", "com"]), ["compare", "completions"]);
    assert_eq!(complete(&["runner", "run", "--max-f"]), ["--max-fail"]);
    let schemas = complete(&["runner", "schema", "m"]);
    assert_eq!(schemas, ["messages"]);
}

#[test]
fn the_manual_has_one_page_per_command() {
    let place = Place::new();
    let page = place.runner(&["man"]).exits(0).stdout;
    assert!(page.contains(".TH runner 1") && page.contains("EXIT STATUS"), "{page}");
    assert!(page.contains("runner\\-run(1)") && !page.contains("runner\\-help"), "only existing pages: {page}");
    place.runner(&["man", "--folder", "man/man1"]).exits(0);
    let mut pages: Vec<String> = std::fs::read_dir(place.path("man/man1"))
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    pages.sort();
    let mut expected: Vec<String> = commands(&place).iter().map(|command| format!("runner-{command}.1")).collect();
    expected.push("runner.1".into());
    expected.sort();
    assert_eq!(pages, expected);
    let run = std::fs::read_to_string(place.path("man/man1/runner-run.1")).unwrap();
    assert!(run.contains("\\-\\-max\\-fail"), "{run}");
    place.write("file", "");
    let done = place.runner(&["man", "--folder", "file/man"]).exits(2);
    assert!(done.stderr.contains("cannot write file/man"), "{}", done.stderr);
}

/// The output of this test is a pipe, so colours appear only if they are forced.
#[test]
fn colours_are_used_when_forced_and_not_in_pipes() {
    let place = Place::new();
    place.block("broken.toml", "[floor]\nfrction = 1\n");
    let coloured = |arguments: &[&str], variables: &[(&str, &str)]| {
        let mut command = place.command(arguments);
        command.env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE").env_remove("CLICOLOR").env("TERM", "xterm");
        let output = command.envs(variables.iter().copied()).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert!(!output.stderr.is_empty());
        output.stderr.contains(&0x1b)
    };
    let check = ["check", "broken.toml"];
    let usage = ["check", "--no-such-option"];
    for wrong in [check, usage] {
        let with = |color: &'static str| [&wrong[..], &[color]].concat();
        assert!(!coloured(&wrong, &[]), "a pipe");
        assert!(!coloured(&wrong, &[("CLICOLOR", "1")]));
        assert!(coloured(&wrong, &[("CLICOLOR_FORCE", "1")]));
        assert!(!coloured(&wrong, &[("CLICOLOR_FORCE", "0")]));
        assert!(!coloured(&wrong, &[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")]), "NO_COLOR takes precedence");
        assert!(coloured(&wrong, &[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "")]), "an empty variable counts as unset");
        assert!(coloured(&with("--color=always"), &[("NO_COLOR", "1")]), "the option takes precedence");
        assert!(!coloured(&with("--color=never"), &[("CLICOLOR_FORCE", "1")]));
        assert!(!coloured(&with("--color=auto"), &[]));
    }
    place.runner(&["check", "broken.toml", "--color", "blue"]).exits(2);
}
