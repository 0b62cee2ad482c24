//! Random numbers of faults and campaigns.

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// A stream of independent random numbers, the same on every machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Random(ChaCha8Rng);

impl Random {
    /// The stream with this address: others are independent of it.
    pub fn new(address: &[u64]) -> Self {
        let octets: Vec<u8> = address.iter().flat_map(|part| part.to_le_bytes()).collect();
        Self(ChaCha8Rng::from_seed(Sha256::digest(octets).into()))
    }

    /// A uniformly distributed number in (0, 1).
    pub fn uniform(&mut self) -> f64 {
        const PARTS: f64 = (1_u64 << 53) as f64;
        ((self.0.next_u64() >> 11) as f64 + 0.5) / PARTS
    }

    /// A uniformly distributed integer from 0 to below `count`.
    pub fn below(&mut self, count: usize) -> usize {
        // 64 bits times the count; the result is the part above the 64 bits (Lemire 2019, without
        // rejection: the bias is below 2^-40 for counts below 2^24).
        ((u128::from(self.0.next_u64()) * count as u128) >> 64) as usize
    }

    /// A standard normal random number.
    pub(crate) fn normal(&mut self) -> f64 {
        normal_quantile(self.uniform())
    }
}

/// The quantile of the standard normal distribution: algorithm AS 241, PPND16 (Wichura 1988), with
/// a relative error of about 1e-16.
pub fn normal_quantile(p: f64) -> f64 {
    let q = p - 0.5;
    if q.abs() <= 0.425 {
        let r = 0.180625 - q * q;
        return q * polynomial(&A, r) / polynomial(&B, r);
    }
    let r = libm::sqrt(-libm::log(if q < 0.0 { p } else { 1.0 - p }));
    let value = if r <= 5.0 {
        polynomial(&C, r - 1.6) / polynomial(&D, r - 1.6)
    } else {
        polynomial(&E, r - 5.0) / polynomial(&F, r - 5.0)
    };
    if q < 0.0 { -value } else { value }
}

/// Horner's scheme; the constant first.
fn polynomial(coefficients: &[f64; 8], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

const A: [f64; 8] = [
    3.387_132_872_796_366_5,
    1.331_416_678_917_843_8e2,
    1.971_590_950_306_551_3e3,
    1.373_169_376_550_946e4,
    4.592_195_393_154_987e4,
    6.726_577_092_700_87e4,
    3.343_057_558_358_813e4,
    2.509_080_928_730_122_7e3,
];
const B: [f64; 8] = [
    1.0,
    4.231_333_070_160_091e1,
    6.871_870_074_920_579e2,
    5.394_196_021_424_751e3,
    2.121_379_430_158_659_7e4,
    3.930_789_580_009_271e4,
    2.872_908_573_572_194_3e4,
    5.226_495_278_852_854e3,
];
const C: [f64; 8] = [
    1.423_437_110_749_683_5,
    4.630_337_846_156_546,
    5.769_497_221_460_691,
    3.647_848_324_763_204_5,
    1.270_458_252_452_368_4,
    2.417_807_251_774_506e-1,
    2.272_384_498_926_918_4e-2,
    7.745_450_142_783_414e-4,
];
const D: [f64; 8] = [
    1.0,
    2.053_191_626_637_759,
    1.676_384_830_183_803_8,
    6.897_673_349_851e-1,
    1.481_039_764_274_800_8e-1,
    1.519_866_656_361_645_7e-2,
    5.475_938_084_995_345e-4,
    1.050_750_071_644_416_9e-9,
];
const E: [f64; 8] = [
    6.657_904_643_501_103,
    5.463_784_911_164_114,
    1.784_826_539_917_291_3,
    2.965_605_718_285_048_7e-1,
    2.653_218_952_657_612_4e-2,
    1.242_660_947_388_078_4e-3,
    2.711_555_568_743_487_6e-5,
    2.010_334_399_292_288_1e-7,
];
const F: [f64; 8] = [
    1.0,
    5.998_322_065_558_88e-1,
    1.369_298_809_227_358e-1,
    1.487_536_129_085_061_5e-2,
    7.868_691_311_456_133e-4,
    1.846_318_317_510_054_8e-5,
    1.421_511_758_316_446e-7,
    2.044_263_103_389_939_7e-15,
];

#[cfg(test)]
mod tests {
    use super::*;

    const QUANTILES: [(f64, f64); 6] = [
        (0.975, 1.9599639845400536),
        (0.2, -0.8416212335729142),
        (0.0001, -3.71901648545568),
        (1e-12, -7.034483825301132),
        (1e-300, -37.0470962993612),
        (0.93, 1.4757910281791708),
    ];

    #[test]
    fn quantiles_are_those_of_python() {
        // statistics.NormalDist().inv_cdf
        for (p, wanted) in QUANTILES {
            let found = normal_quantile(p);
            assert!((found / wanted - 1.0).abs() < 1e-14, "{p}: {found} {wanted}");
        }
        assert_eq!(normal_quantile(0.5), 0.0);
    }

    #[test]
    fn streams_of_other_addresses_differ_and_numbers_have_their_moments() {
        let mut stream = Random::new(&[1, 2]);
        assert_ne!(stream.clone().uniform(), Random::new(&[1, 3]).uniform());
        let numbers: Vec<f64> = (0..20_000).map(|_| stream.normal()).collect();
        let mean = numbers.iter().sum::<f64>() / 2e4;
        let variance = numbers.iter().map(|n| n * n).sum::<f64>() / 2e4;
        // Six standard errors.
        assert!(mean.abs() < 0.043 && (variance - 1.0).abs() < 0.06, "{mean} {variance}");
        assert!((0..100).all(|_| stream.below(3) < 3));
    }
}
