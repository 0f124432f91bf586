//! A humanoid-shaped tree of any size: two legs, a torso, two arms, rectangular soles.

use nalgebra::{Isometry3, Matrix3, Rotation3, Vector3};
use std::f64::consts::FRAC_PI_2;
use stiction::robot::{Base, Drive, Joint, JointKind, Link, LinkId, Model, Sole};

/// `[joints per leg, joints per arm, joints of the torso]`.
pub fn humanoid([leg, arm, torso]: [usize; 3]) -> Model {
    let mut model = Model::tree("humanoid".into(), Base::Floating, vec![], vec![]);
    model.links.push(link(None, 0, 10.0));
    for side in [-1.0, 1.0] {
        let foot = limb(&mut model, 0, leg, Vector3::new(0.0, 0.1 * side, -0.1));
        let corners = [(0.1, 0.05), (-0.1, 0.05), (-0.1, -0.05), (0.1, -0.05)];
        model.soles.push(Sole {
            name: format!("sole {side}"),
            link: LinkId(foot),
            vertices: corners.iter().map(|&(x, y)| Vector3::new(x, y, -0.05)).collect(),
        });
    }
    let chest = limb(&mut model, 0, torso, Vector3::new(0.0, 0.0, 0.2));
    for side in [-1.0, 1.0] {
        limb(&mut model, chest, arm, Vector3::new(0.0, 0.2 * side, 0.2));
    }
    model.home = vec![0.0; model.joints.len()];
    model
}

/// Adds a chain of `n` joints to link `parent` and returns its last link.
fn limb(model: &mut Model, parent: usize, n: usize, start: Vector3<f64>) -> usize {
    let mut at = parent;
    for i in 0..n {
        let mut l = link(Some(at), i, 3.0 / (1.0 + i as f64));
        l.offset = if i == 0 { start } else { Vector3::new(0.02, 0.01, -0.12) };
        model.links.push(l);
        model.joints.push(joint());
        at = model.links.len() - 1;
    }
    at
}

fn link(parent: Option<usize>, turn: usize, mass: f64) -> Link {
    // Each joint axis is perpendicular to the one before.
    let turn = Rotation3::from_euler_angles(FRAC_PI_2 * (turn % 2) as f64, FRAC_PI_2 * (turn % 3) as f64, 0.1);
    Link {
        name: String::new(),
        parent: parent.map(LinkId),
        rotation: turn.into_inner(),
        offset: Vector3::zeros(),
        mass,
        com: Vector3::new(0.01, 0.02, -0.05),
        inertia: Matrix3::from_diagonal(&Vector3::new(0.01, 0.012, 0.008)) * mass,
        urdf_frame: Isometry3::identity(),
        merged: vec![],
        visuals: vec![],
        collisions: vec![],
    }
}

fn joint() -> Joint {
    Joint {
        name: String::new(),
        kind: JointKind::Revolute,
        lower: -3.0,
        upper: 3.0,
        velocity_limit: f64::INFINITY,
        effort_limit: f64::INFINITY,
        damping: 0.0,
        friction: 0.0,
        armature: 0.01,
        lag: 0.0,
        static_friction: 0.0,
        stribeck_velocity: 0.2,
        slip_velocity: 0.05,
        stop: None,
        drive: Drive::default(),
        drive_configured: false,
    }
}
