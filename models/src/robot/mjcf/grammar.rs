//! Elements and attributes that MJCF has: those that are read, those without effect here, and
//! those that are ignored with a notice. Others are errors of spelling, or of a later version.

use super::classes::ACTUATORS;
use super::document::{ATTACHED_DEFAULT, Document, Id, ROOT};
use super::ignored::{Ignored, Role};
use crate::robot::robot_error::RobotError;
use crate::text::suggest::nearest;

/// An element: section, tag, and attributes by treatment, separated by spaces.
struct Rule {
    section: &'static str,
    tag: &'static str,
    read: &'static str,
    /// Appearance, names of groups, and numbers of MuJoCo's contact solver.
    silent: &'static str,
    ignored: &'static str,
}

const RULES: &[Rule] = &[
    Rule {
        section: "compiler",
        tag: "compiler",
        read: "angle assetdir autolimits balanceinertia boundinertia boundmass coordinate eulerseq exactmeshinertia \
               fitaabb inertiafromgeom inertiagrouprange meshdir settotalmass strippath",
        silent: "conflict convexhull discardvisual fusestatic passthrough savecanonical savecompiled saveinertial \
                 texturedir usethread",
        ignored: "alignfree",
    },
    Rule {
        section: "worldbody",
        tag: "body",
        read: "axisangle childclass euler mocap name pos quat xyaxes zaxis",
        silent: "fuse simple sleep user",
        ignored: "gravcomp",
    },
    Rule {
        section: "worldbody",
        tag: "frame",
        read: "axisangle childclass euler name pos quat xyaxes zaxis",
        silent: "",
        ignored: "",
    },
    Rule {
        section: "worldbody",
        tag: "inertial",
        read: "axisangle diaginertia euler fullinertia mass pos quat xyaxes zaxis",
        silent: "",
        ignored: "",
    },
    Rule {
        section: "worldbody",
        tag: "joint",
        read: "actuatorfrclimited actuatorfrcrange armature axis class damping frictionloss limited name pos range ref \
               stiffness type",
        silent: "group margin solimpfriction solimplimit solreffriction solreflimit springref springyield user",
        ignored: "actuatorgravcomp springdamper",
    },
    Rule { section: "worldbody", tag: "freejoint", read: "name", silent: "group user", ignored: "align" },
    Rule {
        section: "worldbody",
        tag: "geom",
        read: "axisangle class conaffinity contype density euler fitscale fromto group hfield mass material mesh name \
               pos quat rgba shellinertia size type xyaxes zaxis",
        silent: "castshadow condim gap margin priority solimp solmix solref user",
        ignored: "adhesion fluidcoef fluidshape friction surfacevel",
    },
    Rule {
        section: "worldbody",
        tag: "site",
        read: "axisangle class euler fromto name pos quat xyaxes zaxis",
        silent: "group material mesh rgba size type user",
        ignored: "",
    },
    Rule {
        section: "asset",
        tag: "mesh",
        read: "builtin class face file inertia name refpos refquat scale vertex",
        silent: "content_type material maxhullvert normal params smoothnormal texcoord",
        ignored: "",
    },
    Rule {
        section: "asset",
        tag: "hfield",
        read: "elevation file name ncol nrow size",
        silent: "content_type",
        ignored: "",
    },
    Rule {
        section: "asset",
        tag: "material",
        read: "class name rgba",
        silent: "emission metallic reflectance roughness shininess specular texrepeat texture texuniform",
        ignored: "",
    },
    Rule {
        section: "equality",
        tag: "equality",
        read: "active anchor body1 body2 class joint1 joint2 name polycoef relpose site1 site2",
        silent: "cell flex solimp solref tendon1 tendon2 torquescale",
        ignored: "",
    },
    Rule {
        section: "actuator",
        tag: "actuator",
        read: "biasprm biastype body class cranksite ctrllimited ctrlrange dampratio dynprm dyntype forcelimited \
               forcerange gainprm gaintype gear inheritrange joint jointinparent kp kv name refsite site slidersite \
               tendon timeconst",
        silent: "actdim actearly actlimited actrange area bias cogging controller cranklength diameter ffrange force \
                 fpmax fvmax gain group imax inductance input instance ki lengthrange lmax lmin lugre motorconst \
                 nominal plugin posrange range resistance saturation scale slewmax tausmooth thermal user velrange \
                 vmax",
        ignored: "armature damping delay interp nsample",
    },
    Rule { section: "contact", tag: "exclude", read: "body1 body2 name", silent: "", ignored: "" },
    Rule {
        section: "keyframe",
        tag: "key",
        read: "name qpos",
        silent: "act ctrl mpos mquat plastic qvel time",
        ignored: "",
    },
];

/// Sections that are read, and those that are ignored with a reason.
const SECTIONS: [&str; 10] =
    ["compiler", "default", "asset", "worldbody", "actuator", "sensor", "equality", "keyframe", "contact", "include"];
const IGNORED_SECTIONS: [(&str, &str); 9] = [
    ("option", "the scenario sets gravity, integrator and contact"),
    ("size", ""),
    ("statistic", ""),
    ("visual", ""),
    ("custom", ""),
    ("extension", "plugins are not available"),
    ("tendon", "tendons are not available"),
    ("deformable", "deformable bodies are not available"),
    ("skin", ""),
];

/// Elements of bodies, and those that are ignored.
const OF_BODIES: [&str; 13] = [
    "body",
    "frame",
    "inertial",
    "joint",
    "freejoint",
    "geom",
    "site",
    "camera",
    "light",
    "replicate",
    "attach",
    "composite",
    "flexcomp",
];

/// Checks the whole document.
///
/// # Errors
/// Unknown elements and attributes whose name is near that of a known one; others are warnings.
pub(super) fn check(document: &Document, ignored: &mut Ignored) -> Result<(), RobotError> {
    attributes(document, ROOT, &["model"], ignored)?;
    for &section in document.children(ROOT) {
        let tag = document.tag(section);
        if tag == "option" && ignored.role != Role::Robot {
            let of_world = if ignored.role == Role::Part { ", which counts for a `[world]`" } else { "" };
            ignored.note(section, format!("<option> is ignored, except for gravity{of_world}"));
            continue;
        }
        if let Some((_, reason)) = IGNORED_SECTIONS.iter().find(|(name, _)| *name == tag) {
            let reason = if reason.is_empty() { String::new() } else { format!(": {reason}") };
            ignored.note(section, format!("<{tag}> is ignored{reason}"));
            continue;
        }
        let known = SECTIONS.into_iter().chain(IGNORED_SECTIONS.into_iter().map(|(name, _)| name));
        match tag {
            "compiler" => by_rule(document, section, "compiler", "compiler", ignored)?,
            "worldbody" => descend(document, section, ignored)?,
            "default" | ATTACHED_DEFAULT => defaults(document, section, ignored)?,
            "asset" | "actuator" | "equality" | "contact" | "keyframe" => {
                for &child in document.children(section) {
                    by_rule(document, child, tag, document.tag(child), ignored)?;
                    if let ("asset", kind @ ("texture" | "skin")) = (tag, document.tag(child)) {
                        ignored.note(child, format!("<{kind}> is ignored"));
                    }
                }
            }
            "sensor" => {}
            _ => unknown(document, section, "mujoco", known, ignored)?,
        }
    }
    Ok(())
}

/// Elements below a body.
fn descend(document: &Document, top: Id, ignored: &mut Ignored) -> Result<(), RobotError> {
    let mut stack = vec![top];
    while let Some(id) = stack.pop() {
        for &child in document.children(id) {
            match document.tag(child) {
                tag @ ("camera" | "light") => ignored.note(child, format!("<{tag}> is ignored")),
                // Ignored where bodies are read.
                "composite" | "flexcomp" | "plugin" => {}
                tag @ ("body" | "frame") => {
                    by_rule(document, child, "worldbody", tag, ignored)?;
                    stack.push(child);
                }
                tag if OF_BODIES.contains(&tag) => by_rule(document, child, "worldbody", tag, ignored)?,
                _ => unknown(document, child, document.tag(id), OF_BODIES, ignored)?,
            }
        }
    }
    Ok(())
}

fn defaults(document: &Document, top: Id, ignored: &mut Ignored) -> Result<(), RobotError> {
    let known = ["default", "mesh", "material", "joint", "geom", "site", "equality", "texture", "camera", "light"];
    let known = || known.into_iter().chain(["pair", "tendon"]).chain(ACTUATORS);
    let mut stack = vec![top];
    while let Some(id) = stack.pop() {
        attributes(document, id, &["class"], ignored)?;
        for &child in document.children(id) {
            match document.tag(child) {
                "default" => stack.push(child),
                tag @ ("joint" | "geom" | "site") => by_rule(document, child, "worldbody", tag, ignored)?,
                tag @ ("mesh" | "material") => by_rule(document, child, "asset", tag, ignored)?,
                "equality" => by_rule(document, child, "equality", "equality", ignored)?,
                "texture" | "camera" | "light" | "pair" | "tendon" => {}
                tag if ACTUATORS.contains(&tag) => by_rule(document, child, "actuator", tag, ignored)?,
                _ => unknown(document, child, "default", known(), ignored)?,
            }
        }
    }
    Ok(())
}

/// Checks an element of a section by its rule.
fn by_rule(document: &Document, id: Id, section: &str, tag: &str, ignored: &mut Ignored) -> Result<(), RobotError> {
    let known: &[&str] = match section {
        "actuator" => &ACTUATORS,
        "equality" => &["connect", "weld", "joint", "tendon", "flex", "flexvert", "flexstrain"],
        "contact" => &["pair", "exclude"],
        "asset" => &["mesh", "material", "texture", "hfield", "skin", "model"],
        "keyframe" => &["key"],
        _ => &OF_BODIES,
    };
    if section != "compiler" && tag != "equality" && !known.contains(&tag) {
        return unknown(document, id, section, known.iter().copied(), ignored);
    }
    let same = |rule: &&Rule| rule.section == section && (rule.tag == tag || rule.tag == section);
    let Some(rule) = RULES.iter().find(same) else { return Ok(()) };
    let words = |list: &'static str| list.split_whitespace();
    for name in words(rule.ignored) {
        if let Some(value) = document.text(id, name) {
            let is_friction = (tag, name) == ("geom", "friction");
            let note = match (is_friction, ignored.role) {
                (true, Role::World) => continue,
                (true, Role::Part) => format!("attribute `{name}` of <{tag}> counts only for a `[world]`"),
                _ => format!("attribute `{name}` of <{tag}> is ignored"),
            };
            // The default of each is off.
            if !matches!(value.trim(), "0" | "false") {
                ignored.note(id, note);
            }
        }
    }
    let all: Vec<&str> = words(rule.read).chain(words(rule.silent)).chain(words(rule.ignored)).collect();
    attributes(document, id, &all, ignored)
}

fn attributes(document: &Document, id: Id, known: &[&str], ignored: &mut Ignored) -> Result<(), RobotError> {
    let tag = document.tag(id);
    for attribute in &document.element(id).attributes {
        let name = attribute.name.as_str();
        if known.contains(&name) {
            continue;
        }
        if nearest(name, known.iter().copied()).is_some() {
            let fault = document.attribute_fault(id, name, format!("<{tag}> has no attribute `{name}`"));
            return Err(fault.expected("an attribute of MJCF").suggest(name, known.iter().copied()).invalid());
        }
        ignored.warning(id, format!("unknown attribute `{name}` of <{tag}> is ignored"));
    }
    Ok(())
}

fn unknown<'a>(
    document: &Document,
    id: Id,
    parent: &str,
    known: impl IntoIterator<Item = &'a str>,
    ignored: &mut Ignored,
) -> Result<(), RobotError> {
    let tag = document.tag(id);
    let known: Vec<&str> = known.into_iter().collect();
    if nearest(tag, known.iter().copied()).is_some() {
        let fault = document.fault(id, format!("<{parent}> has no element <{tag}>"));
        return Err(fault.expected("an element of MJCF").suggest(tag, known).invalid());
    }
    ignored.warning(id, format!("unknown element <{tag}> of <{parent}> is ignored"));
    Ok(())
}
