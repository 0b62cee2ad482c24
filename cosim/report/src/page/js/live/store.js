// The received data of the run, as much as plots can show.

/** Maximum number of instants; beyond that, every second one of the older half is dropped. */
const MOST_KEPT = 2400;

/** An angle (rad) in degrees, between minus and plus half a turn. */
function halfTurn(angle) {
  return degrees(angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI)));
}

function degrees(angle) {
  return (angle / Math.PI) * 180;
}

const finite = (value) => (Number.isFinite(value) ? value : null);

/** Times, columns by number, and lists that are computed from rows. */
export class Store {
  constructor() {
    this.t = [];
    this.columns = new Map();
    this.derived = [];
    this.wanted = [];
    this.number = 0;
  }

  /** Keeps these columns from now on; returns the request to the run. */
  want(columns, derived) {
    this.wanted = [...new Set(columns)];
    this.derived = derived;
    this.number += 1;
    this.#clear();
    return { op: "show", number: this.number, columns: this.wanted };
  }

  #clear() {
    this.t.length = 0;
    for (const { list } of this.derived) list.length = 0;
    this.columns = new Map(this.wanted.map((column) => [column, this.columns.get(column) ?? []]));
    for (const list of this.columns.values()) list.length = 0;
  }

  /** The list of a column, which stays the same object while the column is wanted. */
  list(column) {
    return this.columns.get(column);
  }

  /** Adds a message of the run; returns how many instants were new. */
  take(buffer) {
    const [rows, number, history, width] = new Uint32Array(buffer, 0, 4);
    if (number !== this.number) return 0;
    const times = new Float64Array(buffer, 16, rows);
    const values = new Float64Array(buffer, 16 + 8 * rows, rows * width);
    if (history) this.#clear();
    let fresh = 0;
    for (let row = 0; row < rows; row += 1) {
      if (this.t.length > 0 && times[row] <= this.t.at(-1)) continue;
      fresh += 1;
      this.t.push(times[row]);
      const value = (place) => (place == null ? null : finite(place[1] * values[row * width + this.wanted.indexOf(place[0])] + place[2]));
      this.wanted.forEach((column, at) => this.columns.get(column).push(finite(values[row * width + at])));
      for (const { list, of } of this.derived) list.push(of(value));
    }
    if (this.t.length > MOST_KEPT) this.#thin();
    return fresh;
  }

  #thin() {
    const half = this.t.length >> 1;
    const keep = (list) => {
      let to = 0;
      for (let from = 0; from < list.length; from += from < half ? 2 : 1) list[to++] = list[from];
      list.length = to;
    };
    for (const list of [this.t, ...this.columns.values(), ...this.derived.map(({ list }) => list)]) keep(list);
  }
}

const AXES = ["x", "y", "z", "roll", "pitch", "yaw"];

/** The estimates for which there is a truth. */
export function judged(hello) {
  return hello.bodies.some((body) => body.truth) ? hello.bodies.filter((body) => !body.truth) : [];
}

/** Plots of the errors of an estimate, whose lists the store fills. */
export function errorPlots(hello, body, store) {
  const truth = hello.bodies.find((other) => other.truth);
  return AXES.flatMap((axis, i) => {
    const [own, real, sigma] = [body.pose[i], truth.pose[i], body.sigma[i]];
    if (!own || !real) return [];
    const error = { list: [], of: (value) => {
      const [a, b] = [value(own), value(real)];
      if (a == null || b == null) return null;
      return i < 3 ? a - b : halfTurn(a - b);
    } };
    const band = sigma && { list: [], of: (value) => {
      const deviation = value(sigma);
      if (deviation == null) return null;
      return 3 * (i < 3 ? deviation : degrees(deviation));
    } };
    return [{
      title: `${body.name}, ${axis}: error`, unit: i < 3 ? "m" : "deg", t: store.t, grows: true,
      lines: [{ name: "error", role: "estimate", v: error.list }],
      band: band && { name: "± 3 σ", v: band.list }, derived: band ? [error, band] : [error],
    }];
  });
}

/** All columns used by bodies and courses. */
export function bodyColumns(hello) {
  const places = [...hello.bodies.flatMap((body) => [...body.pose, ...body.sigma, body.xy]), ...hello.courses.flatMap((course) => course.position)];
  return places.filter(Boolean).map(([column]) => column);
}
