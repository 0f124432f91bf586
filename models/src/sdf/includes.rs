//! Resolves `<include>` and the URIs of files.
//!
//! `model://NAME/REST` names a model. It is searched in the folder of the file, in its subfolder
//! `models`, and in the folder above, whose subfolders are siblings of the file's own. A plain path
//! starts from the file's folder. No path leads out of the folder above the file's.

use std::path::{Component, Path, PathBuf};

use super::document::{Model, SdfError, WrittenPose};
use super::geometry::pose;
use super::read_model::{MAX_DEPTH, Reading, read_file};
use super::xml::{Element, parse};
use crate::input;
use crate::text::source::Source;

/// The file or folder of a URI in a file of `folder`.
///
/// # Errors
/// A text that says why there is none.
pub fn resolve_uri(folder: &Path, uri: &str) -> Result<PathBuf, String> {
    if let Some(rest) = uri.strip_prefix("model://").or_else(|| uri.strip_prefix("package://")) {
        let rest = Path::new(rest.trim_start_matches('/'));
        if rest.as_os_str().is_empty() || !rest.components().all(|part| matches!(part, Component::Normal(_))) {
            return Err("its path has parts such as `..`".into());
        }
        let folders = [folder.to_owned(), folder.join("models"), above(folder)];
        let found = folders.iter().map(|candidate| candidate.join(rest)).find(|path| path.exists());
        return found.ok_or_else(|| {
            let names: Vec<String> = folders.iter().map(|f| f.display().to_string()).collect();
            format!("there is no {} in {}", rest.display(), names.join(", "))
        });
    }
    let path = uri.strip_prefix("file://").unwrap_or(uri);
    if path.contains("://") {
        return Err("only files, model:// and package:// are read".into());
    }
    let mut depth = 0;
    for part in Path::new(path).components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => depth -= 1,
            Component::Normal(_) => depth += 1,
            _ => return Err("it is an absolute path".into()),
        }
        if depth < -1 {
            return Err("it leads out of the folder above the file's".into());
        }
    }
    let found = folder.join(path);
    if found.exists() { Ok(found) } else { Err(format!("there is no {}", found.display())) }
}

/// The folder above, by name if it has one.
fn above(folder: &Path) -> PathBuf {
    match folder.components().next_back() {
        Some(Component::Normal(_)) => match folder.parent() {
            Some(parent) if parent.as_os_str().is_empty() => PathBuf::from("."),
            Some(parent) => parent.to_owned(),
            None => folder.join(".."),
        },
        _ => folder.join(".."),
    }
}

/// The included model; `None` if its name is skipped.
pub(super) fn include(
    element: &Element,
    reading: &mut Reading,
    depth: usize,
    is_of_world: bool,
) -> Result<Option<Model>, SdfError> {
    element.check_children(&mut reading.document.remarks);
    if matches!(element.attribute("merge"), Some("true" | "1")) {
        let error = SdfError::new(element.at_attribute("merge"), "merged includes are not available");
        return Err(error.element("<include>").expected("an include without `merge`").not_available());
    }
    if depth >= MAX_DEPTH {
        let error = element.error("files include each other, or too many levels deep");
        return Err(error.expected(format!("at most {MAX_DEPTH} levels")));
    }
    let uri = element.required("uri")?;
    let given = element.child("name")?.map(|name| name.text().to_owned());
    let last = uri.text().trim_end_matches('/').rsplit('/').next().unwrap_or_default();
    let is_skipped = |name: &str| is_of_world && depth == 0 && (reading.skip)(name);
    if is_skipped(given.as_deref().unwrap_or(last)) {
        return Ok(None);
    }
    let pose = match element.child("pose")? {
        Some(_) => Some(pose(element, &mut reading.document.remarks)?),
        None => None,
    };
    let is_static = match element.child("static")? {
        Some(flag) => Some(flag.truth()?),
        None => None,
    };
    let placement_frame = element.child("placement_frame")?.map(|frame| frame.text().to_owned());
    if placement_frame.is_some() && pose.is_none() {
        let error = element.error("<placement_frame> requires <pose>");
        return Err(error.expected("a <pose> of that frame"));
    }
    let cannot = |reason: String| uri.bad_value("the URI of a model").help(reason);
    let folder = uri.source.path().parent().unwrap_or(Path::new(""));
    let found = resolve_uri(folder, uri.text()).map_err(cannot)?;
    let file = if found.is_dir() { model_file(&found).map_err(cannot)? } else { found };
    // A file is read once, so that all its uses have the bytes that the key of a run hashes.
    let known = reading.document.files.iter().find(|(known, _)| *known == file);
    let text = match known.and_then(|(_, bytes)| str::from_utf8(bytes).ok()) {
        Some(text) => text.to_owned(),
        None => {
            let text = input::read_text(&file, input::MOST_TEXT)
                .map_err(|error| cannot(format!("{} cannot be read: {error}", file.display())))?;
            reading.document.files.push((file.clone(), text.as_bytes().to_vec()));
            text
        }
    };
    // Models of the included file go to their own list.
    let own = std::mem::take(&mut reading.document.models);
    let done = read_file(&Source::new(&file, text), reading, depth + 1);
    let mut models = std::mem::replace(&mut reading.document.models, own);
    done?;
    let Some(mut model) = models.pop().filter(|_| models.is_empty()) else {
        return Err(cannot(format!("{} does not hold one model", file.display())));
    };
    if let Some(name) = given {
        model.name = name;
    }
    if is_of_world && depth == 0 && (reading.skip)(&model.name) {
        return Ok(None);
    }
    model.at = element.at();
    if let Some(pose) = pose {
        (model.pose, model.placement_frame) = (pose, placement_frame);
    } else {
        // Its frames are not known here.
        model.pose = WrittenPose { relative_to: None, ..model.pose };
    }
    model.is_static = is_static.unwrap_or(model.is_static);
    Ok(Some(model))
}

/// The newest file that `model.config` of a model's folder names, or `model.sdf`.
fn model_file(folder: &Path) -> Result<PathBuf, String> {
    let manifest = folder.join("model.config");
    let plain = folder.join("model.sdf");
    if !manifest.is_file() {
        return if plain.is_file() { Ok(plain) } else { Err(format!("there is no {}", plain.display())) };
    }
    let text = input::read_text(&manifest, input::MOST_TEXT).map_err(|error| error.to_string())?;
    let source = Source::new(&manifest, text);
    let xml = parse(&source).map_err(|error| error.to_string())?;
    let version = |node: &roxmltree::Node| -> Vec<u32> {
        let text = node.attribute("version").unwrap_or("0");
        text.split('.').map(|part| part.parse().unwrap_or(0)).collect()
    };
    let named = xml.root_element().children().filter(|n| n.has_tag_name("sdf"));
    let named = named.max_by_key(version).and_then(|n| n.text());
    let name = Path::new(named.map_or("model.sdf", str::trim));
    if !name.components().all(|part| matches!(part, Component::Normal(_))) {
        return Err(format!("{} names a file outside its folder", manifest.display()));
    }
    Ok(folder.join(name))
}
