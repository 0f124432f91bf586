//! Tests of `--filter`: the selected runs and the error messages.

use super::{Place, Table};

/// Two scenarios: a sweep of four runs, and a single run.
fn sweep_and_single_run() -> Place {
    let place = Place::new();
    place.block("rest.toml", "").block(
        "slide.toml",
        "[sweep]\ngrid = { \"contact.method\" = [\"exact\", \"one-step\"], \"floor.friction\" = [0.2, 0.4] }\n",
    );
    place
}

/// Scenario, method and friction of the selected runs.
fn selected(place: &Place, filter: &str) -> Vec<String> {
    let arguments = ["list", "--format", "csv", "rest.toml", "slide.toml", "--filter", filter];
    let table = Table::parse(&place.runner(&arguments).exits(0).stdout);
    let column = |name: &str| match table.header.iter().any(|h| h == name) {
        true => table.column(name),
        false => vec![""; table.rows.len()],
    };
    let (methods, friction) = (column("contact.method"), column("floor.friction"));
    (0..table.rows.len())
        .map(|i| format!("{} {} {}", table.column("scenario")[i], methods[i], friction[i]).trim_end().to_owned())
        .collect()
}

#[test]
fn filters_read_names_keys_swept_values_and_defaults() {
    let place = sweep_and_single_run();
    let all = ["rest", "slide exact 0.2", "slide exact 0.4", "slide one-step 0.2", "slide one-step 0.4"];
    assert_eq!(selected(&place, "name ~ '*'"), all);
    assert_eq!(selected(&place, "name ~ 's*' and floor.friction.static < 0.3"), [all[1], all[3]]);
    assert_eq!(selected(&place, "name != 'slide'"), all[..1]);
    // `rest` has `exact` by default.
    assert_eq!(selected(&place, "contact.method == 'exact'"), all[..3]);
    assert_eq!(
        selected(&place, "floor.friction.static == 0.8 or contact.method in ['one-step']"),
        [all[0], all[3], all[4]]
    );
    // The value as written in the sweep. In `rest` it is a table.
    assert_eq!(selected(&place, "floor.friction == 0.4"), [all[2], all[4]]);
    assert_eq!(selected(&place, "not floor.friction == 0.4"), [all[0], all[1], all[3]]);
    let keys = place.runner(&["list", "--format", "csv", "slide.toml"]).exits(0).stdout;
    let key = Table::parse(&keys).column("key")[2].to_owned();
    assert_eq!(selected(&place, &format!("key ^= \"{}\"", &key[..6])), all[3..4]);
}

#[test]
fn only_selected_runs_are_run_with_unchanged_keys() {
    let place = sweep_and_single_run();
    place.runner(&["slide.toml", "--set", "duration=0.05", "--filter", "floor.friction.kinetic > 0.3"]).exits(0);
    let summary = place.summary("results");
    assert_eq!(summary.column("floor.friction"), ["0.4", "0.4"]);
    let all = place.runner(&["list", "--format", "csv", "slide.toml", "--set", "duration=0.05"]).exits(0).stdout;
    let all = Table::parse(&all);
    assert_eq!(summary.column("key"), [all.column("key")[1], all.column("key")[3]]);
    let check = place.runner(&["check", "slide.toml", "--filter", "floor.friction.kinetic > 0.3"]).exits(0);
    assert!(check.stdout.ends_with("all good: 1 scenario, 2 runs\n"), "{}", check.stdout);
}

#[test]
fn references_stay_with_the_runs_that_need_them() {
    let place = Place::new();
    place.block(
        "s.toml",
        "[compare]\nreference = { \"integrator.relative_tolerance\" = 1e-9 }\n\
         [sweep]\ngrid = { \"floor.friction\" = [0.2, 0.4, 0.6] }\n",
    );
    let check = |filter: &str| place.runner(&["check", "s.toml", "--filter", filter]).exits(0).stdout;
    assert!(check("name == 's'").contains("3 runs and 3 reference runs"));
    assert!(check("floor.friction >= 0.4").contains("2 runs and 2 reference runs"));
    let arguments = ["s.toml", "--set", "duration=0.05", "--filter", "floor.friction >= 0.4", "--no-timing"];
    place.runner(&arguments).exits(0);
    let summary = place.summary("results");
    assert!(
        summary.numbers("error_position_rms_m").iter().all(|e| *e < 1e-6),
        "each run is compared with its own reference"
    );
    assert_eq!(std::fs::read_dir(place.path("results/s/references")).unwrap().count(), 2);
}

#[test]
fn stars_can_be_escaped_and_lists_may_end_with_a_comma() {
    let place = Place::new();
    place.block("a.toml", "").block("a*.toml", "").block("a?b.toml", "");
    let selected = |filter: &str| {
        let arguments = ["list", "--format", "csv", "a.toml", "a*.toml", "a?b.toml", "--filter", filter];
        let table = Table::parse(&place.runner(&arguments).exits(0).stdout);
        table.column("scenario").into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(selected(r#"name ~ "a*""#), ["a", "a*", "a?b"]);
    assert_eq!(selected(r#"name ~ "a\*""#), ["a*"]);
    assert_eq!(selected(r#"name ~ "*\?b""#), ["a?b"]);
    assert_eq!(selected(r#"name !~ "a\*""#), ["a", "a?b"]);
    // In single quotes a backslash is literal, and `==` has no patterns.
    assert_eq!(selected(r"not name ~ 'a\*'"), ["a", "a*", "a?b"]);
    assert_eq!(selected(r#"name == "a\*""#), ["a*"]);
    assert_eq!(selected("name in ['a', 'a*',]"), ["a", "a*"]);
    // A valid value that no run has is no error.
    let filter = "contact.method == 'lcp' or name == 'a'";
    assert_eq!(selected(filter), ["a"]);
}

#[test]
fn an_empty_selection_exits_with_4() {
    let place = sweep_and_single_run();
    for command in ["run", "check", "list"] {
        let done = place.runner(&[command, "slide.toml", "--filter", "floor.friction > 1"]).exits(4);
        assert_eq!(done.stderr, "nothing selected: the filter holds for none of 4 runs\n", "{command}");
    }
    assert!(!place.path("results").exists());
}

#[test]
fn errors_are_shown_at_their_position_with_a_suggestion() {
    let place = sweep_and_single_run();
    for (filter, column, message, help) in [
        ("contact.metod == 'exact'", 1, "no run has a parameter `contact.metod`", "did you mean `contact.method`?"),
        ("name == 's' and kinetic > 0", 17, "no run has a parameter `kinetic`", "`floor.friction.kinetic`?"),
        ("colour == 3", 1, "no run has a parameter `colour`", "`resolved`"),
        ("contact.method < 3", 18, "`contact.method` is a text, such as \"exact\"", "compared with a number"),
        ("contact.method < 'exact'", 18, "expected a number", ""),
        ("seed ~ 1", 8, "expected a text in quotes", ""),
        ("gravity == 9.81", 1, "`gravity` is not a number, a text or a flag", "from `gravity.0` to `gravity.2`"),
        ("name = 'rest'", 6, "expected a comparison operator", "equal is `==`"),
        ("name == rest", 9, "expected text in quotes", "write \"rest\""),
        ("name == 'rest", 9, "this text is not closed", ""),
        ("(name == 'rest'", 1, "this bracket is not closed", ""),
        ("name == 'rest')", 15, "this bracket has no opening one", ""),
        ("name == 'rest' name", 16, "expected `and`, `or` or the end", ""),
        ("seed == 1e999", 9, "expected a finite number", ""),
        ("seed == 1.2.3", 9, "not a number", ""),
        ("contact.method == 'exct'", 19, "`contact.method` cannot be \"exct\"", "did you mean `exact`?"),
        ("seed > 0 and contact.method in ['exact', 'ncq']", 42, "`contact.method` cannot be \"ncq\"", "`ncp`?"),
        ("contact.method != 'colour'", 19, "`contact.method` cannot be \"colour\"", "known here: `exact`"),
        ("contact.method in ['exact', 3]", 29, "a number, but the list begins with a text", "of one kind"),
        ("seed in [1, true]", 13, "true or false, but the list begins with a number", "of one kind"),
        ("0.4 == floor.friction.static", 1, "expected a property of the run", "write `floor.friction.static == 0.4`"),
        ("0.4 < floor.friction.static", 1, "expected a property of the run", "write `floor.friction.static > 0.4`"),
        ("'exact' == contact.method", 1, "expected a property of the run", "write `contact.method == 'exact'`"),
        ("1 == 1", 1, "expected a property of the run", ""),
        ("seed == 1 AND name == 'rest'", 11, "expected `and`, `or` or the end", "in lower case: `and`"),
        ("(seed == 1 Or name == 'rest')", 12, "expected `and`, `or` or `)`", "in lower case: `or`"),
        ("NOT seed == 1", 5, "expected a comparison operator", "in lower case: `not`"),
        ("seed IN [1]", 6, "expected a comparison operator", "in lower case: `in`"),
        ("seed == TRUE", 9, "expected text in quotes", "in lower case: `true`"),
        ("seed in [,]", 10, "expected a value", ""),
        ("", 1, "expected a property of the run", "`name`"),
    ] {
        let done = place.runner(&["check", "rest.toml", "slide.toml", "--filter", filter]).exits(2);
        let position = format!("--filter:1:{column}\n");
        for expected in [message, &position, help] {
            assert!(done.stderr.contains(expected), "{filter}: no `{expected}` in\n{}", done.stderr);
        }
        let caret = done.stderr.lines().any(|line| line.trim_start_matches([' ', '|']).starts_with('^'));
        assert!(caret, "{filter}: {}", done.stderr);
    }
}
