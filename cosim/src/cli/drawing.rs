//! A system as a graph: components in stepping order, one arrow for all connections between two of
//! them; solid if values arrive at once, dashed if they are held for a step.

use std::fmt::Write;

use cosim::System;
use cosim::system::Cause;

/// All connections between two components with the same delay.
struct Arrow {
    from: usize,
    to: usize,
    held: bool,
    /// The connected variables, one line each.
    names: Vec<String>,
}

fn arrows(system: &System) -> Vec<Arrow> {
    let mut arrows: Vec<Arrow> = Vec::new();
    for (connection, delay) in system.connections().iter().zip(system.delays()) {
        let (from, to) = (connection.from.component, connection.to.component);
        let held = !matches!(delay.cause, Cause::Fresh | Cause::Solved(_));
        let variable = |port: cosim::system::Port| {
            system.components()[port.component].model.variable_name(port.variable).to_owned()
        };
        let name = format!("{} \u{2192} {}", variable(connection.from), variable(connection.to));
        match arrows.iter_mut().find(|a| (a.from, a.to, a.held) == (from, to, held)) {
            Some(arrow) => arrow.names.push(name),
            None => arrows.push(Arrow { from, to, held, names: vec![name] }),
        }
    }
    arrows
}

/// The label of an arrow: its connection, or the number of connections.
fn label(arrow: &Arrow) -> String {
    match &arrow.names[..] {
        [one] => one.clone(),
        more => format!("{} connections", more.len()),
    }
}

pub(super) fn dot(system: &System) -> String {
    let quoted = |text: &str| {
        format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n"))
    };
    let name = |component: usize| quoted(&system.components()[component].name);
    let mut text = format!("digraph {} {{\n  rankdir=LR;\n", quoted(system.name()));
    text += "  node [shape=box];\n";
    for &component in &system.order().sequence {
        let shown = &system.components()[component];
        let label = quoted(&format!("{}\nevery {}", shown.name, shown.step));
        _ = writeln!(text, "  {} [label={label}];", name(component));
    }
    for arrow in arrows(system) {
        let style = if arrow.held { ", style=dashed" } else { "" };
        let (label, tip) = (quoted(&label(&arrow)), quoted(&arrow.names.join("\n")));
        let (from, to) = (name(arrow.from), name(arrow.to));
        _ = writeln!(text, "  {from} -> {to} [label={label}, tooltip={tip}{style}];");
    }
    text + "}\n"
}

const HEIGHT: f64 = 44.0;
const ROW: f64 = 84.0;
const GAP: f64 = 150.0;
const MARGIN: f64 = 30.0;
/// Approximate width of a character of a name.
const CHARACTER: f64 = 7.5;

/// Where a component is drawn.
#[derive(Clone, Copy, Default)]
struct Place {
    column: usize,
    row: usize,
    x: f64,
    y: f64,
    width: f64,
}

/// Each component is placed to the right of those whose values it gets at once, and of those that
/// come before it in the order if it gets their values held.
fn places(system: &System, arrows: &[Arrow]) -> Vec<Place> {
    let sequence = &system.order().sequence;
    let mut places = vec![Place::default(); system.components().len()];
    let rank = |component: usize| sequence.iter().position(|&c| c == component);
    let mut rows: Vec<usize> = Vec::new();
    for &component in sequence {
        let before = arrows.iter().filter(|a| a.to == component && rank(a.from) < rank(component));
        let column = before.map(|a| places[a.from].column + 1).max().unwrap_or(0);
        rows.resize(rows.len().max(column + 1), 0);
        let name = system.components()[component].name.chars().count();
        let width = (name.max(10) as f64).mul_add(CHARACTER, 20.0);
        places[component] = Place { column, row: rows[column], width, ..Place::default() };
        rows[column] += 1;
    }
    let widest = |column: usize| {
        places.iter().filter(|p| p.column == column).map(|p| p.width).fold(0.0, f64::max)
    };
    let mut left = vec![MARGIN];
    for column in 0..rows.len() {
        left.push(left[column] + widest(column) + GAP);
    }
    for place in &mut places {
        place.x = left[place.column];
        place.y = MARGIN + place.row as f64 * ROW;
    }
    places
}

pub(super) fn svg(system: &System) -> String {
    let arrows = arrows(system);
    let places = places(system, &arrows);
    let far = |of: &dyn Fn(&Place) -> f64| places.iter().map(of).fold(0.0, f64::max);
    let (right, bottom) = (far(&|p| p.x + p.width), far(&|p| p.y + HEIGHT));
    // Backward arrows go below everything.
    let backward = |arrow: &&Arrow| places[arrow.from].column >= places[arrow.to].column;
    let back = arrows.iter().filter(backward).count() as f64;
    let (width, height) = (right + MARGIN, bottom + MARGIN + 22.0 * back);
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
         height=\"{height}\" font-family=\"sans-serif\" font-size=\"13\">\n\
         <title>{}</title>\n\
         <defs><marker id=\"tip\" viewBox=\"0 0 10 10\" refX=\"10\" refY=\"5\" markerWidth=\"8\" \
         markerHeight=\"8\" orient=\"auto\"><path d=\"M0 0L10 5L0 10z\"/></marker></defs>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        escaped(system.name())
    );
    let mut lane = bottom;
    for arrow in &arrows {
        let (from, to) = (&places[arrow.from], &places[arrow.to]);
        let (x0, y0) = (from.x + from.width, from.y + HEIGHT / 2.0);
        let (x1, y1) = (to.x, to.y + HEIGHT / 2.0);
        let (way, at) = if backward(&arrow) {
            lane += 22.0;
            let (out, back) = (x0 + 24.0, x1 - 24.0);
            let way = format!(
                "M{x0} {y0}C{out} {y0} {out} {lane} {x0} {lane}H{x1}C{back} {lane} {back} {y1} {x1} {y1}"
            );
            (way, ((x0 + x1) / 2.0, lane))
        } else {
            let middle = (x0 + x1) / 2.0;
            (format!("M{x0} {y0}C{middle} {y0} {middle} {y1} {x1} {y1}"), (middle, (y0 + y1) / 2.0))
        };
        let dashes = if arrow.held { " stroke-dasharray=\"5 4\"" } else { "" };
        _ = writeln!(
            text,
            "<g><title>{}</title><path d=\"{way}\" fill=\"none\" stroke=\"black\"{dashes} \
             marker-end=\"url(#tip)\"/><text x=\"{}\" y=\"{}\" font-size=\"11\" \
             text-anchor=\"middle\">{}</text></g>",
            escaped(&arrow.names.join("\n")),
            at.0,
            at.1 - 4.0,
            escaped(&label(arrow))
        );
    }
    for (component, place) in system.components().iter().zip(&places) {
        let Place { x, y, width, .. } = place;
        let (middle, first, second) = (x + width / 2.0, y + 18.0, y + 34.0);
        _ = writeln!(
            text,
            "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{HEIGHT}\" rx=\"4\" \
             fill=\"#eef\" stroke=\"black\"/><text x=\"{middle}\" y=\"{first}\" \
             text-anchor=\"middle\">{}</text><text x=\"{middle}\" y=\"{second}\" font-size=\"11\" \
             text-anchor=\"middle\">every {}</text>",
            escaped(&component.name),
            component.step
        );
    }
    text + "</svg>\n"
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
