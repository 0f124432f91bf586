//! A robot as MJCF: the tree of bodies.
//!
//! A body's frame is that of its link. A link without mass and shapes that carries one other link
//! is no body: its joint is one more joint of the next body, in the same order.

use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::mesh_files::MeshFiles;
use super::mjcf_inertia::{inertial, raised_inertial};
use super::mjcf_parts::{NO_EFFORT, actuators, equalities, keyframes, sensors, sites};
use super::xml_text::{Lines, direction, escape, number, numbers, wxyz};
use super::{Converted, joint_warnings, list};
use crate::geometry::spatial_hull::convex_hull_3d;
use crate::robot::{Base, Geometry, Joint, JointKind, Link, LinkId, Model, Shape};

/// Limit that stands for none where the other one is given, rad or m.
const FAR: f64 = 1e10;
/// Greatest number of joints of one body in MuJoCo.
const MAX_JOINTS: usize = 6;

/// The text, with meshes and warnings.
pub(super) fn write(model: &Model, folder: &str) -> Converted {
    let (mut meshes, mut warnings) = (MeshFiles::default(), Vec::new());
    let mut body = Lines::default();
    body.open("<mujoco>");
    body.open("<worldbody>");
    let children = vec![Vec::new(); model.links.len()];
    let mut tree = Tree { model, children, lines: body, flat: Vec::new(), raised: Vec::new() };
    for (i, link) in model.links.iter().enumerate() {
        if let Some(parent) = link.parent {
            tree.children[parent.0].push(i);
        }
    }
    tree.write(&mut meshes);
    let Tree { lines: mut body, flat, raised, .. } = tree;
    let flat: Vec<&str> = flat.iter().map(String::as_str).collect();
    body.close("</worldbody>");
    equalities(model, &mut body, &mut warnings);
    actuators(model, &mut body);
    sensors(model, &mut body);
    keyframes(model, &mut body);
    body.close("</mujoco>");
    list("a flat mesh", "link", &flat, &mut warnings);
    warnings.extend(raised);
    let idle = model.joints.iter().filter(|j| j.effort_limit == 0.0);
    warnings.extend(idle.map(|joint| {
        format!("the effort limit 0 of joint `{}` is written as {NO_EFFORT:e}, as MJCF has none of 0", joint.name)
    }));
    joint_warnings(model, true, &mut warnings);
    let names: Vec<&str> =
        model.joints.iter().filter(|j| j.velocity_limit.is_finite()).map(|j| j.name.as_str()).collect();
    list("the velocity limit", "joint", &names, &mut warnings);
    // The head comes last, since meshes are known by then.
    let mut head = Lines::default();
    head.open(&format!("<mujoco model=\"{}\">", escape(&model.name)));
    head.line("<compiler angle=\"radian\" autolimits=\"true\" inertiafromgeom=\"false\"/>");
    head.line("<option gravity=\"0 0 -9.81\"/>");
    if !meshes.files.is_empty() {
        head.open("<asset>");
        for file in &meshes.files {
            let (name, path) = (file.name.trim_end_matches(".obj"), escape(&format!("{folder}/{}", file.name)));
            head.line(&format!("<mesh name=\"{name}\" file=\"{path}\" inertia=\"shell\"/>"));
        }
        head.close("</asset>");
    }
    let rest = body.text.strip_prefix("<mujoco>\n").unwrap_or(&body.text);
    Converted { text: head.text + rest, meshes: meshes.files, warnings }
}

/// Name of a link's body. `world` is that of MuJoCo's own root.
fn body_name(model: &Model, link: &Link) -> String {
    if link.name != "world" {
        return link.name.clone();
    }
    let mut name = "world_body".to_owned();
    while model.links.iter().any(|other| other.name == name) {
        name.push('_');
    }
    name
}

/// The bodies under construction.
struct Tree<'a> {
    model: &'a Model,
    children: Vec<Vec<usize>>,
    lines: Lines,
    /// Links whose flat meshes are left out.
    flat: Vec<String>,
    /// Warnings about masses and inertias below those that MuJoCo takes.
    raised: Vec<String>,
}

/// A step of the walk: a body, or the end of one.
enum Step {
    Open { link: usize, parent: Option<usize> },
    Close,
}

impl Tree<'_> {
    /// The link is only a motion of the next one.
    fn is_motion(&self, i: usize) -> bool {
        let (model, link) = (self.model, &self.model.links[i]);
        let on = |id: LinkId| id.0 == i;
        let sensors = model.sensors.imu.iter().chain(&model.sensors.force);
        let carries_frames = model.loops.iter().any(|l| on(l.link) || l.other.is_some_and(on))
            || model.soles.iter().any(|sole| on(sole.link))
            || model.end_effectors.iter().any(|effector| on(effector.link))
            || sensors.into_iter().any(|sensor| on(sensor.mount.link));
        link.parent.is_some()
            && link.mass == 0.0
            && link.inertia.amax() == 0.0
            && link.visuals.is_empty()
            && link.collisions.is_empty()
            && link.merged.is_empty()
            && !carries_frames
            && self.children[i].len() == 1
    }

    /// Writes all bodies; the tree may be deep.
    fn write(&mut self, meshes: &mut MeshFiles) {
        let mut stack = vec![Step::Open { link: 0, parent: None }];
        while let Some(step) = stack.pop() {
            let Step::Open { link, parent } = step else {
                self.lines.close("</body>");
                continue;
            };
            let mut chain = vec![link];
            while let Some(&last) = chain.last()
                && chain.len() < MAX_JOINTS
                && self.is_motion(last)
            {
                chain.push(self.children[last][0]);
            }
            let body = chain[chain.len() - 1];
            self.body(&chain, parent, meshes);
            stack.push(Step::Close);
            // Reversed, since the stack returns the last one first.
            stack.extend(self.children[body].iter().rev().map(|&link| Step::Open { link, parent: Some(body) }));
        }
    }

    /// Opens the body of the last link of a chain, with the joints of all.
    fn body(&mut self, chain: &[usize], parent: Option<usize>, meshes: &mut MeshFiles) {
        let model = self.model;
        let last = chain[chain.len() - 1];
        let link = &model.links[last];
        // Poses of the internal frames in that of the parent, at joint positions 0.
        let mut poses: Vec<Isometry3<f64>> = Vec::new();
        for &i in chain {
            let before = poses.last().copied().unwrap_or_default();
            poses.push(before * at_zero(&model.links[i]));
        }
        let own = poses[poses.len() - 1] * link.urdf_frame;
        let pose = match parent {
            Some(parent) => model.links[parent].urdf_frame.inv_mul(&own),
            None => Isometry3::identity(),
        };
        let (pos, quat) = (numbers(pose.translation.vector.as_slice()), wxyz(&pose.rotation));
        let name = escape(&body_name(model, link));
        self.lines.open(&format!("<body name=\"{name}\" pos=\"{pos}\" quat=\"{quat}\">"));
        let inertia = link.body().transformed(&link.urdf_frame.inverse());
        if parent.is_some() || model.base == Base::Floating {
            let (line, warning) = raised_inertial(&inertia);
            self.lines.line(&line);
            self.raised.extend(warning.map(|text| format!("link `{}` has {text}", link.name)));
        } else if link.mass > 0.0 || link.inertia.amax() > 0.0 {
            self.lines.line(&inertial(&inertia));
        }
        if parent.is_none() && model.base == Base::Floating {
            self.lines.line(&format!("<freejoint name=\"{}\"/>", escape(&free_joint(model))));
        }
        for (&i, pose) in chain.iter().zip(&poses).filter(|_| parent.is_some()) {
            joint(&mut self.lines, &model.joints[i - 1], &own.inv_mul(pose));
        }
        let to_body = link.urdf_frame.inverse();
        for (shapes, is_visual) in [(&link.visuals, true), (&link.collisions, false)] {
            for shape in shapes {
                if !geom(&mut self.lines, shape, &(to_body * shape.pose), is_visual, meshes) {
                    self.flat.push(link.name.clone());
                }
            }
        }
        sites(model, last, &to_body, &mut self.lines);
    }
}

/// Name of the joint of a free base.
fn free_joint(model: &Model) -> String {
    let mut name = "base".to_owned();
    while model.joint(&name).is_some() {
        name.push('_');
    }
    name
}

fn at_zero(link: &Link) -> Isometry3<f64> {
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(link.rotation));
    Isometry3::from_parts(Translation3::from(link.offset), rotation)
}

/// `pose` is that of the joint's frame in the body.
fn joint(lines: &mut Lines, joint: &Joint, pose: &Isometry3<f64>) {
    let kind = if joint.kind == JointKind::Prismatic { "slide" } else { "hinge" };
    let axis = direction(&(pose.rotation * Vector3::z()));
    let pos = numbers(pose.translation.vector.as_slice());
    let mut text = format!(
        "<joint name=\"{}\" type=\"{kind}\" pos=\"{pos}\" axis=\"{}\"",
        escape(&joint.name),
        numbers(axis.as_slice())
    );
    if joint.kind != JointKind::Continuous && (joint.lower.is_finite() || joint.upper.is_finite()) {
        let range = numbers(&[joint.lower.max(-FAR), joint.upper.min(FAR)]);
        text += &format!(" range=\"{range}\"");
    }
    for (key, value) in [("damping", joint.damping), ("frictionloss", joint.friction), ("armature", joint.armature)] {
        if value != 0.0 {
            text += &format!(" {key}=\"{}\"", number(value));
        }
    }
    if joint.effort_limit.is_finite() {
        let limit = joint.effort_limit.max(NO_EFFORT);
        text += &format!(" actuatorfrcrange=\"{}\"", numbers(&[-limit, limit]));
    }
    lines.line(&(text + "/>"));
}

/// Visual shapes are of group 2 and touch nothing. False for a flat mesh, which is left out.
fn geom(lines: &mut Lines, shape: &Shape, pose: &Isometry3<f64>, is_visual: bool, meshes: &mut MeshFiles) -> bool {
    let kind = match &shape.geometry {
        Geometry::Box(size) => format!("type=\"box\" size=\"{}\"", numbers((size * 0.5).as_slice())),
        Geometry::Cylinder(r, l) => format!("type=\"cylinder\" size=\"{}\"", numbers(&[*r, 0.5 * l])),
        Geometry::Capsule(r, l) => format!("type=\"capsule\" size=\"{}\"", numbers(&[*r, 0.5 * l])),
        Geometry::Sphere(r) => format!("type=\"sphere\" size=\"{}\"", number(*r)),
        Geometry::Mesh(points, triangles) => {
            if convex_hull_3d(points).is_none() {
                return false;
            }
            format!("type=\"mesh\" mesh=\"{}\"", meshes.add(points, triangles).trim_end_matches(".obj"))
        }
    };
    let role = if is_visual { "group=\"2\" contype=\"0\" conaffinity=\"0\"" } else { "group=\"3\"" };
    let (pos, quat) = (numbers(pose.translation.vector.as_slice()), wxyz(&pose.rotation));
    let rgba = shape.rgba.map(|x| x.to_string()).join(" ");
    lines.line(&format!("<geom {kind} pos=\"{pos}\" quat=\"{quat}\" {role} rgba=\"{rgba}\"/>"));
    true
}
