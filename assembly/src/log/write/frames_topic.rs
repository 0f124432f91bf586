//! Writes `/tf`: the pose of every frame. The parent of each link, moving or welded, is its parent
//! in the URDF, as in ROS, so that viewers can overlay the URDF. A sole's frame, `sole/NAME`, is a
//! child of its link; its origin is the mean of the sole's vertices and its axes are those of the
//! link's URDF frame. The frames of objects, `object/NAME`, are children of the root frame.

use crate::convert::AXIS_LINK;
use crate::files::RecordError;
use crate::log::write::log_header::LogHeader;
use crate::log::write::log_output::{Channel, LogOutput};
use crate::log::write::proto_writer::ProtoWriter;
use crate::log::write::topic::Topic;
use crate::math;
use crate::robot::{JointKind, Model};
use crate::sim::Snapshot;
use foxglove::messages::FrameTransforms;
use nalgebra::{Isometry3, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};
use std::collections::HashMap;

/// Name of the root frame: `world`, or `map` if a link is called `world`.
pub(super) fn world_frame(model: &Model) -> &'static str {
    if model.link("world").is_some() { "map" } else { "world" }
}

/// Name of the frame of an object's link: no link of the robot has it.
pub fn object_frame(link: &str) -> String {
    format!("object/{link}")
}

/// Name of the frame of a sole.
pub fn sole_frame(sole: &str) -> String {
    format!("sole/{sole}")
}

/// Components of a unit vector or quaternion below this are rounding, logged as 0: they would change
/// with every message, which compresses worse than a constant.
const ROUNDING: f64 = 1e-15;

/// The frame of a link that moves in its parent's frame, both as in the URDF.
struct MovingFrame {
    /// Encoded names of parent and child.
    names: Vec<u8>,
    /// Number of the joint; none for the root, which moves in the world.
    joint: Option<(usize, JointKind)>,
    /// Pose at joint position 0.
    at_zero: Isometry3<f64>,
    /// Axis of the joint in the link's frame, and a point of it: 0 where a URDF defines the frame.
    axis: Vector3<f64>,
    centre: Vector3<f64>,
}

impl MovingFrame {
    fn new(model: &Model, i: usize) -> Self {
        let link = &model.links[i];
        let Some(parent) = link.parent else {
            let names = encoded_names(world_frame(model), &link.name);
            let zero = Vector3::zeros();
            return Self { names, joint: None, at_zero: Isometry3::identity(), axis: zero, centre: zero };
        };
        let parent = &model.links[parent.0];
        let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(link.rotation));
        let internal = Isometry3::from_parts(Translation3::from(link.offset), turn);
        let at_zero = parent.urdf_frame.inv_mul(&internal) * link.urdf_frame;
        let round = |x: f64| if x.abs() < ROUNDING { 0.0 } else { x };
        let rotation = UnitQuaternion::new_unchecked(Quaternion::from_vector(at_zero.rotation.coords.map(round)));
        Self {
            names: encoded_names(&parent.name, &link.name),
            joint: Some((i - 1, model.joints[i - 1].kind)),
            at_zero: Isometry3::from_parts(at_zero.translation, rotation),
            // Joints move along or about z of the internal frame.
            axis: link.urdf_frame.inverse_transform_vector(&Vector3::z()).map(round),
            centre: link.urdf_frame.inverse().translation.vector.map(round),
        }
    }

    /// The pose in the parent.
    fn pose(&self, s: &Snapshot) -> Isometry3<f64> {
        match self.joint {
            None => s.base_pose,
            Some((j, JointKind::Prismatic)) => {
                let shift = self.at_zero.rotation * self.axis * s.q[j];
                Isometry3::from_parts(
                    Translation3::from(self.at_zero.translation.vector + shift),
                    self.at_zero.rotation,
                )
            }
            Some((j, JointKind::Revolute | JointKind::Continuous)) => {
                let (sin, cos) = math::sin_cos(0.5 * s.q[j]);
                let turn = UnitQuaternion::new_unchecked(Quaternion::from_parts(cos, self.axis * sin));
                let shift = self.at_zero.rotation * (self.centre - turn * self.centre);
                let origin = Translation3::from(self.at_zero.translation.vector + shift);
                Isometry3::from_parts(origin, self.at_zero.rotation * turn)
            }
        }
    }
}

/// Writes the frames from the base's pose and the joint positions.
pub(super) struct FramesTopic {
    channel: Channel,
    /// One per link, in the model's order.
    moving: Vec<MovingFrame>,
    /// Frames fixed in a link: all fields but the time, encoded.
    fixed: Vec<Vec<u8>>,
    /// Encoded names of the objects' frames.
    objects: Vec<Vec<u8>>,
}

impl FramesTopic {
    pub fn open(output: &mut LogOutput, model: &Model, header: &LogHeader) -> Result<Self, RecordError> {
        let objects = header.objects.iter();
        Ok(Self {
            channel: output.foxglove::<FrameTransforms>("/tf")?,
            moving: (0..model.links.len()).map(|i| MovingFrame::new(model, i)).collect(),
            fixed: fixed(model, header.urdf.text),
            objects: objects.map(|link| encoded_names(world_frame(model), &object_frame(&link.name))).collect(),
        })
    }
}

/// Fields of `foxglove.FrameTransform`.
const TIMESTAMP: u32 = 1;
const PARENT: u32 = 2;
const CHILD: u32 = 3;
const TRANSLATION: u32 = 4;
const ROTATION: u32 = 5;

fn encoded_names(parent: &str, child: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut to = ProtoWriter::new(&mut bytes);
    to.text(PARENT, parent);
    to.text(CHILD, child);
    bytes
}

fn write_pose(to: &mut ProtoWriter, pose: &Isometry3<f64>) {
    to.vector(TRANSLATION, &pose.translation.vector);
    to.foxglove_quaternion(ROTATION, &pose.rotation);
}

/// Frames of welded links and soles.
fn fixed(model: &Model, urdf: &str) -> Vec<Vec<u8>> {
    let parents = welds(urdf);
    let mut found = Vec::new();
    for link in &model.links {
        for weld in &link.merged {
            let welded = parents.get(&weld.name).and_then(|p| link.merged.iter().find(|m| m.name == *p));
            let (parent, at) = welded.map_or((&link.name, link.urdf_frame), |m| (&m.name, m.pose));
            found.push(transform(parent, &weld.name, &at.inv_mul(&weld.pose)));
        }
    }
    for sole in &model.soles {
        let link = &model.links[sole.link.0];
        let mean = sole.centroid();
        let origin = link.urdf_frame.inverse_transform_point(&mean.into());
        let pose = Isometry3::from_parts(origin.into(), Default::default());
        found.push(transform(&link.name, &sole_frame(&sole.name), &pose));
    }
    found
}

/// Parents of the links that fixed joints attach. The model merges chains of them into one link;
/// the URDF has the chain.
pub fn welds(urdf: &str) -> HashMap<String, String> {
    let Ok(document) = roxmltree::Document::parse(urdf) else { return HashMap::new() };
    let joints = document.root_element().children().filter(|n| n.has_tag_name("joint"));
    let link = |joint: roxmltree::Node, end: &str| {
        joint.children().find(|n| n.has_tag_name(end))?.attribute("link").map(str::to_owned)
    };
    joints
        .filter(|j| j.attribute("type") == Some("fixed"))
        .filter_map(|j| Some((link(j, "child")?, link(j, "parent")?)))
        // Such a link moves.
        .filter(|(_, parent)| !parent.ends_with(AXIS_LINK))
        .collect()
}

/// A transform without its time, encoded.
fn transform(parent: &str, child: &str, pose: &Isometry3<f64>) -> Vec<u8> {
    let mut bytes = encoded_names(parent, child);
    write_pose(&mut ProtoWriter::new(&mut bytes), pose);
    bytes
}

impl Topic for FramesTopic {
    fn record(&mut self, time: u64, s: &Snapshot, output: &mut LogOutput) -> Result<(), RecordError> {
        /// Field of `foxglove.FrameTransforms`.
        const TRANSFORMS: u32 = 1;
        output.send_fields(&mut self.channel, time, |to| {
            for frame in &self.moving {
                to.message(TRANSFORMS, |to| {
                    to.timestamp(TIMESTAMP, time);
                    to.encoded(&frame.names);
                    write_pose(to, &frame.pose(s));
                });
            }
            for fields in &self.fixed {
                to.message(TRANSFORMS, |to| {
                    to.timestamp(TIMESTAMP, time);
                    to.encoded(fields);
                });
            }
            for (names, pose) in self.objects.iter().zip(&s.object_poses) {
                to.message(TRANSFORMS, |to| {
                    to.timestamp(TIMESTAMP, time);
                    to.encoded(names);
                    write_pose(to, pose);
                });
            }
        })
    }
}
