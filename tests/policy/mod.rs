//! Tasks of type `policy`: observations, networks and actions against closed forms and other tasks.

#[cfg(feature = "policy")]
mod allocations;
#[cfg(feature = "policy")]
mod bits;
#[cfg(feature = "policy")]
mod kernels;
#[cfg(feature = "policy")]
mod laws;
#[cfg(feature = "policy")]
mod observations;
mod onnx_file;
mod refused;
#[cfg(feature = "policy")]
mod support;

use std::fs;

use crate::support::folder::Folder;

/// A folder with a network `n.onnx`.
fn folder(network: impl AsRef<[u8]>) -> Folder {
    let folder = Folder::with(&[]);
    fs::write(folder.path().join("n.onnx"), network).expect("the folder is writable");
    folder
}
