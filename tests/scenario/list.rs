//! `sweep.list`: sets of values, in order.

use stiction::scenario::{Run, parse_override};

use super::{SMALLEST, file, runs, wrong};

fn listed(text: &str) -> Vec<Run> {
    runs(&format!("{SMALLEST}{text}"))
}

/// The parameters of a run as `name=value`.
fn listed_parameters(run: &Run) -> String {
    run.parameters.iter().map(|(name, value)| format!("{name}={value}")).collect::<Vec<_>>().join(" ")
}

#[test]
fn each_table_is_one_set_of_values() {
    let runs = listed("[sweep]\nlist = [{ \"integrator.step\" = 1e-3 }, { \"integrator.step\" = 1e-4 }]\n");
    let steps: Vec<f64> = runs.iter().map(|r| r.scenario.integrator.step).collect();
    assert_eq!(steps, [1e-3, 1e-4]);
    let text =
        "[sweep]\nlist = [{ duration = 1, \"floor.friction\" = 0.1 }, { duration = 2.5, \"floor.friction\" = 1 }]\n";
    let found: Vec<_> = listed(text).iter().map(|r| (r.scenario.duration, r.scenario.floor.friction.static_)).collect();
    assert_eq!(found, [(1.0, 0.1), (2.5, 1.0)]);
    assert_eq!(
        listed_parameters(&listed(text)[0]),
        "duration=1.0 floor.friction=0.1",
        "a column is of one kind of number"
    );
    assert_eq!(listed_parameters(&listed(text)[1]), "duration=2.5 floor.friction=1.0");
}

#[test]
fn keys_that_a_table_does_not_name_have_the_values_of_the_file() {
    let text = "[floor]\nfriction = { static = 0.8, kinetic = 0.6 }\n[contact]\nmethod = \"one-step\"\n[sweep]\nlist = [{ \"contact.method\" = \"exact\" }, { \"integrator.step\" = 2e-3 }, \
                { \"floor.friction.static\" = 0.9 }, {}]\n";
    let runs = listed(text);
    let found: Vec<_> = runs
        .iter()
        .map(|r| (r.scenario.contact.method.name(), r.scenario.integrator.step, r.scenario.floor.friction.static_))
        .collect();
    assert_eq!(
        found,
        [("exact", 1e-3, 0.8), ("one-step", 2e-3, 0.8), ("one-step", 1e-3, 0.9), ("one-step", 1e-3, 0.8)]
    );
    // Every cell of the summary has the run's own value: from the file, or the default.
    let method = |name: &str, step: &str, friction: &str| {
        format!("contact.method=\"{name}\" integrator.step={step} floor.friction.static={friction}")
    };
    assert_eq!(listed_parameters(&runs[0]), method("exact", "0.001", "0.8"));
    assert_eq!(listed_parameters(&runs[1]), method("one-step", "0.002", "0.8"));
    assert_eq!(listed_parameters(&runs[2]), method("one-step", "0.001", "0.9"));
    assert_eq!(listed_parameters(&runs[3]), method("one-step", "0.001", "0.8"));
}

#[test]
fn a_table_of_defaults_leaves_the_cell_empty() {
    // In the second run `floor.friction` is a default table that the file does not contain.
    let runs = listed("[sweep]\nlist = [{ \"floor.friction\" = 0.5 }, { duration = 2 }]\n");
    assert_eq!(listed_parameters(&runs[0]), "floor.friction=0.5 duration=5.0");
    assert_eq!(listed_parameters(&runs[1]), "duration=2");
    // Tables may name a value and a part of it: only one of them counts in a run, and both are
    // listed unchanged.
    let floor = "[floor]\nfriction = { static = 0.8, kinetic = 0.6 }\n";
    let list = "list = [{ \"floor.friction\" = 0.9 }, { \"floor.friction.kinetic\" = 0.1 }]\n";
    let runs = listed(&format!("{floor}[sweep]\n{list}"));
    assert_eq!(runs[1].scenario.floor.friction.static_, 0.8);
    assert_eq!(
        listed_parameters(&runs[1]),
        "floor.friction={ kinetic = 0.1, static = 0.8 } floor.friction.kinetic=0.1"
    );
    assert_eq!(listed_parameters(&runs[0]), "floor.friction=0.9 floor.friction.kinetic=0.9");
}

#[test]
fn values_reach_into_arrays_and_may_be_arrays() {
    let force = "[[force]]\ntype = \"push\"\nlink = \"a\"\nforce = [1, 2, 3]\n";
    let text = format!("{force}[sweep]\nlist = [{{ \"force.0.force\" = [4, 5, 6] }}, {{ \"force.0.force.2\" = 7 }}]\n");
    let forces: Vec<_> = listed(&text)
        .iter()
        .map(|run| match &run.scenario.force[0] {
            stiction::scenario::ForceSpec::Push(push) => push.force,
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(forces, [[4.0, 5.0, 6.0], [1.0, 2.0, 7.0]]);
}

#[test]
fn a_list_is_one_dimension_nested_in_the_order_of_the_file() {
    let list = "list = [{ duration = 1 }, { duration = 2 }]\n";
    let grid = "grid = { \"floor.height\" = [0, 10] }\n";
    let order = |text: String| -> Vec<_> {
        listed(&format!("[sweep]\n{text}")).iter().map(|r| (r.scenario.duration, r.scenario.floor.height)).collect()
    };
    assert_eq!(order(format!("{list}{grid}")), [(1.0, 0.0), (1.0, 10.0), (2.0, 0.0), (2.0, 10.0)]);
    assert_eq!(order(format!("{grid}{list}")), [(1.0, 0.0), (2.0, 0.0), (1.0, 10.0), (2.0, 10.0)]);
    assert!(order("list = []\n".into()).len() == 1, "an empty list sweeps nothing");
    let blocks = "[[sweep.list]]\nduration = 1\n[[sweep.list]]\nduration = 2\n";
    assert_eq!(listed(blocks).iter().map(|r| r.scenario.duration).collect::<Vec<_>>(), [1.0, 2.0]);
}

#[test]
fn an_overridden_key_is_constant_while_the_tables_advance() {
    let text =
        format!("{SMALLEST}[sweep]\nlist = [{{ duration = 1, \"floor.height\" = 1 }}, {{ \"floor.height\" = 2 }}]\n");
    let file = file(&text).unwrap();
    let runs = |set: &str| file.expand(&[parse_override(set).unwrap()]).unwrap();
    let values: Vec<_> = runs("duration=7").iter().map(|r| (r.scenario.duration, r.scenario.floor.height)).collect();
    assert_eq!(values, [(7.0, 1.0), (7.0, 2.0)]);
    assert!(runs("duration=7").iter().all(|r| r.parameters[0] == ("duration".into(), 7.into())));
    let values: Vec<_> =
        runs("floor.height=7").iter().map(|r| (r.scenario.duration, r.scenario.floor.height)).collect();
    assert_eq!(values, [(1.0, 7.0), (5.0, 7.0)]);
}

#[test]
fn the_number_of_runs_is_limited() {
    let file =
        file(&format!("{SMALLEST}[sweep]\nrepeat = 2\nlist = [{{ duration = 1 }}, {{ duration = 2 }}]\n")).unwrap();
    assert_eq!(file.expand_at_most(&[], 4).unwrap().len(), 4);
    let found = file.expand_at_most(&[], 3).unwrap_err();
    assert!(found.to_string().contains("4 runs, 3 are allowed"), "{found}");
    assert_eq!(found.0[0].location(), "scenarios/test.toml:5:1");
}

#[test]
fn an_error_names_the_value_to_be_replaced() {
    let text = format!("{SMALLEST}[floor]\nheight = 1\n[sweep]\nlist = [{{ \"floor.height\" = \"low\" }}]\n");
    let found = wrong(&text, &[]);
    assert_eq!(found.0[0].location(), "scenarios/test.toml:6:28", "{found}");
    assert!(found.0[0].message.contains("`floor.height` must be a number"), "{found}");
    assert_eq!(found.0[0].help.as_deref(), Some("`floor.height` is at scenarios/test.toml:4:1"), "{found}");
}
