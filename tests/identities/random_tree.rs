//! Seeded random trees, states and vectors. The generator is SplitMix64, so a seed gives the same
//! tree on every machine.

use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};
use stiction::dynamics::State;
use stiction::robot::{Base, Drive, Joint, JointKind, Link, LinkId, Model, Sole};

pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Random(seed)
    }

    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [low, high).
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    pub fn vector(&mut self, size: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.within(-size, size))
    }

    pub fn rotation(&mut self) -> Matrix3<f64> {
        let turn = self.vector(3.0);
        Rotation3::from_scaled_axis(turn).into_inner()
    }

    pub fn list(&mut self, n: usize, size: f64) -> Vec<f64> {
        (0..n).map(|_| self.within(-size, size)).collect()
    }

    /// Inertia of six random point masses, which is always physical.
    fn body(&mut self) -> (f64, Vector3<f64>, Matrix3<f64>) {
        let points: Vec<(f64, Vector3<f64>)> = (0..6).map(|_| (self.within(0.05, 0.5), self.vector(0.2))).collect();
        let mass: f64 = points.iter().map(|p| p.0).sum();
        let com = points.iter().map(|(m, x)| x * *m).sum::<Vector3<f64>>() / mass;
        let inertia = points
            .iter()
            .map(|(m, x)| {
                let d = x - com;
                (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * *m
            })
            .sum();
        (mass, com, inertia)
    }
}

pub fn joint(name: &str, kind: JointKind) -> Joint {
    Joint {
        name: name.into(),
        kind,
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        velocity_limit: f64::INFINITY,
        effort_limit: f64::INFINITY,
        damping: 0.0,
        friction: 0.0,
        armature: 0.0,
        lag: 0.0,
        static_friction: 0.0,
        stribeck_velocity: 0.2,
        slip_velocity: 0.05,
        stop: None,
        drive: Drive::default(),
        drive_configured: false,
    }
}

pub fn link(name: &str, parent: Option<usize>, body: (f64, Vector3<f64>, Matrix3<f64>)) -> Link {
    Link {
        name: name.into(),
        parent: parent.map(LinkId),
        rotation: Matrix3::identity(),
        offset: Vector3::zeros(),
        mass: body.0,
        com: body.1,
        inertia: body.2,
        urdf_frame: Isometry3::identity(),
        merged: vec![],
        visuals: vec![],
        collisions: vec![],
    }
}

/// A tree with `joints` joints of mixed kinds, a third of them with armature, and soles of 1 to 4 vertices on some links.
pub fn tree(seed: u64, joints: usize, base: Base) -> Model {
    let mut r = Random::new(seed);
    let mut model = Model::tree(format!("tree {seed}"), base, vec![link("root", None, r.body())], vec![]);
    model.home = vec![0.0; joints];
    for i in 0..joints {
        // Usually extend the newest chain, sometimes branch.
        let parent = if r.below(3) == 0 { r.below(i + 1) } else { i };
        let kind = [JointKind::Revolute, JointKind::Continuous, JointKind::Prismatic][r.below(3)];
        let mut j = joint(&format!("joint {i}"), kind);
        if r.below(3) == 0 {
            j.armature = r.within(0.0, 0.1);
        }
        let mut l = link(&format!("link {i}"), Some(parent), r.body());
        l.rotation = r.rotation();
        l.offset = r.vector(0.3);
        model.joints.push(j);
        model.links.push(l);
    }
    for k in 0..4 {
        let carrier = if k == 0 { model.links.len() - 1 } else { r.below(model.links.len()) };
        model.soles.push(Sole {
            name: format!("sole {k}"),
            link: LinkId(carrier),
            vertices: (0..=k).map(|_| r.vector(0.1)).collect(),
        });
    }
    model
}

pub fn state(model: &Model, r: &mut Random) -> State {
    let mut state = State::home(model);
    state.position = r.vector(2.0);
    state.rotation = UnitQuaternion::from_scaled_axis(r.vector(2.0));
    state.joints = r.list(model.nj(), 1.5);
    state.v = r.list(model.nv(), 2.0);
    state
}

/// Ten trees of both bases with one state each.
pub fn samples() -> impl Iterator<Item = (Model, State, Random)> {
    (0..10u64).map(|seed| {
        let base = if seed % 2 == 0 { Base::Floating } else { Base::Fixed };
        let model = tree(seed, 3 + 3 * seed as usize, base);
        let mut r = Random::new(1000 + seed);
        let state = state(&model, &mut r);
        (model, state, r)
    })
}
