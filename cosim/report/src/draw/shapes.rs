//! Series as lines, bands, diamonds and boxes.

use plotters::element::{PathElement, Polygon, Rectangle};
use plotters::prelude::*;

use super::super::decimate::{decimate, finite_runs};
use super::super::figure::{Series, Shape};
use super::super::layout::Cell;
use super::super::statistics::quantile;
use super::super::style::Role;
use super::panel::Chart;
use super::{Drawn, Sheet, units};

/// Draws one series into its panel.
pub(super) fn draw(chart: &mut Chart, series: &Series, cell: &Cell) -> Drawn {
    match &series.shape {
        Shape::Line(points) => lines(chart, points, series.role, cell),
        Shape::Steps(points) => lines(chart, &stairs(points), series.role, cell),
        Shape::Band(points) => bands(chart, points, series.role, cell),
        Shape::Marks(points) => marks(chart, points, series.role),
        Shape::Boxes(boxes) => {
            boxes.iter().try_for_each(|(x, sample)| one_box(chart, *x, sample, series.role, cell))
        }
    }
}

fn is_finite(point: &(f64, f64)) -> bool {
    point.0.is_finite() && point.1.is_finite()
}

/// Size of a pixel in data units.
fn pixel(cell: &Cell) -> (f64, f64) {
    ((cell.x.1 - cell.x.0) / cell.data.width, (cell.y.1 - cell.y.0) / cell.data.height)
}

fn lines(chart: &mut Chart, points: &[(f64, f64)], role: Role, cell: &Cell) -> Drawn {
    let area = chart.plotting_area();
    let (sheet, corner) = (area.strip_coord_spec(), area.get_base_pixel());
    for run in finite_runs(points, is_finite) {
        let thinned = decimate(&run, pixel(cell)).into_iter();
        let drawn = thinned.map(|p| area.map_coordinate(&p));
        stroke(&sheet, drawn.map(|p| (p.0 - corner.0, p.1 - corner.1)).collect(), role)?;
    }
    Ok(())
}

/// A line in drawing units in the style of its role.
pub(super) fn stroke(sheet: &Sheet, points: Vec<(i32, i32)>, role: Role) -> Drawn {
    let style = role.colour().stroke_width(units(role.width()) as u32);
    match role.dash() {
        None => sheet.draw(&PathElement::new(points, style)),
        Some((dash, gap)) => {
            let (dash, gap) = (units(dash) as u32, units(gap) as u32);
            let series = DashedLineSeries::new(points, dash, gap, style);
            series.into_iter().try_for_each(|element| sheet.draw(&element))
        }
    }
}

/// The vertices of a curve that holds each value until the next.
fn stairs(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let corners = points.windows(2).flat_map(|w| [w[0], (w[1].0, w[0].1)]);
    corners.chain(points.last().copied()).collect()
}

/// A lighter fill of the role's colour.
pub(super) fn fill(role: Role) -> ShapeStyle {
    role.colour().mix(0.2).filled()
}

fn bands(chart: &mut Chart, points: &[(f64, f64, f64)], role: Role, cell: &Cell) -> Drawn {
    let finite = |p: &(f64, f64, f64)| p.0.is_finite() && p.1.is_finite() && p.2.is_finite();
    for run in finite_runs(points, finite) {
        let lower: Vec<_> = run.iter().map(|p| (p.0, p.1)).collect();
        let upper: Vec<_> = run.iter().map(|p| (p.0, p.2)).collect();
        let mut outline = decimate(&lower, pixel(cell));
        outline.extend(decimate(&upper, pixel(cell)).into_iter().rev());
        chart.plotting_area().draw(&Polygon::new(outline, fill(role)))?;
    }
    Ok(())
}

fn marks(chart: &mut Chart, points: &[(f64, f64)], role: Role) -> Drawn {
    for point in points.iter().copied().filter(is_finite) {
        let mark = EmptyElement::at(point) + diamond((0, 0), role);
        chart.plotting_area().draw(&mark)?;
    }
    Ok(())
}

/// A diamond around a position in drawing units.
pub(super) fn diamond((x, y): (i32, i32), role: Role) -> Polygon<(i32, i32)> {
    let half = units(4.5);
    let corners = [(x - half, y), (x, y - half), (x + half, y), (x, y + half)];
    Polygon::new(corners, role.colour().filled())
}

fn one_box(chart: &mut Chart, x: f64, sample: &[f64], role: Role, cell: &Cell) -> Drawn {
    let at = |p: f64| quantile(sample, p);
    if !x.is_finite() || at(0.5).is_nan() {
        return Ok(());
    }
    let half = 13.0 * pixel(cell).0;
    let line = role.colour().stroke_width(units(1.25) as u32);
    let area = chart.plotting_area();
    let path = |points: [(f64, f64); 2], style: ShapeStyle| {
        area.draw(&PathElement::new(points.to_vec(), style))
    };
    let corners = [(x - half, at(0.75)), (x + half, at(0.25))];
    area.draw(&Rectangle::new(corners, fill(role)))?;
    // As a path: the library writes the outline of a rectangle without its width.
    let [(left, top), (right, bottom)] = corners;
    let outline = vec![(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
    area.draw(&PathElement::new(outline, line))?;
    path([(x - half, at(0.5)), (x + half, at(0.5))], line.stroke_width(units(2.5) as u32))?;
    for (box_end, whisker_end) in [(0.25, 0.05), (0.75, 0.95)] {
        path([(x, at(box_end)), (x, at(whisker_end))], line)?;
        path([(x - half / 2.0, at(whisker_end)), (x + half / 2.0, at(whisker_end))], line)?;
    }
    Ok(())
}
