//! Tests the links of the pages, on a forge and in the book that mdBook makes of `docs/`.
//!
//! A link works in both if its target is a file of `docs/` and its anchor is the same by both rules.
//! Pages of `docs/` therefore name files outside it as code, without a link.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Component, Path, PathBuf};

use super::markdown::Page;
use super::repository;

const SUMMARY: &str = "docs/SUMMARY.md";
const PARTS: [&str; 4] = ["Start", "Guide", "Concepts", "Reference"];

fn root() -> PathBuf {
    repository().to_owned()
}

/// Adds the pages of a folder of the repository.
fn add_pages(folder: &str, recursive: bool, pages: &mut BTreeMap<PathBuf, Page>) {
    for entry in fs::read_dir(root().join(folder)).unwrap() {
        let name = Path::new(folder).join(entry.unwrap().file_name());
        let path = root().join(&name);
        if path.is_dir() && recursive {
            add_pages(name.to_str().unwrap(), true, pages);
        } else if name.extension().is_some_and(|extension| extension == "md") {
            pages.insert(name, Page::read(&fs::read_to_string(path).unwrap()));
        }
    }
}

/// All pages by their path from the root of the repository.
fn pages() -> BTreeMap<PathBuf, Page> {
    let mut pages = BTreeMap::new();
    for (folder, recursive) in [("", false), ("docs", true), ("results", false), ("robots", true), ("scenarios", true)]
    {
        add_pages(folder, recursive, &mut pages);
    }
    pages
}

/// The path from the root of a path relative to a folder; none if it leaves the repository.
fn resolve(folder: &Path, path: &str) -> Option<PathBuf> {
    let mut resolved = folder.to_owned();
    for component in Path::new(path).components() {
        match component {
            Component::ParentDir => resolved.pop().then_some(())?,
            Component::Normal(name) => resolved.push(name),
            Component::CurDir => {}
            _ => return None,
        }
    }
    Some(resolved)
}

/// What is wrong with a relative link.
fn fault(from: &Path, link: &str, pages: &BTreeMap<PathBuf, Page>) -> Option<String> {
    let (path, anchor) = link.split_once('#').map_or((link, None), |(path, anchor)| (path, Some(anchor)));
    let target = match path {
        "" => from.to_owned(),
        path => match resolve(from.parent().unwrap(), path) {
            Some(target) => target,
            None => return Some("leaves the repository".into()),
        },
    };
    let file = root().join(&target);
    if !file.exists() {
        return Some(format!("there is no {}", target.display()));
    }
    if from.starts_with("docs") {
        if !target.starts_with("docs") {
            return Some("leaves docs/: name the file as code, without a link".into());
        }
        if !file.is_file() || target == Path::new(SUMMARY) {
            return Some("is not a page or file of the book".into());
        }
    }
    let anchor = anchor?;
    let Some(page) = pages.get(&target) else { return Some("has an anchor, but its target is not a page".into()) };
    let ids = page.ids.iter().map(|(_, id)| id);
    let known = page.github_slugs().iter().chain(ids).any(|known| known == anchor);
    (!known).then(|| format!("{} has no heading `#{anchor}`", target.display()))
}

#[test]
fn links_resolve_on_a_forge_and_in_the_book() {
    let pages = pages();
    let (mut errors, mut links, mut anchors) = (Vec::new(), 0, 0);
    for (name, page) in &pages {
        let relative = |link: &str| !["https://", "http://", "mailto:"].iter().any(|scheme| link.starts_with(scheme));
        for (line, link) in page.links.iter().filter(|(_, link)| relative(link)) {
            links += 1;
            anchors += usize::from(link.contains('#'));
            let fault = fault(name, link, &pages);
            errors.extend(fault.map(|fault| format!("{}:{line}: `{link}` {fault}", name.display())));
        }
    }
    println!("{} pages, {links} relative links, {anchors} of them with an anchor", pages.len());
    assert!(errors.is_empty(), "{}", errors.join("\n"));
    assert!(links > 300 && anchors > 200, "only {links} links with {anchors} anchors were found");
}

#[test]
fn anchors_are_unique_and_equal_on_a_forge_and_in_the_book() {
    let mut errors = Vec::new();
    for (name, page) in pages() {
        let slugs = page.github_slugs();
        for (slug, other) in slugs.iter().zip(&page.mdbook_slugs()).filter(|(slug, other)| slug != other) {
            errors.push(format!("{}: `#{slug}` on a forge, `#{other}` in the book", name.display()));
        }
        let mut seen = BTreeSet::new();
        // An id may be that of the heading that follows it.
        let ids = page.ids.iter().filter(|(next, id)| slugs.get(*next) != Some(id)).map(|(_, id)| id);
        for anchor in slugs.iter().chain(ids).filter(|anchor| !seen.insert(anchor.as_str())) {
            errors.push(format!("{}: `#{anchor}` is given twice", name.display()));
        }
    }
    assert!(errors.is_empty(), "{}", errors.join("\n"));
}

#[test]
fn every_page_of_docs_is_in_one_part_of_the_summary() {
    let pages = pages();
    let summary = fs::read_to_string(root().join(SUMMARY)).unwrap();
    let (title, parts) = summary.split_once("\n# ").expect("a part");
    assert!(Page::read(title).links.is_empty(), "pages before the first part");
    let titles: Vec<&str> = parts.split("\n# ").map(|part| part.lines().next().unwrap()).collect();
    assert_eq!(titles, PARTS);
    let listed: Vec<PathBuf> = Page::read(parts).links.iter().map(|(_, link)| Path::new("docs").join(link)).collect();
    let mut errors = Vec::new();
    for page in pages.keys().filter(|page| page.starts_with("docs") && *page != Path::new(SUMMARY)) {
        match listed.iter().filter(|listed| *listed == page).count() {
            1 => {}
            count => errors.push(format!("{SUMMARY} lists {} {count} times", page.display())),
        }
    }
    let other = listed.iter().filter(|page| !pages.contains_key(*page));
    errors.extend(other.map(|page| format!("{SUMMARY} lists {}, which is not a page", page.display())));
    assert!(errors.is_empty(), "{}", errors.join("\n"));
}
