//! Tests that at most three files of the sources form an import cycle, except for a trait with its
//! registry.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use super::{rust_files, sources};

/// Files that may form a larger cycle: the trait of contact methods and the registry of its
/// implementations.
const REGISTRY: &str = "contact/methods/";
const MAX_CYCLE: usize = 3;

/// A module path below the crate root.
type Module = Vec<String>;

struct SourceFile {
    /// Name relative to the sources of its crate.
    name: String,
    /// Imports, and in a `mod.rs` re-exports: full paths of single names.
    uses: Vec<Module>,
    reexports: BTreeMap<String, Module>,
}

/// Relative to the sources of its crate: the program exports the simulator's modules under their
/// names.
fn relative(file: &Path) -> &Path {
    sources().iter().find_map(|source| file.strip_prefix(source).ok()).expect("a file of the sources")
}

fn module_of(file: &Path) -> Module {
    let relative = relative(file).with_extension("");
    let mut parts: Module = relative.iter().map(|part| part.to_str().unwrap().to_owned()).collect();
    if ["mod", "lib", "main"].contains(&parts.last().unwrap().as_str()) {
        parts.pop();
    }
    parts
}

/// Expands a use tree such as `a::{b, c::D}` into single paths.
fn expand(tree: &str, prefix: &[String], found: &mut Vec<Module>) {
    let tree = tree.trim();
    let (head, rest) = match tree.find('{') {
        Some(at) => (&tree[..at], Some(tree[at + 1..].rsplit_once('}').unwrap().0)),
        None => (tree, None),
    };
    let head = head.split(" as ").next().unwrap();
    let parts = head.split("::").map(str::trim).filter(|part| !part.is_empty() && *part != "self");
    let path: Module = prefix.iter().cloned().chain(parts.map(str::to_owned)).collect();
    let Some(list) = rest else {
        found.push(path);
        return;
    };
    let (mut depth, mut start) = (0, 0);
    for (at, c) in list.char_indices().chain([(list.len(), ',')]) {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                let item = &list[start..at];
                if !item.trim().is_empty() {
                    expand(item, &path, found);
                }
                start = at + 1;
            }
            _ => {}
        }
    }
}

/// A path from the crate root; none if it leaves the crate.
fn absolute(path: &Module, module: &Module, children: &BTreeSet<Module>) -> Option<Module> {
    let mut path = path.clone();
    match path.first()?.as_str() {
        "crate" | "stiction" | "stiction_assembly" | "stiction_format" | "stiction_models" | "stiction_numerics"
        | "stiction_runs" | "stiction_simulator" => Some(path.split_off(1)),
        "super" => {
            let mut base = module.clone();
            while path.first().is_some_and(|part| part == "super") {
                base.pop();
                path.remove(0);
            }
            Some(base.into_iter().chain(path).collect())
        }
        // A child of this module.
        first => {
            let child: Module = module.iter().cloned().chain([first.to_owned()]).collect();
            children.contains(&child).then(|| module.iter().cloned().chain(path).collect())
        }
    }
}

fn read_sources() -> BTreeMap<Module, SourceFile> {
    let mut paths: Vec<PathBuf> = Vec::new();
    sources().iter().for_each(|source| rust_files(source, &mut paths));
    let modules: BTreeSet<Module> = paths.iter().map(|path| module_of(path)).collect();
    let mut files = BTreeMap::new();
    // The crate roots import everything, and no file imports them.
    for path in paths.iter().filter(|path| !module_of(path).is_empty()) {
        let (text, module) = (fs::read_to_string(path).unwrap(), module_of(path));
        let code = text.split("#[cfg(test)]\nmod ").next().unwrap();
        let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
        let code = lines.collect::<Vec<_>>().join(" ");
        let name = relative(path).display().to_string();
        let mut file = SourceFile { name, uses: Vec::new(), reexports: BTreeMap::new() };
        for (at, _) in code.match_indices("use ") {
            let before = code[..at].trim_end();
            if !(before.is_empty() || before.ends_with([';', '}', ']', ')', '{']) || before.ends_with("pub")) {
                continue;
            }
            let mut single = Vec::new();
            expand(code[at + 4..].split(';').next().unwrap(), &[], &mut single);
            let exported = before.ends_with("pub") || before.rsplit(';').next().unwrap().trim().starts_with("pub(");
            for path in single.iter().filter_map(|path| absolute(path, &module, &modules)) {
                match exported {
                    true => drop(file.reexports.insert(path.last().unwrap().clone(), path)),
                    false => file.uses.push(path),
                }
            }
        }
        files.insert(module, file);
    }
    files
}

/// The module that defines the name at the end of a path, through re-exports.
fn defining_module(path: &Module, files: &BTreeMap<Module, SourceFile>, depth: usize) -> Option<Module> {
    let length = (1..=path.len()).rev().find(|length| files.contains_key(&path[..*length]))?;
    let module = path[..length].to_vec();
    match path.get(length).and_then(|name| files[&module].reexports.get(name)) {
        Some(next) if depth < 8 => defining_module(next, files, depth + 1),
        _ => Some(module),
    }
}

fn reachable<'a>(from: &'a Module, imports: &'a BTreeMap<Module, BTreeSet<Module>>) -> BTreeSet<&'a Module> {
    let (mut seen, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(module) = open.pop() {
        for next in &imports[module] {
            if seen.insert(next) {
                open.push(next);
            }
        }
    }
    seen
}

#[test]
fn import_cycles_have_at_most_three_files_except_the_contact_method_registry() {
    let files = read_sources();
    let mut imports: BTreeMap<Module, BTreeSet<Module>> = BTreeMap::new();
    for (module, file) in &files {
        let targets = file.uses.iter().filter_map(|path| defining_module(path, &files, 0));
        imports.insert(module.clone(), targets.filter(|target| target != module).collect());
    }
    assert!(imports.values().map(BTreeSet::len).sum::<usize>() > 1000, "imports are found");
    let reach: BTreeMap<&Module, BTreeSet<&Module>> =
        imports.keys().map(|module| (module, reachable(module, &imports))).collect();
    let mut cycles: BTreeSet<Vec<&str>> = BTreeSet::new();
    for (module, to) in &reach {
        if to.contains(module) {
            let members = to.iter().filter(|other| reach[**other].contains(module));
            cycles.insert(members.map(|member| files[*member].name.as_str()).collect());
        }
    }
    let allowed = |cycle: &Vec<&str>| cycle.len() <= MAX_CYCLE || cycle.iter().all(|name| name.starts_with(REGISTRY));
    let refused: Vec<_> = cycles.iter().filter(|cycle| !allowed(cycle)).collect();
    assert!(refused.is_empty(), "import cycles: {refused:#?}");
}
