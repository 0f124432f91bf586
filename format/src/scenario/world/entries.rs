//! Models of a world as entries of `[[terrain]]` and `[[object]]`.
//!
//! | model | entries |
//! |---|---|
//! | static | for each collision shape a piece of terrain, the floor, or a fixed `model` |
//! | one homogeneous primitive | an object of its type |
//! | any other | an object of type `model` |
//!
//! An entry is called as its model, a piece of a model with several shapes `MODEL/SHAPE`, and of
//! one with several links `MODEL/LINK/SHAPE`.

use std::path::Path;

use super::height_map;
use super::nodes::{number, numbers, table, text};
use super::read_world::Spans;
use super::solid::{Primitive, primitive};
use crate::sdf::{Geometry, Heights, Model, Pose, Resolved, ResolvedLink, Shape, resolve_uri};
use crate::text::diagnostic::Severity;
use crate::text::source::Span;
use crate::text::toml_tree::{Node, Value};

/// Deviation of a plane's normal from vertical up to which it is level: rounding.
const LEVEL: f64 = 1e-12;

/// The entries of a world.
pub(super) struct Entries<'a, 's> {
    pub terrain: Vec<Node>,
    pub object: Vec<Node>,
    /// Height, m, friction and position of the level plane.
    pub plane: Option<(f64, Option<f64>, Span)>,
    pub remarks: Vec<(Severity, Span, String, Option<String>)>,
    /// The world file as the scenario names it.
    file: &'a str,
    /// The scenario's folder.
    base: &'a Path,
    spans: &'a mut Spans<'s>,
}

impl<'a, 's> Entries<'a, 's> {
    pub fn new(file: &'a str, base: &'a Path, spans: &'a mut Spans<'s>) -> Self {
        let (terrain, object, remarks) = Default::default();
        Entries { terrain, object, plane: None, remarks, file, base, spans }
    }

    /// Adds a model at its pose in the world.
    pub fn add(&mut self, model: &Model, resolved: &Resolved, pose: &Pose) {
        let shapes: usize = resolved.links.iter().map(|link| link.collisions.len()).sum();
        if model.is_static {
            for link in &resolved.links {
                for (in_link, shape) in &link.collisions {
                    let name = piece_name(model, resolved, shapes, link, shape);
                    match is_round(&shape.geometry) {
                        true => self.fixed(name, (model, resolved), (link, shape), pose),
                        false => self.piece(name, shape, &pose.then(&link.pose).then(in_link)),
                    }
                }
            }
            return;
        }
        if shapes == 0 {
            let span = self.spans.of(&model.at);
            self.remark(Severity::Note, span, format!("model `{}` has no collision shapes", model.name));
        }
        match primitive(resolved) {
            Some(solid) => self.solid(model, &solid, pose),
            None => self.model(model, resolved, pose),
        }
    }

    fn remark(&mut self, severity: Severity, span: Span, message: String) {
        self.remarks.push((severity, span, message, None));
    }

    /// Friction of a shape; a second coefficient is reported.
    fn friction(&mut self, shape: &Shape) -> Option<f64> {
        let (mu, second) = shape.mu?;
        if let Some(second) = second {
            let span = self.spans.of(&shape.at);
            let message =
                format!("friction is the same in all directions: mu2 = {second} is ignored, mu = {mu} counts");
            self.remark(Severity::Warning, span, message);
        }
        Some(mu)
    }

    /// A piece of terrain.
    fn piece(&mut self, name: String, shape: &Shape, pose: &Pose) {
        let span = self.spans.of(&shape.at);
        let mut keys = match &shape.geometry {
            Geometry::Box(size) => {
                vec![("type", text("box", &span)), ("size", numbers(size.as_slice(), &span))]
            }
            Geometry::Mesh(uri, scale, is_part) => match self.mesh_file(shape, uri, scale.as_slice(), *is_part) {
                Ok(file) => {
                    vec![("type", text("mesh", &span)), ("file", text(&file, &span)), ("scale", number(scale.x, &span))]
                }
                Err(reason) => return self.leave_out(name, span, &reason),
            },
            Geometry::Hull(Some((path, scale))) => match self.relative(path) {
                Ok(file) => vec![
                    ("type", text("mesh", &span)),
                    ("file", text(&file, &span)),
                    ("scale", number(*scale, &span)),
                    ("as", text("convex", &span)),
                ],
                Err(reason) => return self.leave_out(name, span, &reason),
            },
            Geometry::Plane(normal) => return self.level_plane(name, shape, &span, normal, pose),
            Geometry::Heights(heights) => return self.height_field(&name, shape, pose, heights),
            Geometry::Heightmap(uri, size, offset) => {
                let folder = shape.at.source.path().parent().unwrap_or(Path::new(""));
                return match resolve_uri(folder, uri).and_then(|path| height_map::read(&path, size)) {
                    Ok(heights) => {
                        let offset = Pose::from_rpy((*offset).into(), [0.0; 3]);
                        self.height_field(&name, shape, &pose.then(&offset), &heights)
                    }
                    Err(reason) => self.leave_out(name, span, &reason),
                };
            }
            Geometry::Other(tag) => return self.leave_out(name, span, &format!("there is no terrain <{tag}>")),
            _ => return self.leave_out(name, span, "there is no terrain of its shape"),
        };
        keys.extend(self.place(&name, pose, &span));
        keys.extend(self.friction(shape).map(|mu| ("friction", number(mu, &span))));
        self.terrain.push(table(keys, &span));
    }

    /// A height field, whose heights are part of the entry.
    fn height_field(&mut self, name: &str, shape: &Shape, pose: &Pose, heights: &Heights) {
        let span = self.spans.of(&shape.at);
        let rows = heights.rows.iter().map(|row| numbers(row, &span)).collect();
        let rows = Node { span: span.clone(), value: Value::Array(rows) };
        let mut keys =
            vec![("type", text("heightfield", &span)), ("heights", rows), ("size", numbers(&heights.size, &span))];
        keys.extend(self.place(name, pose, &span));
        keys.extend(self.friction(shape).map(|mu| ("friction", number(mu, &span))));
        self.terrain.push(table(keys, &span));
    }

    fn leave_out(&mut self, name: String, span: Span, reason: &str) {
        self.remark(Severity::Warning, span, format!("`{name}` is left out: {reason}"));
    }

    fn level_plane(&mut self, name: String, shape: &Shape, span: &Span, normal: &nalgebra::Vector3<f64>, pose: &Pose) {
        let up = pose.isometry.rotation * normal;
        if up.x.abs().max(up.y.abs()) > LEVEL || up.z < 0.0 {
            return self.leave_out(
                name,
                span.clone(),
                "only a level plane can be the floor; a large box can be tilted",
            );
        }
        if self.plane.is_some() {
            return self.leave_out(name, span.clone(), "the world has another plane, which is the floor");
        }
        let mu = self.friction(shape);
        self.plane = Some((pose.position()[2], mu, span.clone()));
    }

    /// Name and pose of an entry.
    fn place(&self, name: &str, pose: &Pose, span: &Span) -> [(&'static str, Node); 3] {
        [("name", text(name, span)), ("position", numbers(&pose.position(), span)), ("rpy", numbers(&pose.rpy(), span))]
    }

    /// The path of a mesh, relative to the scenario's folder.
    fn mesh_file(&self, shape: &Shape, uri: &str, scale: &[f64], is_part: bool) -> Result<String, String> {
        if is_part {
            return Err("parts of meshes are not read".into());
        }
        if scale.iter().any(|s| *s != scale[0] || *s <= 0.0) {
            return Err(format!("its scale {scale:?} is not the same in all directions"));
        }
        let folder = shape.at.source.path().parent().unwrap_or(Path::new(""));
        self.relative(&resolve_uri(folder, uri)?)
    }

    /// A path relative to the scenario's folder.
    fn relative(&self, path: &Path) -> Result<String, String> {
        let relative = path.strip_prefix(self.base).unwrap_or(path);
        relative.to_str().map(str::to_owned).ok_or_else(|| "the path is not UTF-8".into())
    }

    /// An object that is a homogeneous primitive.
    fn solid(&mut self, model: &Model, solid: &Primitive, pose: &Pose) {
        let span = self.spans.of(&solid.shape.at);
        let mut keys = match &solid.shape.geometry {
            Geometry::Box(size) => {
                vec![("type", text("box", &span)), ("size", numbers(size.as_slice(), &span))]
            }
            Geometry::Sphere(r) => vec![("type", text("sphere", &span)), ("radius", number(*r, &span))],
            Geometry::Cylinder(r, l) | Geometry::Capsule(r, l) => {
                let is_capsule = matches!(solid.shape.geometry, Geometry::Capsule(..));
                let kind = if is_capsule { "capsule" } else { "cylinder" };
                vec![("type", text(kind, &span)), ("radius", number(*r, &span)), ("length", number(*l, &span))]
            }
            // Others have no moments in `solid`.
            _ => return,
        };
        keys.push(("mass", number(solid.mass, &span)));
        keys.extend(self.place(&model.name, &pose.then(&solid.pose), &span));
        keys.extend(self.friction(solid.shape).map(|mu| ("friction", number(mu, &span))));
        self.object.push(table(keys, &span));
    }

    /// A fixed object that is one shape of a static model.
    fn fixed(
        &mut self,
        name: String,
        (model, resolved): (&Model, &Resolved),
        (link, shape): (&ResolvedLink, &Shape),
        pose: &Pose,
    ) {
        let span = self.spans.of(&shape.at);
        let file = format!("{}#{}::{}::{}", self.file, model.name, link.name, shape.name);
        let mut keys = vec![("type", text("model", &span)), ("model", text(&file, &span))];
        keys.extend(self.place(&name, &pose.then(&root_pose(resolved)), &span));
        keys.extend(self.friction(shape).map(|mu| ("friction", number(mu, &span))));
        self.object.push(table(keys, &span));
    }

    /// An object that is a mechanism of the world file.
    fn model(&mut self, model: &Model, resolved: &Resolved, pose: &Pose) {
        let span = self.spans.of(&model.at);
        let mut mus: Vec<f64> = Vec::new();
        for (_, shape) in resolved.links.iter().flat_map(|link| &link.collisions) {
            mus.extend(self.friction(shape));
        }
        if mus.iter().any(|mu| *mu != mus[0]) {
            let message = format!("model `{}` has one friction for all its shapes: {} counts", model.name, mus[0]);
            self.remark(Severity::Warning, span.clone(), message);
        }
        for link in &resolved.links {
            let count = link.collisions.iter().filter(|(_, shape)| !rolls(&shape.geometry)).count();
            if count < 2 {
                continue;
            }
            let span = self.spans.of(&link.link.at);
            let message = format!("link `{}` touches with the convex hull of {count} of its shapes", link.name);
            self.remark(Severity::Warning, span, message);
        }
        let file = format!("{}#{}", self.file, model.name);
        let mut keys = vec![("type", text("model", &span)), ("model", text(&file, &span))];
        keys.extend(self.place(&model.name, &pose.then(&root_pose(resolved)), &span));
        keys.extend(mus.first().map(|mu| ("friction", number(*mu, &span))));
        self.object.push(table(keys, &span));
    }
}

/// Shapes that terrain does not have, or that only the reader of the world file has, and a fixed object has.
fn is_round(geometry: &Geometry) -> bool {
    use Geometry::{Capsule, Cylinder, Ellipsoid, Hull, Sphere};
    matches!(geometry, Sphere(_) | Cylinder(..) | Capsule(..) | Ellipsoid(_) | Hull(None))
}

/// Shapes that a link touches with as such, not with a hull.
fn rolls(geometry: &Geometry) -> bool {
    matches!(geometry, Geometry::Sphere(_) | Geometry::Cylinder(..) | Geometry::Capsule(..))
}

fn piece_name(model: &Model, resolved: &Resolved, shapes: usize, link: &ResolvedLink, shape: &Shape) -> String {
    match (shapes, resolved.links.len()) {
        (1, _) => model.name.clone(),
        (_, 1) => format!("{}/{}", model.name, shape.name),
        _ => format!("{}/{}/{}", model.name, link.name, shape.name),
    }
}

/// Pose of the root's frame in the model: the link that no joint moves, or the model's own frame
/// where joints or several such links are fixed to the world.
fn root_pose(resolved: &Resolved) -> Pose {
    let is_moved = |link: usize| resolved.joints.iter().any(|joint| joint.child == Some(link));
    let roots: Vec<usize> = (0..resolved.links.len()).filter(|link| !is_moved(*link)).collect();
    match roots[..] {
        [root] if resolved.joints.iter().all(|joint| joint.parent.is_some()) => resolved.links[root].pose,
        _ => Pose::IDENTITY,
    }
}
