//! The command: exit codes, files, formats.

use std::process::{Command, Output};

use serde_json::Value;

use super::{Bench, fill, repository};

/// A block that slides with friction 0.4 from 3 m/s, its exact data, and a fit of them.
fn bench(friction: f64, extra: &str) -> Bench {
    let bench = Bench::new();
    let model = repository("robots/block/block.toml");
    bench.write(
        "block.toml",
        &format!(
            "duration = 1.0\ngravity = [0, 0, -9.81]\nfloor = {{ friction = {{ static = 0.5, kinetic = 0.5 }} }}\n\
             [robot]\nmodel = {model:?}\n\
             base = {{ linear_velocity = [3, 0, 0] }}\n"
        ),
    );
    bench.grid("slide.csv", &["base_x_m"], 50.0, 30);
    let text = format!(
        "description = \"A <sliding> block\"\nscenario = \"block.toml\"\n[[data]]\nfile = \"slide.csv\"\n\
         [[parameter]]\nkey = \"floor.friction.kinetic\"\nstart = 0.3\nmin = 0.1\nmax = 0.5\n{extra}\
         [[signal]]\ncolumn = \"base_x_m\"\n\
         sigma = 0.001\n"
    );
    bench.write("slide.toml", &text);
    let parameters = text.matches("[[parameter]]").count();
    let mut fit = bench.fit(&text);
    let truth: Vec<f64> = [friction, -9.81].into_iter().take(parameters).collect();
    fill(&mut fit, &truth);
    let recording = &fit.experiments[0].recording;
    let rows = recording.times.iter().zip(&recording.channels[0].values);
    let rows: String = rows.map(|(t, x)| format!("{t:?},{x:?}\n")).collect();
    bench.write("slide.csv", &format!("# exact\n\"time_s\", \"base_x_m\"\n{rows}"));
    bench
}

fn runner(bench: &Bench, arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_runner"));
    let Output { status, stdout, stderr } =
        command.args(arguments).current_dir(bench.path("")).env("NO_COLOR", "1").output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (status.code(), text(stdout), text(stderr))
}

#[test]
fn results_are_written_and_printed() {
    let bench = bench(0.4, "");
    let (code, out, err) = runner(&bench, &["fit", "slide.toml"]);
    assert_eq!(code, Some(0), "{out}\n{err}");
    assert!(out.starts_with("slide: converged after "), "{out}");
    assert!(out.contains("floor.friction.kinetic") && out.contains("fits/slide/fitted.toml"), "{out}");
    let json = std::fs::read_to_string(bench.path("fits/slide/fit.json")).unwrap();
    let result: Value = serde_json::from_str(&json).unwrap();
    assert_eq!((&result["fit"], &result["status"]), (&Value::from("slide"), &Value::from("converged")));
    assert_eq!(result["parameters"][0]["unit"], "1");
    let (code, printed, _) = runner(&bench, &["fit", "slide.toml", "--format", "json"]);
    assert_eq!((code, printed), (Some(0), json), "printed as written, and the files of a fit are replaced");
    let page = std::fs::read_to_string(bench.path("fits/slide/fit.html")).unwrap();
    for part in ["A &lt;sliding&gt; block", "<svg class=\"plot\"", "residual / sigma", "floor.friction.kinetic"] {
        assert!(page.contains(part), "{part}");
    }
    let fitted = std::fs::read_to_string(bench.path("fits/slide/fitted.toml")).unwrap();
    let value: toml::Table = fitted.parse().unwrap();
    let friction = value["floor.friction.kinetic"].as_float().unwrap();
    assert!((friction - 0.4).abs() < 1e-9, "{fitted}");
}

#[test]
fn exit_codes_tell_what_was_found() {
    let undecided = bench(0.4, "[[parameter]]\nkey = \"gravity.2\"\nstart = -9.81\nmin = -12\nmax = -8\n");
    let (code, out, _) = runner(&undecided, &["fit", "slide.toml"]);
    assert_eq!(code, Some(5), "{out}");
    assert!(out.contains("warning: the data determine only the product of"), "{out}");
    let differs = bench(0.4, "");
    let text = std::fs::read_to_string(differs.path("slide.csv")).unwrap();
    differs.write("slide.csv", &text.replace("0.02,", "0.02,1"));
    let (code, out, _) = runner(&differs, &["fit", "slide.toml"]);
    assert_eq!(code, Some(1), "{out}");
    let unfinished = bench(0.4, "");
    let fit = std::fs::read_to_string(unfinished.path("slide.toml")).unwrap();
    unfinished.write("slide.toml", &format!("max_iterations = 1\n{fit}"));
    let (code, out, _) = runner(&unfinished, &["fit", "slide.toml"]);
    assert_eq!(code, Some(3), "{out}");
    assert!(out.contains("not converged after 1 iteration"), "{out}");
    let (code, _, err) = runner(&unfinished, &["fit", "none.toml"]);
    assert_eq!(code, Some(2), "{err}");
}

#[test]
fn other_files_are_not_replaced() {
    let bench = bench(0.4, "");
    bench.write("fitted.toml", "mine = 1\n");
    let (code, _, err) = runner(&bench, &["fit", "slide.toml", "-o", "."]);
    assert_eq!(code, Some(2), "{err}");
    assert!(err.contains("it is no result of a fit and is not replaced"), "{err}");
    assert_eq!(std::fs::read_to_string(bench.path("fitted.toml")).unwrap(), "mine = 1\n");
    assert!(!bench.path("fit.json").exists(), "nothing is written");
}

/// A run that ends before its data: the fit says why.
#[test]
fn a_run_that_falls_at_the_start_is_named() {
    let bench = bench(0.4, "");
    let scenario = std::fs::read_to_string(bench.path("block.toml")).unwrap();
    bench.write("block.toml", &format!("{scenario}[stop]\nfallen = {{ below = 1.0 }}\n"));
    let (code, _, err) = runner(&bench, &["fit", "slide.toml"]);
    assert_eq!(code, Some(3), "{err}");
    assert!(err.contains("with the first estimates the run of `slide` ended at 0"), "{err}");
    assert!(err.contains("with outcome fallen"), "{err}");
}
