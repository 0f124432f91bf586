//! The three kinds of search behind one interface.

use super::{Bisection, Contour, Evolution, Position};

/// A search with its results.
#[derive(Clone, Debug)]
pub enum Method {
    /// A condition over one key.
    Bisection(Bisection),
    /// A condition over two keys.
    Contour(Contour),
    /// The least value over several keys.
    Evolution(Box<Evolution>),
}

/// What a probe gave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    /// Whether the condition holds.
    Holds(bool),
    /// The value; infinite if it must not be chosen.
    Value(f64),
}

impl Method {
    /// The next positions to probe; none at the end. Their results must all be added before the next
    /// call.
    pub fn next_positions(&mut self) -> Vec<Position> {
        match self {
            Method::Bisection(bisection) => bisection.next_positions().into_iter().map(|at| vec![at]).collect(),
            Method::Contour(contour) => contour.next_positions(),
            Method::Evolution(evolution) => evolution.next_positions(),
        }
    }

    /// Adds the result at a position. An answer of the other kind is ignored.
    pub fn add(&mut self, at: &[u64], answer: Answer) {
        match (self, answer) {
            (Method::Bisection(bisection), Answer::Holds(holds)) => bisection.add(at[0], holds),
            (Method::Contour(contour), Answer::Holds(holds)) => contour.add(at, holds),
            (Method::Evolution(evolution), Answer::Value(value)) => evolution.add(at, value),
            _ => {}
        }
    }
}
