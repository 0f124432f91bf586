//! Mesh files of a robot, each read once.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use nalgebra::Vector3;

use super::model::Geometry;
use crate::input;
use crate::mesh::{self, MeshError};

/// The mesh files read so far.
#[derive(Default)]
pub(super) struct MeshStore {
    /// With their bytes, in the order of reading.
    pub files: Vec<(PathBuf, Vec<u8>)>,
    /// The same files as triangles: several links may share one.
    decoded: HashMap<PathBuf, Result<mesh::Decoded, MeshError>>,
}

impl MeshStore {
    /// The scaled shape of a file, and the remark of its reader.
    ///
    /// # Errors
    /// A file that cannot be read, is no mesh, or has no extent at this scale.
    pub fn scaled(&mut self, path: &Path, scale: &Vector3<f64>) -> Result<(Geometry, Option<String>), MeshError> {
        if !self.decoded.contains_key(path) {
            let bytes = input::read(path, input::MOST_DATA)?;
            self.decoded.insert(path.to_owned(), mesh::decode(&bytes, path));
            self.files.push((path.to_owned(), bytes));
        }
        match &self.decoded[path] {
            // A mesh without extent in two directions is a line or a point.
            Ok(_) if scale.iter().filter(|s| **s == 0.0).count() > 1 => {
                Err(format!("the scale {} {} {} reduces it to nothing", scale.x, scale.y, scale.z).into())
            }
            Ok(mesh) => {
                let (points, triangles) = mesh.scaled(scale).ok_or("its vertices at this scale are too large")?;
                Ok((Geometry::Mesh(points, triangles), mesh.remark.clone()))
            }
            Err(reason) => Err(reason.clone()),
        }
    }
}
