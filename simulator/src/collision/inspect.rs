//! Self-collision section of `runner inspect`.

use std::fmt::Write;

use super::spatial::{CollisionModel, WhyBody, WhyPair};

/// Bodies, triangles and pairs of a robot, with the reasons why bodies or pairs are not monitored.
pub fn inspect(model: &CollisionModel) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write(&mut out, model);
    out
}

fn write(out: &mut String, model: &CollisionModel) -> std::fmt::Result {
    let (bodies, pairs) = (model.bodies.len(), model.pairs.len());
    writeln!(out, "\nself-collision: {bodies} bodies of {} triangles in all, {pairs} pairs", model.triangles())?;
    for body in &model.bodies {
        let p = &body.polytope;
        writeln!(out, "  {:<20} {} vertices, {} triangles", body.name, p.vertices.len(), p.triangles.len())?;
    }
    for body in &model.dropped_bodies {
        let why = match &body.why {
            WhyBody::NotListed => "the robot file does not list it".into(),
            WhyBody::Inside(outer) => format!("always inside {outer}"),
            WhyBody::NoHull => "its shapes are flat or have too many corners".into(),
        };
        writeln!(out, "  not a body: {:<20} {why}", body.name)?;
    }
    let name = |body: usize| model.bodies[body].name.as_str();
    for (i, body) in model.bodies.iter().enumerate() {
        let others = model.pairs.iter().filter(|p| p.bodies[0] == i).map(|p| name(p.bodies[1]));
        let others: Vec<&str> = others.collect();
        if !others.is_empty() {
            writeln!(out, "  watched: {} with {}", body.name, others.join(", "))?;
        }
    }
    let search = &model.search;
    for pair in &model.dropped_pairs {
        let why = match pair.why {
            WhyPair::Ignored => "the robot file ignores it".into(),
            WhyPair::Adjacent => "adjacent".into(),
            WhyPair::OverlapAtHome(depth) => format!("overlap at home, {:.1} mm deep", 1e3 * depth),
            WhyPair::CannotMeet(least) => format!("never nearer than {:.0} mm", 1e3 * least),
        };
        writeln!(out, "  not watched: {} with {}: {why}", name(pair.bodies[0]), name(pair.bodies[1]))?;
    }
    if model.dropped_pairs.iter().any(|p| matches!(p.why, WhyPair::CannotMeet(_))) {
        writeln!(
            out,
            "  (nearest of {} random postures and {} descents of {} steps; pairs that come within {:.0} mm are watched; seed {})",
            search.postures,
            search.descents,
            search.steps,
            1e3 * search.margin,
            search.seed
        )?;
    }
    Ok(())
}
