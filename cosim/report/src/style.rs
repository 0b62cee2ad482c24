//! The common style: the appearance of each role, the same in every figure.
//!
//! The colours are those of Okabe and Ito (2008), distinguishable with every common form of colour
//! blindness, plus a brown and a grey so that eight thrusters get eight colours.

use plotters::style::RGBColor;

/// The meaning of a series, which decides colour, width and dashes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Reference: grey, dashed.
    Reference,
    /// Truth: black.
    Truth,
    /// The first of two estimates: blue.
    Estimate1,
    /// The second of two estimates: orange.
    Estimate2,
    /// Noisy raw data: thin, light green.
    Measurement,
    /// The i-th of several equivalent signals.
    Signal(usize),
}

const GREY: RGBColor = RGBColor(0x6E, 0x6E, 0x6E);
const BLACK: RGBColor = RGBColor(0x14, 0x14, 0x14);
const BLUE: RGBColor = RGBColor(0x00, 0x72, 0xB2);
const ORANGE: RGBColor = RGBColor(0xD5, 0x5E, 0x00);
const GREEN: RGBColor = RGBColor(0x00, 0x9E, 0x73);
const SIGNALS: [RGBColor; 8] = [
    BLUE,
    ORANGE,
    GREEN,
    RGBColor(0xCC, 0x79, 0xA7),
    RGBColor(0x56, 0xB4, 0xE9),
    RGBColor(0xE6, 0x9F, 0x00),
    RGBColor(0x7A, 0x4B, 0x2A),
    RGBColor(0x90, 0x90, 0x90),
];

/// Number of signals in one panel with distinct colours.
pub(super) const DISTINCT_SIGNALS: usize = SIGNALS.len();

impl Role {
    /// The colour.
    pub(super) fn colour(self) -> RGBColor {
        match self {
            Role::Reference => GREY,
            Role::Truth => BLACK,
            Role::Estimate1 => BLUE,
            Role::Estimate2 => ORANGE,
            Role::Measurement => GREEN,
            Role::Signal(i) => SIGNALS[i % SIGNALS.len()],
        }
    }

    /// Line width, px.
    pub(super) fn width(self) -> f64 {
        match self {
            Role::Measurement => 0.75,
            Role::Signal(_) => 1.25,
            _ => 1.5,
        }
    }

    /// Lengths of dash and gap, px; `None` for a solid line.
    pub(super) fn dash(self) -> Option<(f64, f64)> {
        match self {
            Role::Reference => Some((6.0, 4.0)),
            Role::Signal(i) if i >= SIGNALS.len() => Some((3.0, 2.5)),
            _ => None,
        }
    }
}
