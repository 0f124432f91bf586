//! Selects a part of a file by name: a body under the world, or one geom.

use std::collections::HashSet;

use super::bodies::{Bodies, Body, Held, free_name};
use super::document::Document;
use crate::robot::robot_error::RobotError;

/// A part of a file.
pub(super) enum Selection {
    /// A body under the world with what it carries.
    Top(usize),
    /// A geom, which is all that remains of its body.
    Geom(usize),
}

/// Selects the body under the world of that name, or removes all geoms but `MODEL::BODY::GEOM`.
///
/// # Errors
/// There is none.
pub(super) fn select(bodies: &mut Bodies, document: &Document, name: &str) -> Result<Selection, RobotError> {
    let is_top = |(i, body): &(usize, &Body)| *i > 0 && body.parent == 0 && body.name == name;
    if let Some((top, _)) = bodies.bodies.iter().enumerate().find(is_top) {
        return Ok(Selection::Top(top));
    }
    let names = geom_names(document, bodies);
    for (body, names) in names.iter().enumerate() {
        let prefix = format!("::{}::", bodies.bodies[body].name);
        let is_selected = |geom: &String| name.strip_suffix(geom).is_some_and(|rest| rest.ends_with(&prefix));
        let is_fixed = bodies.up_to_world(body).all(|body| body.joints.is_empty());
        if let Some(k) = names.iter().position(is_selected).filter(|_| is_fixed) {
            let held = bodies.bodies[body].geoms.swap_remove(k);
            bodies.bodies[body].geoms = vec![held];
            return Ok(Selection::Geom(body));
        }
    }
    let tops = bodies.bodies.iter().skip(1).filter(|body| body.parent == 0);
    let fault = document.fault(bodies.bodies[0].element, format!("the file has no body `{name}` under the world"));
    Err(fault.suggest(name, tops.map(|body| body.name.as_str())).invalid())
}

/// Names of the geoms of each body. No two geoms of the file have the same one.
pub(super) fn geom_names(document: &Document, bodies: &Bodies) -> Vec<Vec<String>> {
    let all = bodies.bodies.iter().flat_map(|body| &body.geoms);
    let taken: HashSet<&str> = all.filter_map(|held| own_name(document, held)).collect();
    let mut number = 0;
    let mut name = |held: &Held| {
        number += 1;
        let unnamed = || free_name(&format!("geom{}", number - 1), |name| taken.contains(name));
        own_name(document, held).map_or_else(unnamed, str::to_owned)
    };
    bodies.bodies.iter().map(|body| body.geoms.iter().map(&mut name).collect()).collect()
}

fn own_name<'a>(document: &'a Document, held: &Held) -> Option<&'a str> {
    document.text(held.view.id(), "name").filter(|name| !name.is_empty())
}
