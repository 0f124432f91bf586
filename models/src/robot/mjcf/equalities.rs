//! `<equality>`: coupled joints and closed loops, and `<contact><exclude>`.
//!
//! A joint constraint is `y - y_0 = a_0 + a_1 (x - x_0) + ... + a_4 (x - x_0)^4` about the
//! reference positions ([MuJoCo], XML reference, `equality/joint`); the model has the coefficients
//! of the powers of x.

use nalgebra::{Isometry3, Point3, Quaternion, Unit, UnitQuaternion, Vector3};

use super::classes::Classes;
use super::ignored::Ignored;
use super::joints::Kind;
use super::moving_tree::{Context, FileJoint, Parts};
use super::view::View;
use crate::robot::closure::{Coupling, LoopClosure, LoopKind};
use crate::robot::coupled_joints;
use crate::robot::model::{Base, JointId, LinkId};
use crate::robot::moving_links::z_to;
use crate::robot::robot_error::RobotError;

/// Least distance of the two points of a pin, m.
const LEAST_PIN: f64 = 1e-6;
/// Deviation of lengths that is rounding of the file's digits, relative.
const ROUNDING: f64 = 1e-9;

/// What holds between links.
#[derive(Default)]
pub(super) struct Conditions {
    pub couplings: Vec<Coupling>,
    pub loops: Vec<LoopClosure>,
}

/// Reads `<equality>`.
///
/// # Errors
/// Names that are not in the file, values that are not valid, two loops of one name.
pub(super) fn read(
    context: &Context,
    classes: &Classes,
    parts: &Parts,
    base: Base,
    ignored: &mut Ignored,
) -> Result<Conditions, RobotError> {
    let document = context.document;
    let poses = context.bodies.poses();
    let mut found = Conditions::default();
    for &id in document.section("equality").flat_map(|section| document.children(section)) {
        let mut view = View::bare(document, id);
        view.levels.extend(classes.equality_defaults(id)?);
        let tag = document.tag(id);
        if view.flag("active")? == Some(false) {
            ignored.note(id, format!("an inactive <{tag}> of <equality> is ignored"));
            continue;
        }
        match tag {
            "joint" => found.couplings.extend(coupling(&view, parts, &found.couplings, ignored)?),
            "connect" | "weld" => {
                let number = found.loops.len();
                let Some(mut closure) = closure(context, &poses, &view, parts, base, ignored)? else { continue };
                closure.name = document.text(id, "name").map_or_else(|| format!("{tag}{number}"), str::to_owned);
                let pins = found.loops.iter_mut().find_map(|first| pin(first, &closure).map(|pin| (first, pin)));
                if let Some((first, pin)) = pins {
                    *first = pin;
                    continue;
                }
                if found.loops.iter().any(|other| other.name == closure.name) {
                    let fault = document.fault(id, format!("there are two loops named `{}`", closure.name));
                    return Err(fault.expected("a unique name").invalid());
                }
                found.loops.push(closure);
            }
            _ => ignored.warning(id, format!("<{tag}> of <equality> is ignored")),
        }
    }
    coupled_joints::sort(&mut found.couplings);
    Ok(found)
}

fn file_joint<'a>(view: &View, attribute: &str, parts: &'a Parts) -> Result<&'a FileJoint, RobotError> {
    let name = view.required(attribute)?;
    let joint = parts.file_joints.iter().find(|joint| joint.name == name);
    let Some(joint) = joint.filter(|joint| matches!(joint.kind, Kind::Hinge | Kind::Slide)) else {
        let scalar = parts.file_joints.iter().filter(|j| matches!(j.kind, Kind::Hinge | Kind::Slide));
        let fault = view.fault(attribute, "the name of a hinge or slide");
        return Err(fault.suggest(name, scalar.map(|j| j.name.as_str())).invalid());
    };
    Ok(joint)
}

fn coupling(
    view: &View,
    parts: &Parts,
    known: &[Coupling],
    ignored: &mut Ignored,
) -> Result<Option<Coupling>, RobotError> {
    let id = view.id();
    let follower = file_joint(view, "joint1", parts)?;
    let polynomial = view.overlay("polycoef", [0.0, 1.0, 0.0, 0.0, 0.0])?;
    let leader = if view.has("joint2") { file_joint(view, "joint2", parts)? } else { follower };
    if view.has("joint2") && leader.name == follower.name {
        return Err(view.fault("joint2", "another joint than joint1").invalid());
    }
    let (Some(joint), Some(of)) = (follower.first, leader.first) else {
        ignored.warning(id, "equalities of bodies that are left out are ignored");
        return Ok(None);
    };
    // A chain of leaders that ends at the follower is a ring.
    let leads = |from: usize| known.iter().find(|c| c.joint.0 == from && c.leader.0 != from).map(|c| c.leader.0);
    let is_ring = of != joint && std::iter::successors(Some(of), |&j| leads(j)).any(|j| j == joint);
    if is_ring || known.iter().any(|c| c.joint.0 == joint) {
        ignored.warning(id, "a joint that follows two others, or itself through others: the later equality is ignored");
        return Ok(None);
    }
    let polynomial = if of == joint { [polynomial[0], 0.0, 0.0, 0.0, 0.0] } else { polynomial };
    let coefficients = shifted(polynomial, leader.reference, follower.reference);
    Ok(Some(Coupling { joint: JointId(joint), leader: JointId(of), coefficients }))
}

/// Coefficients of `y_0 + sum_i a_i (x - x_0)^i` in powers of x, by Horner's scheme.
fn shifted(a: [f64; 5], x0: f64, y0: f64) -> [f64; 5] {
    let mut c = [0.0; 5];
    for a in a.into_iter().rev() {
        // c(x) (x - x_0) + a
        let mut next = [0.0; 5];
        for i in 0..5 {
            next[i] = -x0 * c[i] + if i > 0 { c[i - 1] } else { a };
        }
        c = next;
    }
    c[0] += y0;
    c
}

/// The pin that two balls between the same links are, about the line through their points.
fn pin(first: &LoopClosure, second: &LoopClosure) -> Option<LoopClosure> {
    let is_same = (first.link, first.other) == (second.link, second.other);
    if !is_same || first.kind != LoopKind::Ball || second.kind != LoopKind::Ball {
        return None;
    }
    let along = |from: &Isometry3<f64>, to: &Isometry3<f64>| from.inverse() * Point3::from(to.translation.vector);
    let ends = [along(&first.pose, &second.pose), along(&first.other_pose, &second.other_pose)].map(|p| p.coords);
    let length = ends[0].norm();
    if length < LEAST_PIN || (length - ends[1].norm()).abs() > ROUNDING * length {
        return None;
    }
    let is_along_z = |along: &Vector3<f64>| along.z > 0.0 && along.xy().norm() <= ROUNDING * length;
    let turned = |pose: &Isometry3<f64>, along: &Vector3<f64>| match is_along_z(along) {
        true => *pose,
        false => pose * z_to(&Unit::new_normalize(*along)),
    };
    let (pose, other_pose) = (turned(&first.pose, &ends[0]), turned(&first.other_pose, &ends[1]));
    Some(LoopClosure { kind: LoopKind::Pin, pose, other_pose, ..first.clone() })
}

/// A frame on a body: its index and the pose in the body's frame.
type OnBody = (usize, Isometry3<f64>);

fn closure(
    context: &Context,
    poses: &[Isometry3<f64>],
    view: &View,
    parts: &Parts,
    base: Base,
    ignored: &mut Ignored,
) -> Result<Option<LoopClosure>, RobotError> {
    let is_weld = context.document.tag(view.id()) == "weld";
    let (first, second): (OnBody, OnBody) = if view.has("site1") || view.has("site2") {
        (site(context, view, "site1")?, site(context, view, "site2")?)
    } else {
        let one = body(context, view, "body1")?;
        let two = if view.has("body2") { body(context, view, "body2")? } else { 0 };
        let anchor = view.array::<3>("anchor")?;
        // At the reference positions both frames coincide.
        let of_second = |on_first: Isometry3<f64>| poses[two].inverse() * poses[one] * on_first;
        match (is_weld, anchor) {
            (false, None) => return Err(view.missing("anchor")),
            (false, Some(anchor)) => {
                let on_first = Isometry3::translation(anchor[0], anchor[1], anchor[2]);
                ((one, on_first), (two, of_second(on_first)))
            }
            (true, anchor) => {
                let on_second = Vector3::from(anchor.unwrap_or_default());
                let on_second = Isometry3::from_parts(Point3::from(on_second).into(), UnitQuaternion::identity());
                let [x, y, z, rest @ ..] = view.array("relpose")?.unwrap_or([0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
                // A given pose is that of the anchor of body2 in body1, otherwise it follows from the references.
                let on_first = match UnitQuaternion::try_new(Quaternion::new(rest[0], rest[1], rest[2], rest[3]), 1e-10)
                {
                    Some(turn) => Isometry3::from_parts(Point3::new(x, y, z).into(), turn),
                    None => poses[one].inverse() * poses[two] * on_second,
                };
                ((one, on_first), (two, on_second))
            }
        }
    };
    let on_link = |(body, pose): OnBody| parts.placed[body].map(|(link, frame)| (link, frame * pose));
    let is_static = |body: usize| body == 0 || is_fixed_to_world(context, body);
    let in_world = |(body, pose): OnBody| is_static(body).then(|| poses[body] * pose);
    // The root link of a fixed base stands for the world.
    let root = parts.placed.iter().position(|placed| matches!(placed, Some((LinkId(0), _))));
    let fixed_root = root.filter(|_| base == Base::Fixed).and_then(|i| Some((parts.placed[i]?.1, poses[i])));
    let resolve = |on: OnBody| match (on_link(on), in_world(on), fixed_root) {
        (Some((link, pose)), ..) => Some((Some(link), pose)),
        (None, Some(pose), Some((frame, root))) => Some((Some(LinkId(0)), frame * root.inverse() * pose)),
        (None, Some(pose), None) => Some((None, pose)),
        (None, None, _) => None,
    };
    let kind = if is_weld { LoopKind::Weld } else { LoopKind::Ball };
    let ends = match (resolve(first), resolve(second)) {
        (Some((Some(link), pose)), Some((other, other_pose))) => (link, pose, other, other_pose),
        (Some((None, other_pose)), Some((Some(link), pose))) => (link, pose, None, other_pose),
        _ => {
            ignored.warning(view.id(), "equalities of bodies that are left out are ignored");
            return Ok(None);
        }
    };
    let (link, pose, other, other_pose) = ends;
    if Some(link) == other {
        ignored.warning(view.id(), "a loop within one rigid link is ignored");
        return Ok(None);
    }
    Ok(Some(LoopClosure { name: String::new(), kind, link, pose, other, other_pose }))
}

/// True if the body has no joints up to the world, and no user moves it.
fn is_fixed_to_world(context: &Context, body: usize) -> bool {
    context.bodies.up_to_world(body).all(|body| body.joints.is_empty() && !body.is_mocap)
}

fn body(context: &Context, view: &View, attribute: &str) -> Result<usize, RobotError> {
    let name = view.required(attribute)?;
    context.bodies.named(name).ok_or_else(|| {
        let known = context.bodies.bodies.iter().map(|body| body.name.as_str());
        view.fault(attribute, "the name of a body").suggest(name, known).invalid()
    })
}

fn site(context: &Context, view: &View, attribute: &str) -> Result<OnBody, RobotError> {
    let name = view.required(attribute)?;
    let found = context.bodies.sites.iter().find(|site| site.name.as_deref() == Some(name));
    found.map(|site| (site.body, site.pose)).ok_or_else(|| {
        let known = context.bodies.sites.iter().filter_map(|site| site.name.as_deref());
        view.fault(attribute, "the name of a site").suggest(name, known).invalid()
    })
}

/// Pairs of links of `<contact><exclude>`.
///
/// # Errors
/// A body that is not in the file.
pub(super) fn exclusions(
    context: &Context,
    parts: &Parts,
    ignored: &mut Ignored,
) -> Result<Vec<[LinkId; 2]>, RobotError> {
    let document = context.document;
    let mut pairs = Vec::new();
    for &id in document.section("contact").flat_map(|section| document.children(section)) {
        if document.tag(id) != "exclude" {
            ignored.note(id, "<pair> of <contact> is ignored: the scenario sets contact");
            continue;
        }
        let view = View::bare(document, id);
        let ends = [body(context, &view, "body1")?, body(context, &view, "body2")?];
        if let [Some((a, _)), Some((b, _))] = ends.map(|body| parts.placed[body])
            && a != b
            && !pairs.contains(&[a, b])
        {
            pairs.push([a, b]);
        }
    }
    Ok(pairs)
}

#[cfg(test)]
mod tests {
    use super::shifted;

    #[test]
    fn a_polynomial_about_the_references_has_the_same_values_in_powers_of_x() {
        let (a, x0, y0) = ([0.1, 2.0, -3.0, 0.5, 0.25], 0.7, -0.4);
        let c = shifted(a, x0, y0);
        for x in [-1.0f64, 0.0, 0.3, 2.0] {
            let sum = |p: [f64; 5], x: f64| p.into_iter().rev().fold(0.0, |sum, c| sum * x + c);
            assert!((sum(c, x) - y0 - sum(a, x - x0)).abs() < 1e-12, "{x}");
        }
    }
}
