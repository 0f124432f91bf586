//! A convex body that may touch others.

use crate::contact::model::problem::SoleProblem;
use crate::dynamics::Workspace;
use crate::dynamics::reduced::{BodyId, Mechanisms};
use crate::patches::{ConvexBody, Placement};
use crate::terrain::{ExtraFriction, TerrainPiece};
use nalgebra::{Matrix3, Vector3};

/// Friction of a surface or of a pair of surfaces.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Friction {
    /// Static coefficient.
    pub mu_s: f64,
    /// Kinetic coefficient.
    pub mu_k: f64,
    /// Its other terms.
    pub extra: ExtraFriction,
}

impl Friction {
    /// Gives it to a vertex of a polygon.
    pub fn assign(&self, sole: &mut SoleProblem, vertex: usize) {
        let (v, turning) = (&mut sole.vertices[vertex], &mut sole.turning);
        (v.mu_s, v.mu_k, v.viscous) = (self.mu_s, self.mu_k, self.extra.viscous.unwrap_or(0.0));
        turning.torsional = self.extra.torsional.unwrap_or(0.0);
        turning.rolling = self.extra.rolling.unwrap_or(0.0);
    }

    /// The smaller coefficients of both, or those of the only one.
    pub fn smaller(a: Option<Friction>, b: Option<Friction>) -> Option<Friction> {
        match (a, b) {
            (Some(a), Some(b)) => {
                let extra = a.extra.smaller(b.extra);
                Some(Friction { mu_s: a.mu_s.min(b.mu_s), mu_k: a.mu_k.min(b.mu_k), extra })
            }
            (a, b) => a.or(b),
        }
    }
}

/// Friction that is that of the floor, and changes with it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default)]
pub enum FloorFriction {
    /// None.
    #[default]
    None,
    /// That of the plane around all patches.
    Plane,
    /// That of the region of each point.
    Regions,
}

/// Name of the plane of the floor.
pub const FLOOR: &str = "floor";

/// What carries a body.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Host {
    /// The world: terrain, or the floor. Rotation (world from body) and position, m.
    World(Matrix3<f64>, Vector3<f64>),
    /// A link of the robot or of an object, whose internal frame is the body's.
    Link(BodyId),
}

/// A convex body.
#[derive(Clone, Debug)]
pub struct Body {
    /// Name in logs and messages.
    pub name: String,
    /// What carries it.
    pub host: Host,
    /// Its shape.
    pub shape: ConvexBody,
    /// Its friction, if it has its own.
    pub friction: Option<Friction>,
    /// Whether it meets the plane of the floor as a pair. Soles and hulls of the robot have polygons on it without.
    pub meets_floor: bool,
    /// Friction that it has in common with the floor: of the floor itself, and of terrain without its own.
    pub floor: FloorFriction,
}

impl Body {
    /// A piece of terrain; none if it has no volume.
    pub fn of_piece(piece: &TerrainPiece) -> Option<Self> {
        let faces = piece.faces.iter().map(|face| (face.corners.clone(), piece.normal(face))).collect();
        let mut shape = ConvexBody::from_faces(piece.points.clone(), faces)?;
        let hidden = piece.faces.iter().enumerate().filter(|(_, face)| !face.touchable);
        hidden.for_each(|(k, _)| shape.set_touchable(k as u16, false));
        Some(Body {
            name: piece.name.to_string(),
            host: Host::World(Matrix3::identity(), Vector3::zeros()),
            shape,
            friction: (!piece.is_like_floor).then_some(Friction {
                mu_s: piece.mu_s,
                mu_k: piece.mu_k,
                extra: piece.extra,
            }),
            meets_floor: false,
            floor: if piece.is_like_floor { FloorFriction::Plane } else { FloorFriction::None },
        })
    }

    /// The link that carries it, if it moves.
    pub fn link(&self) -> Option<BodyId> {
        match self.host {
            Host::World(..) => None,
            Host::Link(link) => Some(link),
        }
    }

    /// Whether a degree of freedom moves it: neither the world nor the root of a fixed base carries it.
    pub fn moves(&self, mechanisms: Mechanisms) -> bool {
        self.link().is_some_and(|body| !mechanisms.get(body.mechanism).support(body.link).is_empty())
    }

    /// Pose and velocity. Needs the kinematics of its mechanism.
    pub fn placement(&self, mechanisms: Mechanisms) -> Placement {
        match self.host {
            Host::World(rotation, position) => {
                Placement { rotation, position, velocity: Vector3::zeros(), omega: Vector3::zeros() }
            }
            Host::Link(body) => placement(mechanisms.get(body.mechanism), body),
        }
    }
}

fn placement(ws: &Workspace, body: BodyId) -> Placement {
    let link = &ws.links[body.link.0];
    Placement {
        rotation: link.rotation,
        position: ws.position + link.origin,
        velocity: link.velocity.at(&link.origin),
        omega: link.velocity.angular,
    }
}
