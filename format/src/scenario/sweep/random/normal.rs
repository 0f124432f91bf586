//! The quantile function of the standard normal distribution, by rational approximations to 16
//! digits: algorithm AS 241 (PPND16), M. J. Wichura, Applied Statistics 37 (1988) 477. Coefficients
//! in rising powers, with the digits they were published with.

#![allow(clippy::excessive_precision)]

use crate::math;

/// Greatest |p - 1/2| at which the approximation of the middle holds.
const MIDDLE: f64 = 0.425;
/// sqrt(-ln p) at which the second approximation of the tails takes over.
const FAR: f64 = 5.0;

const MIDDLE_NUMERATOR: [f64; 8] = [
    3.387_132_872_796_366_608,
    1.331_416_678_917_843_774_5e2,
    1.971_590_950_306_551_442_7e3,
    1.373_169_376_550_946_112_5e4,
    4.592_195_393_154_987_145_7e4,
    6.726_577_092_700_870_085_3e4,
    3.343_057_558_358_812_810_5e4,
    2.509_080_928_730_122_672_7e3,
];
const MIDDLE_DENOMINATOR: [f64; 8] = [
    1.0,
    4.231_333_070_160_091_125_2e1,
    6.871_870_074_920_579_083e2,
    5.394_196_021_424_751_107_7e3,
    2.121_379_430_158_659_586_7e4,
    3.930_789_580_009_271_061e4,
    2.872_908_573_572_194_267_4e4,
    5.226_495_278_852_854_561e3,
];
const TAIL_NUMERATOR: [f64; 8] = [
    1.423_437_110_749_683_577_34,
    4.630_337_846_156_545_295_9,
    5.769_497_221_460_691_405_5,
    3.647_848_324_763_204_605_04,
    1.270_458_252_452_368_382_58,
    2.417_807_251_774_506_117_7e-1,
    2.272_384_498_926_918_458_33e-2,
    7.745_450_142_783_414_076_4e-4,
];
const TAIL_DENOMINATOR: [f64; 8] = [
    1.0,
    2.053_191_626_637_758_821_87,
    1.676_384_830_183_803_849_4,
    6.897_673_349_851_000_045_5e-1,
    1.481_039_764_274_800_745_9e-1,
    1.519_866_656_361_645_719_66e-2,
    5.475_938_084_995_344_946e-4,
    1.050_750_071_644_416_843_24e-9,
];
const FAR_NUMERATOR: [f64; 8] = [
    6.657_904_643_501_103_777_2,
    5.463_784_911_164_114_369_9,
    1.784_826_539_917_291_335_8,
    2.965_605_718_285_048_912_3e-1,
    2.653_218_952_657_612_309_3e-2,
    1.242_660_947_388_078_438_6e-3,
    2.711_555_568_743_487_578_15e-5,
    2.010_334_399_292_288_132_65e-7,
];
const FAR_DENOMINATOR: [f64; 8] = [
    1.0,
    5.998_322_065_558_879_376_9e-1,
    1.369_298_809_227_358_053_1e-1,
    1.487_536_129_085_061_485_25e-2,
    7.868_691_311_456_132_591e-4,
    1.846_318_317_510_054_681_8e-5,
    1.421_511_758_316_445_888_7e-7,
    2.044_263_103_389_939_785_64e-15,
];

/// The number below which a standard normal variable lies with probability `p`, between 0 and 1.
pub fn quantile(p: f64) -> f64 {
    let q = p - 0.5;
    if q.abs() <= MIDDLE {
        return q * ratio(&MIDDLE_NUMERATOR, &MIDDLE_DENOMINATOR, MIDDLE * MIDDLE - q * q);
    }
    let r = (-math::ln(p.min(1.0 - p))).sqrt();
    let size = if r <= FAR {
        ratio(&TAIL_NUMERATOR, &TAIL_DENOMINATOR, r - 1.6)
    } else {
        ratio(&FAR_NUMERATOR, &FAR_DENOMINATOR, r - FAR)
    };
    size.copysign(q)
}

fn ratio(numerator: &[f64; 8], denominator: &[f64; 8], x: f64) -> f64 {
    let at = |c: &[f64; 8]| c.iter().rev().fold(0.0, |sum, c| sum * x + c);
    at(numerator) / at(denominator)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Roots of the complementary error function in 40 digits, for `p` as f64 holds it.
    const QUANTILES: [(f64, f64); 10] = [
        (0.3, -0.524400512708040816),
        (0.1, -1.28155156554460044),
        (0.9, 1.28155156554460059),
        (0.07, -1.47579102817917069),
        (0.025, -1.95996398454005421),
        (0.001, -3.09023230616781354),
        (1e-10, -6.3613409024040562),
        (1e-11, -6.7060231554951363),
        (1.1102230246251565e-16, -8.20953615160138686),
        (1e-20, -9.26234008979840758),
    ];

    #[test]
    fn quantiles_to_fifteen_digits() {
        for (p, x) in QUANTILES {
            let got = quantile(p);
            // A few roundings, and the condition of the quantile itself near 1.
            assert!((got - x).abs() <= 4e-15 * x.abs(), "{p}: {got} {x}");
        }
        assert_eq!(quantile(0.5), 0.0);
    }

    #[test]
    fn it_is_odd_and_rises_across_its_three_pieces() {
        let grid: Vec<f64> = (1..4096).map(|i| f64::from(i) / 4096.0).collect();
        assert!(grid.iter().all(|p| quantile(*p) == -quantile(1.0 - p)));
        let fine = (0..2000).map(|i| 1e-12 * 10f64.powf(f64::from(i) * 11.6 / 2000.0));
        let values: Vec<f64> = fine.map(quantile).collect();
        assert!(values.windows(2).all(|w| w[0] < w[1]));
    }
}
