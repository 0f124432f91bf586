//! Reads an MJCF file as a world: bodies as models in the types of SDFormat documents, which have
//! positions in the file.
//!
//! | element | model |
//! |---|---|
//! | geom of the world | static, called as the geom |
//! | body without joints up to the world, and none below | static, called as the body |
//! | body under the world with joints, or that carries some | a mechanism, called as the body |
//!
//! Geoms without a name are called `geomN`, N their number in the file.

use std::collections::HashSet;
use std::path::Path;

use nalgebra::{Isometry3, Vector3};

use super::bodies::{Bodies, Body, between, free_name};
use super::classes::Classes;
use super::compiler::Compiler;
use super::document::{Document, Id};
use super::geoms::{Geom, Geoms};
use super::height_fields::HeightFields;
use super::ignored::{Ignored, Role};
use super::joints::Kind;
use super::meshes::Meshes;
use super::selection::geom_names;
use super::unused_sections;
use super::view::View;
use super::{attach, grammar, inertials, robot_tree};
use crate::robot::model::Geometry as Solid;
use crate::robot::robot_error::RobotError;
use crate::robot::urdf::InertiaPolicy;
use crate::sdf::{At, Geometry, Inertial, Joint, Link, Model, Pose, SdfError, Shape, World, WrittenPose};
use crate::text::source::Source;

/// Reads a world. `skip` is true for names of models that are left out.
///
/// # Errors
/// As for a robot, but several mechanisms or none are no error.
pub(in crate::robot) fn read(source: &Source, skip: &dyn Fn(&str) -> bool) -> Result<(World, Vec<Remark>), RobotError> {
    let mut document = Document::read(source)?;
    attach::expand(&mut document)?;
    let mut ignored = Ignored::of(Role::World);
    let world = world(&document, skip, &mut ignored)?;
    let remarks = ignored.into_list().map(|(id, is_warning, message)| (at(&document, id), is_warning, message));
    Ok((world, remarks.collect()))
}

/// Position, whether it is a warning, and text of a remark.
pub(in crate::robot) type Remark = (At, bool, String);

fn at(document: &Document, id: Id) -> At {
    At { source: document.source(id).clone(), span: document.element(id).span.clone() }
}

/// The error of a file as one of a world.
pub(in crate::robot) fn sdf_error(error: &RobotError, source: &Source) -> SdfError {
    let Some(file) = error.file_error() else {
        return SdfError::new(At { source: source.clone(), span: 0..0 }, error.to_string());
    };
    let at = At { source: file.source.clone(), span: file.span.clone() };
    let error = SdfError::new(at, file.message.clone()).element(&file.element);
    let error = error.found(&file.found).expected(&file.expected);
    match &file.help {
        Some(help) => error.help(help),
        None => error,
    }
}

fn world(document: &Document, skip: &dyn Fn(&str) -> bool, ignored: &mut Ignored) -> Result<World, RobotError> {
    grammar::check(document, ignored)?;
    let compiler = Compiler::read(document)?;
    let classes = Classes::read(document)?;
    let bodies = Bodies::read(document, &classes, &compiler, ignored)?;
    let kinds = robot_tree::joint_kinds(&bodies, document)?;
    let folder = document.sources[0].path().parent().unwrap_or(Path::new("")).to_owned();
    let meshes = Meshes::new(&classes, &document.assets("mesh"), &compiler, &folder)?;
    let geoms = Geoms::new(&classes, &document.assets("material"), meshes)?;
    let height_fields = HeightFields::new(document, &compiler, &folder);
    let names = geom_names(document, &bodies);
    let constrained = unused_sections::report(document, &bodies, ignored);
    let (compiler, bodies) = (&compiler, &bodies);
    let mut reader = Reader { document, compiler, bodies, geoms, height_fields, names, constrained, ignored };
    let models = reader.models(&kinds, skip)?;
    let frames = Vec::new();
    Ok(World { at: at(document, bodies.bodies[0].element), gravity: gravity(document)?, models, frames })
}

fn gravity(document: &Document) -> Result<Option<([f64; 3], At)>, RobotError> {
    let mut gravity = None;
    for id in document.section("option") {
        let own = View::bare(document, id).array::<3>("gravity")?;
        gravity = own.map(|g| (g, at(document, id))).or(gravity);
    }
    Ok(gravity)
}

/// Reads models.
struct Reader<'a, 'd> {
    document: &'a Document,
    compiler: &'a Compiler,
    bodies: &'a Bodies<'d>,
    geoms: Geoms<'a>,
    height_fields: HeightFields<'a>,
    names: Vec<Vec<String>>,
    /// Bodies under the world that a constraint holds.
    constrained: HashSet<usize>,
    ignored: &'a mut Ignored,
}

impl Reader<'_, '_> {
    fn models(&mut self, kinds: &[Vec<Kind>], skip: &dyn Fn(&str) -> bool) -> Result<Vec<Model>, RobotError> {
        let (tops, poses) = (self.bodies.tops(), self.bodies.poses());
        let mut has_joints = vec![false; tops.len()];
        for (i, _) in kinds.iter().enumerate().filter(|(_, kinds)| !kinds.is_empty()) {
            has_joints[tops[i]] = true;
        }
        let mut models = Vec::new();
        for i in 0..tops.len() {
            let name = self.bodies.bodies[i].name.clone();
            if i == 0 {
                self.geoms_of_world(skip, &mut models)?;
            } else if !skip(&self.bodies.bodies[tops[i]].name) {
                match has_joints[tops[i]] {
                    false => models.extend(self.fixed_body(i)?.map(|link| model(name, link, poses[i]))),
                    true if tops[i] == i => models.push(self.mechanism(i, &tops, kinds, &poses)?),
                    true => {}
                }
            }
        }
        Ok(models)
    }

    /// Each geom of the world as a static model.
    fn geoms_of_world(&mut self, skip: &dyn Fn(&str) -> bool, models: &mut Vec<Model>) -> Result<(), RobotError> {
        let world = &self.bodies.bodies[0];
        let taken = |name: &str| self.bodies.named(name).is_some();
        let names: Vec<String> = self.names[0].iter().map(|name| free_name(name, taken)).collect();
        for (k, name) in names.into_iter().enumerate().filter(|(_, name)| !skip(name)) {
            if let Some(shape) = self.shape(0, k)?.0 {
                let mut link = self.link(world);
                link.collisions.push(shape);
                models.push(model(name, link, Isometry3::identity()));
            }
        }
        Ok(())
    }

    /// A static body, if it can be touched.
    fn fixed_body(&mut self, i: usize) -> Result<Option<Link>, RobotError> {
        let body = &self.bodies.bodies[i];
        if body.is_mocap {
            let message = format!("body `{}` stays in place, although it is a mocap body", body.name);
            self.ignored.warning(body.element, message);
        }
        let mut link = self.link(body);
        for k in 0..body.geoms.len() {
            link.collisions.extend(self.shape(i, k)?.0);
        }
        Ok((!link.collisions.is_empty()).then_some(link))
    }

    /// A body under the world and all that it carries.
    fn mechanism(
        &mut self,
        top: usize,
        tops: &[usize],
        kinds: &[Vec<Kind>],
        poses: &[Isometry3<f64>],
    ) -> Result<Model, RobotError> {
        let body = &self.bodies.bodies[top];
        // The root of a robot whose joints lead to the world is the world.
        let is_root = kinds[top].iter().all(|kind| *kind == Kind::Free);
        let pose = if is_root { poses[top] } else { Isometry3::identity() };
        let mut model = model(body.name.clone(), self.link(body), pose);
        model.is_static = false;
        model.links.clear();
        let members: Vec<usize> = (0..tops.len()).filter(|&i| tops[i] == top).collect();
        for &i in &members {
            let body = &self.bodies.bodies[i];
            let mut link = self.link(body);
            link.pose = self.pose(body.element, pose.inv_mul(&poses[i]));
            let mut read = Vec::new();
            for k in 0..body.geoms.len() {
                let (shape, geom) = self.shape(i, k)?;
                link.collisions.extend(shape);
                read.push(geom);
            }
            // A constraint is part of a model only.
            if members.len() == 1 && kinds[top] == [Kind::Free] && !self.constrained.contains(&top) {
                link.inertial = self.inertial(body, &read);
                if link.inertial.is_some() {
                    super::joints::warn_about_free_joint(&body.joints[0], self.ignored)?;
                }
            }
            if i != top || !is_root {
                let parent = if i == top { "world" } else { &self.bodies.bodies[body.parent].name };
                model.joints.push(self.joint(body, parent));
            }
            model.links.push(link);
        }
        Ok(model)
    }

    /// Mass and inertia of a free body. Errors are those of the object that it becomes.
    fn inertial(&mut self, body: &Body, geoms: &[Geom]) -> Option<Inertial> {
        if self.compiler.total_mass > 0.0 {
            return None;
        }
        let policy = InertiaPolicy::Refuse;
        let own = inertials::inertia(self.document, body, geoms, self.compiler, policy, self.ignored).ok()?;
        let pose = self.pose(body.element, Isometry3::translation(own.com.x, own.com.y, own.com.z));
        Some(Inertial { at: pose.at.clone(), pose, mass: own.mass, tensor: own.tensor })
    }

    /// A geom that can be touched, and its mass.
    fn shape(&mut self, body: usize, k: usize) -> Result<(Option<Shape>, Geom), RobotError> {
        let held = &self.bodies.bodies[body].geoms[k];
        let view = &held.view;
        let kind = view.text("type").unwrap_or("sphere");
        if matches!(kind, "plane" | "hfield" | "sdf") {
            let pose = held.frame * between(view, self.compiler)?.0;
            let none = Geom { visual: None, collision: None, inertia: Ok(None) };
            if !Geoms::collides(view)? {
                return Ok((None, none));
            }
            let geometry = match kind {
                "plane" => Geometry::Plane(Vector3::z()),
                "hfield" => match self.height_fields.get(view)? {
                    Ok(heights) => Geometry::Heights(heights),
                    Err(reason) => {
                        self.ignored.warning(view.id(), format!("a height field is left out: {reason}"));
                        return Ok((None, none));
                    }
                },
                _ => Geometry::Other(kind.to_owned()),
            };
            return Ok((Some(self.touched(body, k, pose, geometry)?), none));
        }
        let geom = self.geoms.read(held, self.compiler, self.ignored)?;
        let Some(solid) = &geom.collision else { return Ok((None, geom)) };
        let geometry = match &solid.geometry {
            Solid::Box(size) => Geometry::Box(*size),
            Solid::Sphere(r) => Geometry::Sphere(*r),
            Solid::Cylinder(r, l) => Geometry::Cylinder(*r, *l),
            Solid::Capsule(r, l) => Geometry::Capsule(*r, *l),
            Solid::Mesh(..) => Geometry::Hull(match kind {
                "mesh" => self.geoms.meshes.plain_file(view, self.compiler)?,
                _ => None,
            }),
        };
        let shape = self.touched(body, k, solid.pose, geometry)?;
        Ok((Some(shape), geom))
    }

    fn touched(&self, body: usize, k: usize, pose: Isometry3<f64>, geometry: Geometry) -> Result<Shape, RobotError> {
        let view = &self.bodies.bodies[body].geoms[k].view;
        let mu = match view.list("friction", 1, 3)? {
            Some(list) if list[0] < 0.0 => return Err(view.fault("friction", "numbers, not negative").invalid()),
            list => list.map(|list| (list[0], None)),
        };
        let name = self.names[body][k].clone();
        Ok(Shape { name, at: at(self.document, view.id()), pose: self.pose(view.id(), pose), geometry, rgba: None, mu })
    }

    fn pose(&self, id: Id, pose: Isometry3<f64>) -> WrittenPose {
        let position = pose.translation.vector.into();
        let pose = match pose.rotation == nalgebra::UnitQuaternion::identity() {
            true => Pose::from_rpy(position, [0.0; 3]),
            false => Pose::from_quaternion(position, pose.rotation),
        };
        WrittenPose { pose, relative_to: None, at: at(self.document, id) }
    }

    fn link(&self, body: &Body) -> Link {
        Link {
            name: body.name.clone(),
            at: at(self.document, body.element),
            pose: self.pose(body.element, Isometry3::identity()),
            inertial: None,
            visuals: Vec::new(),
            collisions: Vec::new(),
            sensors: Vec::new(),
        }
    }

    /// That a body moves relative to another one; the object's own reader finds how.
    fn joint(&self, body: &Body, parent: &str) -> Joint {
        let at = at(self.document, body.element);
        Joint {
            // No body has this name: XML has no character 0.
            name: format!("{}\0", body.name),
            kind: "fixed".into(),
            pose: self.pose(body.element, Isometry3::identity()),
            parent: (parent.to_owned(), at.clone()),
            child: (body.name.clone(), at.clone()),
            at,
            axes: Vec::new(),
            sensors: Vec::new(),
        }
    }
}

/// A static model of one link.
fn model(name: String, link: Link, pose: Isometry3<f64>) -> Model {
    let at = link.at.clone();
    let rotated = Pose::from_quaternion(pose.translation.vector.into(), pose.rotation);
    let flat = Pose::from_rpy(pose.translation.vector.into(), [0.0; 3]);
    let pose = if pose.rotation == nalgebra::UnitQuaternion::identity() { flat } else { rotated };
    Model {
        name,
        is_static: true,
        pose: WrittenPose { pose, relative_to: None, at: at.clone() },
        placement_frame: None,
        canonical_link: None,
        links: vec![link],
        joints: Vec::new(),
        frames: Vec::new(),
        models: Vec::new(),
        at,
    }
}
