//! The text given to `urdf-rs`, which requires a velocity limit and attributes of elements that are
//! not used here, reads commas as zeros, and overflows the stack on deeply nested elements.

use std::ops::Range;

use roxmltree::Node;

use super::grammar::{has_commas, is_read};
use super::xml::Xml;

/// The file's text without elements that are not read, with `velocity="0"` added to each `<limit>`
/// that lacks it (its presence is checked in the original), and with commas replaced by spaces.
pub(super) fn sanitize(xml: &Xml) -> String {
    let mut edits: Vec<(Range<usize>, String)> = Vec::new();
    let text = xml.source.text();
    collect(text, xml.robot, &mut edits);
    let mut out = String::with_capacity(text.len());
    let mut from = 0;
    for (range, replacement) in edits {
        out.push_str(&text[from..range.start]);
        out.push_str(&replacement);
        from = range.end;
    }
    out.push_str(&text[from..]);
    out
}

/// Edits in document order. The elements that are read nest at most five deep, so this recursion is
/// bounded.
fn collect(text: &str, node: Node, edits: &mut Vec<(Range<usize>, String)>) {
    for child in node.children().filter(|n| n.is_element()) {
        if !is_read(node, child) {
            edits.push((child.range(), String::new()));
            continue;
        }
        let start = child.range().start;
        if text[start..].starts_with("<limit") && !child.has_attribute("velocity") {
            let after_name = start + "<limit".len();
            edits.push((after_name..after_name, " velocity=\"0\"".into()));
        }
        for a in child.attributes().filter(|a| has_commas(child.tag_name().name(), a.name(), a.value())) {
            edits.push((a.range_value(), a.value().replace(',', " ")));
        }
        collect(text, child, edits);
    }
}
