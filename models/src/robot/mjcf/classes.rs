//! Default classes.

use std::collections::HashMap;

use super::document::{ATTACHED_DEFAULT, Document, Id};
use super::view::View;
use crate::robot::robot_error::RobotError;

/// One class: its elements, and the class that it extends.
#[derive(Default)]
struct Class {
    parent: Option<usize>,
    elements: Vec<Id>,
}

/// All classes; the first is `main`.
pub(super) struct Classes<'a> {
    document: &'a Document,
    classes: Vec<Class>,
    names: HashMap<&'a str, usize>,
}

/// Tags of actuators: their defaults share one set of values.
pub(super) const ACTUATORS: [&str; 15] = [
    "general",
    "motor",
    "position",
    "velocity",
    "intvelocity",
    "orientation",
    "pid",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
    "dcmotor",
    "plugin",
    "servo",
    "drive",
];

impl<'a> Classes<'a> {
    /// # Errors
    /// A nested class without a name, or with that of another one.
    pub fn read(document: &'a Document) -> Result<Self, RobotError> {
        let mut this = Self { document, classes: vec![Class::default()], names: HashMap::from([("main", 0)]) };
        let mut stack = Vec::new();
        for id in document.section("default").chain(document.section(ATTACHED_DEFAULT)) {
            let name = document.text(id, "class").unwrap_or("main");
            let root = match (document.tag(id), this.names.get(name)) {
                ("default", _) => 0,
                (_, Some(&known)) => known,
                (_, None) => {
                    this.classes.push(Class::default());
                    this.classes.len() - 1
                }
            };
            this.names.insert(name, root);
            stack.push((id, root));
            // One section after the other: the order of elements is that of the file.
            while let Some((id, class)) = stack.pop() {
                let start = stack.len();
                for &child in document.children(id) {
                    if document.tag(child) != "default" {
                        this.classes[class].elements.push(child);
                        continue;
                    }
                    let name = View::bare(document, child).required("class")?;
                    let index = this.classes.len();
                    if this.names.insert(name, index).is_some() {
                        let fault =
                            document.attribute_fault(child, "class", "there are two default classes of one name");
                        return Err(fault.expected("a unique name").invalid());
                    }
                    this.classes.push(Class { parent: Some(class), elements: Vec::new() });
                    stack.push((child, index));
                }
                stack[start..].reverse();
            }
        }
        Ok(this)
    }

    /// Checks a `childclass`.
    pub fn check(&self, id: Id, attribute: &str) -> Result<(), RobotError> {
        self.document.text(id, attribute).map_or(Ok(()), |name| self.index(id, attribute, name).map(|_| ()))
    }

    fn index(&self, id: Id, attribute: &str, name: &str) -> Result<usize, RobotError> {
        self.names.get(name).copied().ok_or_else(|| {
            let fault = self.document.attribute_fault(id, attribute, "there is no default class of this name");
            let known = self.names.keys().copied();
            fault.expected("the class of a <default>").suggest(name, known).invalid()
        })
    }

    /// An element with its defaults: those of its class, else of `childclass`, else of `main`, and
    /// of the classes that this one extends.
    pub fn view(&self, id: Id, childclass: Option<&str>) -> Result<View<'a>, RobotError> {
        let tag = self.document.tag(id);
        let own = self.document.text(id, "class").map(|name| self.index(id, "class", name)).transpose()?;
        let mut class = own.or(childclass.and_then(|name| self.names.get(name).copied())).or(Some(0));
        let is_actuator = ACTUATORS.contains(&tag);
        let applies = |other: &str| other == tag || is_actuator && ACTUATORS.contains(&other);
        let mut levels = vec![id];
        while let Some(index) = class {
            let class_ = &self.classes[index];
            levels.extend(class_.elements.iter().rev().copied().filter(|&e| applies(self.document.tag(e))));
            class = class_.parent;
        }
        Ok(View { document: self.document, levels })
    }

    /// The elements `<equality>` of the classes that apply to a constraint.
    pub fn equality_defaults(&self, id: Id) -> Result<Vec<Id>, RobotError> {
        let own = self.document.text(id, "class").map(|name| self.index(id, "class", name)).transpose()?;
        let mut class = own.or(Some(0));
        let mut levels = Vec::new();
        while let Some(index) = class {
            let class_ = &self.classes[index];
            levels.extend(class_.elements.iter().rev().copied().filter(|&e| self.document.tag(e) == "equality"));
            class = class_.parent;
        }
        Ok(levels)
    }
}
