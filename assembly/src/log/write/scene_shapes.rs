//! Writes `/scene` once: the shapes of robot and objects, fixed to the frames of their links, the floor
//! and terrain.
//! Viewers keep an entity until one of the same name replaces it. Markers have a topic of their own
//! (`marker_topic.rs`), so that a viewer that jumps to a time and reads only the last message of
//! each topic still shows the robot.

use crate::files::RecordError;
use crate::log::write::conversion::{colour, point, pose, timestamp};
use crate::log::write::frames_topic::{object_frame, world_frame};
use crate::log::write::log_header::LogHeader;
use crate::log::write::log_output::LogOutput;
use crate::robot::{Geometry, Link, Model, Shape};
use crate::terrain::{Terrain, TerrainFace};
use foxglove::messages::{
    CubePrimitive, CylinderPrimitive, LinePrimitive, Point3, SceneEntity, SceneUpdate, SpherePrimitive,
    TriangleListPrimitive, Vector3, line_primitive,
};
use nalgebra::{Isometry3, Translation3};

/// Edge of the drawn floor, m.
const FLOOR: f64 = 10.0;
/// Distance of the grid lines, m.
const GRID: f64 = 0.5;
const FLOOR_COLOUR: [f32; 4] = [0.82, 0.83, 0.85, 1.0];
const TERRAIN_COLOUR: [f32; 4] = [0.70, 0.72, 0.68, 1.0];
const PATCH_COLOUR: [f32; 4] = [0.1, 0.45, 0.75, 1.0];
const GRID_COLOUR: [f32; 4] = [0.6, 0.62, 0.66, 1.0];

/// Writes the robot and the floor.
pub(super) fn write(output: &mut LogOutput, model: &Model, header: &LogHeader) -> Result<(), RecordError> {
    let mut channel = output.foxglove::<SceneUpdate>("/scene")?;
    let robot = model.links.iter().map(link_entity).filter(|e| !is_empty(e));
    let world = world_frame(model);
    let patches = header.patches.iter().enumerate().map(|(i, outline)| patch_entity(world, i, outline));
    let objects = header.objects.iter().map(object_entity);
    let floor = header.floor.iter().map(|floor| floor_entity(world, floor));
    let terrain = terrain_entities(world, header.terrain);
    let entities = floor.chain(terrain).chain(patches).chain(robot).chain(objects).collect();
    output.send(&mut channel, 0, &SceneUpdate { deletions: Vec::new(), entities })
}

/// An entity without primitives that is fixed to a frame and persists.
pub(super) fn entity(frame: &str, id: String) -> SceneEntity {
    SceneEntity {
        timestamp: Some(timestamp(0)),
        frame_id: frame.to_owned(),
        id,
        frame_locked: true,
        ..Default::default()
    }
}

fn is_empty(e: &SceneEntity) -> bool {
    e.cubes.is_empty() && e.spheres.is_empty() && e.cylinders.is_empty() && e.triangles.is_empty()
}

/// The shapes of an object's link.
fn object_entity(link: &Link) -> SceneEntity {
    let frame = object_frame(&link.name);
    SceneEntity { frame_id: frame.clone(), id: frame, ..link_entity(link) }
}

/// The visual shapes of a link, or its collision shapes if it has no visual ones.
fn link_entity(link: &Link) -> SceneEntity {
    let mut to = entity(&link.name, format!("link/{}", link.name));
    let shapes = if link.visuals.is_empty() { &link.collisions } else { &link.visuals };
    for shape in shapes {
        add(shape, &(link.urdf_frame.inverse() * shape.pose), &mut to);
    }
    to
}

/// Adds a shape at `at`, its pose in the link's URDF frame.
fn add(shape: &Shape, at: &Isometry3<f64>, to: &mut SceneEntity) {
    let color = Some(colour(shape.rgba));
    let sphere = |at: &Isometry3<f64>, radius: f64| SpherePrimitive {
        pose: Some(pose(at)),
        size: Some(cube(2.0 * radius)),
        color,
    };
    let cylinder = |radius: f64, length: f64| CylinderPrimitive {
        pose: Some(pose(at)),
        size: Some(Vector3 { x: 2.0 * radius, y: 2.0 * radius, z: length }),
        bottom_scale: 1.0,
        top_scale: 1.0,
        color,
    };
    match &shape.geometry {
        Geometry::Box(edges) => {
            let size = Some(Vector3 { x: edges.x, y: edges.y, z: edges.z });
            to.cubes.push(CubePrimitive { pose: Some(pose(at)), size, color });
        }
        Geometry::Cylinder(radius, length) => to.cylinders.push(cylinder(*radius, *length)),
        Geometry::Capsule(radius, length) => {
            to.cylinders.push(cylinder(*radius, *length));
            for end in [-0.5 * length, 0.5 * length] {
                to.spheres.push(sphere(&(at * Translation3::new(0.0, 0.0, end)), *radius));
            }
        }
        Geometry::Sphere(radius) => to.spheres.push(sphere(at, *radius)),
        Geometry::Mesh(vertices, triangles) => to.triangles.push(TriangleListPrimitive {
            pose: Some(pose(at)),
            points: vertices.iter().map(|p| Point3 { x: p.x, y: p.y, z: p.z }).collect(),
            color,
            colors: Vec::new(),
            indices: triangles.as_flattened().to_vec(),
        }),
    }
}

fn cube(edge: f64) -> Vector3 {
    Vector3 { x: edge, y: edge, z: edge }
}

/// A thin slab whose upper face is the floor, with a grid that makes tilt and sliding visible.
fn floor_entity(world: &str, floor: &Isometry3<f64>) -> SceneEntity {
    const THICKNESS: f64 = 0.01;
    let mut to = entity(world, "floor".to_owned());
    to.cubes.push(CubePrimitive {
        pose: Some(pose(&(floor * Translation3::new(0.0, 0.0, -0.5 * THICKNESS)))),
        size: Some(Vector3 { x: FLOOR, y: FLOOR, z: THICKNESS }),
        color: Some(colour(FLOOR_COLOUR)),
    });
    let lines = (FLOOR / GRID) as i32;
    let half = 0.5 * FLOOR;
    let points = (0..=lines)
        .flat_map(|i| {
            let c = f64::from(i) * GRID - half;
            [(c, -half), (c, half), (-half, c), (half, c)]
        })
        .map(|(x, y)| Point3 { x, y, z: 0.0 })
        .collect();
    to.lines.push(LinePrimitive {
        r#type: line_primitive::Type::LineList.into(),
        pose: Some(pose(floor)),
        thickness: 1.0,
        scale_invariant: true,
        points,
        color: Some(colour(GRID_COLOUR)),
        ..Default::default()
    });
    to
}

/// Terrain, an entity for each entry: the faces of its pieces, the surface of a height field.
fn terrain_entities(world: &str, terrain: &Terrain) -> Vec<SceneEntity> {
    let mut entities: Vec<(usize, SceneEntity)> = Vec::new();
    let mut add = |index: usize, name: &str, points: Vec<Point3>, indices: Vec<u32>| {
        let to = match entities.iter().position(|(entry, _)| *entry == index) {
            Some(at) => &mut entities[at].1,
            None => {
                entities.push((index, entity(world, format!("terrain/{name}"))));
                &mut entities.last_mut().expect("one was pushed").1
            }
        };
        to.triangles.push(TriangleListPrimitive {
            pose: Some(pose(&Isometry3::identity())),
            points,
            color: Some(colour(TERRAIN_COLOUR)),
            colors: Vec::new(),
            indices,
        });
    };
    for piece in terrain.pieces() {
        let fan = |face: &TerrainFace| {
            let ring: Vec<u32> = face.corners.iter().map(|&k| u32::from(k)).collect();
            (2..ring.len()).flat_map(|k| [ring[0], ring[k - 1], ring[k]]).collect::<Vec<_>>()
        };
        let indices = piece.faces.iter().flat_map(fan).collect();
        add(piece.entry, &piece.name, piece.points.iter().map(point).collect(), indices);
    }
    for grid in terrain.grids() {
        let (rows, columns) = (grid.heights().rows, grid.heights().columns);
        let at = |k: usize| point(&grid.entry().to_world(&grid.point(k / columns, k % columns)));
        let points = (0..rows * columns).map(at).collect();
        let cell = |k: usize| {
            let (row, column) = (k / (columns - 1), k % (columns - 1));
            let a = (row * columns + column) as u32;
            let (b, c, d) = (a + 1, a + columns as u32 + 1, a + columns as u32);
            [a, b, c, a, c, d]
        };
        let indices = (0..(rows - 1) * (columns - 1)).flat_map(cell).collect();
        add(grid.entry().index, &grid.entry().name, points, indices);
    }
    entities.into_iter().map(|(_, entity)| entity).collect()
}

/// The outline of a friction region.
fn patch_entity(world: &str, i: usize, outline: &[nalgebra::Vector3<f64>]) -> SceneEntity {
    let mut to = entity(world, format!("floor/patch-{i}"));
    to.lines.push(LinePrimitive {
        r#type: line_primitive::Type::LineLoop.into(),
        pose: Some(pose(&Isometry3::identity())),
        thickness: 3.0,
        scale_invariant: true,
        points: outline.iter().map(point).collect(),
        color: Some(colour(PATCH_COLOUR)),
        ..Default::default()
    });
    to
}
