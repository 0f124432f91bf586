//! Conditions that the tree of links does not contain: coupled joints and closed loops. Their equations are
//! in `dynamics::constraints`.

use super::model::{JointId, LinkId};
use nalgebra::Isometry3;

/// A joint whose position is a polynomial of the position of another one: `q = sum_i c_i x^i`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Coupling {
    /// The following joint.
    pub joint: JointId,
    /// The joint it follows, whose position is x; itself, with a constant polynomial, if it is held.
    pub leader: JointId,
    /// `c_0` to `c_4`, rad or m over powers of rad or m.
    pub coefficients: [f64; 5],
}

impl Coupling {
    /// Position of the following joint, and its first and second derivatives by that of the leader.
    pub fn evaluate(&self, x: f64) -> (f64, f64, f64) {
        let [c0, c1, c2, c3, c4] = self.coefficients;
        let position = c0 + x * (c1 + x * (c2 + x * (c3 + x * c4)));
        let slope = c1 + x * (2.0 * c2 + x * (3.0 * c3 + x * (4.0 * c4)));
        let curvature = 2.0 * c2 + x * (6.0 * c3 + x * (12.0 * c4));
        (position, slope, curvature)
    }
}

/// What a closed loop holds.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum LoopKind {
    /// The origins of both frames coincide: three conditions.
    Ball,
    /// So do their z axes: five conditions, which leave the rotation about z.
    Pin,
    /// The frames coincide: six conditions.
    Weld,
    /// The origins have a distance, m, above 0: a massless rod with ball joints at both ends.
    Rod(f64),
}

impl LoopKind {
    /// Number of conditions.
    pub fn number(self) -> usize {
        match self {
            LoopKind::Ball => 3,
            LoopKind::Pin => 5,
            LoopKind::Weld => 6,
            LoopKind::Rod(_) => 1,
        }
    }
}

/// A closed loop: two frames held together.
#[derive(Clone, PartialEq, Debug)]
pub struct LoopClosure {
    /// Name, unique among the robot's loops.
    pub name: String,
    /// What is held.
    pub kind: LoopKind,
    /// Link of the first frame.
    pub link: LinkId,
    /// The first frame, in the link's **internal** frame.
    pub pose: Isometry3<f64>,
    /// Link of the second frame; `None` for the world.
    pub other: Option<LinkId>,
    /// The second frame, in the other link's **internal** frame or in the world.
    pub other_pose: Isometry3<f64>,
}
