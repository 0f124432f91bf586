//! Mass and inertia of a body as MJCF.
//!
//! MuJoCo takes a body that moves only if its mass, kg, and its principal moments, kg m^2, are at
//! least 1e-15, and a full tensor only if its moments are clearly positive. Moments near these
//! bounds are thus written with their axes.

use nalgebra::{Matrix3, Rotation3, SymmetricEigen, UnitQuaternion};

use super::xml_text::{number, numbers, wxyz};
use crate::robot::RigidInertia;

/// Least mass and principal moment of a body that moves (mjMINVAL of MuJoCo).
const LEAST: f64 = 1e-15;
/// Least moment, and least ratio to the greatest, of a tensor that is written in full.
const LEAST_IN_FULL: f64 = 1e-12;
const LEAST_RATIO: f64 = 1e-6;
/// Excess of the greatest moment over the sum of the others that is rounding, relative.
const ROUNDING: f64 = 1e-9;

/// `<inertial>` of a body by its tensor.
pub(super) fn inertial(body: &RigidInertia) -> String {
    let t = &body.tensor;
    let full = [t[(0, 0)], t[(1, 1)], t[(2, 2)], t[(0, 1)], t[(0, 2)], t[(1, 2)]];
    let (pos, mass, full) = (numbers(body.com.as_slice()), number(body.mass), numbers(&full));
    format!("<inertial pos=\"{pos}\" mass=\"{mass}\" fullinertia=\"{full}\"/>")
}

/// `<inertial>` of a body that moves, with mass and moments raised to the least ones; if so, also
/// a text with those of the model.
pub(super) fn raised_inertial(body: &RigidInertia) -> (String, Option<String>) {
    let eigen = SymmetricEigen::new(body.tensor);
    let (least, greatest) = (eigen.eigenvalues.min(), eigen.eigenvalues.max());
    // A thin plate's greatest moment is the sum of the others, beyond which rounding may put it.
    let excess = 2.0 * greatest - eigen.eigenvalues.sum();
    let is_plain = least >= LEAST_IN_FULL && least >= LEAST_RATIO * greatest && excess < -LEAST_RATIO * greatest;
    if is_plain && body.mass >= LEAST {
        return (inertial(body), None);
    }
    let mut moments = eigen.eigenvalues.map(|moment| moment.max(LEAST));
    let others = moments.sum() - moments.max();
    moments = moments.map(|moment| moment.min(others));
    let mut axes: Matrix3<f64> = eigen.eigenvectors;
    if axes.determinant() < 0.0 {
        axes.neg_mut();
    }
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    let (pos, mass) = (numbers(body.com.as_slice()), number(body.mass.max(LEAST)));
    let (quat, diagonal) = (wxyz(&rotation), numbers(moments.as_slice()));
    let line = format!("<inertial pos=\"{pos}\" quat=\"{quat}\" mass=\"{mass}\" diaginertia=\"{diagonal}\"/>");
    let mut texts = Vec::new();
    // Rounding of a moment of 0 is no deviation of its own.
    if body.mass < LEAST || least < LEAST {
        let found =
            format!("mass {} kg and least principal moment {} kg m^2", number(body.mass), number(least.max(0.0)));
        texts.push(format!("{found}: MuJoCo requires {LEAST:e} of both, which is written for what is less"));
    }
    if greatest > others && excess > ROUNDING * greatest {
        let (greatest, others) = (number(greatest), number(others));
        texts.push(format!("greatest principal moment {greatest} kg m^2, written as {others}, the sum of the others"));
    }
    (line, (!texts.is_empty()).then(|| texts.join("; ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    fn body(mass: f64, moments: [f64; 3], turn: UnitQuaternion<f64>) -> RigidInertia {
        let r = turn.to_rotation_matrix().into_inner();
        let tensor = r * Matrix3::from_diagonal(&Vector3::from(moments)) * r.transpose();
        RigidInertia { mass, com: Vector3::zeros(), tensor: 0.5 * (tensor + tensor.transpose()) }
    }

    /// The numbers of an attribute.
    fn values(line: &str, key: &str) -> Vec<f64> {
        let text = line.split(&format!("{key}=\"")).nth(1).and_then(|rest| rest.split('"').next()).unwrap();
        text.split(' ').map(|x| x.parse().unwrap()).collect()
    }

    #[test]
    fn moments_are_at_least_those_of_mujoco_and_their_axes_give_the_tensor() {
        let turn = UnitQuaternion::from_euler_angles(0.3, -0.7, 1.1);
        for (mass, moments, is_raised) in [
            (0.0, [0.0; 3], true),
            (1e-20, [1e-20; 3], true),
            (2.0, [0.5, 0.5, 0.0], true),
            (1.0, [0.3, 0.2, 0.5], false),
            (1e-9, [1e-14; 3], false),
            (1.0, [0.3, 0.2, 0.5 + 1e-4], true),
        ] {
            let body = body(mass, moments, turn);
            let (line, text) = raised_inertial(&body);
            assert_eq!(text.is_some(), is_raised, "{line}");
            let written = values(&line, "diaginertia");
            assert!(written.iter().all(|m| *m >= LEAST) && values(&line, "mass")[0] >= LEAST, "{line}");
            let sum: f64 = written.iter().sum();
            assert!(written.iter().all(|m| *m <= sum - m), "{line}");
            let q = values(&line, "quat");
            let r = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(q[0], q[1], q[2], q[3]));
            let r = r.to_rotation_matrix().into_inner();
            let again = r * Matrix3::from_diagonal(&Vector3::from_row_slice(&written)) * r.transpose();
            assert!((again - body.tensor).amax() <= 2e-15 || moments[2] > 0.5, "{line}");
        }
        let (line, text) = raised_inertial(&body(1.0, [0.3, 0.2, 0.4], turn));
        assert!(text.is_none() && line.contains("fullinertia"), "{line}");
    }
}
