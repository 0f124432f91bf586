//! Values in messages: numbers beyond a limit, dates, duplicate keys, long texts.

use stiction::scenario::{Diagnostic, load, parse};

use super::{SMALLEST, file, wrong};

/// The first error of a text placed before the smallest scenario, so it begins at line 1.
fn first(text: &str) -> Diagnostic {
    wrong(&format!("{text}\n{SMALLEST}"), &[]).0.swap_remove(0)
}

#[test]
fn a_number_that_is_too_large_is_reported_with_the_limit() {
    for (text, message) in [
        ("sweep.repeat = 4294967296", "`sweep.repeat` must be at most 4294967295, not 4294967296"),
        ("sweep.repeat = 9223372036854775807", "`sweep.repeat` must be at most 4294967295, not 9223372036854775807"),
        (
            "sweep.grid.seed = { linspace = [0, 1, 9223372036854775807] }",
            "`sweep.grid.seed.linspace.2` must be at most 4294967295, not 9223372036854775807",
        ),
        ("sweep.repeat = -1", "`sweep.repeat` must be a whole number that is not negative, not the number -1"),
    ] {
        assert_eq!(first(text).message, message);
    }
}

#[test]
fn whole_numbers_with_a_point_are_shown_with_it() {
    let found = first("seed = 1.0");
    assert_eq!(found.message, "`seed` must be a whole number that is not negative, not the number 1.0");
    assert_eq!(found.help.as_deref(), Some("write it without a decimal point: 1"));
    assert_eq!(first("seed = 1.5").help, None);
    assert_eq!(first("schema = 1.0").message, "`schema` must be 1, not the number 1.0");
    assert_eq!(first("description = 3.0").message, "`description` must be a string, not the number 3.0");
}

#[test]
fn the_fixed_limit_of_runs_has_its_own_help() {
    let text = format!("{SMALLEST}[sweep]\nrepeat = 4294967295\ngrid = {{ duration = [1, 2] }}\n");
    let help = |most| file(&text).unwrap().expansion(&[], most).err().unwrap().0[0].help.clone().unwrap();
    assert_eq!(help(10_000), "`--max-runs` raises the limit");
    assert_eq!(help(4_294_967_295), "no batch can have more: each run has a number of 32 bits");
}

#[test]
fn dates_are_named_as_dates() {
    for (text, message) in [
        ("duration = 1979-05-27T07:32:00Z", "`duration` must be a number, not the date or time 1979-05-27T07:32:00Z"),
        ("seed = 07:32:00", "must be a whole number that is not negative, not the date or time 07:32:00"),
        ("gravity = [0, 0, 1979-05-27]", "`gravity.2` must be a number, not the date or time 1979-05-27"),
        ("gravity = 07:32:00", "`gravity` must be an array of length 3, not the date or time 07:32:00"),
        ("stop = 1979-05-27", "`stop` must be a table, not the date or time 1979-05-27"),
        ("contact.method = 1979-05-27", ", not the date or time 1979-05-27"),
    ] {
        let found = first(text);
        assert!(found.message.contains(message), "{found}");
    }
}

#[test]
fn a_key_of_too_many_parts_has_a_line() {
    let deep = vec!["a"; 100_000].join(".");
    let found = file(&format!("duration = 1\n{deep} = 1\n")).unwrap_err();
    assert_eq!(found.0[0].message, "a dotted key has more than 80 parts");
    assert_eq!(found.0[0].location(), "scenarios/test.toml:2:1");
    assert!(found.to_string().len() < 1000, "{found}");
}

#[test]
fn a_duplicate_key_is_reported_with_the_first() {
    for (text, key, at, help) in [
        ("[floor]\nheight = 1\nheight = 2\n", "floor.height", (3, 1), "the first is on line 2; keep one of them"),
        ("[floor]\n[log]\n[floor]\n", "floor", (3, 2), "the first is on line 1; keep one of them"),
        (
            "sweep = { grid = { \"floor.height\" = [1], \"floor.height\" = [2] } }\n",
            "sweep.grid.\"floor.height\"",
            (1, 42),
            "the first is on line 1; keep one of them",
        ),
    ] {
        let found = file(text).unwrap_err().0.swap_remove(0);
        let place = found.position.unwrap();
        assert_eq!((place.line, place.column), at, "{found}");
        assert_eq!(found.message, format!("duplicate key `{key}`"), "{found}");
        assert_eq!(found.help.as_deref(), Some(help));
        assert_eq!(found.key().as_deref(), Some(key), "{found}");
    }
    // With any number of duplicates, the file is searched a bounded number of times.
    let many = "k = 1\n".repeat(100_000);
    let found = file(&many).unwrap_err();
    assert_eq!(found.0[199].message, "duplicate key `k`");
}

#[test]
fn long_keys_are_shortened() {
    let long = "k".repeat(1 << 18);
    for text in [format!("{long} = 1"), format!("contact.method = \"{long}\""), format!("duration = \"{long}\"")] {
        let found = first(&text);
        let shown = found.to_string();
        assert!(shown.len() < 3000 && shown.contains("kkk…kkk"), "{} bytes", shown.len());
        assert_eq!(found.location().split(':').nth(1), Some("1"));
    }
    let found = file(&format!("[floor]\n{long} = 1\n{long} = 1\n")).unwrap_err();
    assert!(found.to_string().len() < 3000 && found.0[0].message.contains("floor.kkk"));
    // A path that the user has to find is shown in full.
    let path = format!("{}/none.toml", "folder/".repeat(40));
    assert!(load(path.as_ref()).unwrap_err().to_string().contains(&path));
    assert!(parse(path.as_ref(), "x").unwrap_err().to_string().contains(&path));
}
