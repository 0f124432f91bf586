//! Meshes of `<asset>`: vertices in the frame of the geom that names them, and mass properties.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use nalgebra::{Point3, Quaternion, UnitQuaternion, Vector3};

use super::classes::Classes;
use super::compiler::Compiler;
use super::document::Id;
use super::mesh_inertia::{Rule, properties};
use super::view::View;
use crate::geometry::spatial_hull::convex_hull_3d;
use crate::input;
use crate::mesh::{self, VerticesAndTriangles};
use crate::robot::rigid_inertia::RigidInertia;
use crate::robot::robot_error::RobotError;

/// Greatest number of points of a hull whose inertia is computed.
const MAX_HULL_POINTS: usize = 50_000;

/// A mesh that could be read.
pub(super) struct Mesh {
    pub vertices: Vec<Point3<f64>>,
    pub triangles: Vec<[u32; 3]>,
    rule: Rule,
}

/// All meshes of the file, read when a geom names them.
pub(super) struct Meshes<'a> {
    folder: PathBuf,
    views: HashMap<String, View<'a>>,
    rule: Rule,
    /// Each mesh that was read, or why it cannot be.
    read: HashMap<String, Result<Mesh, String>>,
    /// Files read so far, each once.
    pub files: Vec<(PathBuf, Vec<u8>)>,
}

impl<'a> Meshes<'a> {
    /// Finds the meshes of a file in `folder`.
    ///
    /// # Errors
    /// A mesh without name and file; two meshes of one name.
    pub fn new(classes: &Classes<'a>, assets: &[Id], compiler: &Compiler, folder: &Path) -> Result<Self, RobotError> {
        let mut views = HashMap::new();
        for &id in assets {
            let view = classes.view(id, None)?;
            let document = view.document;
            let stem = view.text("file").and_then(|file| Path::new(file).file_stem()?.to_str());
            let name = match document.text(id, "name").filter(|name| !name.is_empty()).or(stem) {
                Some(name) => name.to_owned(),
                None => return Err(view.missing("name")),
            };
            if views.contains_key(&name) {
                let fault = document.fault(id, format!("there are two meshes named `{name}`"));
                return Err(fault.expected("a unique name").invalid());
            }
            views.insert(name, view);
        }
        let folder = folder.join(&compiler.mesh_folder);
        let rule = if compiler.exact_meshes { Rule::Exact } else { Rule::Legacy };
        Ok(Self { folder, views, rule, read: HashMap::new(), files: Vec::new() })
    }

    /// The mesh that a geom names, or why it cannot be read.
    ///
    /// # Errors
    /// No mesh of that name; values of the mesh that are not valid.
    pub fn get(&mut self, geom: &View, compiler: &Compiler) -> Result<Result<&Mesh, String>, RobotError> {
        let name = geom.required("mesh")?;
        let Some(view) = self.views.get(name).cloned() else {
            let known: Vec<&str> = self.views.keys().map(String::as_str).collect();
            let fault = geom.fault("mesh", "the name of a <mesh> in <asset>");
            return Err(fault.suggest(name, known).invalid());
        };
        if !self.read.contains_key(name) {
            let mesh = self.load(&view, compiler)?;
            self.read.insert(name.to_owned(), mesh);
        }
        Ok(self.read[name].as_ref().map_err(Clone::clone))
    }

    /// The file whose vertices, times a scale, are those of the geom's mesh, if there is one.
    ///
    /// # Errors
    /// Values of the mesh that are not valid.
    pub fn plain_file(&self, geom: &View, compiler: &Compiler) -> Result<Option<(PathBuf, f64)>, RobotError> {
        let Some(view) = self.views.get(geom.required("mesh")?) else { return Ok(None) };
        let [x, y, z] = view.array::<3>("scale")?.unwrap_or([1.0; 3]);
        let is_moved = ["refpos", "refquat", "builtin"].iter().any(|name| view.has(name));
        let path = self.path(view, compiler).filter(|_| !is_moved && x == y && y == z && x > 0.0);
        Ok(path.filter(|path| !is_msh(path)).map(|path| (path, x)))
    }

    /// The file of a mesh, if it is not written in place.
    fn path(&self, view: &View, compiler: &Compiler) -> Option<PathBuf> {
        let file = Path::new(view.text("file")?);
        let name = if compiler.strip_path { file.file_name().map_or(file, Path::new) } else { file };
        Some(self.folder.join(name))
    }

    fn load(&mut self, view: &View, compiler: &Compiler) -> Result<Result<Mesh, String>, RobotError> {
        let words = ["convex", "exact", "legacy", "shell"];
        let rule = match view.word("inertia", &words)? {
            Some("convex") => Rule::Convex,
            Some("exact") => Rule::Exact,
            Some("shell") => Rule::Shell,
            Some(_) => Rule::Legacy,
            None => self.rule,
        };
        let scale = Vector3::from(view.array::<3>("scale")?.unwrap_or([1.0; 3]));
        let position = Vector3::from(view.array::<3>("refpos")?.unwrap_or_default());
        let [w, x, y, z] = view.array("refquat")?.unwrap_or([1.0, 0.0, 0.0, 0.0]);
        let Some(turn) = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-10) else {
            return Err(view.fault("refquat", "a quaternion of length above 0").invalid());
        };
        let soup = match self.source(view, compiler)? {
            Ok(soup) => soup,
            Err(reason) => return Ok(Err(reason)),
        };
        let (vertices, mut triangles) = soup;
        let place = |p: &Point3<f64>| Point3::from((turn.inverse() * (p.coords - position)).component_mul(&scale));
        let vertices: Vec<Point3<f64>> = vertices.iter().map(place).collect();
        if !vertices.iter().all(|p| p.iter().all(|x| x.is_finite() && x.abs() < 1e60)) {
            return Ok(Err("its vertices at this scale are too large".into()));
        }
        // A mirror turns triangles inside out.
        if scale.product() < 0.0 {
            triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        Ok(Ok(Mesh { vertices, triangles, rule }))
    }

    /// Vertices and triangles of the file or of the element.
    fn source(&mut self, view: &View, compiler: &Compiler) -> Result<Result<VerticesAndTriangles, String>, RobotError> {
        if view.has("builtin") {
            return Ok(Err("built-in meshes are not available".into()));
        }
        let Some(path) = self.path(view, compiler) else { return inline(view) };
        // A file of several meshes is read once, so that all use the bytes that the key of a run hashes.
        let at = match self.files.iter().position(|(known, _)| *known == path) {
            Some(at) => at,
            None => match input::read(&path, input::MOST_DATA) {
                Ok(bytes) => {
                    self.files.push((path.clone(), bytes));
                    self.files.len() - 1
                }
                Err(error) => return Ok(Err(format!("{}: {error}", path.display()))),
            },
        };
        let bytes = &self.files[at].1;
        Ok(match is_msh(&path) {
            true => msh(bytes).ok_or("it is not a valid MSH file".to_owned()),
            false => mesh::decode(bytes, &path).map_err(|error| error.to_string()).and_then(|decoded| {
                decoded.scaled(&Vector3::repeat(1.0)).ok_or("its vertices are too large".to_owned())
            }),
        })
    }
}

fn is_msh(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("msh"))
}

/// MuJoCo's own format: the numbers of vertices, normals, texture coordinates and faces, then their
/// coordinates and the indices of corners; without faces, the convex hull. All are of 4 bytes.
fn msh(bytes: &[u8]) -> Option<VerticesAndTriangles> {
    let words: Vec<[u8; 4]> = bytes.chunks_exact(4).filter_map(|word| word.try_into().ok()).collect();
    let (counts, rest) = words.split_at_checked(4)?;
    let count = |i: usize| usize::try_from(i32::from_le_bytes(counts[i])).ok();
    let (vertices, faces) = (count(0)?, count(3)?);
    let skipped = 3 * count(1)? + 2 * count(2)?;
    let (coordinates, rest) = rest.split_at_checked(3 * vertices)?;
    let corners = rest.get(skipped..)?;
    if corners.len() != 3 * faces {
        return None;
    }
    let number = |word: &[u8; 4]| f64::from(f32::from_le_bytes(*word));
    let vertices: Vec<Point3<f64>> =
        coordinates.chunks_exact(3).map(|c| Point3::new(number(&c[0]), number(&c[1]), number(&c[2]))).collect();
    if !vertices.iter().all(|p| p.iter().all(|x| x.is_finite())) {
        return None;
    }
    if faces == 0 {
        return convex_hull_3d(&vertices);
    }
    let corners: Vec<u32> = corners.iter().map(|word| u32::from_le_bytes(*word)).collect();
    let are_known = corners.iter().all(|&corner| (corner as usize) < vertices.len());
    are_known.then(|| (vertices, corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect()))
}

/// Vertices written in the file; without faces, their convex hull.
fn inline(view: &View) -> Result<Result<VerticesAndTriangles, String>, RobotError> {
    let Some(numbers) = view.list("vertex", 12, usize::MAX)? else { return Err(view.missing("file")) };
    if numbers.len() % 3 != 0 {
        return Err(view.fault("vertex", "three coordinates of each vertex").invalid());
    }
    let vertices: Vec<Point3<f64>> = numbers.chunks_exact(3).map(Point3::from_slice).collect();
    let Some(faces) = view.list("face", 3, usize::MAX)? else {
        return Ok(convex_hull_3d(&vertices).ok_or("its vertices are in one plane".into()));
    };
    let is_index = |x: &f64| x.fract() == 0.0 && (0.0..vertices.len() as f64).contains(x);
    if faces.len() % 3 != 0 || !faces.iter().all(is_index) {
        return Err(view.fault("face", "three indices of vertices, from 0, of each triangle").invalid());
    }
    let triangles = faces.chunks_exact(3).map(|t| [t[0] as u32, t[1] as u32, t[2] as u32]).collect();
    Ok(Ok((vertices, triangles)))
}

impl Mesh {
    /// Mass properties of density 1, or why there are none; `shell` if the geom's mass is on its surface.
    pub fn inertia(&self, shell: bool) -> Result<RigidInertia, &'static str> {
        let rule = if shell { Rule::Shell } else { self.rule };
        let no_volume = "it has no volume; inertia=\"shell\" of the <mesh> gives its surface mass";
        if rule != Rule::Convex {
            return properties(&self.vertices, &self.triangles, rule).ok_or(no_volume);
        }
        if self.vertices.len() > MAX_HULL_POINTS {
            return Err("it has too many vertices for its convex hull");
        }
        let (vertices, triangles) = convex_hull_3d(&self.vertices).ok_or(no_volume)?;
        properties(&vertices, &triangles, rule).ok_or(no_volume)
    }
}
