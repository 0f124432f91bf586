//! Detects the soles of a robot that names none: the lowest faces of its leaf links at the home
//! posture, by their collision shapes, or by the visual shapes of a link without collision shapes. Wheels and a
//! body of one round shape have none: they roll.

use nalgebra::{Isometry3, Point3, Vector3};

use super::link_poses::link_poses;
use super::mesh_simplification;
use super::model::{Base, Geometry, JointKind, Link, LinkId, Model, Shape, Sole};
use super::notices::Notices;
use super::xml_syntax::root_element;
use crate::geometry::outline;
use crate::geometry::spatial_hull::{convex_hull_3d, outermost, spread};
use crate::math;
use crate::text::source::Source;

/// A leaf whose lowest point is within this fraction of the robot's height above the lowest one has
/// a sole. Round shapes of one link within it form one sole.
const STANDING: f64 = 0.02;
/// A foot smaller than this fraction of the robot's height in all directions is a point.
const POINT: f64 = 0.03;
/// A foot narrower than this fraction of the robot's height is a line.
const LINE: f64 = 0.01;
/// A face tilted further than this from level at home (cosine) is no sole.
const LEVEL: f64 = 0.87;
/// Facets whose normals agree to this (cosine; about 1 degree) are one face.
const SAME_FACE: f64 = 0.99985;
/// Greatest number of points that all enter the hull; of more points only the outermost do. The
/// cost of the hull grows as the square of their number.
const MAX_POINTS: usize = 10_000;
/// Directions over the sphere along which outermost points are searched: 1.9 degrees apart, more
/// than the angle within one face.
const DIRECTIONS: usize = 12_000;
/// Corners of the prism that replaces a round sole.
const ROUND_CORNERS: usize = 8;
/// Distance of the middle of a wheel from the axis of its joint, m, and sine between their axes, up to which it turns
/// in place.
const OFF_AXIS: f64 = 1e-3;
const ASKEW: f64 = 0.01;
/// Greatest number of vertices of a sole: more have too many contact patterns.
const MAX_VERTICES: usize = 8;

/// Adds the detected soles to the model, each with a notice.
pub(super) fn find_soles(model: &mut Model, source: &Source, notices: &mut Notices) {
    let at = root_element(source);
    if model.base == Base::Fixed {
        notices.info(source, at, "no soles: none are given, and a fixed base needs none");
        return;
    }
    let poses = link_poses(model, &model.home);
    let heights = |i: usize| {
        let points = shapes_of(&model.links[i]).iter().flat_map(|s| extreme_points(s, &poses[i]));
        points.map(|p| (poses[i] * Point3::from(p)).z).collect::<Vec<f64>>()
    };
    let lowest: Vec<f64> = (0..model.links.len()).map(|i| least(heights(i))).collect();
    let high = (0..model.links.len()).flat_map(heights).fold(f64::NEG_INFINITY, f64::max);
    let low = least(lowest.iter().copied());
    let height = high - low;
    let is_leaf = |i: usize| !model.links.iter().any(|l| l.parent == Some(LinkId(i)));
    let (mut found, mut rolls) = (Vec::new(), false);
    for i in (0..model.links.len()).filter(|&i| is_leaf(i) && lowest[i] <= low + STANDING * height) {
        let link = &model.links[i];
        if link.parent.is_none() && matches!(&link.collisions[..], [ball] if is_round(ball, &poses[i])) {
            notices.info(source, at, format!("no sole on `{}`: it is round, and touches with its shape", link.name));
            rolls = true;
            continue;
        }
        if is_wheel(model, i) {
            notices.info(source, at, format!("no sole on `{}`: it is a wheel, and rolls on its shape", link.name));
            rolls = true;
            continue;
        }
        let Foot { vertices, flattened } = foot(shapes_of(link), &poses[i], height);
        let name = link.name.clone();
        let back = link.urdf_frame.inverse();
        let listed: Vec<String> = vertices.iter().map(|v| vector_text(&(back * Point3::from(*v)).coords)).collect();
        let by = if link.collisions.is_empty() { ", by its visual shapes" } else { "" };
        // Moves below a hundredth of a millimetre are rounding of mesh files.
        let moved = match flattened {
            d if d > 1e-5 => format!(" (vertices moved by up to {:.2} mm onto one plane)", 1e3 * d),
            _ => String::new(),
        };
        let polygon = listed.join(", ");
        notices.info(source, at, format!("sole `{name}` found on link `{name}`{by}: polygon [{polygon}]{moved}"));
        found.push(Sole { name, link: LinkId(i), vertices });
    }
    if found.is_empty() && !rolls {
        let message = "no soles: none are given, and no leaf link has a shape at the robot's lowest height";
        notices.warning(source, at, message);
    }
    model.soles = found;
}

fn least(numbers: impl IntoIterator<Item = f64>) -> f64 {
    numbers.into_iter().fold(f64::INFINITY, f64::min)
}

/// The shapes that can form a link's sole.
fn shapes_of(link: &Link) -> &[Shape] {
    if link.collisions.is_empty() { &link.visuals } else { &link.collisions }
}

fn vector_text(v: &Vector3<f64>) -> String {
    // Rounded to the nanometre; adding 0 turns -0 into 0.
    let rounded = |x: f64| ((x * 1e9).round() / 1e9) + 0.0;
    format!("[{}, {}, {}]", rounded(v.x), rounded(v.y), rounded(v.z))
}

/// A detected sole.
struct Foot {
    /// Vertices in the link's internal frame, counter-clockwise seen from above, m.
    vertices: Vec<Vector3<f64>>,
    /// Greatest distance by which a vertex was moved onto the plane, m.
    flattened: f64,
}

/// The lowest face of a link's shapes; `height` is the whole robot's.
fn foot(shapes: &[Shape], pose: &Isometry3<f64>, height: f64) -> Foot {
    let up = pose.rotation.inverse() * Vector3::z();
    let level = |p: &Vector3<f64>| (pose * Point3::from(*p)).z;
    let lowest = |s: &Shape| least(extreme_points(s, pose).iter().map(level));
    let Some(first) = shapes.iter().min_by(|a, b| lowest(a).total_cmp(&lowest(b))) else {
        return Foot { vertices: Vec::new(), flattened: 0.0 };
    };
    let is_rolling = is_round(first, pose);
    let reach = lowest(first) + STANDING * height;
    let is_part = |s: &&Shape| is_round(s, pose) == is_rolling && (!is_rolling || lowest(s) <= reach);
    let points: Vec<Vector3<f64>> = shapes.iter().filter(is_part).flat_map(|s| extreme_points(s, pose)).collect();
    let face = if is_rolling { Some((points.clone(), up)) } else { down_face(&points, &-up).map(|(f, n)| (f, -n)) };
    let low = least(points.iter().map(level));
    let bottom = || -> Vec<Vector3<f64>> {
        // Points as low as the lowest up to rounding.
        points.iter().copied().filter(|p| level(p) <= low + 1e-9).collect()
    };
    let (vertices, normal) = face.unwrap_or_else(|| (bottom(), up));
    let mut outline = outline::convex_outline(&vertices, &up);
    let (length, ends) = outline::diameter(&outline);
    // Primitives are exact; the smallest facets of a mesh approximate a round surface.
    let is_mesh = matches!(first.geometry, Geometry::Mesh(..));
    if is_mesh && length < POINT * height {
        let centre = outline.iter().sum::<Vector3<f64>>() / outline.len() as f64;
        return Foot { vertices: vec![centre], flattened: 0.0 };
    }
    if is_mesh && outline::width(&outline, &up) < LINE * height {
        outline = ends.to_vec();
    }
    let mut vertices = outline::simplify(outline, MAX_VERTICES);
    let flattened = if vertices.len() > 3 { flatten(&mut vertices, &normal) } else { 0.0 };
    Foot { vertices, flattened }
}

/// Moves points along the plane's normal onto the plane through the outermost one; returns the
/// largest move. Points that are in a plane up to rounding stay.
fn flatten(points: &mut [Vector3<f64>], normal: &Vector3<f64>) -> f64 {
    let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
    let outermost = least(points.iter().map(|p| normal.dot(p)));
    let off = |p: &Vector3<f64>| normal.dot(p) - outermost;
    let furthest = points.iter().map(off).fold(0.0, f64::max);
    if furthest <= 1e-9 * size {
        return 0.0;
    }
    for p in points.iter_mut() {
        *p -= normal * off(p);
    }
    furthest
}

/// True for shapes that roll: a sphere, a capsule, a horizontal cylinder.
fn is_round(shape: &Shape, pose: &Isometry3<f64>) -> bool {
    match shape.geometry {
        Geometry::Sphere(_) | Geometry::Capsule(..) => true,
        Geometry::Cylinder(..) => (pose.rotation * shape.pose.rotation * Vector3::z()).z.abs() < LEVEL,
        _ => false,
    }
}

/// Whether a link turns without limits about the axis of all its collision shapes: balls, capsules and cylinders.
fn is_wheel(model: &Model, link: usize) -> bool {
    // The joint turns about z of the link's internal frame.
    let is_on_axis = |shape: &Shape| {
        let axis = shape.pose.rotation * Vector3::z();
        let is_along = axis.xy().norm() <= ASKEW;
        let turns_in_place = match shape.geometry {
            Geometry::Sphere(_) => true,
            Geometry::Capsule(..) | Geometry::Cylinder(..) => is_along,
            _ => false,
        };
        turns_in_place && shape.pose.translation.vector.xy().norm() <= OFF_AXIS
    };
    let shapes = &model.links[link].collisions;
    let is_continuous = link > 0 && model.joints[link - 1].kind == JointKind::Continuous;
    is_continuous && !shapes.is_empty() && shapes.iter().all(is_on_axis)
}

/// Points that include the lowest ones of the shape, in the link's internal frame; `pose` is that
/// of the link in the world.
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
        Geometry::Cylinder(radius, length) => (0..2 * ROUND_CORNERS)
            .map(|i| {
                let angle = std::f64::consts::TAU * ((i / 2) as f64 + 0.5) / ROUND_CORNERS as f64;
                let z = if i % 2 == 0 { -0.5 * length } else { 0.5 * length };
                Vector3::new(radius * math::cos(angle), radius * math::sin(angle), z)
            })
            .collect(),
        Geometry::Mesh(points, _) => points.iter().map(|p| p.coords).collect(),
    };
    local.into_iter().map(|p| (shape.pose * Point3::from(p)).coords).collect()
}

/// Vertices and outward normal of the largest face of the convex hull whose normal is close enough
/// to `down`; none without such a face.
fn down_face(points: &[Vector3<f64>], down: &Vector3<f64>) -> Option<(Vec<Vector3<f64>>, Vector3<f64>)> {
    if let Some(normal) = common_normal(points, down) {
        return (normal.dot(down) >= LEVEL).then(|| (points.to_vec(), normal));
    }
    let outer = if points.len() > MAX_POINTS { outermost(points, &sole_directions(down)) } else { points.to_vec() };
    let outer: Vec<Point3<f64>> = outer.into_iter().map(Point3::from).collect();
    let (hull, triangles) = convex_hull_3d(&outer)?;
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| hull[i as usize].coords);
        0.5 * (b - a).cross(&(c - a))
    };
    let unit = |v: Vector3<f64>| v.try_normalize(0.0);
    let facing: Vec<([u32; 3], Vector3<f64>, Vector3<f64>)> = triangles
        .iter()
        .filter_map(|t| Some((*t, area(t), unit(area(t))?)))
        .filter(|(_, _, normal)| normal.dot(down) >= LEVEL)
        .collect();
    // A convex body has one face per normal, so facets of equal normal are one face.
    let size_about = |n: &Vector3<f64>| -> f64 {
        facing.iter().filter(|(_, _, normal)| normal.dot(n) > SAME_FACE).map(|(_, area, _)| area.norm()).sum()
    };
    let sizes: Vec<f64> = facing.iter().map(|(_, _, normal)| size_about(normal)).collect();
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    // The most level one among faces that are equal up to rounding.
    let best = facing
        .iter()
        .zip(&sizes)
        .filter(|(_, size)| **size >= (1.0 - 1e-9) * largest)
        .max_by(|((_, _, a), _), ((_, _, b), _)| a.dot(down).total_cmp(&b.dot(down)))?;
    let same = || facing.iter().filter(|(_, _, normal)| normal.dot(&best.0.2) > SAME_FACE);
    let normal = unit(same().map(|(_, area, _)| area).sum())?;
    Some((same().flat_map(|(t, _, _)| t.map(|i| hull[i as usize].coords)).collect(), normal))
}

/// Directions of possible sole normals, and some over the whole sphere so that the hull has volume.
fn sole_directions(down: &Vector3<f64>) -> Vec<Vector3<f64>> {
    // The normal of a facet is between the directions of its corners.
    let near = |d: &Vector3<f64>| d.dot(down) >= LEVEL - 0.02;
    let dense = spread(DIRECTIONS).into_iter().filter(near);
    dense.chain(spread(mesh_simplification::DIRECTIONS)).collect()
}

/// The normal, towards `down`, of points in one plane: a flat mesh has no convex hull.
fn common_normal(points: &[Vector3<f64>], down: &Vector3<f64>) -> Option<Vector3<f64>> {
    let first = points.first()?;
    let far = points.iter().map(|p| p - first).max_by(|a, b| a.norm().total_cmp(&b.norm()))?;
    let across = points.iter().map(|p| far.cross(&(p - first))).max_by(|a, b| a.norm().total_cmp(&b.norm()))?;
    let normal = across.try_normalize(1e-9 * far.norm_squared())?;
    let is_flat = points.iter().all(|p| normal.dot(&(p - first)).abs() <= 1e-9 * far.norm());
    is_flat.then(|| normal * normal.dot(down).signum())
}
