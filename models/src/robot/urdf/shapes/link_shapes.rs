//! Visual and collision elements as [`Shape`]s.

use std::collections::HashMap;
use std::path::Path;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use roxmltree::Node;

use super::capsules::joined;
use super::package;
use crate::mesh::MeshError;
use crate::robot::mesh_store::MeshStore;
use crate::robot::model::{Geometry, Shape};
use crate::robot::notices::Notices;
use crate::robot::urdf::xml::{Xml, describe};

const GREY: [f32; 4] = [0.7, 0.7, 0.7, 1.0];

/// A URDF origin as a pose: roll, pitch, yaw about the fixed axes x, y, z, then the translation.
pub(in crate::robot::urdf) fn isometry(origin: &urdf_rs::Pose) -> Isometry3<f64> {
    let [roll, pitch, yaw] = origin.rpy.0;
    Isometry3::from_parts(
        Translation3::from(Vector3::from(origin.xyz.0)),
        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    )
}

/// Converts URDF shapes and records the mesh files read.
pub(in crate::robot::urdf) struct Shapes<'a> {
    xml: &'a Xml<'a>,
    /// Materials declared under `<robot>`, by name; the first of each name.
    materials: HashMap<&'a str, &'a urdf_rs::Material>,
    pub meshes: MeshStore,
}

impl<'a> Shapes<'a> {
    pub fn new(xml: &'a Xml<'a>, materials: &'a [urdf_rs::Material]) -> Self {
        let materials = materials.iter().rev().map(|material| (material.name.as_str(), material)).collect();
        Self { xml, materials, meshes: MeshStore::default() }
    }

    /// All visual shapes of a link, in the frame in which the link's URDF frame has pose `frame`.
    pub fn visuals(&mut self, link: &urdf_rs::Link, frame: &Isometry3<f64>, notices: &mut Notices) -> Vec<Shape> {
        let nodes = self.elements(&link.name, "visual");
        let mut shapes = Vec::new();
        for (visual, node) in link.visual.iter().zip(nodes) {
            let pose = frame * isometry(&visual.origin);
            let rgba = self.colour(visual.material.as_ref());
            shapes.extend(self.geometry(&visual.geometry, node, notices).map(|geometry| Shape {
                pose,
                geometry,
                rgba,
            }));
        }
        joined(shapes)
    }

    /// As [`Self::visuals`], for collision shapes.
    pub fn collisions(&mut self, link: &urdf_rs::Link, frame: &Isometry3<f64>, notices: &mut Notices) -> Vec<Shape> {
        let nodes = self.elements(&link.name, "collision");
        let mut shapes = Vec::new();
        for (collision, node) in link.collision.iter().zip(nodes) {
            let pose = frame * isometry(&collision.origin);
            let geometry = self.geometry(&collision.geometry, node, notices);
            shapes.extend(geometry.map(|geometry| Shape { pose, geometry, rgba: GREY }));
        }
        joined(shapes)
    }

    fn elements(&self, link: &str, tag: &str) -> Vec<Node<'a, 'a>> {
        self.xml.named("link", link).children().filter(|n| n.has_tag_name(tag)).collect()
    }

    fn geometry(&mut self, geometry: &urdf_rs::Geometry, node: Node, notices: &mut Notices) -> Option<Geometry> {
        Some(match geometry {
            urdf_rs::Geometry::Box { size } => Geometry::Box(Vector3::from(size.0)),
            urdf_rs::Geometry::Cylinder { radius, length } => Geometry::Cylinder(*radius, *length),
            urdf_rs::Geometry::Capsule { radius, length } => Geometry::Capsule(*radius, *length),
            urdf_rs::Geometry::Sphere { radius } => Geometry::Sphere(*radius),
            urdf_rs::Geometry::Mesh { filename, scale } => {
                let scale = scale.map_or(Vector3::repeat(1.0), |s| Vector3::from(s.0));
                match self.mesh(filename, scale) {
                    Ok((mesh, remark)) => {
                        if let Some(message) = remark {
                            notices.info(self.xml.source, node.range().start, message);
                        }
                        mesh
                    }
                    Err(reason) => {
                        let tag = node.tag_name().name();
                        let message = format!("{} mesh `{filename}` of {} is left out: {reason}", tag, describe(node));
                        notices.warning(self.xml.source, node.range().start, message);
                        return None;
                    }
                }
            }
        })
    }

    /// The shape and the remark of its reader.
    fn mesh(&mut self, filename: &str, scale: Vector3<f64>) -> Result<(Geometry, Option<String>), MeshError> {
        let folder = self.xml.source.path().parent().unwrap_or(Path::new("."));
        self.meshes.scaled(&package::resolve(folder, filename)?, &scale)
    }

    /// A visual's own colour, or the one of the material of that name declared under `<robot>`.
    fn colour(&self, material: Option<&urdf_rs::Material>) -> [f32; 4] {
        let Some(material) = material else { return GREY };
        let shared = || self.materials.get(material.name.as_str()).and_then(|m| m.color.as_ref());
        material.color.as_ref().or_else(shared).map_or(GREY, |c| c.rgba.0.map(|x| x.clamp(0.0, 1.0) as f32))
    }
}
