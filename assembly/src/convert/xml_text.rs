//! XML text: numbers, vectors, escapes, indentation.

use std::fmt::Write;

use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};

use crate::math;

/// A number with the fewest digits that read back to the same bits.
pub(super) fn number(x: f64) -> String {
    let text = format!("{x:?}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

/// Numbers with spaces between them.
pub(super) fn numbers(list: &[f64]) -> String {
    list.iter().map(|x| number(*x)).collect::<Vec<_>>().join(" ")
}

/// Text as the value of an attribute.
pub(super) fn escape(text: &str) -> String {
    let mut escaped = String::new();
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            c if c.is_control() => {
                let _ = write!(escaped, "&#{};", c as u32);
            }
            c => escaped.push(c),
        }
    }
    escaped
}

/// Roll, pitch, yaw of a rotation. Yaw comes first, roll from what remains, so that the product is
/// exact to rounding near a pitch of 90 degrees too (Herter and Lott, "Algorithms for decomposing
/// 3-D orthogonal matrices", 1993).
pub(super) fn rpy(rotation: &UnitQuaternion<f64>) -> [f64; 3] {
    let r: Matrix3<f64> = rotation.to_rotation_matrix().into_inner();
    let yaw = math::atan2(r[(1, 0)], r[(0, 0)]);
    let (s, c) = math::sin_cos(yaw);
    let pitch = math::atan2(-r[(2, 0)], c * r[(0, 0)] + s * r[(1, 0)]);
    let roll = math::atan2(s * r[(0, 2)] - c * r[(1, 2)], c * r[(1, 1)] - s * r[(0, 1)]);
    [roll, pitch, yaw].map(|angle| angle + 0.0)
}

/// The quaternion w x y z.
pub(super) fn wxyz(rotation: &UnitQuaternion<f64>) -> String {
    numbers(&[rotation.w, rotation.i, rotation.j, rotation.k])
}

/// Position and rotation as `xyz` and `rpy`.
pub(super) fn origin(pose: &Isometry3<f64>) -> String {
    let (xyz, rpy) = (numbers(pose.translation.vector.as_slice()), numbers(&rpy(&pose.rotation)));
    format!("<origin xyz=\"{xyz}\" rpy=\"{rpy}\"/>")
}

/// A unit vector in other axes, whose rounding is removed where an entry is 0 or 1 to it.
pub(super) fn direction(v: &Vector3<f64>) -> Vector3<f64> {
    v.map(|x| if (x - x.round()).abs() < 1e-15 { x.round() + 0.0 } else { x })
}

/// Lines with indentation.
#[derive(Default)]
pub(super) struct Lines {
    pub text: String,
    depth: usize,
}

impl Lines {
    pub fn line(&mut self, text: &str) {
        let _ = writeln!(self.text, "{:1$}{text}", "", 2 * self.depth);
    }

    pub fn open(&mut self, text: &str) {
        self.line(text);
        self.depth += 1;
    }

    pub fn close(&mut self, text: &str) {
        self.depth -= 1;
        self.line(text);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn numbers_read_back_to_the_same_bits(bits in any::<u64>()) {
            let x = f64::from_bits(bits);
            prop_assume!(x.is_finite());
            prop_assert_eq!(number(x).parse::<f64>().unwrap().to_bits(), bits);
        }

        #[test]
        fn angles_give_back_the_rotation_at_any_pitch(a in prop::array::uniform3(-3.2f64..3.2), upright in any::<bool>()) {
            let pitch = if upright { std::f64::consts::FRAC_PI_2 } else { a[1] };
            let turn = UnitQuaternion::from_euler_angles(a[0], pitch, a[2]);
            let [roll, pitch, yaw] = rpy(&turn);
            let again = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
            let error = again.to_rotation_matrix().into_inner() - turn.to_rotation_matrix().into_inner();
            prop_assert!(error.amax() < 1e-14, "{error}");
        }
    }

    #[test]
    fn texts_are_escaped() {
        assert_eq!(escape("a<\"&>\n"), "a&lt;&quot;&amp;&gt;&#10;");
    }
}
