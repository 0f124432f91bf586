//! Resolves the frames of a model: poses of links, joints and nested models in the model's frame.
//!
//! A frame's pose is written relative to `relative_to`; left out, links and nested models relative
//! to the model, joints to their child, frames to what they are attached to, and what a link holds
//! to the link. A nested name is `MODEL::NAME`.

use std::collections::{HashMap, HashSet};

use super::document::{At, Frame, Inertial, Joint, Link, Model, SdfError, Sensor, Shape, WrittenPose};
use super::pose::Pose;
use crate::text::suggest::nearest;

/// Name of a model's own frame.
const OWN: &str = "__model__";

/// A model whose frames are resolved, with those of its nested models.
#[derive(Debug)]
pub struct Resolved<'a> {
    /// Links, nested ones after those of the model.
    pub links: Vec<ResolvedLink<'a>>,
    /// Joints, likewise.
    pub joints: Vec<ResolvedJoint<'a>>,
    /// Index of the link to which the model's frame is attached.
    pub canonical: Option<usize>,
    /// Pose in the model, and link to which it is attached, of every name.
    names: HashMap<String, (Pose, Option<usize>)>,
}

/// A link in its model.
#[derive(Debug)]
pub struct ResolvedLink<'a> {
    /// Name in the outer model, such as `arm::hand`.
    pub name: String,
    /// As written.
    pub link: &'a Link,
    /// Pose in the outer model.
    pub pose: Pose,
    /// Mass and inertia, with their pose in the link.
    pub inertial: Option<(Pose, &'a Inertial)>,
    /// Visual shapes with their poses in the link.
    pub visuals: Vec<(Pose, &'a Shape)>,
    /// Collision shapes with their poses in the link.
    pub collisions: Vec<(Pose, &'a Shape)>,
    /// Sensors with their poses in the link.
    pub sensors: Vec<(Pose, &'a Sensor)>,
}

/// A joint in its model.
#[derive(Debug)]
pub struct ResolvedJoint<'a> {
    /// Name in the outer model.
    pub name: String,
    /// As written.
    pub joint: &'a Joint,
    /// Prefix of names in its own model, such as `arm::`.
    pub prefix: String,
    /// Pose in the outer model.
    pub pose: Pose,
    /// Parent link; `None` for the world.
    pub parent: Option<usize>,
    /// Child link; `None` for the world.
    pub child: Option<usize>,
    /// Unit axes in the joint's frame.
    pub axes: Vec<nalgebra::Vector3<f64>>,
    /// Sensors with their poses in the outer model.
    pub sensors: Vec<(Pose, &'a Sensor)>,
}

/// Poses of the models of a world.
///
/// # Errors
/// An unknown name, or frames that are defined by each other.
pub fn world_frames(models: &[Model], frames: &[Frame]) -> Result<Vec<Pose>, SdfError> {
    let mut scope = Scope::new("world");
    for frame in frames {
        scope.frame(frame, "world");
    }
    let resolved = models.iter().map(resolve).collect::<Result<Vec<_>, _>>()?;
    for (model, inner) in models.iter().zip(&resolved) {
        scope.model(model, inner)?;
    }
    models.iter().map(|model| scope.pose_of(&model.name, &model.at)).collect()
}

/// A frame that is not resolved yet.
struct Raw<'a> {
    pose: Pose,
    relative_to: String,
    at: &'a At,
}

/// The names of a model or world.
struct Scope<'a, 'r> {
    root: &'static str,
    raw: HashMap<String, Raw<'a>>,
    nested: HashMap<String, &'r Resolved<'a>>,
}

impl<'a, 'r> Scope<'a, 'r> {
    fn new(root: &'static str) -> Self {
        Scope { root, raw: HashMap::new(), nested: HashMap::new() }
    }

    fn add(&mut self, name: &str, written: &'a WrittenPose, default: &str) {
        let relative_to = written.relative_to.clone().unwrap_or_else(|| default.to_owned());
        self.raw.insert(name.to_owned(), Raw { pose: written.pose, relative_to, at: &written.at });
    }

    fn frame(&mut self, frame: &'a Frame, root: &str) {
        self.add(&frame.name, &frame.pose, frame.attached_to.as_deref().unwrap_or(root));
    }

    fn model(&mut self, model: &'a Model, inner: &'r Resolved<'a>) -> Result<(), SdfError> {
        self.add(&model.name, &model.pose, self.root);
        if let Some(placement) = &model.placement_frame {
            let Some((pose, _)) = inner.names.get(placement) else {
                let error = SdfError::new(model.at.clone(), format!("model `{}`: unknown placement frame", model.name));
                return Err(suggest(error.found(format!("`{placement}`")), placement, inner.names.keys()));
            };
            let raw = self.raw.get_mut(&model.name).map(|raw| &mut raw.pose);
            raw.into_iter().for_each(|own| *own = own.then(&pose.inverse()));
        }
        self.nested.insert(model.name.clone(), inner);
        Ok(())
    }

    /// Pose of a name in the scope's own frame. `at` is the position of the name.
    fn pose_of(&self, name: &str, at: &At) -> Result<Pose, SdfError> {
        let (mut name, mut at) = (name.to_owned(), at);
        let (mut pose, mut visited) = (Pose::IDENTITY, HashSet::new());
        while name != self.root && !(name.is_empty()) {
            let (own, inner) = name.split_once("::").map_or((name.as_str(), None), |(m, n)| (m, Some(n)));
            if let Some(inner) = inner {
                let known = self.nested.get(own).and_then(|nested| nested.names.get(inner));
                let Some((nested, _)) = known else { return Err(self.unknown(&name, at)) };
                pose = nested.then(&pose);
            }
            let Some(raw) = self.raw.get(own) else { return Err(self.unknown(&name, at)) };
            if !visited.insert(own.to_owned()) {
                let message = format!("the pose of `{own}` is relative to itself");
                return Err(SdfError::new(raw.at.clone(), message).expected("frames that lead to the model's own"));
            }
            if visited.len() > LONGEST_CHAIN {
                return Err(too_long(own, raw.at));
            }
            pose = raw.pose.then(&pose);
            (name, at) = (raw.relative_to.clone(), raw.at);
        }
        Ok(pose)
    }

    fn unknown(&self, name: &str, at: &At) -> SdfError {
        let error = SdfError::new(at.clone(), format!("there is no frame `{name}`"));
        suggest(error.expected("the name of a link, joint, frame or model"), name, self.raw.keys())
    }
}

/// Most frames between a frame and the model's own: as many as a chain of joints may have. Every frame is resolved
/// along its chain.
const LONGEST_CHAIN: usize = 1024;

fn too_long(name: &str, at: &At) -> SdfError {
    let error = SdfError::new(at.clone(), format!("`{name}` is placed through too many other frames"));
    error.expected(format!("at most {LONGEST_CHAIN}"))
}

fn suggest<'n>(error: SdfError, name: &str, known: impl Iterator<Item = &'n String>) -> SdfError {
    let mut known: Vec<&str> = known.map(String::as_str).collect();
    known.sort_unstable();
    match nearest(name, known) {
        Some(near) => error.help(format!("did you mean `{near}`?")),
        None => error,
    }
}

/// Resolves a model with its nested ones.
///
/// # Errors
/// An unknown name, or frames that are defined by each other.
pub fn resolve(model: &Model) -> Result<Resolved<'_>, SdfError> {
    let inner = model.models.iter().map(resolve).collect::<Result<Vec<_>, _>>()?;
    let mut scope = Scope::new(OWN);
    for link in &model.links {
        scope.add(&link.name, &link.pose, OWN);
    }
    for joint in &model.joints {
        scope.add(&joint.name, &joint.pose, &joint.child.0);
    }
    for frame in &model.frames {
        scope.frame(frame, OWN);
    }
    for (nested, inner) in model.models.iter().zip(&inner) {
        scope.model(nested, inner)?;
    }
    let mut names: HashMap<String, (Pose, Option<usize>)> = HashMap::new();
    let mut links = Vec::new();
    for link in &model.links {
        let pose = scope.pose_of(&link.name, &link.at)?;
        names.insert(link.name.clone(), (pose, Some(links.len())));
        links.push(resolve_link(link, pose, &scope)?);
    }
    let (nested_links, nested_joints) = place_nested(model, inner_poses(model, &scope)?, &inner, links.len());
    let offsets = nested_links.1;
    links.extend(nested_links.0);
    for ((nested, inner), (pose, offset)) in model.models.iter().zip(&inner).zip(offsets) {
        for (name, (own, link)) in &inner.names {
            let body = link.map(|link| link + offset);
            names.insert(format!("{}::{name}", nested.name), (pose.then(own), body));
        }
        names.insert(nested.name.clone(), (pose, inner.canonical.map(|link| link + offset)));
    }
    let canonical = match &model.canonical_link {
        Some(name) => {
            let known = names.get(name).and_then(|(_, link)| *link);
            let error = || SdfError::new(model.at.clone(), format!("model `{}`: unknown canonical link", model.name));
            Some(known.ok_or_else(|| suggest(error().found(format!("`{name}`")), name, names.keys()))?)
        }
        None => (!links.is_empty()).then_some(0),
    };
    names.insert(OWN.into(), (Pose::IDENTITY, canonical));
    add_frames(model, &scope, &mut names)?;
    let mut joints = Vec::new();
    for joint in &model.joints {
        joints.push(resolve_joint(joint, &scope, &names)?);
    }
    joints.extend(nested_joints);
    Ok(Resolved { links, joints, canonical, names })
}

fn inner_poses(model: &Model, scope: &Scope) -> Result<Vec<Pose>, SdfError> {
    model.models.iter().map(|nested| scope.pose_of(&nested.name, &nested.at)).collect()
}

type Placed<'a> = ((Vec<ResolvedLink<'a>>, Vec<(Pose, usize)>), Vec<ResolvedJoint<'a>>);

/// Links and joints of nested models in the outer one, with pose and first link of each model.
fn place_nested<'a>(model: &'a Model, poses: Vec<Pose>, inner: &[Resolved<'a>], first: usize) -> Placed<'a> {
    let (mut links, mut joints, mut offsets) = (Vec::new(), Vec::new(), Vec::new());
    for ((nested, inner), pose) in model.models.iter().zip(inner).zip(poses) {
        let offset = first + links.len();
        let name = |inner: &str| format!("{}::{inner}", nested.name);
        links.extend(inner.links.iter().map(|l| ResolvedLink {
            name: name(&l.name),
            link: l.link,
            pose: pose.then(&l.pose),
            inertial: l.inertial,
            visuals: l.visuals.clone(),
            collisions: l.collisions.clone(),
            sensors: l.sensors.clone(),
        }));
        joints.extend(inner.joints.iter().map(|j| ResolvedJoint {
            name: name(&j.name),
            joint: j.joint,
            prefix: name(&j.prefix),
            pose: pose.then(&j.pose),
            parent: j.parent.map(|link| link + offset),
            child: j.child.map(|link| link + offset),
            axes: j.axes.clone(),
            sensors: j.sensors.iter().map(|(own, sensor)| (pose.then(own), *sensor)).collect(),
        }));
        offsets.push((pose, offset));
    }
    ((links, offsets), joints)
}

/// Adds joints and frames with the links that they are attached to.
fn add_frames(
    model: &Model,
    scope: &Scope,
    names: &mut HashMap<String, (Pose, Option<usize>)>,
) -> Result<(), SdfError> {
    let joints = model.joints.iter().map(|j| (&j.name, &j.at, j.child.0.as_str(), &j.child.1));
    let frames = model.frames.iter().map(|f| (&f.name, &f.at, f.attached_to.as_deref().unwrap_or(OWN), &f.at));
    let all: Vec<_> = joints.chain(frames).collect();
    let to: HashMap<&str, (&str, &At)> = all.iter().map(|(name, _, to, at)| (name.as_str(), (*to, *at))).collect();
    let mut found = Vec::new();
    for (name, at, ..) in &all {
        let (mut next, mut visited) = (name.as_str(), HashSet::new());
        while let Some((to, _)) = to.get(next) {
            if !visited.insert(next) {
                let error = SdfError::new((*at).clone(), format!("`{name}` is attached to itself"));
                return Err(error.expected("frames that lead to a link"));
            }
            if visited.len() > LONGEST_CHAIN {
                return Err(too_long(name, at));
            }
            next = to;
        }
        // The name of a joint's child, and of the world, is checked with the joint.
        let link = names.get(next).and_then(|(_, link)| *link);
        found.push(((*name).clone(), (scope.pose_of(name, at)?, link)));
    }
    names.extend(found);
    Ok(())
}

fn resolve_link<'a>(link: &'a Link, pose: Pose, scope: &Scope) -> Result<ResolvedLink<'a>, SdfError> {
    let inside = |written: &WrittenPose| -> Result<Pose, SdfError> {
        match written.relative_to.as_deref() {
            None => Ok(written.pose),
            Some(name) if name == link.name => Ok(written.pose),
            Some(name) => Ok(pose.inverse().then(&scope.pose_of(name, &written.at)?).then(&written.pose)),
        }
    };
    let shapes = |list: &'a [Shape]| -> Result<Vec<(Pose, &'a Shape)>, SdfError> {
        list.iter().map(|shape| Ok((inside(&shape.pose)?, shape))).collect()
    };
    Ok(ResolvedLink {
        name: link.name.clone(),
        link,
        pose,
        inertial: match &link.inertial {
            Some(inertial) => Some((inside(&inertial.pose)?, inertial)),
            None => None,
        },
        visuals: shapes(&link.visuals)?,
        collisions: shapes(&link.collisions)?,
        sensors: link.sensors.iter().map(|s| Ok((inside(&s.pose)?, s))).collect::<Result<_, SdfError>>()?,
    })
}

fn resolve_joint<'a>(
    joint: &'a Joint,
    scope: &Scope,
    names: &HashMap<String, (Pose, Option<usize>)>,
) -> Result<ResolvedJoint<'a>, SdfError> {
    let pose = scope.pose_of(&joint.name, &joint.at)?;
    let link = |(name, at): &(String, At), end: &str| -> Result<Option<usize>, SdfError> {
        if name == "world" {
            return Ok(None);
        }
        let known = names.get(name).and_then(|(_, link)| *link);
        known.map(Some).ok_or_else(|| {
            let message = format!("joint `{}` names an unknown {end}", joint.name);
            let error = SdfError::new(at.clone(), message).element(format!("joint `{}`", joint.name));
            suggest(error.found(format!("`{name}`")).expected("the name of a link or frame"), name, names.keys())
        })
    };
    let mut axes = Vec::new();
    for axis in &joint.axes {
        let turned = match &axis.expressed_in {
            Some(frame) if *frame != joint.name => {
                pose.isometry.rotation.inverse() * (scope.pose_of(frame, &axis.at)?.isometry.rotation * axis.xyz)
            }
            _ => axis.xyz,
        };
        axes.push(turned / turned.norm());
    }
    let inside = |sensor: &'a Sensor| -> Result<(Pose, &'a Sensor), SdfError> {
        let base = match sensor.pose.relative_to.as_deref() {
            Some(name) => scope.pose_of(name, &sensor.pose.at)?,
            None => pose,
        };
        Ok((base.then(&sensor.pose.pose), sensor))
    };
    Ok(ResolvedJoint {
        name: joint.name.clone(),
        joint,
        prefix: String::new(),
        pose,
        parent: link(&joint.parent, "parent")?,
        child: link(&joint.child, "child")?,
        axes,
        sensors: joint.sensors.iter().map(inside).collect::<Result<_, _>>()?,
    })
}
