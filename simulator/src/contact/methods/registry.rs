//! The contact methods of this crate. A new method needs a file with its [`MethodDescriptor`] and a
//! line in [`METHODS`]. Scenarios, schemas, combination rules and reports read the descriptor.

use super::contact_method::{ContactMethod, ContactSolver, Scheme};
use super::exact::ExactParameters;
use super::islands::Islands;
use super::lcp::LcpParameters;
use super::ncp::NcpParameters;
use super::penalty::PenaltyParameters;
use super::{exact, lcp, ncp, one_step, penalty};
use crate::contact::model::problem::Problem;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// All methods, in the order of tables, schemas and colours.
pub const METHODS: [&MethodDescriptor; 5] =
    [&exact::DESCRIPTOR, &one_step::DESCRIPTOR, &penalty::DESCRIPTOR, &lcp::DESCRIPTOR, &ncp::DESCRIPTOR];

/// Properties of a method for scenarios and reports.
#[derive(Debug)]
pub struct MethodDescriptor {
    /// Name in scenarios, logs and tables.
    pub name: &'static str,
    /// One sentence for schemas and pages.
    pub doc: &'static str,
    /// Why it only runs with the integrator `semi-implicit`; none if it runs with all integrators.
    pub only_semi_implicit: Option<&'static str>,
    /// Does it apply restitution where events are located?
    pub restitution: bool,
    /// Why states cannot be imposed on soles; none if they can.
    pub unforced: Option<&'static str>,
    /// Why point contacts have no torsional and rolling friction; none if they can.
    pub momentless: Option<&'static str>,
    /// SVG colour of its curves in reports.
    pub colour: &'static str,
    /// Do its parameters differ from their defaults?
    pub is_configured: fn(&MethodParameters) -> bool,
    /// Unknowns of its dense problem for a number of vertices; none if memory does not limit it.
    pub unknowns: Option<fn(&MethodParameters, usize) -> usize>,
    /// Its solver for problems of the size of `p`.
    pub solver: fn(&MethodParameters, &Problem) -> Box<dyn ContactSolver>,
}

impl MethodDescriptor {
    /// The method named `name`.
    pub fn named(name: &str) -> Option<&'static Self> {
        METHODS.into_iter().find(|method| method.name == name)
    }

    /// The method with parameters.
    pub fn with(&'static self, parameters: MethodParameters) -> Box<dyn ContactMethod> {
        Box::new(RegisteredMethod { descriptor: self, parameters })
    }
}

/// Parameters of all methods; each method reads its own.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MethodParameters {
    /// Search of `exact`.
    pub exact: ExactParameters,
    /// Springs and dampers of `penalty`.
    pub penalty: PenaltyParameters,
    /// Friction directions of `lcp`.
    pub lcp: LcpParameters,
    /// Sweeps of `ncp`.
    pub ncp: NcpParameters,
}

/// A method of [`METHODS`] with parameters.
#[derive(Debug)]
struct RegisteredMethod {
    descriptor: &'static MethodDescriptor,
    parameters: MethodParameters,
}

impl ContactMethod for RegisteredMethod {
    fn name(&self) -> &str {
        self.descriptor.name
    }

    fn solver(&self, p: &Problem) -> Box<dyn ContactSolver> {
        let (make, parameters) = (self.descriptor.solver, self.parameters);
        let whole = make(&parameters, p);
        // Compliant contacts do not act on each other within a problem.
        if p.soles.len() < 2 || whole.scheme() == Scheme::Compliant {
            return whole;
        }
        Box::new(Islands::new(p, whole, Arc::new(move |p| make(&parameters, p))))
    }

    fn parameters(&self) -> MethodParameters {
        self.parameters
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_colours_are_distinct() {
        for (i, method) in METHODS.iter().enumerate() {
            assert!(METHODS[..i].iter().all(|other| other.name != method.name && other.colour != method.colour));
            assert_eq!(MethodDescriptor::named(method.name).unwrap().colour, method.colour);
            assert!(!(method.is_configured)(&MethodParameters::default()), "{}", method.name);
        }
        assert!(MethodDescriptor::named("exactly").is_none());
    }
}
