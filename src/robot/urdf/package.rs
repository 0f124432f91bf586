//! Where a mesh is.
//!
//! `package://NAME/REST` names a ROS package. There is no ROS here, so the package is looked for around the URDF: in
//! every folder above it, the folder may be the package itself or contain it.

use std::path::{Path, PathBuf};

/// The file a mesh name of a URDF in `folder` stands for; `None` when there is none.
pub(super) fn resolve(folder: &Path, filename: &str) -> Option<PathBuf> {
    if let Some(rest) = filename.strip_prefix("package://").or_else(|| filename.strip_prefix("model://")) {
        let (package, inside) = rest.split_once('/')?;
        // A relative folder has no further ancestors by name alone.
        let absolute = std::path::absolute(folder).ok()?;
        return absolute.ancestors().find_map(|above| {
            let beside = above.join(package).join(inside);
            let itself = (above.file_name()? == package).then(|| above.join(inside));
            [Some(beside), itself].into_iter().flatten().find(|path| path.is_file())
        });
    }
    let path = filename.strip_prefix("file://").unwrap_or(filename);
    let path = folder.join(path);
    path.is_file().then_some(path)
}
