//! Crossings of borders of flat regions: lines, and rims of cylinders.
//!
//! O owns the plane with the normal m. A crossing z lies on the border of I, and over or below that of O. Its
//! measure g is positive if it exists:
//!
//! ```text
//! line, line        z on both lines                             parameters inside both lines
//! line of O, rim    where the rim meets the plane of the line   depth of the line in the rim, parameter
//!                   and m
//! rim of O, line    at the distance R from the axis of O        likewise
//! rim, rim          above the common points of both circles     r + R - d, d - |r - R|
//! ```
//!
//! with the distance d of the centres. Lines and rims cross, and rims cross each other, in two points.

use super::{ConvexBody, Placement};
use nalgebra::Vector3;

/// Least sine between borders that cross, and least distance of the centres of rims, m.
const LEVEL: f64 = 1e-9;

/// A part of a border, world, m.
#[derive(Clone, Copy)]
pub(super) enum Border {
    /// From `start` in the unit direction `along`.
    Line { start: Vector3<f64>, along: Vector3<f64>, length: f64 },
    /// Across `axis`.
    Circle { centre: Vector3<f64>, axis: Vector3<f64>, radius: f64 },
}

/// A crossing of two borders.
pub(super) struct Crossing {
    /// World, m.
    pub z: Vector3<f64>,
    /// Tangent of the border of I.
    pub e: Vector3<f64>,
    /// Direction in the plane across the border of O.
    pub q: Vector3<f64>,
    /// Positive if the crossing exists, m.
    pub g: f64,
}

impl Border {
    /// An edge of a body.
    pub fn edge(body: &ConvexBody, at: &Placement, edge: u16) -> Border {
        let edge = body.edge(edge);
        Border::Line {
            start: at.point(body.vertex(edge.ends[0])),
            along: at.rotation * edge.direction,
            length: edge.length,
        }
    }
}

impl Crossing {
    /// The crossing of a border of O and one of I; the signs choose one of two points.
    pub fn new(
        m: &Vector3<f64>,
        (of_owner, sign_owner): (&Border, f64),
        (of_other, sign_other): (&Border, f64),
    ) -> Option<Self> {
        // Lengths along a line of I are those of its image in the plane, in which corners are compared.
        let level = |e: &Vector3<f64>| (e - m * m.dot(e)).norm();
        match (*of_owner, *of_other) {
            (Border::Line { start: q0, along: side, length }, Border::Line { start, along: e, length: own }) => {
                let q = m.cross(&side);
                let across = q.dot(&e);
                let s = q.dot(&(q0 - start)) / across;
                let z = start + e * s;
                let t = side.dot(&(z - q0));
                let g = (s.min(own - s) * level(&e)).min(t).min(length - t);
                (across.abs() > LEVEL).then_some(Crossing { z, e, q, g })
            }
            (Border::Line { start: q0, along: side, length }, Border::Circle { centre, axis, radius }) => {
                let q = m.cross(&side);
                let across = q - axis * axis.dot(&q);
                let w = across.try_normalize(LEVEL)?;
                let off = q.dot(&(centre - q0)) / across.norm();
                let half = (radius * radius - off * off).max(0.0).sqrt();
                let z = centre - w * off + axis.cross(&w) * (half * sign_other);
                let t = side.dot(&(z - q0));
                let g = (radius - off.abs()).min(t).min(length - t);
                Some(Crossing { z, e: axis.cross(&(z - centre)) / radius, q, g })
            }
            (Border::Circle { centre, radius, .. }, Border::Line { start, along: e, length }) => {
                let flat = |v: &Vector3<f64>| v - m * m.dot(v);
                let (x, way) = (flat(&(start - centre)), flat(&e));
                let square = way.norm_squared();
                if square < LEVEL {
                    return None;
                }
                let middle = -x.dot(&way) / square;
                let off = (x + way * middle).norm();
                let half = ((radius * radius - off * off).max(0.0) / square).sqrt();
                let s = middle + half * sign_owner;
                let z = start + e * s;
                let g = (radius - off).min(s.min(length - s) * square.sqrt());
                Some(Crossing { z, e, q: flat(&(z - centre)) / radius, g })
            }
            (Border::Circle { centre, radius, .. }, Border::Circle { centre: other, axis, radius: own }) => {
                let between = other - centre;
                let flat = between - m * m.dot(&between);
                let distance = flat.norm();
                let way = flat.try_normalize(LEVEL)?;
                let off = (distance * distance + radius * radius - own * own) / (2.0 * distance);
                let half = (radius * radius - off * off).max(0.0).sqrt();
                let arm = way * off + m.cross(&way) * (half * sign_owner);
                // In the plane of I's rim.
                let z = centre + arm + m * (axis.dot(&(between - arm)) / axis.dot(m));
                let g = (radius + own - distance).min(distance - (radius - own).abs());
                Some(Crossing { z, e: axis.cross(&(z - other)) / own, q: arm / radius, g })
            }
        }
    }
}
