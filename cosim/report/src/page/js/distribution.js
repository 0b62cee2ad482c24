// Distributions: box plots, cumulative shares, scatter plots.
import { el } from "./dom.js";
import { num } from "./format.js";
import { extent, Plane } from "./plane.js";
import { colour } from "./theme.js";

const COLOURS = ["c1", "c2", "c3", "c4", "c5", "c6", "c7", "c8"];

export function groupColour(place) {
  return colour(COLOURS[place % COLOURS.length]);
}

/** One of 41 quantiles that are 1/40 apart. */
export function quantile(quantiles, p) {
  return quantiles.length === 0 ? null : quantiles[Math.round(p * 40)];
}

function caption(text, plane, more) {
  return el("figure", { class: "plot" }, el("figcaption", {}, text), plane.canvas, more);
}

/** Boxes of groups { name, quantiles, points }; `point(group, place)` is called on clicks. */
export function boxes(title, label, groups, clicked) {
  const known = groups.filter((group) => group.quantiles.length > 0);
  if (known.length === 0) return el("p", { class: "soft" }, `${title}: no run has this figure.`);
  const shift = (place) => ((place * 0.618034) % 1) * 0.5 - 0.25;
  const paint = (ctx, at, ratio) => {
    groups.forEach((group, place) => {
      ctx.strokeStyle = ctx.fillStyle = groupColour(place);
      ctx.globalAlpha = 0.4;
      (group.points ?? []).forEach((value, i) => {
        if (value == null) return;
        const [x, y] = at(place + shift(i), value);
        ctx.beginPath();
        ctx.arc(x, y, 2 * ratio, 0, 2 * Math.PI);
        ctx.fill();
      });
      ctx.globalAlpha = 1;
      if (group.quantiles.length === 0) return;
      ctx.lineWidth = 1.5 * ratio;
      const q = (p) => quantile(group.quantiles, p);
      const [left, top] = at(place - 0.3, q(0.75));
      const [right, bottom] = at(place + 0.3, q(0.25));
      ctx.strokeRect(left, top, right - left, bottom - top);
      ctx.globalAlpha = 0.15;
      ctx.fillRect(left, top, right - left, bottom - top);
      ctx.globalAlpha = 1;
      ctx.beginPath();
      for (const [from, to] of [[0.25, 0.05], [0.75, 0.95]]) {
        ctx.moveTo(...at(place, q(from)));
        ctx.lineTo(...at(place, q(to)));
        ctx.moveTo(...at(place - 0.12, q(to)));
        ctx.lineTo(...at(place + 0.12, q(to)));
      }
      ctx.stroke();
      ctx.lineWidth = 3 * ratio;
      ctx.beginPath();
      ctx.moveTo(...at(place - 0.3, q(0.5)));
      ctx.lineTo(...at(place + 0.3, q(0.5)));
      ctx.stroke();
    });
  };
  const range = extent([...known.map((group) => [quantile(group.quantiles, 0.05), quantile(group.quantiles, 0.95)]),
    ...groups.map((group) => group.points ?? [])]);
  const spoken = known.map((group) => `${group.name}: median ${num(quantile(group.quantiles, 0.5))}`).join("; ");
  const plane = new Plane({
    x: { label: "", range: [-0.6, groups.length - 0.4], texts: groups.map((group) => group.name) },
    y: { label, range }, paint, spoken: `${title}. ${spoken}`,
    clicked: (distance) => nearest(distance, groups.flatMap((group, place) =>
      (group.points ?? []).map((value, i) => [place + shift(i), value, () => clicked?.(place, i)]))),
  });
  return caption(title, plane);
}

/** Calls `act` of the nearest of points [x, y, act] if it is close. */
function nearest(distance, points) {
  let [least, act] = [12, null];
  for (const [x, y, found] of points) {
    if (x == null || y == null) continue;
    const apart = distance(x, y);
    if (apart < least) [least, act] = [apart, found];
  }
  act?.();
}

/** The share of runs up to each value, of groups { name, quantiles }. */
export function shares(title, label, groups) {
  const known = groups.filter((group) => group.quantiles.length > 0);
  if (known.length === 0) return null;
  const paint = (ctx, at, ratio) => {
    ctx.lineWidth = 2 * ratio;
    groups.forEach((group, place) => {
      ctx.strokeStyle = groupColour(place);
      ctx.setLineDash(place % 2 ? [6 * ratio, 3 * ratio] : []);
      ctx.beginPath();
      group.quantiles.forEach((value, i) => ctx.lineTo(...at(value, (i / 40) * 100)));
      ctx.stroke();
    });
    ctx.setLineDash([]);
  };
  const plane = new Plane({
    x: { label, range: extent(known.map((group) => group.quantiles)) }, y: { label: "runs up to it (%)", range: [0, 102] },
    paint, spoken: `${title}: share of runs up to each value`,
  });
  return caption(title, plane, groupLegend(groups.map((group) => group.name)));
}

/** Names of groups; by default every second one is dashed, as the shares are. */
function groupLegend(names, dashed = true) {
  return el("ul", { class: "legend" }, names.map((name, place) => {
    const sample = el("i");
    sample.style.borderColor = `var(--${COLOURS[place % COLOURS.length]})`;
    if (dashed && place % 2) sample.style.borderTopStyle = "dashed";
    return el("li", {}, sample, name);
  }));
}

/** Points of one kind; `line` draws y = x; `lines` are { name, points } that are joined. */
export function scatter({ title, x, y, xs = [], ys = [], equalLine = false, lines = [], clicked, note }) {
  const [rangeX, rangeY] = [extent([xs, ...lines.map((line) => line.xs)]), extent([ys, ...lines.flatMap((line) => [line.ys, line.high ?? []])])];
  if (!rangeX || !rangeY) return el("p", { class: "soft" }, `${title}: no points.`);
  const paint = (ctx, at, ratio) => {
    if (equalLine) {
      const [low, high] = [Math.min(rangeX[0], rangeY[0]), Math.max(rangeX[1], rangeY[1])];
      ctx.strokeStyle = colour("soft");
      ctx.setLineDash([5 * ratio, 4 * ratio]);
      ctx.lineWidth = ratio;
      ctx.beginPath();
      ctx.moveTo(...at(low, low));
      ctx.lineTo(...at(high, high));
      ctx.stroke();
      ctx.setLineDash([]);
    }
    ctx.fillStyle = groupColour(0);
    ctx.globalAlpha = 0.55;
    xs.forEach((value, place) => {
      if (value == null || ys[place] == null) return;
      ctx.beginPath();
      ctx.arc(...at(value, ys[place]), 2.5 * ratio, 0, 2 * Math.PI);
      ctx.fill();
    });
    ctx.globalAlpha = 1;
    lines.forEach((line, place) => {
      ctx.strokeStyle = ctx.fillStyle = groupColour(place);
      ctx.lineWidth = 2 * ratio;
      for (const [values, dash] of [[line.ys, []], [line.high ?? [], [5 * ratio, 4 * ratio]]]) {
        ctx.setLineDash(dash);
        ctx.beginPath();
        values.forEach((value, i) => value != null && ctx.lineTo(...at(line.xs[i], value)));
        ctx.stroke();
      }
      ctx.setLineDash([]);
      line.ys.forEach((value, i) => {
        if (value == null) return;
        ctx.beginPath();
        ctx.arc(...at(line.xs[i], value), 3.5 * ratio, 0, 2 * Math.PI);
        ctx.fill();
      });
    });
  };
  const points = xs.map((value, place) => [value, ys[place], () => clicked?.(place)]);
  const plane = new Plane({
    x: { label: x, range: rangeX }, y: { label: y, range: rangeY }, paint,
    clicked: (distance) => nearest(distance, points), spoken: `${title}: ${xs.length} points. ${note ?? ""}`,
  });
  return caption(title, plane, [lines.length > 0 && groupLegend(lines.map((line) => line.name), false), note && el("p", { class: "small soft" }, note)].filter(Boolean));
}

/** An axis label with its unit. */
export function labelled(name, unit) {
  if (unit === "1") return `${name} (no unit)`;
  return `${name} (${unit || "unit not known"})`;
}

