// One run: its path, the quality of the estimates, faults, and everything that was recorded.
import { choice, details, el, facts, table } from "./dom.js";
import { Clock, placeAt, valueAt } from "./clock.js";
import { groupColour } from "./distribution.js";
import { num, withUnit } from "./format.js";
import { extent, Plane } from "./plane.js";
import { spaceOf } from "./space.js";
import { colour, onTheme } from "./theme.js";
import { timePlot, timeSlider, zoomButtons } from "./timeplot.js";

/** The radius in sigmas of an ellipse that contains 95 % of a bivariate normal distribution. */
const HOLDS_95 = Math.sqrt(5.991464547107979);

/** The colour of an estimate depends on its index. */
function pathColour(paths, path) {
  if (path.role === "truth" || path.role === "course") return colour(path.role);
  return path.role === "fix" ? colour("c3") : groupColour(number(paths, path));
}

/** The width of a path and its dashes, for canvas pixels of this size; a course is dotted. */
function penOf(ctx, ratio, paths, path) {
  ctx.lineWidth = (path.role === "estimate" ? 1.8 : 2.5) * ratio;
  ctx.lineCap = path.role === "course" ? "round" : "butt";
  const dashes = { truth: [], course: [0, 6] }[path.role] ?? [[9, 3], [3, 3], [12, 3, 3, 3]][number(paths, path) % 3];
  ctx.setLineDash(dashes.map((d) => d * ratio));
}

function number(paths, path) {
  return paths.filter((other) => other.role === "estimate").indexOf(path);
}

/** Half axes and the angle from east of a covariance; x is north. */
function ellipse(xx, xy, yy) {
  const [mean, half] = [(xx + yy) / 2, (yy - xx) / 2];
  const root = Math.hypot(half, xy);
  return { a: HOLDS_95 * Math.sqrt(mean + root), b: HOLDS_95 * Math.sqrt(Math.max(mean - root, 0)), angle: Math.atan2(xy, half) / 2 };
}

function drawEllipse(ctx, at, path, entry) {
  const { at: places, xx, xy, yy } = path.ellipses;
  if (xx[entry] == null || yy[entry] == null) return;
  const [north, east] = [path.x[places[entry]], path.y[places[entry]]];
  if (north == null || east == null) return;
  const { a, b, angle } = ellipse(xx[entry], xy[entry] ?? 0, yy[entry]);
  const [x, y] = at(east, north);
  const scale = Math.abs(at(east + 1, north)[0] - x);
  // The ellipse of an estimator that has lost track would cover the map.
  if (a * scale > 2 * ctx.canvas.width) return;
  ctx.beginPath();
  ctx.ellipse(x, y, a * scale, b * scale, -angle, 0, 2 * Math.PI);
  ctx.stroke();
}

function drawPath(ctx, at, ratio, paths, path, now, t) {
  ctx.strokeStyle = ctx.fillStyle = pathColour(paths, path);
  if (path.role === "fix") {
    ctx.globalAlpha = 0.55;
    path.x.forEach((x, i) => {
      ctx.beginPath();
      ctx.arc(...at(path.y[i], x), 2 * ratio, 0, 2 * Math.PI);
      ctx.fill();
    });
    ctx.globalAlpha = 1;
    return;
  }
  penOf(ctx, ratio, paths, path);
  ctx.beginPath();
  let pen = false;
  path.x.forEach((x, i) => {
    if (x == null || path.y[i] == null) pen = false;
    else {
      const point = at(path.y[i], x);
      if (pen) ctx.lineTo(...point);
      else ctx.moveTo(...point);
      pen = true;
    }
  });
  ctx.stroke();
  ctx.setLineDash([]);
  if (!path.ellipses) return;
  ctx.lineWidth = ratio;
  ctx.globalAlpha = 0.45;
  if (!path.sparse) path.ellipses.at.forEach((_, entry) => drawEllipse(ctx, at, path, entry));
  ctx.globalAlpha = 1;
  ctx.lineWidth = 2.5 * ratio;
  drawEllipse(ctx, at, path, placeAt(path.ellipses.at.map((i) => t[i]), now));
}

/** The positions of the vehicle and its estimates, as arrows on the map. */
function markers(plane, map, clock) {
  const moving = map.paths.filter((path) => path.role !== "fix");
  const arrows = moving.map(() => el("div", { class: "vehicle" }));
  const place = () => {
    if (!plane.u || plane.u.scales.x.min == null) return;
    moving.forEach((path, i) => {
      const arrow = arrows[i];
      if (arrow.parentNode !== plane.u.over) plane.u.over.append(arrow);
      const [north, east] = [path.x, path.y].map((values) => valueAt(map.t, values, clock.now));
      arrow.hidden = path.hidden || north == null || east == null;
      if (arrow.hidden) return;
      const yaw = path.yaw?.[placeAt(map.t, clock.now)];
      // Without a heading it points nowhere.
      arrow.classList.toggle("round", yaw == null);
      arrow.style.color = pathColour(map.paths, path);
      arrow.style.transform = `translate(${plane.u.valToPos(east, "x")}px, ${plane.u.valToPos(north, "y")}px) rotate(${yaw ?? 0}rad)`;
    });
  };
  plane.moved.add(() => queueMicrotask(place));
  clock.onCursor(() => {
    place();
    plane.redraw();
  });
  onTheme(plane.canvas, place);
}

function mapOf(map, clock) {
  const [xs, ys] = [map.paths.map((path) => path.x), map.paths.map((path) => path.y)];
  const [north, east] = [extent(xs), extent(ys)];
  if (!north || !east) return el("p", { class: "soft" }, "The paths have no finite position: there is no map.");
  // The course is where the vehicle is to be, at another time.
  const passed = map.paths.filter((path) => path.role === "truth" || path.role === "estimate");
  const plane = new Plane({
    x: { label: "east (m)", range: east }, y: { label: "north (m)", range: north }, equal: true,
    paint: (ctx, at, ratio) => {
      const depth = ({ role }) => ["fix", "course"].indexOf(role) + 1 || 3;
      const order = [...map.paths].sort((a, b) => depth(a) - depth(b));
      for (const path of order.filter((path) => !path.hidden)) drawPath(ctx, at, ratio, map.paths, path, clock.now, map.t);
    },
    pointed: (x, y, near) => {
      let [least, time] = [near, null];
      for (const path of passed) {
        path.x.forEach((value, i) => {
          if (value == null || path.y[i] == null) return;
          const apart = Math.hypot(value - y, path.y[i] - x);
          if (apart < least) [least, time] = [apart, map.t[i]];
        });
      }
      if (time != null) clock.set(time);
    },
    spoken: `Map with ${map.paths.map((path) => path.name).join(", ")}: ${num(north[1] - north[0])} m from south to north, ${num(east[1] - east[0])} m from west to east`,
  });
  markers(plane, map, clock);
  // With many estimates, ellipses would hide the paths.
  const estimates = map.paths.filter((path) => path.role === "estimate");
  const samples = map.paths.map((path) => {
    const box = el("input", { type: "checkbox", checked: true, onchange: () => {
      path.hidden = !box.checked;
      plane.redraw();
      clock.set(clock.now);
    } });
    path.sparse = estimates.indexOf(path) > 0;
    const sample = el("i", { class: path.role === "fix" ? "dot" : null });
    const paint = () => {
      sample.style.borderColor = pathColour(map.paths, path);
      if (path.role === "fix") sample.style.background = pathColour(map.paths, path);
      else sample.style.borderTopStyle = { truth: "solid", course: "dotted" }[path.role] ?? "dashed";
    };
    paint();
    onTheme(sample, paint);
    return el("li", {}, el("label", {}, box, sample, `${path.name}${path.role === "course" ? ", course" : path.ellipses ? ", 95 % ellipses" : ""}`));
  });
  return el("figure", { class: "plot", id: "map" }, el("figcaption", {}, "Map: north up"), plane.canvas,
    el("ul", { class: "legend" }, samples), plane.buttons("map"));
}

/** A slider for the instant, and the values at that instant. */
function instant(trace, clock) {
  const body = el("tbody");
  const moving = (trace.map?.paths ?? []).filter((path) => path.role !== "fix");
  const truth = moving.find((path) => path.role === "truth");
  clock.onCursor((now) => {
    const rows = moving.map((path) => {
      const at = (of) => (of[0] ? valueAt(trace.map.t, of[0], now) : null);
      const [north, east, depth] = [at([path.x]), at([path.y]), at([path.z])];
      const real = truth && path !== truth ? [at([truth.x]), at([truth.y])] : [null, null];
      const apart = [north, east, ...real].includes(null) ? null : Math.hypot(north - real[0], east - real[1]);
      return el("tr", {}, el("th", { scope: "row", class: "text" }, path.name),
        [north, east, depth, apart].map((value) => el("td", {}, num(value))));
    });
    body.replaceChildren(...rows);
  });
  const active = el("p", { class: "small" });
  clock.onCursor((now) => {
    const acting = trace.faults.filter(({ from, until }) => from <= now && now < (until ?? Infinity));
    active.textContent = acting.length ? `Acting now: ${acting.map(({ label }) => label).join("; ")}` : "";
  });
  const head = ["path", "north (m)", "east (m)", "depth (m)", "from truth (m)"];
  return el("section", { "aria-label": "Instant" }, timeSlider(clock),
    moving.length > 0 && el("div", { class: "table", tabindex: "0", role: "region", "aria-label": "Positions at this instant" },
      el("table", { id: "instant" }, el("thead", {}, el("tr", {}, head.map((name) => el("th", { scope: "col" }, name)))), body)), active);
}

function faultList(faults, stop) {
  if (faults.length === 0) return null;
  const row = ({ label, from, until }) => [label, num(from, 6), until == null ? `${num(stop, 6)} (the end)` : num(until, 6)];
  return table("What was wrong, shaded in the plots", ["fault", "from (s)", "until (s)"], faults.map(row), [0]);
}

/** The value of a plot whose only curve is constant. */
function constant({ lines, band, limits }) {
  const [first, ...rest] = lines[0].v;
  return lines.length === 1 && !band && !limits && rest.every((value) => value === first) ? first : null;
}

/** Maximum number of plots under one heading; if there are more, only those of the first component are open. */
const AT_ONCE = 10;

function sections({ plots, map, faults }, clock) {
  const grid = (list) => [
    el("div", { class: "plots" }, list.filter((plot) => constant(plot) == null).map((plot) => timePlot(plot, clock, faults))),
    el("p", { class: "small" }, list.filter((plot) => constant(plot) != null)
      .map((plot) => `${plot.title} is ${withUnit(num(constant(plot)), plot.unit)} all the time`).join("; "))];
  const names = [...new Set(plots.map((plot) => plot.section))];
  return names.map((name) => {
    const own = plots.filter((plot) => plot.section === name);
    const space = name === "Depth and heading" && map && spaceOf(map, clock, (path) => pathColour(map.paths, path), (ctx, ratio, path) => penOf(ctx, ratio, map.paths, path));
    if (own.length <= AT_ONCE) {
      const shown = grid(own);
      if (space) shown[0].append(space);
      return el("section", {}, el("h2", {}, name), shown);
    }
    const component = (plot) => plot.title.split(".")[0];
    const components = [...new Set(own.map(component))];
    return el("section", {}, el("h2", {}, name), components.map((of, place) => {
      const list = own.filter((plot) => component(plot) === of);
      return details(`${of} (${list.length} plots)`, () => grid(list), place === 0);
    }));
  });
}

function planeOf({ title, x, y, lines }) {
  const [rangeX, rangeY] = [extent(lines.map((line) => line.x)), extent(lines.map((line) => line.y))];
  if (!rangeX || !rangeY) return el("p", { class: "soft" }, `${title}: no finite values.`);
  const plane = new Plane({
    x: { label: x, range: rangeX }, y: { label: y, range: rangeY }, equal: true, spoken: `${title}: ${y} against ${x}`,
    paint: (ctx, at, ratio) => lines.forEach((line, place) => {
      ctx.strokeStyle = groupColour(place);
      ctx.lineWidth = 1.8 * ratio;
      ctx.setLineDash(place % 2 ? [6 * ratio, 3 * ratio] : []);
      ctx.beginPath();
      line.x.forEach((value, i) => value != null && line.y[i] != null && ctx.lineTo(...at(value, line.y[i])));
      ctx.stroke();
    }),
  });
  const legend = lines.map((line, place) => {
    const sample = el("i");
    sample.style.borderColor = `var(--c${(place % 8) + 1})`;
    return el("li", {}, sample, line.name);
  });
  return el("figure", { class: "plot" }, el("figcaption", {}, title), plane.canvas, el("ul", { class: "legend" }, legend), plane.buttons(title));
}

/** The name of a variable whose component has a section. */
function fullName(section, name) {
  return section === "variables" ? name : `${section}.${name}`;
}

/** All variables: plots by component, filtered by name, and a table. */
function everything(trace, clock) {
  const components = [...new Set(trace.signals.map((plot) => plot.section))];
  const list = el("div", { class: "plots" });
  let [component, word] = [0, ""];
  const refill = () => {
    const wanted = trace.signals.filter((plot) => (word
      ? [plot.section, plot.title, ...plot.lines.map((line) => line.name)].join(" ").toLowerCase().includes(word)
      : plot.section === components[component]));
    const shown = wanted.slice(0, 60);
    list.replaceChildren(...shown.map((plot) => timePlot({ ...plot, title: `${plot.section}: ${plot.title}` }, clock, trace.faults)));
    if (wanted.length > shown.length) list.append(el("p", { class: "soft" }, `${wanted.length - shown.length} more plots: search for a longer word.`));
    const plotted = new Set(trace.signals.flatMap((plot) => plot.lines.map((line) => fullName(plot.section, line.name))));
    const hidden = word ? trace.table.filter(({ name }) => name.toLowerCase().includes(word) && !plotted.has(name)).length : 0;
    if (hidden > 0) list.append(el("p", { class: "soft" }, `Not plotted, because they do not change or because there is no room: ${hidden} with this word. Their numbers are under All variables; cosim report --plot plots them.`));
    else if (wanted.length === 0) list.append(el("p", { class: "soft" }, "No variable has this word in its name."));
  };
  refill();
  const search = el("input", { type: "search", id: "search", oninput: () => {
    word = search.value.trim().toLowerCase();
    refill();
  } });
  return [el("div", { class: "controls" }, choice("Component ", components, 0, (place) => {
    component = place;
    word = search.value = "";
    refill();
  }), el("label", {}, "Search ", search)), list];
}

function variables(trace) {
  const row = ({ name, unit, values, not_finite }) => [name, unit || "not known", ...values.map((value) => num(value, 5)), String(not_finite)];
  return table("Variables", ["variable", "unit", "first", "last", "least", "mean", "greatest", "not finite"], trace.table.map(row), [0, 1]);
}

/** A run with its trace. */
export function runView(trace) {
  const clock = new Clock(trace.start, trace.stop);
  const parts = [];
  const side = [instant(trace, clock), trace.plots.length + trace.signals.length > 0 && zoomButtons(clock), faultList(trace.faults, trace.stop)].filter(Boolean);
  if (trace.map) parts.push(el("div", { class: "wide" }, mapOf(trace.map, clock), el("div", {}, side)));
  else parts.push(side);
  parts.push(trace.xy.map(planeOf));
  parts.push(sections(trace, clock));
  if (trace.signals.length > 0) parts.push(details(`All signals (${trace.signals.length} plots)`, () => everything(trace, clock), trace.plots.length === 0));
  if (trace.table.length > 0) parts.push(details(`All variables (${trace.table.length})`, () => variables(trace)));
  return parts.flat().filter(Boolean);
}

/** Summary of a trace in numbers. */
export function traceFacts(trace) {
  return facts([["Instants", String(trace.instants)], ["From", withUnit(num(trace.start, 6), "s")], ["Until", withUnit(num(trace.stop, 6), "s")]]);
}
