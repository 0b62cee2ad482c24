//! Which recorded variables are the truth, its estimates, position fixes and the course.
//!
//! A path is a group with `x` and `y`, called `pose` or `position`. It has a standard deviation if
//! its component has `sigma.x` and `sigma.y` (or `pose_sigma.x` ...); then it is an estimate. The
//! first `pose` without one is the truth; any other `pose` is an estimate if none has a standard
//! deviation. A `position` without one, of another component, is a fix from a sensor. A group with `x`
//! and `y` called `target`, `reference` or `setpoint` is the course: the point that a guidance system
//! follows. Start values (`initial.pose`) are no path.

use super::Names;
use cosim_base::names::did_you_mean;
use cosim_core::{Code, Error, Result};

/// Paths specified by the user or by the figures of a campaign.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Choice {
    /// The true path, as `vehicle.pose`.
    pub truth: Option<String>,
    /// Estimates of it.
    pub estimates: Vec<Estimate>,
    /// Position fixes; `None`: those whose names say so.
    pub fixes: Option<Vec<String>>,
    /// Courses; `None`: those whose names say so.
    pub courses: Option<Vec<String>>,
}

/// An estimated path.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Estimate {
    /// Prefix of its variables: `filter.pose`.
    pub path: String,
    /// Prefix of its standard deviations: `filter.sigma`.
    pub sigma: Option<String>,
    /// Prefix of its covariances, with `x_y`: `filter.covariance`.
    pub covariance: Option<String>,
}

/// The paths of a recording.
#[derive(Debug, Default)]
pub struct Paths {
    /// The group of the true path.
    pub truth: Option<String>,
    /// The groups of the estimated paths.
    pub estimates: Vec<Estimate>,
    /// The groups of position fixes.
    pub fixes: Vec<String>,
    /// The groups of courses.
    pub courses: Vec<String>,
}

/// The maximum number of estimates shown, and of courses.
const MOST: usize = 6;
/// Names of groups that are a course.
const COURSES: [&str; 3] = ["target", "reference", "setpoint"];

impl Paths {
    /// Among recorded names.
    pub fn find(names: &Names<'_>, choice: &Choice) -> Result<Self> {
        let all = candidates(names, &["pose", "position"]);
        let known = |path: &String| {
            if names.has(&format!("{path}.x")) && names.has(&format!("{path}.y")) {
                return Ok(());
            }
            let help = did_you_mean(path, all.iter().copied())
                .unwrap_or_else(|| format!("paths are {}", all.join(", ")));
            Err(Error::new(
                Code::UnknownName,
                format!("'{path}.x' and '{path}.y' are not recorded"),
            )
            .help(help))
        };
        choice.truth.iter().chain(choice.estimates.iter().map(|e| &e.path)).try_for_each(known)?;
        let (mut sure, mut poses, mut fixes) = (Vec::new(), Vec::new(), Vec::new());
        for path in all {
            let estimate = with_companions(names, path);
            if estimate.sigma.is_some() {
                sure.push(estimate);
            } else if path.ends_with("pose") {
                poses.push(estimate);
            } else {
                fixes.push(path.to_owned());
            }
        }
        let chosen = |path: &str| choice.estimates.iter().any(|e| e.path == path);
        let mut truth = choice.truth.clone();
        if truth.is_none() {
            truth = poses.iter().map(|e| e.path.clone()).find(|path| !chosen(path));
        }
        let mut estimates: Vec<Estimate> = choice.estimates.clone();
        for estimate in &mut estimates {
            let found = with_companions(names, &estimate.path);
            estimate.sigma = estimate.sigma.take().or(found.sigma);
            estimate.covariance = estimate.covariance.take().or(found.covariance);
        }
        if estimates.is_empty() {
            estimates = if sure.is_empty() { poses } else { sure };
            estimates.retain(|estimate| Some(&estimate.path) != truth.as_ref());
        }
        estimates.truncate(MOST);
        // Inputs of the truth or of an estimator are not sensors.
        let owners = truth.iter().chain(estimates.iter().map(|estimate| &estimate.path));
        let owners: Vec<String> =
            owners.filter_map(|path| Some(format!("{}.", path.rsplit_once('.')?.0))).collect();
        fixes.retain(|fix| !owners.iter().any(|owner| fix.starts_with(owner)));
        let fixes = choice.fixes.clone().unwrap_or(fixes);
        let courses = choice.courses.clone().unwrap_or_else(|| {
            let mut found = candidates(names, &COURSES);
            found.retain(|path| truth.as_deref() != Some(path) && !chosen(path));
            found.truncate(MOST);
            found.into_iter().map(str::to_owned).collect()
        });
        Ok(Self { truth, estimates, fixes, courses })
    }
}

/// Groups with `x` and `y` that have one of these names, in the order of the recording.
fn candidates<'a>(names: &Names<'a>, called: &[&str]) -> Vec<&'a str> {
    let prefixes = names.ordered.iter().filter_map(|name| name.strip_suffix(".x"));
    let prefixes = prefixes.filter(|path| !path.split('.').any(|part| part == "initial"));
    let last = |path: &str| path.rsplit('.').next().is_some_and(|last| called.contains(&last));
    prefixes.filter(|path| last(path) && names.has(&format!("{path}.y"))).collect()
}

/// A path with its standard deviations and covariances, if they are recorded.
fn with_companions(names: &Names<'_>, path: &str) -> Estimate {
    let (component, group) = path.rsplit_once('.').unwrap_or(("", path));
    let beside = |name: String| {
        if component.is_empty() { name } else { format!("{component}.{name}") }
    };
    let find = |words: [String; 3], ends: &[&str]| {
        words.into_iter().find(|word| ends.iter().all(|end| names.has(&format!("{word}.{end}"))))
    };
    let sigma = [beside(format!("{group}_sigma")), format!("{path}.sigma"), beside("sigma".into())];
    let covariance =
        [beside(format!("{group}_covariance")), beside("covariance".into()), beside("cov".into())];
    Estimate {
        path: path.to_owned(),
        sigma: find(sigma, &["x", "y"]),
        covariance: find(covariance, &["x_y"]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paths among groups with `x` and `y`.
    fn found(groups: &[&str], choice: &Choice) -> Paths {
        let names: Vec<String> = groups
            .iter()
            .flat_map(|group| ["x", "y"].map(|axis| format!("{group}.{axis}")))
            .collect();
        Paths::find(&Names::new(names.iter().map(String::as_str)), choice).unwrap()
    }

    #[test]
    fn start_values_of_a_path_are_no_path() {
        let groups =
            ["vehicle.pose", "ekf.initial.pose", "ekf.initial.sigma", "ekf.pose", "ekf.sigma"];
        let paths = found(&groups, &Choice::default());
        assert_eq!(paths.truth.as_deref(), Some("vehicle.pose"));
        let estimates: Vec<&str> = paths.estimates.iter().map(|e| e.path.as_str()).collect();
        assert_eq!(estimates, ["ekf.pose"]);
    }

    #[test]
    fn a_target_is_a_course_unless_it_is_chosen_as_the_truth() {
        let groups = ["pursuit.target", "vehicle.pose", "setpoint", "nav.initial.reference"];
        let paths = found(&groups, &Choice::default());
        assert_eq!(paths.courses, ["pursuit.target", "setpoint"]);
        assert_eq!((paths.truth.as_deref(), paths.estimates.len()), (Some("vehicle.pose"), 0));
        let truth = Some("pursuit.target".to_owned());
        let paths = found(&groups, &Choice { truth, ..Choice::default() });
        assert_eq!(paths.courses, ["setpoint"]);
        let courses = Some(Vec::new());
        let paths = found(&groups, &Choice { courses, ..Choice::default() });
        assert!(paths.courses.is_empty());
    }
}
