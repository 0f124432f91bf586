//! Tests of the viewer page.

use crate::record::sample;
use base64::Engine as _;
use std::io::Read;
use stiction::log::TopicGroups;
use stiction::view::{DrawnRun, file_page, pack, served_page};

fn between<'a>(page: &'a str, begin: &str, end: &str) -> &'a str {
    page.split_once(begin).unwrap().1.split_once(end).unwrap().0
}

#[test]
fn a_file_page_contains_its_run() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.mcap");
    sample::open_log(&path, 20, TopicGroups::ALL).finish().unwrap();
    let packed = pack(&DrawnRun::read(&path).unwrap(), None);
    let page = file_page("a run", &packed);
    let data = between(&page, "<script id=\"data\" type=\"text/plain\">", "</script>");
    let zipped = base64::engine::general_purpose::STANDARD.decode(data).unwrap();
    let mut bytes = Vec::new();
    flate2::read::GzDecoder::new(&*zipped).read_to_end(&mut bytes).unwrap();
    assert_eq!(bytes, packed.0);
}

#[test]
fn a_page_loads_nothing_from_other_hosts() {
    let page = served_page("a run", true);
    // An XML namespace in three.js, which is not loaded.
    let without_namespace = page.replace("http://www.w3.org/1999/xhtml", "");
    for reference in ["http://", "https://", "src=", "@import", "url(", "import("] {
        assert!(!without_namespace.contains(reference), "{reference}");
    }
    assert!(page.contains("Content-Security-Policy\" content=\"default-src 'none'"));
    assert_eq!(page.matches("<script").count(), 3, "data, three.js, ours");
    assert_eq!(page.matches("</script>").count(), 3, "no script is cut short");
    assert!(page.contains("Three.js Authors"), "the licence names the authors");
}

#[test]
fn names_are_escaped() {
    let page = served_page("</title><script>alert(1)</script>", false);
    assert!(!page.contains("<script>alert"));
    assert!(!page.contains(">all runs<"), "there is only one run");
    assert!(served_page("a run", true).contains("<a href=\"/\">all runs</a>"));
}
