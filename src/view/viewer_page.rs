//! Renders the viewer page: one file with style and scripts and, for a file page, the run.

use crate::files::{RecordError, atomic};
use crate::view::packed_run::PackedRun;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use minijinja::{AutoEscape, Environment, Value, context};
use std::io::Write as _;
use std::path::Path;

const STYLE: &str = include_str!("page/style.css");
const THREE: &str = include_str!("page/three.min.js");
/// Scripts in the order of their dependencies.
const SCRIPTS: [&str; 7] = [
    include_str!("page/run_data.js"),
    include_str!("page/stage.js"),
    include_str!("page/shapes.js"),
    include_str!("page/markers.js"),
    include_str!("page/robot_camera.js"),
    include_str!("page/playback_clock.js"),
    include_str!("page/main.js"),
];

/// Renders a page that contains its run.
pub fn file_page(title: &str, packed: &PackedRun) -> String {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::new(6));
    // Writing into memory does not fail.
    let zipped = encoder.write_all(&packed.0).and_then(|()| encoder.finish()).unwrap_or_default();
    viewer(title, &STANDARD.encode(zipped), false)
}

/// Writes a page to a temporary file and renames it to `path`. Creates the folder if necessary.
///
/// # Errors
/// The folder or file cannot be written.
pub fn write_page(path: &Path, page: &str) -> Result<(), RecordError> {
    atomic::write_named(path, atomic::OutputKind::Page, |out| {
        out.write_all(page.as_bytes()).map_err(RecordError::io(path))
    })
}

/// Renders a page that loads its run from the server, at the relative address `data`.
pub fn served_page(title: &str, one_of_many: bool) -> String {
    viewer(title, "", one_of_many)
}

fn viewer(title: &str, data: &str, one_of_many: bool) -> String {
    let scripts = SCRIPTS.concat();
    let safe = |text: &str| Value::from_safe_string(text.to_owned());
    let all = context! { title, one_of_many, three => safe(THREE), scripts => safe(&scripts), data => safe(data) };
    render("viewer.html", all)
}

/// Renders one of the two pages; both have the same style.
pub(super) fn render(name: &'static str, values: Value) -> String {
    let mut pages = Environment::new();
    pages.set_auto_escape_callback(|_| AutoEscape::Html);
    pages.add_global("style", Value::from_safe_string(STYLE.to_owned()));
    let source = if name == "list.html" { include_str!("page/list.html") } else { include_str!("page/viewer.html") };
    let page = pages.template_from_named_str(name, source).and_then(|page| page.render(values));
    // The templates are part of the program; an error in one is shown in place of the page.
    page.unwrap_or_else(|error| format!("<!DOCTYPE html><title>error</title><pre>{name}: {error:#}</pre>"))
}
