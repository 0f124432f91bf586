//! The language of `--filter` against a second, plain evaluation of the same trees, and against noise.

use std::path::Path;

use proptest::prelude::*;
use stiction::batch::{Filter, Selection};
use stiction::scenario::{Run, parse};

/// Runs that differ in numbers, whole and not, in texts and in flags.
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

/// A key as those that programs give: it need not be the run's.
fn key(run: &Run) -> String {
    format!("{:016x}", (run.index as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

/// An expression as a tree of its own.
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
            // Without brackets on the left: both are read from the left, and `and` before `or`.
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
                let seen = subject_of(run, subject);
                match (*sign, &seen, &values[0]) {
                    ("in", seen, _) => values.contains(seen),
                    ("==", seen, wanted) => seen == wanted,
                    ("!=", seen, wanted) => seen != wanted,
                    ("^=", Value::Text(seen), Value::Text(wanted)) => seen.starts_with(wanted),
                    ("~", Value::Text(seen), Value::Text(wanted)) => like(wanted, seen),
                    ("!~", Value::Text(seen), Value::Text(wanted)) => !like(wanted, seen),
                    ("<", Value::Number(seen), Value::Number(wanted)) => seen < wanted,
                    ("<=", Value::Number(seen), Value::Number(wanted)) => seen <= wanted,
                    (">", Value::Number(seen), Value::Number(wanted)) => seen > wanted,
                    (">=", Value::Number(seen), Value::Number(wanted)) => seen >= wanted,
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

/// The slow way to a pattern: `*` takes nothing or one more character.
fn like(pattern: &str, text: &str) -> bool {
    match (pattern.chars().next(), text.chars().next()) {
        (None, None) => true,
        (Some('*'), None) => like(&pattern[1..], text),
        (Some('*'), Some(_)) => like(&pattern[1..], text) || like(pattern, &text[1..]),
        (Some('?'), Some(_)) => like(&pattern[1..], &text[1..]),
        (Some(p), Some(t)) => p == t && like(&pattern[1..], &text[1..]),
        _ => false,
    }
}

fn subject_of(run: &Run, subject: &str) -> Value {
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
    let method_leaf =
        (Just("contact.method"), prop::sample::select(vec!["~", "!~", "^="]), prop::collection::vec(texts, 1..4));
    let number_leaf = (
        prop::sample::select(vec!["seed", "task.0.duration"]),
        prop::sample::select(vec!["==", "!=", "<", "<=", ">", ">=", "in"]),
        prop::collection::vec(numbers.prop_map(Value::Number), 1..4),
    );
    // Only words that may stand there are no mistakes.
    let word =
        prop::sample::select(vec!["exact", "one-step", "penalty", "lcp", "ncp"]).prop_map(|w| Value::Text(w.into()));
    let word_leaf =
        (Just("contact.method"), prop::sample::select(vec!["==", "!=", "in"]), prop::collection::vec(word, 1..4));
    prop_oneof![text_leaf, method_leaf, word_leaf, number_leaf]
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
    fn it_selects_what_a_plain_evaluation_selects(tree in tree()) {
        let runs = runs();
        let filter = Filter::parse(&tree.write()).unwrap();
        let wanted: Vec<usize> = runs.iter().filter(|run| tree.holds(run)).map(|run| run.index).collect();
        prop_assert_eq!(selected(&filter, &runs), wanted, "{}", tree.write());
    }

    #[test]
    fn what_it_understood_reads_back_to_the_same(tree in tree()) {
        let filter = Filter::parse(&tree.write()).unwrap();
        let again = Filter::parse(&filter.to_string()).unwrap();
        prop_assert_eq!(again.to_string(), filter.to_string());
        let runs = runs();
        prop_assert_eq!(selected(&again, &runs), selected(&filter, &runs));
    }

    #[test]
    fn no_text_breaks_it(text in "\\PC{0,40}|[ ()!~=<>^&|\\[\\],.\"'\\\\a-z0-9-]{0,60}") {
        if let Err(wrong) = Filter::parse(&text) {
            let place = wrong.position.unwrap();
            prop_assert!(place.column <= text.chars().count() + 1, "{place:?} in {text:?}");
        }
    }
}

#[test]
fn it_binds_as_written() {
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
    // Patterns keep what means itself, however it was written.
    assert_eq!(read(r#"name ~ "a\*\"b*""#), r#"name ~ "a\*\"b*""#);
    assert_eq!(read(r#"name !~ 'a\*"b*'"#), r#"name !~ "a\\*\"b*""#);
    assert_eq!(read(r#"robot.joint."l.knee".kp > -1e-3"#), r#"robot.joint."l.knee".kp > -0.001"#);
}

#[test]
fn neither_length_nor_depth_is_too_much() {
    let long = "seed == 1 or ".repeat(100_000) + "seed == 2";
    assert_eq!(selected(&Filter::parse(&long).unwrap(), &runs()[..3]), [0]);
    for opening in ["(", "not ", "!"] {
        let wrong = Filter::parse(&opening.repeat(100_000)).unwrap_err();
        assert!(wrong.message.contains("inside each other"), "{}", wrong.message);
    }
}
