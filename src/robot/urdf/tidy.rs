//! The text handed to `urdf-rs`: it insists on attributes of elements nobody reads here, and on a velocity limit.

use std::ops::Range;

use roxmltree::Node;

use super::check::is_read;
use super::xml::Xml;

/// The file's text without the elements that are not read, and with `velocity="0"` where a `<limit>` has none (whether
/// it was there is asked of the original).
pub(super) fn tidy(xml: &Xml) -> String {
    let mut edits: Vec<(Range<usize>, &str)> = Vec::new();
    let text = xml.source.text();
    collect(text, xml.robot, &mut edits);
    let mut out = String::with_capacity(text.len());
    let mut from = 0;
    for (range, replacement) in edits {
        out.push_str(&text[from..range.start]);
        out.push_str(replacement);
        from = range.end;
    }
    out.push_str(&text[from..]);
    out
}

/// Edits in document order. The elements that are read nest at most five deep, so this recursion is bounded.
fn collect(text: &str, node: Node, edits: &mut Vec<(Range<usize>, &str)>) {
    for child in node.children().filter(|n| n.is_element()) {
        if !is_read(node, child) {
            edits.push((child.range(), ""));
            continue;
        }
        let start = child.range().start;
        if text[start..].starts_with("<limit") && !child.has_attribute("velocity") {
            let after_name = start + "<limit".len();
            edits.push((after_name..after_name, " velocity=\"0\""));
        }
        collect(text, child, edits);
    }
}
