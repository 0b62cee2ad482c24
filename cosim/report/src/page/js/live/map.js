// The course, and the positions of the truth and the estimates, north up.
import { el } from "../dom.js";
import { num } from "../format.js";
import { extent, Plane } from "../plane.js";
import { colour } from "../theme.js";

/** The radius in sigmas of an ellipse that contains 95 % of a bivariate normal distribution. */
const SIGMAS_95 = Math.sqrt(5.991464547107979);
const ESTIMATE_COLOURS = ["c1", "c2", "c3", "c4", "c5", "c6"];

/** The path of a body as lists of north and east, which the store fills. */
function track(body, up) {
  const [first, second] = [body.pose[0], body.pose[1]];
  const [north, east] = up ? [second, first] : [first, second];
  const list = (place) => ({ list: [], of: (value) => value(place) });
  const [sigmaNorth, sigmaEast] = up ? [body.sigma[1], body.sigma[0]] : [body.sigma[0], body.sigma[1]];
  return { body, north: list(north), east: list(east), sigmaNorth: list(sigmaNorth), sigmaEast: list(sigmaEast), covariance: list(body.xy), yaw: list(body.pose[5]), up };
}

function colourOf(tracks, own) {
  return colour(colourName(tracks, own));
}

function colourName(tracks, own) {
  if (own.body.truth) return "truth";
  if (own.body.course) return "course";
  return ESTIMATE_COLOURS[tracks.filter(({ body }) => !body.truth && !body.course).indexOf(own) % ESTIMATE_COLOURS.length];
}

function drawTrack(ctx, at, ratio, tracks, own) {
  const [north, east] = [own.north.list, own.east.list];
  ctx.strokeStyle = ctx.fillStyle = colourOf(tracks, own);
  const { truth, course } = own.body;
  ctx.lineWidth = (truth || course ? 2.5 : 1.8) * ratio;
  ctx.lineCap = course ? "round" : "butt";
  ctx.setLineDash((truth ? [] : course ? [0, 6] : [9, 3]).map((d) => d * ratio));
  ctx.beginPath();
  let pen = false;
  north.forEach((value, i) => {
    if (value == null || east[i] == null) pen = false;
    else {
      if (pen) ctx.lineTo(...at(east[i], value));
      else ctx.moveTo(...at(east[i], value));
      pen = true;
    }
  });
  ctx.stroke();
  ctx.setLineDash([]);
  const last = north.length - 1;
  if (last < 0 || north[last] == null || east[last] == null) return;
  const [x, y] = at(east[last], north[last]);
  const [sn, se] = [own.sigmaNorth.list[last], own.sigmaEast.list[last]];
  if (sn != null && se != null) {
    const [mean, half, xy] = [(sn * sn + se * se) / 2, (se * se - sn * sn) / 2, own.covariance.list[last] ?? 0];
    const root = Math.hypot(half, xy);
    const scale = Math.abs(at(east[last] + 1, north[last])[0] - x) * SIGMAS_95;
    const [a, b] = [scale * Math.sqrt(mean + root), scale * Math.sqrt(Math.max(mean - root, 0))];
    if (a < 2 * ctx.canvas.width) {
      ctx.beginPath();
      ctx.ellipse(x, y, a, b, -Math.atan2(xy, half) / 2, 0, 2 * Math.PI);
      ctx.stroke();
    }
  }
  // An arrow in the direction of its heading, or a dot.
  const yaw = own.yaw.list[last];
  ctx.save();
  ctx.translate(x, y);
  ctx.scale(ratio, ratio);
  ctx.beginPath();
  if (yaw == null) ctx.arc(0, 0, 5, 0, 2 * Math.PI);
  else {
    ctx.rotate(own.up ? Math.PI / 2 - yaw : yaw);
    for (const [px, py] of [[0, -11], [7, 11], [0, 6], [-7, 11]]) ctx.lineTo(px, py);
  }
  ctx.fill();
  ctx.restore();
}

/** A map that grows with the run: `figure`, the lists that the store fills, and `refresh`. */
export function liveMap(hello) {
  // Courses are drawn first, below the others.
  const courses = hello.courses.map(({ name, position }) => ({ name, course: true, pose: position, sigma: [] }));
  const tracks = [...courses, ...hello.bodies].filter((body) => body.pose[0] && body.pose[1]).map((body) => track(body, hello.up));
  if (tracks.length === 0) return { figure: null, derived: [], refresh() {} };
  const range = (lists) => extent(lists, 0.1) ?? [-1, 1];
  const plane = new Plane({
    x: { label: "east (m)", range: [-1, 1] }, y: { label: "north (m)", range: [-1, 1] }, equal: true, height: 420,
    paint: (ctx, at, ratio) => tracks.forEach((own) => drawTrack(ctx, at, ratio, tracks, own)),
    spoken: `Map with ${tracks.map((own) => own.body.name).join(", ")}`,
  });
  const where = el("p", { class: "small soft", id: "where" });
  const legend = el("ul", { class: "legend" }, tracks.map((own) => {
    const mark = el("i");
    const { name, truth, course } = own.body;
    mark.style.borderColor = `var(--${colourName(tracks, own)})`;
    mark.style.borderTopStyle = truth ? "solid" : course ? "dotted" : "dashed";
    return el("li", {}, mark, `${name}${truth ? " (truth)" : course ? " (course)" : ""}`);
  }));
  let fitted = null;
  const refresh = () => {
    if (!plane.u) return;
    const [east, north] = [range(tracks.map((own) => own.east.list)), range(tracks.map((own) => own.north.list))];
    const within = ([low, high], [least, most]) => least <= low && most >= high;
    // If the user has zoomed in, the view stays.
    if ((fitted === null || plane.view === fitted) && !(fitted && within(east, plane.x.range) && within(north, plane.y.range))) {
      plane.x.range = fitted ? range([east, plane.x.range]) : east;
      plane.y.range = fitted ? range([north, plane.y.range]) : north;
      plane.resize();
      fitted = plane.view;
    } else plane.redraw();
    where.textContent = tracks.map((own) => `${own.body.name}: ${num(own.north.list.at(-1))} m north, ${num(own.east.list.at(-1))} m east`).join("; ");
  };
  return {
    figure: el("figure", { class: "plot" }, el("figcaption", {}, "Map, north up"), plane.canvas, plane.buttons("map"), legend, where),
    derived: tracks.flatMap((own) => [own.north, own.east, own.sigmaNorth, own.sigmaEast, own.covariance, own.yaw]).map((list) => list),
    refresh,
  };
}
