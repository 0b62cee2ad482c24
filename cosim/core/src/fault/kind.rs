//! The kinds of faults, and their names in files.

use serde::{Deserialize, Serialize};

/// The effect of a fault on a value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Kind {
    /// The value is this one.
    Override(f64),
    /// This is added.
    Bias(f64),
    /// The value is multiplied by this.
    Scale(f64),
    /// An added offset that grows by this much per second.
    Drift(f64),
    /// An added offset that grows to `size` during `over` seconds, and stays.
    Ramp {
        /// The final offset.
        size: f64,
        /// How long it grows (s).
        over: f64,
    },
    /// An independent normal random number of this standard deviation is added at each step.
    WhiteNoise(f64),
    /// Adds noise with the standard deviation `sigma` whose correlation falls to 1/e in `tau`
    /// seconds (a first-order Gauss-Markov process).
    GaussMarkov {
        /// Standard deviation.
        sigma: f64,
        /// Correlation time (s).
        tau: f64,
    },
    /// At a step, with probability `share`, an error is added.
    Outliers {
        /// Probability per step.
        share: f64,
        /// The error.
        size: Spread,
    },
    /// The value freezes.
    Stuck,
    /// The value is NaN.
    NotANumber,
    /// The value is rounded to the nearest multiple of this.
    Quantization(f64),
    /// The value is limited to these bounds.
    Saturation(f64, f64),
    /// Values do not come through: permanently, or intermittently.
    DropOut {
        /// Mean time (s) until the signal is lost, and until it returns; if absent, it is lost
        /// permanently.
        turns: Option<(f64, f64)>,
        /// What is seen meanwhile.
        meanwhile: Meanwhile,
    },
    /// The value arrives `delay` seconds late, plus up to `jitter` seconds, in order.
    Latency {
        /// The minimum delay (s).
        delay: f64,
        /// The maximum addition to it (s).
        jitter: f64,
    },
    /// The value follows with a first-order lag with this time constant (s).
    Lag(f64),
    /// Samples are taken only at this period (s); the last one is held.
    Sampling,
    /// With probability `share`, a sample arrives `delay` seconds late, after younger ones; with
    /// `again` it also arrives in time, so it is seen twice.
    Reordering {
        /// Probability per sample.
        share: f64,
        /// Its delay (s).
        delay: f64,
        /// It also arrives in time.
        again: bool,
    },
    /// The faults before this one in the file stop acting on its variables.
    Release,
    /// The component is reset (`fmi2Reset`) and initialized anew with its start values.
    Reset,
}

/// The magnitude of outliers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Spread {
    /// Normally distributed with this standard deviation.
    Normal(f64),
    /// Uniformly distributed up to this magnitude.
    Uniform(f64),
}

/// What is seen of a value that does not come through.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Meanwhile {
    /// The last value that came through.
    Last,
    /// Zero.
    Zero,
    /// NaN.
    NotANumber,
}

/// The name of a kind in a file, and its parameters.
pub struct Word {
    /// The kind.
    pub name: &'static str,
    /// Its effect.
    pub meaning: &'static str,
    /// Its keys.
    pub keys: &'static [Meant],
    /// An example with these keys.
    pub example: &'static str,
}

/// A key of a kind.
pub struct Meant {
    /// The key.
    pub key: &'static str,
    /// The meaning of its value.
    pub meaning: &'static str,
    /// The permitted words; empty if it is a number.
    pub words: &'static [&'static str],
}

const fn key(key: &'static str, meaning: &'static str) -> Meant {
    Meant { key, meaning, words: &[] }
}

/// All kinds that a file can name.
pub const KINDS: [Word; 21] = [
    Word {
        name: "override",
        meaning: "the value is replaced",
        keys: &[key("value", "the replacement")],
        example: "value = 1",
    },
    Word {
        name: "bias",
        meaning: "a constant is added",
        keys: &[key("value", "the constant")],
        example: "value = 0.1",
    },
    Word {
        name: "scale",
        meaning: "the value is multiplied",
        keys: &[key("factor", "the factor")],
        example: "factor = 1.02",
    },
    Word {
        name: "drift",
        meaning: "an added offset grows without limit",
        keys: &[key("rate", "growth per second")],
        example: "rate = 0.001",
    },
    Word {
        name: "ramp",
        meaning: "an added offset grows, and stays",
        keys: &[key("value", "the final offset"), key("over", "seconds of growth")],
        example: "value = 0.5\nover = 20",
    },
    Word {
        name: "white-noise",
        meaning: "an independent normal random number is added at each step",
        keys: &[key("sigma", "its standard deviation"), EVERY],
        example: "sigma = 0.02\nevery = 0.2",
    },
    Word {
        name: "gauss-markov",
        meaning: "noise with a correlation time is added",
        keys: &[
            key("sigma", "its standard deviation"),
            key("tau", "seconds in which its correlation falls to 1/e"),
            EVERY,
        ],
        example: "sigma = 0.05\ntau = 60\nevery = 0.2",
    },
    Word {
        name: "outliers",
        meaning: "occasionally an error is added for one step",
        keys: &[
            key("share", "probability per step"),
            key("sigma", "standard deviation of normal errors"),
            key("size", "or: the maximum magnitude of uniformly distributed errors"),
            EVERY,
        ],
        example: "share = 0.05\nsigma = 5\nevery = 1",
    },
    Word { name: "stuck", meaning: "the value freezes", keys: &[], example: "" },
    Word { name: "zero", meaning: "the value is 0", keys: &[], example: "" },
    Word { name: "nan", meaning: "the value is not a number", keys: &[], example: "" },
    Word {
        name: "quantization",
        meaning: "the value is rounded to the nearest multiple",
        keys: &[key("step", "the base of the multiples")],
        example: "step = 0.1",
    },
    Word {
        name: "saturation",
        meaning: "the value is limited to bounds",
        keys: &[key("min", "the lower bound"), key("max", "the upper bound")],
        example: "min = -100\nmax = 100",
    },
    Word {
        name: "drop-out",
        meaning: "values do not come through: permanently, or intermittently (a two-state Markov chain)",
        keys: &[
            key("up", "mean seconds until the signal is lost"),
            key("down", "mean seconds until it returns"),
            Meant {
                key: "meanwhile",
                meaning: "what is seen then: last (the default), zero or nan",
                words: &["last", "zero", "nan"],
            },
        ],
        example: "up = 20\ndown = 3",
    },
    Word {
        name: "latency",
        meaning: "values arrive late and in order; all variables of the fault with the same delay",
        keys: &[key("delay", "seconds"), key("jitter", "maximum additional seconds (default 0)")],
        example: "delay = 0.5\njitter = 0.1",
    },
    Word {
        name: "lag",
        meaning: "the value follows with a first-order lag",
        keys: &[key("tau", "its time constant in seconds")],
        example: "tau = 0.5",
    },
    Word {
        name: "rate-change",
        meaning: "samples are taken less often; the last one is held",
        keys: &[EVERY],
        example: "every = 2",
    },
    Word {
        name: "reordering",
        meaning: "some samples arrive late, after younger ones; all variables of the fault together",
        keys: &[key("share", "probability per sample"), key("delay", "seconds"), EVERY],
        example: "share = 0.2\ndelay = 1.5\nevery = 1",
    },
    Word {
        name: "duplicates",
        meaning: "some samples arrive a second time, after younger ones; all variables together",
        keys: &[key("share", "probability per sample"), key("delay", "seconds"), EVERY],
        example: "share = 0.2\ndelay = 1.5\nevery = 1",
    },
    Word {
        name: "release",
        meaning: "the faults before this one in the file stop acting on its variables",
        keys: &[],
        example: "",
    },
    Word {
        name: "reset",
        meaning: "the components named by 'on' are reset and initialized anew, with their start values",
        keys: &[],
        example: "",
    },
];

/// For kinds that draw a random number for each sample.
const EVERY: Meant =
    key("every", "seconds between samples (default: each step of the component is one)");

impl Kind {
    /// Whether all variables of a fault share its random numbers: they are lost or late together.
    pub(crate) fn is_common(&self) -> bool {
        matches!(
            self,
            Kind::DropOut { .. }
                | Kind::Latency { .. }
                | Kind::Outliers { .. }
                | Kind::Reordering { .. }
        )
    }

    /// Whether its effect depends on earlier values.
    pub(crate) fn remembers(&self) -> bool {
        matches!(
            self,
            Kind::Stuck
                | Kind::DropOut { .. }
                | Kind::Latency { .. }
                | Kind::Lag(_)
                | Kind::Sampling
                | Kind::Reordering { .. }
        )
    }
}
