//! Compares runs with the trajectory of a reference run while they are simulated.

use crate::contact::model::state::{Mode, SoleState};
use crate::math;
use crate::results::Comparison;
use crate::sim::Sample;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use std::sync::Arc;

/// The sampled trajectory of a reference run, in one array: `8 (8 + joints + 3 soles + 3 objects + their
/// joints) + 4 soles` bytes each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReferenceMotion {
    rate: f64,
    joints: usize,
    soles: usize,
    objects: usize,
    object_joints: usize,
    /// Per sample: time, position 3, orientation 4 (i, j, k, w), joints, forces 3 per sole, positions 3 per
    /// object, joints of the objects.
    values: Vec<f64>,
    /// Per sample: the state of every sole.
    states: Vec<SoleState>,
}

impl ReferenceMotion {
    /// An empty trajectory with `rate` samples per second, Hz.
    pub fn new(rate: f64, joints: usize, soles: usize) -> Self {
        ReferenceMotion { rate, joints, soles, ..ReferenceMotion::default() }
    }

    /// With objects, which have this number of joints together.
    pub fn with_objects(self, objects: usize, object_joints: usize) -> Self {
        ReferenceMotion { objects, object_joints, ..self }
    }

    /// Samples per simulated second, Hz.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.values.len() / self.width()
    }

    /// Time of the last sample, s; 0 without any.
    pub fn end(&self) -> f64 {
        self.len().checked_sub(1).and_then(|last| self.get(last)).map_or(0.0, |(values, _)| values[0])
    }

    /// True without samples.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    fn width(&self) -> usize {
        8 + self.joints + 3 * self.soles + 3 * self.objects + self.object_joints
    }

    /// Appends a sample, which must have the numbers of joints, soles and objects given to
    /// [`new`](Self::new) and [`with_objects`](Self::with_objects).
    pub fn push(&mut self, s: &Sample) {
        debug_assert_eq!((s.joints.len(), s.forces.len(), s.states.len()), (self.joints, self.soles, self.soles));
        debug_assert_eq!((s.objects.len(), s.object_joints.len()), (self.objects, self.object_joints));
        self.values.push(s.time);
        self.values.extend_from_slice(s.position.as_slice());
        self.values.extend_from_slice(s.rotation.coords.as_slice());
        self.values.extend_from_slice(&s.joints);
        s.forces.iter().chain(&s.objects).for_each(|v| self.values.extend_from_slice(v.as_slice()));
        self.values.extend_from_slice(&s.object_joints);
        self.states.extend(s.states.iter().map(|state| merge_modes(*state)));
    }

    /// The values and states of a sample.
    fn get(&self, index: usize) -> Option<(&[f64], &[SoleState])> {
        let width = self.width();
        let values = self.values.get(index * width..(index + 1) * width)?;
        Some((values, &self.states[index * self.soles..(index + 1) * self.soles]))
    }
}

/// Maps states with one name to one state: turning about a vertex counts as sliding.
fn merge_modes(state: SoleState) -> SoleState {
    let mode = if state.mode == Mode::Static { Mode::Static } else { Mode::Sliding };
    SoleState { mode, ..state }
}

/// Accumulates the differences between a run and a reference trajectory.
#[derive(Clone, Debug)]
pub struct Comparator {
    reference: Arc<ReferenceMotion>,
    instants: u64,
    until: f64,
    /// Sums of squares.
    position: f64,
    joints: f64,
    force: f64,
    agreements: u64,
    objects: f64,
    object_joints: f64,
    /// Position and rotation at the last instant, and the greatest distance of an object.
    last: (f64, f64),
    last_object: f64,
}

impl Comparator {
    /// A comparator without samples.
    pub fn new(reference: Arc<ReferenceMotion>) -> Self {
        Comparator {
            reference,
            instants: 0,
            until: 0.0,
            position: 0.0,
            joints: 0.0,
            force: 0.0,
            agreements: 0,
            objects: 0.0,
            object_joints: 0.0,
            last: (0.0, 0.0),
            last_object: 0.0,
        }
    }

    /// Required samples per simulated second, Hz.
    pub fn rate(&self) -> f64 {
        self.reference.rate
    }

    /// Compares a sample; an instant that the reference lacks is skipped.
    pub fn take(&mut self, sample: &Sample) {
        let joints = self.reference.joints;
        let Some((values, states)) = self.reference.get(sample.index).filter(|(v, _)| v[0] == sample.time) else {
            return;
        };
        self.instants += 1;
        self.until = sample.time;
        let apart = sample.position - Vector3::new(values[1], values[2], values[3]);
        self.position += apart.norm_squared();
        let rotation = Quaternion::new(values[7], values[4], values[5], values[6]);
        self.last = (apart.norm(), angle(&sample.rotation, &UnitQuaternion::new_unchecked(rotation)));
        let squares = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| math::powi(a - b, 2)).sum::<f64>();
        let (of_joints, rest) = values[8..].split_at(joints);
        let (forces, rest) = rest.split_at(3 * self.reference.soles);
        let (objects, object_joints) = rest.split_at(3 * self.reference.objects);
        self.joints += squares(&sample.joints, of_joints);
        let forces = forces.chunks_exact(3).map(|f| Vector3::new(f[0], f[1], f[2]));
        self.force += sample.forces.iter().zip(forces).map(|(a, b)| (a - b).norm_squared()).sum::<f64>();
        self.last_object = 0.0;
        for (a, b) in sample.objects.iter().zip(objects.chunks_exact(3)) {
            let apart = (a - Vector3::new(b[0], b[1], b[2])).norm();
            self.objects += apart * apart;
            self.last_object = self.last_object.max(apart);
        }
        self.object_joints += squares(&sample.object_joints, object_joints);
        self.agreements += sample.states.iter().zip(states).filter(|(a, b)| merge_modes(**a) == **b).count() as u64;
    }

    /// The result so far.
    pub fn comparison(&self) -> Comparison {
        if self.instants == 0 {
            return Comparison::default();
        }
        let n = self.instants as f64;
        let mean = |sum: f64, per_instant: usize| (per_instant > 0).then(|| sum / (n * per_instant as f64));
        let (joints, soles) = (self.reference.joints, self.reference.soles);
        Comparison {
            instants: self.instants,
            until_s: Some(self.until),
            error_position_rms_m: Some((self.position / n).sqrt()),
            error_joint_rms_rad: mean(self.joints, joints).map(f64::sqrt),
            error_force_rms_n: mean(self.force, soles).map(f64::sqrt),
            contact_state_agreement: mean(self.agreements as f64, soles),
            error_final_position_m: Some(self.last.0),
            error_final_rotation_rad: Some(self.last.1),
            error_object_position_rms_m: mean(self.objects, self.reference.objects).map(f64::sqrt),
            error_object_joint_rms_rad: mean(self.object_joints, self.reference.object_joints).map(f64::sqrt),
            error_final_object_position_m: (self.reference.objects > 0).then_some(self.last_object),
            ..Comparison::default()
        }
    }
}

/// Angle between two orientations, rad, with full precision for small angles. With unit quaternions
/// half the angle t apart, `|q - p| = 2 sin(t / 4)` and `|q + p| = 2 cos(t / 4)`; q and -q are one
/// orientation.
fn angle(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>) -> f64 {
    let (near, far) = ((a.coords - b.coords).norm(), (a.coords + b.coords).norm());
    4.0 * math::atan2(near.min(far), near.max(far))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::model::state::Pattern;

    fn sample(index: usize) -> Sample {
        let t = index as f64 / 10.0;
        let slides = SoleState { pattern: Pattern::Face, mode: Mode::Pivoting(2) };
        Sample {
            index,
            time: t,
            position: Vector3::new(t, 2.0, 3.0),
            rotation: UnitQuaternion::from_scaled_axis(Vector3::new(t, -t, 0.5)),
            joints: vec![t, 1.0, -t],
            forces: vec![Vector3::new(0.0, 0.0, 10.0), Vector3::new(t, 0.0, 0.0)],
            states: vec![SoleState::fixed(Pattern::Face), slides],
            objects: vec![Vector3::new(t, 0.0, 1.0), Vector3::new(0.0, t, 1.0)],
            object_joints: vec![t, 2.0 * t, 0.5],
        }
    }

    fn reference(samples: usize) -> Arc<ReferenceMotion> {
        let mut trajectory = ReferenceMotion::new(10.0, 3, 2).with_objects(2, 3);
        (0..samples).for_each(|i| trajectory.push(&sample(i)));
        assert_eq!(trajectory.len(), samples);
        Arc::new(trajectory)
    }

    #[test]
    fn the_distance_of_a_run_from_itself_is_zero() {
        let mut comparator = Comparator::new(reference(5));
        (0..5).for_each(|i| comparator.take(&sample(i)));
        let found = comparator.comparison();
        assert_eq!((found.instants, found.until_s), (5, Some(0.4)));
        assert_eq!((found.error_position_rms_m, found.error_joint_rms_rad), (Some(0.0), Some(0.0)));
        assert_eq!((found.error_force_rms_n, found.contact_state_agreement), (Some(0.0), Some(1.0)));
        assert_eq!((found.error_final_position_m, found.error_final_rotation_rad), (Some(0.0), Some(0.0)));
        assert_eq!((found.error_object_position_rms_m, found.error_object_joint_rms_rad), (Some(0.0), Some(0.0)));
        assert_eq!(found.error_final_object_position_m, Some(0.0));
    }

    #[test]
    fn distances_are_root_means_over_instants_joints_and_soles() {
        let mut comparator = Comparator::new(reference(4));
        for i in 0..4 {
            let mut s = sample(i);
            // 0, 5, 10, 15 m; one joint of three off by 0.3; one sole of two off by 2 N in two
            // instants; objects off by 0, 1, 2, 3 m and by 0.5 m; one of their three joints off by 0.6.
            s.position += Vector3::new(3.0, 0.0, 4.0) * i as f64;
            s.joints[1] += 0.3;
            s.objects[0].z += i as f64;
            s.objects[1].x += 0.5;
            s.object_joints[2] -= 0.6;
            s.forces[1].y = if i % 2 == 0 { 2.0 } else { 0.0 };
            s.states[0] = if i == 3 { SoleState::FREE } else { s.states[0] };
            s.states[1].mode = Mode::Sliding;
            s.rotation = UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 1e-9 * i as f64, 0.0)) * s.rotation;
            comparator.take(&s);
        }
        let found = comparator.comparison();
        let near = |a: Option<f64>, b: f64| (a.unwrap() - b).abs() <= 1e-14 * b;
        assert!(near(found.error_position_rms_m, (350.0f64 / 4.0).sqrt()));
        assert!(near(found.error_joint_rms_rad, 0.3 / 3.0f64.sqrt()));
        assert!(near(found.error_object_position_rms_m, (15.0f64 / 8.0).sqrt()));
        assert!(near(found.error_object_joint_rms_rad, 0.6 / 3.0f64.sqrt()));
        assert!(near(found.error_final_object_position_m, 3.0));
        assert!(near(found.error_force_rms_n, (2.0 * 4.0f64 / 8.0).sqrt()));
        assert_eq!(found.contact_state_agreement, Some(7.0 / 8.0), "turning about a vertex is sliding");
        assert!(near(found.error_final_position_m, 15.0));
        // Coordinates of 1 carry 1e-16.
        assert!((found.error_final_rotation_rad.unwrap() - 3e-9).abs() < 1e-15);
    }

    #[test]
    fn only_common_instants_are_compared() {
        let mut comparator = Comparator::new(reference(3));
        // The run's own end, at an index where the reference has another time.
        let end = Sample { index: 2, time: 0.15, ..sample(2) };
        [sample(0), sample(1), end, sample(7)].iter().for_each(|s| comparator.take(s));
        let found = comparator.comparison();
        assert_eq!((found.instants, found.until_s), (2, Some(0.1)));
        let none = Comparator::new(reference(0)).comparison();
        assert_eq!(none, Comparison::default());
    }

    #[test]
    fn angles_are_accurate_up_to_a_half_turn() {
        let a = UnitQuaternion::from_scaled_axis(Vector3::new(0.1, 0.0, 0.2));
        for turn in [1e-12, 0.3, 2.0, 3.1] {
            let b = UnitQuaternion::from_scaled_axis(Vector3::new(0.0, turn, 0.0)) * a;
            let minus = UnitQuaternion::new_unchecked(-b.into_inner());
            // Rounding of the quaternions.
            assert!((angle(&a, &b) - turn).abs() < 2e-15, "{turn}");
            assert!((angle(&a, &minus) - turn).abs() < 2e-15, "{turn}");
        }
    }
}
