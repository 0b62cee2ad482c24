//! What faults do, and how files say it.

use serde::{Deserialize, Serialize};

/// What a fault does to a value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Kind {
    /// The value is this one.
    Override(f64),
    /// This is added.
    Bias(f64),
    /// The value is multiplied by this.
    Scale(f64),
    /// What is added grows by so much a second.
    Drift(f64),
    /// What is added grows to `size` during `over` seconds, and stays.
    Ramp {
        /// What is added in the end.
        size: f64,
        /// How long it grows (s).
        over: f64,
    },
    /// An independent normal number of this standard deviation is added at each step.
    WhiteNoise(f64),
    /// Noise of the standard deviation `sigma` whose correlation falls to 1/e in `tau` seconds (a
    /// first-order Gauss-Markov process) is added.
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
        /// What is added then.
        size: Spread,
    },
    /// The value stays what it was.
    Stuck,
    /// The value is NaN.
    NotANumber,
    /// The value is a whole multiple of this, the nearest.
    Quantization(f64),
    /// The value is cut at these bounds.
    Saturation(f64, f64),
    /// Nothing comes through: all the time, or by turns.
    DropOut {
        /// Mean time (s) until it is lost, and until it comes back; without, it is lost.
        turns: Option<(f64, f64)>,
        /// What is seen meanwhile.
        meanwhile: Meanwhile,
    },
    /// The value comes `delay` seconds late, and up to `jitter` seconds later than that, in order.
    Latency {
        /// The least delay (s).
        delay: f64,
        /// What is added to it at most (s).
        jitter: f64,
    },
    /// The value follows with a lag of first order of this time constant (s).
    Lag(f64),
    /// Samples are taken at this period (s) only; the last one is held.
    Sampling,
    /// With probability `share`, a sample comes `delay` seconds late, after younger ones; with
    /// `again` it also comes in time, so it is seen twice.
    Reordering {
        /// Probability per sample.
        share: f64,
        /// How late it comes (s).
        delay: f64,
        /// It comes in time, too.
        again: bool,
    },
    /// The faults before this one in the file stop acting on its variables.
    Release,
    /// The component is reset (`fmi2Reset`) and initialized anew with its start values.
    Reset,
}

/// How large outliers are.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Spread {
    /// Normal numbers of this standard deviation.
    Normal(f64),
    /// Numbers with equal chances up to this size.
    Uniform(f64),
}

/// What is seen of a value that does not come through.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Meanwhile {
    /// The last one that came through.
    Last,
    /// Zero.
    Zero,
    /// NaN.
    NotANumber,
}

/// How a file names a kind, and what else it says with it.
pub struct Word {
    /// The kind.
    pub name: &'static str,
    /// What it does.
    pub meaning: &'static str,
    /// The keys that belong to it.
    pub keys: &'static [Meant],
    /// An example of these keys.
    pub example: &'static str,
}

/// A key of a kind.
pub struct Meant {
    /// The key.
    pub key: &'static str,
    /// What its value is.
    pub meaning: &'static str,
    /// The words that it may be; none if it is a number.
    pub words: &'static [&'static str],
}

const fn key(key: &'static str, meaning: &'static str) -> Meant {
    Meant { key, meaning, words: &[] }
}

/// Every kind that a file can name.
pub const KINDS: [Word; 21] = [
    Word {
        name: "override",
        meaning: "the value is another one",
        keys: &[key("value", "that one")],
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
        keys: &[key("factor", "by this")],
        example: "factor = 1.02",
    },
    Word {
        name: "drift",
        meaning: "what is added grows without end",
        keys: &[key("rate", "so much a second")],
        example: "rate = 0.001",
    },
    Word {
        name: "ramp",
        meaning: "what is added grows, and stays",
        keys: &[key("value", "what is added in the end"), key("over", "seconds of growth")],
        example: "value = 0.5\nover = 20",
    },
    Word {
        name: "white-noise",
        meaning: "an independent normal number is added at each step",
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
        meaning: "now and then an error is added for one step",
        keys: &[
            key("share", "probability per step"),
            key("sigma", "standard deviation of normal errors"),
            key("size", "or: the greatest size of errors with equal chances"),
            EVERY,
        ],
        example: "share = 0.05\nsigma = 5\nevery = 1",
    },
    Word { name: "stuck", meaning: "the value stays what it was", keys: &[], example: "" },
    Word { name: "zero", meaning: "the value is 0", keys: &[], example: "" },
    Word { name: "nan", meaning: "the value is not a number", keys: &[], example: "" },
    Word {
        name: "quantization",
        meaning: "the value is the nearest whole multiple",
        keys: &[key("step", "of this")],
        example: "step = 0.1",
    },
    Word {
        name: "saturation",
        meaning: "the value is cut at bounds",
        keys: &[key("min", "the lower"), key("max", "the upper")],
        example: "min = -100\nmax = 100",
    },
    Word {
        name: "drop-out",
        meaning: "nothing comes through: all the time, or by turns (a Markov chain of two states)",
        keys: &[
            key("up", "mean seconds until it is lost"),
            key("down", "mean seconds until it is back"),
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
        meaning: "values come late and in order; all variables of the fault by the same time",
        keys: &[
            key("delay", "seconds"),
            key("jitter", "seconds that are added at most (default 0)"),
        ],
        example: "delay = 0.5\njitter = 0.1",
    },
    Word {
        name: "lag",
        meaning: "the value follows with a lag of first order",
        keys: &[key("tau", "its time constant in seconds")],
        example: "tau = 0.5",
    },
    Word {
        name: "rate-change",
        meaning: "samples are taken more rarely; the last one is held",
        keys: &[EVERY],
        example: "every = 2",
    },
    Word {
        name: "reordering",
        meaning: "some samples come late, after younger ones; all variables of the fault together",
        keys: &[key("share", "probability per sample"), key("delay", "seconds"), EVERY],
        example: "share = 0.2\ndelay = 1.5\nevery = 1",
    },
    Word {
        name: "duplicates",
        meaning: "some samples come a second time, after younger ones; all variables together",
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

/// Of kinds that draw a number for each sample.
const EVERY: Meant =
    key("every", "seconds between samples (default: each step of the component is one)");

impl Kind {
    /// Whether all variables of a fault share its chances: they are lost or late together.
    pub(crate) fn is_common(&self) -> bool {
        matches!(
            self,
            Kind::DropOut { .. }
                | Kind::Latency { .. }
                | Kind::Outliers { .. }
                | Kind::Reordering { .. }
        )
    }

    /// Whether what it does depends on earlier values.
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
