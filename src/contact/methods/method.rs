//! What a contact method offers the simulator. A new method is one file that implements [`Method`] and one line in
//! [`make`].

use crate::contact::methods::exact::Exact;
use crate::contact::methods::lcp::{Lcp, LcpParameters};
use crate::contact::methods::ncp::{Ncp, NcpParameters};
use crate::contact::methods::one_step::OneStep;
use crate::contact::methods::penalty::{Penalty, PenaltyParameters};
use crate::contact::model::problem::Problem;
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{SoleState, States};
use crate::contact::search::judge::Rules;
use crate::contact::search::select::Selection;
use serde::{Deserialize, Serialize};

/// Names of the methods that [`make`] knows.
pub const NAMES: [&str; 5] = ["exact", "one-step", "penalty", "lcp", "ncp"];

/// What the methods can be told; each reads its own part.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Parameters {
    /// Of `penalty`.
    pub penalty: PenaltyParameters,
    /// Of `lcp`.
    pub lcp: LcpParameters,
    /// Of `ncp`.
    pub ncp: NcpParameters,
}

/// The method of that name for problems of this size.
pub fn make(name: &str, parameters: &Parameters, p: &Problem) -> Option<Box<dyn Method>> {
    match name {
        "exact" => Some(Box::new(Exact::new(p))),
        "one-step" => Some(Box::new(OneStep::new(p))),
        "penalty" => Some(Box::new(Penalty::new(p, parameters.penalty))),
        "lcp" => Some(Box::new(Lcp::new(parameters.lcp, p))),
        "ncp" => Some(Box::new(Ncp::new(parameters.ncp, p))),
        _ => None,
    }
}

/// What a choice of states starts from.
#[derive(Clone, Copy)]
pub struct Question<'a> {
    /// Tolerances, the states before, and which of them an event has put in doubt.
    pub rules: &'a Rules,
    /// False when nothing has happened since the states before were chosen.
    pub event: bool,
    /// Which states each sole may take (forced states of a scenario).
    pub allowed: &'a dyn Fn(usize, SoleState) -> bool,
}

/// How a method meets time, and what the simulator does for it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Manner {
    /// Searches for valid states: events are located, impacts are problems of their own, a step closes its gaps.
    Searching,
    /// Decides from what is at hand at the start of each step, and then holds what it decided.
    Deciding,
    /// Gives forces for the present places and velocities, whatever they are: nothing is clamped, no velocity jumps, its
    /// states are labels.
    Compliant,
    /// Knows only the velocities at the end of a fixed step and the impulses over it: it has no forces in between, chooses
    /// no states beforehand, and says itself what each vertex carries.
    Stepping,
}

/// Energy that a compliant method holds in its springs.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Stored {
    /// The energy, J.
    pub energy: f64,
    /// How fast it grows with the present velocities, W.
    pub power: f64,
}

/// A contact method: decides states, answers with wrenches.
pub trait Method: Send {
    /// How it meets time.
    fn manner(&self) -> Manner;

    /// Does it want its events located, or does it look only at the start of each step?
    fn locates_events(&self) -> bool {
        self.manner() == Manner::Searching
    }

    /// Are the vertex forces of its solutions its own? Else those of static soles are shared out of their wrenches.
    fn gives_vertex_forces(&self) -> bool {
        matches!(self.manner(), Manner::Compliant | Manner::Stepping)
    }

    /// Chooses the states at the acceleration level and leaves their wrenches in `out`, which holds the last known
    /// solution on entry.
    fn select(&mut self, p: &mut Problem, question: &Question, out: &mut Solution) -> Selection;

    /// Chooses states and impulses at the velocity level: an impact, or a step of a time-stepping integrator.
    fn impulse(&mut self, p: &mut Problem, question: &Question, out: &mut Solution) -> Selection;

    /// Wrenches for states held fixed, with the directions that stand in the problem: called at every evaluation.
    fn respond(&mut self, p: &Problem, states: &States, out: &mut Solution);

    /// What its springs hold with the vertices where they are.
    fn stored(&self, _: &Problem) -> Stored {
        Stored::default()
    }
}
