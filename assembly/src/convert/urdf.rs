//! A robot as URDF.
//!
//! The axis of a joint passes through the origin of its child in URDF. Where it does not pass through
//! that of the link, the link's frame is moved to the joint; or, in [`description`], a link without
//! mass ([`AXIS_LINK`]) is between both. Links welded to others are links without mass on fixed
//! joints.

use std::collections::HashSet;

use nalgebra::{Isometry3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::mesh_files::MeshFiles;
use super::xml_text::{Lines, direction, escape, number, numbers, origin};
use super::{Converted, joint_warnings, list};
use crate::robot::{
    Base, Coupling, Geometry, Joint, JointKind, Link, Model, NO_LIMIT, RigidInertia, Shape, link_held_by_armature,
};

/// End of the name of a link between a joint and the link it moves.
pub const AXIS_LINK: &str = "/axis";

/// The robot as a URDF for viewers and ROS: links keep their frames; meshes and couplings are left
/// out.
pub fn description(model: &Model) -> String {
    let mut writer = Writer::new(model, None);
    writer.robot();
    writer.lines.text
}

/// The text, with meshes and warnings.
///
/// # Errors
/// A link that only armatures of joints hold.
pub(super) fn write(model: &Model, folder: &str) -> Result<Converted, String> {
    if let Some(link) = link_held_by_armature(model) {
        return Err(format!(
            "link `{}` has no inertia but {}, and a URDF holds no armature: it would not load; write MJCF (.xml)",
            model.links[link].name,
            match link {
                0 => "that of armatures of joints".to_owned(),
                _ => format!("the armature of joint `{}`", model.joints[link - 1].name),
            }
        ));
    }
    let mut writer = Writer::new(model, Some((MeshFiles::default(), folder)));
    writer.robot();
    writer.warn();
    let meshes = writer.meshes.map_or(Vec::new(), |(meshes, _)| meshes.files);
    Ok(Converted { text: writer.lines.text, meshes, warnings: writer.warnings })
}

/// A text under construction.
struct Writer<'a> {
    model: &'a Model,
    lines: Lines,
    /// Mesh files and their folder; `None` for a description.
    meshes: Option<(MeshFiles, &'a str)>,
    warnings: Vec<String>,
    /// Names of joints so far.
    names: HashSet<String>,
}

impl<'a> Writer<'a> {
    fn new(model: &'a Model, meshes: Option<(MeshFiles, &'a str)>) -> Self {
        let names = model.joints.iter().map(|joint| joint.name.clone()).collect();
        Self { model, lines: Lines::default(), meshes, warnings: Vec::new(), names }
    }

    fn is_description(&self) -> bool {
        self.meshes.is_none()
    }

    fn robot(&mut self) {
        let model = self.model;
        self.lines.line("<?xml version=\"1.0\"?>");
        self.lines.open(&format!("<robot name=\"{}\">", escape(&model.name)));
        let is_fixed = model.base == Base::Fixed;
        if is_fixed && model.links[0].name != "world" && !self.is_description() {
            self.lines.line("<link name=\"world\"/>");
            self.fixed_joint("world_fixed", "world", &model.links[0].name, &Isometry3::identity());
        }
        for (i, link) in model.links.iter().enumerate() {
            let frame = self.frame(link);
            if let Some(parent) = link.parent {
                self.motion(i, &model.links[parent.0]);
            }
            // The world's link has no mass, or it would count as an ordinary link.
            let has_mass = !(is_fixed && i == 0 && link.name == "world");
            self.link(link, &frame, has_mass);
            for merged in &link.merged {
                self.lines.line(&format!("<link name=\"{}\"/>", escape(&merged.name)));
                let pose = frame.inv_mul(&merged.pose);
                self.fixed_joint(&format!("{}_fixed", merged.name), &link.name, &merged.name, &pose);
            }
        }
        self.lines.close("</robot>");
    }

    /// The written frame of a link in its internal frame.
    fn frame(&self, link: &Link) -> Isometry3<f64> {
        match self.is_description() {
            true => link.urdf_frame,
            false => Isometry3::from_parts(Translation3::identity(), link.urdf_frame.rotation),
        }
    }

    /// The joint that moves link `i`, at joint position 0.
    fn motion(&mut self, i: usize, parent: &Link) {
        let link = &self.model.links[i];
        let frame = self.frame(link);
        let turn = Rotation3::from_matrix_unchecked(link.rotation);
        let at_zero = Isometry3::from_parts(link.offset.into(), UnitQuaternion::from_rotation_matrix(&turn));
        let parent_frame = self.frame(parent);
        if frame.translation.vector == Vector3::zeros() {
            let pose = parent_frame.inv_mul(&(at_zero * frame));
            self.joint(i, (&parent.name, &link.name), &pose, &axis(&frame));
            return;
        }
        let between = format!("{}{AXIS_LINK}", link.name);
        self.lines.line(&format!("<link name=\"{}\"/>", escape(&between)));
        self.joint(i, (&parent.name, &between), &parent_frame.inv_mul(&at_zero), &Vector3::z());
        self.fixed_joint(&format!("{between}_fixed"), &between, &link.name, &frame);
    }

    /// Lists what is not written.
    fn warn(&mut self) {
        let (model, warnings) = (self.model, &mut self.warnings);
        let is_moved = |link: &&Link| link.parent.is_some() && link.urdf_frame.translation.vector != Vector3::zeros();
        let moved: Vec<&str> = model.links.iter().filter(is_moved).map(|link| link.name.as_str()).collect();
        list("the position of the frame, which is moved to the joint,", "link", &moved, warnings);
        let is_open = |j: &&Joint| {
            let drives = [j.effort_limit, j.velocity_limit];
            let is_limited = j.kind != JointKind::Continuous || drives.iter().any(|limit| limit.is_finite());
            let has_range = j.kind == JointKind::Continuous || (-j.lower).max(j.upper).is_finite();
            is_limited && !(has_range && drives.iter().all(|limit| limit.is_finite()))
        };
        let open: Vec<&str> = model.joints.iter().filter(is_open).map(|j| j.name.as_str()).collect();
        if let [first, rest @ ..] = &open[..] {
            let more = if rest.is_empty() { String::new() } else { format!(" and {} more", rest.len()) };
            let limits = format!("limits that joint `{first}`{more} lacks");
            warnings.push(format!("{limits} are written as {NO_LIMIT:e}, as URDF requires them"));
        }
        joint_warnings(model, false, warnings);
        let loops: Vec<&str> = model.loops.iter().map(|l| l.name.as_str()).collect();
        list("the closed loop", "constraint", &loops, warnings);
        let soles: Vec<&str> = model.soles.iter().map(|s| s.name.as_str()).collect();
        list("the polygon", "sole", &soles, warnings);
        let sensors = model.sensors.imu.iter().chain(&model.sensors.force).map(|s| s.name.as_str());
        let frames: Vec<&str> = sensors.chain(model.end_effectors.iter().map(|e| e.name.as_str())).collect();
        list("the frame", "sensor or end effector", &frames, warnings);
        if model.home.iter().any(|q| *q != 0.0) {
            warnings.push("the home posture is not written".into());
        }
    }

    fn fixed_joint(&mut self, name: &str, parent: &str, child: &str, pose: &Isometry3<f64>) {
        let mut name = name.to_owned();
        while !self.names.insert(name.clone()) {
            name.push('_');
        }
        let lines = &mut self.lines;
        lines.open(&format!("<joint name=\"{}\" type=\"fixed\">", escape(&name)));
        lines.line(&origin(pose));
        lines.line(&format!("<parent link=\"{}\"/>", escape(parent)));
        lines.line(&format!("<child link=\"{}\"/>", escape(child)));
        lines.close("</joint>");
    }

    fn joint(&mut self, i: usize, (parent, child): (&str, &str), pose: &Isometry3<f64>, axis: &Vector3<f64>) {
        let (model, lines, joint) = (self.model, &mut self.lines, &self.model.joints[i - 1]);
        let coupling = model.couplings.iter().find(|c| c.joint.0 == i - 1).filter(|_| self.meshes.is_some());
        let kind = match joint.kind {
            JointKind::Revolute => "revolute",
            JointKind::Continuous => "continuous",
            JointKind::Prismatic => "prismatic",
        };
        lines.open(&format!("<joint name=\"{}\" type=\"{kind}\">", escape(&joint.name)));
        lines.line(&origin(pose));
        lines.line(&format!("<parent link=\"{}\"/>", escape(parent)));
        lines.line(&format!("<child link=\"{}\"/>", escape(child)));
        lines.line(&format!("<axis xyz=\"{}\"/>", numbers(axis.as_slice())));
        let mut limit = String::new();
        if joint.kind != JointKind::Continuous {
            let (lower, upper) = (joint.lower.max(-NO_LIMIT), joint.upper.min(NO_LIMIT));
            limit += &format!(" lower=\"{}\" upper=\"{}\"", number(lower), number(upper));
        }
        // Other readers want both or, of a continuous joint, none.
        let drives = [("effort", joint.effort_limit), ("velocity", joint.velocity_limit)];
        if joint.kind != JointKind::Continuous || drives.iter().any(|(_, value)| value.is_finite()) {
            drives.iter().for_each(|(key, value)| limit += &format!(" {key}=\"{}\"", number(value.min(NO_LIMIT))));
        }
        if !limit.is_empty() {
            lines.line(&format!("<limit{limit}/>"));
        }
        if joint.damping != 0.0 || joint.friction != 0.0 {
            let (damping, friction) = (number(joint.damping), number(joint.friction));
            lines.line(&format!("<dynamics damping=\"{damping}\" friction=\"{friction}\"/>"));
        }
        if let Some(Coupling { leader, coefficients: [offset, multiplier, rest @ ..], .. }) = coupling {
            let leader = &model.joints[leader.0].name;
            let (multiplier, offset) = (number(*multiplier), number(*offset));
            match rest.iter().all(|c| *c == 0.0) {
                _ if *leader == joint.name => {
                    self.warnings.push(format!("joint `{}` is held at {offset}: not written", joint.name));
                }
                true => lines.line(&format!(
                    "<mimic joint=\"{}\" multiplier=\"{multiplier}\" offset=\"{offset}\"/>",
                    escape(leader)
                )),
                false => self
                    .warnings
                    .push(format!("joint `{}` follows `{leader}` by a polynomial: not written", joint.name)),
            }
        }
        lines.close("</joint>");
    }

    fn link(&mut self, link: &Link, frame: &Isometry3<f64>, has_mass: bool) {
        let lines = &mut self.lines;
        let has_mass = has_mass && (link.mass > 0.0 || link.inertia.amax() > 0.0);
        if !has_mass && link.visuals.is_empty() && link.collisions.is_empty() {
            lines.line(&format!("<link name=\"{}\"/>", escape(&link.name)));
            return;
        }
        lines.open(&format!("<link name=\"{}\">", escape(&link.name)));
        if has_mass {
            let RigidInertia { mass, com, tensor: t } = link.body().transformed(&frame.inverse());
            lines.open("<inertial>");
            lines.line(&format!("<origin xyz=\"{}\"/>", numbers(com.as_slice())));
            lines.line(&format!("<mass value=\"{}\"/>", number(mass)));
            let entries = [("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2)];
            let entries = entries.map(|(name, i, j)| format!("{name}=\"{}\"", number(t[(i, j)])));
            lines.line(&format!("<inertia {}/>", entries.join(" ")));
            lines.close("</inertial>");
        }
        for (tag, shapes) in [("visual", &link.visuals), ("collision", &link.collisions)] {
            for shape in shapes.iter().flat_map(without_capsule) {
                self.shape(tag, &shape, frame);
            }
        }
        self.lines.close("</link>");
    }

    fn shape(&mut self, tag: &str, shape: &Shape, frame: &Isometry3<f64>) {
        let geometry = match &shape.geometry {
            Geometry::Box(size) => format!("<box size=\"{}\"/>", numbers(size.as_slice())),
            Geometry::Cylinder(r, l) => format!("<cylinder radius=\"{}\" length=\"{}\"/>", number(*r), number(*l)),
            Geometry::Capsule(..) => return,
            Geometry::Sphere(r) => format!("<sphere radius=\"{}\"/>", number(*r)),
            Geometry::Mesh(points, triangles) => {
                let Some((meshes, folder)) = &mut self.meshes else { return };
                format!("<mesh filename=\"{}\"/>", escape(&format!("{folder}/{}", meshes.add(points, triangles))))
            }
        };
        let lines = &mut self.lines;
        lines.open(&format!("<{tag}>"));
        lines.line(&origin(&frame.inv_mul(&shape.pose)));
        lines.line(&format!("<geometry>{geometry}</geometry>"));
        if tag == "visual" {
            let rgba = shape.rgba.map(|x| x.to_string()).join(" ");
            lines.line(&format!("<material name=\"\"><color rgba=\"{rgba}\"/></material>"));
        }
        lines.close(&format!("</{tag}>"));
    }
}

/// A capsule, which most readers of URDF do not know, as a cylinder and the balls at its ends; other
/// shapes as they are.
fn without_capsule(shape: &Shape) -> Vec<Shape> {
    let Geometry::Capsule(radius, length) = shape.geometry else { return vec![shape.clone()] };
    let ball = |z: f64| Shape {
        pose: shape.pose * Isometry3::translation(0.0, 0.0, z),
        geometry: Geometry::Sphere(radius),
        rgba: shape.rgba,
    };
    if length <= 0.0 {
        return vec![ball(0.0)];
    }
    let cylinder = Shape { geometry: Geometry::Cylinder(radius, length), ..shape.clone() };
    vec![cylinder, ball(-0.5 * length), ball(0.5 * length)]
}

/// The joint's axis in the written frame.
fn axis(frame: &Isometry3<f64>) -> Vector3<f64> {
    direction(&(frame.rotation.inverse() * Vector3::z()))
}
