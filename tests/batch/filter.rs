//! Tests of the `--filter` language against an independent evaluation of the same expressions, and
//! against random text.

use std::path::Path;

use proptest::prelude::*;
use stiction::batch::{Filter, Selection};
use stiction::scenario::{Run, parse};

/// Runs with different whole numbers, fractions and texts.
const SCENARIO: &str = r#"
[robot]
model = "none.toml"
[[task]]
type = "posture"
joints = { knee = 0.1 }
[sweep.grid]
"contact.method" = ["exact", "one-step"]
"task.0.duration" = [0.25, 1.0, 2.0]
seed = [1, 7, 40]
"#;

fn runs() -> Vec<Run> {
    parse(Path::new("push-left.toml"), SCENARIO).unwrap().expand(&[]).unwrap()
}

/// A key in the format of the program, but not that of the run.
fn key(run: &Run) -> String {
    format!("{:016x}", (run.index as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

/// A filter expression, independent of that of the library.
#[derive(Clone, Debug)]
enum Tree {
    Leaf(&'static str, &'static str, Vec<Value>),
    Not(Box<Tree>),
    And(Box<Tree>, Box<Tree>),
    Or(Box<Tree>, Box<Tree>),
}

#[derive(Clone, Debug, PartialEq)]
enum Value {
    Number(f64),
    Text(String),
}

impl Tree {
    fn write(&self) -> String {
        match self {
            Tree::Leaf(subject, "in", values) => {
                format!("{subject} in [{}]", values.iter().map(Value::write).collect::<Vec<_>>().join(","))
            }
            Tree::Leaf(subject, sign, values) => format!("{subject}{sign}{}", values[0].write()),
            Tree::Not(a) => format!("not ({})", a.write()),
            // No brackets on the left: operators associate to the left, and `and` binds before
            // `or`.
            Tree::And(a, b) => format!("{} and ({})", a.bracketed_or(), b.write()),
            Tree::Or(a, b) => format!("{} or ({})", a.write(), b.write()),
        }
    }

    fn bracketed_or(&self) -> String {
        if matches!(self, Tree::Or(..)) { format!("({})", self.write()) } else { self.write() }
    }

    fn holds(&self, run: &Run) -> bool {
        match self {
            Tree::Leaf(subject, sign, values) => {
                let found = value_of(run, subject);
                match (*sign, &found, &values[0]) {
                    ("in", found, _) => values.contains(found),
                    ("==", found, expected) => found == expected,
                    ("!=", found, expected) => found != expected,
                    ("^=", Value::Text(found), Value::Text(expected)) => found.starts_with(expected),
                    ("~", Value::Text(found), Value::Text(expected)) => matches_pattern(expected, found),
                    ("!~", Value::Text(found), Value::Text(expected)) => !matches_pattern(expected, found),
                    ("<", Value::Number(found), Value::Number(expected)) => found < expected,
                    ("<=", Value::Number(found), Value::Number(expected)) => found <= expected,
                    (">", Value::Number(found), Value::Number(expected)) => found > expected,
                    (">=", Value::Number(found), Value::Number(expected)) => found >= expected,
                    other => panic!("{other:?}"),
                }
            }
            Tree::Not(a) => !a.holds(run),
            Tree::And(a, b) => a.holds(run) && b.holds(run),
            Tree::Or(a, b) => a.holds(run) || b.holds(run),
        }
    }
}

impl Value {
    fn write(&self) -> String {
        match self {
            Value::Number(x) => format!("{x:?}"),
            Value::Text(text) => format!("'{text}'"),
        }
    }
}

/// Recursive pattern matching: `*` matches nothing or one more character.
fn matches_pattern(pattern: &str, text: &str) -> bool {
    match (pattern.chars().next(), text.chars().next()) {
        (None, None) => true,
        (Some('*'), None) => matches_pattern(&pattern[1..], text),
        (Some('*'), Some(_)) => matches_pattern(&pattern[1..], text) || matches_pattern(pattern, &text[1..]),
        (Some('?'), Some(_)) => matches_pattern(&pattern[1..], &text[1..]),
        (Some(p), Some(t)) => p == t && matches_pattern(&pattern[1..], &text[1..]),
        _ => false,
    }
}

fn value_of(run: &Run, subject: &str) -> Value {
    let scenario = &run.scenario;
    match subject {
        "name" => Value::Text(run.name.clone()),
        "key" => Value::Text(key(run)),
        "contact.method" => Value::Text(scenario.contact.method.name().into()),
        "seed" => Value::Number(scenario.seed as f64),
        "task.0.duration" => {
            let (_, swept) = run.parameters.iter().find(|(name, _)| name == "task.0.duration").unwrap();
            Value::Number(swept.as_float().unwrap())
        }
        other => panic!("{other}"),
    }
}

fn leaf() -> impl Strategy<Value = Tree> {
    let texts = prop_oneof![
        prop::sample::select(vec!["exact", "one-step", "push-left", "push", "*", "*e*", "?xact", "9", "*7?c15", ""])
            .prop_map(str::to_owned),
        "[a-f0-9*?-]{0,3}",
    ];
    let numbers = prop_oneof![prop::sample::select(vec![0.25, 1.0, 2.0, 7.0, 40.0, 0.0]), -3.0..50.0];
    let texts = texts.prop_map(Value::Text).boxed();
    let text_leaf = (
        prop::sample::select(vec!["name", "key"]),
        prop::sample::select(vec!["==", "!=", "~", "!~", "^=", "in"]),
        prop::collection::vec(texts.clone(), 1..4),
    );
    let method_pattern_leaf =
        (Just("contact.method"), prop::sample::select(vec!["~", "!~", "^="]), prop::collection::vec(texts, 1..4));
    let number_leaf = (
        prop::sample::select(vec!["seed", "task.0.duration"]),
        prop::sample::select(vec!["==", "!=", "<", "<=", ">", ">=", "in"]),
        prop::collection::vec(numbers.prop_map(Value::Number), 1..4),
    );
    // Other values of `contact.method` are errors.
    let method =
        prop::sample::select(vec!["exact", "one-step", "penalty", "lcp", "ncp"]).prop_map(|w| Value::Text(w.into()));
    let method_name_leaf =
        (Just("contact.method"), prop::sample::select(vec!["==", "!=", "in"]), prop::collection::vec(method, 1..4));
    prop_oneof![text_leaf, method_pattern_leaf, method_name_leaf, number_leaf]
        .prop_map(|(subject, sign, values)| Tree::Leaf(subject, sign, values))
}

fn tree() -> impl Strategy<Value = Tree> {
    leaf().prop_recursive(5, 24, 2, |inner| {
        prop_oneof![
            inner.clone().prop_map(|a| Tree::Not(Box::new(a))),
            (inner.clone(), inner.clone()).prop_map(|(a, b)| Tree::And(Box::new(a), Box::new(b))),
            (inner.clone(), inner).prop_map(|(a, b)| Tree::Or(Box::new(a), Box::new(b))),
        ]
    })
}

fn selected(filter: &Filter, runs: &[Run]) -> Vec<usize> {
    let mut selection = Selection::new(filter);
    let taken = runs.iter().filter(|run| selection.takes(run, &key(run))).map(|run| run.index).collect();
    selection.end().unwrap();
    taken
}

proptest! {
    #[test]
    fn filters_agree_with_an_independent_evaluation(tree in tree()) {
        let runs = runs();
        let filter = Filter::parse(&tree.write()).unwrap();
        let expected: Vec<usize> = runs.iter().filter(|run| tree.holds(run)).map(|run| run.index).collect();
        prop_assert_eq!(selected(&filter, &runs), expected, "{}", tree.write());
    }

    #[test]
    fn a_printed_filter_parses_to_the_same_filter(tree in tree()) {
        let filter = Filter::parse(&tree.write()).unwrap();
        let again = Filter::parse(&filter.to_string()).unwrap();
        prop_assert_eq!(again.to_string(), filter.to_string());
        let runs = runs();
        prop_assert_eq!(selected(&again, &runs), selected(&filter, &runs));
    }

    #[test]
    fn errors_have_a_position_within_the_text(text in "\\PC{0,40}|[ ()!~=<>^&|\\[\\],.\"'\\\\a-z0-9-]{0,60}") {
        if let Err(error) = Filter::parse(&text) {
            let position = error.position.unwrap();
            prop_assert!(position.column <= text.chars().count() + 1, "{position:?} in {text:?}");
        }
    }
}

#[test]
fn operators_have_the_documented_precedence() {
    let read = |text: &str| Filter::parse(text).unwrap().to_string();
    let (a, b, c) = ("seed == 1", "seed == 2", "seed == 3");
    assert_eq!(read("seed==1 or seed==2 and seed==3"), format!("({a} or ({b} and {c}))"));
    assert_eq!(read("not seed==1 and seed==2"), format!("(not {a} and {b})"));
    assert_eq!(read("not (seed==1 and !seed==2)"), format!("not ({a} and not {b})"));
    assert_eq!(read("seed==1 || seed==2 && seed==3"), format!("({a} or ({b} and {c}))"));
    assert_eq!(read("seed==1 and seed==2 and seed==3"), format!("({a} and {b} and {c})"));
    assert_eq!(read(r#"key != "a\"b\\c""#), r#"key != 'a"b\c'"#);
    assert_eq!(read(r#"a == "it's \"so\"""#), r#"a == "it's \"so\"""#);
    assert_eq!(read(r#""name" in [1, 2.5, 3,]"#), r#""name" in [1, 2.5, 3]"#, "a parameter in quotes");
    // Patterns keep escaped characters, in either notation.
    assert_eq!(read(r#"name ~ "a\*\"b*""#), r#"name ~ "a\*\"b*""#);
    assert_eq!(read(r#"name !~ 'a\*"b*'"#), r#"name !~ "a\\*\"b*""#);
    assert_eq!(read(r#"robot.joint."l.knee".kp > -1e-3"#), r#"robot.joint."l.knee".kp > -0.001"#);
}

#[test]
fn long_filters_are_accepted_and_deep_nesting_is_refused() {
    let long = "seed == 1 or ".repeat(100_000) + "seed == 2";
    assert_eq!(selected(&Filter::parse(&long).unwrap(), &runs()[..3]), [0]);
    for opening in ["(", "not ", "!"] {
        let error = Filter::parse(&opening.repeat(100_000)).unwrap_err();
        assert!(error.message.contains("nested brackets"), "{}", error.message);
    }
}
