//! Where the values of runs come from: distributions, and the points at which they are evaluated.
//!
//! Every value is the quantile of a point in (0, 1). Points are independent, from a Latin hypercube
//! (McKay, Beckman & Conover 1979), or from a Sobol sequence with the direction numbers of Joe &
//! Kuo 2008, shifted by a random number modulo 1 (Cranley & Patterson 1976).

use cosim_core::scenario::{Random, normal_quantile};
use cosim_core::table::Table;

/// The distribution of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Distribution {
    Normal {
        mean: f64,
        sigma: f64,
        min: f64,
        max: f64,
    },
    Uniform {
        min: f64,
        max: f64,
    },
    LogUniform {
        min: f64,
        max: f64,
    },
    /// One of these texts, with equal probability.
    Choice(Vec<String>),
    /// An integer with equal probability, both ends included.
    Discrete {
        min: i64,
        max: i64,
    },
}

/// The points at which the distributions are evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Design {
    #[default]
    Random,
    LatinHypercube,
    Sobol,
}

pub(super) const DESIGNS: [(&str, Design); 3] = [
    ("random", Design::Random),
    ("latin-hypercube", Design::LatinHypercube),
    ("sobol", Design::Sobol),
];

pub(super) const KINDS: [&str; 5] = ["normal", "uniform", "log-uniform", "choice", "discrete"];

impl Distribution {
    /// From a table of the file; `None` if that is wrong.
    pub(super) fn read(table: &Table<'_>) -> Option<Self> {
        let kind = table.needed_text("kind")?;
        match kind {
            "normal" => {
                table.allow(&["kind", "mean", "sigma", "min", "max"]);
                let (mean, sigma) = (table.needed_number("mean"), table.needed_positive("sigma"));
                let bound = |key: &str, none| table.get(key).map_or(Some(none), |b| b.number());
                let (min, max) = (bound("min", -f64::INFINITY)?, bound("max", f64::INFINITY)?);
                Self::bounded(table, min, max)?;
                Some(Self::Normal { mean: mean?, sigma: sigma?, min, max })
            }
            "uniform" | "log-uniform" => {
                table.allow(&["kind", "min", "max"]);
                let (min, max) = (table.needed_number("min"), table.needed_number("max"));
                let (min, max) = (min?, max?);
                Self::bounded(table, min, max)?;
                if kind == "uniform" {
                    return Some(Self::Uniform { min, max });
                }
                if min <= 0.0 {
                    table.wrong("'min' must be greater than 0: its logarithm is varied");
                    return None;
                }
                Some(Self::LogUniform { min, max })
            }
            "choice" => {
                table.allow(&["kind", "of"]);
                let list = table.get("of").map(|entry| entry.list()).unwrap_or_default();
                let values: Vec<String> = list.iter().filter_map(|v| v.start_value()).collect();
                if values.len() < 2 {
                    table.wrong("'of' must be a list of at least two values: it has no spread");
                    return None;
                }
                Some(Self::Choice(values))
            }
            "discrete" => {
                table.allow(&["kind", "min", "max"]);
                let (min, max) = (table.needed_number("min"), table.needed_number("max"));
                let (min, max) = (min?, max?);
                Self::bounded(table, min, max)?;
                Some(Self::Discrete { min: min.ceil() as i64, max: max.floor() as i64 })
            }
            other => {
                let help = cosim_base::names::did_you_mean(other, KINDS)
                    .unwrap_or_else(|| format!("known are {}", KINDS.join(", ")));
                table.wrong(format!("there is no distribution '{other}'; {help}"));
                None
            }
        }
    }

    fn bounded(table: &Table<'_>, min: f64, max: f64) -> Option<()> {
        if min < max {
            return Some(());
        }
        table.wrong(format!("'min' {min} is not below 'max' {max}: it has no spread"));
        None
    }

    /// The quantile at a point in (0, 1), as the text of a start value.
    pub(super) fn quantile(&self, point: f64) -> String {
        match self {
            Self::Normal { mean, sigma, min, max } => {
                // Truncated: the part of the distribution between the bounds.
                let below = |bound: f64| normal_probability((bound - mean) / sigma);
                let (low, high) = (below(*min), below(*max));
                let value = mean + sigma * normal_quantile(low + point * (high - low));
                value.clamp(*min, *max).to_string()
            }
            Self::Uniform { min, max } => (min + point * (max - min)).to_string(),
            Self::LogUniform { min, max } => {
                let (low, high) = (libm::log(*min), libm::log(*max));
                libm::exp(low + point * (high - low)).clamp(*min, *max).to_string()
            }
            Self::Choice(values) => values[part(point, values.len())].clone(),
            Self::Discrete { min, max } => {
                let count = (max - min + 1).max(1) as usize;
                (min + part(point, count) as i64).to_string()
            }
        }
    }
}

/// Which of this many equal parts a point lies in.
fn part(point: f64, count: usize) -> usize {
    ((point * count as f64) as usize).min(count - 1)
}

/// The standard normal distribution function.
pub(super) fn normal_probability(z: f64) -> f64 {
    0.5 * libm::erfc(-z / std::f64::consts::SQRT_2)
}

/// The points of a campaign: one coordinate for each varied parameter.
pub(super) struct Points {
    design: Design,
    seed: u64,
    /// For each coordinate of a Latin hypercube: in which part the points lie.
    parts: Vec<Vec<usize>>,
}

/// The first component of the addresses of random streams, after the root seed.
const POINTS: u64 = 0x706f_696e_7473;

impl Points {
    /// For `count` points with this many coordinates.
    pub(super) fn new(design: Design, seed: u64, coordinates: usize, count: usize) -> Self {
        let permutation = |coordinate: usize| {
            let mut stream = Random::new(&[seed, POINTS, 0, coordinate as u64]);
            let mut parts: Vec<usize> = (0..count).collect();
            for last in (1..count).rev() {
                parts.swap(last, stream.below(last + 1));
            }
            parts
        };
        let parts = match design {
            Design::LatinHypercube => (0..coordinates).map(permutation).collect(),
            _ => Vec::new(),
        };
        Self { design, seed, parts }
    }

    /// The maximum number of coordinates of a design.
    pub(super) fn most(design: Design) -> usize {
        if design == Design::Sobol { SOBOL.len() + 1 } else { usize::MAX }
    }

    /// One coordinate of a point.
    pub(super) fn at(&self, point: usize, coordinate: usize) -> f64 {
        let own =
            |number: u64| Random::new(&[self.seed, POINTS, number, coordinate as u64]).uniform();
        match self.design {
            Design::Random => own(point as u64 + 2),
            Design::LatinHypercube => {
                let parts = &self.parts[coordinate];
                (parts[point] as f64 + own(point as u64 + 2)) / parts.len() as f64
            }
            Design::Sobol => {
                let shifted = sobol(point as u32, coordinate) + own(1);
                (shifted - shifted.floor()).max(f64::MIN_POSITIVE)
            }
        }
    }
}

/// Degree and coefficients of primitive polynomials, and the first direction numbers, from the
/// table new-joe-kuo-6.21201 of Joe & Kuo, for the coordinates from the second on.
const SOBOL: [(u32, u32, &[u32]); 9] = [
    (1, 0, &[1]),
    (2, 1, &[1, 3]),
    (3, 1, &[1, 3, 1]),
    (3, 2, &[1, 1, 1]),
    (4, 1, &[1, 1, 3, 3]),
    (4, 4, &[1, 3, 5, 13]),
    (5, 2, &[1, 1, 5, 5, 17]),
    (5, 4, &[1, 1, 5, 5, 5]),
    (5, 7, &[1, 1, 7, 11, 19]),
];

/// One coordinate of a point of the Sobol sequence, in [0, 1).
fn sobol(point: u32, coordinate: usize) -> f64 {
    const BITS: usize = 32;
    let mut directions = [0_u32; BITS];
    if coordinate == 0 {
        (0..BITS).for_each(|bit| directions[bit] = 1 << (BITS - 1 - bit));
    } else {
        let (degree, coefficients, first) = SOBOL[coordinate - 1];
        let degree = degree as usize;
        for bit in 0..BITS {
            directions[bit] = if bit < degree {
                first[bit] << (BITS - 1 - bit)
            } else {
                let old = directions[bit - degree];
                (1..degree).fold(old ^ (old >> degree), |value, k| {
                    let used = coefficients >> (degree - 1 - k) & 1;
                    value ^ (used * directions[bit - k])
                })
            };
        }
    }
    // In Gray code order the points are the same, and so are any first 2^k of them.
    let gray = point ^ (point >> 1);
    let bits = (0..BITS).filter(|bit| gray >> bit & 1 == 1);
    f64::from(bits.fold(0, |value, bit| value ^ directions[bit])) / 4_294_967_296.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sobol_sequence_is_that_of_scipy() {
        // scipy.stats.qmc.Sobol(4, scramble=False).random(8)
        let wanted = [
            [0.0, 0.0, 0.0, 0.0],
            [0.5, 0.5, 0.5, 0.5],
            [0.75, 0.25, 0.25, 0.25],
            [0.25, 0.75, 0.75, 0.75],
            [0.375, 0.375, 0.625, 0.875],
            [0.875, 0.875, 0.125, 0.375],
            [0.625, 0.125, 0.875, 0.625],
            [0.125, 0.625, 0.375, 0.125],
        ];
        for (point, wanted) in wanted.iter().enumerate() {
            for (coordinate, wanted) in wanted.iter().enumerate() {
                assert_eq!(sobol(point as u32, coordinate), *wanted, "{point} {coordinate}");
            }
        }
        // For 2^k points, each coordinate has one point in each of 2^k parts.
        for coordinate in 0..Points::most(Design::Sobol) {
            let mut parts: Vec<u32> =
                (0..64).map(|point| (sobol(point, coordinate) * 64.0) as u32).collect();
            parts.sort_unstable();
            assert_eq!(parts, (0..64).collect::<Vec<_>>(), "{coordinate}");
        }
    }

    #[test]
    fn a_latin_hypercube_has_one_point_in_each_part_of_each_coordinate() {
        let points = Points::new(Design::LatinHypercube, 3, 2, 50);
        for coordinate in 0..2 {
            let mut parts: Vec<usize> =
                (0..50).map(|point| (points.at(point, coordinate) * 50.0) as usize).collect();
            assert_ne!(parts, (0..50).collect::<Vec<_>>());
            parts.sort_unstable();
            assert_eq!(parts, (0..50).collect::<Vec<_>>());
        }
    }

    #[test]
    fn random_points_are_those_of_their_number_alone() {
        let (few, many) =
            (Points::new(Design::Random, 3, 2, 5), Points::new(Design::Random, 3, 9, 500));
        assert_eq!(few.at(4, 1), many.at(4, 1));
        assert_ne!(few.at(4, 1), few.at(4, 0));
    }

    #[test]
    fn quantiles_are_those_of_their_distributions() {
        let number = |d: &Distribution, p| d.quantile(p).parse::<f64>().unwrap();
        let normal = Distribution::Normal {
            mean: 1.0,
            sigma: 2.0,
            min: f64::NEG_INFINITY,
            max: f64::INFINITY,
        };
        assert!((number(&normal, 0.975) - 4.919_927_969_080_108).abs() < 1e-12);
        let cut = Distribution::Normal { mean: 0.0, sigma: 1.0, min: 0.0, max: 1.0 };
        // scipy.stats.truncnorm(0, 1).ppf(0.5)
        assert!((number(&cut, 0.5) - 0.441_770_546_686_581).abs() < 1e-9);
        let log = Distribution::LogUniform { min: 0.01, max: 1.0 };
        assert!((number(&log, 0.5) - 0.1).abs() < 1e-15);
        let choice = Distribution::Choice(vec!["a".into(), "b".into()]);
        assert_eq!((choice.quantile(0.49).as_str(), choice.quantile(0.999_999)), ("a", "b".into()));
        let dice = Distribution::Discrete { min: 1, max: 6 };
        assert_eq!((dice.quantile(1e-9), dice.quantile(1.0 - 1e-16)), ("1".into(), "6".into()));
    }
}
