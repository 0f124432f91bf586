//! Errors of fit files and data: file, line, key, the value found and the expected one.

use super::{Bench, repository};
use stiction::fit::{Fit, FitFile};

const GOOD: &str = r#"scenario = "block.toml"

[[data]]
file = "slide.csv"

[[parameter]]
key = "floor.friction.kinetic"
start = 0.3
min = 0.1
max = 0.5

[[signal]]
column = "base_x_m"
sigma = 0.001
"#;

fn bench() -> Bench {
    let bench = Bench::new();
    bench.grid("slide.csv", &["base_x_m", "other"], 50.0, 20);
    let model = repository("robots/block/block.toml");
    bench.write(
        "block.toml",
        &format!(
            "duration = 0.5\nfloor = {{ friction = {{ static = 0.5, kinetic = 0.5 }} }}\n[robot]\nmodel = {model:?}\n"
        ),
    );
    bench
}

/// The errors of a fit file as `file:line: message; help`, without the folder.
fn errors(bench: &Bench, text: &str) -> Vec<String> {
    let path = bench.path("fit.toml");
    let folder = format!("{}/", bench.path("").display().to_string().trim_end_matches('/'));
    let shown = |file: &str, line: usize, message: &str, help: &Option<String>| {
        let help = help.as_ref().map_or_else(String::new, |help| format!("; {help}"));
        format!("{file}:{line}: {message}{help}").replace(&folder, "")
    };
    match FitFile::parse(&path, text) {
        Err(errors) => errors.0.iter().map(|e| shown(&e.file, e.line(), &e.message, &e.help)).collect(),
        Ok(file) => match Fit::of_file(file) {
            Ok(_) => Vec::new(),
            Err(findings) => findings
                .iter()
                .filter(|finding| finding.severity() == stiction::batch::Severity::Error)
                .map(|finding| match finding {
                    stiction::batch::Finding::Scenario(e) => shown(&e.file, e.line(), &e.message, &e.help),
                    other => other.render(false),
                })
                .collect(),
        },
    }
}

#[test]
fn a_good_file_has_no_errors() {
    assert_eq!(errors(&bench(), GOOD), Vec::<String>::new());
}

#[test]
fn errors_of_fit_files_name_line_key_and_values() {
    let bench = bench();
    let search = "boundary = { outcome = \"fallen\" }, over = { duration = { between = [1, 2], tolerance = 0.1 } }";
    let searched = format!("duration = 0.5\nrobot = {{ model = \"x\" }}\nsearch = {{ {search} }}\n");
    bench.write("searched.toml", &searched);
    bench.write("swept.toml", "duration = 0.5\nrobot = { model = \"x\" }\nsweep = { grid = { seed = [1, 2] } }\n");
    bench.write("late.csv", "time_s,base_x_m\n0,1\n0.7,2\n");
    bench.write("back.csv", "time_s,base_x_m\n0,1\n0,2\n");
    bench.write("short.csv", "time_s,base_x_m\n0\n");
    bench.write("words.csv", "time_s,base_x_m\n0,near\n");
    bench.write("when.csv", "time_s,base_x_m\nnow,1\n");
    bench.write("log.mcap", "no log");
    for (from, to, expected) in [
        ("scenario = \"block.toml\"\n", "", "fit.toml:1: the fit lacks the key `scenario`"),
        ("min = 0.1", "mn = 0.1", "fit.toml:9: unknown key `mn` in `parameter.0`; did you mean `min`?"),
        ("start = 0.3", "start = \"low\"", "fit.toml:8: `parameter.0.start` must be a number, not the string \"low\""),
        ("start = 0.3", "start = 0.6", "fit.toml:8: `parameter.0.start` must be from 0.1 to 0.5, not 0.6"),
        ("max = 0.5", "max = 0.1", "fit.toml:10: `parameter.0.max` must be above `min`, 0.1, not 0.1"),
        (
            "min = 0.1",
            "min = 0.0\nscale = \"log\"",
            "fit.toml:9: `parameter.0.min` must be greater than 0 on a logarithmic scale, not 0",
        ),
        (
            "min = 0.1",
            "min = 0.1\nscale = \"lin\"",
            "fit.toml:10: `parameter.0.scale` cannot be \"lin\"; known here: `linear`, `log`",
        ),
        (
            "\"floor.friction.kinetic\"",
            "\"floor.friction.kinetik\"",
            "fit.toml:7: `parameter.0.key`: unknown key `kinetik` in `floor.friction`; did you mean `kinetic`?",
        ),
        (
            "key = \"floor.friction.kinetic\"",
            "key = [\"floor.height\", \"robot.payload.0.mass\"]",
            "fit.toml:7: `parameter.0.key`: there is no `robot.payload.0`: the file has no `robot.payload`",
        ),
        (
            "key = \"floor.friction.kinetic\"",
            "key = 3",
            "fit.toml:7: `parameter.0.key` must be a key or an array of keys, not the number 3",
        ),
        ("sigma = 0.001", "sigma = 0", "fit.toml:14: `signal.0.sigma` must be greater than 0, not 0"),
        (
            "[[signal]]",
            "[[signal]]\ncolumn = \"other\"\n[[signal]]",
            "fit.toml:14: `signal.1` and `signal.0` must both have a `sigma`, or none; without `sigma` the noise of \
             each signal is estimated",
        ),
        (
            "column = \"base_x_m\"",
            "column = \"base_y_m\"",
            "fit.toml:13: the data `slide` have no column `base_y_m`; did you mean `base_x_m`?",
        ),
        ("column = \"base_x_m\"", "column = \"other\"", "fit.toml:13: the scenario for `slide` has no column `other`"),
        (
            "sigma = 0.001",
            "sigma = 0.001\ndata = [\"slid\"]",
            "fit.toml:15: there are no data `slid`; did you mean `slide`?",
        ),
        (
            "file = \"slide.csv\"",
            "file = \"slide.csv\"\nhold_out = true",
            "fit.toml:3: all data are held out: there is nothing to fit",
        ),
        (
            "file = \"slide.csv\"",
            "file = \"slide.csv\"\n[[data]]\nfile = \"slide.csv\"",
            "fit.toml:6: `data.1` and `data.0` have the same name `slide`; give each a `name`",
        ),
        (
            "file = \"slide.csv\"",
            "file = \"slide.csv\"\nfrom = 2\nto = 1",
            "fit.toml:6: `data.0.to` must be after `from`, 2, not 1",
        ),
        (
            "file = \"slide.csv\"",
            "file = \"slide.csv\"\nfrom = 2",
            "fit.toml:4: `slide` has no values of the signals from 2 s to inf s",
        ),
        (
            "file = \"slide.csv\"",
            "file = \"slide.csv\"\noffset = -0.1",
            "fit.toml:5: `slide` begins at -0.1 s of simulated time, before the scenario; `offset` or `from` can \
             move or cut it",
        ),
        (
            "file = \"slide.csv\"",
            "file = \"slide.csv\"\ntime = \"t\"",
            "fit.toml:5: `slide.csv` has no column `t` of the time; known here: `time_s`, `base_x_m`, `other`",
        ),
        (
            "file = \"slide.csv\"",
            "file = \"slide.csv\"\nset = { \"floor.frction\" = 0.5 }",
            "fit.toml:5: `data.0.set.\"floor.frction\"`: unknown key `frction` in `floor`; did you mean `friction`?",
        ),
        (
            "file = \"slide.csv\"",
            "file = \"slide.csv\"\ncolumns = { base_x_m = \"x\" }",
            "fit.toml:5: `slide.csv` has no column `x`; known here: `time_s`, `base_x_m`, `other`",
        ),
        (
            "file = \"slide.csv\"",
            "file = \"slide.dat\"",
            "fit.toml:4: `data.0.file` must be a log (.mcap) or a table (.csv), not `slide.dat`",
        ),
        (
            "slide.csv",
            "late.csv",
            "fit.toml:4: the data `late` reach to 0.7 s, the scenario ends at 0.5 s; set `duration` of the scenario, \
             here by `set = { duration = 0.7 }`, or `to`",
        ),
        ("slide.csv", "back.csv", "back.csv:3: the time must be after that of the line before, 0"),
        ("slide.csv", "short.csv", "short.csv:2: this line has 1 cell, the header 2"),
        ("slide.csv", "words.csv", "fit.toml:13: `base_x_m` of the data `words` is not a number"),
        ("slide.csv", "when.csv", "when.csv:2: the time must be a number, not \"now\""),
        ("block.toml", "swept.toml", "fit.toml:1: the scenario has a sweep or a search: a fit needs a single run"),
        ("block.toml", "searched.toml", "fit.toml:1: the scenario has a sweep or a search: a fit needs a single run"),
    ] {
        let text = GOOD.replacen(from, to, 1);
        assert_ne!(text, GOOD, "{from}");
        let found = errors(&bench, &text);
        assert!(found.iter().any(|error| error == expected), "{to}\n  found    {found:#?}\n  expected {expected}");
    }
    for (from, to, part) in [
        ("slide.csv", "none.csv", "fit.toml:4: none.csv: "),
        ("slide.csv", "log.mcap", "fit.toml:4: "),
        ("block.toml", "none.toml", "none.toml:0: cannot read the file: "),
    ] {
        let found = errors(&bench, &GOOD.replacen(from, to, 1));
        assert!(found.len() == 1 && found[0].starts_with(part), "{to}: {found:#?}");
    }
}

/// Too few values for the parameters.
#[test]
fn fewer_values_than_parameters_are_refused() {
    let bench = bench();
    bench.write("slide.csv", "time_s,base_x_m\n0.1,1\n");
    assert_eq!(errors(&bench, GOOD), ["fit.toml:3: 1 value cannot determine 1 parameter"]);
}
