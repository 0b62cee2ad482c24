//! The part of `documentation/index.html` before the variables: the author's text with its
//! equations, and a plot of the reference run.
//!
//! The text is Markdown with equations in LaTeX between `$` signs, which become MathML: browsers
//! display it directly, without a network.

use super::reference::{Run, STEP_S};
use anyhow::{Result, anyhow};
use cosim::report::{Figure, Panel, Role, Series, Shape};
use fmu_kit::kernel::{Entry, Group};
use pulldown_cmark::{Event, Options, Parser, html};
use pulldown_latex::{RenderConfig, Storage, config::DisplayMode, push_mathml};

/// Height of one panel of the plot, px.
const PANEL_HEIGHT: f64 = 110.0;

/// The chapters of a component, as HTML.
pub(crate) fn chapters(component: &Entry, text: &str, run: &Run) -> Result<String> {
    let name = component.info().name;
    let mut chapters = "<img class=\"icon\" src=\"../model.png\" alt=\"\">\n".to_owned();
    chapters.push_str(&markdown(text)?);
    chapters.push_str(&format!(
        "<h2 id=\"reference\">Reference run</h2>\n<p>The default experiment, {} s by \
         co-simulation in steps of {STEP_S} s. Inputs and result are in \
         <code>extra/org.fmi-standard.fmi-ls-ref/</code> as <code>{name}_in.csv</code> and \
         <code>{name}_out.csv</code>; a simulation with these inputs gives this result.</p>\n\
         <figure>{}</figure>\n",
        component.info().stop_time_s,
        plot(component, run)?,
    ));
    Ok(chapters)
}

/// Markdown to HTML, LaTeX to MathML.
fn markdown(text: &str) -> Result<String> {
    let mut failure = None;
    let events = Parser::new_ext(text, Options::ENABLE_MATH | Options::ENABLE_TABLES);
    let events = events.map(|event| {
        let math = match &event {
            Event::InlineMath(latex) => mathml(latex, DisplayMode::Inline),
            Event::DisplayMath(latex) => mathml(latex, DisplayMode::Block),
            _ => return event,
        };
        match math {
            Ok(math) => Event::InlineHtml(math.into()),
            Err(error) => {
                failure.get_or_insert(error);
                event
            }
        }
    });
    let mut page = String::new();
    html::push_html(&mut page, events);
    failure.map_or(Ok(page), Err)
}

pub(crate) fn mathml(latex: &str, display_mode: DisplayMode) -> Result<String> {
    let storage = Storage::new();
    let events = pulldown_latex::Parser::new(latex, &storage).collect::<Result<Vec<_>, _>>();
    let events = events.map_err(|error| anyhow!("equation `{latex}`: {error}"))?;
    let mut text = String::new();
    let configuration = RenderConfig { display_mode, ..RenderConfig::default() };
    let events = events.into_iter().map(Ok::<_, std::convert::Infallible>);
    push_mathml(&mut text, events, configuration)?;
    Ok(text)
}

/// The outputs over time, one panel for each quantity of one unit.
pub(crate) fn plot(component: &Entry, run: &Run) -> Result<String> {
    let mut groups: Vec<((String, &str), Vec<&str>)> = Vec::new();
    for (_, output) in component.table().group(Group::Output) {
        let (Some(unit), Some((quantity, _))) =
            (output.unit.as_deref(), output.name.rsplit_once('.').or(Some((&output.name, ""))))
        else {
            continue;
        };
        if output.name == "stamp" || unit == "1" {
            continue;
        }
        let quantity = quantity.split('[').next().unwrap_or_default();
        let key = (quantity.to_owned(), unit);
        match groups.iter_mut().find(|(known, _)| *known == key) {
            Some((_, names)) => names.push(&output.name),
            None => groups.push((key, vec![&output.name])),
        }
    }
    let sampled = component.info().sampled;
    let panels = groups.into_iter().map(|((quantity, unit), names)| {
        let series = names.iter().enumerate().map(|(index, name)| {
            let course = run.outputs.course(name);
            let shape = if sampled { Shape::Steps(course) } else { Shape::Line(course) };
            Series { name: (*name).to_owned(), role: Role::Signal(index), shape }
        });
        Panel::new("time (s)", &format!("{quantity} ({unit})"), PANEL_HEIGHT, series.collect())
    });
    let name = component.info().name;
    let mut figure = Figure::stacked(format!("{name}: reference run"), panels.collect());
    figure.legend = cosim::report::LegendPlace::Right;
    Ok(figure.svg()?)
}
