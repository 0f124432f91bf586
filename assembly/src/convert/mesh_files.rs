//! Meshes of a converted robot as OBJ files.

use std::fmt::Write;

use nalgebra::Point3;

use super::xml_text::numbers;

/// A mesh file.
#[derive(Clone, PartialEq, Debug)]
pub struct MeshFile {
    /// Its name, without folders.
    pub name: String,
    /// Its text.
    pub text: String,
}

/// Meshes written so far; equal ones share a file.
#[derive(Default)]
pub(super) struct MeshFiles {
    pub files: Vec<MeshFile>,
}

impl MeshFiles {
    /// The name of the file of a mesh.
    pub fn add(&mut self, points: &[Point3<f64>], triangles: &[[u32; 3]]) -> String {
        let mut text = String::new();
        for point in points {
            let _ = writeln!(text, "v {}", numbers(point.coords.as_slice()));
        }
        for [a, b, c] in triangles {
            let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
        }
        if let Some(known) = self.files.iter().find(|file| file.text == text) {
            return known.name.clone();
        }
        let name = format!("mesh{}.obj", self.files.len());
        self.files.push(MeshFile { name: name.clone(), text });
        name
    }
}
