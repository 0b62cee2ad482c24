//! The tables: 7, 8 and 9 beside the paper's numbers, the filters at equal fixes, the goals.

use cosim::report::Table;

use super::campaign::Campaign;
use super::case::{Case, Course, Filter, Fix};
use super::metrics::{Metrics, Spread};
use super::paper::printed;
use crate::experiment::Verdict;

/// One of the paper's tables, with medians over seeds and the paper's numbers.
pub(crate) fn of_course(campaign: &Campaign, course: Course) -> Table {
    let caption =
        format!("Table {}: {}, {}", course.number() + 6, course.name(), course.description());
    let header = ["error", "dynamic", "5–95 %", "the paper", "kinematic", "5–95 %", "the paper"];
    let mut table = Table::new(caption, &header);
    let runs = Filter::ALL.map(|filter| {
        campaign.metrics(|c: &Case| c.is_in_paper() && c.course == course && c.filter == filter)
    });
    let paper = Filter::ALL.map(|filter| printed(course, filter));
    let mut row = |name: &str, measure: fn(&Metrics) -> f64, paper: [String; 2]| {
        let [dynamic, kinematic] = [&runs[0], &runs[1]].map(|r| cells(&Spread::of(r, measure)));
        let [dynamic_paper, kinematic_paper] = paper;
        let [d, d_range] = dynamic;
        let [k, k_range] = kinematic;
        table.push([name.to_string(), d, d_range, dynamic_paper, k, k_range, kinematic_paper]);
    };
    row("Total (m)", |m| m.total, paper.map(|p| metres(p.total)));
    row("X-Kalman RMSE (m)", |m| m.x_rmse, paper.map(|p| metres(p.x)));
    row("Y-Kalman RMSE (m)", |m| m.y_rmse, paper.map(|p| metres(p.y)));
    row("Y-Kalman MSE (m²)", |m| m.y_mse, paper.map(|p| metres(p.y)));
    let [dynamic, kinematic] = [&runs[0], &runs[1]].map(|r| finished(r));
    table.push(["finished", &dynamic, "", "", &kinematic, "", ""]);
    table
}

/// Both filters with the same position fix, on the same noise.
pub(crate) fn equal_fix(campaign: &Campaign) -> Table {
    let header = [
        "course, fix",
        "dynamic Total",
        "X",
        "Y",
        "kinematic Total",
        "X",
        "Y",
        "Y kinematic / dynamic",
    ];
    let mut table = Table::new("Both filters with the same position fix: medians (m)", &header);
    for course in Course::ALL {
        for fix in Fix::ALL {
            let medians = Filter::ALL.map(|filter| {
                let runs = campaign
                    .metrics(|c: &Case| (c.course, c.fix, c.filter) == (course, fix, filter));
                let measures: [fn(&Metrics) -> f64; 3] = [|m| m.total, |m| m.x_rmse, |m| m.y_rmse];
                measures.map(|measure| Spread::of(&runs, measure).median)
            });
            let mut row = vec![format!("{}, {} m", course.name(), fix.sigma())];
            row.extend(medians.iter().flatten().map(|m| metres(*m)));
            row.push(format!("{:.2}", medians[1][2] / medians[0][2]));
            table.push(row);
        }
    }
    table
}

/// The goals with their verdicts.
pub(crate) fn goals(verdicts: &[Verdict]) -> Table {
    let mut table = Table::new("Goal G1", &["quantity (median)", "value", "goal", "verdict"]);
    for verdict in verdicts {
        let cells = [verdict.what.clone(), verdict.value(), verdict.bounds()];
        table.push(cells.into_iter().chain([verdict.word()]));
    }
    table
}

fn cells(spread: &Spread) -> [String; 2] {
    [metres(spread.median), format!("{}–{}", metres(spread.low), metres(spread.high))]
}

/// Millimetres are enough.
fn metres(value: f64) -> String {
    format!("{value:.3}")
}

fn finished(runs: &[Metrics]) -> String {
    let finished = runs.iter().filter(|m| !m.finish_time.is_nan()).count();
    format!("{finished} of {}", runs.len())
}

#[cfg(test)]
mod tests {
    use cosim::campaign::{Row, Status};

    use super::super::campaign::Outcome;
    use super::*;

    fn campaign() -> Campaign {
        let outcome = |case: Case| {
            let scale = if case.filter == Filter::Dynamic { 0.1 } else { 0.4 };
            let y_rmse = 3.0 * scale * case.fix.sigma();
            let finish_time = if case.seed == 2 { f64::NAN } else { 190.0 };
            let (total, x_rmse, y_mse) = (scale, 2.0 * scale, y_rmse * y_rmse);
            let metrics = Metrics { total, x_rmse, y_rmse, y_mse, finish_time };
            let row = Row::without_figures(0, Status::Ok, "");
            Outcome { case, metrics, row, trace: None }
        };
        Campaign { outcomes: Case::all(3).into_iter().map(outcome).collect() }
    }

    #[test]
    fn tables_stand_beside_the_paper_s_numbers() {
        let text = of_course(&campaign(), Course::Be2).text();
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].starts_with("Table 8: BE2"));
        let cells = |line: &str| line.split("  ").map(str::trim).filter(|c| !c.is_empty()).count();
        assert!(lines[3].contains("0.100") && lines[3].contains("0.166"), "{}", lines[3]);
        assert!(lines[5].contains("3.000") && lines[5].contains("4.336"), "{}", lines[5]);
        assert_eq!(cells(lines[3]), 7);
        assert!(lines[7].contains("2 of 3"));
    }

    #[test]
    fn the_fair_comparison_has_a_row_for_each_course_and_fix() {
        let table = equal_fix(&campaign());
        assert_eq!(table.rows.len(), 6);
        assert_eq!(table.rows[0].len(), table.header.len());
        assert_eq!(table.rows[1][3], "0.750");
        assert_eq!(table.rows[1][7], "4.00");
    }
}
