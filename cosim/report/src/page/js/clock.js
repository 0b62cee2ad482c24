// The instant that all plots of a run show, and the time range that they show.

/** Times are in seconds; listeners get the instant, or the range. */
export class Clock {
  #cursor = new Set();
  #range = new Set();

  constructor(start, stop) {
    Object.assign(this, { start, stop, now: start, from: start, until: stop });
  }

  onCursor(listener) {
    this.#cursor.add(listener);
    listener(this.now);
  }

  onRange(listener) {
    this.#range.add(listener);
  }

  /** Removes a listener. */
  forget(...listeners) {
    for (const listener of listeners) {
      this.#cursor.delete(listener);
      this.#range.delete(listener);
    }
  }

  set(time) {
    this.now = Math.min(Math.max(time, this.start), this.stop);
    for (const listener of this.#cursor) listener(this.now);
  }

  show(from, until) {
    if (from === this.from && until === this.until) return;
    Object.assign(this, { from, until });
    for (const listener of this.#range) listener(from, until);
  }

  reset() {
    this.show(this.start, this.stop);
  }

  /** Scales the shown range by `factor`, and shifts it by `shift` of its length. */
  zoom(factor, shift = 0) {
    const length = this.until - this.from;
    const middle = (this.from + this.until) / 2 + shift * length;
    const half = Math.min(length * factor, this.stop - this.start) / 2;
    const from = Math.min(Math.max(middle - half, this.start), this.stop - 2 * half);
    this.show(from, from + 2 * half);
  }
}

/** The last position whose time is not after this one. */
export function placeAt(times, time) {
  let low = 0;
  let high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle - 1;
  }
  return low;
}

/** The value between two instants; null if there is none. */
export function valueAt(times, values, time) {
  const place = placeAt(times, time);
  const [a, b] = [values[place], values[place + 1]];
  if (a == null || b == null || times[place + 1] <= times[place]) return a ?? null;
  const part = (time - times[place]) / (times[place + 1] - times[place]);
  return a + Math.min(Math.max(part, 0), 1) * (b - a);
}
