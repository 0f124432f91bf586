//! Bodies that touch each other, and their pairs.

use super::objects::Object;
use crate::collision::spatial::shape_points;
use crate::dynamics::reduced::{BodyId, Mechanisms};
use crate::dynamics::{State, Workspace, kinematics};
use crate::patches::{ConvexBody, touchable_depth};
use crate::robot::{LinkId, Model};
use crate::scenario::{Diagnostic, Run, TouchingParts};
use crate::sim::Floor;
use crate::sim::bodies::{Body, FloorFriction, Host, Pair, pairs};
use crate::sim::setup::Start;
use crate::terrain::{Terrain, TerrainPiece};
use nalgebra::Vector3;

/// What of the robot touches terrain and objects: its soles, or the convex hulls of all links, to which
/// the soles belong. `resolution` is the number of corners to a circle.
pub(super) fn robot_bodies(model: &Model, parts: TouchingParts, resolution: usize) -> Vec<Body> {
    let host = |link: LinkId| Host::Link(BodyId { mechanism: 0, link });
    match parts {
        TouchingParts::Soles => {
            let of_sole = |sole: &crate::robot::Sole| {
                let shape = flat_body(&sole.vertices)?;
                let (name, host) = (sole.name.clone(), host(sole.link));
                Some(Body { name, host, shape, friction: None, floor: FloorFriction::None })
            };
            model.soles.iter().filter_map(of_sole).collect()
        }
        TouchingParts::Bodies => {
            let of_link = |(i, link): (usize, &crate::robot::Link)| {
                let soles = model.soles.iter().filter(|sole| sole.link.0 == i).flat_map(|sole| &sole.vertices);
                let shapes = link.collisions.iter().flat_map(|shape| shape_points(shape, resolution));
                let points: Vec<Vector3<f64>> = shapes.chain(soles.copied()).collect();
                let shape = ConvexBody::from_points(&points).or_else(|| flat_body(&points))?;
                let (name, host) = (link.name.clone(), host(LinkId(i)));
                Some(Body { name, host, shape, friction: None, floor: FloorFriction::None })
            };
            model.links.iter().enumerate().filter_map(of_link).collect()
        }
    }
}

/// A convex polygon, a line or a point.
fn flat_body(points: &[Vector3<f64>]) -> Option<ConvexBody> {
    match points {
        [] => None,
        [point] => Some(ConvexBody::point(*point)),
        [from, to] => ConvexBody::segment([*from, *to]),
        polygon => ConvexBody::plate(polygon),
    }
}

/// The bodies of a run and the pairs that may touch besides terrain: objects with the floor, with each
/// other and with the robot. Soles and links of the robot touch the floor without these.
pub(super) fn bodies(robot: Vec<Body>, floor: &Floor, objects: &[Object]) -> (Vec<Body>, Vec<Pair>) {
    let mut bodies = Vec::new();
    if !floor.is_absent {
        bodies.push(Body {
            name: "floor".into(),
            host: Host::World(floor.rotation, floor.point),
            shape: ConvexBody::half_space(),
            friction: None,
            floor: FloorFriction::Regions,
        });
    }
    bodies.extend(robot);
    for (o, object) in objects.iter().enumerate() {
        bodies.push(Body {
            name: object.setup.name.clone(),
            host: Host::Link(BodyId { mechanism: 1 + o, link: LinkId(0) }),
            shape: object.shape.clone(),
            friction: object.friction,
            floor: FloorFriction::None,
        });
    }
    let mechanism = |body: &Body| body.link().map(|link| link.mechanism);
    let may_touch = |a: &Body, b: &Body| {
        let (a, b) = (mechanism(a), mechanism(b));
        // The robot touches the floor with its own polygons, and not itself.
        a != b && (a.is_some_and(|a| a > 0) || b.is_some_and(|b| b > 0))
    };
    let pairs = pairs::pairs(&bodies, may_touch, |_, _| None);
    (bodies, pairs)
}

/// Depth, m, up to which bodies may overlap at the start, and up to which soles may.
const DEPTH: f64 = 1e-6;
const SOLE_DEPTH: f64 = 1e-3;

/// An error if two bodies overlap at the start: it names those that do most, and their depth.
pub(super) fn overlap(
    run: &Run,
    model: &Model,
    start: &Start,
    objects: &[Object],
    (bodies, pairs): &(Vec<Body>, Vec<Pair>),
    terrain: &Terrain,
) -> Option<Diagnostic> {
    let workspace = |model: &Model, state: &State| {
        let mut ws = Workspace::new(model);
        kinematics::update(model, state, &mut ws);
        ws
    };
    let mut state = State::home(model);
    (state.position, state.rotation) = (start.position, start.rotation);
    state.joints.copy_from_slice(&start.joints);
    let robot = workspace(model, &state);
    let objects: Vec<Workspace> = objects.iter().map(|o| workspace(&o.setup.model, &o.setup.state)).collect();
    let mechanisms = Mechanisms { robot: &robot, objects: &objects };
    let depth = |a: &Body, b: &Body| {
        let depth = touchable_depth(&a.shape, &a.placement(mechanisms), &b.shape, &b.placement(mechanisms));
        let is_robot = |body: &Body| body.link().is_some_and(|link| link.mechanism == 0);
        let is_sole = run.scenario.robot.contact == TouchingParts::Soles && (is_robot(a) || is_robot(b));
        (depth > if is_sole { SOLE_DEPTH } else { DEPTH }).then_some(depth)
    };
    let mut found: Vec<(f64, String, String, String)> = Vec::new();
    for pair in pairs {
        let (a, b) = (&bodies[pair.bodies.0], &bodies[pair.bodies.1]);
        let object = [a, b].iter().filter_map(|body| body.link()?.mechanism.checked_sub(1)).max();
        let key = object.map_or("robot.base.position".into(), |o| format!("object.{o}"));
        found.extend(depth(a, b).map(|depth| (depth, a.name.clone(), b.name.clone(), key)));
    }
    let mut buffer = TerrainPiece::prism_buffer();
    for body in bodies.iter().filter(|body| body.link().is_some()) {
        let centre = body.placement(mechanisms).point(&body.shape.centre);
        let reach = Vector3::repeat(body.shape.radius);
        let mut near = Vec::new();
        terrain.near(&(centre - reach), &(centre + reach), |piece| near.push(piece));
        for piece in near {
            let piece = terrain.piece(piece, &mut buffer);
            let (Some(other), entry) = (Body::of_piece(piece), piece.entry) else { continue };
            let key = format!("terrain.{entry}");
            found.extend(depth(body, &other).map(|depth| (depth, body.name.clone(), other.name, key)));
        }
    }
    let (depth, a, b, key) = found.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let depth = if depth < 1e-4 { format!("{depth:.1e}") } else { format!("{depth:.4}") };
    Some(run.error_at(&key, format!("`{a}` and `{b}` overlap by {depth} m at the start"), None))
}
