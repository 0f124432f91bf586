//! The exact method: searches for a valid contact state, in continuous time at events only, with
//! fixed steps once per step for the velocities at its end.

use crate::contact::methods::contact_method::{ContactSolver, Scheme, SelectionInput};
use crate::contact::methods::registry::MethodDescriptor;
use crate::contact::model::problem::{Problem, Vertex};
use crate::contact::model::solution::Solution;
use crate::contact::model::state::{Mode, Pattern, SoleState, States};
use crate::contact::search::judge::STILL;
use crate::contact::search::moves::first_mode;
use crate::contact::search::select::{SearchOrder, Selection, Selector};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Descriptor for scenarios and reports.
pub const DESCRIPTOR: MethodDescriptor = MethodDescriptor {
    name: "exact",
    doc: "Exact Coulomb friction: contact states are tested until one is consistent.",
    only_semi_implicit: None,
    restitution: true,
    unforced: None,
    momentless: None,
    colour: "#0B62A4",
    is_configured: |parameters| parameters.exact != ExactParameters::default(),
    unknowns: None,
    solver: |parameters, p| Box::new(Exact::new(parameters.exact, p)),
};

/// Parameters of method `exact`.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ExactParameters {
    /// How it finds the contact states.
    pub search: SearchOrder,
}

/// Solver of the method.
#[derive(Clone)]
pub struct Exact {
    selector: Selector,
}

impl Exact {
    /// For problems of this size.
    pub fn new(parameters: ExactParameters, p: &Problem) -> Self {
        Exact { selector: Selector::new(parameters.search, p) }
    }

    /// The previous patterns, with the modes that the velocities allow.
    fn carry_over(p: &Problem, before: &States) -> States {
        let mut start = before.clone();
        for s in 0..p.soles.len() {
            let keeps_turning = match before[s].mode {
                Mode::Pivoting(j) => before[s].is_dynamic() && !p.soles[s].vertices[j as usize].moving,
                _ => false,
            };
            let fresh = first_mode(p, s, before[s].pattern);
            start.set(s, if keeps_turning && fresh.is_dynamic() { before[s] } else { fresh });
        }
        start
    }
}

impl ContactSolver for Exact {
    fn copy(&self) -> Option<Box<dyn ContactSolver>> {
        Some(Box::new(self.clone()))
    }

    fn scheme(&self) -> Scheme {
        Scheme::EventDriven
    }

    fn select(&mut self, p: &mut Problem, input: &SelectionInput, out: &mut Solution) -> Selection {
        let tol = &input.rules.tolerances;
        let stops = input.rules.stops;
        for v in p.soles.iter_mut().flat_map(|s| &mut s.vertices) {
            v.moving |= !stops && v.velocity.xy().norm() > STILL;
            // A vertex about to be clamped out of a slow motion has its velocity settled first.
            v.settles = stops && v.moving && v.velocity.z.abs() > tol.rest && v.velocity.xy().norm() <= tol.velocity;
            v.moving &= !v.settles;
            if v.moving {
                v.direction = v.velocity.xy().normalize();
            }
        }
        // The vertices of a sole that stops do so together, up to the resolution of the integrator.
        for (s, sole) in p.soles.iter_mut().enumerate() {
            let (state, k) = (input.rules.previous[s], sole.vertices.len());
            let clamped = |i: &usize| state.clamps(*i, k);
            let fastest = (0..k).filter(clamped).map(|i| sole.vertices[i].velocity.xy().norm()).fold(0.0, f64::max);
            let slow = 10.0 * tol.rest;
            if stops && state.is_dynamic() && fastest <= slow {
                // Others that touch the floor are at rest by the same resolution.
                let rests = |v: &Vertex| v.is_near(tol) && v.velocity.xy().norm() <= slow;
                for (i, v) in sole.vertices.iter_mut().enumerate() {
                    if state.clamps(i, k) || rests(v) {
                        v.settles |= v.moving;
                        v.moving = false;
                    }
                }
            }
        }
        let start = Self::carry_over(p, &input.rules.previous);
        let start = replace_forbidden(p, start, input);
        self.selector.select(p, &[start], input, out)
    }

    fn impulse(&mut self, p: &mut Problem, input: &SelectionInput, out: &mut Solution) -> Selection {
        // Start with all vertices that touch and do not already leave; in a fixed step, first with the
        // previous states and with soles that slide on. Where static friction is greater than
        // kinetic, rest comes first.
        let mut start = input.rules.previous.clone();
        let (mut continued, mut previous_states) = (start.clone(), start.clone());
        let mut rest_first = false;
        for (s, sole) in p.soles.iter().enumerate() {
            let approaches = |i: usize| {
                let v = &sole.vertices[i];
                v.near && p.vertex_motion(&p.b, s, i).z < sole.vertex_target(i)
            };
            let k = sole.vertices.len();
            let previous = input.rules.previous[s];
            let pattern = Pattern::covering(k, |i| approaches(i) || (previous.clamps(i, k) && sole.vertices[i].near));
            let fixed = SoleState::fixed(pattern);
            start.set(s, fixed);
            let slides_on = !input.event && previous.is_dynamic() && pattern != Pattern::Free;
            let mode = if previous.pattern == pattern { previous.mode } else { Mode::Sliding };
            continued.set(s, if slides_on { SoleState { pattern, mode } } else { fixed });
            let reaches = (0..k).all(|i| !previous.clamps(i, k) || sole.vertices[i].near);
            let remains = !input.event && previous != SoleState::FREE && reaches;
            previous_states.set(s, if remains { previous } else { continued[s] });
            let clamped = sole.vertices.iter().enumerate().filter(|(i, _)| continued[s].clamps(*i, k));
            rest_first |= slides_on && clamped.into_iter().any(|(_, v)| v.mu_s > v.mu_k);
        }
        let start = replace_forbidden(p, start, input);
        let continued = replace_forbidden(p, continued, input);
        let previous_states = replace_forbidden(p, previous_states, input);
        let starts = if rest_first { [start, previous_states, continued] } else { [previous_states, continued, start] };
        // Equal ones are tested once.
        self.selector.select(p, &starts, input, out)
    }

    fn point_impulse(&mut self, p: &Problem, out: &mut Solution) -> Option<States> {
        // A point carries no moment.
        if p.has_turning() { None } else { self.selector.solve_points(p, out) }
    }

    fn respond(&mut self, p: &Problem, states: &States, out: &mut Solution) {
        self.selector.solver().solve(p, states, out);
    }
}

/// Replaces each state that is not allowed by the first allowed one.
fn replace_forbidden(p: &Problem, mut states: States, input: &SelectionInput) -> States {
    for (s, sole) in p.soles.iter().enumerate() {
        if !(input.allowed)(s, states[s]) {
            let k = sole.vertices.len();
            states[s] = SoleState::all(k).find(|&x| (input.allowed)(s, x)).unwrap_or(states[s]);
        }
    }
    states
}
