//! What messages show of what was written: numbers beyond a limit, dates, keys that are there twice, what is long.

use stiction::scenario::Diagnostic;

use super::{SMALLEST, file, wrong};

/// The first mistake of a text that stands above the smallest scenario, so it begins at line 1.
fn first(text: &str) -> Diagnostic {
    wrong(&format!("{text}\n{SMALLEST}"), &[]).0.swap_remove(0)
}

#[test]
fn numbers_that_are_too_large_are_told_the_limit() {
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
fn a_limit_that_cannot_be_raised_is_told_as_such() {
    let text = format!("{SMALLEST}[sweep]\nrepeat = 4294967295\ngrid = {{ duration = [1, 2] }}\n");
    let help = |most| file(&text).unwrap().expansion(&[], most).err().unwrap().0[0].help.clone().unwrap();
    assert_eq!(help(10_000), "`--max-runs` raises the limit");
    assert_eq!(help(4_294_967_295), "no batch can have more: each run has a number of 32 bits");
}
