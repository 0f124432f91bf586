//! Shapes of links.

use std::path::Path;

use nalgebra::{Isometry3, Vector3};

use crate::mesh::MeshError;
use crate::robot::mesh_store::MeshStore;
use crate::robot::model::{Geometry, Shape};
use crate::robot::notices::Notices;
use crate::sdf::{self, Geometry as Written, Pose, Shape as WrittenShape};

const GREY: [f32; 4] = [0.7, 0.7, 0.7, 1.0];

/// Converts shapes and records the mesh files read.
#[derive(Default)]
pub(super) struct Shapes {
    pub meshes: MeshStore,
}

impl Shapes {
    /// The shapes of one kind of a link whose frame has pose `frame`. Those that cannot be used are
    /// left out with a notice.
    pub fn convert(
        &mut self,
        (link, kind): (&str, &str),
        shapes: &[(Pose, &WrittenShape)],
        frame: &Isometry3<f64>,
        notices: &mut Notices,
    ) -> Vec<Shape> {
        let mut converted = Vec::new();
        for (pose, shape) in shapes {
            let (source, at) = (&shape.at.source, shape.at.span.start);
            match self.geometry(shape, notices) {
                Ok(geometry) => {
                    let pose = frame * pose.isometry;
                    converted.push(Shape { pose, geometry, rgba: shape.rgba.unwrap_or(GREY) });
                }
                Err(reason) => {
                    let message = format!("{kind} `{}` of link `{link}` is left out: {reason}", shape.name);
                    notices.warning(source, at, message);
                }
            }
        }
        converted
    }

    fn geometry(&mut self, shape: &WrittenShape, notices: &mut Notices) -> Result<Geometry, MeshError> {
        match &shape.geometry {
            Written::Box(size) => Ok(Geometry::Box(*size)),
            Written::Cylinder(radius, length) => Ok(Geometry::Cylinder(*radius, *length)),
            Written::Capsule(radius, length) => Ok(Geometry::Capsule(*radius, *length)),
            Written::Sphere(radius) => Ok(Geometry::Sphere(*radius)),
            Written::Ellipsoid(radii) if radii.x == radii.y && radii.y == radii.z => Ok(Geometry::Sphere(radii.x)),
            Written::Ellipsoid(_) => Err("there are no ellipsoids with different radii".into()),
            Written::Mesh(_, _, true) => Err("parts of meshes are not read".into()),
            Written::Mesh(uri, scale, false) => {
                let (geometry, remark) = self.mesh(shape, uri, scale)?;
                if let Some(remark) = remark {
                    notices.info(&shape.at.source, shape.at.span.start, remark);
                }
                Ok(geometry)
            }
            Written::Hull(_) => Err("it is not a shape of an SDF".into()),
            Written::Plane(_) => Err("a <plane> is no body".into()),
            Written::Heights(_) | Written::Heightmap(..) => {
                Err("height fields are fixed terrain of a `[world]`".into())
            }
            Written::Other(tag) => Err(format!("there is no shape <{tag}>").into()),
        }
    }

    fn mesh(
        &mut self,
        shape: &WrittenShape,
        uri: &str,
        scale: &Vector3<f64>,
    ) -> Result<(Geometry, Option<String>), MeshError> {
        let folder = shape.at.source.path().parent().unwrap_or(Path::new(""));
        self.meshes.scaled(&sdf::resolve_uri(folder, uri)?, scale)
    }
}
