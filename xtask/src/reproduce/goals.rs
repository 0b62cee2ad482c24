//! Goal G1: the bands in which the paper's results count as reproduced, course by course.

use super::campaign::Campaign;
use super::case::{Case, Course, Filter};
use super::metrics::{Metrics, Spread};
use crate::experiment::Verdict;

/// The verdicts of all courses.
pub(crate) fn verdicts(campaign: &Campaign) -> Vec<Verdict> {
    Course::ALL
        .into_iter()
        .flat_map(|course| {
            let runs = |filter| {
                campaign
                    .metrics(|c: &Case| c.is_in_paper() && c.course == course && c.filter == filter)
            };
            of_course(course.name(), &runs(Filter::Dynamic), &runs(Filter::Kinematic))
        })
        .collect()
}

/// The verdicts of one course from the runs of both filters.
fn of_course(course: &str, dynamic: &[Metrics], kinematic: &[Metrics]) -> Vec<Verdict> {
    let metres = |what: &str, spread: &Spread, low, high| Verdict {
        what: format!("{course} {what}"),
        value: spread.median,
        interval: spread.median_interval,
        low,
        high,
        unit: "m",
    };
    let ratio = |what: &str, value, low| Verdict {
        what: format!("{course} {what}"),
        value,
        interval: [value; 2],
        low,
        high: f64::INFINITY,
        unit: "",
    };
    let (y_dynamic, y_kinematic) =
        (Spread::of(dynamic, |m| m.y_rmse), Spread::of(kinematic, |m| m.y_rmse));
    let x_kinematic = Spread::of(kinematic, |m| m.x_rmse);
    vec![
        metres("dynamic Total", &Spread::of(dynamic, |m| m.total), 0.0, 0.20),
        metres("dynamic X-Kalman", &Spread::of(dynamic, |m| m.x_rmse), 0.08, 0.15),
        metres("dynamic Y-Kalman", &y_dynamic, 0.25, 0.37),
        metres("kinematic X-Kalman", &x_kinematic, 0.33, 0.50),
        metres("kinematic Y-Kalman", &y_kinematic, 0.95, 1.5),
        ratio("Y kinematic / Y dynamic", y_kinematic.median / y_dynamic.median, 2.2),
        ratio("kinematic Y / X", y_kinematic.median / x_kinematic.median, 2.4),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(total: f64, x_rmse: f64, y_rmse: f64) -> Vec<Metrics> {
        vec![Metrics { total, x_rmse, y_rmse, y_mse: y_rmse * y_rmse, finish_time: 200.0 }]
    }

    #[test]
    fn the_prototype_s_results_reach_every_goal() {
        let verdicts = of_course("BE1", &run(0.164, 0.11, 0.304), &run(0.444, 0.423, 1.2));
        assert_eq!(verdicts.len(), 7);
        assert!(verdicts.iter().all(Verdict::is_reached), "{verdicts:?}");
    }

    #[test]
    fn each_goal_can_be_missed() {
        let missed = |dynamic: &[Metrics], kinematic: &[Metrics]| {
            let verdicts = of_course("BE1", dynamic, kinematic);
            let missed = verdicts.into_iter().filter(|v| !v.is_reached());
            missed.map(|v| v.what).collect::<Vec<_>>()
        };
        let (dynamic, kinematic) = (run(0.164, 0.11, 0.304), run(0.444, 0.423, 1.2));
        assert_eq!(missed(&run(0.21, 0.11, 0.304), &kinematic), ["BE1 dynamic Total"]);
        assert_eq!(missed(&run(0.1, 0.07, 0.304), &kinematic), ["BE1 dynamic X-Kalman"]);
        assert_eq!(missed(&run(0.1, 0.11, 0.24), &kinematic), ["BE1 dynamic Y-Kalman"]);
        let far = missed(&dynamic, &run(0.4, 0.423, 1.6));
        assert_eq!(far, ["BE1 kinematic Y-Kalman"]);
        assert_eq!(missed(&dynamic, &run(0.4, 0.48, 1.0)), ["BE1 kinematic Y / X"]);
        assert_eq!(missed(&run(0.1, 0.1, 0.37), &run(0.4, 0.33, 0.8)).len(), 2);
        assert_eq!(missed(&dynamic, &[]).len(), 4);
    }

    #[test]
    fn bounds_read_as_they_are_meant() {
        let texts: Vec<String> = of_course("BE1", &[], &[]).iter().map(Verdict::bounds).collect();
        assert_eq!(texts[0], "at most 0.2 m");
        assert_eq!(texts[1], "0.08 to 0.15 m");
        assert_eq!(texts[5], "at least 2.2");
    }
}
