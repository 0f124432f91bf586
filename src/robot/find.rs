//! Soles of a robot that names none: the lowest collision faces of its leaf links at the home posture.

use nalgebra::{Isometry3, Point3, Vector3};
use parry3d_f64::math::Vector as ParryVector;
use parry3d_f64::transformation::try_convex_hull;

use super::model::{Base, Geometry, Link, LinkId, Model, Shape, Sole};
use super::notice::Notices;
use super::outline;
use super::posture::link_poses;
use super::source::Source;

/// A leaf whose lowest point is within this fraction of the robot's height above the lowest one stands on it.
const STANDING: f64 = 0.02;
/// A face tilted further than this from level at home (cosine) is not stood upon.
const LEVEL: f64 = 0.87;
/// Facets whose normals agree to this (cosine; about 1 degree) are one face.
const SAME_FACE: f64 = 0.99985;
/// Corners of the prism that stands for a round sole.
const ROUND: usize = 8;
/// More vertices than this make contact patterns too many.
const MOST_VERTICES: usize = 8;

/// Adds the soles found to the model and tells each one as a notice.
pub(super) fn find_soles(model: &mut Model, source: &Source, notices: &mut Notices) {
    let at = source.text().find("<robot").unwrap_or(0);
    if model.base == Base::Fixed {
        notices.info(source, at, "no soles: none are given, and a fixed base does not stand on any");
        return;
    }
    let poses = link_poses(model, &model.home);
    let is_leaf = |i: usize| !model.links.iter().any(|l| l.parent == Some(LinkId(i)));
    let leaves: Vec<usize> = (0..model.links.len()).filter(|&i| is_leaf(i)).collect();
    let corners = |i: usize| -> Vec<Vector3<f64>> {
        let points = model.links[i].collisions.iter().flat_map(|s| extreme_points(s, &poses[i]));
        points.collect()
    };
    let heights = |i: usize| corners(i).into_iter().map(|p| (poses[i] * Point3::from(p)).z).collect::<Vec<_>>();
    let all: Vec<f64> = (0..model.links.len()).flat_map(heights).collect();
    let lowest_of = |heights: &[f64]| heights.iter().copied().fold(f64::INFINITY, f64::min);
    let (low, high) = (lowest_of(&all), all.iter().copied().fold(f64::NEG_INFINITY, f64::max));
    let mut found = Vec::new();
    for i in leaves {
        if lowest_of(&heights(i)) <= low + STANDING * (high - low) {
            let vertices = lowest_face(&model.links[i], &poses[i]);
            let name = model.links[i].name.clone();
            let back = model.links[i].urdf_frame.inverse();
            let listed: Vec<String> = vertices.iter().map(|v| triple(&(back * Point3::from(*v)).coords)).collect();
            notices.info(source, at, format!("sole `{name}` found on link `{name}`: polygon [{}]", listed.join(", ")));
            found.push(Sole { name, link: LinkId(i), vertices });
        }
    }
    if found.is_empty() {
        let words = "no soles: none are given, and no leaf link has a collision shape at the robot's lowest height";
        notices.warning(source, at, words);
    }
    model.soles = found;
}

fn triple(v: &Vector3<f64>) -> String {
    // Rounding to the nanometre, and no minus before a zero.
    let show = |x: f64| ((x * 1e9).round() / 1e9) + 0.0;
    format!("[{}, {}, {}]", show(v.x), show(v.y), show(v.z))
}

/// Vertices of the lowest face of a link's collision shapes, in its internal frame, counter-clockwise seen from above.
fn lowest_face(link: &Link, pose: &Isometry3<f64>) -> Vec<Vector3<f64>> {
    let height = |p: &Vector3<f64>| (pose * Point3::from(*p)).z;
    let lowest = |s: &Shape| extreme_points(s, pose).iter().map(height).fold(f64::INFINITY, f64::min);
    let Some(foot) = link.collisions.iter().min_by(|a, b| lowest(a).total_cmp(&lowest(b))) else { return Vec::new() };
    let points = if is_round(foot, pose) {
        extreme_points(foot, pose)
    } else {
        link.collisions.iter().filter(|s| !is_round(s, pose)).flat_map(|s| extreme_points(s, pose)).collect()
    };
    let up = pose.rotation.inverse() * Vector3::z();
    let down_face = if is_round(foot, pose) { None } else { hull_face(&points, &-up) };
    let vertices = down_face.unwrap_or_else(|| {
        let low = points.iter().map(height).fold(f64::INFINITY, f64::min);
        // Points as low as the lowest, to rounding.
        points.iter().copied().filter(|p| height(p) <= low + 1e-9).collect()
    });
    outline::simplify(outline::convex_outline(&vertices, &up), MOST_VERTICES)
}

/// Rolls rather than stands: a sphere, a capsule, a cylinder lying down.
fn is_round(shape: &Shape, pose: &Isometry3<f64>) -> bool {
    match shape.geometry {
        Geometry::Sphere(_) | Geometry::Capsule(..) => true,
        Geometry::Cylinder(..) => (pose.rotation * shape.pose.rotation * Vector3::z()).z.abs() < LEVEL,
        _ => false,
    }
}

/// Points among which the lowest of the shape are, in the link's internal frame; `pose` is the link's in the world.
fn extreme_points(shape: &Shape, pose: &Isometry3<f64>) -> Vec<Vector3<f64>> {
    let down = (pose.rotation * shape.pose.rotation).inverse() * -Vector3::z();
    let local: Vec<Vector3<f64>> = match &shape.geometry {
        Geometry::Box(size) => (0..8)
            .map(|i| Vector3::from_fn(|axis, _| if i >> axis & 1 == 1 { 0.5 * size[axis] } else { -0.5 * size[axis] }))
            .collect(),
        Geometry::Sphere(radius) => vec![down * *radius],
        Geometry::Capsule(radius, length) => {
            [-0.5, 0.5].iter().map(|s| Vector3::z() * (s * length) + down * *radius).collect()
        }
        Geometry::Cylinder(radius, length) if is_round(shape, pose) => {
            let side = Vector3::new(down.x, down.y, 0.0).normalize() * *radius;
            [-0.5, 0.5].iter().map(|s| Vector3::z() * (s * length) + side).collect()
        }
        Geometry::Cylinder(radius, length) => (0..2 * ROUND)
            .map(|i| {
                let angle = std::f64::consts::TAU * ((i / 2) as f64 + 0.5) / ROUND as f64;
                let z = if i % 2 == 0 { -0.5 * length } else { 0.5 * length };
                Vector3::new(radius * angle.cos(), radius * angle.sin(), z)
            })
            .collect(),
        Geometry::Mesh(points, _) => points.iter().map(|p| p.coords).collect(),
    };
    local.into_iter().map(|p| (shape.pose * Point3::from(p)).coords).collect()
}

/// Vertices of the face of the convex hull that looks most nearly along `down`; none when no face is level enough.
fn hull_face(points: &[Vector3<f64>], down: &Vector3<f64>) -> Option<Vec<Vector3<f64>>> {
    let input: Vec<ParryVector> = points.iter().map(|p| ParryVector::new(p.x, p.y, p.z)).collect();
    let (hull, triangles) = try_convex_hull(&input).ok()?;
    let hull: Vec<Vector3<f64>> = hull.iter().map(|p| Vector3::new(p.x, p.y, p.z)).collect();
    let normal = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| hull[i as usize]);
        (b - a).cross(&(c - a)).try_normalize(0.0)
    };
    let level = |t: &&[u32; 3]| normal(t).map_or(-1.0, |n| n.dot(down));
    let best = triangles.iter().max_by(|a, b| level(a).total_cmp(&level(b)))?;
    if level(&best) < LEVEL {
        return None;
    }
    let best_normal = normal(best)?;
    let same = triangles.iter().filter(|t| normal(t).is_some_and(|n| n.dot(&best_normal) > SAME_FACE));
    // Facets of that slope elsewhere on the hull cannot exist: a convex body has one face per normal.
    Some(same.flatten().map(|&i| hull[i as usize]).collect())
}
