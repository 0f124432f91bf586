//! Combinations of methods and integrators: each cell of the table runs, or is refused with its
//! position.

use crate::support::runs::root;
use std::sync::atomic::AtomicBool;
use stiction::assemble;
use stiction::scenario;
use stiction::sim::{NullObserver, Outcome, Simulation};

const METHODS: [&str; 5] = ["exact", "one-step", "penalty", "lcp", "ncp"];
const INTEGRATORS: [&str; 4] = ["dopri5", "bs23", "rk4", "semi-implicit"];

/// A sliding block with these lines in `[contact]`; the method is in line 4.
fn attempt(method: &str, integrator: &str, contact: &str) -> Result<Simulation, String> {
    let text = format!(
        "duration = 0.1\nlog = {{ rate = 0 }}\n[contact]\nmethod = \"{method}\"\n{contact}\n[integrator]\n\
         method = \"{integrator}\"\n[robot]\nmodel = \"robots/block/block.toml\"\nbase = {{ linear_velocity = [1, 0, 0] }}\n"
    );
    let file = scenario::parse(&root().join("test.toml"), &text).map_err(|e| e.to_string())?;
    let run = file.expand(&[]).map_err(|e| e.to_string())?.remove(0);
    let robot = stiction::robot::load(&run.resolve(&run.scenario.robot.model)).expect("our own robot");
    let setup = assemble::setup(&run, &robot).map_err(|e| e.to_string())?;
    Ok(Simulation::new(setup).unwrap_or_else(|e| panic!("{e}")))
}

#[test]
fn every_method_runs_with_the_integrators_of_the_table_and_no_other() {
    for method in METHODS {
        for integrator in INTEGRATORS {
            let compatible = !matches!(method, "lcp" | "ncp") || integrator == "semi-implicit";
            match attempt(method, integrator, "") {
                Ok(mut sim) => {
                    assert!(compatible, "{method} with {integrator} is not refused");
                    let (outcome, message) = sim.run(&mut NullObserver, &AtomicBool::new(false));
                    assert_eq!(outcome, Outcome::Passed, "{method} with {integrator}: {message}");
                    // It slides with mu g, 0.6 by default, to the accuracy of a step of 10 ms.
                    let speed = sim.metrics().final_base_velocity[0];
                    assert!((speed - (1.0 - 0.6 * 9.81 * 0.1)).abs() < 0.01, "{method} with {integrator}: {speed}");
                }
                Err(error) => {
                    assert!(!compatible, "{error}");
                    let names = [format!("`contact.method` = \"{method}\""), format!("\"{integrator}\"")];
                    assert!(names.iter().all(|n| error.contains(n)) && error.contains("test.toml:4:10"), "{error}");
                    assert!(error.contains("set `integrator.method` = \"semi-implicit\""), "{error}");
                }
            }
        }
    }
}

#[test]
fn restitution_and_imposed_states_are_refused_where_they_have_no_effect() {
    let forced = "forced = [{ sole = \"bottom\", state = \"face-dynamic\", to = 0.05 }]";
    for method in METHODS {
        for integrator in INTEGRATORS {
            if matches!(method, "lcp" | "ncp") && integrator != "semi-implicit" {
                continue;
            }
            let bounces = method == "exact" && integrator != "semi-implicit";
            let takes_states = matches!(method, "exact" | "one-step");
            for (line, key, accepted) in
                [("restitution = 0.5", "restitution", bounces), (forced, "forced", takes_states)]
            {
                match attempt(method, integrator, line) {
                    Ok(mut sim) => {
                        assert!(accepted, "{method} with {integrator} takes {key}");
                        assert_eq!(sim.run(&mut NullObserver, &AtomicBool::new(false)).0, Outcome::Passed);
                    }
                    Err(error) => {
                        let says = format!("`contact.{key}` does not work with `contact.method` = \"{method}\"");
                        assert!(!accepted && error.contains(&says) && error.contains("test.toml:5:"), "{error}");
                    }
                }
            }
        }
    }
}

#[test]
fn torsional_and_rolling_friction_are_refused_by_methods_of_forces_alone() {
    for method in METHODS {
        for term in ["torsional", "rolling"] {
            let pair = format!(
                "pair = [{{ bodies = [\"bottom\", \"floor\"], friction = {{ static = 0.5, kinetic = 0.5, {term} = 0.01 }} }}]"
            );
            match attempt(method, "semi-implicit", &pair) {
                Ok(_) => assert!(matches!(method, "exact" | "one-step"), "{method} with {term} is not refused"),
                Err(error) => {
                    assert!(!matches!(method, "exact" | "one-step"), "{error}");
                    let named = format!("`contact.pair.0.friction.{term}` = 0.01 does not work with");
                    assert!(error.contains(&named) && error.contains("test.toml:5:"), "{error}");
                    assert!(error.contains(&format!("\"{method}\"")) && error.contains("\"exact\""), "{error}");
                }
            }
        }
    }
}
