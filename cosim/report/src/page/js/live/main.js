// A live run: shows the messages of the server, at most once per screen frame.
import { Clock } from "../clock.js";
import { choice, el, facts } from "../dom.js";
import { num } from "../format.js";
import { startTheme, themeButton } from "../theme.js";
import { timePlot } from "../timeplot.js";
import { eventLog, faultForm, playControls } from "./controls.js";
import { liveMap } from "./map.js";
import { nameList, Signals } from "./signals.js";
import { bodyColumns, errorPlots, judged, Store } from "./store.js";

const WINDOWS = [["all", Infinity], ["the last 10 s", 10], ["the last minute", 60], ["the last 10 minutes", 600]];
const AGAIN = 1000;

/** Whether a figure is on the screen or close to it. */
function inView(figure) {
  const { top, bottom } = figure.getBoundingClientRect();
  return bottom > -100 && top < window.innerHeight + 100;
}

class LivePage {
  constructor() {
    for (const moved of ["scroll", "resize"]) window.addEventListener(moved, () => this.hello && this.dirty(), { passive: true });
    this.state = { time: 0, factor: 0, paused: false, ended: false, dropped: 0 };
    this.status = el("dl", { class: "facts", id: "status" });
    this.problem = el("p", { class: "notes", role: "alert", hidden: true });
    this.faults = [];
    this.window = Infinity;
    this.frames = 0;
    this.connect();
  }

  connect() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    this.socket = new WebSocket(`${scheme}://${location.host}/${location.search}`, "cosim.live.v1");
    this.socket.binaryType = "arraybuffer";
    this.socket.addEventListener("message", ({ data }) => (typeof data === "string" ? this.heard(JSON.parse(data)) : this.took(data)));
    this.socket.addEventListener("close", () => {
      if (this.state.ended) return;
      this.problem.hidden = false;
      this.problem.textContent = "There is no connection to the run. If it has not ended, the page connects again.";
      setTimeout(() => this.connect(), AGAIN);
    });
  }

  send(said) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(said));
  }

  heard(said) {
    if (said.op === "hello") this.begin(said);
    else if (said.op === "state") {
      this.state = said;
      this.controls.update(said);
      this.dirty();
    } else if (said.op === "event") {
      this.events.add(said);
      if (said.kind === "fault") this.faults.push(said.more);
    }
  }

  begin(hello) {
    this.hello = hello;
    this.problem.hidden = true;
    this.store = new Store();
    this.faults = [...hello.faults];
    this.clock = new Clock(hello.start, hello.start + 1);
    this.controls = playControls((said) => this.send(said));
    this.events = eventLog();
    this.map = liveMap(hello);
    const estimates = judged(hello);
    this.errorPlots = el("div", { class: "plots" });
    this.judge(estimates[0]);
    const chosen = this.signals?.chosen ?? [];
    this.signals = new Signals(hello, this.clock, this.faults, () => this.want());
    this.signals.chosen = chosen.filter((column) => column < hello.columns.length);
    const shown = choice("Plots show", WINDOWS.map(([name]) => name), 0, (place) => {
      this.window = WINDOWS[place][1];
      this.dirty();
    });
    const without = el("p", { class: "soft" }, "No truth with estimates is recorded: there are no errors to show.");
    const estimate = choice("Estimate", estimates.map(({ name }) => name), 0, (place) => {
      this.judge(estimates[place]);
      this.want();
    });
    document.getElementById("view").replaceChildren(
      el("h1", {}, hello.name), this.problem, this.controls.element, this.status, nameList("names", hello.columns.map(({ name }) => name)),
      el("div", { class: "wide" }, this.map.figure ?? el("p", { class: "soft" }, "No path is recorded: there is no map."), this.events.element),
      el("h2", {}, "Errors"), el("div", { class: "controls" }, estimates.length > 1 && estimate, shown),
      estimates.length > 0 ? this.errorPlots : without,
      this.signals.element, faultForm(hello, (said) => this.send(said)));
    document.title = `${hello.name} – live`;
    this.want();
  }

  /** Shows the errors of an estimate, if there is one. */
  judge(estimate) {
    for (const figure of this.errorFigures ?? []) figure.dispose();
    this.errors = estimate ? errorPlots(this.hello, estimate, this.store) : [];
    this.errorFigures = this.errors.map((plot) => timePlot(plot, this.clock, this.faults));
    this.errorPlots.replaceChildren(...this.errorFigures);
  }

  want() {
    const derived = [...this.map.derived, ...this.errors.flatMap((plot) => plot.derived)];
    this.send(this.store.want([...bodyColumns(this.hello), ...this.signals.chosen], derived));
    this.signalFigures = this.signals.rebuild(this.store);
  }

  took(buffer) {
    if (this.store.take(buffer) > 0) this.dirty();
  }

  dirty() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      this.show();
    });
  }

  show() {
    const { state, hello, clock } = this;
    const way = state.ended ? "ended" : state.paused ? "paused" : "running";
    this.status.replaceChildren(...facts([
      ["state", way], ["time", `${num(state.time, 7)} s of ${num(hello.stop, 7)} s`],
      ["real-time factor", way === "running" ? num(state.factor, 3) : "–"], ["instants not shown", String(state.dropped)],
    ]).children);
    const last = this.store.t.at(-1);
    if (last == null) return;
    // A cursor that the user has not moved follows the run.
    const along = clock.now >= clock.stop || clock.now === clock.start;
    clock.stop = Math.max(last, clock.start + 1e-9);
    clock.show(Math.max(clock.start, last - this.window), clock.stop);
    for (const figure of [...this.errorFigures, ...this.signalFigures].filter(inView)) figure.refresh();
    if (along) clock.set(clock.stop);
    this.map.refresh();
    this.frames += 1;
  }
}

startTheme();
document.getElementById("top").replaceChildren(el("p", { class: "brand" }, "cosim live"), themeButton());
document.getElementById("end").replaceChildren(el("p", { class: "small soft" }, "This page comes from the run itself and loads nothing else. Values on it are thinned; the file of results has them all."));
window.livePage = new LivePage();
