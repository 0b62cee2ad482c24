//! Figure 4 of the paper: surge acceleration by the dynamic model and by the IMU, on BE3.

use cosim::report::{Figure, Panel, Role, Series};

use super::{Captioned, over_time, shown};
use crate::reproduce::campaign::{Campaign, SHOWN_SEED};
use crate::reproduce::case::{Course, Filter};
use crate::reproduce::trace::Trace;

/// The part shown in the second panel: the first turn, s.
const DETAIL_S: (f64, f64) = (60.0, 110.0);

/// Whole run and detail.
pub(super) fn figure(campaign: &Campaign) -> anyhow::Result<Captioned> {
    let trace = shown(campaign, Course::Be3, Filter::Dynamic)?;
    let whole = panel(trace, (f64::NEG_INFINITY, f64::INFINITY)).titled("whole course");
    let detail = panel(trace, DETAIL_S).titled("first turn");
    let title = "BE3: surge acceleration by model and by IMU";
    Ok(Captioned {
        name: "acceleration-BE3".into(),
        figure: Figure {
            common_x: false,
            ..Figure::stacked(title, vec![whole, detail])
        },
        caption: format!(
            "Fig. 4 of the paper: surge acceleration on BE3 by the dynamic model (eq. 27, from DVL \
             velocity and thrust), by the IMU (specific force less gravity) and the true one, \
             seed {SHOWN_SEED}."
        ),
    })
}

fn panel(trace: &Trace, (from, to): (f64, f64)) -> Panel {
    let line = |name: &str, role: Role, values: &[f64]| {
        let mut points = over_time(trace, values);
        points.retain(|(t, _)| (from..=to).contains(t));
        Series::line(name, role, points)
    };
    let series = vec![
        line("IMU", Role::Measurement, &trace.imu_acceleration),
        line("dynamic model", Role::Estimate1, &trace.filter_acceleration),
        line("truth", Role::Truth, &trace.surge_acceleration),
    ];
    Panel::new("time (s)", "acceleration (m/s²)", 190.0, series)
}
