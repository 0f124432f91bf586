//! The XML tree with its source: elements by name, positions of attributes, errors.

use std::collections::HashMap;

use roxmltree::{Document, Node};

use crate::robot::robot_error::{FileError, RobotError};
use crate::robot::xml_syntax::open_tag;
use crate::text::source::Source;

/// A well-formed document whose root element is `<robot>`.
pub(super) struct Xml<'a> {
    pub source: &'a Source,
    pub robot: Node<'a, 'a>,
    /// Elements directly under `<robot>` by tag and name; the first of those that share both.
    named: HashMap<(&'a str, &'a str), Node<'a, 'a>>,
}

impl<'a> Xml<'a> {
    pub fn new(source: &'a Source, document: &'a Document<'a>) -> Result<Self, RobotError> {
        let robot = document.root_element();
        if !robot.has_tag_name("robot") {
            let fault =
                FileError::new(source, open_tag(source, robot), "this is not a URDF").expected("<robot name=\"...\">");
            return Err(fault.found(format!("<{}>", robot.tag_name().name())).invalid());
        }
        let mut named = HashMap::new();
        for node in robot.children() {
            if let Some(name) = node.attribute("name") {
                named.entry((node.tag_name().name(), name)).or_insert(node);
            }
        }
        Ok(Self { source, robot, named })
    }

    /// The `<link>` or `<joint>` of that name directly under `<robot>`; the root element if there
    /// is none.
    pub fn named(&self, tag: &str, name: &str) -> Node<'a, 'a> {
        self.named.get(&(tag, name)).copied().unwrap_or(self.robot)
    }

    /// An error at an element's opening tag.
    pub fn fault(&self, node: Node, message: impl Into<String>) -> FileError {
        FileError::new(self.source, open_tag(self.source, node), message).element(describe(node))
    }

    /// An error at an attribute's value, or at the element when the attribute is absent.
    pub fn attribute_fault(&self, node: Node, attribute: &str, message: impl Into<String>) -> FileError {
        match node.attribute_node(attribute) {
            Some(a) => FileError::new(self.source, a.range_value(), message)
                .element(describe(node))
                .found(format!("`{}`", a.value())),
            None => self.fault(node, message),
        }
    }
}

/// The first child element of that name.
pub(super) fn child<'a>(node: Node<'a, 'a>, tag: &str) -> Option<Node<'a, 'a>> {
    node.children().find(|n| n.has_tag_name(tag))
}

/// The nearest enclosing named element as text: ``joint `knee` ``.
pub(super) fn describe(node: Node) -> String {
    node.ancestors()
        .filter(|n| n.has_tag_name("link") || n.has_tag_name("joint"))
        .find_map(|n| n.attribute("name").map(|name| format!("{} `{name}`", n.tag_name().name())))
        .unwrap_or_else(|| format!("<{}>", node.tag_name().name()))
}
