//! The collision model of a robot: its bodies and the pairs of them that are monitored.

use super::body::{Body, DroppedBody, WhyBody};
use super::enclosed_bodies::drop_enclosed;
use super::link_tree::{carriers, joints_between};
use super::pair_search::{Search, closest_found};
use crate::collision::detection::PairDistance;
use crate::collision::kinematics::{LinkPose, link_poses};
use crate::robot::{JointId, LinkId, Model, SelfCollision};

/// A monitored pair of bodies.
#[derive(Clone, PartialEq, Debug)]
pub struct Pair {
    /// Indices into [`CollisionModel::bodies`], ascending.
    pub bodies: [usize; 2],
    /// The joints between them: only these change their distance.
    pub joints: Vec<JointId>,
}

/// A pair of bodies that is not monitored.
#[derive(Clone, PartialEq, Debug)]
pub struct DroppedPair {
    /// Indices into [`CollisionModel::bodies`], ascending.
    pub bodies: [usize; 2],
    /// Reason.
    pub why: WhyPair,
}

/// Reason why a pair is not monitored.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum WhyPair {
    /// The robot file excludes it.
    Ignored,
    /// The bodies are connected by a joint, or through links without bodies.
    Adjacent,
    /// They overlap in the home posture, by this depth, m.
    OverlapAtHome(f64),
    /// They cannot meet within the joint ranges: this is the least distance found, m.
    CannotMeet(f64),
}

/// Collision model of a robot: immutable, shared by all threads.
#[derive(Clone, Debug)]
pub struct CollisionModel {
    /// Convex bodies, at most one per link, in the links' order.
    pub bodies: Vec<Body>,
    /// Monitored pairs.
    pub pairs: Vec<Pair>,
    /// Links with shapes that are not bodies.
    pub dropped_bodies: Vec<DroppedBody>,
    /// Pairs that are not monitored.
    pub dropped_pairs: Vec<DroppedPair>,
    /// Parameters of the search for pairs that cannot meet.
    pub search: Search,
}

impl CollisionModel {
    /// Bodies and pairs of a robot. Random postures show which pairs cannot meet; the result
    /// depends only on the arguments.
    pub fn new(model: &Model, settings: &SelfCollision) -> Self {
        Self::searched(model, settings, Search::default())
    }

    /// As [`Self::new`], with another search.
    pub fn searched(model: &Model, settings: &SelfCollision, search: Search) -> Self {
        let mut this = Self::every_pair(model, settings);
        this.search = search;
        let candidates: Vec<[usize; 2]> = this.pairs.iter().map(|p| p.bodies).collect();
        let is_watched = |bodies: [usize; 2]| contains(&settings.watch, bodies.map(|b| this.bodies[b].link));
        let at_home = depths_at_home(model, &this.bodies, &candidates);
        let open: Vec<[usize; 2]> = candidates
            .iter()
            .zip(&at_home)
            .filter(|(bodies, depth)| depth.is_none() && !is_watched(**bodies))
            .map(|(bodies, _)| *bodies)
            .collect();
        let least = closest_found(model, &this.bodies, &open, &search);
        let why = |bodies: [usize; 2], depth: Option<f64>| {
            if is_watched(bodies) {
                return None;
            }
            let distance = open.iter().position(|o| *o == bodies).map(|i| least[i]);
            let far = distance.filter(|d| *d > search.margin).map(WhyPair::CannotMeet);
            depth.map(WhyPair::OverlapAtHome).or(far)
        };
        let reasons: Vec<Option<WhyPair>> = candidates.iter().zip(&at_home).map(|(b, d)| why(*b, *d)).collect();
        let mut reasons = reasons.into_iter();
        let dropped = candidates.iter().zip(reasons.clone());
        this.dropped_pairs.extend(dropped.filter_map(|(&bodies, why)| why.map(|why| DroppedPair { bodies, why })));
        this.dropped_pairs.sort_by_key(|p| p.bodies);
        this.pairs.retain(|_| reasons.next().flatten().is_none());
        this
    }

    /// Bodies of a robot and every pair of them except adjacent and ignored ones. Tests no
    /// postures, except for enclosed bodies.
    pub fn every_pair(model: &Model, settings: &SelfCollision) -> Self {
        let (bodies, dropped_bodies) = bodies(model, settings);
        let carriers = carriers(model, |link| bodies.iter().any(|b| b.link == link));
        let above = |link: LinkId| model.links[link.0].parent.and_then(|p| carriers[p.0]);
        let mut this = Self {
            bodies: Vec::new(),
            pairs: Vec::new(),
            dropped_bodies,
            dropped_pairs: Vec::new(),
            search: Search::default(),
        };
        for i in 0..bodies.len() {
            for k in i + 1..bodies.len() {
                let links = [bodies[i].link, bodies[k].link];
                let why = if contains(&settings.ignore, links) {
                    Some(WhyPair::Ignored)
                } else if (above(links[1]) == Some(links[0])) && !contains(&settings.watch, links) {
                    Some(WhyPair::Adjacent)
                } else {
                    None
                };
                match why {
                    Some(why) => this.dropped_pairs.push(DroppedPair { bodies: [i, k], why }),
                    None => {
                        let joints = joints_between(model, links[0], links[1]);
                        this.pairs.push(Pair { bodies: [i, k], joints });
                    }
                }
            }
        }
        this.bodies = bodies;
        this
    }

    /// Number of triangles of all bodies.
    pub fn triangles(&self) -> usize {
        self.bodies.iter().map(|b| b.polytope.triangles.len()).sum()
    }
}

fn contains(pairs: &[[LinkId; 2]], [a, b]: [LinkId; 2]) -> bool {
    pairs.contains(&[a, b]) || pairs.contains(&[b, a])
}

fn bodies(model: &Model, settings: &SelfCollision) -> (Vec<Body>, Vec<DroppedBody>) {
    let (mut bodies, mut dropped) = (Vec::new(), Vec::new());
    for (i, link) in model.links.iter().enumerate() {
        let Some(body) = Body::new(link, LinkId(i), settings.resolution) else { continue };
        if settings.bodies.as_ref().is_some_and(|listed| !listed.contains(&LinkId(i))) {
            dropped.push(DroppedBody { link: LinkId(i), name: link.name.clone(), why: WhyBody::NotListed });
            continue;
        }
        match body {
            Ok(body) => bodies.push(body),
            Err(reason) => dropped.push(reason),
        }
    }
    // Bodies listed in the robot file are monitored even inside another body.
    if settings.bodies.is_none() {
        let (kept, inner) = drop_enclosed(model, bodies, Search::default().seed);
        bodies = kept;
        dropped.extend(inner);
    }
    dropped.sort_by_key(|d| d.link);
    (bodies, dropped)
}

/// Depth of overlap of every pair in the home posture, m.
fn depths_at_home(model: &Model, bodies: &[Body], pairs: &[[usize; 2]]) -> Vec<Option<f64>> {
    let mut poses = vec![LinkPose::IDENTITY; model.links.len()];
    link_poses(model, &model.home, &mut poses);
    let mut near = PairDistance::new(bodies);
    near.set_poses(bodies, &poses);
    pairs.iter().map(|pair| near.depth(bodies, *pair)).collect()
}
