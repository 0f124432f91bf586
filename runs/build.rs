//! Names the build by a hash of the sources of this crate and of those below it, on which results depend. Records store it.
//! It needs no version control and no clock, so builds are reproducible and equal sources have equal names everywhere.

use std::path::{Path, PathBuf};

/// 64-bit FNV-1a: distinguishes builds and needs no dependency.
struct Fnv(u64);

impl Fnv {
    fn eat(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}

fn main() {
    let own = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    // A packaged crate comes alone; its `Cargo.lock` names the crates below it by their checksums.
    let workspace = own.parent().filter(|root| root.join("simulator/src").exists());
    let crates = "runs/src runs/Cargo.toml format/src format/Cargo.toml simulator/src simulator/Cargo.toml";
    let crates = if workspace.is_some() { crates } else { "src" };
    let root = workspace.unwrap_or(&own);
    let mut files = Vec::new();
    for name in crates.split(' ').chain(["Cargo.toml", "Cargo.lock"]) {
        if root.join(name).exists() {
            println!("cargo:rerun-if-changed={}", root.join(name).display());
            gather(&root.join(name), &mut files);
        }
    }
    // The order in which a folder lists its files depends on the system.
    let mut named: Vec<(String, PathBuf)> = files.into_iter().map(|path| (name_of(&path, root), path)).collect();
    named.sort();
    let mut hash = Fnv(0xcbf2_9ce4_8422_2325);
    for (name, path) in named {
        let bytes = std::fs::read(&path).unwrap_or_default();
        hash.eat(name.as_bytes());
        // With the length, no two different lists of files give the same bytes.
        hash.eat(&(bytes.len() as u64).to_le_bytes());
        hash.eat(&bytes);
    }
    println!("cargo:rustc-env=STICTION_BUILD={:016x}", hash.0);
}

fn gather(path: &Path, files: &mut Vec<PathBuf>) {
    match std::fs::read_dir(path) {
        Ok(entries) => entries.flatten().for_each(|entry| gather(&entry.path(), files)),
        Err(_) if path.is_file() => files.push(path.to_owned()),
        Err(_) => {}
    }
}

/// The same on every system.
fn name_of(path: &Path, root: &Path) -> String {
    let below = path.strip_prefix(root).unwrap_or(path);
    below.components().map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}
