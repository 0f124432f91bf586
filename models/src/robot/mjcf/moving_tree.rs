//! Builds the tree of moving links from the bodies: bodies without joints are welded to their
//! parents, several joints of a body are a chain, and each joint axis becomes z.
//!
//! A body with joints has the pose `P A_1 J_1(q_1 - r_1) A_1^-1 A_2 J_2(q_2 - r_2) A_2^-1 ...` in
//! its parent, with P its pose in the file, A the internal frame of a joint in the body's axes, J
//! the motion about or along z, and r the reference (`ref`).

use std::collections::HashSet;

use nalgebra::{Isometry3, Vector3};

use super::bodies::{Bodies, free_name};
use super::compiler::Compiler;
use super::document::{Document, Id};
use super::geoms::{Geom, Geoms};
use super::ignored::Ignored;
use super::inertials;
use super::joints::{Kind, internal_frame, motions, warn_about_free_joint};
use super::robot_tree::RobotTree;
use crate::robot::model::{Base, Joint, JointKind, Link, LinkId, Merged};
use crate::robot::movable_links::without_inertia;
use crate::robot::moving_links::{MAX_JOINTS, bare_link};
use crate::robot::rigid_inertia::{RigidInertia, examine, moments_text};
use crate::robot::robot_error::RobotError;
use crate::robot::urdf::InertiaPolicy;

/// A joint of the file, whether it belongs to the robot or not.
pub(super) struct FileJoint {
    pub name: String,
    pub kind: Kind,
    pub body: usize,
    /// Index of its first joint in the model.
    pub first: Option<usize>,
    /// Position at which the body has the pose of the file.
    pub reference: f64,
}

/// The moving tree.
pub(super) struct Parts {
    pub links: Vec<Link>,
    pub joints: Vec<Joint>,
    /// Positions at which the bodies have the poses of the file.
    pub references: Vec<f64>,
    /// All joints of the file in the order of `qpos`.
    pub file_joints: Vec<FileJoint>,
    /// For each body of the robot, its link and the pose of its frame in the link's internal frame.
    pub placed: Vec<Option<(LinkId, Isometry3<f64>)>>,
}

/// What all parts of a file refer to.
pub(super) struct Context<'a> {
    pub document: &'a Document,
    pub compiler: &'a Compiler,
    pub bodies: &'a Bodies<'a>,
    pub kinds: &'a [Vec<Kind>],
}

/// Builds links and joints.
///
/// # Errors
/// Values of joints, geoms and inertias that are not valid; a link that moves without inertia; too
/// many joints.
pub(super) fn build(
    context: &Context,
    tree: &RobotTree,
    geoms: &mut Geoms,
    policy: InertiaPolicy,
    ignored: &mut Ignored,
) -> Result<Parts, RobotError> {
    let Context { document, compiler, bodies, .. } = *context;
    let tops = bodies.tops();
    let root_name = if tree.has_world { "world" } else { &bodies.bodies[tree.tops[0]].name };
    let mut parts = Parts {
        links: vec![bare_link(root_name, None)],
        joints: Vec::new(),
        references: Vec::new(),
        file_joints: Vec::new(),
        placed: vec![None; bodies.bodies.len()],
    };
    let mut elements: Vec<Id> = vec![bodies.bodies[tree.tops[0]].element];
    let mut total = 0.0;
    if tree.has_world {
        parts.placed[0] = Some((LinkId(0), Isometry3::identity()));
    }
    let chosen: HashSet<usize> = tree.tops.iter().copied().collect();
    let names: HashSet<&str> =
        bodies.bodies.iter().flat_map(|b| &b.joints).filter_map(|j| own_name(document, j.view.id())).collect();
    // The world is a part only as scenery.
    for (i, body) in bodies.bodies.iter().enumerate().skip(usize::from(!tree.is_scenery)) {
        let is_part = chosen.contains(if tree.is_scenery { &i } else { &tops[i] });
        add_joints(context, (i, is_part), &names, &mut parts, &mut elements, ignored)?;
        if !is_part && (compiler.total_mass <= 0.0 || tree.is_scenery) {
            continue;
        }
        let mut read = Vec::new();
        for held in &body.geoms {
            read.push(geoms.read(held, compiler, ignored)?);
        }
        let own = match tree.is_scenery {
            true => RigidInertia { mass: 0.0, com: Vector3::zeros(), tensor: nalgebra::Matrix3::zeros() },
            false => inertials::inertia(document, body, &read, compiler, policy, ignored)?,
        };
        total += own.mass;
        if is_part && let Some((carrier, frame)) = parts.placed[i] {
            add_body(&mut parts.links[carrier.0], &own, &frame, read);
        }
    }
    if parts.joints.len() > MAX_JOINTS {
        let fault = document.fault(elements[MAX_JOINTS], "the robot has too many moving joints");
        return Err(fault.found(parts.joints.len()).expected(format!("at most {MAX_JOINTS}")).invalid());
    }
    if compiler.total_mass > 0.0 && total > 0.0 {
        let factor = compiler.total_mass / total;
        for link in &mut parts.links {
            link.mass *= factor;
            link.inertia *= factor;
        }
    }
    check(document, tree.base, &parts, &elements)?;
    Ok(parts)
}

fn add_body(link: &mut Link, own: &RigidInertia, frame: &Isometry3<f64>, geoms: Vec<Geom>) {
    link.set_body(&link.body().plus(&own.transformed(frame)));
    for geom in geoms {
        let place =
            |shape: crate::robot::model::Shape| crate::robot::model::Shape { pose: frame * shape.pose, ..shape };
        link.visuals.extend(geom.visual.map(place));
        link.collisions.extend(geom.collision.map(place));
    }
}

/// Adds the joints of a body, and the links that they move.
fn add_joints(
    context: &Context,
    (index, is_part): (usize, bool),
    names: &HashSet<&str>,
    parts: &mut Parts,
    elements: &mut Vec<Id>,
    ignored: &mut Ignored,
) -> Result<(), RobotError> {
    let Context { document, compiler, bodies, kinds } = *context;
    let body = &bodies.bodies[index];
    // A top body under a root link that is not the world is that root.
    let parent = parts.placed[body.parent].map(|(carrier, frame)| (carrier, frame * body.pose));
    let mut at = if is_part { parent.or(Some((LinkId(0), Isometry3::identity()))) } else { None };
    let mut last = None;
    for (held, &kind) in body.joints.iter().zip(&kinds[index]) {
        let element = held.view.id();
        let name = own_name(document, element).map_or_else(
            || {
                if kind != Kind::Free {
                    ignored
                        .note(element, "a joint without a name is called by its number: `joint0`, `joint1` and so on");
                }
                free_name(&format!("joint{}", parts.file_joints.len()), |name| names.contains(name))
            },
            str::to_owned,
        );
        let first = parts.joints.len();
        let mut reference = 0.0;
        if kind == Kind::Free && is_part {
            warn_about_free_joint(held, ignored)?;
        }
        if kind != Kind::Free {
            let moves = motions(held, kind, &name, compiler, ignored)?;
            reference = moves[0].reference;
            for motion in moves.into_iter().take(if at.is_some() { 3 } else { 0 }) {
                let Some((carrier, frame)) = at else { continue };
                let internal = internal_frame(&motion);
                let at_zero = frame * internal * moved(&motion.joint, -motion.reference);
                let mut link = bare_link(&format!("{}/{}", body.name, motion.joint.name), Some(carrier));
                link.rotation = at_zero.rotation.to_rotation_matrix().into_inner();
                link.offset = at_zero.translation.vector;
                link.urdf_frame = internal.inverse();
                at = Some((LinkId(parts.links.len()), link.urdf_frame));
                last = Some(parts.links.len());
                parts.links.push(link);
                parts.joints.push(motion.joint);
                parts.references.push(motion.reference);
                elements.push(element);
            }
        }
        let first = (is_part && kind != Kind::Free).then_some(first);
        parts.file_joints.push(FileJoint { name, kind, body: index, first, reference });
    }
    parts.placed[index] = at;
    match (last, at) {
        (Some(link), _) => parts.links[link].name.clone_from(&body.name),
        (None, Some((carrier, pose))) if parts.links[carrier.0].name != body.name => {
            parts.links[carrier.0].merged.push(Merged { name: body.name.clone(), pose });
        }
        _ => {}
    }
    Ok(())
}

fn own_name(document: &Document, id: Id) -> Option<&str> {
    document.text(id, "name").filter(|name| !name.is_empty())
}

/// The motion of a joint by `q`, in its internal frame.
fn moved(joint: &Joint, q: f64) -> Isometry3<f64> {
    match joint.kind {
        JointKind::Prismatic => Isometry3::translation(0.0, 0.0, q),
        _ if q == 0.0 => Isometry3::identity(),
        _ => Isometry3::rotation(Vector3::z() * q),
    }
}

/// Checks that every link that can accelerate has inertia along its joint.
fn check(document: &Document, base: Base, parts: &Parts, elements: &[Id]) -> Result<(), RobotError> {
    let Some(&i) = without_inertia(&parts.links, &parts.joints, base).last() else { return Ok(()) };
    let link = &parts.links[i];
    let fault = match link.mass {
        0.0 => document.fault(elements[i], format!("link `{}` moves but has no mass", link.name)),
        _ => document
            .fault(elements[i], format!("link `{}` moves but has no inertia about its joint", link.name))
            .found(moments_text(examine(&link.inertia).0)),
    };
    Err(fault.expected("an <inertial>, or geoms with mass").invalid())
}
