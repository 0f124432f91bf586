//! Parses filter expressions.

use std::ops::Range;

use super::expression::{Comparison, Expression, Relation, Subject};
use super::literal::{is_bare, kind, quoted, same_kind};
use crate::results::ParamValue;
use crate::scenario::Diagnostic;

/// Maximum nesting of brackets and negations, which bounds the stack.
const MAX_DEPTH: usize = 100;

/// Help for a keyword in capitals.
const LOWER_CASE: &str = "write it in lower case: `?`";

type Parsed<T> = Result<T, Box<Diagnostic>>;

/// A parsed value and its position.
struct Written {
    value: ParamValue,
    /// A text as a pattern, with `\` before literal characters.
    pattern: Option<String>,
    at: Range<usize>,
}

/// Parses a whole text.
pub(super) fn parse(text: &str) -> Parsed<Expression> {
    let mut parser = Parser { text, at: 0, depth: 0, comparisons: 0 };
    let expression = parser.any()?;
    match parser.rest() {
        "" => Ok(expression),
        rest if rest.starts_with(')') => Err(parser.wrong("this bracket has no opening one", None)),
        _ => {
            let help = parser.lower_case_help(&["and", "or"]);
            Err(parser.wrong("expected `and`, `or` or the end", help))
        }
    }
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
    comparisons: usize,
}

impl<'a> Parser<'a> {
    fn any(&mut self) -> Parsed<Expression> {
        let first = self.all()?;
        let mut any = vec![first];
        while self.keyword("or") || self.sign("||") {
            any.push(self.all()?);
        }
        Ok(if any.len() == 1 { any.remove(0) } else { Expression::Any(any) })
    }

    fn all(&mut self) -> Parsed<Expression> {
        let first = self.one()?;
        let mut all = vec![first];
        while self.keyword("and") || self.sign("&&") {
            all.push(self.one()?);
        }
        Ok(if all.len() == 1 { all.remove(0) } else { Expression::All(all) })
    }

    fn one(&mut self) -> Parsed<Expression> {
        if self.depth == MAX_DEPTH {
            return Err(self.wrong(format!("more than {MAX_DEPTH} nested brackets and negations"), None));
        }
        self.depth += 1;
        let one = self.bracket_or_comparison();
        self.depth -= 1;
        one
    }

    fn bracket_or_comparison(&mut self) -> Parsed<Expression> {
        if self.keyword("not") || (!self.rest().starts_with("!=") && !self.rest().starts_with("!~") && self.sign("!")) {
            return Ok(Expression::Not(Box::new(self.one()?)));
        }
        let open = self.here();
        if !self.sign("(") {
            return self.comparison();
        }
        let inner = self.any()?;
        if self.sign(")") {
            return Ok(inner);
        }
        if self.rest().is_empty() {
            return Err(super::error(self.text, open, "this bracket is not closed", None));
        }
        let help = self.lower_case_help(&["and", "or"]);
        Err(self.wrong("expected `and`, `or` or `)`", help))
    }

    fn comparison(&mut self) -> Parsed<Expression> {
        self.blanks();
        let start = self.at;
        let subject = self.subject()?;
        let at = start..self.at;
        let relation = self.relation(&at)?;
        self.blanks();
        let start = self.at;
        let values = if relation == Relation::In { self.list() } else { self.value().map(|value| vec![value]) };
        if let Some(error) = self.swapped_sides(&at, relation, start, values.is_err()) {
            return Err(error);
        }
        let values = values?;
        let expected_at = start..self.at;
        if let Some(other) = values.iter().find(|other| !same_kind(&other.value, &values[0].value)) {
            let (this, first) = (kind(&other.value), kind(&values[0].value));
            let help = "all values of a list must be of one kind".to_owned();
            let message = format!("{this}, but the list begins with {first}");
            return Err(super::error(self.text, other.at.clone(), message, Some(help)));
        }
        let values_at = values.iter().map(|value| value.at.clone()).collect();
        let written = |written: Written| match written.pattern {
            Some(pattern) if relation.takes_pattern() => ParamValue::Text(pattern),
            _ => written.value,
        };
        let expected: Vec<ParamValue> = values.into_iter().map(written).collect();
        let fits = |value: &ParamValue| match value {
            ParamValue::Text(_) => !relation.needs_numbers(),
            ParamValue::Integer(_) | ParamValue::Number(_) => !relation.needs_texts(),
            ParamValue::Flag(_) => !relation.needs_numbers() && !relation.needs_texts(),
        };
        if !expected.iter().all(fits) {
            let kind = if relation.needs_numbers() { "a number" } else { "a text in quotes" };
            return Err(super::error(self.text, expected_at, format!("expected {kind}"), None));
        }
        let index = self.comparisons;
        self.comparisons += 1;
        Ok(Expression::Comparison(index, Comparison { subject, relation, expected, at, expected_at, values_at }))
    }

    /// Detects swapped sides, as in `0.4 == floor.friction`: no path at `left` and one at `right`,
    /// or numbers on both sides. A quoted text may be a path, unless the right side is wrong.
    fn swapped_sides(
        &self,
        left: &Range<usize>,
        relation: Relation,
        right: usize,
        wrong: bool,
    ) -> Option<Box<Diagnostic>> {
        let word = &self.text[left.clone()];
        let is_number = word.starts_with(|c: char| c.is_ascii_digit() || c == '-') && word.parse::<f64>().is_ok();
        let is_value = is_number || (wrong && (word.starts_with(['"', '\'']) || ["true", "false"].contains(&word)));
        let rest = &self.text[right..];
        let path = &rest[..rest.find(|c| !is_bare(c) && c != '.').unwrap_or(rest.len())];
        let is_path = path.starts_with(char::is_alphabetic) && !["true", "false"].contains(&path);
        if !(is_number || is_value && is_path) {
            return None;
        }
        let help = relation.swapped().filter(|_| is_path).map(|sign| format!("write `{path} {sign} {word}`"));
        Some(super::error(self.text, left.clone(), "expected a property of the run on the left side", help))
    }

    fn subject(&mut self) -> Parsed<Subject> {
        let mut path = Vec::new();
        let is_quoted = self.text[self.at..].starts_with(['"', '\'']);
        loop {
            path.push(match self.text[self.at..].chars().next() {
                Some('"' | '\'') => self.string()?.0,
                Some(c) if is_bare(c) => self.take_while(is_bare).to_owned(),
                _ if path.is_empty() => {
                    let help = "such as `name`, `key` or `contact.method`".to_owned();
                    return Err(self.wrong("expected a property of the run", Some(help)));
                }
                _ => return Err(self.wrong("expected the rest of the path", None)),
            });
            if !self.text[self.at..].starts_with('.') {
                break;
            }
            self.at += 1;
        }
        Ok(match path.as_slice() {
            [word] if word == "name" && !is_quoted => Subject::Name,
            [word] if word == "key" && !is_quoted => Subject::Key,
            _ => Subject::Parameter(path),
        })
    }

    fn relation(&mut self, subject: &Range<usize>) -> Parsed<Relation> {
        if self.keyword("in") {
            return Ok(Relation::In);
        }
        self.blanks();
        match Relation::SIGNS.iter().find(|(sign, _)| self.rest().starts_with(sign)) {
            Some((sign, relation)) => {
                self.at += sign.len();
                Ok(*relation)
            }
            None => {
                let help = match self.rest().starts_with('=') {
                    true => "equal is `==`".to_owned(),
                    false if self.text[subject.clone()].eq_ignore_ascii_case("not") => LOWER_CASE.replace('?', "not"),
                    false => {
                        self.lower_case_help(&["in"]).unwrap_or_else(|| "one of == != < <= > >= ~ !~ ^= in".to_owned())
                    }
                };
                Err(self.wrong("expected a comparison operator", Some(help)))
            }
        }
    }

    fn list(&mut self) -> Parsed<Vec<Written>> {
        if !self.sign("[") {
            return Err(self.wrong("expected a list such as [1, 2]", None));
        }
        let mut values = vec![self.value()?];
        // As in TOML, a comma may follow the last one.
        while self.sign(",") && !self.rest().starts_with(']') {
            values.push(self.value()?);
        }
        if self.sign("]") { Ok(values) } else { Err(self.wrong("expected `,` or `]`", None)) }
    }

    fn value(&mut self) -> Parsed<Written> {
        self.blanks();
        let start = self.at;
        if self.rest().starts_with(['"', '\'']) {
            let (text, pattern) = self.string()?;
            return Ok(Written { value: ParamValue::Text(text), pattern: Some(pattern), at: start..self.at });
        }
        let value = self.plain(start)?;
        Ok(Written { value, pattern: None, at: start..self.at })
    }

    /// A number or a flag.
    fn plain(&mut self, start: usize) -> Parsed<ParamValue> {
        let word = self.take_while(|c| is_bare(c) || c == '.' || c == '+');
        let wrong = |message: &str, help: Option<String>| super::error(self.text, start..self.at, message, help);
        match word {
            "true" => return Ok(ParamValue::Flag(true)),
            "false" => return Ok(ParamValue::Flag(false)),
            "" => {
                self.at = start;
                return Err(self.wrong("expected a value", Some("a number, or a text in quotes".into())));
            }
            _ => {}
        }
        if let Ok(integer) = word.parse::<i64>() {
            return Ok(ParamValue::Integer(integer));
        }
        match word.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(ParamValue::Number(number)),
            Ok(_) => Err(wrong("expected a finite number", None)),
            Err(_) if word.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) => {
                Err(wrong("not a number", None))
            }
            Err(_) if ["true", "false"].iter().any(|flag| word.eq_ignore_ascii_case(flag)) => {
                Err(wrong("expected text in quotes", Some(LOWER_CASE.replace('?', &word.to_ascii_lowercase()))))
            }
            Err(_) => Err(wrong("expected text in quotes", Some(format!("write {}", quoted(word))))),
        }
    }

    /// Parses a quoted text and its pattern; after `\` in double quotes a character is literal.
    fn string(&mut self) -> Parsed<(String, String)> {
        let start = self.at;
        let mut characters = self.text[start..].char_indices();
        let quote = characters.next().map_or('"', |(_, c)| c);
        let (mut out, mut pattern) = (String::new(), String::new());
        while let Some((i, c)) = characters.next() {
            match c {
                c if c == quote => {
                    self.at = start + i + c.len_utf8();
                    return Ok((out, pattern));
                }
                '\\' if quote == '"' => {
                    if let Some((_, c)) = characters.next() {
                        out.push(c);
                        pattern.extend(['\\', c]);
                    }
                }
                c => {
                    out.push(c);
                    // Keeps the pattern valid in double quotes.
                    pattern.extend(['"', '\\'].contains(&c).then_some('\\').into_iter().chain([c]));
                }
            }
        }
        Err(super::error(self.text, start..self.text.len(), "this text is not closed", None))
    }

    /// Skips blanks and returns the rest of the text.
    fn rest(&mut self) -> &'a str {
        self.blanks();
        &self.text[self.at..]
    }

    fn blanks(&mut self) {
        self.take_while(char::is_whitespace);
    }

    fn take_while(&mut self, accept: impl Fn(char) -> bool) -> &'a str {
        let rest = &self.text[self.at..];
        let length = rest.find(|c| !accept(c)).unwrap_or(rest.len());
        self.at += length;
        &rest[..length]
    }

    fn sign(&mut self, sign: &str) -> bool {
        let found = self.rest().starts_with(sign);
        self.at += if found { sign.len() } else { 0 };
        found
    }

    /// Consumes a keyword, not the beginning of a longer word or path.
    fn keyword(&mut self, keyword: &str) -> bool {
        let after = self.rest().strip_prefix(keyword);
        let found = after.is_some_and(|rest| !rest.starts_with(|c| is_bare(c) || c == '.'));
        self.at += if found { keyword.len() } else { 0 };
        found
    }

    /// Help if one of these keywords is written in capitals.
    fn lower_case_help(&mut self, keywords: &[&str]) -> Option<String> {
        let rest = self.rest();
        let word = &rest[..rest.find(|c| !is_bare(c)).unwrap_or(rest.len())];
        keywords
            .iter()
            .find(|keyword| word.eq_ignore_ascii_case(keyword))
            .map(|keyword| LOWER_CASE.replace('?', keyword))
    }

    /// Range of the next character, or the end of the text.
    fn here(&mut self) -> Range<usize> {
        let length = self.rest().chars().next().map_or(0, char::len_utf8);
        self.at..self.at + length
    }

    fn wrong(&mut self, message: impl Into<String>, help: Option<String>) -> Box<Diagnostic> {
        let here = self.here();
        super::error(self.text, here, message, help)
    }
}
