//! Goal G1: the bands in which the paper's results count as reproduced, course by course.
//!
//! The goals are about medians over all seeds there could be; a campaign knows them within an
//! interval only. So a verdict has three values: the median lies in the band; it does not, but its
//! interval reaches into the band (too few seeds to tell); or it lies clearly outside.

use super::campaign::Campaign;
use super::case::{Case, Course, Filter};
use super::metrics::{Metrics, Spread};

/// One goal and what was reached.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Verdict {
    /// Course and quantity.
    pub(crate) what: String,
    /// The value reached, a median over seeds, m or a ratio.
    pub(crate) value: f64,
    /// Where the median over all possible seeds lies with 95 % confidence; of a ratio the value.
    pub(crate) interval: [f64; 2],
    /// Least allowed value.
    pub(crate) low: f64,
    /// Greatest allowed value.
    pub(crate) high: f64,
    /// `m` or nothing.
    pub(crate) unit: &'static str,
}

impl Verdict {
    /// Whether the value lies within its bounds; NaN does not.
    pub(crate) fn is_reached(&self) -> bool {
        (self.low..=self.high).contains(&self.value)
    }

    /// The bounds as text.
    pub(crate) fn bounds(&self) -> String {
        let text = match (self.low > 0.0, self.high.is_finite()) {
            (true, true) => format!("{} to {}", self.low, self.high),
            (false, _) => format!("at most {}", self.high),
            (true, false) => format!("at least {}", self.low),
        };
        format!("{text} {}", self.unit).trim_end().to_string()
    }

    /// The value as text.
    pub(crate) fn value(&self) -> String {
        format!("{:.3} {}", self.value, self.unit).trim_end().to_string()
    }

    /// Whether the value lies outside its bounds by more than the seeds leave open.
    pub(crate) fn is_missed(&self) -> bool {
        let [least, greatest] = self.interval;
        // Also when there is no value: NaN compares with nothing.
        !(self.is_reached() || least <= self.high && greatest >= self.low)
    }

    /// The verdict in words.
    pub(crate) fn word(&self) -> String {
        let [least, greatest] = self.interval;
        if self.is_reached() {
            "reached".into()
        } else if self.is_missed() {
            "MISSED".into()
        } else {
            format!("open: these seeds say {least:.3} to {greatest:.3} (95 %)")
        }
    }
}

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
    fn a_median_outside_is_open_while_its_interval_reaches_into_the_band() {
        let verdict = |value, interval| Verdict {
            what: String::new(),
            value,
            interval,
            low: 0.25,
            high: 0.37,
            unit: "m",
        };
        assert!(!verdict(0.24, [0.2, 0.28]).is_missed());
        assert!(!verdict(0.24, [0.2, 0.28]).is_reached());
        assert!(verdict(0.24, [0.23, 0.249]).is_missed());
        assert!(verdict(0.4, [0.38, 0.42]).is_missed());
        assert!(verdict(f64::NAN, [f64::NAN; 2]).is_missed());
        assert!(!verdict(0.3, [0.1, 0.2]).is_missed());
    }

    #[test]
    fn bounds_read_as_they_are_meant() {
        let texts: Vec<String> = of_course("BE1", &[], &[]).iter().map(Verdict::bounds).collect();
        assert_eq!(texts[0], "at most 0.2 m");
        assert_eq!(texts[1], "0.08 to 0.15 m");
        assert_eq!(texts[5], "at least 2.2");
    }
}
