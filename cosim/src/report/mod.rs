//! Reports: figures as SVG, pages as self-contained HTML, and the report of recorded results.
//!
//! A report is plain data until the last step: a [`Figure`] of [`Panel`]s of [`Series`] becomes an
//! SVG text by [`Figure::svg`]; a [`Page`] of paragraphs, tables and figures becomes one HTML file
//! by [`Page::html`]. The same data give the same bytes.
//!
//! | to change | look in |
//! |---|---|
//! | colours and line styles | `style` |
//! | where panels and legends lie | `layout` |
//! | how a series is drawn | `draw` |
//! | the look of the page | `page.html`, `page.css` |
//! | what `cosim report` shows | `results`, `grouping`, `select` |

mod decimate;
mod draw;
mod figure;
mod grouping;
mod layout;
mod legend;
mod page;
mod results;
mod select;
mod statistics;
mod style;
mod table;
mod ticks;

pub use figure::{Axis, Figure, LegendPlace, Panel, Series, Shape};
pub use layout::{Layout, Rect};
pub use page::{Block, Page, Section};
pub use results::{Options, html, svg};
pub use select::{Plot, XyPlot};
pub use statistics::{mean, quantile, root_mean_square};
pub use style::Role;
pub use table::Table;
