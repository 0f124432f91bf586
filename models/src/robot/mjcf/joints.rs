//! Joints: hinges, slides, and balls as chains of three hinges.

use nalgebra::{Isometry3, Point3, Unit, UnitQuaternion, Vector3};

use super::bodies::Held;
use super::compiler::Compiler;
use super::ignored::Ignored;
use crate::robot::model::{Joint, JointKind};
use crate::robot::moving_links::free_joint;
use crate::robot::robot_error::RobotError;

/// One motion of a joint.
pub(super) struct Motion {
    pub joint: Joint,
    /// Unit axis in the body's frame.
    pub axis: Unit<Vector3<f64>>,
    /// A point of the axis in the body's frame.
    pub anchor: Point3<f64>,
    /// Position at which the body has the pose of the file.
    pub reference: f64,
}

/// Kind of a joint element.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    Free,
    Ball,
    Slide,
    Hinge,
}

impl Kind {
    pub fn of(held: &Held) -> Result<Self, RobotError> {
        let view = &held.view;
        if view.document.tag(view.id()) == "freejoint" {
            return Ok(Self::Free);
        }
        Ok(match view.word("type", &["free", "ball", "slide", "hinge"])? {
            Some("free") => Self::Free,
            Some("ball") => Self::Ball,
            Some("slide") => Self::Slide,
            _ => Self::Hinge,
        })
    }

    /// Numbers in `qpos`.
    pub fn positions(self) -> usize {
        match self {
            Self::Free => 7,
            Self::Ball => 4,
            _ => 1,
        }
    }

    /// Joints of the model.
    pub fn motions(self) -> usize {
        match self {
            Self::Free => 0,
            Self::Ball => 3,
            _ => 1,
        }
    }
}

/// The motions of a hinge, slide or ball, parent's side first.
pub(super) fn motions(
    held: &Held,
    kind: Kind,
    name: &str,
    compiler: &Compiler,
    ignored: &mut Ignored,
) -> Result<Vec<Motion>, RobotError> {
    let view = &held.view;
    let id = view.id();
    let anchor = held.frame * Point3::from(view.array::<3>("pos")?.unwrap_or_default());
    let unit = if kind == Kind::Slide { 1.0 } else { compiler.angle };
    let mut plain =
        free_joint(name.to_owned(), if kind == Kind::Slide { JointKind::Prismatic } else { JointKind::Continuous });
    plain.drive_configured = false;
    // Later numbers of both are coefficients of powers of the speed or of the angle.
    let first = |attribute| -> Result<f64, RobotError> {
        let list = view.list(attribute, 1, 3)?.unwrap_or(vec![0.0]);
        if list[0] < 0.0 {
            return Err(view.fault(attribute, "numbers, the first not negative").invalid());
        }
        Ok(list[0])
    };
    if view.list("damping", 1, 3)?.is_some_and(|list| list[1..].iter().any(|x| *x != 0.0)) {
        ignored.warning(id, "of `damping` of <joint> only the linear part is read");
    }
    plain.damping = first("damping")?;
    if first("stiffness")? != 0.0 {
        ignored.warning(id, "attribute `stiffness` of <joint> is ignored: springs of joints are not available");
    }
    plain.friction = view.amount("frictionloss")?;
    plain.armature = view.amount("armature")?;
    if let Some([low, high]) = view.range("actuatorfrcrange", "actuatorfrclimited", compiler.autolimits)? {
        plain.effort_limit = larger(low, high, id, "actuatorfrcrange", ignored);
    }
    let range = view.range("range", "limited", compiler.autolimits || kind == Kind::Ball)?;
    if kind == Kind::Ball {
        if range.is_some() {
            ignored.warning(id, "`range` of a ball joint is ignored: its cone has no counterpart");
        }
        let message = format!(
            "joint `{name}` is modelled as the chain of `{name}/yaw`, `{name}/pitch` and `{name}/roll`; it must not \
             pitch by 90 degrees"
        );
        ignored.warning(id, message);
        if plain.armature > 0.0 || plain.damping > 0.0 || plain.friction > 0.0 {
            ignored.warning(id, "armature, damping and friction of a ball joint act on its yaw, pitch and roll");
        }
        let part = |(suffix, axis): (&str, Unit<Vector3<f64>>)| {
            let joint = Joint { name: format!("{name}/{suffix}"), ..plain.clone() };
            Motion { joint, axis: held.frame.rotation * axis, anchor, reference: 0.0 }
        };
        let axes = [("yaw", Vector3::z_axis()), ("pitch", Vector3::y_axis()), ("roll", Vector3::x_axis())];
        return Ok(axes.into_iter().map(part).collect());
    }
    if let Some([low, high]) = range {
        (plain.lower, plain.upper) = (low * unit, high * unit);
        if kind == Kind::Hinge {
            plain.kind = JointKind::Revolute;
        }
    }
    let axis = Vector3::from(view.array::<3>("axis")?.unwrap_or([0.0, 0.0, 1.0]));
    let Some(axis) = Unit::try_new(axis, 1e-10) else {
        return Err(view.fault("axis", "a direction of length above 0").invalid());
    };
    let reference = view.number("ref")?.unwrap_or(0.0) * unit;
    Ok(vec![Motion { joint: plain, axis: held.frame.rotation * axis, anchor, reference }])
}

/// The larger end of a range of efforts; the model's limits are symmetric.
pub(super) fn larger(low: f64, high: f64, id: usize, attribute: &str, ignored: &mut Ignored) -> f64 {
    if low != -high {
        ignored.warning(id, format!("`{attribute}` is not symmetric: its larger end limits both directions"));
    }
    low.abs().max(high.abs())
}

/// Yaw, pitch and roll of a quaternion `w x y z`, as the chain of a ball joint has them.
pub(super) fn ball_angles([w, x, y, z]: [f64; 4]) -> [f64; 3] {
    // MuJoCo takes 0 as no rotation.
    let q = UnitQuaternion::try_new(nalgebra::Quaternion::new(w, x, y, z), 1e-15).unwrap_or_default();
    let (roll, pitch, yaw) = q.euler_angles();
    [yaw, pitch, roll]
}

/// The pose of a motion's internal frame in the body's frame: origin on the anchor, z along the axis.
pub(super) fn internal_frame(motion: &Motion) -> Isometry3<f64> {
    Isometry3::from_parts(motion.anchor.coords.into(), crate::robot::moving_links::z_to(&motion.axis))
}

/// Reports what a free joint has beyond its freedom.
pub(super) fn warn_about_free_joint(held: &Held, ignored: &mut Ignored) -> Result<(), RobotError> {
    let (document, element) = (held.view.document, held.view.id());
    for name in ["armature", "damping", "frictionloss", "stiffness"] {
        if held.view.list(name, 1, 3)?.is_some_and(|list| list[0] != 0.0) && document.tag(element) == "joint" {
            ignored.warning(element, format!("`{name}` of a free joint is ignored"));
        }
    }
    Ok(())
}
