//! The internal frames: z is the joint axis, and the link poses equal those of the URDF read
//! literally.
//!
//! The reference is an independent reader. It uses 4x4 matrices, Rodrigues' formula about the axis
//! as written, no welding and no rotated frames. It shares only the parsed numbers of `urdf-rs`
//! with the library.

use std::collections::HashMap;

use nalgebra::{Isometry3, Matrix3, Matrix4, Vector3};
use stiction::robot::{JointKind, Model};

use super::{BODY, load_urdf, shipped};

/// Numbers in [-1, 1] from a fixed sequence (Lehmer, modulus 2^31 - 1).
pub struct Sequence(pub u64);

impl Sequence {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0 * 48271 % 2_147_483_647;
        2.0 * self.0 as f64 / 2_147_483_647.0 - 1.0
    }
}

fn rotation(axis: Vector3<f64>, angle: f64) -> Matrix3<f64> {
    let k = axis.normalize().cross_matrix();
    Matrix3::identity() + k * angle.sin() + k * k * (1.0 - angle.cos())
}

fn homogeneous(r: Matrix3<f64>, p: Vector3<f64>) -> Matrix4<f64> {
    let mut m = Matrix4::identity();
    m.fixed_view_mut::<3, 3>(0, 0).copy_from(&r);
    m.fixed_view_mut::<3, 1>(0, 3).copy_from(&p);
    m
}

/// Pose of every URDF link with respect to the root link, with the file read literally.
fn literal(text: &str, q: &HashMap<String, f64>) -> HashMap<String, Matrix4<f64>> {
    let urdf = urdf_rs::read_from_string(text).unwrap();
    let mut poses = HashMap::new();
    let is_child = |name: &str| urdf.joints.iter().any(|j| j.child.link == name);
    let root = urdf.links.iter().find(|l| !is_child(&l.name)).unwrap();
    poses.insert(root.name.clone(), Matrix4::identity());
    while poses.len() < urdf.links.len() {
        for j in &urdf.joints {
            let Some(parent) = poses.get(&j.parent.link) else { continue };
            let [roll, pitch, yaw] = j.origin.rpy.0;
            let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
            let r = rotation(z, yaw) * rotation(y, pitch) * rotation(x, roll);
            let origin = homogeneous(r, Vector3::from(j.origin.xyz.0));
            let axis = Vector3::from(j.axis.xyz.0);
            let value = q.get(&j.name).copied().unwrap_or(0.0);
            let motion = match j.joint_type {
                urdf_rs::JointType::Fixed => Matrix4::identity(),
                urdf_rs::JointType::Prismatic => homogeneous(Matrix3::identity(), axis.normalize() * value),
                _ => homogeneous(rotation(axis, value), Vector3::zeros()),
            };
            poses.insert(j.child.link.clone(), parent * origin * motion);
        }
    }
    poses
}

/// Pose of every URDF link by the model's documented convention: offset and rotation, then a motion about or along z.
pub fn by_model(model: &Model, q: &[f64]) -> HashMap<String, Matrix4<f64>> {
    let mut internal: Vec<Matrix4<f64>> = Vec::new();
    let mut named = HashMap::new();
    for (i, link) in model.links.iter().enumerate() {
        let pose = match link.parent {
            None => Matrix4::identity(),
            Some(parent) => {
                assert!(parent.0 < i, "parents come first");
                let at_zero = homogeneous(link.rotation, link.offset);
                let (s, c) = q[i - 1].sin_cos();
                let motion = match model.joints[i - 1].kind {
                    JointKind::Prismatic => homogeneous(Matrix3::identity(), Vector3::z() * q[i - 1]),
                    _ => homogeneous(Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0), Vector3::zeros()),
                };
                internal[parent.0] * at_zero * motion
            }
        };
        internal.push(pose);
        let matrix = |frame: &Isometry3<f64>| frame.to_homogeneous();
        named.insert(link.name.clone(), pose * matrix(&link.urdf_frame));
        for m in &link.merged {
            named.insert(m.name.clone(), pose * matrix(&m.pose));
        }
    }
    named
}

/// A chain with branches: axes, origins and joint types from the sequence, including axes along the
/// coordinate directions.
pub fn tangled(sequence: &mut Sequence, links: usize) -> String {
    let mut text = format!("<robot name=\"tangled\"><link name=\"l0\">{BODY}</link>");
    let coordinate =
        ["1 0 0", "-1 0 0", "0 1 0", "0 -1 0", "0 0 1", "0 0 -1", "1e-9 0 -1", "0 1e-9 1", "0.001 -0.002 -5"];
    for i in 1..links {
        let mut three = || format!("{} {} {}", sequence.next(), sequence.next(), sequence.next());
        let (xyz, rpy, random_axis) = (three(), three(), three());
        let axis = coordinate.get(i % 14).map_or(random_axis, |a| (*a).to_owned());
        let kind = ["continuous", "prismatic", "fixed", "continuous", "revolute"][i % 5];
        let parent = if i % 3 == 0 { i / 2 } else { i - 1 };
        text += &format!(
            "<joint name=\"j{i}\" type=\"{kind}\"><origin xyz=\"{xyz}\" rpy=\"{rpy}\"/><parent link=\"l{parent}\"/>\
             <child link=\"l{i}\"/><axis xyz=\"{axis}\"/><limit lower=\"-9\" upper=\"9\" effort=\"1\" velocity=\"1\"/>\
             </joint><link name=\"l{i}\">{BODY}</link>"
        );
    }
    text + "</robot>"
}

fn worst_difference(model: &Model, text: &str, sequence: &mut Sequence) -> f64 {
    let q: Vec<f64> = model.joints.iter().map(|_| 3.0 * sequence.next()).collect();
    let named = model.joints.iter().map(|j| j.name.clone()).zip(q.iter().copied()).collect();
    let (ours, theirs) = (by_model(model, &q), literal(text, &named));
    assert_eq!(ours.len(), theirs.len());
    theirs.iter().map(|(name, pose)| (ours[name] - pose).abs().max()).fold(0.0, f64::max)
}

#[test]
fn internal_frames_give_the_link_poses_of_the_urdf() {
    let mut sequence = Sequence(7);
    for _ in 0..20 {
        let text = tangled(&mut sequence, 40);
        let model = load_urdf(&text).unwrap().model;
        // Rounding of some 20 products of rotations, with lever arms of a few metres.
        assert!(worst_difference(&model, &text, &mut sequence) < 1e-12);
    }
}

#[test]
fn internal_frames_of_hoap2_give_the_link_poses_of_the_urdf() {
    let robot = shipped("hoap2/hoap2.toml");
    let worst = worst_difference(&robot.model, robot.urdf_text.as_ref().unwrap(), &mut Sequence(3));
    // As above, with lever arms below a metre.
    assert!(worst < 1e-14, "{worst}");
}

#[test]
fn z_is_the_axis() {
    let text = tangled(&mut Sequence(11), 60);
    let urdf = urdf_rs::read_from_string(&text).unwrap();
    let model = load_urdf(&text).unwrap().model;
    for (i, joint) in model.joints.iter().enumerate() {
        let link = &model.links[i + 1];
        assert_eq!(link.urdf_frame.translation.vector, Vector3::zeros(), "the origin stays on the joint");
        let axis = Vector3::from(urdf.joints.iter().find(|j| j.name == joint.name).unwrap().axis.xyz.0).normalize();
        // Rounding of one quaternion product.
        assert!((link.urdf_frame.rotation * axis - Vector3::z()).norm() < 2e-15, "{}", joint.name);
    }
}

#[test]
fn coordinate_axes_give_rotations_of_zeros_and_ones() {
    let model = shipped("hoap2/hoap2.toml").model;
    for link in &model.links {
        assert!(link.rotation.iter().all(|x| [-1.0, 0.0, 1.0].contains(x)), "{}: {}", link.name, link.rotation);
        assert_eq!(link.rotation.determinant(), 1.0);
    }
}
