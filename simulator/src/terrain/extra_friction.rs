//! Friction of a surface that Coulomb's coefficients do not describe: viscous slip, and the torsional and
//! rolling friction of point contacts (`docs/contact.md`, section 21).

/// Terms that a surface may have besides its static and kinetic coefficient; those left out are none.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct ExtraFriction {
    /// Increase of the kinetic coefficient with the slip speed, s/m.
    pub viscous: Option<f64>,
    /// Greatest torsional moment of a point contact over its normal force, m.
    pub torsional: Option<f64>,
    /// Greatest rolling moment of a point contact over its normal force, m.
    pub rolling: Option<f64>,
}

impl ExtraFriction {
    /// Of each term the smaller of both, or that of the only surface that has it.
    pub fn smaller(self, other: ExtraFriction) -> ExtraFriction {
        let least = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
        ExtraFriction {
            viscous: least(self.viscous, other.viscous),
            torsional: least(self.torsional, other.torsional),
            rolling: least(self.rolling, other.rolling),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_two_surfaces_the_smaller_of_the_given_terms_count() {
        let a = ExtraFriction { viscous: Some(0.2), torsional: Some(0.01), rolling: None };
        let b = ExtraFriction { viscous: Some(0.1), torsional: None, rolling: None };
        let both = ExtraFriction { viscous: Some(0.1), torsional: Some(0.01), rolling: None };
        assert_eq!((a.smaller(b), b.smaller(a)), (both, both));
    }
}
