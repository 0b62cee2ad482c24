//! Describes figures of merit in words, with their units, for reports.

use super::{Figure, Over, Poses, Take, What, Window};
use crate::trajectory::{ALIGNMENTS, Alignment};
use cosim_report::{Choice, Estimate, Units, freedom};

impl Figure {
    /// What is computed.
    pub(crate) fn words(&self) -> String {
        let apart = |poses: &Poses| {
            format!("{} from {} ({})", poses.estimate, poses.truth, poses.axes.join(", "))
        };
        let what = match &self.what {
            What::Of { of, minus, absolute, angle, take } => {
                let less = minus.as_ref().map_or(String::new(), |minus| format!(" - {minus}"));
                let turn = if *angle { ", as the smallest rotation" } else { "" };
                let of = format!("{of}{less}{turn}");
                let of = if *absolute { format!("|{of}|") } else { of };
                match take {
                    Take::Final => format!("the last {of}"),
                    Take::Min => format!("the minimum of {of}"),
                    Take::Max => format!("the maximum of {of}"),
                    Take::Mean => format!("the mean of {of}"),
                    Take::Rms => format!("the root mean square of {of}"),
                    Take::Percentile(p) => format!("the {p}th percentile of {of} over time"),
                    Take::TimeAbove(bound) => format!("how long {of} is above {bound}"),
                    Take::FirstAbove(bound) => format!("when {of} first exceeds {bound}"),
                    Take::SettledBelow(bound) => {
                        format!("how long it takes until {of} stays below {bound}")
                    }
                    Take::Error(sigma) => {
                        format!("the root mean square of {of}, with the claimed sigma {sigma}")
                    }
                    Take::At(instant) => format!("{of} at {instant} s"),
                }
            }
            What::Ate { poses, align, greatest } => {
                let take = if *greatest { "greatest" } else { "root mean square of the" };
                let name = ALIGNMENTS.iter().find(|(_, known)| known == align);
                let aligned = match (align, name) {
                    (Alignment::None, _) | (_, None) => "not aligned".to_owned(),
                    (_, Some((name, _))) => format!("aligned in {}", name.to_uppercase()),
                };
                format!("{take} distance of {}, {aligned}", apart(poses))
            }
            What::Rpe { poses, heading, over } => {
                let over = match over {
                    Over::Seconds(seconds) => format!("{seconds} s"),
                    Over::Metres(metres) => format!("{metres} m"),
                };
                let of = apart(poses);
                format!("root mean square error of the movement over {over} of {of}, by {heading}")
            }
            What::Drift(poses) => {
                format!("final distance of {}, in % of the distance travelled", apart(poses))
            }
            What::CrossTrack { poses, greatest } => {
                let take = if *greatest { "greatest" } else { "root mean square of the" };
                format!("{take} distance across the track of {}", apart(poses))
            }
            What::Beyond { poses, sigmas, .. } => {
                format!("share of the errors of {} beyond {sigmas} sigma", apart(poses))
            }
            What::Whiteness { innovation, .. } => {
                format!("normalized correlation of successive innovations {innovation}")
            }
            What::Nees { poses, at: Some(at), .. } => {
                format!("normalized estimation error squared of {} at {at} s", apart(poses))
            }
            What::Nis { nis, at: Some(at), .. } => {
                format!("normalized innovation squared {nis} at {at} s")
            }
            What::Nees { poses, .. } => {
                format!("mean normalized estimation error squared of {}", apart(poses))
            }
            What::Nis { nis, .. } => format!("mean normalized innovation squared {nis}"),
        };
        let what = match self.window {
            Window::All => what,
            Window::Before => format!("{what}, before the faults"),
            Window::During => format!("{what}, during the faults"),
            Window::After => format!("{what}, after the faults"),
        };
        match (self.from.is_finite(), self.until.is_finite()) {
            (true, true) => format!("{what}, from {} s to {} s", self.from, self.until),
            (true, false) => format!("{what}, from {} s on", self.from),
            (false, true) => format!("{what}, until {} s", self.until),
            (false, false) => what,
        }
    }

    /// Its unit; empty if it is not known.
    pub(crate) fn unit(&self, units: &Units) -> String {
        let unit = match &self.what {
            What::Of {
                take: Take::TimeAbove(_) | Take::FirstAbove(_) | Take::SettledBelow(_),
                ..
            } => Some("s"),
            What::Of { of, .. } => match of.variables() {
                [variable] => units.unit(variable),
                _ => None,
            },
            What::Ate { .. } | What::Rpe { .. } | What::CrossTrack { .. } => Some("m"),
            What::Drift(_) => Some("%"),
            What::Beyond { .. } | What::Nees { .. } | What::Nis { .. } | What::Whiteness { .. } => {
                Some("1")
            }
        };
        unit.unwrap_or_default().to_owned()
    }

    /// The degrees of freedom if the value is chi-square distributed for a consistent filter.
    pub(crate) fn freedom(&self, recorded: &[String]) -> Option<usize> {
        match &self.what {
            What::Nees { poses, .. } => Some(poses.axes.len()),
            What::Nis { nis, .. } => {
                let (owner, sensor) = nis.split_once(".nis.")?;
                freedom(recorded.iter().map(String::as_str), owner, sensor)
            }
            _ => None,
        }
    }

    /// Adds the truth and the estimate that it compares.
    pub(crate) fn choose(&self, choice: &mut Choice) {
        let (poses, sigma, covariance) = match &self.what {
            What::Ate { poses, .. }
            | What::Rpe { poses, .. }
            | What::CrossTrack { poses, .. }
            | What::Drift(poses) => (poses, None, None),
            What::Beyond { poses, sigma, .. } => (poses, Some(sigma), None),
            What::Nees { poses, sigma, covariance, .. } => {
                (poses, Some(sigma), covariance.as_ref())
            }
            What::Of { .. } | What::Nis { .. } | What::Whiteness { .. } => return,
        };
        // A map needs north and east.
        if !["x", "y"].iter().all(|wanted| poses.axes.iter().any(|axis| axis == wanted)) {
            return;
        }
        if *choice.truth.get_or_insert_with(|| poses.truth.clone()) != poses.truth {
            return;
        }
        let place = choice.estimates.iter().position(|known| known.path == poses.estimate);
        let place = place.unwrap_or_else(|| {
            let path = poses.estimate.clone();
            choice.estimates.push(Estimate { path, ..Estimate::default() });
            choice.estimates.len() - 1
        });
        let estimate = &mut choice.estimates[place];
        estimate.sigma = estimate.sigma.take().or(sigma.cloned());
        estimate.covariance = estimate.covariance.take().or(covariance.cloned());
    }
}
