// The paths of a run in space, seen from a direction chosen by the user.
import { el } from "./dom.js";
import { valueAt } from "./clock.js";
import { num } from "./format.js";
import { extent, Plane } from "./plane.js";
import { colour } from "./theme.js";

/** Elevation of the view above the horizon (rad). */
const ABOVE = 0.45;
/** A smaller change of depth (m) is shown only in the plot of depths. */
const DIVE = 1;

/** A figure with the paths { name, x, y, z, ... }, or null where depth hardly changes; `tint(path)` is a colour, `pen(ctx, ratio, path)` sets a line. */
export function spaceOf(map, clock, tint, pen) {
  const paths = map.paths.filter((path) => path.z && path.role !== "fix");
  const truth = paths.filter((path) => path.role === "truth");
  const deep = extent((truth.length ? truth : paths).map((path) => path.z), 0);
  const [north, east] = [extent(paths.map((path) => path.x), 0), extent(paths.map((path) => path.y), 0)];
  if (!deep || !north || !east || deep[1] - deep[0] < DIVE) return null;
  const wide = Math.max(north[1] - north[0], east[1] - east[0]);
  // Depth is scaled up to a third of the path if it is smaller.
  const factor = Math.max(1, wide / 3 / (deep[1] - deep[0]));
  const middle = [north, east].map(([low, high]) => (low + high) / 2);
  let side = 0.6;
  const project = (x, y, z) => {
    const [n, e] = [x - middle[0], y - middle[1]];
    const [right, away] = [e * Math.cos(side) - n * Math.sin(side), e * Math.sin(side) + n * Math.cos(side)];
    return [right, away * Math.sin(ABOVE) - (z - deep[0]) * factor * Math.cos(ABOVE)];
  };
  const reach = Math.hypot(north[1] - north[0], east[1] - east[0]) / 2;
  const height = (deep[1] - deep[0]) * factor * Math.cos(ABOVE);
  const corners = [[0, 0], [0, 1], [1, 1], [1, 0]].map(([i, j]) => [north[i], east[j]]);
  const paint = (ctx, at, ratio) => {
    const go = (points) => {
      ctx.beginPath();
      points.forEach(([x, y, z]) => x != null && y != null && z != null && ctx.lineTo(...at(...project(x, y, z))));
      ctx.stroke();
    };
    ctx.lineWidth = ratio;
    ctx.strokeStyle = colour("line");
    for (const z of deep) go([...corners, corners[0]].map(([x, y]) => [x, y, z]));
    for (const [x, y] of corners) go(deep.map((z) => [x, y, z]));
    ctx.fillStyle = colour("soft");
    ctx.font = `${12 * ratio}px system-ui, sans-serif`;
    const write = (text, x, y, z) => ctx.fillText(text, ...at(...project(x, y, z)));
    write(`${num(deep[0])} m deep`, north[0], east[0], deep[0]);
    write(`${num(deep[1])} m deep`, north[0], east[0], deep[1]);
    write("north", north[1], middle[1], deep[1]);
    write("east", middle[0], east[1], deep[1]);
    for (const path of paths) {
      ctx.strokeStyle = ctx.fillStyle = tint(path);
      pen(ctx, ratio, path);
      go(path.x.map((x, i) => [x, path.y[i], path.z[i]]));
      ctx.setLineDash([]);
      const [x, y, z] = [path.x, path.y, path.z].map((values) => valueAt(map.t, values, clock.now));
      if (x == null || y == null || z == null) continue;
      // A vertical line to the bottom shows the position.
      ctx.lineWidth = ratio;
      go([[x, y, z], [x, y, deep[1]]]);
      ctx.beginPath();
      ctx.arc(...at(...project(x, y, z)), 5 * ratio, 0, 2 * Math.PI);
      ctx.fill();
    }
  };
  const plane = new Plane({
    x: { label: "to the right (m)", range: [-1.05 * reach, 1.05 * reach] },
    y: { label: "up the picture (m)", range: [-reach * Math.sin(ABOVE) - height, reach * Math.sin(ABOVE)] },
    paint, equal: true, spoken: `Path in space: from ${num(deep[0])} m to ${num(deep[1])} m deep`,
  });
  clock.onCursor(() => plane.redraw());
  const turn = el("input", { type: "range", min: 0, max: 360, step: 5, value: 35, "aria-label": "seen from", oninput: () => {
    side = (turn.value / 180) * Math.PI;
    plane.redraw();
  } });
  const scaled = factor > 1 ? `depth is drawn ${num(factor, 2)} times as large` : "one scale in all directions";
  return el("figure", { class: "plot" }, el("figcaption", {}, `Path in space: ${scaled}`), plane.canvas,
    el("div", { class: "slider" }, el("label", {}, "Turn "), turn));
}
