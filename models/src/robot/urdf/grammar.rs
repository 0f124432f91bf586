//! Checks a URDF's elements and attributes. Those that `urdf-rs` ignores are reported; values that
//! it would misread are refused with their position.

use roxmltree::Node;

use super::xml::{Xml, describe};
use crate::robot::notices::Notices;
use crate::robot::robot_error::RobotError;

/// Value of an attribute.
#[derive(Clone, Copy, PartialEq)]
enum Value {
    /// A name: not empty, no spaces around it.
    Name,
    /// Any text; some exporters write empty material names.
    Text,
    Number,
    NotNegative,
    Positive,
    Vector(usize),
    PositiveVector(usize),
    /// Not negative, kg.
    Mass,
    /// Three coordinates, m.
    Position,
}
use Value::*;

/// Greatest mass, kg: squares of greater ones could overflow.
const MAX_MASS: f64 = 1e12;
/// Greatest coordinate, m: beyond it rounding of the inertia about a joint exceeds that about the
/// centre of mass.
const MAX_COORDINATE: f64 = 1e4;

/// One element: attributes (name, value, required) and child elements (name, count).
struct Rule {
    tag: &'static str,
    attributes: &'static [(&'static str, Value, bool)],
    children: &'static [(&'static str, Count)],
}

#[derive(Clone, Copy, PartialEq)]
enum Count {
    Many,
    AtMostOnce,
    Once,
    /// Defined by URDF, not used here.
    Ignored,
}
use Count::*;

const RULES: &[Rule] = &[
    Rule {
        tag: "robot",
        attributes: &[("name", Text, false), ("version", Text, false)],
        children: &[("link", Many), ("joint", Many), ("material", Many)],
    },
    Rule {
        tag: "link",
        attributes: &[("name", Name, true)],
        children: &[("inertial", AtMostOnce), ("visual", Many), ("collision", Many)],
    },
    Rule { tag: "inertial", attributes: &[], children: &[("origin", AtMostOnce), ("mass", Once), ("inertia", Once)] },
    Rule {
        tag: "origin",
        attributes: &[("xyz", Position, false), ("rpy", Vector(3), false), ("quat_xyzw", Vector(4), false)],
        children: &[],
    },
    Rule { tag: "mass", attributes: &[("value", Mass, true)], children: &[] },
    Rule {
        tag: "inertia",
        attributes: &[
            ("ixx", Number, true),
            ("ixy", Number, true),
            ("ixz", Number, true),
            ("iyy", Number, true),
            ("iyz", Number, true),
            ("izz", Number, true),
        ],
        children: &[],
    },
    Rule {
        tag: "visual",
        attributes: &[("name", Text, false)],
        children: &[("origin", AtMostOnce), ("geometry", Once), ("material", AtMostOnce)],
    },
    Rule {
        tag: "collision",
        attributes: &[("name", Text, false)],
        children: &[("origin", AtMostOnce), ("geometry", Once)],
    },
    Rule {
        tag: "geometry",
        attributes: &[],
        children: &[
            ("box", AtMostOnce),
            ("cylinder", AtMostOnce),
            ("capsule", AtMostOnce),
            ("sphere", AtMostOnce),
            ("mesh", AtMostOnce),
        ],
    },
    Rule { tag: "box", attributes: &[("size", PositiveVector(3), true)], children: &[] },
    Rule { tag: "cylinder", attributes: &[("radius", Positive, true), ("length", Positive, true)], children: &[] },
    Rule { tag: "capsule", attributes: &[("radius", Positive, true), ("length", Positive, true)], children: &[] },
    Rule { tag: "sphere", attributes: &[("radius", Positive, true)], children: &[] },
    Rule { tag: "mesh", attributes: &[("filename", Name, true), ("scale", Vector(3), false)], children: &[] },
    Rule {
        tag: "material",
        attributes: &[("name", Text, true)],
        children: &[("color", AtMostOnce), ("texture", Ignored)],
    },
    Rule { tag: "color", attributes: &[("rgba", Vector(4), true)], children: &[] },
    Rule {
        tag: "joint",
        attributes: &[("name", Name, true), ("type", Name, true)],
        children: &[
            ("origin", AtMostOnce),
            ("parent", Once),
            ("child", Once),
            ("axis", AtMostOnce),
            ("limit", AtMostOnce),
            ("dynamics", AtMostOnce),
            ("mimic", AtMostOnce),
            ("calibration", Ignored),
            ("safety_controller", Ignored),
        ],
    },
    Rule { tag: "parent", attributes: &[("link", Name, true)], children: &[] },
    Rule { tag: "child", attributes: &[("link", Name, true)], children: &[] },
    Rule { tag: "axis", attributes: &[("xyz", Vector(3), true)], children: &[] },
    Rule {
        tag: "limit",
        attributes: &[
            ("lower", Number, false),
            ("upper", Number, false),
            ("effort", NotNegative, false),
            ("velocity", NotNegative, false),
        ],
        children: &[],
    },
    Rule {
        tag: "dynamics",
        attributes: &[("damping", NotNegative, false), ("friction", NotNegative, false)],
        children: &[],
    },
    Rule {
        tag: "mimic",
        attributes: &[("joint", Name, true), ("multiplier", Number, false), ("offset", Number, false)],
        children: &[],
    },
];

/// Checks the whole document: notices for dropped elements, and the first error.
pub(super) fn check(xml: &Xml, notices: &mut Notices) -> Result<(), RobotError> {
    // The grammar's elements nest at most five deep, so this recursion is bounded for every file.
    element(xml, xml.robot, notices)
}

fn element(xml: &Xml, node: Node, notices: &mut Notices) -> Result<(), RobotError> {
    let tag = node.tag_name().name();
    let Some(rule) = RULES.iter().find(|r| r.tag == tag) else { return Ok(()) };
    for (name, value, required) in rule.attributes {
        match node.attribute(*name) {
            Some(text) => attribute(xml, node, name, text, *value, notices)?,
            None if *required => {
                let fault = xml.fault(node, format!("{}: <{tag}> lacks the attribute `{name}`", describe(node)));
                return Err(fault.expected(format!("{name}=\"{}\"", describe_value(*value))).invalid());
            }
            None => {}
        }
    }
    for a in node.attributes() {
        if a.namespace().is_none() && !rule.attributes.iter().any(|(n, ..)| *n == a.name()) {
            notices.info(xml.source, a.range().start, format!("attribute `{}` of <{tag}> is ignored", a.name()));
        }
    }
    children(xml, node, rule, notices)
}

/// True when an attribute of several numbers has commas, where URDF requires spaces.
pub(super) fn has_commas(tag: &str, attribute: &str, text: &str) -> bool {
    let rule = RULES.iter().find(|r| r.tag == tag);
    let value =
        rule.and_then(|r| r.attributes.iter().find(|(name, ..)| *name == attribute)).map(|(_, value, _)| *value);
    text.contains(',') && value.is_some_and(is_list)
}

fn is_list(value: Value) -> bool {
    matches!(value, Vector(_) | PositiveVector(_) | Position)
}

/// The text with each comma replaced by a space, unless a number is missing as in `1,,2`.
fn without_commas(text: &str, has_commas: bool) -> std::borrow::Cow<'_, str> {
    match has_commas && text.split(',').all(|part| !part.trim().is_empty()) {
        true => text.replace(',', " ").into(),
        false => text.into(),
    }
}

/// True when elements with the child's name are read from the parent; others have been reported.
pub(super) fn is_read(parent: Node, child: Node) -> bool {
    let (parent, child) = (parent.tag_name().name(), child.tag_name().name());
    let rule = RULES.iter().find(|r| r.tag == parent);
    rule.is_some_and(|r| r.children.iter().any(|(name, count)| *name == child && *count != Ignored))
}

fn children(xml: &Xml, node: Node, rule: &Rule, notices: &mut Notices) -> Result<(), RobotError> {
    let tag = rule.tag;
    for (name, count) in rule.children {
        let mut found = node.children().filter(|n| n.has_tag_name(*name));
        let first = found.next();
        if *count == Once && first.is_none() {
            let fault = xml.fault(node, format!("{}: <{tag}> lacks <{name}>", describe(node)));
            return Err(fault.expected(format!("one <{name}>")).invalid());
        }
        if matches!(count, Once | AtMostOnce)
            && let Some(second) = found.next()
        {
            let fault = xml.fault(second, format!("{}: <{tag}> has more than one <{name}>", describe(node)));
            return Err(fault.expected(format!("one <{name}>")).invalid());
        }
    }
    if tag == "geometry" && node.children().filter(|n| n.is_element()).count() != 1 {
        let fault = xml.fault(node, format!("{}: <geometry> must hold one shape", describe(node)));
        return Err(fault.expected("one of <box>, <cylinder>, <capsule>, <sphere>, <mesh>").invalid());
    }
    for n in node.children().filter(|n| n.is_element()) {
        let name = n.tag_name().name();
        if n.tag_name().namespace().is_some_and(|ns| ns.contains("xacro")) {
            let fault = xml.fault(n, format!("<xacro:{name}> has not been expanded"));
            return Err(fault.expected("plain URDF").help("run the file through xacro first").invalid());
        }
        match rule.children.iter().find(|(c, _)| *c == name) {
            Some((_, Ignored)) | None if tag == "geometry" => {
                let fault = xml.fault(n, format!("{}: <{name}> is not a shape", describe(n)));
                let known = rule.children.iter().map(|(c, _)| *c);
                return Err(fault
                    .expected("one of box, cylinder, capsule, sphere, mesh")
                    .suggest(name, known)
                    .invalid());
            }
            Some((_, Ignored)) | None => {
                let owner = if tag == "robot" { String::new() } else { format!(" of {}", describe(node)) };
                notices.info(xml.source, n.range().start, format!("<{name}>{owner} is ignored"));
            }
            Some(_) => element(xml, n, notices)?,
        }
    }
    Ok(())
}

fn attribute(
    xml: &Xml,
    node: Node,
    name: &str,
    text: &str,
    value: Value,
    notices: &mut Notices,
) -> Result<(), RobotError> {
    let has_commas = text.contains(',') && is_list(value);
    let numbers: Option<Vec<f64>> =
        without_commas(text, has_commas).split_whitespace().map(|number| number.parse().ok()).collect();
    let is_valid = match (value, &numbers) {
        (Text, _) => true,
        (Name, _) => !text.is_empty() && text.trim() == text,
        (_, None) => false,
        (_, Some(n)) => {
            let length = match value {
                Vector(k) | PositiveVector(k) => k,
                Position => 3,
                _ => 1,
            };
            let in_range = match value {
                NotNegative => n.iter().all(|x| *x >= 0.0),
                Mass => n.iter().all(|x| (0.0..=MAX_MASS).contains(x)),
                Position => n.iter().all(|x| x.abs() <= MAX_COORDINATE),
                Positive | PositiveVector(_) => n.iter().all(|x| *x > 0.0),
                _ => true,
            };
            n.len() == length && in_range && n.iter().all(|x| x.is_finite())
        }
    };
    if is_valid {
        if has_commas {
            let message = format!("{}: commas in `{name}=\"{text}\"` are read as spaces", describe(node));
            notices.warning(xml.source, node.range().start, message);
        }
        return Ok(());
    }
    let message = format!("{}: `{name}` of <{}> cannot be used", describe(node), node.tag_name().name());
    let mut fault = xml.attribute_fault(node, name, message).expected(describe_value(value));
    if text.contains("${") {
        fault = fault.help("this appears to be a xacro file: run it through xacro first");
    }
    Err(fault.invalid())
}

fn describe_value(value: Value) -> String {
    match value {
        Text => "text".into(),
        Name => "text without spaces around it".into(),
        Number => "a finite number".into(),
        NotNegative => "a finite number, not negative".into(),
        Positive => "a finite number above 0".into(),
        Vector(n) => format!("{n} finite numbers separated by spaces"),
        Mass => format!("a mass in kg, not negative and at most {MAX_MASS:e}"),
        Position => format!("3 finite numbers separated by spaces, in m and at most {MAX_COORDINATE:e}"),
        PositiveVector(n) => format!("{n} finite numbers above 0 separated by spaces"),
    }
}
