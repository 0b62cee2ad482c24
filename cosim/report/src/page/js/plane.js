// A plot of two quantities: the library draws axes and zooms, `paint` draws the contents.
import { el } from "./dom.js";
import { axis, whenSeen } from "./timeplot.js";

const MARGIN = { left: 66, bottom: 40, top: 10, right: 14 };

function short(text) {
  return text.length > 16 ? `${text.slice(0, 15)}…` : text;
}

/** Minimum and maximum of lists of numbers, with a margin; null if there are none. */
export function extent(lists, margin = 0.05) {
  let [low, high] = [Infinity, -Infinity];
  for (const list of lists) {
    for (const value of list) {
      if (value == null) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  if (low > high) return null;
  const padding = high > low ? (high - low) * margin : Math.abs(high) * 0.1 || 0.5;
  return [low - padding, high + padding];
}

/**
 * A plane as a figure. `x` and `y` are { label, range }, `paint(ctx, at)` draws, where `at(x, y)` are
 * canvas pixels; `equal`: both axes have the same scale; `pointed(x, y, near)` is called on mouse moves,
 * and `near` is a distance on screen in units of x.
 */
export class Plane {
  constructor({ x, y, paint, equal = false, height = 260, pointed, clicked, spoken }) {
    Object.assign(this, { x, y, paint, equal, wanted: height, pointed, clicked });
    this.canvas = el("div", { class: "canvas", role: "group", "aria-label": spoken });
    this.moved = new Set();
    this.u = null;
    this.view = null;
    whenSeen(this.canvas, () => this.build(), () => this.resize());
  }

  #area() {
    const width = Math.max(this.canvas.clientWidth, 220) - MARGIN.left - MARGIN.right;
    if (!this.equal) return [width, this.wanted - MARGIN.top - MARGIN.bottom];
    const [dx, dy] = [this.x.range[1] - this.x.range[0], this.y.range[1] - this.y.range[0]];
    return [width, Math.min(Math.max((width * dy) / dx, 220), 480)];
  }

  /** The full range, at equal scale if requested. */
  #fitted([width, height]) {
    const [x, y] = [[...this.x.range], [...this.y.range]];
    if (this.equal) {
      const scale = Math.max((x[1] - x[0]) / width, (y[1] - y[0]) / height);
      const around = (range, length) => {
        const middle = (range[0] + range[1]) / 2;
        return [middle - (length * scale) / 2, middle + (length * scale) / 2];
      };
      return { x: around(x, width), y: around(y, height) };
    }
    return { x, y };
  }

  build() {
    this.u?.destroy();
    const area = this.#area();
    this.view ??= this.#fitted(area);
    const [width, height] = [area[0] + MARGIN.left + MARGIN.right, area[1] + MARGIN.top + MARGIN.bottom];
    const range = (of) => (_, low, high) => (low == null ? this.view[of] : [low, high]);
    const values = this.x.texts && { values: (_, ticks) => ticks.map((tick) => short(this.x.texts[tick] ?? "")), splits: () => this.x.texts.map((_, place) => place) };
    this.u = new uPlot({
      width, height, padding: [MARGIN.top, MARGIN.right, 0, 0],
      scales: { x: { time: false, range: range("x") }, y: { range: range("y") } },
      axes: [axis(this.x.label, { size: MARGIN.bottom - 20, ...values }), axis(this.y.label, { size: MARGIN.left - 22 })],
      series: [{}, { show: true, points: { show: false }, stroke: "transparent" }],
      cursor: { points: { show: false }, drag: { x: true, y: true, uni: 10, setScale: false } },
      legend: { show: false },
      hooks: { draw: [(u) => this.#draw(u)], setSelect: [(u) => this.#selected(u)] },
    }, [this.view.x, this.view.y], this.canvas);
    const { over } = this.u;
    over.addEventListener("dblclick", () => this.fit());
    over.addEventListener("mousemove", () => {
      const { left, top } = this.u.cursor;
      if (left < 0 || !this.pointed) return;
      const near = Math.abs(this.u.posToVal(left + 30, "x") - this.u.posToVal(left, "x"));
      this.pointed(this.u.posToVal(left, "x"), this.u.posToVal(top, "y"), near);
    });
    over.addEventListener("click", () => {
      const { left, top } = this.u.cursor;
      const distance = (x, y) => Math.hypot(this.u.valToPos(x, "x") - left, this.u.valToPos(y, "y") - top);
      if (left >= 0) this.clicked?.(distance);
    });
    this.#show(this.view);
  }

  resize() {
    this.view = null;
    this.build();
  }

  #draw(u) {
    const { ctx, bbox } = u;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    this.paint(ctx, (x, y) => [u.valToPos(x, "x", true), u.valToPos(y, "y", true)], devicePixelRatio);
    ctx.restore();
  }

  #selected(u) {
    const { left, top, width, height } = u.select;
    if (width < 5 && height < 5) return;
    const x = [u.posToVal(left, "x"), u.posToVal(left + width, "x")];
    const y = [u.posToVal(top + height, "y"), u.posToVal(top, "y")];
    u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    if (!this.equal) return this.#show({ x, y });
    const [scaleX, scaleY] = [(x[1] - x[0]) / u.over.clientWidth, (y[1] - y[0]) / u.over.clientHeight];
    const now = (this.view.x[1] - this.view.x[0]) / u.over.clientWidth;
    this.zoom(Math.max(scaleX, scaleY) / now, (x[0] + x[1]) / 2, (y[0] + y[1]) / 2);
  }

  #show(view) {
    this.view = view;
    this.u.batch(() => {
      this.u.setScale("x", { min: view.x[0], max: view.x[1] });
      this.u.setScale("y", { min: view.y[0], max: view.y[1] });
    });
    for (const listener of this.moved) listener();
  }

  fit() {
    if (this.u) this.#show(this.#fitted(this.#area()));
  }

  zoom(factor, x, y) {
    if (!this.u) return;
    const around = (range, middle = (range[0] + range[1]) / 2) => {
      const half = ((range[1] - range[0]) / 2) * factor;
      return [middle - half, middle + half];
    };
    this.#show({ x: around(this.view.x, x), y: around(this.view.y, y) });
  }

  /** Moves the view by parts of its size. */
  pan(right, up) {
    if (!this.u) return;
    const by = ([low, high], part) => [low + part * (high - low), high + part * (high - low)];
    this.#show({ x: by(this.view.x, right), y: by(this.view.y, up) });
  }

  redraw() {
    this.u?.redraw(false);
  }

  /** Buttons as an alternative to dragging. */
  buttons(name) {
    const button = (sign, what, act) =>
      el("button", { type: "button", "aria-label": `${what}: ${name}`, title: what, onclick: act }, sign);
    return el("div", { class: "controls" },
      button("+", "zoom in", () => this.zoom(0.5)), button("−", "zoom out", () => this.zoom(2)),
      button("←", "move left", () => this.pan(-0.25, 0)), button("→", "move right", () => this.pan(0.25, 0)),
      button("↑", "move up", () => this.pan(0, 0.25)), button("↓", "move down", () => this.pan(0, -0.25)),
      button("fit", "show all", () => this.fit()));
  }
}
