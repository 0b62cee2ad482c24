// Plots over time; all plots of a run share the cursor and the shown time range.
import { el } from "./dom.js";
import { num, withUnit } from "./format.js";
import { colour, onTheme } from "./theme.js";

const SIGNALS = ["c1", "c2", "c3", "c4", "c5", "c6", "c7", "c8"];
const DASHES = [null, [8, 3], [3, 3], [10, 3, 2, 3]];
const FONT = "12px system-ui, sans-serif";

/** Axes in the common style. */
export function axis(label, more = {}) {
  return {
    label, font: FONT, labelFont: FONT, labelSize: 20, labelGap: 2, stroke: colour("soft"),
    grid: { stroke: colour("line"), width: 1 }, ticks: { stroke: colour("line"), width: 1, size: 4 },
    values: (_, ticks) => ticks.map((tick) => (tick == null ? "" : num(tick, 6))), ...more,
  };
}

/** Faults of a run, shaded over the height of a plot. */
function shadeFaults(u, faults, stop) {
  const { ctx, bbox } = u;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  for (const { from, until } of faults) {
    const left = u.valToPos(from, "x", true);
    const right = u.valToPos(until ?? stop, "x", true);
    ctx.fillStyle = colour("fault");
    ctx.globalAlpha = 0.13;
    ctx.fillRect(left, bbox.top, right - left, bbox.height);
    ctx.globalAlpha = 0.8;
    ctx.fillRect(left, bbox.top, Math.max(1, devicePixelRatio), bbox.height);
    ctx.fillRect(right, bbox.top, Math.max(1, devicePixelRatio), bbox.height);
  }
  ctx.restore();
}

function lineStyle(line, place, count) {
  if (line.role === "truth") return { stroke: colour("truth"), width: 2 };
  if (line.role === "course") return { stroke: colour("course"), width: 2, dash: [0, 5], cap: "round" };
  if (line.role === "edge") return { stroke: colour("estimate"), width: 0.75 };
  if (line.role === "estimate" && count === 1) return { stroke: colour("estimate"), width: 1.5 };
  const own = SIGNALS[place % SIGNALS.length];
  return { stroke: colour(own), width: 1.5, dash: DASHES[Math.floor(place / 2) % DASHES.length] };
}

/** The line of an angle in degrees: it ends at 180 and goes on at -180, or the other way. */
function turning(u, place, first, last) {
  const [t, v] = [u.data[0], u.data[place]];
  const at = (time, angle) => [u.valToPos(time, "x", true), u.valToPos(angle, "y", true)];
  const stroke = new Path2D();
  for (let i = first; i <= last; i += 1) {
    if (v[i] == null) continue;
    const step = i === first || v[i - 1] == null ? null : v[i] - v[i - 1];
    if (step == null) stroke.moveTo(...at(t[i], v[i]));
    else if (Math.abs(step) > 180) {
      const edge = -180 * Math.sign(step);
      const time = t[i - 1] + ((edge - v[i - 1]) / (step + 2 * edge)) * (t[i] - t[i - 1]);
      stroke.lineTo(...at(time, edge));
      stroke.moveTo(...at(time, -edge));
    }
    stroke.lineTo(...at(t[i], v[i]));
  }
  return { stroke, fill: null, clip: null, band: null, gaps: null, flags: 1 };
}

/** Data and series of a plot: lines, between which `fills` are shaded, then the edges of the band, then its limits. */
function contents(plot) {
  const value = (_, v) => (v == null ? "–" : withUnit(num(v), plot.unit));
  const paths = plot.steps ? { paths: uPlot.paths.stepped({ align: 1 }) } : plot.wraps ? { paths: turning } : {};
  const quiet = { points: { show: false }, value, ...paths };
  const data = [plot.t, ...plot.lines.map((line) => line.v)];
  const series = [{ label: "time", value: (_, v) => (v == null ? "–" : `${num(v, 7)} s`) }];
  plot.lines.forEach((line, place) => {
    const truths = plot.lines.filter((other) => other.role === "truth").length;
    series.push({ ...quiet, label: line.name, ...lineStyle(line, line.role === "truth" ? 0 : place - truths, plot.lines.length) });
  });
  const bands = (plot.fills ?? []).map(([low, high]) => ({ series: [high + 1, low + 1], fill: colour("band") }));
  // Beside shaded lines the band is not shaded.
  const bound = { ...quiet, stroke: colour(plot.fills ? "truth" : "estimate"), width: 1, dash: [4, 3] };
  if (plot.band) {
    const above = plot.band.v;
    if (!plot.fills) bands.push({ series: [data.length, data.length + 1], fill: colour("band") });
    data.push(above, above.map((v) => (v == null ? null : -v)));
    series.push({ ...bound, label: plot.band.name });
    series.push({ ...bound, label: `${plot.band.name}, lower`, class: "hidden" });
  }
  if (plot.limits) {
    const { name, high, low } = plot.limits;
    for (const [label, v, hidden] of [[name, high, null], [`${name}, lower`, low, "hidden"]]) {
      data.push(plot.t.map(() => v));
      series.push({ ...bound, stroke: colour("fault"), label, class: hidden });
    }
  }
  return { data, series, bands };
}

/** The range of values: of the lines, and of the band unless that would make the lines unreadable. */
function valueRange(plot, low, high) {
  if (plot.wraps && high - low > 180) return [-185, 185];
  if (!plot.band) return uPlot.rangeNum(low ?? 0, high ?? 1, 0.1, true);
  const most = (lists) => Math.max(0, ...lists.map((list) => list.reduce((a, v) => (v == null ? a : Math.max(a, Math.abs(v))), 0)));
  const size = most(plot.lines.map((line) => line.v));
  const seen = Math.max(size, Math.min(most([plot.band.v]), 4 * size || Infinity)) || 1;
  return [-1.1 * seen, 1.1 * seen];
}

/** Crosses on the first line where something was marked. */
function drawMarks(u, marks) {
  const { ctx } = u;
  const size = 4 * devicePixelRatio;
  ctx.save();
  ctx.strokeStyle = colour("fault");
  ctx.lineWidth = 2 * devicePixelRatio;
  ctx.beginPath();
  for (const place of marks.at) {
    const value = u.data[1][place];
    const x = u.valToPos(u.data[0][place], "x", true);
    if (value == null || x < u.bbox.left || x > u.bbox.left + u.bbox.width) continue;
    const y = u.valToPos(value, "y", true);
    ctx.moveTo(x - size, y - size);
    ctx.lineTo(x + size, y + size);
    ctx.moveTo(x - size, y + size);
    ctx.lineTo(x + size, y - size);
  }
  ctx.stroke();
  ctx.restore();
}

/** The text alternative for screen readers. */
function spoken(plot) {
  if (plot.grows) return `${plot.title} over time, while the run goes on`;
  const parts = plot.lines.map((line) => {
    const known = line.v.filter((v) => v != null);
    if (known.length === 0) return `${line.name}: no values`;
    const [low, high] = [known.reduce((a, b) => Math.min(a, b)), known.reduce((a, b) => Math.max(a, b))];
    return `${line.name} from ${num(low)} to ${withUnit(num(high), plot.unit)}`;
  });
  return `${plot.title} over time: ${parts.join("; ")}`;
}

/** A plot as a figure; it is drawn when it comes into view. */
export function timePlot(plot, clock, faults) {
  const canvas = el("div", { class: "canvas" });
  const unit = plot.unit === "1" ? "no unit" : plot.unit || "unit not known";
  const head = !plot.unit || plot.unit === "1" || plot.title.endsWith(`(${plot.unit})`) ? plot.title : `${plot.title} (${plot.unit})`;
  const marks = plot.marks && plot.marks.at.length > 0 ? plot.marks : null;
  const figure = el("figure", { class: "plot" }, el("figcaption", {}, head), canvas,
    marks && el("p", { class: "small soft" }, `✕ ${marks.name} (${marks.at.length})`));
  let u = null;
  const build = () => {
    u?.destroy();
    const { data, series, bands } = contents(plot);
    const first = plot.lines.length === 1 ? plot.lines[0].name : "";
    u = new uPlot({
      width: Math.max(canvas.clientWidth, 200), height: 190, bands, series,
      scales: {
        x: { time: false, range: (_, low, high) => [low, high], min: clock.from, max: clock.until },
        y: { dir: plot.down ? -1 : 1, range: (_, low, high) => valueRange(plot, low, high) },
      },
      axes: [axis("time (s)", { size: 24 }), axis(`${first} (${unit})`.trim(), { size: 62, ...(plot.wraps ? { incrs: [0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 45, 90] } : {}) })],
      cursor: { y: false, drag: { x: true, y: false }, points: { size: 7 } },
      legend: { live: true },
      hooks: {
        drawClear: [(self) => shadeFaults(self, faults, clock.stop)],
        draw: marks ? [(self) => drawMarks(self, marks)] : [],
        setScale: [(self, key) => {
          if (key !== "x" || u !== self) return;
          clock.show(Math.max(self.scales.x.min, clock.start), Math.min(self.scales.x.max, clock.stop));
          cursor(clock.now);
        }],
        ready: [() => cursor(clock.now)],
      },
    }, data, canvas);
    u.over.addEventListener("mousemove", () => {
      if (u.cursor.left >= 0) clock.set(u.posToVal(u.cursor.left, "x"));
    });
    u.over.addEventListener("mouseleave", () => clock.set(clock.now));
    u.root.setAttribute("role", "group");
    u.root.setAttribute("aria-label", spoken(plot));
    range(clock.from, clock.until);
  };
  const range = (from, until) => {
    u?.setScale("x", { min: from, max: until > from ? until : from + 1 });
  };
  const cursor = (now) => {
    if (u && !u.over.matches(":hover")) u.setCursor({ left: u.valToPos(now, "x"), top: 0 }, false);
  };
  clock.onRange(range);
  clock.onCursor(cursor);
  // For growing data: the lists of the plot have changed, and with them the range of the clock.
  figure.refresh = () => u?.batch(() => {
    u.setData(contents(plot).data, false);
    range(clock.from, clock.until);
  });
  figure.dispose = () => {
    clock.forget(range, cursor);
    u?.destroy();
    u = null;
  };
  whenSeen(canvas, build, () => u?.setSize({ width: canvas.clientWidth, height: 190 }));
  return figure;
}

/** A slider for the instant: the cursor by keyboard. */
export function timeSlider(clock) {
  const output = el("output", { for: "time" });
  const slider = el("input", { type: "range", id: "time", min: 0, max: 1000, step: 1, value: 0, "aria-label": "time",
    oninput: () => clock.set(clock.start + (slider.value / 1000) * (clock.stop - clock.start)) });
  clock.onCursor((now) => {
    if (document.activeElement !== slider) slider.value = Math.round(((now - clock.start) / (clock.stop - clock.start || 1)) * 1000);
    output.textContent = `t = ${num(now, 6)} s`;
    slider.setAttribute("aria-valuetext", output.textContent);
  });
  return el("div", { class: "slider" }, el("label", { for: "time" }, "Time"), slider, output);
}

/** Buttons as an alternative to dragging. */
export function zoomButtons(clock) {
  const button = (text, what, act) => el("button", { type: "button", title: what, "aria-label": what, onclick: act }, text);
  return el("div", { class: "controls", role: "group", "aria-label": "Part of time that plots show" },
    el("span", {}, "Plots"), button("+", "zoom in on time", () => clock.zoom(0.5)), button("−", "zoom out of time", () => clock.zoom(2)),
    button("←", "earlier", () => clock.zoom(1, -0.25)), button("→", "later", () => clock.zoom(1, 0.25)),
    button("all", "show the whole run", () => clock.reset()),
    el("span", { class: "small soft" }, "Drag in a plot to zoom, double-click for all; all plots have one cursor."));
}

const UNSEEN = new Map();
const SEEN = new IntersectionObserver((entries) => {
  for (const entry of entries) if (entry.isIntersecting) buildNow(entry.target);
}, { rootMargin: "400px" });
const SIZES = new ResizeObserver((entries) => entries.forEach((entry) => entry.target.resized?.()));

function buildNow(element) {
  const build = UNSEEN.get(element);
  if (!build) return;
  UNSEEN.delete(element);
  SEEN.unobserve(element);
  build();
}

// Everything that is open is printed.
window.addEventListener("beforeprint", () => [...UNSEEN.keys()].forEach((element) => {
  if (element.checkVisibility()) buildNow(element);
}));

/** Draws when an element comes into view, and again after a change of colours; resizes with it. */
export function whenSeen(element, build, resize) {
  let width = 0;
  UNSEEN.set(element, () => {
    width = element.clientWidth;
    build();
    onTheme(element, build);
    element.resized = () => {
      if (element.clientWidth === width || element.clientWidth === 0) return;
      width = element.clientWidth;
      resize();
    };
    SIZES.observe(element);
  });
  SEEN.observe(element);
}
