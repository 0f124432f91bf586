//! Writes `/tf`: the pose of every frame. The parent of each link, moving or welded, is its parent
//! in the URDF, as in ROS, so that viewers can overlay the URDF. A sole's frame, `sole/NAME`, is a
//! child of its link; its origin is the mean of the sole's vertices and its axes are those of the
//! link's URDF frame. The frames of objects, `object/NAME`, are children of the root frame.

use crate::files::RecordError;
use crate::log::write::conversion::{quaternion, timestamp, vector};
use crate::log::write::log_header::LogHeader;
use crate::log::write::log_output::{Channel, LogOutput};
use crate::log::write::topic::Topic;
use crate::robot::{Link, Model};
use crate::sim::Snapshot;
use foxglove::messages::{FrameTransform, FrameTransforms};
use nalgebra::Isometry3;
use std::collections::HashMap;

/// Name of the root frame: `world`, or `map` if a link is called `world`.
pub(super) fn world_frame(model: &Model) -> &'static str {
    if model.link("world").is_some() { "map" } else { "world" }
}

/// Name of the frame of an object's link: no link of the robot has it.
pub(super) fn object_frame(link: &Link) -> String {
    format!("object/{}", link.name)
}

pub(super) struct FramesTopic {
    channel: Channel,
    /// One transform per link, in the model's order, then the frames fixed in a link, then objects.
    message: FrameTransforms,
    parents: Vec<Option<usize>>,
    /// First transform of the objects.
    objects: usize,
}

impl FramesTopic {
    pub fn open(output: &mut LogOutput, model: &Model, header: &LogHeader) -> Result<Self, RecordError> {
        let parents: Vec<Option<usize>> = model.links.iter().map(|l| l.parent.map(|p| p.0)).collect();
        let moving = model.links.iter().zip(&parents).map(|(link, parent)| {
            let parent = parent.map_or(world_frame(model), |p| &model.links[p].name);
            transform(parent, &link.name, &Isometry3::identity())
        });
        let mut transforms: Vec<_> = moving.chain(fixed(model, header.urdf.text)).collect();
        let objects = transforms.len();
        let of_world = |link: &Link| transform(world_frame(model), &object_frame(link), &Isometry3::identity());
        transforms.extend(header.objects.iter().map(of_world));
        Ok(Self {
            channel: output.foxglove::<FrameTransforms>("/tf")?,
            message: FrameTransforms { transforms },
            parents,
            objects,
        })
    }
}

/// Frames of welded links and soles.
fn fixed(model: &Model, urdf: &str) -> Vec<FrameTransform> {
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
        found.push(transform(&link.name, &format!("sole/{}", sole.name), &pose));
    }
    found
}

/// Parents of the links that fixed joints attach. The model merges chains of them into one link;
/// the URDF has the chain.
fn welds(urdf: &str) -> HashMap<String, String> {
    let Ok(document) = roxmltree::Document::parse(urdf) else { return HashMap::new() };
    let joints = document.root_element().children().filter(|n| n.has_tag_name("joint"));
    let link = |joint: roxmltree::Node, end: &str| {
        joint.children().find(|n| n.has_tag_name(end))?.attribute("link").map(str::to_owned)
    };
    joints
        .filter(|j| j.attribute("type") == Some("fixed"))
        .filter_map(|j| Some((link(j, "child")?, link(j, "parent")?)))
        .collect()
}

fn transform(parent: &str, child: &str, pose: &Isometry3<f64>) -> FrameTransform {
    FrameTransform {
        timestamp: None,
        parent_frame_id: parent.to_owned(),
        child_frame_id: child.to_owned(),
        translation: Some(vector(&pose.translation.vector)),
        rotation: Some(quaternion(&pose.rotation)),
    }
}

impl Topic for FramesTopic {
    fn record(&mut self, time: u64, s: &Snapshot, output: &mut LogOutput) -> Result<(), RecordError> {
        for ((to, pose), parent) in self.message.transforms.iter_mut().zip(&s.link_poses).zip(&self.parents) {
            let local = parent.map_or(*pose, |p| s.link_poses[p].inv_mul(pose));
            to.translation = Some(vector(&local.translation.vector));
            to.rotation = Some(quaternion(&local.rotation));
        }
        for (to, pose) in self.message.transforms[self.objects..].iter_mut().zip(&s.object_poses) {
            to.translation = Some(vector(&pose.translation.vector));
            to.rotation = Some(quaternion(&pose.rotation));
        }
        let stamp = timestamp(time);
        for to in &mut self.message.transforms {
            to.timestamp = Some(stamp);
        }
        output.send(&mut self.channel, time, &self.message)
    }
}
