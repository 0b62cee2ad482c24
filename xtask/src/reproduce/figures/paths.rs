//! Figures 6, 7 and 8 of the paper: reference, path taken and estimate, seen from above, north up.

use cosim::report::{Figure, Panel, Role, Series};

use super::{Captioned, role, shown};
use crate::reproduce::campaign::{Campaign, SHOWN_SEED};
use crate::reproduce::case::{Course, Filter};
use crate::reproduce::trace::Trace;

/// Distance of the drawn points of the reference path, m.
const REFERENCE_STEP_M: f64 = 0.1;

/// Both filters on one course.
pub(super) fn figure(campaign: &Campaign, course: Course) -> anyhow::Result<Captioned> {
    let reference = reference(course)?;
    let panel = |filter: Filter| -> anyhow::Result<Panel> {
        let trace = shown(campaign, course, filter)?;
        Ok(panel(&reference, trace, filter))
    };
    let panels = Filter::ALL.into_iter().map(panel).collect::<anyhow::Result<Vec<_>>>()?;
    let extent = |of: fn(&(f64, f64)) -> f64| {
        let values = || reference.iter().map(of);
        values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min)
    };
    // Wide courses one above the other, tall ones side by side.
    let columns = if extent(|p| p.0) > 1.5 * extent(|p| p.1) { 1 } else { 2 };
    let number = course.number() + 5;
    let title = format!("{}: {}", course.name(), course.description());
    Ok(Captioned {
        name: format!("path-{}", course.name()),
        figure: Figure::paths(title, columns, panels),
        caption: format!(
            "{}, Fig. {number} of the paper: reference path, path taken and estimate, seed \
             {SHOWN_SEED}. Seen from above, north up and east to the right; one metre is as long \
             on both axes.",
            course.name()
        ),
    })
}

/// Points (east, north), m.
fn reference(course: Course) -> anyhow::Result<Vec<(f64, f64)>> {
    let path = course.path()?;
    let steps = (path.length() / REFERENCE_STEP_M).ceil() as usize;
    let point = |i: usize| {
        let [x, y] = path.point(path.length() * i as f64 / steps as f64);
        (y, x)
    };
    Ok((0..=steps).map(point).collect())
}

fn panel(reference: &[(f64, f64)], trace: &Trace, filter: Filter) -> Panel {
    let path = |pose: &[Vec<f64>; 4]| -> Vec<(f64, f64)> {
        pose[1].iter().copied().zip(pose[0].iter().copied()).collect()
    };
    let name = format!("estimate, {} filter", filter.name());
    let series = vec![
        Series::line(&name, role(filter), path(&trace.estimate)),
        Series::line("path taken", Role::Truth, path(&trace.truth)),
        Series::line("reference path", Role::Reference, reference.to_vec()),
    ];
    let mut panel = Panel::new("y, east (m)", "x, north (m)", 420.0, series);
    panel.title = format!("{} filter, fix {} m", filter.name(), filter.paper_fix().sigma());
    panel
}
