//! Closed loops of a robot file, `[[loop]]`.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use toml::Spanned;

use super::apply_robot_file::known_link;
use super::closure::{LoopClosure, LoopKind};
use super::link_poses::link_poses;
use super::model::{LinkId, Model};
use super::robot_error::{FileError, RobotError};
use super::robot_file::{LoopEntry, LoopWord};
use crate::text::angle::Angle;
use crate::text::source::Source;

/// The second side of a loop to the world.
const WORLD: &str = "world";

/// Shortest rod, m.
const SHORTEST_ROD: f64 = 1e-6;

/// Adds the loops. Needs the home posture.
pub(super) fn add(entries: &[Spanned<LoopEntry>], source: &Source, model: &mut Model) -> Result<(), RobotError> {
    let poses = link_poses(model, &model.home);
    for entry in entries {
        let closure = closure(entry, source, model, &poses)?;
        model.loops.push(closure);
    }
    Ok(())
}

/// An error of an entry at a position of the file.
struct Entry<'a> {
    source: &'a Source,
    element: String,
}

impl Entry<'_> {
    fn fault(&self, span: std::ops::Range<usize>, message: String, expected: &str) -> RobotError {
        FileError::new(self.source, span, message).element(&self.element).expected(expected).invalid()
    }

    /// A vector of finite numbers.
    fn vector(&self, key: &str, given: &Option<Spanned<[f64; 3]>>) -> Result<Option<Vector3<f64>>, RobotError> {
        let Some(given) = given else { return Ok(None) };
        if given.get_ref().iter().all(|x| x.is_finite()) {
            return Ok(Some(Vector3::from(*given.get_ref())));
        }
        Err(self.fault(given.span(), format!("{key} of {} is not finite", self.element), "three finite numbers"))
    }

    /// A rotation whose z is along an axis.
    fn axis(&self, key: &str, given: &Option<Spanned<[f64; 3]>>) -> Result<Option<UnitQuaternion<f64>>, RobotError> {
        let Some(axis) = self.vector(key, given)? else { return Ok(None) };
        let span = given.as_ref().map_or(0..0, Spanned::span);
        let Some(axis) = axis.try_normalize(1e-6) else {
            return Err(self.fault(span, format!("{key} of {} has length 0", self.element), "a direction"));
        };
        let half_turn = || UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI);
        Ok(Some(UnitQuaternion::rotation_between(&Vector3::z(), &axis).unwrap_or_else(half_turn)))
    }
}

fn rotation(rpy: &Option<Spanned<[Angle; 3]>>) -> Option<UnitQuaternion<f64>> {
    let [roll, pitch, yaw] = rpy.as_ref()?.get_ref().map(|angle| angle.value);
    Some(UnitQuaternion::from_euler_angles(roll, pitch, yaw))
}

fn closure(
    spanned: &Spanned<LoopEntry>,
    source: &Source,
    model: &Model,
    poses: &[Isometry3<f64>],
) -> Result<LoopClosure, RobotError> {
    let entry = spanned.get_ref();
    let at = Entry { source, element: format!("loop `{}`", entry.name) };
    if model.loops.iter().any(|other| other.name == entry.name) {
        let message = format!("there are two loops named `{}`", entry.name);
        return Err(at.fault(spanned.span(), message, "a unique name"));
    }
    check_keys(entry, &at)?;
    let (link, frame) = known_link(&entry.link, &at.element, source, model)?;
    let (other, other_frame) = match entry.to.get_ref().as_str() {
        WORLD if model.link(WORLD).is_none() => (None, Isometry3::identity()),
        _ => known_link(&entry.to, &at.element, source, model).map(|(link, frame)| (Some(link), frame))?,
    };
    if other == Some(link) {
        let message = format!("{} joins `{}` to the same rigid body", at.element, entry.link.get_ref());
        return Err(at.fault(entry.to.span(), message, "a link that moves relative to the first one"));
    }
    let turn = at.axis("axis", &entry.axis)?.or(rotation(&entry.rpy)).unwrap_or_default();
    let position = at.vector("position", &entry.position)?.unwrap_or_default();
    let pose = frame * Isometry3::from_parts(position.into(), turn);
    // The first frame, seen from the second link's URDF frame, at home.
    let of_second = |LinkId(other)| poses[other] * other_frame;
    let at_home = other.map_or_else(Isometry3::identity, of_second).inverse() * poses[link.0] * pose;
    let to_position = at.vector("to_position", &entry.to_position)?;
    let other_point = to_position.map_or(at_home.translation, Translation3::from);
    let other_turn = at.axis("to_axis", &entry.to_axis)?.or(rotation(&entry.to_rpy)).unwrap_or(at_home.rotation);
    let other_pose = other_frame * Isometry3::from_parts(other_point, other_turn);
    let kind = match entry.kind {
        LoopWord::Ball => LoopKind::Ball,
        LoopWord::Pin => LoopKind::Pin,
        LoopWord::Weld => LoopKind::Weld,
        LoopWord::Rod => {
            let between = (Point3::from(at_home.translation.vector) - Point3::from(other_point.vector)).norm();
            let length = entry.length.as_ref().map_or(between, |length| *length.get_ref());
            if !(length.is_finite() && length >= SHORTEST_ROD) {
                let span = entry.length.as_ref().map_or(spanned.span(), Spanned::span);
                let message = format!("the length of {} cannot be used", at.element);
                let fault = FileError::new(source, span, message).found(length).element(&at.element);
                return Err(fault.expected("a length above 0, or points apart at home").invalid());
            }
            LoopKind::Rod(length)
        }
    };
    Ok(LoopClosure { name: entry.name.clone(), kind, link, pose, other, other_pose })
}

/// Refuses keys that the kind of the loop does not have.
fn check_keys(entry: &LoopEntry, at: &Entry) -> Result<(), RobotError> {
    let span_of = |given: &Option<Spanned<[f64; 3]>>| given.as_ref().map(Spanned::span);
    let span_of_angles = |given: &Option<Spanned<[Angle; 3]>>| given.as_ref().map(Spanned::span);
    let (pin, weld, rod) = ([LoopWord::Pin], [LoopWord::Weld], [LoopWord::Rod]);
    for (key, span, kinds, of) in [
        ("axis", span_of(&entry.axis), pin, "a pin"),
        ("to_axis", span_of(&entry.to_axis), pin, "a pin"),
        ("rpy", span_of_angles(&entry.rpy), weld, "a weld"),
        ("to_rpy", span_of_angles(&entry.to_rpy), weld, "a weld"),
        ("length", entry.length.as_ref().map(Spanned::span), rod, "a rod"),
    ] {
        if let Some(span) = span.filter(|_| !kinds.contains(&entry.kind)) {
            let message = format!("{} has `{key}`, which only {of} has", at.element);
            return Err(at.fault(span, message, &format!("no `{key}`, or another `type`")));
        }
    }
    Ok(())
}
