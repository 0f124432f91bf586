//! Loads that the robot file welds to links: a backpack, hands that the URDF leaves out.
//!
//! A homogeneous box of mass m and edges a, b, c has `Ixx = m (b^2 + c^2) / 12` about its centre, and cyclically.

use nalgebra::{Translation3, Vector3};
use toml::Spanned;

use super::adjust::add_payload;
use super::apply::known_link;
use super::error::RobotError;
use super::file::PayloadEntry;
use super::model::{Geometry, Model, Shape};
use super::source::Source;

/// Red, green, blue, opacity of a load given by its size.
const COLOUR: [f32; 4] = [0.36, 0.37, 0.40, 1.0];

/// Adds every load to its link, in file order. Faults carry the place in the robot file.
pub(super) fn weld(loads: &[Spanned<PayloadEntry>], source: &Source, model: &mut Model) -> Result<(), RobotError> {
    for entry in loads {
        let load = entry.get_ref();
        let element = format!("payload `{}`", load.name);
        known_link(&load.link, &element, source, model)?;
        let mass = *load.mass.get_ref();
        let position = load.position.as_ref().map_or(Vector3::zeros(), |p| Vector3::from(*p.get_ref()));
        let inertia = match (&load.inertia, &load.size) {
            (Some(_), Some(size)) => {
                let fault = source.fault(size.span(), format!("{element} has both `inertia` and `size`"));
                return Err(fault.element(element).wanted("one of them, or none for a point mass").invalid());
            }
            (Some(inertia), None) => *inertia.get_ref(),
            (None, Some(size)) => box_inertia(mass, size, &element, source)?,
            (None, None) => [0.0; 6],
        };
        add_payload(model, load.link.get_ref(), mass, position, inertia).map_err(|error| match error {
            RobotError::BadValue { subject, seen, wanted } => {
                let place = match subject.split(' ').next() {
                    Some("mass") => Some(load.mass.span()),
                    Some("position") => load.position.as_ref().map(Spanned::span),
                    _ => load.inertia.as_ref().map(Spanned::span),
                };
                let fault = source.fault(place.unwrap_or(entry.span()), subject);
                fault.element(&element).seen(seen).wanted(wanted).invalid()
            }
            other => other,
        })?;
        if let Some(size) = &load.size {
            draw(model, load.link.get_ref(), position, Vector3::from(*size.get_ref()));
        }
    }
    Ok(())
}

/// `[ixx, iyy, izz, ixy, ixz, iyz]` of a homogeneous box about its centre, kg m^2.
fn box_inertia(mass: f64, size: &Spanned<[f64; 3]>, element: &str, source: &Source) -> Result<[f64; 6], RobotError> {
    let [a, b, c] = *size.get_ref();
    if ![a, b, c].iter().all(|x| x.is_finite() && *x > 0.0) {
        let fault = source.fault(size.span(), format!("size of {element} is no box")).seen(format!("{:?}", [a, b, c]));
        return Err(fault.element(element).wanted("three finite lengths above 0").invalid());
    }
    let twelfth = mass / 12.0;
    Ok([twelfth * (b * b + c * c), twelfth * (a * a + c * c), twelfth * (a * a + b * b), 0.0, 0.0, 0.0])
}

fn draw(model: &mut Model, link: &str, centre: Vector3<f64>, size: Vector3<f64>) {
    if let Some((carrier, frame)) = model.link(link) {
        let pose = frame * Translation3::from(centre);
        model.links[carrier.0].visuals.push(Shape { pose, geometry: Geometry::Box(size), rgba: COLOUR });
    }
}
