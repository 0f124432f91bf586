//! Mesh files, named by a URDF beside them; the first byte says of which kind. Readers of meshes open files, so the bytes
//! stand in one, in memory where the system has a file system there.

use std::path::PathBuf;

use stiction::robot;

use super::urdf;

/// Kinds by their letter: the file's ending.
pub const KINDS: [(u8, &str); 3] = [(b's', "stl"), (b'o', "obj"), (b'd', "dae")];

/// Takes the letter of a kind and a mesh of that kind.
pub fn take(data: &[u8]) {
    let Some((kind, bytes)) = data.split_first() else { return };
    let Some((_, ending)) = KINDS.iter().find(|(k, _)| k == kind) else { return };
    let folder = folder();
    let made =
        std::fs::create_dir_all(&folder).and_then(|()| std::fs::write(folder.join(format!("mesh.{ending}")), bytes));
    made.expect("room for a mesh");
    let shape = format!("<geometry><mesh filename=\"mesh.{ending}\" scale=\"1 1 -1\"/></geometry>");
    let text = format!(
        "<robot name=\"fuzzed\"><link name=\"body\"><inertial><mass value=\"1\"/>\
         <inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial>\
         <visual>{shape}</visual><collision>{shape}</collision></link></robot>"
    );
    urdf::look(robot::parse(&folder.join("fuzzed.urdf"), text, None));
}

fn folder() -> PathBuf {
    let memory = PathBuf::from("/dev/shm");
    let base = if memory.is_dir() { memory } else { std::env::temp_dir() };
    base.join(format!("stiction-fuzz-{}", std::process::id()))
}
