//! `--filter`: which runs are left, and what is said of a filter that makes no sense.

use super::{Place, Table};

/// Four runs with two friction coefficients, beside one with none of this swept.
fn place() -> Place {
    let place = Place::new();
    place.block("rest.toml", "").block(
        "slide.toml",
        "[sweep]\ngrid = { \"contact.method\" = [\"exact\", \"one-step\"], \"floor.friction\" = [0.2, 0.4] }\n",
    );
    place
}

/// Scenario, method and friction of the runs that are left.
fn left(place: &Place, filter: &str) -> Vec<String> {
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
fn it_reads_names_keys_swept_values_and_defaults() {
    let place = place();
    let all = ["rest", "slide exact 0.2", "slide exact 0.4", "slide one-step 0.2", "slide one-step 0.4"];
    assert_eq!(left(&place, "name ~ '*'"), all);
    assert_eq!(left(&place, "name ~ 's*' and floor.friction.static < 0.3"), [all[1], all[3]]);
    assert_eq!(left(&place, "name != 'slide'"), all[..1]);
    // `exact` is what `rest` has without saying so.
    assert_eq!(left(&place, "contact.method == 'exact'"), all[..3]);
    assert_eq!(
        left(&place, "floor.friction.static == 0.8 or contact.method in ['one-step']"),
        [all[0], all[3], all[4]]
    );
    // The value as the sweep wrote it; `rest` has a table there.
    assert_eq!(left(&place, "floor.friction == 0.4"), [all[2], all[4]]);
    assert_eq!(left(&place, "not floor.friction == 0.4"), [all[0], all[1], all[3]]);
    let keys = place.runner(&["list", "--format", "csv", "slide.toml"]).exits(0).stdout;
    let key = Table::parse(&keys).column("key")[2].to_owned();
    assert_eq!(left(&place, &format!("key ^= \"{}\"", &key[..6])), all[3..4]);
}

#[test]
fn only_what_is_left_is_run_and_keys_stay() {
    let place = place();
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
    assert!(summary.numbers("error_position_rms_m").iter().all(|e| *e < 1e-6), "each is held against its own");
    assert_eq!(std::fs::read_dir(place.path("results/s/references")).unwrap().count(), 2);
}

#[test]
fn stars_can_be_meant_and_lists_may_end_with_a_comma() {
    let place = Place::new();
    place.block("a.toml", "").block("a*.toml", "").block("a?b.toml", "");
    let left = |filter: &str| {
        let arguments = ["list", "--format", "csv", "a.toml", "a*.toml", "a?b.toml", "--filter", filter];
        let table = Table::parse(&place.runner(&arguments).exits(0).stdout);
        table.column("scenario").into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(left(r#"name ~ "a*""#), ["a", "a*", "a?b"]);
    assert_eq!(left(r#"name ~ "a\*""#), ["a*"]);
    assert_eq!(left(r#"name ~ "*\?b""#), ["a?b"]);
    assert_eq!(left(r#"name !~ "a\*""#), ["a", "a?b"]);
    // In single quotes nothing takes a meaning away, and `==` knows no patterns.
    assert_eq!(left(r"not name ~ 'a\*'"), ["a", "a*", "a?b"]);
    assert_eq!(left(r#"name == "a\*""#), ["a*"]);
    assert_eq!(left("name in ['a', 'a*',]"), ["a", "a*"]);
    // A word that could be there, though no run has it, is no mistake.
    let words = "contact.method == 'lcp' or name == 'a'";
    assert_eq!(left(words), ["a"]);
}

#[test]
fn nothing_selected_is_4() {
    let place = place();
    for command in ["run", "check", "list"] {
        let done = place.runner(&[command, "slide.toml", "--filter", "floor.friction > 1"]).exits(4);
        assert_eq!(done.stderr, "nothing selected: the filter holds for none of 4 runs\n", "{command}");
    }
    assert!(!place.path("results").exists());
}

#[test]
fn mistakes_are_shown_at_their_place_with_what_was_meant() {
    let place = place();
    for (filter, column, message, help) in [
        ("contact.metod == 'exact'", 1, "no run has a parameter `contact.metod`", "did you mean `contact.method`?"),
        ("name == 's' and kinetic > 0", 17, "no run has a parameter `kinetic`", "`floor.friction.kinetic`?"),
        ("colour == 3", 1, "no run has a parameter `colour`", "`resolved`"),
        ("contact.method < 3", 18, "`contact.method` is a text, such as \"exact\"", "compared with a number"),
        ("contact.method < 'exact'", 18, "a number is wanted here", ""),
        ("seed ~ 1", 8, "a text in quotes is wanted here", ""),
        ("gravity == 9.81", 1, "`gravity` is neither", "from `gravity.0` to `gravity.2`"),
        ("name = 'rest'", 6, "a comparison is wanted here", "equal is `==`"),
        ("name == rest", 9, "a text stands in quotes", "write \"rest\""),
        ("name == 'rest", 9, "this text is never closed", ""),
        ("(name == 'rest'", 1, "this bracket is never closed", ""),
        ("name == 'rest')", 15, "this bracket closes nothing", ""),
        ("name == 'rest' name", 16, "`and`, `or` or the end is wanted here", ""),
        ("seed == 1e999", 9, "a finite number is wanted here", ""),
        ("seed == 1.2.3", 9, "this is no number", ""),
        ("contact.method == 'exct'", 19, "`contact.method` cannot be \"exct\"", "did you mean `exact`?"),
        ("seed > 0 and contact.method in ['exact', 'ncq']", 42, "`contact.method` cannot be \"ncq\"", "`ncp`?"),
        ("contact.method != 'colour'", 19, "`contact.method` cannot be \"colour\"", "known here: `exact`"),
        ("contact.method in ['exact', 3]", 29, "a number, but the list begins with a text", "of one kind"),
        ("seed in [1, true]", 13, "true or false, but the list begins with a number", "of one kind"),
        ("0.4 == floor.friction.static", 1, "something of the run is wanted", "write `floor.friction.static == 0.4`"),
        ("0.4 < floor.friction.static", 1, "something of the run is wanted", "write `floor.friction.static > 0.4`"),
        ("'exact' == contact.method", 1, "something of the run is wanted", "write `contact.method == 'exact'`"),
        ("1 == 1", 1, "something of the run is wanted", ""),
        ("seed == 1 AND name == 'rest'", 11, "`and`, `or` or the end is wanted here", "in small letters: `and`"),
        ("(seed == 1 Or name == 'rest')", 12, "`and`, `or` or `)` is wanted here", "in small letters: `or`"),
        ("NOT seed == 1", 5, "a comparison is wanted here", "in small letters: `not`"),
        ("seed IN [1]", 6, "a comparison is wanted here", "in small letters: `in`"),
        ("seed == TRUE", 9, "a text stands in quotes", "in small letters: `true`"),
        ("seed in [,]", 10, "a value is wanted here", ""),
        ("", 1, "something of the run is wanted here", "`name`"),
    ] {
        let done = place.runner(&["check", "rest.toml", "slide.toml", "--filter", filter]).exits(2);
        let place = format!("--filter:1:{column}\n");
        for wanted in [message, &place, help] {
            assert!(done.stderr.contains(wanted), "{filter}: no `{wanted}` in\n{}", done.stderr);
        }
        let caret = done.stderr.lines().any(|line| line.trim_start_matches([' ', '|']).starts_with('^'));
        assert!(caret, "{filter}: {}", done.stderr);
    }
}
