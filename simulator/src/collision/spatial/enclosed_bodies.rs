//! Removes bodies enclosed in other bodies, which cannot be touched before the outer ones.

use super::body::{Body, DroppedBody, WhyBody};
use super::link_tree::joints_between;
use super::pair_search::Sampler;
use crate::collision::kinematics::{LinkPose, link_poses};
use crate::robot::Model;

/// Postures tested in addition to home. In each a quarter of the joints is at either end of its
/// range.
const POSTURES: usize = 200;
/// A body may protrude by this much and still count as enclosed, m: rounding.
const ROUNDING: f64 = 1e-12;

/// Removes bodies that are inside another one in all postures tested.
pub(super) fn drop_enclosed(model: &Model, bodies: Vec<Body>, seed: u64) -> (Vec<Body>, Vec<DroppedBody>) {
    let mut postures = vec![model.home.clone()];
    let mut sampler = Sampler::new(model, seed, "inner");
    postures.extend((0..POSTURES).map(|_| sampler.posture(model)));
    let mut poses = vec![vec![LinkPose::IDENTITY; model.links.len()]; postures.len()];
    postures.iter().zip(&mut poses).for_each(|(q, poses)| link_poses(model, q, poses));

    let outside = |inner: &Body, outer: &Body, poses: &[LinkPose]| {
        let (i, o) = (&poses[inner.link.0], &poses[outer.link.0]);
        let (turn, shift) = (o.rotation.tr_mul(&i.rotation), o.rotation.tr_mul(&(i.origin - o.origin)));
        let mut top = 0;
        outer.polytope.triangles.iter().any(|t| {
            let [a, b, c] = t.map(|k| outer.polytope.vertices[k as usize]);
            let normal = (b - a).cross(&(c - a)).normalize();
            top = inner.polytope.support(&inner.polytope.vertices, &turn.tr_mul(&normal), top);
            let highest = turn * inner.polytope.vertices[top as usize] + shift;
            normal.dot(&(highest - a)) > ROUNDING
        })
    };
    let encloses = |outer: &Body, inner: &Body| {
        // Without a joint between them one posture is enough.
        let fixed = joints_between(model, inner.link, outer.link).is_empty();
        !poses.iter().take(if fixed { 1 } else { poses.len() }).any(|p| outside(inner, outer, p))
    };
    let mut dropped: Vec<Option<usize>> = vec![None; bodies.len()];
    for i in 0..bodies.len() {
        // One of two equal bodies remains.
        let outer = |o: &usize| *o != i && dropped[*o].is_none() && encloses(&bodies[*o], &bodies[i]);
        dropped[i] = (0..bodies.len()).find(outer);
    }
    let dropped_body = |i: usize, outer: usize| DroppedBody {
        link: bodies[i].link,
        name: bodies[i].name.clone(),
        why: WhyBody::Inside(bodies[outer].name.clone()),
    };
    let removed = dropped.iter().enumerate().filter_map(|(i, o)| o.map(|o| dropped_body(i, o))).collect();
    let kept = bodies.into_iter().zip(&dropped).filter(|(_, o)| o.is_none()).map(|(b, _)| b).collect();
    (kept, removed)
}
