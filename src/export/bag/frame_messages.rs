//! Messages of `/tf` and `/tf_static`, from the frames of a log.
//!
//! Frames that fixed joints attach, and those of soles, are static. The frame `sole/NAME/world_axes`
//! is that of a sole's wrench: its origin is the mean of the sole's vertices, its axes are those of
//! the world.

use crate::export::bag::bag_log::{BagInstant, BagLog};
use crate::export::bag::messages::{TfMessage, Transform, TransformStamped};
use crate::export::bag::wrench_messages::centre;
use crate::log::ros::{Header, Time};
use crate::log::{Frame, object_frame, sole_frame, welds};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use std::collections::BTreeSet;

/// The frames of a log.
pub(super) struct Frames<'a> {
    log: &'a BagLog,
    fixed: Vec<&'a Frame>,
    moving: Vec<&'a Frame>,
    /// The frame of the base.
    root: Option<&'a str>,
    /// Frames of the objects in the trajectory.
    objects: Vec<String>,
    /// Frames of the wrenches.
    soles: Vec<String>,
}

/// Name of the frame of a sole's wrench.
pub(super) fn wrench_frame(sole: &str) -> String {
    format!("{}/world_axes", sole_frame(sole))
}

impl<'a> Frames<'a> {
    pub fn new(log: &'a BagLog) -> Self {
        let trajectory = &log.trajectory;
        let world = &trajectory.info.world_frame;
        let welded: BTreeSet<String> = trajectory.urdf_text().map(welds).unwrap_or_default().into_keys().collect();
        let of_soles = sole_frame("");
        // A robot that is fixed to the world still has its base in `/state`.
        let is_fixed = |frame: &&Frame| {
            frame.parent != *world && (welded.contains(&frame.name) || frame.name.starts_with(&of_soles))
        };
        let (fixed, moving): (Vec<_>, Vec<_>) = log.scene.frames.iter().partition(is_fixed);
        let objects: Vec<String> = trajectory.objects.iter().map(|object| object_frame(&object.name)).collect();
        let of_base = |frame: &&&Frame| frame.parent == *world && !frame.name.starts_with(&object_frame(""));
        let root = trajectory.motion.as_ref().and_then(|_| moving.iter().find(of_base)).map(|f| f.name.as_str());
        Self { log, root, objects, soles: log.soles().map(|sole| wrench_frame(&sole.name)).collect(), fixed, moving }
    }

    /// True if there are moving frames.
    pub fn has_moving(&self) -> bool {
        !(self.moving.is_empty() && self.objects.is_empty() && self.soles.is_empty())
    }

    /// The fixed frames; none if there are no such frames.
    pub fn fixed(&self, stamp: Time) -> Option<TfMessage> {
        let transforms = self.fixed.iter().filter_map(|f| Some(transform(stamp, &f.parent, &f.name, f.poses.first()?)));
        let transforms: Vec<_> = transforms.collect();
        (!transforms.is_empty()).then_some(TfMessage { transforms })
    }

    /// The frames that the log has at an instant: all, or base, objects and soles only.
    pub fn moving(&self, at: &BagInstant, stamp: Time) -> TfMessage {
        let world = self.log.trajectory.info.world_frame.as_str();
        let mut transforms: Vec<TransformStamped> = Vec::new();
        let mut add = |parent: &str, name: &str, position: Vector3<f64>, orientation: UnitQuaternion<f64>| {
            transforms.push(transform(stamp, parent, name, &Isometry3::from_parts(position.into(), orientation)));
        };
        match (at.frames, at.tick) {
            (Some(i), _) => self.moving.iter().for_each(|frame| {
                let pose = &frame.poses[i];
                add(&frame.parent, &frame.name, pose.translation.vector, pose.rotation);
            }),
            (None, Some(i)) => {
                let base = self.root.zip(self.log.trajectory.motion.as_ref());
                base.iter().for_each(|(root, motion)| {
                    add(world, root, motion.base_position[i], motion.base_orientation[i]);
                });
                for (name, object) in self.objects.iter().zip(&self.log.trajectory.objects) {
                    add(world, name, object.position[i], object.orientation[i]);
                }
            }
            (None, None) => {}
        }
        if let Some(i) = at.tick {
            for (name, sole) in self.soles.iter().zip(self.log.soles()) {
                add(world, name, centre(sole, i), UnitQuaternion::identity());
            }
        }
        TfMessage { transforms }
    }
}

fn transform(stamp: Time, parent: &str, child: &str, pose: &Isometry3<f64>) -> TransformStamped {
    TransformStamped {
        header: Header { stamp, frame_id: parent.to_owned() },
        child_frame_id: child.to_owned(),
        transform: Transform { translation: pose.translation.vector.into(), rotation: pose.rotation.into() },
    }
}
