//! Resolves the names of links and joints and checks that they form one tree.

use std::collections::HashMap;

use super::xml::{Xml, child};
use crate::robot::robot_error::RobotError;

/// Links and joints by index into the URDF's lists.
pub(super) struct Tree<'a> {
    pub robot: &'a urdf_rs::Robot,
    /// For each link the joints of which it is the parent, in file order.
    pub joints_of: Vec<Vec<usize>>,
    /// For each joint its child link.
    pub child_of: Vec<usize>,
    /// The link that no joint moves.
    pub root: usize,
}

impl<'a> Tree<'a> {
    /// Errors: duplicate names, joints that name unknown links, a link under two joints, several
    /// roots, loops.
    pub fn new(robot: &'a urdf_rs::Robot, xml: &Xml) -> Result<Self, RobotError> {
        unique_names(xml, "link")?;
        unique_names(xml, "joint")?;
        if robot.links.is_empty() {
            return Err(xml.fault(xml.robot, "the robot has no links").expected("at least one <link>").invalid());
        }
        let index: HashMap<&str, usize> = robot.links.iter().enumerate().map(|(i, l)| (l.name.as_str(), i)).collect();
        let mut joints_of = vec![Vec::new(); robot.links.len()];
        let mut child_of = Vec::with_capacity(robot.joints.len());
        let mut above: Vec<Option<usize>> = vec![None; robot.links.len()];
        for (j, joint) in robot.joints.iter().enumerate() {
            let resolve = |end: &str, name: &str| {
                index.get(name).copied().ok_or_else(|| {
                    let node = xml.named("joint", &joint.name);
                    let message = format!("joint `{}` names an unknown {end} link", joint.name);
                    let fault = xml.attribute_fault(child(node, end).unwrap_or(node), "link", message);
                    fault
                        .expected("the name of a <link>")
                        .suggest(name, robot.links.iter().map(|l| l.name.as_str()))
                        .invalid()
                })
            };
            let parent = resolve("parent", &joint.parent.link)?;
            let child = resolve("child", &joint.child.link)?;
            if let Some(other) = above[child] {
                let (link, other) = (&joint.child.link, &robot.joints[other].name);
                let message = format!("link `{link}` is the child of both joint `{other}` and joint `{}`", joint.name);
                let fault = xml.fault(xml.named("joint", &joint.name), message);
                return Err(fault.expected("a tree: closed loops are not supported").invalid());
            }
            above[child] = Some(j);
            joints_of[parent].push(j);
            child_of.push(child);
        }
        let root = single_root(robot, xml, &above)?;
        let tree = Self { robot, joints_of, child_of, root };
        tree.check_connected(xml, &above)?;
        Ok(tree)
    }

    /// Refuses loops: a link without a path to the root is in, or below, a loop of joints.
    fn check_connected(&self, xml: &Xml, above: &[Option<usize>]) -> Result<(), RobotError> {
        let mut reached = vec![false; above.len()];
        let mut stack = vec![self.root];
        while let Some(link) = stack.pop() {
            reached[link] = true;
            stack.extend(self.joints_of[link].iter().map(|&j| self.child_of[j]));
        }
        let Some(unreached) = reached.iter().position(|r| !r) else { return Ok(()) };
        // After as many steps to the parent as there are links the walk is inside the loop.
        let parent = |link: usize| above[link].map_or(link, |j| self.parent_of(j));
        let start = (0..above.len()).fold(unreached, |link, _| parent(link));
        let mut names = vec![self.robot.links[start].name.as_str()];
        let mut link = parent(start);
        while link != start {
            names.push(&self.robot.links[link].name);
            link = parent(link);
        }
        names.reverse();
        let message = format!("the joints form a loop through the links {}", quoted_list(&names));
        Err(xml.fault(xml.named("link", names[0]), message).expected("a tree with one root").invalid())
    }

    fn parent_of(&self, joint: usize) -> usize {
        self.joints_of.iter().position(|joints| joints.contains(&joint)).unwrap_or(self.root)
    }
}

fn unique_names(xml: &Xml, tag: &str) -> Result<(), RobotError> {
    let mut lines: HashMap<&str, usize> = HashMap::new();
    for node in xml.robot.children().filter(|n| n.has_tag_name(tag)) {
        let name = node.attribute("name").unwrap_or_default();
        let line = xml.source.line(node.range().start);
        if let Some(first) = lines.insert(name, line) {
            let fault = xml.attribute_fault(node, "name", format!("there are two {tag}s named `{name}`"));
            return Err(fault.expected("a unique name").help(format!("the other is on line {first}")).invalid());
        }
    }
    Ok(())
}

fn single_root(robot: &urdf_rs::Robot, xml: &Xml, above: &[Option<usize>]) -> Result<usize, RobotError> {
    let roots: Vec<usize> = (0..above.len()).filter(|&l| above[l].is_none()).collect();
    match roots[..] {
        [root] => Ok(root),
        [] => {
            let names: Vec<&str> = robot.links.iter().map(|l| l.name.as_str()).collect();
            let message =
                format!("every link is moved by a joint: the joints form a loop through {}", quoted_list(&names));
            Err(xml.fault(xml.named("link", names[0]), message).expected("a tree with one root").invalid())
        }
        [_, second, ..] => {
            let names: Vec<&str> = roots.iter().map(|&r| robot.links[r].name.as_str()).collect();
            let message = format!("there are {} root links: {}", names.len(), quoted_list(&names));
            let node = xml.named("link", &robot.links[second].name);
            Err(xml.fault(node, message).expected("one root, every other link the child of a joint").invalid())
        }
    }
}

fn quoted_list(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().take(8).map(|n| format!("`{n}`")).collect();
    let rest = if names.len() > 8 { format!(" and {} more", names.len() - 8) } else { String::new() };
    quoted.join(", ") + &rest
}
