//! All filters under equal conditions: which one is right when, and why.

use anyhow::Context;
use cosim::report::{Block, Section, Table, mean, quantile, root_mean_square};

use crate::navigate::{Cell, Cells, Filter, GRADES, Score, fly_all};

/// The number of seeds of the paper's experiment per mission flown here; paired comparisons use
/// half of these: all filters get the same missions.
const SHARE: u32 = 10;

const PAPER: &[Filter] = &[Filter::PaperDynamic, Filter::PaperKinematic];
const MODELLED: &[Filter] = &[Filter::ModelAided, Filter::Dynamic];

/// Words, standard deviation of the fix (m), and parameters of the filter.
type Variant = (&'static str, f64, &'static [(&'static str, &'static str)]);

/// The paper's filters as printed, with one change after another.
const VARIANTS: [Variant; 6] = [
    ("as printed, fix 1.5 m", 1.5, &[]),
    ("without rotation to NED", 1.5, &[("rotate_to_ned", "false")]),
    ("fix 2.5 m", 2.5, &[]),
    ("fix 0.5 m", 0.5, &[]),
    ("F repaired, fix 1.5 m", 1.5, &[("transition", "Repaired")]),
    (
        "F repaired, Q of the velocity log",
        1.5,
        &[("transition", "Repaired"), ("process_noise", "Dvl"), ("dvl_sigma", "0.01")],
    ),
];

/// The section, from separate missions.
pub(crate) fn section(seeds: u32, threads: usize) -> anyhow::Result<Section> {
    let seeds = seeds.div_ceil(SHARE);
    let pairs = seeds.div_ceil(2);
    let outages = GRADES.map(|grade| match grade {
        "Adis16448" => "outage".to_owned(),
        grade => format!("outage-{}", grade.to_lowercase()),
    });
    let named =
        ["BE3", "fix-305", "DIVE", "HELIX"].into_iter().chain(outages.iter().map(String::as_str));
    let cells = named.map(Cell::named).collect::<anyhow::Result<Vec<_>>>()?;
    let compared = fly_all(&cells, 1, seeds, threads)?;
    let (nominal, rest) = compared.split_first().context("no cell was flown")?;
    let (without_fix, rest) = rest.split_first().context("no cell was flown without fixes")?;
    let (spatial, outages) = rest.split_at(2);
    let variants = variants()?;
    let variants = fly_all(&variants, 1, pairs, threads)?;
    let coefficients = coefficients()?;
    let coefficients = fly_all(&coefficients, 1, pairs, threads)?;

    let mut section = Section::new("Which filter, when");
    section.text(format!(
        "The filters of examples/baseline.ssd on the same missions of course BE3: the vehicle steers \
         by its true pose, all filters get the same measurements (fix 0.5 m at 1 Hz, velocity log 0.01 m/s, \
         attitude, depth, inertial unit, rotor speeds) and start with the same error of 0.5 m. \
         {seeds} seeds; median and 95 % over them."
    ));
    section.blocks.push(Block::Table(equal(nominal)));
    section.text(
        "With fixes and velocity log NavModelAided, NavDynamic and NavInertial are equally good, and \
         as good as any filter can be: their models make no difference. The paper's comparison \
         reflects its matrix F.",
    );
    section.blocks.push(Block::Table(by_variant(&variants)));
    section.text(format!(
        "The experiment that explains the paper's Y error, {pairs} seeds: y is worse than x with F as \
         printed, whatever the fix. With the Jacobian of the prediction it is not, with or without \
         dynamics. With the process noise of the velocity log alone y is the better axis, but the \
         filter trusts its prediction too much and the fix too little."
    ));
    section.blocks.push(Block::Table(dead_reckoning(without_fix)));
    section.text(
        "Without fixes, for 305 s from the start, velocity log and heading determine the error: \
         again the filters are equally good.",
    );
    section.blocks.push(Block::Table(by_grade(outages)));
    section.text(
        "Dynamics help without fix and velocity log, here for 60 s: compared with a low-grade \
         inertial unit by an order of magnitude, compared with a tactical-grade one hardly at all. \
         The model-aided filter weights both and is never clearly worse than the better one.",
    );
    section.blocks.push(Block::Table(dimensions(spatial)));
    section.text(
        "Four degrees of freedom are enough for the horizontal position as long as the position \
         rates use the measured roll and pitch; where the vehicle pitches permanently, as on the \
         helix, depth and consistency are slightly worse.",
    );
    section.blocks.push(Block::Table(sensitivity(&coefficients)?));
    section.text(format!(
        "Sensitivity of the same outage, speed changing between 0.3 and 0.1 m/s, to the coefficients \
         of the filter's model, {pairs} seeds: root mean square of the error at the end. With \
         velocity log and fix no coefficient matters. The coefficients that set the speed dominate: \
         thrust gain and quadratic damping."
    ));
    Ok(section)
}

fn scores<'a>(cells: &'a Cells<'_>, filter: Filter) -> &'a [Score] {
    cells.of(filter).unwrap_or_default()
}

fn quantiles(scores: &[Score], of: fn(&Score) -> f64, digits: usize) -> String {
    let values: Vec<f64> = scores.iter().map(of).collect();
    let [median, high] = [0.5, 0.95].map(|p| quantile(&values, p));
    format!("{median:.digits$} / {high:.digits$}")
}

fn mean_nees(scores: &[Score], which: usize) -> f64 {
    mean(&scores.iter().flat_map(|s| s.nees[which].iter().copied()).collect::<Vec<_>>())
}

fn rms(scores: &[Score], of: fn(&Score) -> f64) -> f64 {
    root_mean_square(&scores.iter().map(of).collect::<Vec<_>>())
}

fn equal(nominal: &Cells<'_>) -> Table {
    let mut table = Table::new(
        "All filters under equal conditions: errors after 30 s",
        &[
            "filter",
            "RMSE (m)",
            "z (m)",
            "heading (°)",
            "√(mean P) / RMSE",
            "NEES of x, y (ideal 2)",
            "processor time / real time",
        ],
    );
    for (filter, scores) in &nominal.scores {
        let claimed = mean(&scores.iter().map(|s| s.variance).collect::<Vec<_>>()).sqrt();
        table.push([
            filter.name().to_owned(),
            quantiles(scores, |s| s.settled, 3),
            quantiles(scores, |s| s.depth, 3),
            quantiles(scores, |s| s.heading.to_degrees(), 3),
            ratio(claimed / rms(scores, |s| s.settled)),
            format!("{:.1}", mean_nees(scores, 0)),
            format!("1 / {:.0}", 1.0 / mean(&scores.iter().map(|s| s.load).collect::<Vec<_>>())),
        ]);
    }
    if let Some(bound) = nominal.bound {
        table.push(["Cramér-Rao bound (RMS)".to_owned(), format!("{:.3}", bound.rms)]);
    }
    table
}

/// Two digits after the point, or the power of ten alone of what has run away.
fn ratio(value: f64) -> String {
    if value < 100.0 { format!("{value:.2}") } else { format!("{value:.0e}") }
}

fn dead_reckoning(cells: &Cells<'_>) -> Table {
    let header = ["filter", "RMSE without fixes (m)", "error at the end (m)", "its NEES (ideal 2)"];
    let mut table = Table::new("Without fixes: velocity log, attitude and depth", &header);
    for (filter, scores) in &cells.scores {
        table.push([
            filter.name().to_owned(),
            quantiles(scores, |s| s.window, 2),
            quantiles(scores, |s| s.last, 2),
            format!("{:.1}", mean(&scores.iter().map(|s| s.last_nees).collect::<Vec<_>>())),
        ]);
    }
    table
}

fn variants() -> anyhow::Result<Vec<Cell>> {
    VARIANTS
        .iter()
        .map(|(name, fix, values)| {
            let cell = Cell::named("BE3")?.variant(*name, PAPER);
            let cell = cell.set("fix.sigma", fix).set("fix.rate_hz", 10);
            Ok(PAPER.iter().fold(cell, |cell, filter| {
                let own = |name: &str| format!("{}.{name}", filter.component());
                let cell = cell.set(own("fix_sigma"), fix);
                values.iter().fold(cell, |cell, (name, value)| cell.set(own(name), value))
            }))
        })
        .collect()
}

fn by_variant(variants: &[Cells<'_>]) -> Table {
    let header = ["filters of the paper", "dynamic x", "y", "y / x", "kinematic x", "y", "y / x"];
    let mut table =
        Table::new("The paper's filters, one change at a time: medians of RMSE (m)", &header);
    for cells in variants {
        let mut row = vec![cells.cell.name.clone()];
        for filter in PAPER {
            let median = |axis: usize| {
                let errors = scores(cells, *filter).iter().map(|s| s.axes[axis]);
                quantile(&errors.collect::<Vec<_>>(), 0.5)
            };
            let [x, y] = [median(0), median(1)];
            row.extend([format!("{x:.3}"), format!("{y:.3}"), format!("{:.2}", y / x)]);
        }
        table.push(row);
    }
    table
}

fn by_grade(outages: &[Cells<'_>]) -> Table {
    let mut table = Table::new(
        "Error after 60 s without fix and velocity log by grade of the inertial unit (m)",
        &["filter", "ADIS16448", "industrial", "tactical"],
    );
    for filter in Filter::BEST {
        let cells = outages.iter().map(|cells| quantiles(scores(cells, filter), |s| s.last, 2));
        table.push(std::iter::once(filter.name().to_owned()).chain(cells));
    }
    table
}

fn dimensions(spatial: &[Cells<'_>]) -> Table {
    let mut table = Table::new(
        "Four degrees of freedom (NavDynamic) and six on courses with depth",
        &["course, filter", "RMSE after 30 s (m)", "z (m)", "NEES of x, y, z, heading (ideal 4)"],
    );
    for cells in spatial {
        for (filter, scores) in &cells.scores {
            table.push([
                format!("{}, {}", cells.cell.name, filter.name()),
                quantiles(scores, |s| s.settled, 3),
                quantiles(scores, |s| s.depth, 3),
                format!("{:.1}", mean_nees(scores, 1)),
            ]);
        }
    }
    table
}

/// Names of the groups of coefficients.
const GROUPS: [&str; 4] = ["quadratic damping", "linear damping", "added mass", "thrust gain"];

/// The outage without changes, and with each group 30 % less and 30 % more.
fn coefficients() -> anyhow::Result<Vec<Cell>> {
    let base = Cell::named("outage-speed")?;
    let changed = GROUPS.into_iter().flat_map(|group| [0.7, 1.3].map(|factor| (group, factor)));
    let cells = changed.map(|(group, factor)| {
        let cell = base.clone().variant(group, MODELLED);
        match group {
            "quadratic damping" => cell.damping("*.model", &["quadratic"], factor),
            "linear damping" => cell.damping("*.model", &["linear"], factor),
            "added mass" => cell.added_mass("*.model", factor),
            _ => cell.thrust_gain("tachometer", factor),
        }
    });
    Ok(std::iter::once(base.clone().variant("as identified", MODELLED)).chain(cells).collect())
}

fn sensitivity(coefficients: &[Cells<'_>]) -> anyhow::Result<Table> {
    let mut table = Table::new(
        "Error after the outage, and how a coefficient 30 % less or more changes it",
        &["coefficient", "NavModelAided, −30 %", "+30 %", "NavDynamic, −30 %", "+30 %"],
    );
    let (base, changed) = coefficients.split_first().context("no cell was flown")?;
    let of = |cells: &Cells<'_>, filter| rms(scores(cells, filter), |s| s.last);
    let [aided, dynamic] = [0, 1].map(|i| format!("{:.2} m", of(base, MODELLED[i])));
    table.push([base.cell.name.clone(), aided, String::new(), dynamic, String::new()]);
    for pair in changed.chunks(2) {
        let mut row = vec![pair[0].cell.name.clone()];
        for filter in MODELLED {
            row.extend(pair.iter().map(|cells| {
                format!("{:+.0} %", 100.0 * (of(cells, *filter) / of(base, *filter) - 1.0))
            }));
        }
        table.push(row);
    }
    Ok(table)
}
