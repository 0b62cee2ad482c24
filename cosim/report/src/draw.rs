//! Draws a planned figure as SVG.
//!
//! The library counts in whole pixels, so it draws on a sheet [`UNIT`] times as large, and the
//! header of the picture scales it down: curves are smooth and the numbers stay short.

mod coordinate;
mod panel;
mod shapes;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::legend::{Entry, FONT, GAP, Legend, SWATCH, Sample};
use super::{Figure, Layout, Rect};
use cosim_core::{Code, Error, Result};

/// Drawing units per pixel.
const UNIT: f64 = 4.0;
/// The divisor of the library for font sizes.
const FONT_SCALE: f64 = 1.24;

type Sheet<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// Pixels to whole drawing units.
fn units(px: f64) -> i32 {
    (px * UNIT).round() as i32
}

impl Figure {
    /// The figure as one SVG element with a white background.
    pub fn svg(&self) -> Result<String> {
        let layout = Layout::of(self);
        let size = (units(layout.width), units(layout.height));
        let mut svg = String::new();
        {
            let sheet = SVGBackend::with_string(&mut svg, (size.0 as u32, size.1 as u32))
                .into_drawing_area();
            draw(&sheet, self, &layout).map_err(|e| {
                Error::new(Code::Report, format!("cannot draw the figure '{}'", self.title)).why(e)
            })?;
        }
        Ok(with_head(&svg, size, &self.title))
    }
}

/// Replaces the library's header by one with the size in pixels and a title.
fn with_head(svg: &str, size: (i32, i32), title: &str) -> String {
    let body = svg.split_once('>').map_or("", |(_, body)| body);
    let title = title.replace('&', "&amp;").replace('<', "&lt;");
    let (width, height) = (f64::from(size.0) / UNIT, f64::from(size.1) / UNIT);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {} {}\" role=\"img\">\n<title>{title}</title>{body}",
        size.0, size.1
    )
}

fn draw(sheet: &Sheet, figure: &Figure, layout: &Layout) -> Drawn {
    sheet.fill(&WHITE)?;
    let bold = font(14.0).style(FontStyle::Bold);
    sheet.draw_text(&figure.title, &bold.color(&INK), (units(12.0), units(9.0)))?;
    for (panel, cell) in figure.panels.iter().zip(&layout.cells) {
        panel::draw(sheet, panel, cell)?;
        legend(sheet, &cell.legend)?;
    }
    legend(sheet, &layout.legend)?;
    sheet.present()
}

/// Text and axis lines.
const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);

fn font(px: f64) -> FontDesc<'static> {
    ("sans-serif", px * UNIT * FONT_SCALE).into_font()
}

fn legend(sheet: &Sheet, legend: &Legend) -> Drawn {
    legend.entries.iter().try_for_each(|(entry, rect)| legend_entry(sheet, entry, *rect))
}

fn legend_entry(sheet: &Sheet, entry: &Entry, rect: Rect) -> Drawn {
    let middle = rect.y + rect.height / 2.0;
    let (left, right) = (units(rect.x), units(rect.x + SWATCH));
    match entry.sample {
        Sample::Line => {
            let ends = [(left, units(middle)), (right, units(middle))];
            shapes::stroke(sheet, ends.to_vec(), entry.role)?;
        }
        Sample::Band => {
            let corners = [(left, units(middle - 5.0)), (right, units(middle + 5.0))];
            sheet.draw(&Rectangle::new(corners, shapes::fill(entry.role)))?;
        }
        Sample::Mark => {
            let centre = (units(rect.x + SWATCH / 2.0), units(middle));
            sheet.draw(&shapes::diamond(centre, entry.role))?;
        }
    }
    let style = TextStyle::from(font(FONT)).color(&INK).pos(Pos::new(HPos::Left, VPos::Center));
    sheet.draw_text(&entry.name, &style, (units(rect.x + SWATCH + GAP), units(middle)))
}

#[cfg(test)]
mod tests {
    use super::super::{Panel, Role, Series};
    use super::*;

    /// The vertices of each line of the picture, px.
    fn lines(svg: &str) -> Vec<Vec<(f64, f64)>> {
        let points = svg.split("points=\"").skip(1).filter_map(|rest| rest.split('"').next());
        let number = |text: &str| text.parse::<f64>().unwrap() / UNIT;
        let corner = |pair: &str| pair.split_once(',').map(|(x, y)| (number(x), number(y)));
        points.map(|list| list.split_whitespace().filter_map(corner).collect()).collect()
    }

    fn square(x: f64, y: f64, side: f64) -> Figure {
        let corners = [(x, y), (x + side, y), (x + side, y + side), (x, y + side), (x, y)];
        let series = vec![Series::line("path", Role::Truth, corners.to_vec())];
        let line = Series::line("", Role::Truth, vec![(0.0, 0.0), (60.0, 25.0)]);
        let panel = Panel::new("x (m)", "y (m)", 300.0, [series, vec![line]].concat());
        Figure::paths("A & B", 1, vec![panel])
    }

    #[test]
    fn a_square_is_drawn_as_a_square_where_the_plan_says() {
        let figure = square(10.0, 5.0, 12.0);
        let cell = &Layout::of(&figure).cells[0];
        let scale = cell.data.width / (cell.x.1 - cell.x.0);
        let corners = lines(&figure.svg().unwrap()).into_iter().find(|l| l.len() == 5).unwrap();
        let expected = |x: f64, y: f64| {
            (cell.data.x + (x - cell.x.0) * scale, cell.data.y + (cell.y.1 - y) * scale)
        };
        for (drawn, (x, y)) in corners.iter().zip([(10.0, 5.0), (22.0, 5.0), (22.0, 17.0)]) {
            let (x, y) = expected(x, y);
            assert!((drawn.0 - x).abs() < 0.6 && (drawn.1 - y).abs() < 0.6, "{drawn:?} {x} {y}");
        }
    }

    #[test]
    fn the_same_figure_gives_the_same_bytes_and_titles_are_escaped() {
        let svg = square(0.0, 0.0, 1.0).svg().unwrap();
        assert_eq!(svg, square(0.0, 0.0, 1.0).svg().unwrap());
        assert!(svg.contains("<title>A &amp; B</title>") && svg.ends_with("</svg>\n"));
    }

    #[test]
    fn nan_interrupts_a_line_and_no_data_draw_an_empty_panel() {
        let points = vec![(0.0, 0.0), (1.0, 1.0), (2.0, f64::NAN), (3.0, 1.0), (4.0, 0.0)];
        let figure = |points| {
            let series = vec![Series::line("", Role::Truth, points)];
            Figure::stacked("", vec![Panel::new("t (s)", "y", 100.0, series)])
        };
        // Only the series has the width of its role; grid and axes are thinner.
        let drawn = |points| figure(points).svg().unwrap().matches("stroke-width=\"6\"").count();
        assert_eq!((drawn(points), drawn(vec![])), (2, 0));
        assert!(!figure(vec![(f64::NAN, 1.0)]).svg().unwrap().contains("NaN"));
    }
}
