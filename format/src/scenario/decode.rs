//! Deserializes a [`Node`] to a typed value, with the span and the path of each error.
//!
//! serde's errors carry text only. [`DecodeError`] also has the span of the key or value, its
//! dotted path and a help line. Its messages follow the path: "`floor.friction` must be ...".

use std::fmt;

use serde::{
    de::{
        self, DeserializeSeed, Deserializer, EnumAccess, Expected, IntoDeserializer, MapAccess, SeqAccess, Unexpected,
        VariantAccess, Visitor,
    },
    forward_to_deserialize_any,
};

use crate::scenario::findings::Findings;
use crate::text::source::Span;
use crate::text::suggest;
use crate::text::toml_tree::{Entry, Node, Value};

/// Why a value cannot be read. Boxed, to keep results small in the code generated for each type.
#[derive(Debug)]
pub struct DecodeError(Box<Problem>);

#[derive(Debug)]
struct Problem {
    span: Option<Span>,
    path: Vec<String>,
    /// What is wrong, as a predicate of the path.
    message: String,
    help: Option<String>,
    /// The message names its subject, so that no path precedes it.
    names_subject: bool,
}

impl DecodeError {
    /// The error with `span`, unless it has one already.
    pub fn at(mut self, span: &Span) -> Self {
        self.0.span.get_or_insert_with(|| span.clone());
        self
    }

    fn below(mut self, key: &str) -> Self {
        self.0.path.insert(0, key.to_owned());
        self
    }

    fn predicate(message: impl Into<String>, help: Option<String>) -> Self {
        let (span, path, message) = (None, Vec::new(), message.into());
        DecodeError(Box::new(Problem { span, path, message, help, names_subject: false }))
    }

    /// Reports the error; its path is relative to `prefix`.
    pub fn report(mut self, prefix: &str, findings: &mut Findings) {
        for segment in prefix.rsplit('.') {
            self = self.below(segment);
        }
        self.report_in("the scenario", findings);
    }

    /// Reports the error of a `document`, such as "the scenario".
    pub fn report_in(self, document: &str, findings: &mut Findings) {
        // A key with a dot in it, such as a swept path, stays one key.
        let quoted = |key: &String| if key.contains('.') { format!("{key:?}") } else { key.clone() };
        let Problem { span, path, message, help, names_subject } = *self.0;
        let path = path.iter().map(quoted).collect::<Vec<_>>().join(".");
        let message = match (names_subject, path.is_empty()) {
            (true, true) => message,
            (true, false) => format!("{message} in `{path}`"),
            (false, true) => format!("{document} {message}"),
            (false, false) => format!("`{path}` {message}"),
        };
        findings.error(span.unwrap_or(0..0), message, help);
    }
}

impl fmt::Display for DecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.message)
    }
}

impl std::error::Error for DecodeError {}

impl de::Error for DecodeError {
    /// A predicate such as "must be positive"; a second line becomes the help.
    fn custom<T: fmt::Display>(message: T) -> Self {
        let text = message.to_string();
        match text.split_once('\n') {
            Some((message, help)) => Self::predicate(message, Some(help.to_owned())),
            None => Self::predicate(text, None),
        }
    }

    fn invalid_type(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        let expected = toml_name(expected);
        let help = match found {
            // `1.0` is a float although it is a whole number.
            Unexpected::Float(x) if expected.starts_with(WHOLE_NUMBER) && x.fract() == 0.0 && x.abs() < 1e15 => {
                Some(format!("write it without a decimal point: {x}"))
            }
            _ => None,
        };
        Self::predicate(format!("must be {expected}, not {}", describe(&found)), help)
    }

    fn invalid_value(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        match (greatest(expected), found) {
            (Some(max), Unexpected::Signed(number)) if number > max => {
                Self::predicate(format!("must be at most {max}, not {number}"), None)
            }
            (_, found) => Self::invalid_type(found, expected),
        }
    }

    fn invalid_length(length: usize, expected: &dyn Expected) -> Self {
        Self::predicate(format!("must be {}, not of length {length}", toml_name(expected)), None)
    }

    fn unknown_variant(found: &str, known: &'static [&'static str]) -> Self {
        let help = suggest::help(found, known.iter().copied());
        Self::predicate(format!("cannot be {found:?}"), Some(help))
    }

    fn unknown_field(found: &str, known: &'static [&'static str]) -> Self {
        let help = suggest::help(found, known.iter().copied());
        let mut error = Self::predicate(format!("unknown key `{found}`"), Some(help));
        error.0.names_subject = true;
        error
    }

    fn missing_field(field: &'static str) -> Self {
        Self::predicate(format!("lacks the key `{field}`"), None)
    }

    fn duplicate_field(field: &'static str) -> Self {
        Self::predicate(format!("has the key `{field}` twice"), None)
    }
}

/// Beginning of [`toml_name`]'s names of whole numbers.
const WHOLE_NUMBER: &str = "a whole number";

/// The greatest number of an integer type, by serde's name of the type, where TOML has greater
/// ones.
fn greatest(expected: &dyn Expected) -> Option<i64> {
    match expected.to_string().as_str() {
        "u8" => Some(u8::MAX.into()),
        "u32" => Some(u32::MAX.into()),
        "i32" => Some(i32::MAX.into()),
        _ => None,
    }
}

/// TOML's name of an expected type, for which serde gives the Rust type.
fn toml_name(expected: &dyn Expected) -> String {
    let text = expected.to_string();
    match text.as_str() {
        "f64" => "a number".into(),
        "u64" | "u32" | "u8" | "usize" => format!("{WHOLE_NUMBER} that is not negative"),
        "i64" | "i32" => WHOLE_NUMBER.into(),
        "a map" => "a table".into(),
        "a sequence" => "an array".into(),
        _ if text.starts_with("struct ") => "a table".into(),
        _ => text,
    }
}

fn describe(found: &Unexpected<'_>) -> String {
    match found {
        // Debug format: whole numbers keep their decimal point.
        Unexpected::Float(x) => format!("the number {x:?}"),
        Unexpected::Signed(n) => format!("the number {n}"),
        Unexpected::Unsigned(n) => format!("the number {n}"),
        Unexpected::Map => "a table".into(),
        Unexpected::Seq => "an array".into(),
        Unexpected::Bool(yes) => format!("`{yes}`"),
        Unexpected::Str(text) => format!("the string {text:?}"),
        other => other.to_string(),
    }
}

/// The error of a date, which serde does not have, where a reader expects something else.
fn unexpected_date(time: &str, expected: &dyn Expected) -> DecodeError {
    de::Error::invalid_type(Unexpected::Other(&format!("the date or time {time}")), expected)
}

/// The error of an enum that is not written as a string.
fn not_a_name(found: &Value, known: &[&str]) -> DecodeError {
    let known: Vec<_> = known.iter().map(|k| format!("\"{k}\"")).collect();
    DecodeError::predicate(format!("must be {}, not {found}", known.join(" or ")), None)
}

/// The error of a value that its reader does not take.
fn unexpected(found: &Value, expected: &dyn Expected) -> DecodeError {
    let found = match found {
        Value::String(text) => Unexpected::Str(text),
        Value::Datetime(time) => return unexpected_date(time, expected),
        Value::Integer(number) => Unexpected::Signed(*number),
        Value::Float(number) => Unexpected::Float(*number),
        Value::Boolean(yes) => Unexpected::Bool(*yes),
        Value::Array(_) => Unexpected::Seq,
        Value::Table(_) => Unexpected::Map,
    };
    de::Error::invalid_type(found, expected)
}

/// Reads one node. Its methods and those of `Items` and `Entries` are compiled for each type that is read, so what
/// does not depend on the type is a function of its own. Structs, arrays and maps have methods of their own, since
/// `deserialize_any` would compile their readers for all kinds of values.
#[derive(Clone, Copy)]
pub struct NodeDeserializer<'a>(pub &'a Node);

impl<'de> Deserializer<'de> for NodeDeserializer<'de> {
    type Error = DecodeError;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DecodeError> {
        match &self.0.value {
            Value::String(text) => visitor.visit_borrowed_str(text),
            Value::Datetime(time) => {
                // The error is created first, since reading consumes the visitor.
                let error = unexpected_date(time, &visitor);
                visitor.visit_borrowed_str(time).map_err(|_: DecodeError| error)
            }
            Value::Integer(number) => visitor.visit_i64(*number),
            Value::Float(number) => visitor.visit_f64(*number),
            Value::Boolean(yes) => visitor.visit_bool(*yes),
            Value::Array(_) => self.deserialize_seq(visitor),
            Value::Table(_) => self.deserialize_map(visitor),
        }
        .map_err(|e| e.at(&self.0.span))
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DecodeError> {
        let Value::Array(items) = &self.0.value else {
            return Err(unexpected(&self.0.value, &visitor).at(&self.0.span));
        };
        let mut access = Items { items, next: 0 };
        match visitor.visit_seq(&mut access) {
            // Fixed-size arrays stop reading when they are full.
            Ok(_) if access.next < items.len() => Err(access.unread().at(&self.0.span)),
            Ok(value) => Ok(value),
            Err(error) => Err(error.at(&self.0.span)),
        }
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, DecodeError> {
        self.deserialize_seq(visitor)
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DecodeError> {
        match &self.0.value {
            Value::Table(entries) => visitor.visit_map(Entries { entries, next: 0 }),
            other => Err(unexpected(other, &visitor)),
        }
        .map_err(|e| e.at(&self.0.span))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DecodeError> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, DecodeError> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, DecodeError> {
        // serde would read a struct from an array by position, which is unclear in a file.
        match self.0.value {
            Value::Array(_) => Err(DecodeError::predicate("must be a table, not an array", None).at(&self.0.span)),
            _ => self.deserialize_map(visitor),
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        known: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, DecodeError> {
        match &self.0.value {
            Value::String(text) => visitor.visit_enum(Name(text)),
            other => Err(not_a_name(other, known)),
        }
        .map_err(|e| e.at(&self.0.span))
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct
        tuple_struct identifier ignored_any
    }
}

struct Items<'a> {
    items: &'a [Node],
    next: usize,
}

impl<'a> Items<'a> {
    fn read(&mut self) -> Option<&'a Node> {
        let item = self.items.get(self.next)?;
        self.next += 1;
        Some(item)
    }

    /// `error` of the item that was read last.
    fn locate(&self, error: DecodeError) -> DecodeError {
        let index = self.next - 1;
        error.at(&self.items[index].span).below(&index.to_string())
    }

    /// The error of an array longer than its reader.
    fn unread(&self) -> DecodeError {
        let (length, expected) = (self.items.len(), self.next);
        DecodeError::predicate(format!("must be an array of length {expected}, not of length {length}"), None)
    }
}

impl<'de> SeqAccess<'de> for &mut Items<'de> {
    type Error = DecodeError;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, DecodeError> {
        let Some(item) = self.read() else { return Ok(None) };
        match seed.deserialize(NodeDeserializer(item)) {
            Ok(value) => Ok(Some(value)),
            Err(error) => Err(self.locate(error)),
        }
    }
}

struct Entries<'a> {
    entries: &'a [Entry],
    next: usize,
}

impl<'a> Entries<'a> {
    fn read(&mut self) -> Option<&'a Entry> {
        let entry = self.entries.get(self.next)?;
        self.next += 1;
        Some(entry)
    }

    /// The entry whose key was read last.
    fn current(&self) -> &'a Entry {
        &self.entries[self.next - 1]
    }

    /// `error` of the current value.
    fn locate(&self, error: DecodeError) -> DecodeError {
        let entry = self.current();
        error.at(&entry.node.span).below(&entry.key)
    }
}

impl<'de> MapAccess<'de> for Entries<'de> {
    type Error = DecodeError;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, DecodeError> {
        let Some(entry) = self.read() else { return Ok(None) };
        let key: de::value::StrDeserializer<'_, DecodeError> = entry.key.as_str().into_deserializer();
        seed.deserialize(key).map(Some).map_err(|e| e.at(&entry.key_span))
    }

    fn next_value_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<T::Value, DecodeError> {
        match seed.deserialize(NodeDeserializer(&self.current().node)) {
            Ok(value) => Ok(value),
            Err(error) => Err(self.locate(error)),
        }
    }
}

/// An enum without data, by its name.
struct Name<'a>(&'a str);

impl<'de> EnumAccess<'de> for Name<'de> {
    type Error = DecodeError;
    type Variant = Self;

    fn variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<(T::Value, Self), DecodeError> {
        let name: de::value::BorrowedStrDeserializer<'de, DecodeError> =
            de::value::BorrowedStrDeserializer::new(self.0);
        Ok((seed.deserialize(name)?, self))
    }
}

impl<'de> VariantAccess<'de> for Name<'de> {
    type Error = DecodeError;

    fn unit_variant(self) -> Result<(), DecodeError> {
        Ok(())
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, _: T) -> Result<T::Value, DecodeError> {
        Err(DecodeError::predicate("must be a table", None))
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, _: V) -> Result<V::Value, DecodeError> {
        Err(DecodeError::predicate("must be an array", None))
    }

    fn struct_variant<V: Visitor<'de>>(self, _: &'static [&'static str], _: V) -> Result<V::Value, DecodeError> {
        Err(DecodeError::predicate("must be a table", None))
    }
}
