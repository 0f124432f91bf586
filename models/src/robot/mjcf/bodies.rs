//! The tree of bodies of `<worldbody>`, depth first as MuJoCo numbers them.

use std::collections::HashMap;

use nalgebra::{Isometry3, Point3, Vector3};

use super::classes::Classes;
use super::compiler::Compiler;
use super::document::{Document, Id};
use super::ignored::Ignored;
use super::orientation::{from_z, pose};
use super::view::View;
use crate::robot::robot_error::RobotError;

/// An element of a body, and the pose of the frame that holds it in the body's frame.
pub(super) struct Held<'a> {
    pub view: View<'a>,
    pub frame: Isometry3<f64>,
}

/// A named frame on a body.
pub(super) struct Site {
    pub name: Option<String>,
    pub body: usize,
    /// In the body's frame.
    pub pose: Isometry3<f64>,
}

/// One body; the first is the world.
pub(super) struct Body<'a> {
    pub element: Id,
    pub name: String,
    pub parent: usize,
    /// In the parent body's frame.
    pub pose: Isometry3<f64>,
    pub inertial: Option<Id>,
    /// Hinges, slides, balls and free joints, in file order.
    pub joints: Vec<Held<'a>>,
    pub geoms: Vec<Held<'a>>,
    pub is_mocap: bool,
}

/// All bodies and sites.
pub(super) struct Bodies<'a> {
    pub bodies: Vec<Body<'a>>,
    pub sites: Vec<Site>,
}

/// Names of bodies, joints and sites, each unique among its kind.
#[derive(Default)]
struct Names(HashMap<(&'static str, String), Id>);

impl Names {
    fn add(&mut self, document: &Document, kind: &'static str, id: Id) -> Result<(), RobotError> {
        let Some(name) = document.text(id, "name").filter(|name| !name.is_empty()) else { return Ok(()) };
        if let Some(first) = self.0.insert((kind, name.to_owned()), id) {
            let fault = document.attribute_fault(id, "name", format!("there are two {kind} named `{name}`"));
            let line = document.source(first).line(document.at(first));
            let help = format!("the other is on line {line} of {}", document.source(first).name());
            return Err(fault.expected("a unique name").help(help).invalid());
        }
        Ok(())
    }
}

/// A child of a body or frame that is still to be read.
struct Pending {
    id: Id,
    body: usize,
    frame: Isometry3<f64>,
    class: Option<String>,
}

impl<'a> Bodies<'a> {
    /// # Errors
    /// Two bodies, joints or sites of one name; two `<inertial>` of one body; poses that are not valid.
    pub fn read(
        document: &'a Document,
        classes: &Classes<'a>,
        compiler: &Compiler,
        ignored: &mut Ignored,
    ) -> Result<Self, RobotError> {
        let world = document.section("worldbody").next().unwrap_or(super::document::ROOT);
        let mut this = Self { bodies: vec![Body::new(world, "world".into(), 0, Isometry3::identity())], sites: vec![] };
        let mut names = Names::default();
        let mut stack = Vec::new();
        for section in document.section("worldbody") {
            classes.check(section, "childclass")?;
            let class = document.text(section, "childclass").map(str::to_owned);
            push_children(document, section, 0, Isometry3::identity(), class, &mut stack);
            while let Some(next) = stack.pop() {
                this.element(document, classes, compiler, next, &mut names, &mut stack, ignored)?;
            }
        }
        this.name_others(&names, ignored);
        Ok(this)
    }

    #[expect(clippy::too_many_arguments, reason = "the state of one walk")]
    fn element(
        &mut self,
        document: &'a Document,
        classes: &Classes<'a>,
        compiler: &Compiler,
        next: Pending,
        names: &mut Names,
        stack: &mut Vec<Pending>,
        ignored: &mut Ignored,
    ) -> Result<(), RobotError> {
        let Pending { id, body, frame, class } = next;
        let inherit = |own: Option<&str>| own.map(str::to_owned).or(class.clone());
        match document.tag(id) {
            tag @ ("body" | "frame") => {
                classes.check(id, "childclass")?;
                let view = View::bare(document, id);
                let own = frame * pose(&view, compiler)?;
                let class = inherit(document.text(id, "childclass"));
                if tag == "frame" {
                    push_children(document, id, body, own, class, stack);
                    return Ok(());
                }
                names.add(document, "bodies", id)?;
                let name = document.text(id, "name").unwrap_or_default();
                if name == "world" {
                    let fault = document.attribute_fault(id, "name", "`world` is the name of the world");
                    return Err(fault.expected("another name").invalid());
                }
                let mut new = Body::new(id, name.to_owned(), body, own);
                new.is_mocap = view.flag("mocap")?.unwrap_or(false);
                let index = self.bodies.len();
                self.bodies.push(new);
                push_children(document, id, index, Isometry3::identity(), class, stack);
            }
            "inertial" => {
                let first = self.bodies[body].inertial.replace(id);
                if first.is_some() {
                    let fault = document.fault(id, format!("body `{}` has two <inertial>", self.bodies[body].name));
                    return Err(fault.expected("one <inertial>").invalid());
                }
            }
            "joint" | "freejoint" => {
                names.add(document, "joints", id)?;
                self.bodies[body].joints.push(Held { view: classes.view(id, class.as_deref())?, frame });
            }
            "geom" => self.bodies[body].geoms.push(Held { view: classes.view(id, class.as_deref())?, frame }),
            "site" => {
                names.add(document, "sites", id)?;
                let view = classes.view(id, class.as_deref())?;
                let name = document.text(id, "name").map(str::to_owned);
                self.sites.push(Site { name, body, pose: frame * between(&view, compiler)?.0 });
            }
            tag @ ("composite" | "flexcomp") => {
                ignored.warning(id, format!("<{tag}> is left out: deformable bodies are not available"));
            }
            tag @ "plugin" => ignored.warning(id, format!("<{tag}> of a body is ignored")),
            // Cameras, lights and unknown elements, which the grammar reports.
            _ => {}
        }
        Ok(())
    }

    /// Gives bodies without a name that of their number.
    fn name_others(&mut self, names: &Names, ignored: &mut Ignored) {
        for (number, body) in self.bodies.iter_mut().enumerate().filter(|(_, b)| b.name.is_empty()) {
            body.name = free_name(&format!("body{number}"), |name| names.0.contains_key(&("bodies", name.to_owned())));
            ignored.note(body.element, "a body without a name is called by its number: `body1`, `body2` and so on");
        }
    }

    /// Poses of all bodies in the world with each joint at its reference.
    pub fn poses(&self) -> Vec<Isometry3<f64>> {
        let mut poses: Vec<Isometry3<f64>> = Vec::with_capacity(self.bodies.len());
        for (i, body) in self.bodies.iter().enumerate() {
            poses.push(if i == 0 { body.pose } else { poses[body.parent] * body.pose });
        }
        poses
    }

    /// For each body, the body directly under the world that it belongs to; the world itself for the world.
    pub fn tops(&self) -> Vec<usize> {
        let mut tops: Vec<usize> = Vec::with_capacity(self.bodies.len());
        for (i, body) in self.bodies.iter().enumerate() {
            tops.push(if body.parent == 0 { i } else { tops[body.parent] });
        }
        tops
    }

    /// The body and those that carry it, up to the world.
    pub fn up_to_world(&self, body: usize) -> impl Iterator<Item = &Body<'a>> {
        let parents = std::iter::successors(Some(body), |&body| Some(self.bodies[body].parent).filter(|_| body != 0));
        parents.map(|body| &self.bodies[body])
    }

    /// The body of that name.
    pub fn named(&self, name: &str) -> Option<usize> {
        self.bodies.iter().position(|body| body.name == name)
    }
}

/// The name, with as many `_` as make it free.
pub(super) fn free_name(name: &str, is_taken: impl Fn(&str) -> bool) -> String {
    let mut name = name.to_owned();
    while is_taken(&name) {
        name.push('_');
    }
    name
}

impl Body<'_> {
    fn new(element: Id, name: String, parent: usize, pose: Isometry3<f64>) -> Self {
        let (joints, geoms) = (Vec::new(), Vec::new());
        Self { element, name, parent, pose, inertial: None, joints, geoms, is_mocap: false }
    }
}

fn push_children(
    document: &Document,
    id: Id,
    body: usize,
    frame: Isometry3<f64>,
    class: Option<String>,
    stack: &mut Vec<Pending>,
) {
    // Reversed, since the stack returns the last one first.
    let children = document.children(id).iter().rev();
    stack.extend(children.map(|&id| Pending { id, body, frame, class: class.clone() }));
}

/// The pose of a geom or site, and its half length if it lies between two points (`fromto`).
pub(super) fn between(view: &View, compiler: &Compiler) -> Result<(Isometry3<f64>, Option<f64>), RobotError> {
    let Some([a, b, c, d, e, f]) = view.array("fromto")? else { return Ok((pose(view, compiler)?, None)) };
    let (from, to) = (Vector3::new(a, b, c), Vector3::new(d, e, f));
    let Some(axis) = nalgebra::Unit::try_new(from - to, 1e-10) else {
        return Err(view.fault("fromto", "two points that differ").invalid());
    };
    let middle = Point3::from(0.5 * (from + to));
    Ok((Isometry3::from_parts(middle.into(), from_z(&axis)), Some(0.5 * (from - to).norm())))
}
