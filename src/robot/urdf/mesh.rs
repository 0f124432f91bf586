//! Mesh files (STL, OBJ) as vertices and triangles.

use std::collections::HashMap;
use std::path::Path;

use nalgebra::{Point3, Vector3};

use crate::robot::model::Geometry;

/// Triangles of an STL or OBJ file, scaled; equal vertices are merged, since STL repeats each one.
pub(super) fn decode(bytes: &[u8], path: &Path, scale: Vector3<f64>) -> Result<Geometry, String> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let loader = mesh_loader::Loader::default().merge_meshes(true);
    let scene = match extension.as_str() {
        "stl" => loader.load_stl_from_slice(bytes, path),
        // Material files cannot change the shape, so none is opened.
        "obj" => loader.load_obj_from_slice_with_reader(bytes, path, |_| Ok(Vec::new())),
        _ => return Err(format!("mesh files of type `{extension}` are not read (STL and OBJ are)")),
    };
    let scene = scene.map_err(|e| e.to_string())?;
    let mesh = mesh_loader::Mesh::merge(scene.meshes);
    let mut index: HashMap<[u32; 3], u32> = HashMap::new();
    let mut points = Vec::new();
    let mut renumbered = Vec::with_capacity(mesh.vertices.len());
    for v in &mesh.vertices {
        if !v.iter().all(|x| x.is_finite()) {
            return Err("a vertex is not finite".into());
        }
        // Adding 0 turns -0 into 0, which is the same place with other bits.
        let key = v.map(|x| (x + 0.0).to_bits());
        renumbered.push(*index.entry(key).or_insert_with(|| {
            points.push(Point3::from(Vector3::from(v.map(f64::from)).component_mul(&scale)));
            points.len() as u32 - 1
        }));
    }
    // A mirror scale turns triangles inside out.
    let flip = scale.product() < 0.0;
    let mut triangles = Vec::with_capacity(mesh.faces.len());
    for face in &mesh.faces {
        let Some(mut t) = corner_indices(face, &renumbered) else {
            return Err("a face names a vertex that is not there".into());
        };
        if flip {
            t.swap(1, 2);
        }
        if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
            triangles.push(t);
        }
    }
    if triangles.is_empty() {
        return Err("it has no triangles".into());
    }
    Ok(Geometry::Mesh(points, triangles))
}

fn corner_indices(face: &[u32; 3], renumbered: &[u32]) -> Option<[u32; 3]> {
    let corner = |i: usize| renumbered.get(face[i] as usize).copied();
    Some([corner(0)?, corner(1)?, corner(2)?])
}
