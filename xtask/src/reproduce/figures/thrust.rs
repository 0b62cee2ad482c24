//! Thrust of the eight thrusters on BE3.

use cosim::report::{Figure, LegendPlace, Panel, Role, Series, Shape};

use super::{Captioned, over_time, shown};
use crate::reproduce::campaign::{Campaign, SHOWN_SEED};
use crate::reproduce::case::{Course, Filter};

/// Thrusters 0 to 3 above 4 to 7.
pub(super) fn figure(campaign: &Campaign) -> anyhow::Result<Captioned> {
    let trace = shown(campaign, Course::Be3, Filter::Dynamic)?;
    let panel = |first: usize| {
        let series = |i: usize| Series {
            name: format!("thruster {i}"),
            role: Role::Signal(i),
            shape: Shape::Steps(over_time(trace, &trace.thrust[i])),
        };
        Panel::new("time (s)", "thrust (N)", 170.0, (first..first + 4).map(series).collect())
    };
    let title = "BE3: thrust";
    let stacked = Figure::stacked(title, vec![panel(0), panel(4)]);
    Ok(Captioned {
        name: "thrust-BE3".into(),
        figure: Figure { legend: LegendPlace::Right, ..stacked },
        caption: format!(
            "Thrust of the eight thrusters on BE3 with the dynamic filter in the loop, seed \
             {SHOWN_SEED}. The dynamic filter gets these forces; the kinematic filter does not."
        ),
    })
}
