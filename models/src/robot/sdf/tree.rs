//! Builds the model: fixed joints are welded, and each joint axis becomes z.

use std::collections::HashMap;

use nalgebra::{Isometry3, Vector3};

use super::convert;
use super::inertia::{check_movable, link_inertia};
use super::joints::motions;
use super::shapes::Shapes;
use super::spanning_tree::SpanningTree;
use crate::robot::closure::{LoopClosure, LoopKind};
use crate::robot::model::{Base, Joint, Link, LinkId, Merged, Model, Mount, SensorFrame, SensorFrames};
use crate::robot::moving_links::{MAX_JOINTS, bare_link, z_to};
use crate::robot::notices::Notices;
use crate::robot::robot_error::RobotError;
use crate::robot::urdf::{InertiaPolicy, Loaded, Mimic};
use crate::sdf::{At, Model as Written, Resolved, ResolvedJoint, SdfError, resolve};

/// The tree under construction.
#[derive(Default)]
struct Builder {
    links: Vec<Link>,
    joints: Vec<Joint>,
    /// For each link the element that it comes from.
    positions: Vec<At>,
    /// For each link of the file its carrier and its pose there.
    carriers: Vec<Option<(usize, Isometry3<f64>)>>,
    /// For each joint of the file its motions.
    motions: HashMap<usize, Vec<usize>>,
    sensors: SensorFrames,
    /// How the root is held.
    base: Option<Base>,
    policy: InertiaPolicy,
    shapes: Shapes,
}

/// Builds the model of a written one.
pub(super) fn build(
    written: &Written,
    requested: Option<Base>,
    policy: InertiaPolicy,
    notices: &mut Notices,
) -> Result<Loaded, RobotError> {
    let resolved = resolve(written).map_err(convert)?;
    if resolved.links.is_empty() {
        let error = SdfError::new(written.at.clone(), format!("model `{}` has no links", written.name));
        return Err(convert(error.expected("at least one <link>")));
    }
    let tree = SpanningTree::new(&resolved)?;
    let (root, base) = choose_root(written, &resolved, &tree, requested)?;
    let carriers = vec![None; resolved.links.len()];
    let mut builder = Builder { carriers, base: Some(base), policy, ..Builder::default() };
    builder.walk(written, &resolved, &tree, root, notices)?;
    let Builder { links, joints, positions, .. } = &builder;
    if let Some(at) = positions.get(MAX_JOINTS + 1) {
        let error = SdfError::new(at.clone(), "the robot has too many moving joints").found(joints.len());
        return Err(convert(error.expected(format!("at most {MAX_JOINTS}"))));
    }
    check_movable(links, joints, base, positions)?;
    let loops = builder.loops(&resolved, &tree, notices)?;
    let mimics = mimics(&resolved, &builder, notices);
    // The loader makes couplings of the mimics.
    let Builder { links, joints, sensors, shapes, .. } = builder;
    let model = Model { sensors, loops, ..Model::tree(written.name.clone(), base, links, joints) };
    Ok(Loaded { model, meshes: shapes.meshes.files, mimics })
}

/// The root link, or none for the world, and how it is held. A model with a joint of the world, or
/// a static one, is fixed.
fn choose_root(
    written: &Written,
    resolved: &Resolved,
    tree: &SpanningTree,
    requested: Option<Base>,
) -> Result<(Option<usize>, Base), RobotError> {
    let at_world = tree.joints_of.last().map_or(&[][..], Vec::as_slice);
    let error =
        |at: &At, message: String| SdfError::new(at.clone(), message).element(format!("model `{}`", written.name));
    if let (Some(Base::Floating), [first, ..]) = (requested, at_world) {
        let single = at_world.len() == 1 && resolved.joints[*first].joint.kind == "fixed" && tree.roots.is_empty();
        if let (true, Some(child)) = (single, resolved.joints[*first].child) {
            return Ok((Some(child), Base::Floating));
        }
        let at = &resolved.joints[*first].joint.at;
        let error = error(at, "base = \"floating\" does not fit a joint of the world that moves".into());
        return Err(convert(error.expected("one fixed joint of the world")));
    }
    let is_fixed = written.is_static || requested == Some(Base::Fixed);
    match tree.roots[..] {
        [root] if at_world.is_empty() => {
            let base = if is_fixed && requested != Some(Base::Floating) { Base::Fixed } else { Base::Floating };
            Ok((Some(root), base))
        }
        [] => Ok((None, Base::Fixed)),
        // Roots of a static model are fixed to the world.
        _ if written.is_static => Ok((None, Base::Fixed)),
        [first, ..] => {
            let root = tree.roots.get(usize::from(at_world.is_empty())).unwrap_or(&first);
            let link = &resolved.links[*root];
            let error = error(&link.link.at, format!("link `{}` is the child of no joint", link.name));
            Err(convert(error.expected("one root, every other link the child of a joint")))
        }
    }
}

impl Builder {
    /// Adds all links, depth first, siblings in the order of their joints in the file.
    fn walk(
        &mut self,
        written: &Written,
        resolved: &Resolved,
        tree: &SpanningTree,
        root: Option<usize>,
        notices: &mut Notices,
    ) -> Result<(), RobotError> {
        let world = resolved.links.len();
        // Joints still to be followed, with the carrier of their parent and its pose there.
        let mut stack: Vec<(usize, usize, Isometry3<f64>)> = Vec::new();
        let mut first: Vec<(usize, Isometry3<f64>)> = Vec::new();
        let follow = |stack: &mut Vec<_>, link: usize, carrier: usize, frame: Isometry3<f64>| {
            // Reversed, since the stack returns the last one first.
            stack.extend(tree.joints_of[link].iter().rev().map(|&j| (j, carrier, frame)));
        };
        let (name, at) = match root {
            Some(root) => (resolved.links[root].name.as_str(), resolved.links[root].link.at.clone()),
            None => ("world", written.at.clone()),
        };
        self.links.push(bare_link(name, None));
        self.positions.push(at);
        match root {
            Some(root) => first.push((root, Isometry3::identity())),
            // The world's frame is that of the model.
            None => first.extend(tree.roots.iter().map(|&link| (link, resolved.links[link].pose.isometry))),
        }
        for (link, frame) in first {
            self.add(resolved, link, (0, frame), notices)?;
            follow(&mut stack, link, 0, frame);
        }
        if root.is_none() {
            follow(&mut stack, world, 0, Isometry3::identity());
        }
        while let Some((j, mut carrier, parent_frame)) = stack.pop() {
            let joint = &resolved.joints[j];
            let Some(child) = joint.child else { continue };
            let from_parent = joint.parent.map_or(Isometry3::identity(), |p| resolved.links[p].pose.isometry);
            // The joint's frame in the carrier, then after its motions in the moved link.
            let mut frame = parent_frame * from_parent.inv_mul(&joint.pose.isometry);
            let motions = motions(joint, notices)?;
            let last = motions.len();
            for (k, (motion, axis)) in motions.into_iter().enumerate() {
                let turn = z_to(&axis);
                let at_zero = frame * turn;
                let name = if k + 1 == last { &resolved.links[child].name } else { &motion.name };
                let mut link = bare_link(name, Some(LinkId(carrier)));
                link.rotation = at_zero.rotation.to_rotation_matrix().into_inner();
                link.offset = at_zero.translation.vector;
                frame = Isometry3::from_parts(Vector3::zeros().into(), turn.inverse());
                link.urdf_frame = frame;
                carrier = self.links.len();
                self.motions.entry(j).or_default().push(self.joints.len());
                self.links.push(link);
                self.joints.push(motion);
                self.positions.push(resolved.links[child].link.at.clone());
            }
            let child_frame = frame * joint.pose.isometry.inv_mul(&resolved.links[child].pose.isometry);
            if last > 0 {
                self.links[carrier].urdf_frame = child_frame;
            }
            self.add(resolved, child, (carrier, child_frame), notices)?;
            self.sensors(joint, carrier, &child_frame, &resolved.links[child].pose.isometry);
            follow(&mut stack, child, carrier, child_frame);
        }
        Ok(())
    }

    /// Adds a link of the file to its carrier.
    fn add(
        &mut self,
        resolved: &Resolved,
        index: usize,
        (carrier, frame): (usize, Isometry3<f64>),
        notices: &mut Notices,
    ) -> Result<(), RobotError> {
        let written = &resolved.links[index];
        self.carriers[index] = Some((carrier, frame));
        let is_fixed = carrier == 0 && self.base == Some(Base::Fixed);
        let own = link_inertia(written, is_fixed, self.policy, notices)?;
        let link = &mut self.links[carrier];
        if link.name != written.name {
            link.merged.push(Merged { name: written.name.clone(), pose: frame });
        }
        link.set_body(&link.body().plus(&own.transformed(&frame)));
        link.visuals.extend(self.shapes.convert((&written.name, "visual"), &written.visuals, &frame, notices));
        link.collisions.extend(self.shapes.convert((&written.name, "collision"), &written.collisions, &frame, notices));
        for (pose, sensor) in &written.sensors {
            let mount = Mount { link: LinkId(carrier), pose: frame * pose.isometry };
            self.sensor(&written.name, &sensor.name, &sensor.kind, mount);
        }
        Ok(())
    }

    /// Force sensors of a joint, which are carried by its child.
    fn sensors(&mut self, joint: &ResolvedJoint, carrier: usize, child: &Isometry3<f64>, in_model: &Isometry3<f64>) {
        for (pose, sensor) in &joint.sensors {
            let mount = Mount { link: LinkId(carrier), pose: child * in_model.inv_mul(&pose.isometry) };
            self.sensor(&joint.name, &sensor.name, &sensor.kind, mount);
        }
    }

    /// Adds a sensor; one whose name another has is called `OWNER/NAME`.
    fn sensor(&mut self, owner: &str, name: &str, kind: &str, mount: Mount) {
        let list = if kind == "imu" { &mut self.sensors.imu } else { &mut self.sensors.force };
        let is_known = list.iter().any(|other| other.name == name);
        let name = if is_known { format!("{owner}/{name}") } else { name.to_owned() };
        list.push(SensorFrame { name, mount });
    }

    /// Loops that joints close, at the positions of the file.
    fn loops(
        &self,
        resolved: &Resolved,
        tree: &SpanningTree,
        notices: &mut Notices,
    ) -> Result<Vec<LoopClosure>, RobotError> {
        let mut loops = Vec::new();
        for &j in &tree.closing {
            let joint = &resolved.joints[j];
            let kind = match joint.joint.kind.as_str() {
                "ball" => LoopKind::Ball,
                "revolute" | "continuous" => LoopKind::Pin,
                "fixed" => LoopKind::Weld,
                other => {
                    let message = format!("joint `{}` closes a loop, which {other} joints cannot", joint.name);
                    let error = SdfError::new(joint.joint.at.clone(), message);
                    let error = error.element(format!("joint `{}`", joint.name));
                    return Err(convert(error.expected("ball, revolute or fixed").not_available()));
                }
            };
            if joint.joint.axes.iter().any(|a| a.lower.is_some() || a.upper.is_some() || a.damping + a.friction > 0.0) {
                let message =
                    format!("limits and friction of joint `{}`, which closes a loop, are ignored", joint.name);
                notices.warning(&joint.joint.at.source, joint.joint.at.span.start, message);
            }
            let turn = joint.axes.first().map_or(nalgebra::UnitQuaternion::identity(), z_to);
            let frame = joint.pose.isometry * turn;
            let on = |link: usize| {
                let (carrier, pose) = self.carriers[link]?;
                Some((LinkId(carrier), pose * resolved.links[link].pose.isometry.inv_mul(&frame)))
            };
            // All links are carried, since the tree reaches them.
            let Some((link, pose)) = joint.child.and_then(on) else { continue };
            let (other, other_pose) = match joint.parent.and_then(on) {
                Some((other, pose)) => (Some(other), pose),
                None => (None, frame),
            };
            loops.push(LoopClosure { name: joint.name.clone(), kind, link, pose, other, other_pose });
        }
        Ok(loops)
    }
}

/// The joints that follow others; those whose leader does not exist are reported.
fn mimics(resolved: &Resolved, builder: &Builder, notices: &mut Notices) -> Vec<Mimic> {
    let motion = |j: usize, k: usize| Some(builder.joints[*builder.motions.get(&j)?.get(k)?].name.clone());
    let mut mimics = Vec::new();
    for (j, joint) in resolved.joints.iter().enumerate() {
        for (k, axis) in joint.joint.axes.iter().enumerate() {
            let Some(mimic) = &axis.mimic else { continue };
            let leader = format!("{}{}", joint.prefix, mimic.joint);
            let index = resolved.joints.iter().position(|other| other.name == leader);
            let of = index.and_then(|index| motion(index, usize::from(mimic.axis == "axis2")));
            let (source, at) = (&mimic.at.source, mimic.at.span.start);
            let (Some(name), Some(of)) = (motion(j, k), of) else {
                let message = format!("joint `{}` mimics `{leader}`, which is no moving joint: ignored", joint.name);
                notices.warning(source, at, message);
                continue;
            };
            if name == of {
                notices.warning(source, at, format!("joint `{name}` mimics itself: ignored"));
                continue;
            }
            let message = format!("joint `{name}` mimics joint `{of}`");
            notices.info(source, at, message);
            let offset = mimic.offset - mimic.multiplier * mimic.reference;
            mimics.push(Mimic { joint: name, of, multiplier: mimic.multiplier, offset, at });
        }
    }
    mimics
}
