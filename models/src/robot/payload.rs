//! Loads that the robot file welds to links: a backpack, hands that the URDF leaves out.
//!
//! A homogeneous box of mass m and edges a, b, c has `Ixx = m (b^2 + c^2) / 12` about its centre,
//! and cyclically.

use nalgebra::{Translation3, Vector3};
use toml::Spanned;

use super::adjustments::add_payload;
use super::apply_robot_file::known_link;
use super::model::{Geometry, Model, Shape};
use super::robot_error::{FileError, RobotError};
use super::robot_file::PayloadEntry;
use crate::text::source::Source;

/// Red, green, blue, opacity of a load given by its size.
const COLOUR: [f32; 4] = [0.36, 0.37, 0.40, 1.0];

/// Adds every load to its link, in file order. Errors have positions in the robot file.
pub(super) fn weld(loads: &[Spanned<PayloadEntry>], source: &Source, model: &mut Model) -> Result<(), RobotError> {
    for (i, entry) in loads.iter().enumerate() {
        let load = entry.get_ref();
        let element = format!("payload `{}`", load.name);
        if loads[..i].iter().any(|other| other.get_ref().name == load.name) {
            let fault = FileError::new(source, entry.span(), format!("there are two payloads named `{}`", load.name));
            return Err(fault.element(element).expected("a unique name").invalid());
        }
        known_link(&load.link, &element, source, model)?;
        let mass = *load.mass.get_ref();
        let position = load.position.as_ref().map_or(Vector3::zeros(), |p| Vector3::from(*p.get_ref()));
        if let (Some(_), Some(size)) = (&load.inertia, &load.size) {
            let fault = FileError::new(source, size.span(), format!("{element} has both `inertia` and `size`"));
            return Err(fault.element(element).expected("one of them, or none for a point mass").invalid());
        }
        let added = match &load.size {
            Some(size) => add_box(model, load.link.get_ref(), mass, position, *size.get_ref()),
            None => {
                let inertia = load.inertia.as_ref().map_or([0.0; 6], |inertia| *inertia.get_ref());
                add_payload(model, load.link.get_ref(), mass, position, inertia)
            }
        };
        added.map_err(|error| match error {
            RobotError::BadValue { subject, found, expected } => {
                let span = match subject.split(' ').next() {
                    Some("mass") => Some(load.mass.span()),
                    Some("position") => load.position.as_ref().map(Spanned::span),
                    Some("size") => load.size.as_ref().map(Spanned::span),
                    _ => load.inertia.as_ref().map(Spanned::span),
                };
                let fault = FileError::new(source, span.unwrap_or(entry.span()), subject);
                fault.element(&element).found(found).expected(expected).invalid()
            }
            other => other,
        })?;
    }
    Ok(())
}

/// Welds a homogeneous box to the link named `link` and draws it: mass (kg), centre (m) in the
/// link's URDF frame, edges (m) along its axes. Errors: as [`add_payload`], and a size that is
/// not positive.
pub fn add_box(
    model: &mut Model,
    link: &str,
    mass: f64,
    centre: Vector3<f64>,
    size: [f64; 3],
) -> Result<(), RobotError> {
    let [a, b, c] = size;
    if !size.iter().all(|x| x.is_finite() && *x > 0.0) {
        let subject = format!("size of the payload on link `{link}` is not a box");
        let expected = "three finite lengths above 0".to_owned();
        return Err(RobotError::BadValue { subject, found: format!("{size:?}"), expected });
    }
    let twelfth = mass / 12.0;
    let inertia = [twelfth * (b * b + c * c), twelfth * (a * a + c * c), twelfth * (a * a + b * b), 0.0, 0.0, 0.0];
    add_payload(model, link, mass, centre, inertia)?;
    draw(model, link, centre, Vector3::from(size));
    Ok(())
}

fn draw(model: &mut Model, link: &str, centre: Vector3<f64>, size: Vector3<f64>) {
    if let Some((carrier, frame)) = model.link(link) {
        let pose = frame * Translation3::from(centre);
        model.links[carrier.0].visuals.push(Shape { pose, geometry: Geometry::Box(size), rgba: COLOUR });
    }
}
