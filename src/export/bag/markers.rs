//! Turns the entities of a scene into markers: each primitive is one, in the namespace of its
//! entity.

use crate::export::bag::messages::{Colour, CompressedImage, Marker, MeshFile, Pose, Quaternion, Vector3};
use crate::log::ros::{Header, Time};
use foxglove::messages::{self as drawn, LinePrimitive, SceneEntity, TriangleListPrimitive, line_primitive};

/// Shapes of `visualization_msgs/msg/Marker`.
const ARROW: i32 = 0;
const CUBE: i32 = 1;
const SPHERE: i32 = 2;
const CYLINDER: i32 = 3;
const LINE_STRIP: i32 = 4;
const LINE_LIST: i32 = 5;
const TRIANGLE_LIST: i32 = 11;
/// Action that removes all markers of the topic; 0 adds one.
const DELETE_ALL: i32 = 3;

/// Width of a line per pixel of its width on the screen, m: markers have none in pixels.
const PIXEL: f64 = 0.002;

/// The marker that removes all before it.
pub(super) fn removal(frame: &str, stamp: Time) -> Marker {
    Marker { action: DELETE_ALL, ..blank(frame, stamp) }
}

/// The markers of entities.
pub(super) fn markers(entities: &[SceneEntity], stamp: Time) -> Vec<Marker> {
    entities.iter().flat_map(|entity| of_entity(entity, stamp)).collect()
}

fn of_entity(entity: &SceneEntity, stamp: Time) -> Vec<Marker> {
    let mut all = Vec::new();
    let mut add = |marker: Marker| {
        let id = i32::try_from(all.len()).unwrap_or(i32::MAX);
        let (header, ns) = (header(&entity.frame_id, stamp), entity.id.clone());
        all.push(Marker { header, ns, id, frame_locked: entity.frame_locked, ..marker });
    };
    let solid = |r#type, at: &Option<drawn::Pose>, size: &Option<drawn::Vector3>, color: &Option<drawn::Color>| {
        Marker { r#type, pose: pose(at), scale: vector(size), color: colour(color), ..blank("", stamp) }
    };
    for arrow in &entity.arrows {
        let tip = Vector3 { x: arrow.shaft_length + arrow.head_length, ..Vector3::default() };
        add(Marker {
            r#type: ARROW,
            pose: pose(&arrow.pose),
            scale: Vector3 { x: arrow.shaft_diameter, y: arrow.head_diameter, z: arrow.head_length },
            color: colour(&arrow.color),
            points: vec![Vector3::default(), tip],
            ..blank("", stamp)
        });
    }
    entity.cubes.iter().for_each(|cube| add(solid(CUBE, &cube.pose, &cube.size, &cube.color)));
    entity.spheres.iter().for_each(|ball| add(solid(SPHERE, &ball.pose, &ball.size, &ball.color)));
    entity.cylinders.iter().for_each(|tube| add(solid(CYLINDER, &tube.pose, &tube.size, &tube.color)));
    entity.lines.iter().for_each(|line| add(lines(line, stamp)));
    entity.triangles.iter().for_each(|mesh| add(triangles(mesh, stamp)));
    all
}

fn lines(line: &LinePrimitive, stamp: Time) -> Marker {
    let width = if line.scale_invariant { PIXEL * line.thickness } else { line.thickness };
    let mut points = indexed(&line.points, &line.indices, point);
    let mut colors = indexed(&line.colors, &line.indices, |c| colour(&Some(*c)));
    if line.r#type == i32::from(line_primitive::Type::LineLoop) {
        points.extend(points.first().copied());
        colors.extend(colors.first().copied());
    }
    let r#type = if line.r#type == i32::from(line_primitive::Type::LineList) { LINE_LIST } else { LINE_STRIP };
    let scale = Vector3 { x: width, ..Vector3::default() };
    let (pose, color) = (pose(&line.pose), colour(&line.color));
    Marker { r#type, pose, scale, color, points, colors, ..blank("", stamp) }
}

fn triangles(mesh: &TriangleListPrimitive, stamp: Time) -> Marker {
    Marker {
        r#type: TRIANGLE_LIST,
        pose: pose(&mesh.pose),
        scale: Vector3 { x: 1.0, y: 1.0, z: 1.0 },
        color: colour(&mesh.color),
        points: indexed(&mesh.points, &mesh.indices, point),
        colors: indexed(&mesh.colors, &mesh.indices, |c| colour(&Some(*c))),
        ..blank("", stamp)
    }
}

/// The items in the order of the indices; all, if there are none.
fn indexed<T, U>(items: &[T], indices: &[u32], convert: impl Fn(&T) -> U) -> Vec<U> {
    match indices {
        [] => items.iter().map(convert).collect(),
        _ => indices.iter().filter_map(|i| items.get(*i as usize)).map(convert).collect(),
    }
}

fn blank(frame: &str, stamp: Time) -> Marker {
    Marker {
        header: header(frame, stamp),
        ns: String::new(),
        id: 0,
        r#type: ARROW,
        action: 0,
        pose: Pose::default(),
        scale: Vector3::default(),
        color: Colour::default(),
        lifetime: Time::from_nanoseconds(0),
        frame_locked: false,
        points: Vec::new(),
        colors: Vec::new(),
        texture_resource: String::new(),
        texture: CompressedImage {
            header: header("", Time::from_nanoseconds(0)),
            format: String::new(),
            data: Vec::new(),
        },
        uv_coordinates: Vec::new(),
        text: String::new(),
        mesh_resource: String::new(),
        mesh_file: MeshFile::default(),
        mesh_use_embedded_materials: false,
    }
}

fn header(frame: &str, stamp: Time) -> Header {
    Header { stamp, frame_id: frame.to_owned() }
}

fn pose(pose: &Option<drawn::Pose>) -> Pose {
    let Some(pose) = pose else { return Pose::default() };
    let orientation = pose.orientation.as_ref().map(|q| Quaternion { x: q.x, y: q.y, z: q.z, w: q.w });
    Pose { position: vector(&pose.position), orientation: orientation.unwrap_or_default() }
}

fn vector(v: &Option<drawn::Vector3>) -> Vector3 {
    v.as_ref().map_or_else(Vector3::default, |v| Vector3 { x: v.x, y: v.y, z: v.z })
}

fn point(p: &drawn::Point3) -> Vector3 {
    Vector3 { x: p.x, y: p.y, z: p.z }
}

/// Single precision, as in the message.
fn colour(c: &Option<drawn::Color>) -> Colour {
    let Some(c) = c else { return Colour::default() };
    Colour { r: c.r as f32, g: c.g as f32, b: c.b as f32, a: c.a as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_triangles_follow_their_indices() {
        let at = |x: f64| drawn::Point3 { x, y: 0.0, z: 0.0 };
        let points: Vec<_> = [0.0, 1.0, 2.0].map(at).to_vec();
        let entity = SceneEntity {
            id: "e".into(),
            frame_id: "f".into(),
            lines: vec![LinePrimitive {
                r#type: line_primitive::Type::LineLoop.into(),
                points: points.clone(),
                thickness: 3.0,
                scale_invariant: true,
                ..Default::default()
            }],
            // The last index is beyond the points.
            triangles: vec![TriangleListPrimitive { points, indices: vec![2, 1, 0, 3], ..Default::default() }],
            ..Default::default()
        };
        let found = markers(&[entity], Time::from_nanoseconds(1_500_000_000));
        let along = |marker: &Marker| marker.points.iter().map(|p| p.x).collect::<Vec<_>>();
        assert_eq!((along(&found[0]), found[0].r#type, found[0].scale.x), (vec![0.0, 1.0, 2.0, 0.0], 4, 0.006));
        assert_eq!((along(&found[1]), found[1].r#type, found[1].id), (vec![2.0, 1.0, 0.0], 11, 1));
        let header = &found[1].header;
        assert_eq!((header.stamp.sec, header.stamp.nanosec, header.frame_id.as_str()), (1, 500_000_000, "f"));
    }
}
