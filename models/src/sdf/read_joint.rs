//! Reads joints.

use nalgebra::Vector3;

use super::document::{At, Axis, Joint, Mimic, SdfError};
use super::geometry::pose;
use super::read_model::{Version, sensors};
use super::remarks::Remarks;
use super::xml::Element;

/// A `<joint>`.
pub(super) fn joint(element: &Element, version: Version, remarks: &mut Remarks) -> Result<Joint, SdfError> {
    element.check_children(remarks);
    let name = element.name()?;
    let kind = element.attribute("type").unwrap_or_default().to_owned();
    let end = |tag| -> Result<(String, At), SdfError> {
        let end = element.required(tag)?;
        // Files before version 1.4 have `<parent link="...">`.
        let text = end.named("link").unwrap_or_else(|| end.text().to_owned());
        match text.is_empty() {
            true => Err(end.bad_value("the name of a link or frame")),
            false => Ok((text, end.at_value())),
        }
    };
    let mut axes = Vec::new();
    for tag in ["axis", "axis2"] {
        if let Some(axis) = element.child(tag)? {
            axes.push(self::axis(&axis, version, remarks)?);
        }
    }
    Ok(Joint {
        name,
        kind,
        at: element.at(),
        pose: pose(element, remarks)?,
        parent: end("parent")?,
        child: end("child")?,
        axes,
        sensors: sensors(element, remarks)?,
    })
}

/// The axis is written in the frame `expressed_in`, by default the joint's. Before version 1.7 it
/// is written in the model's frame with `use_parent_model_frame`, and before 1.5 always.
fn axis(element: &Element, version: Version, remarks: &mut Remarks) -> Result<Axis, SdfError> {
    element.check_children(remarks);
    let mut in_model = version < Version(1, 5);
    if let Some(choice) = element.child("use_parent_model_frame")? {
        in_model = choice.truth()?;
    }
    let (mut xyz, mut expressed_in) = (Vector3::z(), None);
    if let Some(direction) = element.child("xyz")? {
        xyz = direction.numbers::<3>()?.into();
        if xyz.norm() < 1e-6 {
            return Err(direction.bad_value("a direction, such as 0 0 1"));
        }
        expressed_in = direction.named("expressed_in");
    }
    if in_model {
        expressed_in = expressed_in.or(Some("__model__".into()));
    }
    let (mut lower, mut upper, mut effort, mut velocity) = (None, None, None, None);
    if let Some(limit) = element.child("limit")? {
        limit.check_children(remarks);
        (lower, upper) = (limit.limit("lower")?, limit.limit("upper")?);
        // Negative values stand for none.
        effort = limit.limit("effort")?.filter(|x| *x >= 0.0);
        velocity = limit.limit("velocity")?.filter(|x| *x >= 0.0);
        if let (Some(l), Some(u)) = (lower, upper)
            && l > u
        {
            let message = format!("{}: the lower limit is above the upper", element.describe());
            return Err(limit.error(message).found(format!("{l} > {u}")).expected("lower <= upper"));
        }
    }
    let (mut damping, mut friction) = (0.0, 0.0);
    if let Some(dynamics) = element.child("dynamics")? {
        dynamics.check_children(remarks);
        let number = |tag| dynamics.number(tag, |x| x >= 0.0, "a finite number, not negative");
        (damping, friction) = (number("damping")?.unwrap_or(0.0), number("friction")?.unwrap_or(0.0));
        if number("spring_stiffness")?.is_some_and(|k| k != 0.0) {
            let message = format!("the spring of {} is ignored", element.describe());
            remarks.warning(dynamics.at(), message);
        }
    }
    let mimic = match element.child("mimic")? {
        Some(mimic) => Some(self::mimic(&mimic, remarks)?),
        None => None,
    };
    let at = element.at();
    Ok(Axis { at, xyz, expressed_in, lower, upper, effort, velocity, damping, friction, mimic })
}

fn mimic(element: &Element, remarks: &mut Remarks) -> Result<Mimic, SdfError> {
    element.check_children(remarks);
    let Some(joint) = element.named("joint") else {
        let message = format!("{}: <mimic> names no joint", element.describe());
        return Err(element.error(message).expected("joint=\"...\""));
    };
    let number = |tag, default| -> Result<f64, SdfError> {
        Ok(element.number(tag, |_| true, "a finite number")?.unwrap_or(default))
    };
    let axis = element.named("axis").unwrap_or_else(|| "axis".into());
    let (multiplier, offset) = (number("multiplier", 1.0)?, number("offset", 0.0)?);
    Ok(Mimic { at: element.at(), joint, axis, multiplier, offset, reference: number("reference", 0.0)? })
}
