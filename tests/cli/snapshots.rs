//! Snapshots of the exact output: help, errors, tables. To update them, run
//! `INSTA_UPDATE=always cargo test --release --test suite snapshots` and review the differences.

use super::{Done, Place};

/// Asserts that the text equals `snapshots/<name>.snap`.
#[track_caller]
fn assert_matches_snapshot(name: &str, text: &str) {
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| insta::assert_snapshot!(name, text));
}

/// Exit code, standard output and standard error as one text.
fn full_output(done: &Done) -> String {
    let mut out = format!("exit code {}\n", done.code.unwrap());
    for (name, text) in [("stdout", &done.stdout), ("stderr", &done.stderr)] {
        if !text.is_empty() {
            out += &format!("--- {name}\n{text}");
        }
    }
    out
}

#[test]
fn help() {
    let place = Place::new();
    let listed = place.runner(&["--help"]).exits(0).stdout;
    let commands = listed.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let commands = commands.filter(|line| !line.starts_with("   ")).filter_map(|line| line.split_whitespace().next());
    for command in ["runner"].into_iter().chain(commands.filter(|word| *word != "help")) {
        let mut arguments = vec!["--help"];
        if command != "runner" {
            arguments.insert(0, command);
        }
        // A fixed width, because the output is no terminal.
        let done = Done::from(place.command(&arguments).env("COLUMNS", "100").output().unwrap()).exits(0);
        let text: Vec<&str> = done.stdout.lines().map(str::trim_end).collect();
        assert_matches_snapshot(&format!("help-{command}"), &text.join("\n"));
    }
}

#[test]
fn errors() {
    let place = Place::new();
    let robot = std::fs::read_to_string(place.path("block/block.toml")).unwrap();
    let urdf = std::fs::read_to_string(place.path("block/block.urdf")).unwrap();
    place
        .block("key.toml", "[floor]\nfrction = 0.5\nheight = \"low\"\n")
        .block("joint.toml", "posture = { knee = 1.0 }\n")
        .block("sweep.toml", "[sweep.grid]\n\"floor.friction\" = [\n  0.1,\n  -0.2,\n]\n")
        .block(
            "late.toml",
            "[[force]]\ntype = \"push\"\nlink = \"block\"\nforce = [1, 0, 0]\nstart = 9.0\nduration = 0.1\n",
        )
        .write("syntax.toml", "[robot]\nmodel = block/block.toml\n")
        .write("lost.toml", "[robot]\nmodel = \"block/blok.toml\"\n")
        .write("bad/robot.toml", robot.replace("link = \"block\"", "link = \"blok\""))
        .write("bad/block.urdf", &urdf)
        .write("robot.toml", "[robot]\nmodel = \"bad/robot.toml\"\n")
        .write("heavy/block.urdf", urdf.replace("<mass value=\"1\"/>", "<mass value=\"-1\"/>"))
        .write("urdf.toml", "[robot]\nmodel = \"heavy/block.urdf\"\n")
        .block("good.toml", "");
    for (name, arguments) in [
        ("scenario-keys", &["key.toml"][..]),
        ("scenario-joint", &["joint.toml"]),
        ("scenario-sweep", &["sweep.toml"]),
        ("scenario-syntax", &["syntax.toml"]),
        ("scenario-warning", &["late.toml", "--strict"]),
        ("robot-not-there", &["lost.toml"]),
        ("robot-file", &["robot.toml"]),
        ("robot-urdf", &["urdf.toml"]),
        ("override", &["good.toml", "--set", "floor.friction=-1"]),
        ("filter-parameter", &["good.toml", "--filter", "contact.metod == 'exact'"]),
        ("filter-syntax", &["good.toml", "--filter", "name = 'good'"]),
        ("usage-option", &["good.toml", "--max-fial", "2"]),
        ("usage-command", &["chekc"]),
        ("usage-command-late", &["--color", "never", "check", "good.toml"]),
        ("usage-no-file", &["nothing.toml"]),
    ] {
        assert_matches_snapshot(&format!("mistake-{name}"), &full_output(&place.runner(arguments)));
    }
}

/// Replaces keys and times, which depend on the version and the machine.
fn redacted(text: &str, place: &Place, results: &str) -> String {
    let summary = place.summary(results);
    let mut text = text.to_owned();
    for (i, key) in summary.column("key").iter().enumerate() {
        text = text.replace(key, &format!("<key {i}>"));
    }
    text.lines()
        .map(|line| {
            let times =
                ["passed", "failed"].iter().any(|word| line.contains(&format!(" {word} "))) && line.contains("exact");
            let cells: Vec<&str> = line.split_whitespace().collect();
            match () {
                // The table: keeps simulated time, replaces wall time and real-time factor.
                () if times && cells.len() >= 7 => {
                    let at = cells.iter().position(|c| *c == "passed" || *c == "failed").unwrap();
                    let shown = cells
                        .iter()
                        .enumerate()
                        .map(|(i, c)| if [at + 2, at + 3].contains(&i) { "<time>" } else { *c });
                    shown.collect::<Vec<_>>().join("  ")
                }
                // The overview: replaces processor time.
                () if line.starts_with("slide ") && line.contains(" of ") => {
                    [&cells[..cells.len() - 1], &["<time>"]].concat().join(" ")
                }
                () if line.contains(" s in ") => {
                    let (before, after) = line.split_once(" s in ").unwrap();
                    format!("{before} s in <time>{}", &after[after.find(" s").unwrap()..])
                }
                () => line.split_whitespace().collect::<Vec<_>>().join(" "),
            }
        })
        .collect::<Vec<_>>()
        .join("\n")
}

#[test]
fn batch_and_list() {
    let place = Place::new();
    place.block(
        "slide.toml",
        // Numbers without rounding errors.
        "base = { linear_velocity = [0.2, 0, 0] }\n[[expect]]\nmetric = \"duration_s\"\nmax = 0.2\n\
         [[expect]]\nmetric = \"impacts\"\nvalue = 0\ntolerance = 0.5\n\
         [sweep]\ngrid = { duration = [0.125, 0.25], \"floor.friction\" = [0.1] }\n",
    );
    let done = place.runner(&["slide.toml", "-j", "1"]).exits(1);
    assert_matches_snapshot("batch", &redacted(&full_output(&done), &place, "results"));
    let done = place.runner(&["list", "slide.toml"]).exits(0);
    assert_matches_snapshot("list", &redacted(&full_output(&done), &place, "results"));
}
