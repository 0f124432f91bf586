//! Kinds of events of a run.

use std::fmt;

/// What happened. [`EventKind::as_str`] is the kind in logs and scripts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// A free sole touches the floor.
    Touchdown,
    /// A sole loses its last contact.
    Liftoff,
    /// A static sole begins to slide.
    Slip,
    /// A sliding sole comes to rest.
    Stick,
    /// Any other change of a sole's contact state.
    State,
    /// Torsional or rolling friction of a point contact begins or ceases to hold.
    Turning,
    /// An impact.
    Impact,
    /// Sliding ended by an impulse (Painleve).
    Jam,
    /// A sliding mode begins or ends: contact states alternate faster than steps resolve, or none is found.
    SlidingMode,
    /// No valid contact state exists.
    Inconsistent,
    /// A vertex enters another friction region.
    Border,
    /// A state is imposed on a sole, or no longer imposed.
    Forced,
    /// The robot fell.
    Fallen,
    /// A task starts or ends.
    Task,
    /// An event of the scenario.
    Scenario,
    /// A link takes or releases an object.
    Object,
    /// Two bodies of the robot begin or end to overlap.
    SelfCollision,
    /// An event of a force model, by the model's kind.
    Force(&'static str),
}

impl EventKind {
    /// The kind in logs and scripts.
    pub fn as_str(self) -> &'static str {
        match self {
            EventKind::Touchdown => "touchdown",
            EventKind::Liftoff => "liftoff",
            EventKind::Slip => "slip",
            EventKind::Stick => "stick",
            EventKind::State => "state",
            EventKind::Turning => "turning",
            EventKind::Impact => "impact",
            EventKind::Jam => "jam",
            EventKind::SlidingMode => "sliding-mode",
            EventKind::Inconsistent => "inconsistent",
            EventKind::Border => "border",
            EventKind::Forced => "forced",
            EventKind::Fallen => "fallen",
            EventKind::Task => "task",
            EventKind::Scenario => "event",
            EventKind::Object => "object",
            EventKind::SelfCollision => "self-collision",
            EventKind::Force(kind) => kind,
        }
    }
}

impl fmt::Display for EventKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl PartialEq<str> for EventKind {
    fn eq(&self, other: &str) -> bool {
        self.as_str() == other
    }
}

impl PartialEq<&str> for EventKind {
    fn eq(&self, other: &&str) -> bool {
        self.as_str() == *other
    }
}
