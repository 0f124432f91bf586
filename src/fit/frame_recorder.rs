//! Collects the snapshots of a run in memory as the time series of a log.

use crate::export::column_names;
use crate::log::{JointSeries, Motion, ObjectSeries, RunInfo, SoleSeries, Trajectory, VertexSeries};
use crate::robot::JointKind;
use crate::sim::plant::objects::named_links;
use crate::sim::{Observer, ObserverError, Setup, SimEvent, Snapshot};

/// Frames of a run, as its log would have them: motion, soles and objects.
pub struct FrameRecorder {
    times: Vec<f64>,
    motion: Motion,
    soles: Vec<SoleSeries>,
    objects: Vec<ObjectSeries>,
}

impl FrameRecorder {
    /// A recorder for the run of a setup.
    pub fn new(setup: &Setup) -> Self {
        let joint = |joint: &crate::robot::Joint| JointSeries {
            name: joint.name.clone(),
            prismatic: joint.kind == JointKind::Prismatic,
            ..JointSeries::default()
        };
        let sole = |sole: &crate::robot::Sole| SoleSeries {
            name: sole.name.clone(),
            is_link: false,
            state: Vec::new(),
            force: Vec::new(),
            vertices: vec![VertexSeries::default(); sole.vertices.len()],
            points: Vec::new(),
        };
        let objects = named_links(setup.objects.iter().map(|object| (object.name.as_str(), &*object.model)));
        let object = |name: String| ObjectSeries { name, ..ObjectSeries::default() };
        FrameRecorder {
            times: Vec::new(),
            motion: Motion { joints: setup.model.joints.iter().map(joint).collect(), ..Motion::default() },
            soles: setup.model.soles.iter().map(sole).collect(),
            objects: objects.into_iter().map(|link| object(link.name)).collect(),
        }
    }

    /// Names of the columns that its frames have.
    pub fn column_names(self) -> Vec<String> {
        column_names(&self.into_trajectory())
    }

    /// The frames as a log.
    pub fn into_trajectory(self) -> Trajectory {
        let text = String::new;
        Trajectory {
            info: RunInfo {
                scenario: text(),
                key: text(),
                method: text(),
                program: text(),
                robot: text(),
                world_frame: text(),
            },
            complete: true,
            attachments: Vec::new(),
            times: self.times,
            motion: Some(self.motion),
            soles: Some(self.soles),
            residuals: None,
            estimate: None,
            self_collision: None,
            objects: self.objects,
            events: Vec::new(),
        }
    }
}

impl Observer for FrameRecorder {
    fn snapshot(&mut self, s: &Snapshot) -> Result<(), ObserverError> {
        self.times.push(s.time);
        let motion = &mut self.motion;
        motion.base_position.push(s.base_pose.translation.vector);
        motion.base_orientation.push(s.base_pose.rotation);
        motion.base_linear_velocity.push(s.base_linear_velocity);
        motion.base_angular_velocity.push(s.base_angular_velocity);
        motion.com.push(s.com);
        motion.com_velocity.push(s.com_velocity);
        motion.cop.push(s.centre_of_pressure);
        motion.stable_point.push(s.stable_point);
        for (j, joint) in motion.joints.iter_mut().enumerate() {
            joint.position.push(s.q[j]);
            joint.velocity.push(s.qd[j]);
            joint.desired_position.push(s.q_desired[j]);
            joint.desired_velocity.push(s.qd_desired[j]);
            joint.effort.push(s.effort[j]);
            joint.desired_effort.push(s.effort_desired[j]);
        }
        for (series, sole) in self.soles.iter_mut().zip(&s.soles) {
            series.state.push(sole.state.clone());
            series.force.push(sole.forces.iter().sum());
            for (v, vertex) in series.vertices.iter_mut().enumerate() {
                vertex.clamped.push(sole.clamped[v]);
                vertex.position.push(sole.positions[v]);
                vertex.velocity.push(sole.velocities[v]);
                vertex.force.push(sole.forces[v]);
            }
        }
        for (series, pose) in self.objects.iter_mut().zip(&s.object_poses) {
            series.position.push(pose.translation.vector);
            series.orientation.push(pose.rotation);
        }
        Ok(())
    }

    fn event(&mut self, _: &SimEvent) -> Result<(), ObserverError> {
        Ok(())
    }
}
