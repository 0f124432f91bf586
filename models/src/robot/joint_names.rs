//! Joints by their names in a robot file.

use toml::Spanned;

use super::model::Model;
use super::robot_error::{FileError, RobotError};
use crate::text::source::Source;

/// The index of a moving joint.
pub(super) fn joint_index(name: &Spanned<String>, source: &Source, model: &Model) -> Result<usize, RobotError> {
    model.joint(name.get_ref()).map(|id| id.0).ok_or_else(|| {
        let fault = FileError::new(source, name.span(), format!("the URDF has no moving joint `{}`", name.get_ref()));
        let known = model.joints.iter().map(|j| j.name.as_str());
        fault.element(format!("joint `{}`", name.get_ref())).suggest(name.get_ref(), known).invalid()
    })
}
