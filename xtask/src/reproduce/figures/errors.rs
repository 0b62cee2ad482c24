//! Estimation errors of both filters with their reported three sigma, on BE3.

use cosim::report::{Figure, Panel, Series};

use super::{Captioned, over_time, role, shown};
use crate::reproduce::campaign::{Campaign, SHOWN_SEED};
use crate::reproduce::case::{Course, Filter};
use crate::reproduce::trace::Trace;

/// Axes shown: index into a pose and label.
const ROWS: [(usize, &str); 3] = [(0, "x error (m)"), (1, "y error (m)"), (3, "yaw error (rad)")];

/// A row for each axis, a column for each filter, with the same scale in each row.
pub(super) fn figure(campaign: &Campaign) -> anyhow::Result<Captioned> {
    let mut panels = Vec::new();
    for (row, (axis, label)) in ROWS.into_iter().enumerate() {
        let traces = Filter::ALL.map(|filter| shown(campaign, Course::Be3, filter));
        let [dynamic, kinematic] = traces;
        let traces = [dynamic?, kinematic?];
        let greatest = traces.iter().flat_map(|t| t.error(axis)).fold(0.0, |m, e| e.abs().max(m));
        for (filter, trace) in Filter::ALL.into_iter().zip(traces) {
            let mut panel = panel(trace, filter, axis, label);
            panel.y.range = Some((-1.15 * greatest, 1.15 * greatest));
            if row == 0 {
                panel.title = format!("{} filter", filter.name());
            }
            panels.push(panel);
        }
    }
    let title = "BE3: estimation errors";
    Ok(Captioned {
        name: "errors-BE3".into(),
        figure: Figure { columns: 2, ..Figure::stacked(title, panels) },
        caption: format!(
            "Errors of the estimate on BE3, seed {SHOWN_SEED}, with the ± 3 σ that each filter \
             reports (cut off at the edge where it is wider). Both columns of a row have one scale."
        ),
    })
}

fn panel(trace: &Trace, filter: Filter, axis: usize, label: &str) -> Panel {
    let sigma = &trace.sigma[axis];
    let band = trace.time.iter().zip(sigma).map(|(t, s)| (*t, -3.0 * s, 3.0 * s)).collect();
    let series = vec![
        Series::band(&format!("± 3 σ, {} filter", filter.name()), role(filter), band),
        Series::line(
            &format!("error, {} filter", filter.name()),
            role(filter),
            over_time(trace, &trace.error(axis)),
        ),
    ];
    Panel::new("time (s)", label, 130.0, series)
}
