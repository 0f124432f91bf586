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

/// This crate and those below it, in a workspace.
const CRATES: [&str; 6] = ["runs", "assembly", "format", "simulator", "models", "numerics"];

fn main() {
    let own = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    // A packaged crate comes alone; its `Cargo.lock` names the crates below it by their checksums.
    let workspace = own.parent().filter(|root| root.join("simulator/src").exists());
    let root = workspace.unwrap_or(&own);
    let crates = if workspace.is_some() { &CRATES[..] } else { &[""] };
    let parts = crates.iter().flat_map(|name| ["src", "Cargo.toml"].map(|part| root.join(name).join(part)));
    let mut files = Vec::new();
    for path in parts.chain([root.join("Cargo.toml"), root.join("Cargo.lock")]).filter(|path| path.exists()) {
        println!("cargo:rerun-if-changed={}", path.display());
        gather(&path, &mut files);
    }
    // The order in which a folder lists its files depends on the system.
    let mut named: Vec<(String, PathBuf)> = files.into_iter().map(|path| (name_of(&path, root), path)).collect();
    named.sort();
    named.dedup();
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
