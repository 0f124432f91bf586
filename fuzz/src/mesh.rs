//! Mesh files, named by a URDF in the same folder; the first byte selects the kind. Mesh readers
//! open files, so the bytes are written to one.

use stiction::robot;

use super::{scratch, urdf};

/// Kinds by letter: the file's extension.
pub const KINDS: [(u8, &str); 3] = [(b's', "stl"), (b'o', "obj"), (b'd', "dae")];

/// Reads a mesh; the first byte is the letter of its kind.
pub fn take(data: &[u8]) {
    let Some((kind, bytes)) = data.split_first() else { return };
    let Some((_, extension)) = KINDS.iter().find(|(k, _)| k == kind) else { return };
    let folder = scratch::folder("mesh");
    scratch::write(&folder.join(format!("mesh.{extension}")), bytes);
    let shape = format!("<geometry><mesh filename=\"mesh.{extension}\" scale=\"1 1 -1\"/></geometry>");
    let text = format!(
        "<robot name=\"fuzzed\"><link name=\"body\"><inertial><mass value=\"1\"/>\
         <inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial>\
         <visual>{shape}</visual><collision>{shape}</collision></link></robot>"
    );
    urdf::inspect(robot::parse(&folder.join("fuzzed.urdf"), text, None));
}
