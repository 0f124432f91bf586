//! The groups of topics of a log, `log.topics` of a scenario.

use std::str::FromStr;

/// The logged groups of topics. Events are always logged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TopicGroups {
    /// `/state`, `/joint_states`, `/robot_description`.
    pub state: bool,
    /// `/contact`, `/residual`.
    pub contact: bool,
    /// `/tf`, `/scene`, `/scene/contact`.
    pub scene: bool,
}

impl TopicGroups {
    /// Every group.
    pub const ALL: Self = Self { state: true, contact: true, scene: true };
    /// Events only.
    pub const NONE: Self = Self { state: false, contact: false, scene: false };

    /// The groups of these names.
    pub fn from_names<S: AsRef<str>>(names: &[S]) -> Result<Self, ParseTopicError> {
        names.iter().try_fold(Self::NONE, |all, name| {
            let one: Self = name.as_ref().parse()?;
            Ok(Self { state: all.state | one.state, contact: all.contact | one.contact, scene: all.scene | one.scene })
        })
    }
}

impl Default for TopicGroups {
    fn default() -> Self {
        Self::ALL
    }
}

impl FromStr for TopicGroups {
    type Err = ParseTopicError;

    fn from_str(name: &str) -> Result<Self, ParseTopicError> {
        match name {
            "state" => Ok(Self { state: true, ..Self::NONE }),
            "contact" => Ok(Self { contact: true, ..Self::NONE }),
            "scene" => Ok(Self { scene: true, ..Self::NONE }),
            _ => Err(ParseTopicError(name.to_owned())),
        }
    }
}

/// The error of an unknown group of topics.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("unknown log topic `{0}`: there are state, contact, scene")]
pub struct ParseTopicError(pub String);
