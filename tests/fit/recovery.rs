//! Parameters from the program's own logs without noise.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use super::{Bench, repository};

fn run(arguments: &[&str], code: i32) -> String {
    let done = Command::new(env!("CARGO_BIN_EXE_runner")).args(arguments).env("NO_COLOR", "1").output().unwrap();
    let (out, err) = (String::from_utf8_lossy(&done.stdout), String::from_utf8_lossy(&done.stderr));
    assert_eq!(done.status.code(), Some(code), "{arguments:?}\n{out}\n{err}");
    out.into_owned()
}

/// The log of the only run below a folder of results.
fn log(results: &Path) -> String {
    let scenario = std::fs::read_dir(results).unwrap().map(|e| e.unwrap().path()).find(|path| path.is_dir()).unwrap();
    let run = std::fs::read_dir(scenario).unwrap().next().unwrap().unwrap().path();
    run.join("log.mcap").to_str().unwrap().to_owned()
}

const PARAMETERS: [(&str, f64, f64); 4] = [
    ("floor.friction.static", 0.5, 0.6),
    ("floor.friction.kinetic", 0.3, 0.4),
    ("robot.joint.swing.friction.coulomb", 0.005, 0.01),
    ("robot.joint.swing.friction.viscous", 0.002, 0.001),
];

fn fit_text(data: &str) -> String {
    let mut text = format!("scenario = {:?}\n[[data]]\n{data}\n", repository("scenarios/fits/base/cart.toml"));
    for (key, start, truth) in PARAMETERS {
        text += &format!("[[parameter]]\nkey = {key:?}\nstart = {start}\nmin = 0\nmax = {}\n", 2.0 * truth);
    }
    for column in ["base_x_m", "joint.swing.position_rad"] {
        text += &format!("[[signal]]\ncolumn = \"{column}\"\nsigma = 0.001\n");
    }
    text
}

#[test]
fn friction_of_floor_and_joint_from_our_own_log() {
    let bench = Bench::new();
    let at = |name: &str| bench.path(name).to_str().unwrap().to_owned();
    let scenario = repository("scenarios/fits/base/cart.toml");
    run(&[scenario.to_str().unwrap(), "-o", &at("results")], 0);
    let log = log(&bench.path("results"));
    run(&["export", &log, "-o", &at("table.csv")], 0);
    bench.write("log.toml", &fit_text(&format!("name = \"own\"\nfile = {log:?}")));
    bench.write("table.toml", &fit_text("name = \"own\"\nfile = \"table.csv\""));
    let fitted = |name: &str, jobs: &str| {
        run(&["fit", &at(name), "-o", &at(&format!("{name}-{jobs}")), "-j", jobs], 0);
        std::fs::read_to_string(bench.path(&format!("{name}-{jobs}/fit.json"))).unwrap()
    };
    let text = fitted("log.toml", "2");
    let result: Value = serde_json::from_str(&text).unwrap();
    for (found, (key, _, truth)) in result["parameters"].as_array().unwrap().iter().zip(PARAMETERS) {
        let estimate = found["estimate"].as_f64().unwrap();
        // The search ends with steps of 1e-10; residuals of runs with tolerances of 1e-9 are equal at
        // equal values.
        assert!((estimate / truth - 1.0).abs() < 1e-6, "{key}: {estimate:e}");
        assert_eq!(found["keys"][0], key);
    }
    assert_eq!(result["status"], "converged");
    assert_eq!(text, fitted("log.toml", "1"), "the same bits on one thread");
    // A table has the log's values to the last bit.
    assert_eq!(text.replace("log", "table"), fitted("table.toml", "2"));
    // The fitted values are overrides.
    let values = at("log.toml-2/fitted.toml");
    run(&["check", scenario.to_str().unwrap(), "--set-from", &values], 0);
    let listed = run(&["list", scenario.to_str().unwrap(), "--set-from", &values, "--set", "duration=0.5"], 0);
    assert_eq!(listed.lines().count(), 1);
}

/// With the true values the run of an experiment is the logged one, to the last bit: also where steps
/// are fixed and frames are their ends.
#[test]
fn simulated_columns_are_those_of_the_log() {
    let bench = Bench::new();
    let at = |name: &str| bench.path(name).to_str().unwrap().to_owned();
    let scenario = repository("scenarios/fits/base/cart.toml");
    for method in ["dopri5", "semi-implicit", "rk4"] {
        let set = format!("integrator.method={method}");
        run(&[scenario.to_str().unwrap(), "-o", &at(method), "--set", &set, "--set", "integrator.step=1e-3"], 0);
        let mut text = fit_text(&format!(
            "name = \"own\"\nfile = {:?}\nset = {{ \"integrator.method\" = {method:?}, \"integrator.step\" = 1e-3 }}",
            log(&bench.path(method))
        ));
        for column in
            ["base_v*", "com_z_m", "sole.bottom.force_?_N", "sole.bottom.vertex0.?_m", "joint.swing.effort_Nm"]
        {
            text += &format!("[[signal]]\ncolumn = {column:?}\nsigma = 1\n");
        }
        let fit = bench.fit(&text);
        let simulated = &fit.simulated(&PARAMETERS.map(|(.., truth)| truth)).unwrap()[0];
        assert!(simulated.channels.len() >= 13, "{}", simulated.channels.len());
        for (ours, logged) in simulated.channels.iter().zip(&fit.experiments[0].recording.channels) {
            assert_eq!(ours, logged, "{method}");
        }
    }
}
