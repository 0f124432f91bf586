//! Bodies that touch each other, and their pairs.

use super::objects::Object;
use crate::collision::spatial::shape_points;
use crate::dynamics::reduced::{BodyId, Mechanisms};
use crate::dynamics::{State, Workspace, kinematics};
use crate::patches::{ConvexBody, touchable_depth};
use crate::robot::{Base, Geometry, Link, LinkId, Model, Shape, Sole};
use crate::scenario::{Diagnostic, Run, TouchingParts};
use crate::sim::Floor;
use crate::sim::bodies::{Body, FLOOR, FloorFriction, Host, Pair, PairRules, pairs};
use crate::sim::floor::{is_near, is_on_ball};
use crate::sim::plant::objects::named_links;
use crate::sim::setup::Start;
use crate::terrain::{Terrain, TerrainPiece};
use nalgebra::Vector3;

/// What of the robot touches terrain and objects: its soles, or the bodies of all links. With the floor alone these
/// are the round shapes, as hulls and soles touch it in another way.
pub(super) fn robot_bodies(model: &Model, run: &Run, resolution: usize) -> Vec<Body> {
    let s = &run.scenario;
    let is_scene = !s.terrain.is_empty() || !s.object.is_empty() || s.robot.self_contact;
    let body = |name: &str, link: LinkId, shape: ConvexBody, meets_floor: bool| {
        let host = Host::Link(BodyId { mechanism: 0, link });
        Body { name: name.into(), host, shape, friction: None, meets_floor, floor: FloorFriction::None }
    };
    match s.robot.contact {
        TouchingParts::Soles => {
            let of_sole = |sole: &Sole| Some(body(&sole.name, sole.link, flat_body(&sole.vertices)?, false));
            model.soles.iter().filter_map(of_sole).collect()
        }
        TouchingParts::Bodies => {
            let mut shapes = link_shapes(model, resolution);
            shapes.retain(|shape| is_scene || shape.meets_floor);
            let name = |link: LinkId| &model.links[link.0].name;
            shapes.into_iter().map(|s| body(name(s.link), s.link, s.shape, s.meets_floor)).collect()
        }
    }
}

/// A body of a link.
pub(super) struct LinkShape {
    pub link: LinkId,
    pub shape: ConvexBody,
    /// Whether the plane of the floor meets the exact surface of this shape.
    pub meets_floor: bool,
}

/// Shapes of all links: each round collision shape, and the convex hull of the others and the soles. A vertex of a
/// sole on a ball of its link is left out.
pub(super) fn link_shapes(model: &Model, resolution: usize) -> Vec<LinkShape> {
    let of_link = |(i, link): (usize, &Link)| -> Vec<LinkShape> {
        let id = LinkId(i);
        let soles = model.soles.iter().filter(|sole| sole.link == id).flat_map(|sole| &sole.vertices);
        let soles = soles.filter(|v| !link.collisions.iter().any(|shape| is_on_ball(shape, v)));
        let angular = link.collisions.iter().filter(|shape| round_body(shape).is_none());
        let points: Vec<Vector3<f64>> =
            angular.flat_map(|shape| shape_points(shape, resolution)).chain(soles.copied()).collect();
        let hull = ConvexBody::from_points(&points).or_else(|| flat_body(&points));
        let hull = hull.map(|shape| LinkShape { link: id, shape, meets_floor: false });
        let round = link.collisions.iter().filter_map(|shape| {
            Some(LinkShape { link: id, shape: round_body(shape)?, meets_floor: rolls_on_floor(model, id, shape) })
        });
        hull.into_iter().chain(round).collect()
    };
    model.links.iter().enumerate().flat_map(of_link).collect()
}

/// Whether the floor meets the exact surface of this shape: of round ones that are not near a sole of their link.
pub(super) fn rolls_on_floor(model: &Model, link: LinkId, shape: &Shape) -> bool {
    round_body(shape).is_some() && model.soles.iter().filter(|sole| sole.link == link).all(|sole| !is_near(sole, shape))
}

/// The body of a shape with a round surface.
fn round_body(shape: &Shape) -> Option<ConvexBody> {
    let body = match shape.geometry {
        Geometry::Sphere(radius) => ConvexBody::ball(radius),
        Geometry::Capsule(radius, length) => ConvexBody::capsule(0.5 * length, radius),
        Geometry::Cylinder(radius, length) => ConvexBody::cylinder(0.5 * length, radius),
        // The hulls of boxes are exact too.
        Geometry::Box(_) | Geometry::Mesh(..) => return None,
    };
    let has_volume = body.radius > 0.0 && body.inner + body.edge_rounding() > 0.0;
    has_volume.then(|| body.placed(&shape.pose))
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
/// other and with the robot, round shapes of the robot with the floor, and the pairs `own` of the robot's links.
/// Soles and hulls of the robot touch the floor without these.
pub(super) fn bodies(
    model: &Model,
    robot: Vec<Body>,
    own: &[[LinkId; 2]],
    floor: &Floor,
    objects: &[Object],
    rules: &PairRules,
) -> (Vec<Body>, Vec<Pair>) {
    let mut bodies = Vec::new();
    if !floor.is_absent {
        bodies.push(Body {
            name: FLOOR.into(),
            host: Host::World(floor.rotation, floor.point),
            shape: ConvexBody::half_space(),
            friction: None,
            meets_floor: false,
            floor: FloorFriction::Regions,
        });
    }
    bodies.extend(robot);
    for (o, object) in objects.iter().enumerate() {
        let links = named_links(std::iter::once((&*object.setup.name, &*object.setup.model)));
        bodies.extend(object.bodies.iter().map(|(link, shape)| Body {
            name: links[link.0].name.clone(),
            host: Host::Link(BodyId { mechanism: 1 + o, link: *link }),
            shape: shape.clone(),
            friction: object.friction,
            meets_floor: true,
            floor: FloorFriction::None,
        }));
    }
    let mechanism = |body: &Body| body.link().map(|link| link.mechanism);
    // A fixed root moves as little as the world.
    let is_fixed = |body: &Body| {
        let Some(BodyId { mechanism, link }) = body.link() else { return true };
        let model = mechanism.checked_sub(1).map_or(model, |o| &objects[o].setup.model);
        link == LinkId(0) && model.base == Base::Fixed
    };
    let may_touch = |a: &Body, b: &Body| {
        let (one, other) = (mechanism(a), mechanism(b));
        if let (Some(a), Some(b), Some(0), Some(0)) = (a.link(), b.link(), one, other) {
            return own.contains(&[a.link, b.link]) || own.contains(&[b.link, a.link]);
        }
        // Hulls and soles of the robot touch the floor with their own polygons. No object touches itself.
        let is_floor = |body: &Body| body.shape.is_half_space();
        let on_floor = is_floor(a) || is_floor(b);
        one != other && (!on_floor || a.meets_floor || b.meets_floor) && !(is_fixed(a) && is_fixed(b))
    };
    let may_touch = |a: &Body, b: &Body| may_touch(a, b) && rules.touches(&a.name, &b.name);
    let pairs = pairs::pairs(&bodies, may_touch, |a, b| rules.friction(&a.name, &b.name));
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
    rules: &PairRules,
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
    for body in bodies.iter().filter(|body| body.moves(mechanisms)) {
        let centre = body.placement(mechanisms).point(&body.shape.centre);
        let reach = Vector3::repeat(body.shape.radius);
        let mut near = Vec::new();
        terrain.near(&(centre - reach), &(centre + reach), |piece| near.push(piece));
        for piece in near {
            let piece = terrain.piece(piece, &mut buffer);
            let (Some(other), entry) = (Body::of_piece(piece), piece.entry) else { continue };
            if !rules.touches(&body.name, &other.name) {
                continue;
            }
            let key = format!("terrain.{entry}");
            found.extend(depth(body, &other).map(|depth| (depth, body.name.clone(), other.name, key)));
        }
    }
    let (depth, a, b, key) = found.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    let depth = if depth < 1e-4 { format!("{depth:.1e}") } else { format!("{depth:.4}") };
    Some(run.error_at(&key, format!("`{a}` and `{b}` overlap by {depth} m at the start"), None))
}
