//! The contact methods of this crate. A new one is a file with its [`MethodDescriptor`] and a line in [`METHODS`]; scenarios,
//! schemas, rules of combination and reports read everything else from the descriptor.

use super::contact_method::{ContactMethod, ContactSolver};
use super::lcp::LcpParameters;
use super::ncp::NcpParameters;
use super::penalty::PenaltyParameters;
use super::{exact, lcp, ncp, one_step, penalty};
use crate::contact::model::problem::Problem;
use serde::{Deserialize, Serialize};

/// All methods, in the order of tables, schemas and colours.
pub const METHODS: [&MethodDescriptor; 5] =
    [&exact::DESCRIPTOR, &one_step::DESCRIPTOR, &penalty::DESCRIPTOR, &lcp::DESCRIPTOR, &ncp::DESCRIPTOR];

/// What scenarios and reports need to know of a method.
#[derive(Debug)]
pub struct MethodDescriptor {
    /// Name in scenarios, logs and tables.
    pub name: &'static str,
    /// One sentence for schemas and pages.
    pub doc: &'static str,
    /// Why it only runs with the integrator `semi-implicit`; none if it runs with all.
    pub only_semi_implicit: Option<&'static str>,
    /// Do bodies bounce with it, where events are located?
    pub restitution: bool,
    /// Why states cannot be imposed on its soles; none if they can.
    pub unforced: Option<&'static str>,
    /// Colour of its curves in reports, as SVG writes it.
    pub colour: &'static str,
    /// Have its parameters, where it has any, other values than their defaults?
    pub is_configured: fn(&MethodParameters) -> bool,
    /// Unknowns of its densest problem for so many vertices; none if memory does not limit it.
    pub unknowns: Option<fn(&MethodParameters, usize) -> usize>,
    /// Its solver for problems of the size of `p`.
    pub solver: fn(&MethodParameters, &Problem) -> Box<dyn ContactSolver>,
}

impl MethodDescriptor {
    /// The method of a name.
    pub fn named(name: &str) -> Option<&'static Self> {
        METHODS.into_iter().find(|method| method.name == name)
    }

    /// The method with parameters.
    pub fn with(&'static self, parameters: MethodParameters) -> Box<dyn ContactMethod> {
        Box::new(RegisteredMethod { descriptor: self, parameters })
    }
}

/// Parameters of all methods; each reads its own part.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MethodParameters {
    /// Springs and dampers of `penalty`.
    pub penalty: PenaltyParameters,
    /// Friction directions of `lcp`.
    pub lcp: LcpParameters,
    /// Iterations of `ncp`.
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
        (self.descriptor.solver)(&self.parameters, p)
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
            assert!(std::ptr::eq(MethodDescriptor::named(method.name).unwrap(), *method));
            assert!(!(method.is_configured)(&MethodParameters::default()), "{}", method.name);
        }
        assert!(MethodDescriptor::named("exactly").is_none());
    }
}
