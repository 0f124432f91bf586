//! Sensors: one IMU for each site with a gyroscope, accelerometer or orientation, one force sensor
//! for each site with a force or torque sensor.

use super::bodies::Bodies;
use super::document::Document;
use super::ignored::Ignored;
use super::moving_tree::Parts;
use super::view::View;
use crate::robot::model::{Mount, SensorFrame, SensorFrames};
use crate::robot::robot_error::RobotError;

/// Reads all sensors.
///
/// # Errors
/// A site that is not in the file.
pub(super) fn read(
    document: &Document,
    bodies: &Bodies,
    parts: &Parts,
    ignored: &mut Ignored,
) -> Result<SensorFrames, RobotError> {
    let mut sensors = SensorFrames::default();
    for &id in document.section("sensor").flat_map(|section| document.children(section)) {
        let tag = document.tag(id);
        let view = View::bare(document, id);
        let attribute = match tag {
            "gyro" | "accelerometer" | "force" | "torque" => "site",
            "framequat" if document.text(id, "objtype") == Some("site") && !view.has("refname") => "objname",
            _ => {
                ignored.note(id, format!("sensors <{tag}> are ignored"));
                continue;
            }
        };
        let name = view.required(attribute)?;
        let Some(site) = bodies.sites.iter().find(|site| site.name.as_deref() == Some(name)) else {
            let known = bodies.sites.iter().filter_map(|site| site.name.as_deref());
            return Err(view.fault(attribute, "the name of a site").suggest(name, known).invalid());
        };
        let Some((link, frame)) = parts.placed[site.body] else {
            ignored.warning(id, "sensors of bodies that are left out are ignored");
            continue;
        };
        let list = if matches!(tag, "force" | "torque") { &mut sensors.force } else { &mut sensors.imu };
        if !list.iter().any(|sensor| sensor.name == name) {
            list.push(SensorFrame { name: name.to_owned(), mount: Mount { link, pose: frame * site.pose } });
        }
    }
    Ok(sensors)
}
