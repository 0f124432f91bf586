//! COLLADA (`.dae`) as triangles: the visual scene with the transforms of its nodes and the file's
//! unit.
//!
//! A vertex p of a geometry under nodes with matrices N_1 .. N_k (outermost first) is at u N_1 ..
//! N_k p, with u metres to the unit; a node's own matrix is the product of its transformation
//! elements in the order of the file (COLLADA 1.4.1 specification, chapter 5). `up_axis` is
//! reported, not applied: URDF puts meshes into the link's axes as they are, as ROS's viewers do,
//! and exporters write `Y_UP` for vertices that are not rotated.

use std::collections::HashMap;

use nalgebra::{Matrix3, Matrix4, Point3, Unit, Vector3};
use roxmltree::{Document, Node, ParsingOptions};

use super::{MeshError, Soup};
use crate::text::xml_attributes::{MAX_ATTRIBUTES, excess_attribute};

/// Greatest depth of nodes: instances that contain themselves would nest without end.
const MAX_DEPTH: usize = 64;
/// Greatest number of nodes, instances of instances included.
const MAX_INSTANCES: usize = 100_000;
/// Greatest numbers of vertices and triangles: several hundred times those of a large mesh.
const MAX_VERTICES: usize = 20_000_000;
const MAX_TRIANGLES: usize = 40_000_000;
/// Greatest number of columns of a list of corners, far more than files have.
const MAX_COLUMNS: usize = 1000;

/// Triangles of the file's scene in m, and its up-axis; `Z_UP` if it gives none, since meshes are
/// not rotated.
pub(super) fn decode(bytes: &[u8]) -> Result<(Soup, String), MeshError> {
    let text = std::str::from_utf8(bytes).map_err(|_| "it is not UTF-8")?;
    if excess_attribute(text).is_some() {
        return Err(format!("an element has more than {MAX_ATTRIBUTES} attributes").into());
    }
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|e| e.to_string())?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        return Err(format!("its root element is <{}>, not <COLLADA>", root.tag_name().name()).into());
    }
    let asset = first_child(root, "asset");
    let unit = asset.and_then(|a| first_child(a, "unit")).and_then(|u| u.attribute("meter"));
    let unit = unit.map_or(Ok(1.0), |u| positive(u).ok_or(format!("its unit is `{u}` m")))?;
    let up = asset.and_then(|a| first_child(a, "up_axis")).and_then(|u| u.text()).unwrap_or("Z_UP").trim().to_owned();
    let ids = root.descendants().filter_map(|n| n.attribute("id").map(|id| (id, n))).collect();
    let mut reader = Reader { ids, soup: Soup::default(), instances: 0 };
    let transform = Matrix4::new_scaling(unit);
    let named = first_child(root, "scene")
        .and_then(|s| first_child(s, "instance_visual_scene"))
        .and_then(|s| reader.target(s, "url"));
    match named.or_else(|| root.descendants().find(|n| has_tag(*n, "visual_scene"))) {
        Some(scene) => reader.nodes(scene, transform, 0)?,
        // A file without a scene is a library of shapes: all of them, untransformed.
        None => {
            root.descendants().filter(|n| has_tag(*n, "geometry")).try_for_each(|g| reader.geometry(g, &transform))?
        }
    }
    Ok((reader.soup, up))
}

struct Reader<'a> {
    ids: HashMap<&'a str, Node<'a, 'a>>,
    soup: Soup,
    /// Number of nodes visited so far.
    instances: usize,
}

impl<'a> Reader<'a> {
    /// The element that an attribute such as `url="#id"` names.
    fn target(&self, node: Node<'a, 'a>, attribute: &str) -> Option<Node<'a, 'a>> {
        self.ids.get(node.attribute(attribute)?.strip_prefix('#')?).copied()
    }

    fn require(&self, node: Node<'a, 'a>, attribute: &str) -> Result<Node<'a, 'a>, MeshError> {
        self.target(node, attribute).ok_or_else(|| {
            let (tag, name) = (node.tag_name().name(), node.attribute(attribute).unwrap_or(""));
            format!("<{tag}> names `{name}`, which is not in the file").into()
        })
    }

    /// Reads all children of a visual scene or of a node whose frame has the matrix `transform`.
    fn nodes(&mut self, parent: Node<'a, 'a>, transform: Matrix4<f64>, depth: usize) -> Result<(), MeshError> {
        if depth > MAX_DEPTH {
            return Err(format!("its nodes nest more than {MAX_DEPTH} deep").into());
        }
        self.instances += 1;
        if self.instances > MAX_INSTANCES {
            return Err(format!("it has more than {MAX_INSTANCES} nodes").into());
        }
        for child in parent.children() {
            match child.tag_name().name() {
                "node" => self.nodes(child, transform * own_matrix(child)?, depth + 1)?,
                "instance_node" => {
                    let node = self.require(child, "url")?;
                    self.nodes(node, transform * own_matrix(node)?, depth + 1)?;
                }
                "instance_geometry" => {
                    let geometry = self.require(child, "url")?;
                    self.geometry(geometry, &transform)?;
                }
                "instance_controller" => {
                    // A skin in its bind pose; there is no skeleton to move it by.
                    let controller = self.require(child, "url")?;
                    let skin = first_child(controller, "skin").ok_or("a controller that is no skin")?;
                    let bind = first_child(skin, "bind_shape_matrix").map_or(Ok(Matrix4::identity()), matrix)?;
                    let geometry = self.require(skin, "source")?;
                    self.geometry(geometry, &(transform * bind))?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn geometry(&mut self, geometry: Node<'a, 'a>, transform: &Matrix4<f64>) -> Result<(), MeshError> {
        let Some(mesh) = first_child(geometry, "mesh") else { return Ok(()) };
        // A mirror turns triangles inside out.
        let flip = transform.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
        for primitive in mesh.children().filter(|n| n.is_element()) {
            let kind = primitive.tag_name().name();
            if !matches!(kind, "triangles" | "polylist" | "polygons" | "tristrips" | "trifans") {
                continue;
            }
            let inputs = || primitive.children().filter(|n| has_tag(*n, "input"));
            let offsets: Vec<usize> = inputs().map(offset).collect::<Result<_, _>>()?;
            let stride = 1 + offsets.into_iter().max().unwrap_or(0);
            let vertex = inputs().find(|i| i.attribute("semantic") == Some("VERTEX"));
            let vertex = vertex.ok_or_else(|| format!("<{kind}> without vertices"))?;
            let base = self.positions(vertex, transform)?;
            let count = self.soup.vertices.len() - base;
            let column = offset(vertex)?;
            let sizes: Vec<usize> = first_child(primitive, "vcount").map_or(Ok(Vec::new()), numbers)?;
            for list in primitive.children().filter(|n| has_tag(*n, "p")) {
                let all: Vec<usize> = numbers(list)?;
                let corners: Vec<usize> = all.chunks_exact(stride).map(|c| c[column]).collect();
                if corners.iter().any(|&c| c >= count) {
                    return Err("a face names a vertex that is not there".into());
                }
                let corners: Vec<u32> = corners.iter().map(|c| (base + c) as u32).collect();
                self.faces(kind, &corners, &sizes, flip);
                if self.soup.triangles.len() > MAX_TRIANGLES {
                    return Err(format!("it has more than {MAX_TRIANGLES} triangles").into());
                }
            }
        }
        Ok(())
    }

    /// Appends the transformed positions of a `VERTEX` input; returns the index of the first.
    fn positions(&mut self, vertex: Node<'a, 'a>, transform: &Matrix4<f64>) -> Result<usize, MeshError> {
        let vertices = self.require(vertex, "source")?;
        let position =
            vertices.children().find(|i| has_tag(*i, "input") && i.attribute("semantic") == Some("POSITION"));
        let source = self.require(position.ok_or("<vertices> without positions")?, "source")?;
        let array = first_child(source, "float_array").ok_or("positions without a <float_array>")?;
        let accessor = source.descendants().find(|n| has_tag(*n, "accessor"));
        let read =
            |name, default| accessor.and_then(|a| a.attribute(name)).and_then(|s| s.parse().ok()).unwrap_or(default);
        let (stride, offset): (usize, usize) = (read("stride", 3), read("offset", 0));
        let values: Vec<f64> = numbers(array)?;
        let base = self.soup.vertices.len();
        if base > MAX_VERTICES {
            return Err(format!("it has more than {MAX_VERTICES} vertices").into());
        }
        for p in values.get(offset..).unwrap_or(&[]).chunks(stride.max(1)).filter(|c| c.len() >= 3) {
            self.soup.vertices.push(transform.transform_point(&Point3::new(p[0], p[1], p[2])));
        }
        Ok(base)
    }

    /// Splits one list of corners into triangles, polygons into fans.
    fn faces(&mut self, kind: &str, corners: &[u32], sizes: &[usize], flip: bool) {
        let triangles = &mut self.soup.triangles;
        let mut add = |a: u32, b: u32, c: u32| triangles.push(if flip { [a, c, b] } else { [a, b, c] });
        let mut fan = |polygon: &[u32]| (2..polygon.len()).for_each(|i| add(polygon[0], polygon[i - 1], polygon[i]));
        match kind {
            "triangles" => corners.chunks_exact(3).for_each(fan),
            "polylist" => {
                let mut rest = corners;
                for &size in sizes {
                    let (polygon, after) = rest.split_at(size.min(rest.len()));
                    fan(polygon);
                    rest = after;
                }
            }
            // Every other triangle of a strip has the opposite orientation.
            "tristrips" => corners.windows(3).enumerate().for_each(|(i, t)| match i % 2 {
                0 => fan(t),
                _ => fan(&[t[1], t[0], t[2]]),
            }),
            _ => fan(corners),
        }
    }
}

/// The column of an input in a list of corners.
fn offset(input: Node) -> Result<usize, MeshError> {
    let Some(text) = input.attribute("offset") else { return Ok(0) };
    let column = text.trim().parse().ok().filter(|column| *column < MAX_COLUMNS);
    column.ok_or_else(|| format!("an <input> with the offset `{text}`").into())
}

/// The product of a node's transformation elements.
fn own_matrix(node: Node) -> Result<Matrix4<f64>, MeshError> {
    let mut product = Matrix4::identity();
    for child in node.children().filter(|n| n.is_element()) {
        let kind = child.tag_name().name();
        let vector = |n: usize| -> Result<Vec<f64>, MeshError> {
            let v: Vec<f64> = numbers(child)?;
            if v.len() == n { Ok(v) } else { Err(format!("<{kind}> holds {} numbers, not {n}", v.len()).into()) }
        };
        product *= match kind {
            "matrix" => matrix(child)?,
            "translate" => Matrix4::new_translation(&Vector3::from_vec(vector(3)?)),
            "scale" => Matrix4::new_nonuniform_scaling(&Vector3::from_vec(vector(3)?)),
            "rotate" => {
                let v = vector(4)?;
                match Unit::try_new(Vector3::new(v[0], v[1], v[2]), 0.0) {
                    Some(axis) => Matrix4::from_axis_angle(&axis, v[3].to_radians()),
                    None => Matrix4::identity(),
                }
            }
            "lookat" | "skew" => return Err(format!("<{kind}> of a node is not read").into()),
            _ => continue,
        };
    }
    Ok(product)
}

/// Sixteen numbers, row after row.
fn matrix(node: Node) -> Result<Matrix4<f64>, MeshError> {
    let v: Vec<f64> = numbers(node)?;
    let m = (v.len() == 16).then(|| Matrix4::from_row_slice(&v)).ok_or("a matrix without 16 numbers")?;
    // A projection is not affine.
    let affine = m.row(3) == Matrix4::<f64>::identity().row(3);
    let linear: Matrix3<f64> = m.fixed_view::<3, 3>(0, 0).into();
    if affine && linear.iter().all(|x| x.is_finite()) { Ok(m) } else { Err("a matrix that is not affine".into()) }
}

fn numbers<T: std::str::FromStr>(node: Node) -> Result<Vec<T>, MeshError> {
    let text = node.text().unwrap_or("");
    let parse = |number: &str| number.parse().map_err(|_| format!("`{number}` in <{}>", node.tag_name().name()).into());
    text.split_ascii_whitespace().map(parse).collect()
}

fn positive(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0)
}

fn has_tag(node: Node, tag: &str) -> bool {
    node.tag_name().name() == tag
}

fn first_child<'a>(node: Node<'a, 'a>, tag: &str) -> Option<Node<'a, 'a>> {
    node.children().find(|n| has_tag(*n, tag))
}
