//! The quantile of the standard normal distribution.

/// Least probability that is distinguished: half of what a coordinate of a point resolves.
const LEAST: f64 = 1.0 / (1_u64 << 25) as f64;

/// The value that a standard normal variable is below with probability `p`; `p` is taken to be
/// within `LEAST` of the open interval from 0 to 1.
///
/// Relative error about 1e-16: algorithm AS 241, PPND16 (M. J. Wichura, *Applied Statistics* 37,
/// 1988). With `libm` it has the same bits on every machine.
pub(super) fn quantile(p: f64) -> f64 {
    let p = p.clamp(LEAST, 1.0 - LEAST);
    let q = p - 0.5;
    if q.abs() <= 0.425 {
        let r = 0.180_625 - q * q;
        return q * ratio(r, &CENTRE);
    }
    let r = libm::sqrt(-libm::log(if q < 0.0 { p } else { 1.0 - p }));
    let size = if r <= 5.0 { ratio(r - 1.6, &MIDDLE) } else { ratio(r - 5.0, &TAIL) };
    if q < 0.0 { -size } else { size }
}

/// A polynomial over another one, by Horner's rule; coefficients ascend.
fn ratio(r: f64, [over, under]: &[[f64; 8]; 2]) -> f64 {
    let value = |of: &[f64; 8]| of.iter().rev().fold(0.0, |sum, c| sum * r + c);
    value(over) / value(under)
}

const CENTRE: [[f64; 8]; 2] = [
    [
        3.387_132_872_796_366_5,
        133.141_667_891_784_38,
        1_971.590_950_306_551_3,
        13_731.693_765_509_46,
        45_921.953_931_549_87,
        67_265.770_927_008_7,
        33_430.575_583_588_13,
        2_509.080_928_730_122_7,
    ],
    [
        1.0,
        42.313_330_701_600_91,
        687.187_007_492_057_9,
        5_394.196_021_424_751,
        21_213.794_301_586_597,
        39_307.895_800_092_71,
        28_729.085_735_721_943,
        5_226.495_278_852_545,
    ],
];

const MIDDLE: [[f64; 8]; 2] = [
    [
        1.423_437_110_749_683_5,
        4.630_337_846_156_546,
        5.769_497_221_460_691,
        3.647_848_324_763_204_5,
        1.270_458_252_452_368_4,
        0.241_780_725_177_450_6,
        0.022_723_844_989_269_184,
        7.745_450_142_783_414e-4,
    ],
    [
        1.0,
        2.053_191_626_637_759,
        1.676_384_830_183_803_8,
        0.689_767_334_985_1,
        0.148_103_976_427_480_08,
        0.015_198_666_563_616_457,
        5.475_938_084_995_345e-4,
        1.050_750_071_644_416_9e-9,
    ],
];

const TAIL: [[f64; 8]; 2] = [
    [
        6.657_904_643_501_103,
        5.463_784_911_164_114,
        1.784_826_539_917_291_3,
        0.296_560_571_828_504_87,
        0.026_532_189_526_576_124,
        0.001_242_660_947_388_078_4,
        2.711_555_568_743_487_6e-5,
        2.010_334_399_292_288_1e-7,
    ],
    [
        1.0,
        0.599_832_206_555_888,
        0.136_929_880_922_735_8,
        0.014_875_361_290_850_615,
        7.868_691_311_456_133e-4,
        1.846_318_317_510_054_8e-5,
        1.421_511_758_316_446e-7,
        2.044_263_103_389_939_8e-15,
    ],
];

#[cfg(test)]
mod tests {
    use super::*;

    /// The distribution function of the quantile of p is p.
    #[test]
    fn it_is_the_inverse_of_the_distribution_function() {
        for k in 1..20_000_u32 {
            let p = f64::from(k) / 20_000.0;
            let below = 0.5 * libm::erfc(-quantile(p) / core::f64::consts::SQRT_2);
            assert!((below - p).abs() < 1e-14, "{p}: {below}");
        }
        for p in [LEAST, 1e-6, 1e-4, 1e-3] {
            let below = 0.5 * libm::erfc(-quantile(p) / core::f64::consts::SQRT_2);
            assert!((below / p - 1.0).abs() < 1e-12, "{p}: {below}");
            // 1 - p is not exact.
            let apart = quantile(p) + quantile(1.0 - p);
            assert!(apart.abs() < 1e-8, "{p}: {apart}");
        }
        assert_eq!(quantile(0.5), 0.0);
        assert!(quantile(0.0).is_finite() && quantile(1.0).is_finite());
    }
}
