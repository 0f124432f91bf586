//! Functions of `math` give the bits of the crate's own functions, however a script calls them.

use super::{ScriptedRun, TASK, pendulum};
use std::fmt::Write;
use stiction::math;
use stiction::sim::{NullObserver, Outcome};

type Call = (&'static str, Box<dyn Fn(f64, f64) -> f64>);

fn unary(name: &'static str, function: fn(f64) -> f64) -> Call {
    (name, Box::new(move |x, _| function(x)))
}

/// Calls in Luau of numbers x and y in (0, 1), and their values.
fn calls() -> Vec<Call> {
    vec![
        unary("math.sin(x)", math::sin),
        unary("math.cos(x)", math::cos),
        unary("math.tan(x)", math::tan),
        unary("math.asin(x)", math::asin),
        unary("math.acos(x)", math::acos),
        unary("math.atan(x)", math::atan),
        unary("math.sinh(x)", math::sinh),
        unary("math.cosh(x)", math::cosh),
        unary("math.tanh(x)", math::tanh),
        unary("math.exp(x)", math::exp),
        unary("math.log(x)", math::ln),
        unary("math.log(x, nil)", math::ln),
        unary("math.log10(x)", math::log10),
        unary("math.log(x, 2)", math::log2),
        unary("math.log(x, 10)", math::log10),
        ("math.log(x, y)", Box::new(|x, y| math::ln(x) / math::ln(y))),
        ("math.atan2(x, y)", Box::new(math::atan2)),
        ("math.pow(x, y)", Box::new(math::powf)),
    ]
}

/// A sequence in (0, 1).
fn number(i: u32) -> f64 {
    (f64::from(i) * 0.618_033_988_749_894_9).fract()
}

#[track_caller]
fn succeeds(script: &str) {
    let (outcome, message) =
        ScriptedRun::new(&pendulum(0.002, "mode = \"position\"", TASK), script).end(&mut NullObserver);
    assert_eq!(outcome, Outcome::Passed, "{message}");
}

#[test]
fn called_with_variables() {
    let mut script = "local function number(i) return i * 0.6180339887498949 % 1 end\n".to_owned();
    for (call, function) in calls() {
        let values: Vec<String> = (1..500).map(|i| format!("{:?}", function(number(i), number(i + 7)))).collect();
        writeln!(
            script,
            "for i, expected in {{{}}} do\nlocal x, y = number(i), number(i + 7)\n\
             if {call} ~= expected then error(`{call} of {{x}}, {{y}}: {{{call}}} is not {{expected}}`) end\nend",
            values.join(", ")
        )
        .unwrap();
    }
    succeeds(&(script + "function run() end"));
}

#[test]
fn called_with_constants_or_under_another_name() {
    let mut script = String::new();
    for (call, function) in calls() {
        let (name, _) = call.split_once('(').unwrap();
        for i in 1..50 {
            let (x, y) = (number(i), number(i + 7));
            // The names of functions have an x and a y as well.
            let arguments = call[name.len()..].replace('x', &format!("{x:?}")).replace('y', &format!("{y:?}"));
            let expected = function(x, y);
            writeln!(script, "if {name}{arguments} ~= {expected:?} then error('{call} {x:?} {y:?}') end").unwrap();
            writeln!(script, "do local f = {name} if f{arguments} ~= {expected:?} then error('local {call}') end end")
                .unwrap();
        }
    }
    succeeds(&(script + "function run() end"));
}

#[test]
fn wrong_arguments_are_named() {
    for (call, expected) in [
        ("math.sin()", "invalid argument #1 to 'sin' (number expected, got nil)"),
        ("math.exp({})", "invalid argument #1 to 'exp' (number expected, got table)"),
        ("math.pow(2, \"x\")", "invalid argument #2 to 'pow' (number expected, got string)"),
        ("math.log(2, true)", "invalid argument #2 to 'log' (number expected, got boolean)"),
    ] {
        let script = format!("function run()\nlocal x = {call}\nend");
        let (outcome, message) =
            ScriptedRun::new(&pendulum(0.01, "mode = \"position\"", TASK), &script).end(&mut NullObserver);
        assert_eq!(outcome, Outcome::Error);
        assert!(message.contains(&format!("s.luau:2: {expected}")), "{message}");
    }
    succeeds("assert(math.sqrt(\"4\") == 2 and math.pow(\"2\", 3) == 8)\nfunction run() end");
}
