//! From text to expression.

use std::ops::Range;

use super::expression::{Comparison, Expression, Relation, Subject};
use crate::record::ParamValue;
use crate::scenario::Diagnostic;

/// Brackets and negations inside each other; more would be a mistake, and the stack is not endless.
const DEEPEST: usize = 100;

type Parsed<T> = Result<T, Box<Diagnostic>>;

/// Reads a whole text.
pub(super) fn parse(text: &str) -> Parsed<Expression> {
    let mut parser = Parser { text, at: 0, depth: 0, comparisons: 0 };
    let expression = parser.any()?;
    match parser.rest() {
        "" => Ok(expression),
        rest if rest.starts_with(')') => Err(parser.wrong("this bracket closes nothing", None)),
        _ => Err(parser.wrong("`and`, `or` or the end is wanted here", None)),
    }
}

/// A segment of a path, in quotes where it is no bare word or would be taken for another.
pub(super) fn segment(name: &str) -> String {
    let is_word = !name.is_empty() && name.chars().all(is_bare);
    if is_word && !["not", "name", "key"].contains(&name) { name.to_owned() } else { quoted(name) }
}

/// A text in quotes: in single ones as it is, else with `\` before what would end it.
pub(super) fn quoted(text: &str) -> String {
    if text.contains('"') && !text.contains('\'') {
        return format!("'{text}'");
    }
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

fn is_bare(c: char) -> bool {
    c.is_alphanumeric() || c == '_' || c == '-'
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
        while self.word("or") || self.sign("||") {
            any.push(self.all()?);
        }
        Ok(if any.len() == 1 { any.remove(0) } else { Expression::Any(any) })
    }

    fn all(&mut self) -> Parsed<Expression> {
        let first = self.one()?;
        let mut all = vec![first];
        while self.word("and") || self.sign("&&") {
            all.push(self.one()?);
        }
        Ok(if all.len() == 1 { all.remove(0) } else { Expression::All(all) })
    }

    fn one(&mut self) -> Parsed<Expression> {
        if self.depth == DEEPEST {
            return Err(self.wrong(format!("more than {DEEPEST} brackets and negations inside each other"), None));
        }
        self.depth += 1;
        let one = self.bracket_or_comparison();
        self.depth -= 1;
        one
    }

    fn bracket_or_comparison(&mut self) -> Parsed<Expression> {
        if self.word("not") || (!self.rest().starts_with("!=") && !self.rest().starts_with("!~") && self.sign("!")) {
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
            return Err(super::error(self.text, open, "this bracket is never closed", None));
        }
        Err(self.wrong("`and`, `or` or `)` is wanted here", None))
    }

    fn comparison(&mut self) -> Parsed<Expression> {
        self.blanks();
        let start = self.at;
        let subject = self.subject()?;
        let at = start..self.at;
        let relation = self.relation()?;
        self.blanks();
        let start = self.at;
        let wanted = if relation == Relation::In { self.list()? } else { vec![self.value()?] };
        let wanted_at = start..self.at;
        let fits = |value: &ParamValue| match value {
            ParamValue::Text(_) => !relation.orders(),
            ParamValue::Integer(_) | ParamValue::Number(_) => !relation.reads(),
            ParamValue::Flag(_) => !relation.orders() && !relation.reads(),
        };
        if !wanted.iter().all(fits) {
            let kind = if relation.orders() { "a number" } else { "a text in quotes" };
            return Err(super::error(self.text, wanted_at, format!("{kind} is wanted here"), None));
        }
        let index = self.comparisons;
        self.comparisons += 1;
        Ok(Expression::Holds(index, Comparison { subject, relation, wanted, at, wanted_at }))
    }

    fn subject(&mut self) -> Parsed<Subject> {
        let mut path = Vec::new();
        let is_quoted = self.text[self.at..].starts_with(['"', '\'']);
        loop {
            path.push(match self.text[self.at..].chars().next() {
                Some('"' | '\'') => self.string()?,
                Some(c) if is_bare(c) => self.take_while(is_bare).to_owned(),
                _ if path.is_empty() => {
                    let help = "such as `name`, `key` or `contact.method`".to_owned();
                    return Err(self.wrong("something of the run is wanted here", Some(help)));
                }
                _ => return Err(self.wrong("the rest of the path is wanted here", None)),
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

    fn relation(&mut self) -> Parsed<Relation> {
        if self.word("in") {
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
                    false => "one of == != < <= > >= ~ !~ ^= in".to_owned(),
                };
                Err(self.wrong("a comparison is wanted here", Some(help)))
            }
        }
    }

    fn list(&mut self) -> Parsed<Vec<ParamValue>> {
        if !self.sign("[") {
            return Err(self.wrong("a list such as [1, 2] is wanted here", None));
        }
        let mut values = vec![self.value()?];
        while self.sign(",") {
            values.push(self.value()?);
        }
        if self.sign("]") { Ok(values) } else { Err(self.wrong("`,` or `]` is wanted here", None)) }
    }

    fn value(&mut self) -> Parsed<ParamValue> {
        self.blanks();
        let start = self.at;
        if self.rest().starts_with(['"', '\'']) {
            return self.string().map(ParamValue::Text);
        }
        let word = self.take_while(|c| is_bare(c) || c == '.' || c == '+');
        let wrong = |message: &str, help: Option<String>| super::error(self.text, start..self.at, message, help);
        match word {
            "true" => return Ok(ParamValue::Flag(true)),
            "false" => return Ok(ParamValue::Flag(false)),
            "" => {
                self.at = start;
                return Err(self.wrong("a value is wanted here", Some("a number, or a text in quotes".into())));
            }
            _ => {}
        }
        if let Ok(integer) = word.parse::<i64>() {
            return Ok(ParamValue::Integer(integer));
        }
        match word.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(ParamValue::Number(number)),
            Ok(_) => Err(wrong("a finite number is wanted here", None)),
            Err(_) if word.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) => {
                Err(wrong("this is no number", None))
            }
            Err(_) => Err(wrong("a text stands in quotes", Some(format!("write {}", quoted(word))))),
        }
    }

    /// A text at the present place; in double quotes `\` takes away the meaning of the next character.
    fn string(&mut self) -> Parsed<String> {
        let start = self.at;
        let mut characters = self.text[start..].char_indices();
        let quote = characters.next().map_or('"', |(_, c)| c);
        let mut out = String::new();
        while let Some((i, c)) = characters.next() {
            match c {
                c if c == quote => {
                    self.at = start + i + c.len_utf8();
                    return Ok(out);
                }
                '\\' if quote == '"' => out.extend(characters.next().map(|(_, c)| c)),
                c => out.push(c),
            }
        }
        Err(super::error(self.text, start..self.text.len(), "this text is never closed", None))
    }

    /// The rest of the text, blanks skipped.
    fn rest(&mut self) -> &'a str {
        self.blanks();
        &self.text[self.at..]
    }

    fn blanks(&mut self) {
        self.take_while(char::is_whitespace);
    }

    fn take_while(&mut self, wanted: impl Fn(char) -> bool) -> &'a str {
        let rest = &self.text[self.at..];
        let length = rest.find(|c| !wanted(c)).unwrap_or(rest.len());
        self.at += length;
        &rest[..length]
    }

    fn sign(&mut self, sign: &str) -> bool {
        let found = self.rest().starts_with(sign);
        self.at += if found { sign.len() } else { 0 };
        found
    }

    /// A word that is not the beginning of a longer one or of a path.
    fn word(&mut self, word: &str) -> bool {
        let after = self.rest().strip_prefix(word);
        let found = after.is_some_and(|rest| !rest.starts_with(|c| is_bare(c) || c == '.'));
        self.at += if found { word.len() } else { 0 };
        found
    }

    /// The next character, or the place behind the last one.
    fn here(&mut self) -> Range<usize> {
        let length = self.rest().chars().next().map_or(0, char::len_utf8);
        self.at..self.at + length
    }

    fn wrong(&mut self, message: impl Into<String>, help: Option<String>) -> Box<Diagnostic> {
        let here = self.here();
        super::error(self.text, here, message, help)
    }
}
