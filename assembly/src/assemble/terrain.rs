//! The terrain of a run: entries of the scenario and the files that they name, as convex pieces.

use super::friction::extra;
use crate::geometry::Plane;
use crate::mesh;
use crate::scenario::{Diagnostic, HeightFieldTerrain, Input, MeshBody, MeshTerrain, Run, TerrainSpec};
use crate::terrain::shapes::{self, Stairs};
use crate::terrain::{Entry, HeightGrid, Heights, MAX_POINTS, Solid, Terrain, mesh_shapes};
use nalgebra::{Rotation3, Vector3};

/// Greatest number of faces of all pieces but those of height fields, each of which takes about 100
/// bytes.
pub const MAX_FACES: usize = 1_000_000;

/// Faces of a prism.
const PRISM_FACES: usize = 5;

/// Greatest number of heights of all entries, each of which takes 8 bytes.
pub const MAX_HEIGHTS: usize = MAX_POINTS * MAX_POINTS;

/// Greatest coordinate of a mesh, m.
const MAX_COORDINATE: f64 = 1e6;

/// Least distance of rows or columns, m.
const MIN_SPACING: f64 = 1e-6;

/// Depth of the solid behind a triangle of a mesh, m.
const DEPTH: f64 = 0.05;

/// The terrain of the run. `floor` is the plane of the floor, unless the scenario has none.
pub fn terrain(run: &Run, floor: Option<Plane>, notes: &mut Vec<String>, errors: &mut Vec<Diagnostic>) -> Terrain {
    let (mut pieces, mut grids): (Vec<_>, Vec<HeightGrid>) = Default::default();
    let mut faces = 0;
    for (index, spec) in run.scenario.terrain.iter().enumerate() {
        let path = format!("terrain.{index}");
        let entry = entry(run, index, spec);
        let solids = match spec {
            TerrainSpec::Box(block) => vec![shapes::block(&block.size.into())],
            TerrainSpec::Ramp(ramp) => vec![shapes::ramp(&ramp.size.into())],
            TerrainSpec::Stairs(s) => {
                shapes::stairs(&Stairs { steps: s.steps, rise: s.rise, run: s.run, width: s.width, landing: s.landing })
            }
            TerrainSpec::HeightField(field) => {
                grids.extend(height_field(run, &path, &entry, field, errors));
                Vec::new()
            }
            TerrainSpec::Mesh(mesh) => mesh_solids(run, &path, mesh, notes, errors),
        };
        let heights: usize = grids.iter().map(|grid| grid.heights().values.len()).sum();
        faces += solids.iter().map(|solid| solid.faces.len()).sum::<usize>();
        let counts = [("faces", faces, MAX_FACES), ("heights of height fields", heights, MAX_HEIGHTS)];
        if let Some((what, count, most)) = counts.into_iter().find(|(_, count, most)| count > most) {
            let message = format!("with `{path}` the terrain has {count} {what}, at most {most} are allowed");
            errors.push(run.error_at(&path, message, None));
            return Terrain::default();
        }
        pieces.extend(solids.iter().map(|solid| entry.place(solid)));
    }
    Terrain::new(pieces, grids, floor)
}

fn entry(run: &Run, index: usize, spec: &TerrainSpec) -> Entry {
    let common = spec.entry();
    let [roll, pitch, yaw] = common.rpy;
    let friction = common.friction.unwrap_or(run.scenario.floor.friction);
    Entry {
        name: spec.name(index).into(),
        index,
        rotation: *Rotation3::from_euler_angles(roll, pitch, yaw).matrix(),
        position: common.position.into(),
        mu_s: friction.static_,
        mu_k: friction.kinetic,
        extra: extra(friction),
        is_like_floor: common.friction.is_none(),
    }
}

/// The height field of an entry; `None` after an error, which goes to `errors`.
fn height_field(
    run: &Run,
    path: &str,
    entry: &Entry,
    field: &HeightFieldTerrain,
    errors: &mut Vec<Diagnostic>,
) -> Option<HeightGrid> {
    let heights = match &field.heights {
        Some(rows) => {
            let read = Heights::from_rows(rows, field.scale.unwrap_or(1.0), field.offset.unwrap_or(0.0));
            read.map_err(|error| errors.push(run.error_at(&format!("{path}.heights"), error.message, None))).ok()?
        }
        None => heights_of_file(run, path, field, errors)?,
    };
    let intervals = [heights.columns, heights.rows].map(|points| (points - 1) as f64);
    let spacing = match (field.size, field.spacing) {
        (Some([x, y]), _) => [x / intervals[0], y / intervals[1]],
        (None, spacing) => [spacing.unwrap_or(1.0); 2],
    };
    if let Some(distance) = spacing.into_iter().find(|distance| *distance < MIN_SPACING) {
        let message = format!(
            "{} rows and {} columns of this size are {distance} m apart, at least {MIN_SPACING} m is required",
            heights.rows, heights.columns
        );
        errors.push(run.error_at(&format!("{path}.size"), message, None));
        return None;
    }
    Some(HeightGrid::new(entry, heights, spacing))
}

/// The heights of the entry's file; `None` after an error.
fn heights_of_file(run: &Run, path: &str, field: &HeightFieldTerrain, errors: &mut Vec<Diagnostic>) -> Option<Heights> {
    let input = run.input(&format!("{path}.file"))?;
    match read_heights(input, field) {
        Ok(heights) => Some(heights),
        Err((Some((text, span)), message)) => {
            let name = input.path.display().to_string();
            errors.push(Diagnostic::in_text(&name, text, span, message, None));
            None
        }
        Err((None, message)) => {
            errors.push(file_error(run, path, input, message));
            None
        }
    }
}

/// The text concerned with the bytes in it, and the message of an error.
type FileError<'a> = (Option<(&'a str, std::ops::Range<usize>)>, String);

fn read_heights<'a>(input: &'a Input, field: &HeightFieldTerrain) -> Result<Heights, FileError<'a>> {
    if field.is_picture() {
        let [black, white] = field.height.unwrap_or_default();
        return Heights::from_png(&input.bytes, black, white).map_err(|error| (None, error.message));
    }
    let text = std::str::from_utf8(&input.bytes).map_err(|_| (None, "the file is not UTF-8".to_owned()))?;
    let read = Heights::from_csv(text, field.scale.unwrap_or(1.0), field.offset.unwrap_or(0.0));
    read.map_err(|error| (error.span.map(|span| (text, span)), error.message))
}

/// The solids of a mesh; none after an error, which goes to `errors`.
fn mesh_solids(
    run: &Run,
    path: &str,
    spec: &MeshTerrain,
    notes: &mut Vec<String>,
    errors: &mut Vec<Diagnostic>,
) -> Vec<Solid> {
    let Some(input) = run.input(&format!("{path}.file")) else { return Vec::new() };
    let mut refuse = |message: String| {
        errors.push(file_error(run, path, input, message));
        Vec::new()
    };
    let decoded = match mesh::decode(&input.bytes, &input.path) {
        Ok(decoded) => decoded,
        Err(error) => return refuse(error.to_string()),
    };
    let scaled = decoded.scaled(&Vector3::repeat(spec.scale));
    let is_bounded = |points: &[nalgebra::Point3<f64>]| points.iter().all(|p| p.coords.amax() <= MAX_COORDINATE);
    let Some((points, triangles)) = scaled.filter(|(points, _)| is_bounded(points)) else {
        return refuse(format!("at the scale {} it has coordinates beyond {MAX_COORDINATE} m", spec.scale));
    };
    let points: Vec<Vector3<f64>> = points.iter().map(|p| p.coords).collect();
    let solids = match spec.body {
        MeshBody::Convex => match mesh_shapes::hull(&points) {
            Some(hull) => vec![hull],
            None => return refuse("it is flat, so its convex hull has no volume".to_owned()),
        },
        MeshBody::Triangles if triangles.len() > MAX_FACES / PRISM_FACES => {
            let (count, most) = (triangles.len(), MAX_FACES / PRISM_FACES);
            return refuse(format!("it has {count} triangles, at most {most} are allowed unless `as = \"convex\"`"));
        }
        MeshBody::Triangles => mesh_shapes::prisms(&points, &triangles, spec.depth.unwrap_or(DEPTH)),
    };
    if solids.is_empty() {
        return refuse("none of its triangles has an area".to_owned());
    }
    notes.extend(decoded.remark.map(|remark| format!("{path}: {}: {remark}", input.path.display())));
    solids
}

fn file_error(run: &Run, path: &str, input: &Input, message: String) -> Diagnostic {
    run.error_at(&format!("{path}.file"), format!("{}: {message}", input.path.display()), None)
}
