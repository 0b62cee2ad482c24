//! Figure 4 of the paper: surge acceleration by the dynamic model and by the IMU, on BE3.

use cosim::report::{Figure, Panel, Role, Series};

use super::{Captioned, over_time, shown};
use crate::reproduce::campaign::{Campaign, SHOWN_SEED};
use crate::reproduce::case::{Course, Filter};

/// With the IMU, and without it on a separate scale.
pub(super) fn figure(campaign: &Campaign) -> anyhow::Result<Captioned> {
    let trace = shown(campaign, Course::Be3, Filter::Dynamic)?;
    let line =
        |name: &str, role: Role, values: &[f64]| Series::line(name, role, over_time(trace, values));
    let imu = line("IMU", Role::Measurement, &trace.imu_acceleration);
    let model = line("dynamic model", Role::Estimate1, &trace.filter_acceleration);
    let truth = line("truth", Role::Truth, &trace.surge_acceleration);
    let panel = |series: Vec<Series>| Panel::new("time (s)", "acceleration (m/s²)", 190.0, series);
    let panels = vec![
        panel(vec![imu, truth.clone(), model.clone()]).titled("IMU, model and truth"),
        panel(vec![truth, model]).titled("model and truth"),
    ];
    Ok(Captioned {
        name: "acceleration-BE3".into(),
        figure: Figure::stacked("BE3: surge acceleration by model and by IMU", panels),
        caption: format!(
            "Fig. 4 of the paper: surge acceleration on BE3 by the dynamic model (eq. 27, from DVL \
             velocity and thrust), by the IMU (specific force less gravity, with the bias that it \
             has after switching on) and the true one, seed {SHOWN_SEED}. The lower panel shows \
             model and truth on their own scale."
        ),
    })
}
