//! Figures of merit: one number from the recording of a run.

mod compute;
mod expression;
mod formula;
mod nees;

use self::expression::Expression;
use super::trajectory::{ALIGNMENTS, Alignment};
use cosim_base::names::{self, Aliases};
use cosim_core::table::{Entry, Table};

/// A figure of merit.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Figure {
    what: What,
    /// The part of the run that counts (s), and its relation to the faults of the scenario.
    from: f64,
    until: f64,
    window: Window,
}

/// A part of a run relative to its faults, from the start of the first to the end of the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Window {
    All,
    Before,
    During,
    After,
}

const WINDOWS: [(&str, Window); 3] =
    [("before", Window::Before), ("during", Window::During), ("after", Window::After)];

/// What is computed.
#[derive(Debug, Clone, PartialEq)]
enum What {
    /// Of a variable or an expression, or of how far it exceeds another one.
    Of { of: Expression, minus: Option<Expression>, absolute: bool, angle: bool, take: Take },
    /// Absolute trajectory error.
    Ate { poses: Poses, align: Alignment, greatest: bool },
    /// Relative pose error, root mean square.
    Rpe { poses: Poses, heading: String, over: Over },
    /// The final distance, in % of the distance travelled.
    Drift(Poses),
    /// Distance of the estimate from the line along which the truth moves, in the first two axes.
    CrossTrack { poses: Poses, greatest: bool },
    /// Share of the errors, per axis, that exceed this many standard deviations.
    Beyond { poses: Poses, sigma: String, sigmas: f64 },
    /// Normalised estimation error squared: its mean, or its value at an instant (s).
    Nees { poses: Poses, sigma: String, covariance: Option<String>, at: Option<f64> },
    /// Normalised innovation squared, of the samples at which `count` increased: their mean, or the
    /// last one at an instant (s).
    Nis { nis: String, count: String, at: Option<f64> },
    /// Correlation of successive innovations, normalised (Bar-Shalom et al. 2001, eq 5.4.2-19).
    Whiteness { innovation: String, count: String },
}

#[derive(Debug, Clone, PartialEq)]
enum Take {
    Final,
    Min,
    Max,
    Mean,
    Rms,
    Percentile(f64),
    TimeAbove(f64),
    FirstAbove(f64),
    SettledBelow(f64),
    /// Root mean square of an error of which this standard deviation is claimed.
    Error(Expression),
    /// The value at an instant (s); NaN if the part of the run does not reach it.
    At(f64),
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Over {
    Seconds(f64),
    Metres(f64),
}

/// The variables of a truth and an estimate, per axis.
#[derive(Debug, Clone, PartialEq)]
struct Poses {
    truth: String,
    estimate: String,
    axes: Vec<String>,
}

pub(super) const KINDS: [&str; 18] = [
    "final",
    "min",
    "max",
    "mean",
    "rms",
    "percentile",
    "time-above",
    "first-above",
    "settled-below",
    "error",
    "ate",
    "rpe",
    "drift",
    "cross-track",
    "beyond",
    "nees",
    "nis",
    "whiteness",
];

impl Poses {
    fn read(table: &Table<'_>) -> Option<Self> {
        let (truth, estimate) = (table.needed_text("truth"), table.needed_text("estimate"));
        let mut axes: Vec<String> = table.texts("axes").into_iter().map(str::to_owned).collect();
        if axes.is_empty() {
            axes = ["x", "y", "z"].map(str::to_owned).to_vec();
        }
        Some(Self { truth: truth?.to_owned(), estimate: estimate?.to_owned(), axes })
    }

    fn columns(&self) -> Vec<String> {
        let both = [&self.truth, &self.estimate].into_iter();
        both.flat_map(|of| self.axes.iter().map(move |axis| format!("{of}.{axis}"))).collect()
    }
}

/// Keys that every figure accepts.
const PART: [&str; 4] = ["kind", "from", "until", "window"];
/// Additional keys of those that compare an estimate with the truth.
const POSES: [&str; 3] = ["truth", "estimate", "axes"];

/// Whether the maximum is taken instead of the root mean square.
fn greatest(table: &Table<'_>) -> Option<bool> {
    match table.text("take") {
        None | Some("rmse") => Some(false),
        Some("max") => Some(true),
        Some(other) => {
            table.get("take")?.wrong(format!("'{other}' is not one of rmse, max"));
            None
        }
    }
}

fn expression(entry: &Entry<'_>) -> Option<Expression> {
    match Expression::read(entry.text()?) {
        Ok(expression) => Some(expression),
        Err(why) => {
            entry.wrong(why);
            None
        }
    }
}

impl Figure {
    /// From a table of the file; `None` if that is wrong.
    pub(super) fn read(table: &Table<'_>) -> Option<Self> {
        let kind = table.needed_text("kind")?;
        let allow = |own: &[&str]| table.allow(&[&PART[..], &POSES, own].concat());
        let what = match kind {
            "ate" => {
                allow(&["align", "take"]);
                let align = table.text("align").unwrap_or("none");
                let found = ALIGNMENTS.iter().find(|(name, _)| *name == align);
                if found.is_none() {
                    table.get("align")?.wrong(format!("'{align}' is not one of none, se2, se3"));
                }
                let greatest = greatest(table)?;
                What::Ate { poses: Poses::read(table)?, align: found?.1, greatest }
            }
            "rpe" => {
                allow(&["heading", "seconds", "metres"]);
                let over = match (table.get("seconds"), table.get("metres")) {
                    (Some(_), None) => Over::Seconds(table.positive("seconds")?),
                    (None, Some(_)) => Over::Metres(table.positive("metres")?),
                    _ => {
                        table.wrong("either 'seconds' or 'metres' must be given");
                        return None;
                    }
                };
                let heading = table.text("heading").unwrap_or("yaw").to_owned();
                What::Rpe { poses: Poses::read(table)?, heading, over }
            }
            "drift" => {
                allow(&[]);
                What::Drift(Poses::read(table)?)
            }
            "cross-track" => {
                allow(&["take"]);
                What::CrossTrack { greatest: greatest(table)?, poses: Poses::read(table)? }
            }
            "beyond" => {
                allow(&["sigma", "sigmas"]);
                let (poses, sigma) = (Poses::read(table), table.needed_text("sigma"));
                let sigmas = table.positive("sigmas").unwrap_or(3.0);
                What::Beyond { poses: poses?, sigma: sigma?.to_owned(), sigmas }
            }
            "nees" => {
                allow(&["sigma", "covariance", "every"]);
                let (poses, sigma) = (Poses::read(table), table.needed_text("sigma"));
                let covariance = table.text("covariance").map(str::to_owned);
                What::Nees { poses: poses?, sigma: sigma?.to_owned(), covariance, at: None }
            }
            "nis" => {
                table.allow(&[&PART[..], &["nis", "count", "every", "dimension"]].concat());
                let (nis, count) = (table.needed_text("nis"), table.needed_text("count"));
                What::Nis { nis: nis?.to_owned(), count: count?.to_owned(), at: None }
            }
            "whiteness" => {
                table.allow(&[&PART[..], &["innovation", "count"]].concat());
                let innovation = table.needed_text("innovation").map(str::to_owned);
                let count = table.needed_text("count").map(str::to_owned);
                What::Whiteness { innovation: innovation?, count: count? }
            }
            _ => Self::read_of(table, kind)?,
        };
        let bound = |key: &str, none| table.get(key).map_or(Some(none), |bound| bound.number());
        let (from, until) = (bound("from", f64::NEG_INFINITY)?, bound("until", f64::INFINITY)?);
        if until <= from {
            table.wrong(format!("'until' {until} is not after 'from' {from}"));
        }
        let window = match table.text("window") {
            None => Window::All,
            Some(name) => {
                let found = WINDOWS.iter().find(|(known, _)| *known == name);
                if found.is_none() {
                    let what = format!("'{name}' is not one of before, during, after");
                    table.get("window")?.wrong(what);
                }
                found?.1
            }
        };
        Some(Self { what, from, until, window })
    }

    /// What a figure that is evaluated over time is at an instant (s), each with what is added to
    /// its name; nothing for other figures.
    pub(super) fn at(&self, instant: f64) -> Vec<(&'static str, Self)> {
        let (mut what, mut claimed) = (self.what.clone(), None);
        match &mut what {
            What::Nees { at, .. } | What::Nis { at, .. } => *at = Some(instant),
            What::Of { take: take @ Take::Error(_), .. } => {
                if let Take::Error(of) = std::mem::replace(take, Take::At(instant)) {
                    let (minus, take) = (None, Take::At(instant));
                    claimed = Some(What::Of { of, minus, absolute: false, angle: false, take });
                }
            }
            _ => return Vec::new(),
        }
        let all = [("", what)].into_iter().chain(claimed.map(|what| (".sigma", what)));
        all.map(|(more, what)| (more, Self { what, ..self.clone() })).collect()
    }

    /// Whether it is an error with a claimed standard deviation.
    pub(super) fn is_error(&self) -> bool {
        matches!(self.what, What::Of { take: Take::Error(_), .. })
    }

    /// The same figure for variables with other names.
    pub(super) fn renamed(&self, aliases: &Aliases) -> Self {
        let mut figure = self.clone();
        let (poses, expressions, names) = match &mut figure.what {
            What::Of { of, minus, take, .. } => {
                let sigma = if let Take::Error(sigma) = take { Some(sigma) } else { None };
                (None, vec![Some(of), minus.as_mut(), sigma], vec![])
            }
            What::Ate { poses, .. }
            | What::Rpe { poses, .. }
            | What::Drift(poses)
            | What::CrossTrack { poses, .. } => (Some(poses), vec![], vec![]),
            What::Beyond { poses, sigma, .. } => (Some(poses), vec![], vec![Some(sigma)]),
            What::Nees { poses, sigma, covariance, .. } => {
                (Some(poses), vec![], vec![Some(sigma), covariance.as_mut()])
            }
            What::Nis { nis, count, .. } => (None, vec![], vec![Some(nis), Some(count)]),
            What::Whiteness { innovation, count } => {
                (None, vec![], vec![Some(innovation), Some(count)])
            }
        };
        let of_poses = poses.into_iter().flat_map(|p| [&mut p.truth, &mut p.estimate]);
        let expressions = expressions.into_iter().flatten();
        of_poses
            .chain(expressions.flat_map(Expression::variables_mut))
            .chain(names.into_iter().flatten())
            .for_each(|name| *name = aliases.resolve(name));
        figure
    }

    /// The instant to which it refers (s).
    pub(super) fn instant(&self) -> Option<f64> {
        match self.what {
            What::Nees { at, .. } | What::Nis { at, .. } => at,
            What::Of { take: Take::At(at), .. } => Some(at),
            _ => None,
        }
    }

    /// The number of axes of a normalised error squared.
    pub(super) fn axes(&self) -> Option<usize> {
        match &self.what {
            What::Nees { poses, .. } => Some(poses.axes.len()),
            _ => None,
        }
    }

    fn read_of(table: &Table<'_>, kind: &str) -> Option<What> {
        let number = |key: &str| table.needed_number(key);
        let needed = |key: &str| match table.get(key) {
            Some(entry) => expression(&entry),
            None => {
                table.wrong(format!("'{key}' is missing"));
                None
            }
        };
        let (take, own): (_, &[&str]) = match kind {
            "final" => (Some(Take::Final), &[]),
            "min" => (Some(Take::Min), &[]),
            "max" => (Some(Take::Max), &[]),
            "mean" => (Some(Take::Mean), &[]),
            "rms" => (Some(Take::Rms), &[]),
            "percentile" => (number("p").map(Take::Percentile), &["p"]),
            "time-above" => (number("above").map(Take::TimeAbove), &["above"]),
            "first-above" => (number("above").map(Take::FirstAbove), &["above"]),
            "settled-below" => (number("below").map(Take::SettledBelow), &["below"]),
            "error" => (needed("sigma").map(Take::Error), &["sigma", "every"]),
            other => {
                let help = names::did_you_mean(other, KINDS)
                    .unwrap_or_else(|| format!("known are {}", KINDS.join(", ")));
                table.get("kind")?.wrong(format!("there is no figure '{other}'; {help}"));
                return None;
            }
        };
        let known = PART.into_iter().chain(["of", "minus", "absolute", "angle"]);
        table.allow(&known.chain(own.iter().copied()).collect::<Vec<_>>());
        if let Some(Take::Percentile(p)) = take
            && !(0.0..=100.0).contains(&p)
        {
            table.get("p")?.wrong(format!("{p} is not between 0 and 100"));
        }
        let of = needed("of");
        let minus = table.get("minus").map_or(Some(None), |entry| expression(&entry).map(Some));
        let flag = |key: &str| table.number(key).is_some_and(|value| value != 0.0);
        let (absolute, angle) = (flag("absolute"), flag("angle"));
        Some(What::Of { of: of?, minus: minus?, absolute, angle, take: take? })
    }

    /// The variables that it needs.
    pub(super) fn columns(&self) -> Vec<String> {
        match &self.what {
            What::Of { of, minus, take, .. } => {
                let sigma = if let Take::Error(sigma) = take { Some(sigma) } else { None };
                let all = [of].into_iter().chain(minus).chain(sigma);
                all.flat_map(|of| of.variables().to_vec()).collect()
            }
            What::Ate { poses, .. } | What::CrossTrack { poses, .. } | What::Drift(poses) => {
                poses.columns()
            }
            What::Beyond { poses, sigma, .. } => {
                let deviations = poses.axes.iter().map(|axis| format!("{sigma}.{axis}"));
                poses.columns().into_iter().chain(deviations).collect()
            }
            What::Rpe { poses, heading, .. } => {
                let mut columns = poses.columns();
                columns.extend([&poses.truth, &poses.estimate].map(|of| format!("{of}.{heading}")));
                columns
            }
            What::Nees { poses, sigma, covariance, .. } => {
                let mut columns = poses.columns();
                columns.extend(poses.axes.iter().map(|axis| format!("{sigma}.{axis}")));
                if let Some(covariance) = covariance {
                    for (place, first) in poses.axes.iter().enumerate() {
                        let others = poses.axes[place + 1..].iter();
                        columns.extend(others.map(|other| format!("{covariance}.{first}_{other}")));
                    }
                }
                columns
            }
            What::Nis { nis, count, .. } => vec![nis.clone(), count.clone()],
            What::Whiteness { innovation, count } => vec![innovation.clone(), count.clone()],
        }
    }
}

mod words;

#[cfg(test)]
mod tests;
