// Selected signals: one plot for each unit.
import { el } from "../dom.js";
import { timePlot } from "../timeplot.js";

/** A list of names to choose from, for inputs. */
export function nameList(id, names) {
  return el("datalist", { id }, names.map((name) => el("option", { value: name })));
}

/** The part of the page with signals; `changed` is called when the selection changes, `plots` returns the plots. */
export class Signals {
  constructor(hello, clock, faults, changed) {
    Object.assign(this, { hello, clock, faults, changed });
    this.chosen = [];
    this.input = el("input", { type: "search", list: "names", id: "signal", "aria-describedby": "signal-help", placeholder: "name, or a pattern such as dvl.*" });
    this.list = el("ul", { class: "legend", "aria-label": "Signals that are shown" });
    this.figures = el("div", { class: "plots" });
    const add = (event) => {
      event.preventDefault();
      this.add(this.input.value.trim());
    };
    this.problem = el("p", { class: "small fail", role: "alert" });
    this.element = el("section", {}, el("h2", {}, "Signals"),
      el("form", { class: "controls", onsubmit: add }, el("label", {}, "Signal", this.input), el("button", { type: "submit" }, "Show")),
      el("p", { class: "small soft", id: "signal-help" }, "* stands for any text."), this.problem, this.list, this.figures);
  }

  add(wanted) {
    if (wanted === "") return;
    const pattern = new RegExp(`^${wanted.replace(/[.+^${}()|[\]\\?]/g, "\\$&").replace(/\*/g, ".*")}$`);
    const found = this.hello.columns.flatMap(({ name }, place) => (pattern.test(name) && !this.chosen.includes(place) ? [place] : []));
    this.problem.textContent = found.length === 0 ? `'${wanted}' is no other recorded variable` : "";
    if (found.length === 0) return;
    this.input.value = "";
    this.chosen.push(...found);
    this.changed();
  }

  remove(column) {
    this.chosen = this.chosen.filter((other) => other !== column);
    this.changed();
  }

  /** Rebuilds the plots from the current lists of the store. */
  rebuild(store) {
    const units = new Map();
    for (const column of this.chosen) {
      const { name, unit } = this.hello.columns[column];
      const line = { name, role: "signal", v: store.list(column) };
      // A signal with an unknown unit gets its own plot.
      const key = unit || name;
      if (!units.has(key)) units.set(key, { title: unit ? `Signals in ${unit}` : name, unit, t: store.t, grows: true, lines: [] });
      units.get(key).lines.push(line);
    }
    for (const figure of this.plots ?? []) figure.dispose();
    this.plots = [...units.values()].map((plot) => timePlot(plot, this.clock, this.faults));
    this.figures.replaceChildren(...this.plots);
    this.list.replaceChildren(...this.chosen.map((column) => {
      const { name } = this.hello.columns[column];
      return el("li", {}, name, el("button", { type: "button", "aria-label": `Remove ${name}`, onclick: () => this.remove(column) }, "×"));
    }));
    return this.plots;
  }
}
