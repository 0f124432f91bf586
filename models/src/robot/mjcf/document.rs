//! The elements of an MJCF file with those of its included files, and errors at their positions.

use std::ops::Range;
use std::path::{Component, Path, PathBuf};

use crate::robot::robot_error::{FileError, RobotError, read_source};
use crate::robot::xml_syntax::{self, open_tag};
use crate::text::source::Source;

/// Greatest depth of nested elements: the tree of bodies is walked recursively in places.
const MAX_DEPTH: usize = 1024;
/// Greatest number of elements of all files.
const MAX_ELEMENTS: usize = 1_000_000;
/// Greatest number of included files.
const MAX_INCLUDES: usize = 1000;

/// Index of an element.
pub(super) type Id = usize;

/// One attribute with the position of its value.
#[derive(Clone)]
pub(super) struct Attribute {
    pub name: String,
    pub value: String,
    pub span: Range<usize>,
}

/// One element.
#[derive(Clone)]
pub(super) struct Element {
    pub tag: String,
    pub attributes: Vec<Attribute>,
    pub children: Vec<Id>,
    /// Index into [`Document::sources`].
    pub source: usize,
    /// Bytes of the opening tag.
    pub span: Range<usize>,
}

/// All elements; those of an included file replace its `<include>`.
pub(super) struct Document {
    /// The main file first.
    pub sources: Vec<Source>,
    elements: Vec<Element>,
}

/// Tag of the sections of default classes of an attached model.
pub(super) const ATTACHED_DEFAULT: &str = "attached default";

/// The root element of the main file.
pub(super) const ROOT: Id = 0;

impl Document {
    /// Reads the file and the files it includes.
    ///
    /// # Errors
    /// XML that is not well-formed; a root element other than `<mujoco>`; an included file that is
    /// missing, includes itself or has an absolute path; too many or too deeply nested elements.
    pub fn read(source: &Source) -> Result<Self, RobotError> {
        let mut document = Self { sources: vec![source.clone()], elements: Vec::new() };
        let mut chain = vec![normalized(source.path())];
        document.append(0, None, &mut chain, 0)?;
        let root = document.element(ROOT);
        if root.tag != "mujoco" {
            let fault = document.fault(ROOT, "this is not an MJCF file").found(format!("<{}>", root.tag));
            return Err(fault.expected("<mujoco model=\"...\">").invalid());
        }
        Ok(document)
    }

    pub fn element(&self, id: Id) -> &Element {
        &self.elements[id]
    }

    pub fn element_mut(&mut self, id: Id) -> &mut Element {
        &mut self.elements[id]
    }

    /// All elements.
    pub fn elements_mut(&mut self) -> impl Iterator<Item = &mut Element> {
        self.elements.iter_mut()
    }

    /// Adds all elements of another document, which no element of this one holds yet. Returns what
    /// their ids are greater by.
    ///
    /// # Errors
    /// Too many elements.
    pub fn absorb(&mut self, other: Self) -> Result<Id, RobotError> {
        let (offset, sources) = (self.elements.len(), self.sources.len());
        self.sources.extend(other.sources);
        for mut element in other.elements {
            element.source += sources;
            element.children.iter_mut().for_each(|id| *id += offset);
            self.push(element)?;
        }
        Ok(offset)
    }

    /// Adds an element, which no other one holds yet.
    ///
    /// # Errors
    /// Too many elements.
    pub fn push(&mut self, element: Element) -> Result<Id, RobotError> {
        let id = self.elements.len();
        self.elements.push(element);
        if id > MAX_ELEMENTS {
            let fault = self.fault(id, "with its copies the file has too many elements");
            return Err(fault.expected(format!("at most {MAX_ELEMENTS}")).invalid());
        }
        Ok(id)
    }

    pub fn tag(&self, id: Id) -> &str {
        &self.elements[id].tag
    }

    pub fn children(&self, id: Id) -> &[Id] {
        &self.elements[id].children
    }

    pub fn attribute(&self, id: Id, name: &str) -> Option<&Attribute> {
        self.elements[id].attributes.iter().find(|a| a.name == name)
    }

    /// The value of an attribute.
    pub fn text(&self, id: Id, name: &str) -> Option<&str> {
        self.attribute(id, name).map(|a| a.value.as_str())
    }

    /// Elements of that name in all sections of that name directly under the root.
    pub fn section<'a>(&'a self, name: &'a str) -> impl Iterator<Item = Id> + 'a {
        self.children(ROOT).iter().copied().filter(move |&id| self.tag(id) == name)
    }

    /// All elements of that name in `<asset>`.
    pub fn assets(&self, tag: &str) -> Vec<Id> {
        let all = self.section("asset").flat_map(|section| self.children(section).iter().copied());
        all.filter(|&id| self.tag(id) == tag).collect()
    }

    pub fn source(&self, id: Id) -> &Source {
        &self.sources[self.elements[id].source]
    }

    /// The element's position for notices.
    pub fn at(&self, id: Id) -> usize {
        self.elements[id].span.start
    }

    /// An error at an element's opening tag.
    pub fn fault(&self, id: Id, message: impl Into<String>) -> FileError {
        FileError::new(self.source(id), self.elements[id].span.clone(), message).element(self.describe(id))
    }

    /// An error at an attribute's value, or at the element when the attribute is absent.
    pub fn attribute_fault(&self, id: Id, name: &str, message: impl Into<String>) -> FileError {
        match self.attribute(id, name) {
            Some(a) => FileError::new(self.source(id), a.span.clone(), message)
                .element(self.describe(id))
                .found(format!("`{}`", a.value)),
            None => self.fault(id, message),
        }
    }

    /// The element as text: ``joint `knee` ``, or `<joint>`.
    pub fn describe(&self, id: Id) -> String {
        let tag = self.tag(id);
        match self.text(id, "name").or_else(|| self.text(id, "class")) {
            Some(name) => format!("{tag} `{name}`"),
            None => format!("<{tag}>"),
        }
    }

    /// Appends the elements of a file. `parent` receives the children of the root of an included
    /// file; the main file's root has none.
    fn append(
        &mut self,
        source: usize,
        parent: Option<Id>,
        chain: &mut Vec<PathBuf>,
        depth: usize,
    ) -> Result<(), RobotError> {
        let text = self.sources[source].clone();
        let xml = xml_syntax::parse(&text)?;
        let root = xml.root_element();
        let mut stack = vec![(root, parent, depth)];
        if parent.is_some() {
            stack = root.children().filter(|n| n.is_element()).map(|n| (n, parent, depth)).collect();
            stack.reverse();
        }
        while let Some((node, parent, depth)) = stack.pop() {
            let id = self.elements.len();
            self.elements.push(element(&text, source, node));
            if depth > MAX_DEPTH || id > MAX_ELEMENTS {
                let fault = self.fault(id, "the elements nest too deeply, or are too many");
                return Err(fault.expected(format!("at most {MAX_DEPTH} levels, {MAX_ELEMENTS} elements")).invalid());
            }
            let target = match (parent, node.has_tag_name("include")) {
                (Some(parent), true) => {
                    self.include(id, parent, chain, depth)?;
                    continue;
                }
                (Some(parent), false) => {
                    self.elements[parent].children.push(id);
                    id
                }
                (None, _) => id,
            };
            let children: Vec<_> = node.children().filter(|n| n.is_element()).collect();
            stack.extend(children.into_iter().rev().map(|n| (n, Some(target), depth + 1)));
        }
        Ok(())
    }

    /// Reads an included file; its path is relative to the folder of the main file, else to that of
    /// the file that includes it, as in MuJoCo.
    fn include(&mut self, id: Id, parent: Id, chain: &mut Vec<PathBuf>, depth: usize) -> Result<(), RobotError> {
        let Some(name) = self.text(id, "file") else {
            return Err(self.fault(id, "<include> lacks the attribute `file`").expected("file=\"...\"").invalid());
        };
        let relative = Path::new(name);
        if relative.components().any(|part| matches!(part, Component::RootDir | Component::Prefix(_))) {
            let fault = self.attribute_fault(id, "file", "an included file has an absolute path");
            return Err(fault.expected("a path relative to the main file").invalid());
        }
        let beside = |source: &Source| source.path().parent().unwrap_or(Path::new("")).join(relative);
        let path = Some(beside(&self.sources[0])).filter(|path| path.is_file());
        let path = path.unwrap_or_else(|| beside(self.source(id)));
        let key = normalized(&path);
        if chain.contains(&key) {
            let fault = self.attribute_fault(id, "file", "the file includes itself");
            return Err(fault.expected("files that do not include each other in a ring").invalid());
        }
        if self.sources.len() > MAX_INCLUDES {
            let fault = self.attribute_fault(id, "file", "too many files are included");
            return Err(fault.expected(format!("at most {MAX_INCLUDES}")).invalid());
        }
        let source = read_source(&path)
            .map_err(|error| self.attribute_fault(id, "file", error.to_string()).expected("an MJCF file").invalid())?;
        self.sources.push(source);
        chain.push(key);
        self.append(self.sources.len() - 1, Some(parent), chain, depth)?;
        chain.pop();
        Ok(())
    }
}

fn element(text: &Source, source: usize, node: roxmltree::Node) -> Element {
    let attributes = node.attributes().map(|a| Attribute {
        name: a.name().to_owned(),
        value: a.value().to_owned(),
        span: a.range_value(),
    });
    let tag = node.tag_name().name().to_owned();
    Element { tag, attributes: attributes.collect(), children: Vec::new(), source, span: open_tag(text, node) }
}

/// The path by which a file is recognised.
pub(super) fn normalized(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}
