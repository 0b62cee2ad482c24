//! Plots of the quality of estimates: errors, innovations, consistency.

use super::columns::Columns;
use super::plots::{Limits, Role, Whole};
use crate::statistics::chi_square_quantile;
use crate::units::Units;
use cosim_results::roles::{Estimate, Paths};

/// The axes of a pose, and whether they are angles.
const AXES: [(&str, bool); 6] =
    [("x", false), ("y", false), ("z", false), ("roll", true), ("pitch", true), ("yaw", true)];

fn component(path: &str) -> &str {
    path.rsplit_once('.').map_or("", |(component, _)| component)
}

fn times(values: Vec<f64>, factor: f64) -> Vec<f64> {
    values.into_iter().map(|value| value * factor).collect()
}

/// An angle in degrees from -180 to 180.
fn half_turn(degrees: f64) -> f64 {
    (degrees + 180.0).rem_euclid(360.0) - 180.0
}

/// Headings of the truth and the estimates in degrees.
pub(super) fn headings(columns: &Columns<'_>, paths: &Paths, units: &Units) -> Whole {
    let lines = super::paths_of(paths).filter_map(|(path, role)| {
        let name = format!("{path}.yaw");
        let degrees = units.radians(&name).to_degrees();
        let values = columns.get(&name)?.into_iter().map(|value| half_turn(value * degrees));
        Some((name, role, values.collect()))
    });
    Whole {
        section: "Depth and heading".into(),
        title: "yaw, clockwise from north".into(),
        unit: "deg".into(),
        lines: lines.collect(),
        wraps: true,
        ..Whole::default()
    }
}

/// Estimates minus the truth, with three standard deviations; angles in degrees.
pub(super) fn errors(columns: &Columns<'_>, paths: &Paths, units: &Units) -> Vec<Whole> {
    let Some(truth) = &paths.truth else { return Vec::new() };
    let mut plots = Vec::new();
    for estimate in &paths.estimates {
        let poses = AXES.iter().map(|(axis, turns)| {
            let name = |of: &str| format!("{of}.{axis}");
            let sigma = estimate.sigma.as_deref().map(name);
            (name(&estimate.path), name(truth), sigma, *turns)
        });
        // Other quantities with a standard deviation and a truth: `velocity.u`, `velocity_sigma.u`.
        let (own, true_one) = (component(&estimate.path), component(truth));
        let others = columns.names.iter().filter_map(|name| {
            let rest = name.strip_prefix(own)?.strip_prefix('.')?;
            let (group, leaf) = rest.split_once("_sigma.")?;
            if group == "pose" || group == "innovation" {
                return None;
            }
            let (value, real) =
                (format!("{own}.{group}.{leaf}"), format!("{true_one}.{group}.{leaf}"));
            Some((value, real, Some((*name).to_owned()), false))
        });
        for (name, real_name, sigma, turns) in poses.chain(others) {
            let (Some(value), Some(real)) = (columns.get(&name), columns.get(&real_name)) else {
                continue;
            };
            // Each angle may be in its own unit.
            let scale = |of: &str| if turns { units.radians(of).to_degrees() } else { 1.0 };
            let (of_value, of_real) = (scale(&name), scale(&real_name));
            let error = value.iter().zip(&real).map(|(value, real)| {
                let error = value * of_value - real * of_real;
                if turns { half_turn(error) } else { error }
            });
            let band =
                sigma.and_then(|sigma| Some(times(columns.get(&sigma)?, 3.0 * scale(&sigma))));
            let unit = if turns { "deg" } else { units.unit(&name).unwrap_or_default() };
            plots.push(Whole {
                section: "Errors".into(),
                title: format!("{name}: error"),
                unit: unit.into(),
                lines: vec![("error".into(), Role::Estimate, error.collect())],
                band: band.map(|band| ("± 3 σ".into(), band)),
                ..Whole::default()
            });
        }
    }
    plots
}

/// Horizontal normalized estimation error squared, with the 95 % band of a consistent estimate.
pub(super) fn consistency(columns: &Columns<'_>, paths: &Paths) -> Vec<Whole> {
    let Some(truth) = &paths.truth else { return Vec::new() };
    let plot = |estimate: &Estimate| {
        let sigma = estimate.sigma.as_ref()?;
        let get = |of: &str, axis: &str| columns.get(&format!("{of}.{axis}"));
        let (x, y) = (get(&estimate.path, "x")?, get(&estimate.path, "y")?);
        let (true_x, true_y) = (get(truth, "x")?, get(truth, "y")?);
        let (sigma_x, sigma_y) = (get(sigma, "x")?, get(sigma, "y")?);
        let both = estimate.covariance.as_ref().and_then(|covariance| get(covariance, "x_y"));
        let nees = (0..x.len()).map(|row| {
            let (dx, dy) = (x[row] - true_x[row], y[row] - true_y[row]);
            let (xx, yy) = (sigma_x[row] * sigma_x[row], sigma_y[row] * sigma_y[row]);
            let xy = both.as_ref().map_or(0.0, |both| both[row]);
            let determinant = xx * yy - xy * xy;
            if determinant > 0.0 {
                (dx * dx * yy - 2.0 * dx * dy * xy + dy * dy * xx) / determinant
            } else {
                f64::NAN
            }
        });
        Some(Whole {
            section: "Consistency".into(),
            title: format!("{}: NEES of x and y", estimate.path),
            unit: "1".into(),
            lines: vec![("NEES".into(), Role::Estimate, nees.collect())],
            limits: Some(limits(2)),
            ..Whole::default()
        })
    };
    paths.estimates.iter().filter_map(plot).collect()
}

fn limits(freedom: usize) -> Limits {
    let quantile = |p| chi_square_quantile(p, freedom as f64);
    let plural = if freedom == 1 { "degree" } else { "degrees" };
    let name = format!("95 % of χ² with {freedom} {plural} of freedom");
    Limits { name, low: quantile(0.025), high: quantile(0.975) }
}

/// Innovations with two standard deviations, and where a measurement was rejected.
pub(super) fn innovations(columns: &Columns<'_>, paths: &Paths, units: &Units) -> Vec<Whole> {
    let mut plots = Vec::new();
    for estimate in &paths.estimates {
        let prefix = format!("{}.innovation.", component(&estimate.path));
        for name in columns.names.iter().filter(|name| name.starts_with(&prefix)) {
            let rest = &name[prefix.len()..];
            let sigma = columns.get(&name.replacen(".innovation.", ".innovation_sigma.", 1));
            let Some(values) = columns.get(name) else { continue };
            plots.push(Whole {
                section: "Innovations".into(),
                title: (*name).into(),
                unit: units.unit(name).unwrap_or_default().into(),
                lines: vec![("innovation".into(), Role::Estimate, values)],
                band: sigma.map(|sigma| ("± 2 √S".into(), times(sigma, 2.0))),
                marks: rejected(columns, component(&estimate.path), rest),
                steps: true,
                ..Whole::default()
            });
        }
    }
    plots
}

/// The rows at which a measurement of a sensor was rejected.
fn rejected(columns: &Columns<'_>, owner: &str, of: &str) -> Option<(String, Vec<usize>)> {
    let sensor = of.split('.').next()?;
    let count = columns.get(&format!("{owner}.count.{sensor}.rejected"))?;
    let rows = (1..count.len()).filter(|row| count[*row] > count[row - 1]);
    Some(("rejected".to_owned(), rows.collect()))
}

/// Normalized innovations squared, with the 95 % band of a consistent filter.
pub(super) fn normalized(columns: &Columns<'_>, paths: &Paths) -> Vec<Whole> {
    let mut plots = Vec::new();
    for estimate in &paths.estimates {
        let owner = component(&estimate.path);
        let prefix = format!("{owner}.nis.");
        for name in columns.names.iter().filter(|name| name.starts_with(&prefix)) {
            let sensor = &name[prefix.len()..];
            let Some(values) = columns.get(name) else { continue };
            let freedom = freedom(columns.names.iter().copied(), owner, sensor);
            plots.push(Whole {
                section: "Consistency".into(),
                title: format!("{name}: NIS"),
                unit: "1".into(),
                lines: vec![("NIS".into(), Role::Estimate, values)],
                limits: freedom.map(limits),
                marks: rejected(columns, owner, sensor),
                steps: true,
                ..Whole::default()
            });
        }
    }
    plots
}

/// How many innovations a measurement of a sensor has: `filter.innovation.fix.x` and `.y` are two.
pub fn freedom<'a>(
    names: impl Iterator<Item = &'a str>,
    owner: &str,
    sensor: &str,
) -> Option<usize> {
    let one = format!("{owner}.innovation.{sensor}");
    let belongs =
        |name: &&str| name.strip_prefix(&one).is_some_and(|r| r.is_empty() || r.starts_with('.'));
    Some(names.filter(belongs).count()).filter(|count| *count > 0)
}
