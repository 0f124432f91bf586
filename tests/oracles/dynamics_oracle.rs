//! Reads `dynamics_<robot>.json` (written by `make_dynamics.py`) and builds the robot recorded
//! there.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use serde::Deserialize;
use stiction::robot::{Base, Drive, Joint, JointKind, Link, LinkId, Model, Sole};

#[derive(Deserialize)]
pub struct Oracle {
    pub robot: String,
    pub floating: bool,
    pub gravity: [f64; 3],
    pub names: Vec<String>,
    pub armature: Vec<f64>,
    pub total_mass: f64,
    pub tree: Option<Vec<Body>>,
    pub soles: Vec<Point>,
    pub configurations: Vec<Configuration>,
}

/// A link as merged by Pinocchio, in the frame of its joint.
#[derive(Deserialize)]
pub struct Body {
    name: String,
    mass: f64,
    com: [f64; 3],
    inertia: [[f64; 3]; 3],
    #[serde(flatten)]
    joint: Option<JointPlacement>,
}

#[derive(Deserialize)]
struct JointPlacement {
    parent: usize,
    rotation: [[f64; 3]; 3],
    offset: [f64; 3],
    kind: String,
    axis: [f64; 3],
}

#[derive(Deserialize)]
pub struct Point {
    pub link: usize,
    pub point: [f64; 3],
}

/// Inputs and true values; matrices by rows, lower triangles row by row.
#[derive(Deserialize)]
pub struct Configuration {
    pub position: [f64; 3],
    pub rotation: [[f64; 3]; 3],
    pub joints: Vec<f64>,
    pub v: Vec<f64>,
    pub vdot: Vec<f64>,
    pub tau: Vec<f64>,
    pub floor: [[f64; 3]; 3],
    pub mass_lower: Vec<f64>,
    pub bias: Vec<f64>,
    pub inverse_dynamics: Vec<f64>,
    pub forward_dynamics: Vec<f64>,
    pub positions: Vec<[f64; 3]>,
    pub rotations: Vec<[[f64; 3]; 3]>,
    pub com: [f64; 3],
    pub com_velocity: [f64; 3],
    pub momentum: [f64; 6],
    pub kinetic_energy: f64,
    pub potential_energy: f64,
    pub frames: Vec<FrameTruth>,
    pub contact_w_lower: Vec<f64>,
    pub contact_a0: Vec<f64>,
    pub contact_velocity: Vec<f64>,
}

#[derive(Deserialize)]
pub struct FrameTruth {
    pub point: [f64; 3],
    pub jacobian: Vec<Vec<f64>>,
    pub velocity: [f64; 6],
    pub acceleration: [f64; 6],
}

/// A model with the map from the oracle's indices to its own.
pub struct Subject {
    pub model: Model,
    /// Our joint for each of the oracle's.
    pub joint: Vec<usize>,
    /// Our link for each of the oracle's (the root first).
    pub link: Vec<usize>,
    /// Pose of the oracle's link frame in our internal frame, by the oracle's link.
    pub frame: Vec<Isometry3<f64>>,
}

pub fn matrix(rows: &[[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

impl Oracle {
    pub fn parse(text: &str) -> Self {
        serde_json::from_str(text).expect("an oracle file of make_dynamics.py")
    }

    /// The recorded tree, each link frame rotated so that its joint axis is z.
    pub fn recorded(&self) -> Subject {
        let bodies = self.tree.as_ref().expect("a frozen tree");
        let base = if self.floating { Base::Floating } else { Base::Fixed };
        let mut model = Model::tree(self.robot.clone(), base, vec![], vec![]);
        model.home = vec![0.0; bodies.len() - 1];
        // Oracle's link frame from our internal frame.
        let mut turns: Vec<Matrix3<f64>> = vec![];
        for body in bodies {
            let (mut rotation, mut offset, mut parent) = (Matrix3::identity(), Vector3::zeros(), None);
            let mut turn = Matrix3::identity();
            if let Some(joint) = &body.joint {
                let axis = Vector3::from(joint.axis);
                turn = Rotation3::rotation_between(&Vector3::z(), &axis)
                    .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI))
                    .into_inner();
                let before = turns[joint.parent].transpose();
                rotation = before * matrix(&joint.rotation) * turn;
                offset = before * Vector3::from(joint.offset);
                parent = Some(LinkId(joint.parent));
                model.joints.push(self.plain_joint(&body.name, &joint.kind, model.joints.len()));
            }
            turns.push(turn);
            model.links.push(Link {
                name: body.name.clone(),
                parent,
                rotation,
                offset,
                mass: body.mass,
                com: turn.transpose() * Vector3::from(body.com),
                inertia: turn.transpose() * matrix(&body.inertia) * turn,
                urdf_frame: Isometry3::identity(),
                merged: vec![],
                visuals: vec![],
                collisions: vec![],
            });
        }
        assert!(model.joints.iter().map(|j| &j.name).eq(&self.names), "tree and names of {}", self.robot);
        let frame = turns.iter().map(|t| {
            let back = UnitQuaternion::from_matrix(&t.transpose());
            Isometry3::from_parts(Translation3::identity(), back)
        });
        let subject = Subject {
            joint: (0..model.nj()).collect(),
            link: (0..model.links.len()).collect(),
            frame: frame.collect(),
            model,
        };
        self.with_soles(subject)
    }

    /// A robot of this repository, its joints found by name, armature and soles as in the oracle.
    pub fn loaded(&self, path: &str) -> Subject {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
        let mut model = stiction::robot::load(&path).expect("our own robot").model;
        assert_eq!(model.nj(), self.names.len());
        let joint: Vec<usize> = self.names.iter().map(|n| model.joint(n).expect("joint of that name").0).collect();
        for (&j, &armature) in joint.iter().zip(&self.armature) {
            model.joints[j].armature = armature;
        }
        let link: Vec<usize> = std::iter::once(0).chain(joint.iter().map(|j| j + 1)).collect();
        // A joint's frame is the URDF frame of the link it moves.
        let frame = link.iter().map(|&l| model.links[l].urdf_frame).collect();
        self.with_soles(Subject { model, joint, link, frame })
    }

    /// One-vertex soles at the oracle's points, instead of the model's own.
    pub fn with_soles(&self, mut subject: Subject) -> Subject {
        subject.model.soles = self
            .soles
            .iter()
            .enumerate()
            .map(|(i, s)| Sole {
                name: format!("sole {i}"),
                link: LinkId(subject.link[s.link]),
                vertices: vec![(subject.frame[s.link] * nalgebra::Point3::from(s.point)).coords],
            })
            .collect();
        subject
    }

    fn plain_joint(&self, name: &str, kind: &str, index: usize) -> Joint {
        Joint {
            name: name.into(),
            kind: match kind {
                "revolute" => JointKind::Revolute,
                "continuous" => JointKind::Continuous,
                "prismatic" => JointKind::Prismatic,
                other => panic!("joint kind {other}"),
            },
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            velocity_limit: f64::INFINITY,
            effort_limit: f64::INFINITY,
            damping: 0.0,
            friction: 0.0,
            armature: self.armature[index],
            lag: 0.0,
            static_friction: 0.0,
            stribeck_velocity: 0.2,
            slip_velocity: 0.05,
            stop: None,
            drive: Drive::default(),
            drive_configured: false,
        }
    }
}

impl Subject {
    /// The oracle's velocity vector, in our order.
    pub fn ours(&self, theirs: &[f64]) -> Vec<f64> {
        let nb = self.model.nb();
        let mut out = theirs.to_vec();
        for (k, &j) in self.joint.iter().enumerate() {
            out[nb + j] = theirs[nb + k];
        }
        out
    }

    /// Our index of the oracle's velocity `k`.
    pub fn velocity(&self, k: usize) -> usize {
        let nb = self.model.nb();
        if k < nb { k } else { nb + self.joint[k - nb] }
    }
}
