//! One panel: grid, axes and series.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::super::figure::Panel;
use super::super::layout::{Cell, X_AXIS, Y_AXIS};
use super::super::legend::FONT;
use super::coordinate::Coordinate;
use super::{Drawn, INK, Sheet, font, shapes, units};

/// To the left of the label of the vertical axis, px.
const EDGE: f64 = 8.0;
/// Approximate distance of ticks on the horizontal and on the vertical axis, px.
const SPACING: (f64, f64) = (110.0, 36.0);
const GRID: RGBColor = RGBColor(0xE4, 0xE4, 0xE4);
const AXIS: RGBColor = RGBColor(0x9A, 0x9A, 0x9A);

/// The chart of one panel.
pub(super) type Chart<'a, 'b> =
    ChartContext<'a, SVGBackend<'b>, Cartesian2d<Coordinate, Coordinate>>;

/// Draws the panel in its cell.
pub(super) fn draw(sheet: &Sheet, panel: &Panel, cell: &Cell) -> Drawn {
    let x_axis = if cell.x_labelled { X_AXIS } else { 0.0 };
    let area = sheet.clone().shrink(
        (units(cell.data.x - Y_AXIS + EDGE), units(cell.data.y)),
        (units(cell.data.width + Y_AXIS - EDGE), units(cell.data.height + x_axis)),
    );
    title(sheet, panel, cell)?;
    let mut chart = ChartBuilder::on(&area)
        .y_label_area_size(units(Y_AXIS - EDGE))
        .x_label_area_size(units(x_axis))
        .build_cartesian_2d(
            Coordinate::new(&panel.x, cell.x, cell.data.width, SPACING.0),
            Coordinate::new(&panel.y, cell.y, cell.data.height, SPACING.1),
        )?;
    let text = TextStyle::from(font(FONT)).color(&INK);
    chart
        .configure_mesh()
        .bold_line_style(GRID.stroke_width(units(0.75) as u32))
        .light_line_style(TRANSPARENT)
        .axis_style(AXIS.stroke_width(units(0.75) as u32))
        .set_all_tick_mark_size(units(3.0))
        .label_style(text.clone())
        .axis_desc_style(text)
        .x_desc(panel.x.label.clone())
        .y_desc(panel.y.label.clone())
        .draw()?;
    panel.series.iter().try_for_each(|series| shapes::draw(&mut chart, series, cell))
}

fn title(sheet: &Sheet, panel: &Panel, cell: &Cell) -> Drawn {
    let style = TextStyle::from(font(12.5).style(FontStyle::Bold))
        .color(&INK)
        .pos(Pos::new(HPos::Left, VPos::Bottom));
    sheet.draw_text(&panel.title, &style, (units(cell.data.x), units(cell.data.y - 3.0)))
}
