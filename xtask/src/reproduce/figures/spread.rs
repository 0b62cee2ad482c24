//! Distribution of the three measures over seeds beside the paper's single numbers.

use cosim::report::{Figure, Panel, Series, Shape};

use super::{Captioned, role};
use crate::reproduce::campaign::Campaign;
use crate::reproduce::case::{Case, Course, Filter};
use crate::reproduce::metrics::Metrics;
use crate::reproduce::paper::{Printed, printed};

/// Distance of a filter's boxes from the middle of its course.
const ASIDE: f64 = 0.18;

/// One panel per measure.
pub(super) fn figure(campaign: &Campaign) -> Captioned {
    let panels = vec![
        panel(campaign, "Total", |m| m.total, |p| p.total),
        panel(campaign, "X-Kalman RMSE", |m| m.x_rmse, |p| p.x),
        panel(campaign, "Y-Kalman RMSE", |m| m.y_rmse, |p| p.y),
    ];
    let stacked = Figure::stacked("Spread over seeds", panels);
    Captioned {
        name: "spread".into(),
        figure: Figure { columns: 3, common_x: false, ..stacked },
        caption: "Distribution over seeds: box 25 to 75 %, thick bar at the median, whiskers 5 to \
                  95 %. Diamonds are the numbers of the paper's tables."
            .into(),
    }
}

fn panel(
    campaign: &Campaign,
    title: &str,
    measure: fn(&Metrics) -> f64,
    paper: fn(&Printed) -> f64,
) -> Panel {
    let places = |filter: Filter| {
        let aside = if filter == Filter::Dynamic { -ASIDE } else { ASIDE };
        Course::ALL.into_iter().enumerate().map(move |(i, course)| (i as f64 + aside, course))
    };
    let sample = |course: Course, filter: Filter| -> Vec<f64> {
        let runs = campaign
            .metrics(|c: &Case| c.is_in_paper() && (c.course, c.filter) == (course, filter));
        runs.iter().map(measure).collect()
    };
    let boxes = Filter::ALL.map(|filter| Series {
        name: format!("{} filter", filter.name()),
        role: role(filter),
        shape: Shape::Boxes(places(filter).map(|(x, c)| (x, sample(c, filter))).collect()),
    });
    let marks = Filter::ALL.map(|filter| Series {
        name: format!("the paper, {}", filter.name()),
        role: role(filter),
        shape: Shape::Marks(places(filter).map(|(x, c)| (x, paper(&printed(c, filter)))).collect()),
    });
    let series = boxes.into_iter().chain(marks).collect();
    let mut panel = Panel::new("", "error (m)", 220.0, series).titled(title);
    panel.x.categories = Course::ALL.map(|course| course.name().to_string()).to_vec();
    panel
}
