//! Reads mesh files (STL, OBJ, COLLADA) to vertices and triangles. A mesh may be flat or open:
//! drawing and sole detection need no volume.
//!
//! Imports: `geometry`, `text`. Used by: `robot`, `assemble`.

mod collada;

use crate::geometry;
use nalgebra::{Point3, Vector3};
use std::path::Path;

/// Largest coordinate, m: fourth powers of greater ones overflow.
const MAX_COORDINATE: f64 = 1e60;

/// Why a mesh file cannot be read.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{0}")]
pub struct MeshError(String);

impl From<String> for MeshError {
    fn from(reason: String) -> Self {
        MeshError(reason)
    }
}

impl From<&str> for MeshError {
    fn from(reason: &str) -> Self {
        MeshError(reason.to_owned())
    }
}

impl From<std::io::Error> for MeshError {
    fn from(error: std::io::Error) -> Self {
        MeshError(error.to_string())
    }
}

/// Triangles as stored in a file, in m before scaling.
#[derive(Default)]
struct Soup {
    vertices: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
}

/// Vertices, m, and triangles by the indices of their corners.
pub type VerticesAndTriangles = (Vec<Point3<f64>>, Vec<[u32; 3]>);

/// A decoded file.
pub struct Decoded {
    /// Vertices, each once, and triangles with three different corners.
    soup: Soup,
    /// Deviation of the reader from the file.
    pub remark: Option<String>,
}

/// Reads a mesh file of the kind that the extension of `path` names; equal vertices are merged,
/// since STL repeats each one.
///
/// # Errors
/// Another extension; a file that is not valid; a mesh without triangles.
pub fn decode(bytes: &[u8], path: &Path) -> Result<Decoded, MeshError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let loader = mesh_loader::Loader::default().merge_meshes(true);
    let mut remark = None;
    let raw = match extension.as_str() {
        "stl" => match binary_stl(bytes) {
            Some(soup) => soup,
            None => to_soup(loader.load_stl_from_slice(bytes, path))?,
        },
        // Material files cannot change the shape, so none is opened.
        "obj" => to_soup(loader.load_obj_from_slice_with_reader(bytes, path, |_| Ok(Vec::new())))?,
        "dae" => {
            let (soup, up) = collada::decode(bytes)?;
            if up != "Z_UP" {
                let message = "of COLLADA meshes is not applied: they keep the axes of the file, as in ROS";
                remark = Some(format!("up-axis {up} {message}"));
            }
            soup
        }
        _ => return Err(format!("mesh files of type `{extension}` are not read (STL, OBJ and DAE are)").into()),
    };
    Ok(Decoded { soup: weld_vertices(&raw)?, remark })
}

impl Decoded {
    /// Vertices and triangles at a scale, with the orientation of triangles kept; `None` if a
    /// coordinate exceeds 1e60 m.
    pub fn scaled(&self, scale: &Vector3<f64>) -> Option<VerticesAndTriangles> {
        let points: Vec<Point3<f64>> =
            self.soup.vertices.iter().map(|p| Point3::from(p.coords.component_mul(scale))).collect();
        if !points.iter().all(|p| p.iter().all(|x| x.abs() <= MAX_COORDINATE)) {
            return None;
        }
        // A mirror scale turns triangles inside out.
        let flip = scale.product() < 0.0;
        let orient = |t: &[u32; 3]| if flip { [t[0], t[2], t[1]] } else { *t };
        Some((points, self.soup.triangles.iter().map(orient).collect()))
    }
}

/// A binary STL: 80 bytes of header, the number n of triangles, and n times normal, corners and two
/// bytes. Many headers begin with `solid` as text files do, so the length decides.
fn binary_stl(bytes: &[u8]) -> Option<Soup> {
    let count = u32::from_le_bytes(bytes.get(80..84)?.try_into().ok()?);
    let records = &bytes[84..];
    if records.len() as u64 != 50 * u64::from(count) {
        return None;
    }
    let number = |at: &[u8]| f64::from(f32::from_le_bytes([at[0], at[1], at[2], at[3]]));
    let corner = |at: &[u8]| Point3::new(number(at), number(&at[4..]), number(&at[8..]));
    let vertices = records.chunks_exact(50).flat_map(|r| [12, 24, 36].map(|at| corner(&r[at..]))).collect();
    Some(Soup { vertices, triangles: (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect() })
}

fn to_soup(scene: std::io::Result<mesh_loader::Scene>) -> Result<Soup, MeshError> {
    let mesh = mesh_loader::Mesh::merge(scene?.meshes);
    let vertices = mesh.vertices.iter().map(|v| Point3::from(Vector3::from(v.map(f64::from)))).collect();
    Ok(Soup { vertices, triangles: mesh.faces })
}

fn weld_vertices(raw: &Soup) -> Result<Soup, MeshError> {
    if !raw.vertices.iter().all(|p| p.iter().all(|x| x.is_finite())) {
        return Err("a vertex is not finite".into());
    }
    let (vertices, renumbered) = geometry::distinct_points(&raw.vertices);
    let mut triangles = Vec::with_capacity(raw.triangles.len());
    for face in &raw.triangles {
        let corner = |i: usize| renumbered.get(face[i] as usize).copied();
        let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) else {
            return Err("a face names a vertex that is not there".into());
        };
        if a != b && b != c && c != a {
            triangles.push([a, b, c]);
        }
    }
    if triangles.is_empty() {
        return Err("it has no triangles".into());
    }
    Ok(Soup { vertices, triangles })
}
