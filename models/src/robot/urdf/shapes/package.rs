//! Resolves the file of a mesh.
//!
//! `package://NAME/REST` names a ROS package. There is no ROS here, so the package is searched
//! around the URDF. In each folder from the URDF's own upward, the folder may contain one called
//! NAME, or be the package itself, by its own name or by that in its `package.xml`.
//! `package:///NAME/REST` and `model://NAME/REST` mean the same. These names are URIs, so `%20` may
//! stand for a space (RFC 3986, section 2.1); a file whose name contains `%20` itself takes
//! precedence.

use std::path::{Path, PathBuf};

use crate::input;
use crate::mesh::MeshError;
use crate::text::xml_attributes::excess_attribute;

/// The file of a mesh name of a URDF in `folder`; the error lists the folders searched.
pub(super) fn resolve(folder: &Path, filename: &str) -> Result<PathBuf, MeshError> {
    let found = find_file(folder, filename);
    let decoded = percent_decoded(filename).filter(|_| found.is_err());
    decoded.and_then(|name| find_file(folder, &name).ok()).map_or(found, Ok)
}

/// The name with every `%` and two hexadecimal digits replaced by their byte; none when nothing
/// changes, or the bytes are not UTF-8.
fn percent_decoded(name: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(name.len());
    let mut rest = name.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let digits = after.first_chunk().filter(|_| first == b'%');
        let byte = digits.and_then(|[a, b]| Some(16 * char::from(*a).to_digit(16)? + char::from(*b).to_digit(16)?));
        bytes.push(byte.map_or(first, |byte| byte as u8));
        rest = if byte.is_some() { &after[2..] } else { after };
    }
    String::from_utf8(bytes).ok().filter(|decoded| decoded != name)
}

fn find_file(folder: &Path, filename: &str) -> Result<PathBuf, MeshError> {
    if let Some(name) = filename.strip_prefix("package://").or_else(|| filename.strip_prefix("model://")) {
        let Some((package, inside)) = name.trim_start_matches('/').split_once('/') else {
            return Err("the name lacks a path inside the package".into());
        };
        // The ancestors of a relative folder require its absolute path.
        let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let absolute = std::path::absolute(here)?;
        let found = absolute.ancestors().find_map(|above| {
            let inside_folder = above.join(package).join(inside);
            let itself = is_package(above, package).then(|| above.join(inside));
            [Some(inside_folder), itself].into_iter().flatten().find(|path| path.is_file())
        });
        return found.ok_or_else(|| {
            let folders: Vec<String> = absolute.ancestors().map(|a| a.display().to_string()).collect();
            format!("no folder `{package}` with `{inside}` in it is found in {}", folders.join(", ")).into()
        });
    }
    let path = folder.join(filename.strip_prefix("file://").unwrap_or(filename));
    if path.is_file() { Ok(path) } else { Err(format!("there is no file {}", path.display()).into()) }
}

/// True when the folder is the ROS package of that name.
fn is_package(folder: &Path, name: &str) -> bool {
    let manifest = || input::read_text(&folder.join("package.xml"), input::MOST_TEXT).ok();
    let has_name = |text: String| {
        if excess_attribute(&text).is_some() {
            return None;
        }
        let document = roxmltree::Document::parse(&text).ok()?;
        let node = document.root_element().children().find(|n| n.has_tag_name("name"))?;
        Some(node.text()?.trim() == name)
    };
    folder.file_name().is_some_and(|own| own == name) || manifest().and_then(has_name).unwrap_or(false)
}
