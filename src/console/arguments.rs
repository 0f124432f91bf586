//! Splits a line into arguments at blanks outside quotes and brackets. `#` begins a comment.

use crate::console::ConsoleError;

/// Arguments of a line, consumed from the front.
#[derive(Debug)]
pub struct Arguments {
    arguments: Vec<String>,
    next: usize,
}

impl Arguments {
    /// Splits a line.
    pub fn of(line: &str) -> Result<Self, ConsoleError> {
        let (mut arguments, mut argument) = (Vec::new(), String::new());
        let (mut quote, mut open): (Option<char>, Vec<char>) = (None, Vec::new());
        let mut escaped = false;
        // Skip a byte order mark.
        for c in line.trim_start_matches('\u{feff}').chars() {
            match (quote, c) {
                (Some('"'), '\\') if !escaped => {
                    escaped = true;
                    argument.push(c);
                    continue;
                }
                (Some(q), _) if c == q && !escaped => quote = None,
                (Some(_), _) => {}
                (None, '"' | '\'') => quote = Some(c),
                (None, '#') if argument.is_empty() => break,
                (None, '[' | '{') => open.push(if c == '[' { ']' } else { '}' }),
                (None, ']' | '}') if open.pop() != Some(c) => {
                    return Err(ConsoleError::usage(format!("`{c}` has no opening bracket")));
                }
                (None, _) if c.is_whitespace() && open.is_empty() => {
                    if !argument.is_empty() {
                        arguments.push(std::mem::take(&mut argument));
                    }
                    continue;
                }
                _ => {}
            }
            escaped = false;
            argument.push(c);
        }
        if let Some(missing) = quote.or(open.pop()) {
            return Err(ConsoleError::usage(format!("`{missing}` is missing at the end")));
        }
        if !argument.is_empty() {
            arguments.push(argument);
        }
        Ok(Arguments { arguments, next: 0 })
    }

    /// Takes the next argument, without its quotes if they enclose all of it.
    pub fn next(&mut self) -> Option<&str> {
        let argument = self.arguments.get(self.next)?;
        self.next += 1;
        Some(unquoted(argument))
    }

    /// The next argument, not consumed.
    pub fn peek(&self) -> Option<&str> {
        self.arguments.get(self.next).map(|argument| unquoted(argument))
    }

    /// Takes the next argument if it equals `keyword`.
    pub fn take(&mut self, keyword: &str) -> bool {
        let found = self.peek() == Some(keyword);
        self.next += usize::from(found);
        found
    }

    /// Takes the next argument, named `what` in the error text.
    pub fn need(&mut self, what: &str) -> Result<&str, ConsoleError> {
        self.next().ok_or_else(|| ConsoleError::usage(format!("{what} is missing")))
    }

    /// Takes the next argument, a finite number.
    pub fn number(&mut self, what: &str) -> Result<f64, ConsoleError> {
        let text = self.need(what)?;
        number(text).ok_or_else(|| ConsoleError::usage(format!("{what} must be a number, not `{text}`")))
    }

    /// Takes the next argument if it is a finite number.
    pub fn some_number(&mut self) -> Option<f64> {
        let found = number(self.peek()?)?;
        self.next += 1;
        Some(found)
    }

    /// Takes three numbers.
    pub fn vector(&mut self, what: &str) -> Result<[f64; 3], ConsoleError> {
        Ok([self.number(what)?, self.number(what)?, self.number(what)?])
    }

    /// Takes the remaining arguments, with their quotes.
    pub fn rest(&mut self) -> Vec<String> {
        let rest = self.arguments[self.next..].to_vec();
        self.next = self.arguments.len();
        rest
    }

    /// Takes the remaining arguments as `KEY=VALUE`: dotted keys and TOML values; a value that is
    /// not TOML is a string.
    pub fn assignments(&mut self) -> Result<Vec<(String, toml::Value)>, ConsoleError> {
        let parse = |text: String| crate::scenario::parse_override(&text).map_err(ConsoleError::usage);
        self.rest().into_iter().map(parse).collect()
    }

    /// Error if arguments remain.
    pub fn done(&mut self) -> Result<(), ConsoleError> {
        match self.next() {
            None => Ok(()),
            Some(argument) => Err(ConsoleError::usage(format!("unexpected argument `{argument}`"))),
        }
    }
}

fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

/// Removes quotes that enclose a whole argument.
fn unquoted(argument: &str) -> &str {
    let quoted = |q: char| argument.strip_prefix(q).and_then(|rest| rest.strip_suffix(q));
    let whole = |inner: &&str| !inner.contains(['"', '\'']);
    quoted('"').or_else(|| quoted('\'')).filter(whole).unwrap_or(argument)
}

/// Segments of a dotted TOML key.
pub fn segments(key: &str) -> Result<Vec<String>, ConsoleError> {
    let wrong = || ConsoleError::usage(format!("`{key}` is not a dotted key"));
    let mut table = format!("{key} = 0").parse::<toml::Table>().map_err(|_| wrong())?;
    let mut segments = Vec::new();
    loop {
        let (segment, value) = table.into_iter().next().ok_or_else(wrong)?;
        segments.push(segment);
        match value {
            toml::Value::Table(inner) => table = inner,
            _ => return Ok(segments),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(line: &str) -> Vec<String> {
        Arguments::of(line).unwrap().rest()
    }

    #[test]
    fn blanks_in_quotes_and_brackets_do_not_split_arguments() {
        assert_eq!(split("  set a=1\tb = # 2"), ["set", "a=1", "b", "="]);
        assert_eq!(
            split("start sine joints={ a = { amplitude = 1 } } x"),
            ["start", "sine", "joints={ a = { amplitude = 1 } }", "x"]
        );
        assert_eq!(split(r#"load "a b#c.mcap" 'it"s'"#), ["load", "\"a b#c.mcap\"", "'it\"s'"]);
        assert_eq!(split(r#"x="a \" b" y"#), [r#"x="a \" b""#, "y"]);
        assert!(Arguments::of("a [1, 2").is_err() && Arguments::of("a }").is_err() && Arguments::of("\"a").is_err());
    }

    #[test]
    fn arguments_are_taken_in_order() {
        let mut args = Arguments::of("push \"left foot\" 1 -2e1 .5 for 0.1").unwrap();
        assert_eq!(args.next(), Some("push"));
        assert_eq!(args.next(), Some("left foot"));
        assert_eq!(args.vector("force").unwrap(), [1.0, -20.0, 0.5]);
        assert!(!args.take("at") && args.take("for"));
        assert_eq!(args.some_number(), Some(0.1));
        assert!(args.done().is_ok() && args.number("x").is_err());
    }

    #[test]
    fn dotted_keys_are_split_as_in_toml() {
        assert_eq!(segments("a.\"b c\".d").unwrap(), ["a", "b c", "d"]);
        assert!(segments("a b").is_err() && segments("").is_err());
    }
}
