//! XML elements with their source: children, values, positions and errors.

use roxmltree::Node;

use super::document::{At, SdfError};
use super::remarks::Remarks;
use super::vocabulary::{OF_OTHER_JOINTS, VOCABULARY};
use crate::text::source::Source;
use crate::text::suggest::nearest;
use crate::text::xml_syntax;

/// Greatest magnitude of a number: greater ones stand for infinity in old files.
pub(super) const UNLIMITED: f64 = 1e16;
/// Greatest mass, kg: squares of greater ones could overflow.
pub(super) const MAX_MASS: f64 = 1e12;
/// Greatest coordinate, m: beyond it rounding of the inertia about a joint exceeds that about the
/// centre of mass.
pub(super) const MAX_COORDINATE: f64 = 1e4;

/// An element of a file.
#[derive(Clone, Copy)]
pub(super) struct Element<'a> {
    pub node: Node<'a, 'a>,
    pub source: &'a Source,
}

/// Parses a text. Errors have their position.
pub(super) fn parse(source: &Source) -> Result<roxmltree::Document<'_>, SdfError> {
    xml_syntax::parse(source.text())
        .map_err(|error| SdfError::new(At { source: source.clone(), span: error.span }, error.message).syntax())
}

impl<'a> Element<'a> {
    pub fn tag(&self) -> &'a str {
        self.node.tag_name().name()
    }

    pub fn all(&self, tag: &'static str) -> impl Iterator<Item = Element<'a>> + use<'a> {
        let source = self.source;
        self.node.children().filter(move |n| n.has_tag_name(tag)).map(move |node| Element { node, source })
    }

    /// The only child of that name. Error: there are several.
    pub fn child(&self, tag: &'static str) -> Result<Option<Element<'a>>, SdfError> {
        let mut found = self.all(tag);
        let first = found.next();
        match found.next() {
            Some(second) => {
                let message = format!("{}: <{}> has more than one <{tag}>", self.describe(), self.tag());
                Err(second.error(message).expected(format!("one <{tag}>")))
            }
            None => Ok(first),
        }
    }

    /// The only child of that name, which must be there.
    pub fn required(&self, tag: &'static str) -> Result<Element<'a>, SdfError> {
        self.child(tag)?.ok_or_else(|| {
            let message = format!("{}: <{}> lacks <{tag}>", self.describe(), self.tag());
            self.error(message).expected(format!("one <{tag}>"))
        })
    }

    /// Bytes of the opening tag; the element may span hundreds of lines.
    pub fn at(&self) -> At {
        At { source: self.source.clone(), span: xml_syntax::open_tag(self.source.text(), self.node) }
    }

    /// Bytes of an attribute's value, or of the opening tag without it.
    pub fn at_attribute(&self, name: &str) -> At {
        match self.node.attribute_node(name) {
            Some(attribute) => At { source: self.source.clone(), span: attribute.range_value() },
            None => self.at(),
        }
    }

    /// Bytes of the element with its value.
    pub fn at_value(&self) -> At {
        At { source: self.source.clone(), span: self.node.range() }
    }

    pub fn error(&self, message: impl Into<String>) -> SdfError {
        SdfError::new(self.at(), message).element(self.describe())
    }

    /// The text in the element.
    pub fn text(&self) -> &'a str {
        self.node.text().unwrap_or("").trim()
    }

    pub fn attribute(&self, name: &str) -> Option<&'a str> {
        self.node.attribute(name)
    }

    /// An attribute that names something; empty is as left out.
    pub fn named(&self, name: &str) -> Option<String> {
        self.attribute(name).filter(|text| !text.is_empty()).map(str::to_owned)
    }

    /// The `name`, which must be there.
    pub fn name(&self) -> Result<String, SdfError> {
        let found = self.attribute("name").unwrap_or("");
        if !found.is_empty() && found.trim() == found && !found.contains("::") && !found.starts_with("__") {
            return Ok(found.to_owned());
        }
        let message = format!("{}: the name of <{}> cannot be used", self.describe(), self.tag());
        let error = SdfError::new(self.at_attribute("name"), message).element(self.describe());
        let error = if self.attribute("name").is_some() { error.found(format!("{found:?}")) } else { error };
        Err(error.expected("a name without `::`, spaces around it, or `__` before it"))
    }

    /// `N` finite numbers.
    pub fn numbers<const N: usize>(&self) -> Result<[f64; N], SdfError> {
        self.parse_numbers(self.text()).ok_or_else(|| {
            let what = if N == 1 { "a finite number".into() } else { format!("{N} finite numbers") };
            self.bad_value(&what)
        })
    }

    /// As [`Element::numbers`], from a part of the text.
    pub fn parse_numbers<const N: usize>(&self, text: &str) -> Option<[f64; N]> {
        let numbers: Vec<f64> = text.split_whitespace().map(|word| word.parse().ok()).collect::<Option<_>>()?;
        let numbers: [f64; N] = numbers.try_into().ok()?;
        numbers.iter().all(|x| x.is_finite()).then_some(numbers)
    }

    /// The error of a value.
    pub fn bad_value(&self, expected: &str) -> SdfError {
        let message = format!("{}: the value of <{}> cannot be used", self.describe(), self.tag());
        let found = format!("`{}`", self.text());
        SdfError::new(self.at_value(), message).element(self.describe()).found(found).expected(expected)
    }

    /// The number in the child of that name, in a range.
    pub fn number(
        &self,
        tag: &'static str,
        is_valid: impl Fn(f64) -> bool,
        expected: &str,
    ) -> Result<Option<f64>, SdfError> {
        let Some(child) = self.child(tag)? else { return Ok(None) };
        match child.parse_numbers(child.text()) {
            Some([x]) if is_valid(x) => Ok(Some(x)),
            _ => Err(child.bad_value(expected)),
        }
    }

    /// A number that stands for infinity when it is very large, infinite or left out.
    pub fn limit(&self, tag: &'static str) -> Result<Option<f64>, SdfError> {
        let Some(child) = self.child(tag)? else { return Ok(None) };
        match child.text().parse::<f64>() {
            Ok(x) if !x.is_nan() => Ok(Some(x).filter(|x| x.abs() < UNLIMITED)),
            _ => Err(child.bad_value("a number")),
        }
    }

    /// True or false in the child of that name.
    pub fn boolean(&self, tag: &'static str) -> Result<bool, SdfError> {
        let Some(child) = self.child(tag)? else { return Ok(false) };
        child.truth()
    }

    /// The element's own text as true or false.
    pub fn truth(&self) -> Result<bool, SdfError> {
        match self.text() {
            "true" | "1" | "True" | "TRUE" => Ok(true),
            "false" | "0" | "False" | "FALSE" => Ok(false),
            _ => Err(self.bad_value("true or false")),
        }
    }

    /// The nearest enclosing named element as text: ``joint `knee` ``.
    pub fn describe(&self) -> String {
        const NAMED: [&str; 5] = ["link", "joint", "frame", "model", "world"];
        let named = self.node.ancestors().filter(|n| NAMED.contains(&n.tag_name().name()));
        let text = |n: Node| n.attribute("name").map(|name| format!("{} `{name}`", n.tag_name().name()));
        named.filter_map(text).next().unwrap_or_else(|| format!("<{}>", self.tag()))
    }

    /// Remarks on children without effect and on unknown ones.
    pub fn check_children(&self, remarks: &mut Remarks) {
        let tag = match self.tag() {
            "axis2" => "axis",
            tag => tag,
        };
        let Some(words) = VOCABULARY.iter().find(|words| words.tag == tag) else { return };
        for node in self.node.children().filter(|n| n.is_element()) {
            let child = Element { node, source: self.source };
            let name = node.tag_name().name();
            let is_foreign = node.tag_name().namespace().is_some();
            if words.read.contains(&name) && !is_foreign || tag == "joint" && OF_OTHER_JOINTS.contains(&name) {
                continue;
            }
            if words.ignored.contains(&name) || is_foreign {
                remarks.ignore(child.at(), format!("<{name}> of <{}>", self.tag()));
                continue;
            }
            let near = nearest(name, words.read.iter().chain(words.ignored).copied());
            let near = near.map_or(String::new(), |near| format!("; did you mean <{near}>?"));
            let message = format!("unknown element <{name}> of {} is ignored{near}", self.describe());
            remarks.warning(child.at(), message);
        }
    }
}
