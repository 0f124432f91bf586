//! The part of a log that is constant over the run.

use crate::log::topic_groups::TopicGroups;
use crate::robot::Link;
use crate::terrain::Terrain;
use nalgebra::{Isometry3, Vector3};

/// A text attached to the log.
#[derive(Clone, Copy, Debug)]
pub struct AttachedText<'a> {
    /// File name.
    pub name: &'a str,
    /// Contents.
    pub text: &'a str,
}

/// Data of a log before the first tick.
#[derive(Clone, Copy, Debug)]
pub struct LogHeader<'a> {
    /// Name of the scenario.
    pub scenario_name: &'a str,
    /// Key of the run.
    pub key: &'a str,
    /// Contact method.
    pub method: &'a str,
    /// The resolved scenario, attached.
    pub scenario: AttachedText<'a>,
    /// The robot file, attached; none for a bare URDF.
    pub robot: Option<AttachedText<'a>>,
    /// The URDF, attached and published.
    pub urdf: AttachedText<'a>,
    /// Other input files of the run, attached.
    pub inputs: &'a [AttachedText<'a>],
    /// Pose of the floor in the world: a point of the plane, z its normal; none if there is no plane.
    pub floor: Option<Isometry3<f64>>,
    /// Outlines of the floor's friction regions, world, m.
    pub patches: &'a [Vec<Vector3<f64>>],
    /// Links of objects, in the order of their poses in a snapshot; the root link of an object has its name.
    pub objects: &'a [Link],
    /// Fixed bodies besides the floor.
    pub terrain: &'a Terrain,
    /// Topics to log.
    pub topics: TopicGroups,
    /// Greatest rate of topics that only viewers read, Hz.
    pub viewer_rate: f64,
}
