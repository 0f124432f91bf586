//! `[self_collision]` of a robot file.

use std::ops::RangeInclusive;

use toml::Spanned;

use super::apply_robot_file::known_link;
use super::model::{LinkId, Model};
use super::robot_error::{FileError, RobotError};
use super::robot_file::RobotFile;
use crate::text::source::Source;

/// Range of the resolution: fewer corners distort cylinders, more cost time without benefit.
const RESOLUTION: RangeInclusive<u32> = 8..=128;

/// Links that are checked for collisions with each other, and the resolution of their polyhedra.
#[derive(Clone, PartialEq, Debug)]
pub struct SelfCollision {
    /// Checked links; `None`: all that have collision shapes.
    pub bodies: Option<Vec<LinkId>>,
    /// Pairs that are not checked.
    pub ignore: Vec<[LinkId; 2]>,
    /// Pairs that are always checked.
    pub watch: Vec<[LinkId; 2]>,
    /// Corners of the polygon around a circle.
    pub resolution: usize,
}

impl Default for SelfCollision {
    fn default() -> Self {
        Self { bodies: None, ignore: Vec::new(), watch: Vec::new(), resolution: 16 }
    }
}

/// Reads `[self_collision]`. A link that is welded to another one is part of it.
pub(super) fn read(file: &RobotFile, source: &Source, model: &Model) -> Result<SelfCollision, RobotError> {
    let mut settings = SelfCollision::default();
    let Some(entry) = &file.self_collision else { return Ok(settings) };
    let entry = entry.get_ref();
    let link = |name: &Spanned<String>| known_link(name, "self_collision", source, model).map(|(link, _)| link);
    let listed = |name: &Spanned<String>| {
        let id = link(name)?;
        if model.links[id.0].collisions.is_empty() {
            let message = format!("link `{}` has no collision shapes", name.get_ref());
            let fault = FileError::new(source, name.span(), message).element("self_collision.bodies");
            return Err(fault.expected("a link with a <collision>").invalid());
        }
        Ok(id)
    };
    let pair = |names: &[Spanned<String>; 2]| {
        let pair = [link(&names[0])?, link(&names[1])?];
        if pair[0] == pair[1] {
            let message = format!("`{}` and `{}` are one body", names[0].get_ref(), names[1].get_ref());
            let fault = FileError::new(source, names[1].span(), message).element("self_collision");
            return Err(fault.expected("two links that move against each other").invalid());
        }
        Ok(pair)
    };
    if let Some(bodies) = &entry.bodies {
        settings.bodies = Some(bodies.iter().map(listed).collect::<Result<_, _>>()?);
    }
    settings.ignore = entry.ignore.iter().map(pair).collect::<Result<_, _>>()?;
    settings.watch = entry.watch.iter().map(pair).collect::<Result<_, _>>()?;
    if let Some(resolution) = &entry.resolution {
        if !RESOLUTION.contains(resolution.get_ref()) {
            let fault = FileError::new(source, resolution.span(), "self_collision.resolution cannot be used");
            let expected = format!("{} to {}", RESOLUTION.start(), RESOLUTION.end());
            return Err(fault.element("self_collision").found(resolution.get_ref()).expected(expected).invalid());
        }
        settings.resolution = *resolution.get_ref() as usize;
    }
    Ok(settings)
}
