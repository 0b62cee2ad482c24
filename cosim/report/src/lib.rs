//! Reports: figures as SVG, pages as self-contained HTML, and the report of recorded results.
//!
//! A document is plain data until the last step: a [`Figure`] of [`Panel`]s of [`Series`] becomes
//! an SVG text by [`Figure::svg`]; a [`Page`] of paragraphs, tables and figures becomes one HTML
//! file by [`Page::html`]. An interactive report is data in JSON with a script that shows them;
//! both kinds of page have the same style. The same data give the same bytes.
//!
//! | to change | look in |
//! |---|---|
//! | colours and line styles of figures | `style` |
//! | positions of panels and legends | `layout` |
//! | how a series is drawn | `draw` |
//! | the style of pages | `page/base.css`, `page/report.css` |
//! | the behaviour of a report | `page/js` |
//! | the content of a run's report | `run` |
//! | the content of a campaign's report | `cosim_campaign::report` |

#![forbid(unsafe_code)]

#[cfg(feature = "pictures")]
mod convert;
#[cfg(not(feature = "pictures"))]
#[path = "convert/none.rs"]
mod convert;
mod decimate;
mod declared;
mod document;
mod draw;
mod figure;
mod grouping;
mod layout;
mod legend;
mod numbers;
mod page;
mod results;
mod run;
mod select;
mod statistics;
mod style;
mod table;
mod ticks;
mod units;

pub use figure::{Axis, Figure, LegendPlace, Panel, Series, Shape};
pub use layout::{Layout, Rect};
pub use page::{Block, Page, Section};
pub use results::{Options, Picture, html, picture};
pub use run::{Choice, Estimate};
pub use select::{Plot, XyPlot};
pub use statistics::quantile_of_sorted;
pub use statistics::{chi_square_quantile, mean, quantile, root_mean_square};
pub use style::Role;
pub use table::Table;
pub use units::Units;

pub use document::live_page;
pub use document::{Document, Term, run_terms};
pub use numbers::{Numbers, rounded};
pub use run::{Shown as ShownAs, Trace, freedom};
