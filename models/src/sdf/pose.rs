//! Poses that remember the angles with which they were written.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

/// A pose. Composed with identities it keeps the roll, pitch and yaw of the file to the last bit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// The pose.
    pub isometry: Isometry3<f64>,
    angles: Option<[f64; 3]>,
}

impl Pose {
    /// No displacement.
    pub const IDENTITY: Pose = Pose {
        isometry: Isometry3 {
            rotation: UnitQuaternion::new_unchecked(Quaternion::new(1.0, 0.0, 0.0, 0.0)),
            translation: Translation3 { vector: Vector3::new(0.0, 0.0, 0.0) },
        },
        angles: Some([0.0; 3]),
    };

    /// Roll, pitch, yaw about the fixed axes x, y, z, rad, then the translation, m.
    pub fn from_rpy(position: [f64; 3], angles: [f64; 3]) -> Self {
        let [roll, pitch, yaw] = angles;
        let rotation = match angles == [0.0; 3] {
            true => UnitQuaternion::identity(),
            false => UnitQuaternion::from_euler_angles(roll, pitch, yaw),
        };
        Pose { isometry: Isometry3::from_parts(Vector3::from(position).into(), rotation), angles: Some(angles) }
    }

    /// A rotation, then the translation, m.
    pub fn from_quaternion(position: [f64; 3], rotation: UnitQuaternion<f64>) -> Self {
        Pose { isometry: Isometry3::from_parts(Vector3::from(position).into(), rotation), angles: None }
    }

    /// The pose of a frame whose pose in this one is `inner`.
    pub fn then(&self, inner: &Pose) -> Pose {
        let angles = match (self.angles, inner.angles) {
            (Some([0.0, 0.0, 0.0]), known) => known,
            (known, Some([0.0, 0.0, 0.0])) => known,
            _ => None,
        };
        Pose { isometry: self.isometry * inner.isometry, angles }
    }

    /// The inverse.
    pub fn inverse(&self) -> Pose {
        let angles = self.angles.filter(|angles| *angles == [0.0; 3]);
        Pose { isometry: self.isometry.inverse(), angles }
    }

    /// Position, m.
    pub fn position(&self) -> [f64; 3] {
        self.isometry.translation.vector.into()
    }

    /// Roll, pitch, yaw, rad.
    pub fn rpy(&self) -> [f64; 3] {
        self.angles.unwrap_or_else(|| self.isometry.rotation.euler_angles().into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn written_angles_survive_identities() {
        let turned = Pose::from_rpy([1.0, 2.0, 3.0], [0.1, 0.2, 0.3]);
        let shifted = Pose::from_rpy([0.5, 0.0, 0.0], [0.0; 3]);
        assert_eq!(shifted.then(&turned).then(&shifted).rpy(), [0.1, 0.2, 0.3]);
        assert_eq!(shifted.then(&turned).position(), [1.5, 2.0, 3.0]);
        let twice = turned.then(&turned);
        let again = Pose::from_rpy(twice.position(), twice.rpy());
        assert!((again.isometry.to_homogeneous() - twice.isometry.to_homogeneous()).amax() < 1e-15);
        assert!(
            (turned.then(&turned.inverse()).isometry.to_homogeneous() - Pose::IDENTITY.isometry.to_homogeneous())
                .amax()
                < 1e-15
        );
    }
}
