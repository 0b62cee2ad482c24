//! The goals, cell by cell, with the results of an independent simulation of the same filters.

use cosim::report::quantile;

use super::bound::Bound;
use super::cell::{Cell, GRADES, of_grade};
use super::filter::Filter;
use super::score::{CHANNELS, Score};
use super::smoother::Smoothed;
use super::statistic::{Number, anis, mean_of, number, over, quantile_of, ratio_of, share_in_band};
use crate::experiment::Verdict;

/// A number of a cell with its verdict.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) cell: String,
    pub(crate) filter: &'static str,
    pub(crate) verdict: Verdict,
    /// The result of the independent simulation.
    pub(crate) reference: &'static str,
}

/// Bounds of a number: none, from below, from above, or both.
type Bounds = [f64; 2];
const SHOWN: Bounds = [f64::NEG_INFINITY, f64::INFINITY];

fn at_most(high: f64) -> Bounds {
    [f64::NEG_INFINITY, high]
}

fn at_least(low: f64) -> Bounds {
    [low, f64::INFINITY]
}

/// Scores of the filters of a cell, seed by seed.
pub(crate) struct Cells<'a> {
    pub(crate) cell: &'a Cell,
    pub(crate) scores: Vec<(Filter, Vec<Score>)>,
    /// The Cramér-Rao bound of the RMSE after settling.
    pub(crate) bound: Option<Bound>,
}

impl Cells<'_> {
    /// The scores of a filter.
    pub(crate) fn of(&self, filter: Filter) -> Option<&[Score]> {
        self.scores.iter().find(|(f, _)| *f == filter).map(|(_, scores)| scores.as_slice())
    }

    /// All rows of the cell.
    pub(crate) fn rows(&self) -> Vec<Row> {
        let mut rows = Vec::new();
        let name = self.cell.name.as_str();
        for (filter, scores) in &self.scores {
            let mut add = Rows { rows: &mut rows, cell: name, filter: *filter };
            match name {
                "BE1" | "BE2" | "BE3" => nominal(&mut add, scores, self.bound),
                "DIVE" | "HELIX" => spatial(&mut add, scores),
                _ if name.starts_with("loop-") => in_loop(&mut add, scores),
                _ if name.starts_with("fix-") => fix_off(&mut add, scores),
                _ if self.cell.smoothed => smoothed(&mut add, scores),
                _ => outage(&mut add, scores, self.cell),
            }
        }
        if name.starts_with("outage") {
            self.against_the_better(&mut rows);
        }
        rows
    }

    /// The ratio of the model-aided filter to the better of the other two.
    fn against_the_better(&self, rows: &mut Vec<Row>) {
        let [Some(aided), Some(dynamic), Some(inertial)] = Filter::BEST.map(|f| self.of(f)) else {
            return;
        };
        let full = aided.len() >= 200;
        let industrial = self.cell.grade == GRADES[1] && !self.cell.name.contains("current");
        let mut add = Rows { rows, cell: &self.cell.name, filter: Filter::ModelAided };
        for (p, what, goal) in [
            (0.5, "median / better of NavDynamic, NavInertial", if full { 1.05 } else { 1.1 }),
            (0.95, "95 % / better of NavDynamic, NavInertial", 1.15),
        ] {
            let goal = if industrial && p == 0.5 { 0.8 } else { goal };
            let ratio = number(aided.len(), |drawn| {
                let [a, d, i] = [aided, dynamic, inertial].map(|s| over(s, drawn, p, |s| s.last));
                a / d.min(i)
            });
            add.row(what, "", ratio, at_most(goal), "");
        }
    }
}

/// The ratio of the model-aided filter's errors after an outage with and without a lost propeller
/// (G6), for the seeds that both cells have.
pub(crate) fn of_losses(results: &[Cells<'_>]) -> Vec<Row> {
    let aided = |name: &str| {
        let found = results.iter().find(|cells| cells.cell.name == name)?;
        found.of(Filter::ModelAided)
    };
    let mut rows = Vec::new();
    for grade in GRADES {
        for kind in ["propeller-before", "propeller-during"] {
            let name = of_grade(kind, grade);
            let Some((sound, lost)) = aided(&of_grade("outage", grade)).zip(aided(&name)) else {
                continue;
            };
            let median = |scores, drawn: &[usize]| over(scores, drawn, 0.5, |s: &Score| s.last);
            let ratio = number(sound.len().min(lost.len()), |drawn| {
                median(lost, drawn) / median(sound, drawn)
            });
            let mut add = Rows { rows: &mut rows, cell: &name, filter: Filter::ModelAided };
            add.row("median / that without a loss", "", ratio, at_most(1.15), "1.00 to 1.07");
        }
    }
    rows
}

/// The improvement by the smoother, as a share of the filter's RMSE.
fn smoothed(add: &mut Rows<'_>, scores: &[Score]) {
    type Part = (&'static str, fn(&Score) -> f64, fn(&Smoothed) -> f64, f64, &'static str);
    let parts: [Part; 3] = [
        ("whole mission", |s| s.rmse, |s| s.rmse, 0.45, "0.51"),
        ("after 30 s", |s| s.settled, |s| s.settled, 0.3, "0.34"),
        ("in the outage", |s| s.window, |s| s.window, 0.6, "0.64 to 0.94"),
    ];
    // A mission with an outage is measured within it, another one as a whole.
    let wanted = if add.cell == "smoother" { &parts[..2] } else { &parts[2..] };
    for (what, filter, smoother, goal, reference) in wanted {
        let gain = number(scores.len(), |drawn| {
            let median = |of: &dyn Fn(&Score) -> f64| {
                quantile(&drawn.iter().map(|i| of(&scores[*i])).collect::<Vec<_>>(), 0.5)
            };
            let of_smoother = |s: &Score| s.smoothed.as_ref().map_or(f64::NAN, smoother);
            1.0 - median(&of_smoother) / median(filter)
        });
        add.row(&format!("gain of the smoother, {what}"), "", gain, at_least(*goal), reference);
    }
}

/// The output for rows.
struct Rows<'a> {
    rows: &'a mut Vec<Row>,
    cell: &'a str,
    filter: Filter,
}

impl Rows<'_> {
    fn row(
        &mut self,
        what: &str,
        unit: &'static str,
        number: Number,
        [low, high]: Bounds,
        reference: &'static str,
    ) {
        let Number { value, interval } = number;
        let verdict = Verdict { what: what.into(), value, interval, low, high, unit };
        let (cell, filter) = (self.cell.to_owned(), self.filter.name());
        self.rows.push(Row { cell, filter, verdict, reference });
    }

    /// Median and 95 % of a measure in metres.
    fn spread(
        &mut self,
        what: &str,
        scores: &[Score],
        of: fn(&Score) -> f64,
        goals: [Bounds; 2],
        references: [&'static str; 2],
    ) {
        for (((p, name), goal), reference) in
            [(0.5, "median"), (0.95, "95 %")].into_iter().zip(goals).zip(references)
        {
            self.row(&format!("{what}, {name}"), "m", quantile_of(scores, p, of), goal, reference);
        }
    }

    fn is_best(&self) -> bool {
        Filter::BEST.contains(&self.filter)
    }

    /// Bounds for those filters that should reach them.
    fn goal(&self, bounds: Bounds) -> Bounds {
        if self.is_best() { bounds } else { SHOWN }
    }

    fn goals(&self, [median, high]: [f64; 2]) -> [Bounds; 2] {
        [self.goal(at_most(median)), self.goal(at_most(high))]
    }
}

/// Accuracy (G2) and consistency (G4) of nominal missions.
fn nominal(add: &mut Rows<'_>, scores: &[Score], bound: Option<Bound>) {
    let whole = if add.cell == "BE1" { [0.125, 0.175] } else { [0.11, 0.155] };
    let goals = add.goals(whole);
    add.spread("RMSE", scores, |s| s.rmse, goals, ["", ""]);
    let axis = add.goal(at_most(0.085));
    add.row("x RMSE, median", "m", quantile_of(scores, 0.5, |s| s.axes[0]), axis, "");
    add.row("y RMSE, median", "m", quantile_of(scores, 0.5, |s| s.axes[1]), axis, "");
    let goals = add.goals([0.08, 0.11]);
    add.spread("RMSE after 30 s", scores, |s| s.settled, goals, ["0.069", "0.096"]);
    if let Some(Bound { rms: least, high }) = bound {
        let ratio = number(scores.len(), |drawn| rms(scores, drawn) / least);
        let name = format!("RMSE after 30 s / Cramér-Rao bound of {least:.4} m");
        add.row(&name, "", ratio, SHOWN, "1");
        let ratio = number(scores.len(), |drawn| over(scores, drawn, 0.95, |s| s.settled) / high);
        let name = format!("RMSE after 30 s, 95 % / that at the bound, {high:.3} m");
        add.row(&name, "", ratio, SHOWN, "1");
    }
    add.row(
        "z RMSE after 30 s, median",
        "m",
        quantile_of(scores, 0.5, |s| s.depth),
        SHOWN,
        "0.023",
    );
    let claimed = number(scores.len(), |drawn| {
        let variance = drawn.iter().map(|i| scores[*i].variance).sum::<f64>();
        (variance / drawn.len() as f64).sqrt() / rms(scores, drawn)
    });
    let goal = add.goal(at_least(0.95));
    add.row("√(mean P) / RMSE", "", claimed, goal, "0.97 to 1.06");
    consistency(add, scores);
}

/// Root mean square error after settling of all missions drawn.
fn rms(scores: &[Score], drawn: &[usize]) -> f64 {
    let squares = drawn.iter().map(|i| scores[*i].settled * scores[*i].settled);
    (squares.sum::<f64>() / drawn.len() as f64).sqrt()
}

fn consistency(add: &mut Rows<'_>, scores: &[Score]) {
    for (which, components, least, reference) in
        [(0, 2.0, 0.95, "0.989 to 1"), (1, 4.0, 0.9, "0.928 to 0.99")]
    {
        let value = share_in_band(scores, which, components);
        // Errors of the position last for 90 s: a mission has three independent stretches. Where each is
        // in the band with 0.95, the share has a standard deviation of sqrt(0.95 0.05/3) = 0.126.
        let interval = [value - 1.96 * 0.126, value + 1.96 * 0.126];
        let what = format!("time with ANEES{components} in its 95 % band");
        let goal = add.goal(at_least(least));
        add.row(&what, "", Number { value, interval }, goal, reference);
    }
    let goal = add.goal([3.6, 4.4]);
    add.row("mean ANEES4", "", nees4(scores), goal, "3.8 to 4.15");
    for (channel, (name, dimension)) in CHANNELS.into_iter().enumerate() {
        let number = anis(scores, channel);
        // A filter that uses a channel as an input has no innovation of it.
        if number.value > 0.0 {
            // Within 5 %; rounded for display.
            let goal = [0.95, 1.05].map(|share| (1e3 * share * dimension).round() / 1e3);
            let goal = add.goal(goal);
            add.row(&format!("ANIS of {name}"), "", number, goal, "");
        }
    }
}

fn nees4(scores: &[Score]) -> Number {
    ratio_of(scores, |s| [s.nees[1].iter().sum(), s.nees[1].len() as f64])
}

/// Dive and helix.
fn spatial(add: &mut Rows<'_>, scores: &[Score]) {
    add.spread("RMSE after 30 s", scores, |s| s.settled, [SHOWN; 2], ["", ""]);
    add.row("z RMSE after 30 s, median", "m", quantile_of(scores, 0.5, |s| s.depth), SHOWN, "");
    let in_space = add.filter != Filter::Dynamic;
    let goal = if in_space { at_most(4.5) } else { SHOWN };
    add.row("mean ANEES4", "", nees4(scores), goal, if in_space { "3.8 to 4.2" } else { "" });
}

/// The loop closed on the estimate (G3).
fn in_loop(add: &mut Rows<'_>, scores: &[Score]) {
    let goal = match add.cell {
        "loop-BE1" => at_most(0.07),
        "loop-BE2" => at_most(0.06),
        "loop-BE3" => at_most(0.055),
        _ => SHOWN,
    };
    add.row("Total, median", "m", quantile_of(scores, 0.5, |s| s.total), goal, "");
    add.row(
        "depth off its course, median",
        "m",
        quantile_of(scores, 0.5, |s| s.vertical),
        SHOWN,
        "",
    );
    let value = scores.iter().filter(|s| s.finished).count() as f64 / scores.len() as f64;
    add.row("finished", "", Number { value, interval: [value; 2] }, at_least(1.0), "");
}

/// Without fixes (G5).
fn fix_off(add: &mut Rows<'_>, scores: &[Score]) {
    let (goals, references) = match add.cell {
        "fix-60" => ([0.08, 0.13], ["0.07", "0.11"]),
        "fix-305" => ([0.19, 0.32], ["0.18", "0.30"]),
        _ => ([0.7, 1.7], ["0.55 to 0.68", "1.2 to 1.7"]),
    };
    // The inertial filter dead-reckons by the velocity log like the others.
    let goals = add.goals(goals);
    add.spread("RMSE without fixes", scores, |s| s.window, goals, references);
    add.row("NEES2 at its end", "", mean_of(scores, |s| s.last_nees), SHOWN, "");
}

/// Without fixes and velocity (G5), and with a propeller lost (G6).
fn outage(add: &mut Rows<'_>, scores: &[Score], cell: &Cell) {
    let kind = cell.name.trim_end_matches("-industrial").trim_end_matches("-tactical");
    let (goals, references) = match kind {
        "outage" => ([1.75, 3.8], ["1.60", "3.66"]),
        "outage-current" => ([1.95, 4.3], ["1.79 to 1.81", "3.66 to 4.29"]),
        "outage-speed" => ([2.1, 4.3], ["1.75 to 2.01", "4.04 to 4.17"]),
        "outage-mass-20" | "outage-mass+20" => ([2.7, 4.9], ["1.72 to 2.56", "3.83 to 4.78"]),
        "outage-damping-20" | "outage-damping+20" => {
            ([1.85, 4.0], ["1.40 to 1.74", "3.40 to 3.87"])
        }
        "outage-dead" => ([1.85, 3.9], ["1.60 to 1.71", "3.46 to 3.82"]),
        _ => ([f64::INFINITY; 2], ["", ""]),
    };
    // The absolute goals are those of the two filters with a model and the cheapest inertial unit.
    let modelled = add.filter != Filter::Inertial && cell.grade == GRADES[0];
    let (goals, references) =
        if modelled { (goals.map(at_most), references) } else { ([SHOWN; 2], ["", ""]) };
    add.spread("error at the end", scores, |s| s.last, goals, references);
    let nees = mean_of(scores, |s| s.last_nees);
    let goal = if kind == "outage" && modelled { [1.5, 3.0] } else { SHOWN };
    add.row("NEES2 at the end", "", nees, goal, "1.6 to 2.7");
    if add.filter == Filter::Inertial {
        return;
    }
    if cell.propeller_lost == Some(100.0) {
        add.row("loss detected after, median", "s", detected(scores, 0.5), at_most(2.0), "1.0");
        add.row("loss detected after, 95 %", "s", detected(scores, 0.95), at_most(5.0), "2.6");
        let right = mean_of(scores, |s| f64::from(u8::from(s.right)));
        add.row("right thruster named", "", right, at_least(0.95), "1");
    }
    let alarms = ratio_of(scores, |s| [s.false_alarms, s.hours]);
    add.row("false alarms", "1/h", alarms, at_most(0.125), "0 in 8.1 h");
}

fn detected(scores: &[Score], p: f64) -> Number {
    quantile_of(scores, p, |s| s.detected)
}
