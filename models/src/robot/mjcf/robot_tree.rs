//! Chooses the bodies that are the robot.
//!
//! Each body directly under the world with a free joint is a robot of its own; all others that
//! have joints are together one robot with a fixed base. The one with most joints is chosen. A
//! single body without joints is a robot with a fixed base.

use std::collections::HashSet;

use super::bodies::{Bodies, Held};
use super::document::Document;
use super::ignored::Ignored;
use super::joints::Kind;
use super::selection::Selection;
use crate::robot::model::Base;
use crate::robot::robot_error::RobotError;

/// The robot's bodies and how it is held.
pub(super) struct RobotTree {
    /// The bodies directly under the world that belong to the robot.
    pub tops: Vec<usize>,
    pub base: Base,
    /// True if the root link is the world, otherwise it is the only top body.
    pub has_world: bool,
    /// True if the robot is only the top body's shapes, at any depth and without mass.
    pub is_scenery: bool,
}

/// A possible robot.
struct Candidate {
    tops: Vec<usize>,
    joints: usize,
    is_free: bool,
}

/// Kinds of the joints of each body.
///
/// # Errors
/// A free joint below another body, or together with other joints.
pub(super) fn joint_kinds(bodies: &Bodies, document: &Document) -> Result<Vec<Vec<Kind>>, RobotError> {
    let mut all = Vec::new();
    for (i, body) in bodies.bodies.iter().enumerate() {
        let kinds: Vec<Kind> = body.joints.iter().map(Kind::of).collect::<Result<_, _>>()?;
        if let Some(at) = kinds.iter().position(|kind| *kind == Kind::Free)
            && (body.parent != 0 || i == 0 || kinds.len() > 1)
        {
            let fault = joint_fault(&body.joints[at], document, "a free joint below another body or with other joints");
            return Err(fault.expected("a free joint as the only one of a body directly under the world").invalid());
        }
        if i == 0 && !kinds.is_empty() {
            return Err(joint_fault(&body.joints[0], document, "the world has a joint").invalid());
        }
        all.push(kinds);
    }
    Ok(all)
}

fn joint_fault(held: &Held, document: &Document, message: &str) -> crate::robot::robot_error::FileError {
    document.fault(held.view.id(), message)
}

/// Chooses the robot; `requested` overrides how it is held where possible.
pub(super) fn choose(
    bodies: &Bodies,
    kinds: &[Vec<Kind>],
    document: &Document,
    requested: Option<Base>,
    ignored: &mut Ignored,
) -> Result<RobotTree, RobotError> {
    let tops = bodies.tops();
    // Joints of each body under the world with what it carries.
    let mut counts = vec![0; tops.len()];
    for (top, kinds) in tops.iter().zip(kinds) {
        counts[*top] += kinds.iter().map(|kind| kind.motions()).sum::<usize>();
    }
    let count = |top: usize| counts[top];
    let all: Vec<usize> = (1..tops.len()).filter(|&i| tops[i] == i).collect();
    let is_free = |top: &usize| kinds[*top] == [Kind::Free];
    let mut candidates: Vec<Candidate> = all
        .iter()
        .filter(|top| is_free(top))
        .map(|&top| Candidate { tops: vec![top], joints: count(top), is_free: true })
        .collect();
    let fixed: Vec<usize> = all.iter().copied().filter(|top| !is_free(top) && count(*top) > 0).collect();
    if !fixed.is_empty() {
        let joints = fixed.iter().map(|&top| count(top)).sum();
        candidates.push(Candidate { tops: fixed, joints, is_free: false });
    } else if let ([only], true) = (&all[..], candidates.is_empty()) {
        candidates.push(Candidate { tops: vec![*only], joints: 0, is_free: false });
    }
    let most = candidates.iter().map(|c| c.joints).max();
    let mut best = candidates.into_iter().filter(|c| Some(c.joints) == most);
    let Some(chosen) = best.next() else {
        let bodies = bodies.bodies[0].element;
        let fault = document.fault(bodies, format!("the file has no robot: {} bodies and no joints", all.len()));
        return Err(fault.expected("bodies with joints below <worldbody>, or one body").invalid());
    };
    if let Some(other) = best.next() {
        let name = |c: &Candidate| format!("`{}`", bodies.bodies[c.tops[0]].name);
        let message =
            format!("the file has several robots with {} joints: {}, {}", other.joints, name(&chosen), name(&other));
        let fault = document.fault(bodies.bodies[other.tops[0]].element, message);
        return Err(fault
            .expected("one with more joints than any other")
            .help("keep one of them in the file")
            .invalid());
    }
    report_others(bodies, &chosen, &all, |top| count(top) > 0 || is_free(&top), ignored);
    held(bodies, kinds, document, (chosen.tops, chosen.is_free, requested), ignored)
}

/// The robot of a selected body under the world, or of one geom as a fixed body.
pub(super) fn choose_one(
    bodies: &Bodies,
    kinds: &[Vec<Kind>],
    document: &Document,
    (selection, requested): (Selection, Option<Base>),
    ignored: &mut Ignored,
) -> Result<RobotTree, RobotError> {
    match selection {
        Selection::Geom(body) => {
            Ok(RobotTree { tops: vec![body], base: Base::Fixed, has_world: false, is_scenery: true })
        }
        Selection::Top(top) => {
            let chosen = (vec![top], kinds[top] == [Kind::Free], requested);
            held(bodies, kinds, document, chosen, ignored)
        }
    }
}

/// Reports what is not part of the robot.
fn report_others(
    bodies: &Bodies,
    chosen: &Candidate,
    all: &[usize],
    moves: impl Fn(usize) -> bool,
    ignored: &mut Ignored,
) {
    let chosen: HashSet<usize> = chosen.tops.iter().copied().collect();
    for &top in all.iter().filter(|top| !chosen.contains(top)) {
        let body = &bodies.bodies[top];
        match moves(top) {
            true => ignored.warning(
                body.element,
                format!("body `{}` and what it carries are left out: another robot has more joints", body.name),
            ),
            false => ignored.note(body.element, "a body fixed to the world is not part of the robot"),
        }
    }
    for geom in &bodies.bodies[0].geoms {
        ignored.note(geom.view.id(), "a geom of the world is not part of the robot");
    }
}

/// The robot of some bodies under the world, and how it is held.
fn held(
    bodies: &Bodies,
    kinds: &[Vec<Kind>],
    document: &Document,
    (tops, is_free, requested): (Vec<usize>, bool, Option<Base>),
    ignored: &mut Ignored,
) -> Result<RobotTree, RobotError> {
    let single = matches!(tops[..], [top] if kinds[top].iter().all(|kind| *kind == Kind::Free));
    let base = match (is_free, requested) {
        (true, None) => Base::Floating,
        (false, None) => Base::Fixed,
        (false, Some(Base::Floating)) if !single => {
            let element = bodies.bodies[tops[0]].element;
            let fault = document.fault(element, "base = \"floating\" does not fit bodies with joints to the world");
            return Err(fault.expected("one body without joints, or with a free joint, under the world").invalid());
        }
        (_, Some(base)) => base,
    };
    let pose = &bodies.bodies[tops[0]].pose;
    if single && base == Base::Fixed && *pose != nalgebra::Isometry3::identity() {
        let body = &bodies.bodies[tops[0]];
        let p = pose.translation.vector;
        let message = format!("the pose of body `{}` in the world is not read: the scenario sets it", body.name);
        ignored.note(body.element, format!("{message}; its position is {} {} {}", p.x, p.y, p.z));
    }
    Ok(RobotTree { has_world: !single, tops, base, is_scenery: false })
}
