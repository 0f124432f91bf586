//! Elementary functions with the same bits on every processor, of the crate `libm`.
//!
//! The methods of `f64` (`sin`, `exp`, `powf`, ...) call the system's library, which chooses an
//! implementation by processor and version; their last bits differ. `clippy.toml` forbids them.
//! `sqrt`, `mul_add`, rounding and `%` are exact by IEEE 754 and remain methods.
//!
//! Imports: no other room. Used by: `geometry`, `integrate`, `random`, `robot`, `dynamics`,
//! `motion`, `patches`, `contact`, `collision`, `task`, `force`, `script`, `policy`, `scenario`, `sim`, `log`, `assemble`,
//! `convert`, `statistics`, `search`, `results`, `report`, `fit`.

pub use libm::{acos, asin, atan, atan2, cbrt, cosh, erfc, exp, hypot, log2, log10, sinh, tan, tanh};
pub use libm::{cos, sin, sincos as sin_cos};
pub use libm::{expm1 as exp_m1, lgamma as ln_gamma, log as ln, pow as powf};

/// `x` to a whole power by repeated squaring; the method of `f64` leaves the order to the compiler.
#[inline]
pub fn powi(x: f64, n: i32) -> f64 {
    let (mut result, mut square, mut rest) = (1.0, x, n.unsigned_abs());
    loop {
        if rest & 1 == 1 {
            result *= square;
        }
        rest >>= 1;
        if rest == 0 {
            return if n < 0 { 1.0 / result } else { result };
        }
        square *= square;
    }
}

/// The greater of two numbers; NaN if one of them is NaN. The method `max` of `f64` ignores NaN, so an error
/// that cannot be computed would not count.
#[inline]
pub fn greater(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_greater_of_nan_and_a_number_is_nan() {
        assert_eq!((greater(1.0, 2.0), greater(2.0, -1.0)), (2.0, 2.0));
        assert!(greater(f64::NAN, 1.0).is_nan() && greater(1.0, f64::NAN).is_nan());
    }

    #[test]
    fn whole_powers_are_products() {
        for x in [-3.0, 0.1, 0.5, 2.0, 7.0] {
            assert_eq!(powi(x, 0), 1.0);
            assert_eq!(powi(x, 1), x);
            assert_eq!(powi(x, 2), x * x);
            assert_eq!(powi(x, 3), x * (x * x));
            assert_eq!(powi(x, 4), (x * x) * (x * x));
            assert_eq!(powi(x, -3), 1.0 / (x * (x * x)));
        }
        assert_eq!(powi(2.0, -1022), f64::MIN_POSITIVE);
        assert_eq!(powi(1.0, i32::MIN), 1.0);
    }

    /// The expected bits are the rounded values of mpmath, computed with 300 bits; the functions may
    /// be one unit in the last place off.
    #[test]
    fn values_are_right_within_one_unit() {
        let near = |value: f64, bits: u64| assert!(value.to_bits().abs_diff(bits) <= 1, "{value:e}");
        near(sin(0.7), 0x3fe49d6e694619b8);
        near(cos(0.7), 0x3fe87996529f9d93);
        near(sin_cos(0.7).0, 0x3fe49d6e694619b8);
        near(sin_cos(0.7).1, 0x3fe87996529f9d93);
        near(tan(0.7), 0x3feaf406c2fc78ae);
        near(asin(0.7), 0x3fe8d00e692afd95);
        near(acos(0.7), 0x3fe973e83f5d5c9b);
        near(atan(2.3), 0x3ff29219a49709a1);
        near(atan2(0.7, -2.3), 0x4006c4eb3e58b1ee);
        near(exp(2.3), 0x4023f2c80aef884d);
        near(exp_m1(-0.7), 0xbfe01bf92311555f);
        near(ln(2.3), 0x3feaa73108717b69);
        near(log2(2.3), 0x3ff339e46d77d670);
        near(log10(2.3), 0x3fd7268c826fe5fc);
        near(powf(2.3, 0.7), 0x3ffca9dc35da278c);
        near(hypot(0.7, 2.3), 0x40033bb9d71f593a);
        near(cbrt(2.3), 0x3ff51ebebd3a21bc);
        near(sinh(2.3), 0x4013bf72ea61af1a);
        near(cosh(2.3), 0x4014261d2b7d6180);
        near(tanh(0.7), 0x3fe356fb17af2e91);
    }
}
