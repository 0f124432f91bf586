//! Values of an element's attributes, its own before those of its default classes.

use super::document::{Attribute, Document, Id};
use crate::robot::robot_error::{FileError, RobotError};

/// Greatest size of a number that is read: products of some of them must stay finite.
const MAX_NUMBER: f64 = 1e20;

/// An element with the default elements that apply to it, in order of precedence.
#[derive(Clone)]
pub(super) struct View<'a> {
    pub document: &'a Document,
    pub levels: Vec<Id>,
}

impl<'a> View<'a> {
    /// An element without defaults.
    pub fn bare(document: &'a Document, id: Id) -> Self {
        Self { document, levels: vec![id] }
    }

    /// The element itself.
    pub fn id(&self) -> Id {
        self.levels[0]
    }

    /// The attribute and the element that has it.
    pub fn find(&self, name: &str) -> Option<(Id, &'a Attribute)> {
        self.levels.iter().find_map(|&id| Some((id, self.document.attribute(id, name)?)))
    }

    /// True if the element or one of its defaults has the attribute.
    pub fn has(&self, name: &str) -> bool {
        self.find(name).is_some()
    }

    /// The attribute's text.
    pub fn text(&self, name: &str) -> Option<&'a str> {
        self.find(name).map(|(_, a)| a.value.as_str())
    }

    /// The text of an attribute that must be there.
    pub fn required(&self, name: &str) -> Result<&'a str, RobotError> {
        self.text(name).ok_or_else(|| self.missing(name))
    }

    /// The error of an attribute that is not there.
    pub fn missing(&self, name: &str) -> RobotError {
        let (document, id) = (self.document, self.id());
        let message = format!("{} lacks the attribute `{name}`", document.describe(id));
        document.fault(id, message).expected(format!("{name}=\"...\"")).invalid()
    }

    /// An error at the attribute's value.
    pub fn fault(&self, name: &str, expected: impl Into<String>) -> FileError {
        let id = self.find(name).map_or(self.id(), |(id, _)| id);
        let document = self.document;
        let message = format!("`{name}` of {} cannot be used", document.describe(id));
        document.attribute_fault(id, name, message).expected(expected)
    }

    /// Between `least` and `most` finite numbers.
    pub fn list(&self, name: &str, least: usize, most: usize) -> Result<Option<Vec<f64>>, RobotError> {
        let Some((id, _)) = self.find(name) else { return Ok(None) };
        list_of(self.document, id, name, least, most).map(Some)
    }

    /// Exactly `N` finite numbers.
    pub fn array<const N: usize>(&self, name: &str) -> Result<Option<[f64; N]>, RobotError> {
        let Some(list) = self.list(name, N, N)? else { return Ok(None) };
        Ok(list.try_into().ok())
    }

    /// One finite number.
    pub fn number(&self, name: &str) -> Result<Option<f64>, RobotError> {
        Ok(self.array::<1>(name)?.map(|[x]| x))
    }

    /// One finite number that is not negative; 0 by default.
    pub fn amount(&self, name: &str) -> Result<f64, RobotError> {
        match self.number(name)? {
            Some(x) if x < 0.0 => Err(self.fault(name, "a finite number, not negative").invalid()),
            x => Ok(x.unwrap_or(0.0)),
        }
    }

    /// Up to `N` numbers, which replace the first ones of the values so far: those of the classes,
    /// outermost first, then the element's own.
    pub fn overlay<const N: usize>(&self, name: &str, mut values: [f64; N]) -> Result<[f64; N], RobotError> {
        for &id in self.levels.iter().rev().filter(|&&id| self.document.attribute(id, name).is_some()) {
            let list = list_of(self.document, id, name, 1, N)?;
            values[..list.len()].copy_from_slice(&list);
        }
        Ok(values)
    }

    /// One of the words.
    pub fn word(&self, name: &str, words: &[&'static str]) -> Result<Option<&'static str>, RobotError> {
        let Some(text) = self.text(name) else { return Ok(None) };
        match words.iter().find(|word| **word == text) {
            Some(word) => Ok(Some(word)),
            None => {
                let fault = self.fault(name, format!("one of {}", words.join(", ")));
                Err(fault.suggest(text, words.iter().copied()).invalid())
            }
        }
    }

    /// `true` or `false`.
    pub fn flag(&self, name: &str) -> Result<Option<bool>, RobotError> {
        Ok(self.word(name, &["true", "false"])?.map(|word| word == "true"))
    }

    /// A range that is active: `limited`, or `auto` when the range is given and the compiler's
    /// `autolimits` is on.
    pub fn range(&self, range: &str, limited: &str, autolimits: bool) -> Result<Option<[f64; 2]>, RobotError> {
        let values = self.array::<2>(range)?;
        let word = self.word(limited, &["true", "false", "auto"])?.unwrap_or("auto");
        let is_active = match (word, values) {
            ("auto", Some(_)) if !autolimits => {
                let expected = format!("`{limited}` as well, since autolimits is off");
                return Err(self.fault(range, expected).invalid());
            }
            ("auto", values) => values.is_some_and(|v| v != [0.0; 2]),
            (word, _) => word == "true",
        };
        let values = values.unwrap_or([0.0; 2]);
        if is_active && values[0] >= values[1] {
            return Err(self.fault(range, "two numbers, the first below the second").invalid());
        }
        Ok(is_active.then_some(values))
    }
}

/// The numbers of an attribute that the element has itself.
pub(super) fn list_of(
    document: &Document,
    id: Id,
    name: &str,
    least: usize,
    most: usize,
) -> Result<Vec<f64>, RobotError> {
    let text = document.text(id, name).unwrap_or_default();
    let numbers: Option<Vec<f64>> = text.split_whitespace().map(|number| number.parse().ok()).collect();
    let is_valid =
        |n: &Vec<f64>| (least..=most).contains(&n.len()) && n.iter().all(|x| x.is_finite() && x.abs() <= MAX_NUMBER);
    numbers.filter(is_valid).ok_or_else(|| {
        let count = match (least, most) {
            (1, 1) => "a finite number".to_owned(),
            (_, usize::MAX) => format!("at least {least} finite numbers separated by spaces"),
            _ if least == most => format!("{least} finite numbers separated by spaces"),
            _ => format!("{least} to {most} finite numbers separated by spaces"),
        };
        let message = format!("`{name}` of {} cannot be used", document.describe(id));
        document.attribute_fault(id, name, message).expected(count).invalid()
    })
}
