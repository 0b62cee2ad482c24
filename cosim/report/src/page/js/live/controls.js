// Controls of the run: pause, step, speed, faults.
import { choice, el } from "../dom.js";
import { num } from "../format.js";

const SPEEDS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100];

/** Playback buttons; `send` sends requests to the run, `update` shows its state. */
export function playControls(send) {
  const play = el("button", { type: "button", id: "play", onclick: () => send({ op: play.dataset.op }) }, "Pause");
  play.dataset.op = "pause";
  const step = el("button", { type: "button", onclick: () => send({ op: "step" }) }, "One step");
  const speeds = [...SPEEDS, null];
  const names = speeds.map((speed) => (speed == null ? "as fast as it can" : `${speed} ×`));
  const speed = choice("Speed", names, SPEEDS.indexOf(1), (place) => send({ op: "speed", factor: speeds[place] }));
  const select = speed.querySelector("select");
  const update = (state) => {
    play.dataset.op = state.paused ? "play" : "pause";
    play.textContent = state.paused ? "Go on" : "Pause";
    const now = state.speed ?? null;
    if (!speeds.includes(now)) select.append(el("option", { value: speeds.push(now) - 1 }, `${now} ×`));
    if (document.activeElement !== select) select.value = String(speeds.indexOf(now));
    for (const control of [play, step, select]) control.disabled = state.ended;
  };
  return { element: el("div", { class: "controls", role: "group", "aria-label": "The run" }, play, step, speed), update };
}

/** A form for a fault that begins immediately. */
export function faultForm(hello, send) {
  const fields = el("div", { class: "controls" });
  const meaning = el("p", { class: "small soft" });
  let kind = hello.kinds[0];
  const show = () => {
    meaning.textContent = kind.meaning;
    fields.replaceChildren(...kind.keys.map(({ key, meaning: what, words }) => {
      const input = words.length > 0
        ? el("select", { name: key }, el("option", { value: "" }, ""), words.map((word) => el("option", { value: word }, word)))
        : el("input", { name: key, inputmode: "decimal", size: 8, autocomplete: "off" });
      return el("label", { title: what }, key, input);
    }));
  };
  const kinds = choice("Fault", hello.kinds.map(({ name }) => name), 0, (place) => {
    kind = hello.kinds[place];
    show();
  });
  const on = el("input", { type: "search", list: "names", name: "on", required: true, size: 28 });
  const lasts = el("input", { name: "for", inputmode: "decimal", size: 6, autocomplete: "off" });
  const inject = (event) => {
    event.preventDefault();
    const fault = { kind: kind.name, on: on.value.split(/[\s,]+/).filter(Boolean) };
    for (const input of fields.querySelectorAll("input, select")) {
      if (input.value.trim() === "") continue;
      fault[input.name] = input.tagName === "SELECT" ? input.value : valueOf(input.value);
    }
    if (lasts.value.trim() !== "") fault.for = valueOf(lasts.value);
    if (kind.name === "reset") delete fault.for;
    send({ op: "fault", fault });
  };
  show();
  return el("section", {}, el("h2", {}, "Inject a fault"),
    el("form", { onsubmit: inject },
      el("div", { class: "controls" }, kinds, el("label", {}, "on variables", on), el("label", {}, "for (s)", lasts)),
      meaning, fields, el("button", { type: "submit", id: "inject" }, "Inject")),
    el("p", { class: "small soft" }, "It begins at the next output instant, and stays if nothing is said of its length. The run keeps it in a file, so that it can be repeated."));
}

/** A number if it is one, a list of numbers in brackets, otherwise the text: the run reports errors. */
function valueOf(text) {
  const plain = text.trim();
  if (/^\[.*\]$/.test(plain)) return plain.slice(1, -1).split(",").map(valueOf);
  const number = Number(plain);
  return Number.isFinite(number) ? number : plain;
}

/** Events, newest first. */
export function eventLog() {
  const list = el("ul", {}, el("li", { class: "soft" }, "none yet"));
  const add = ({ time, kind, text }) => {
    list.querySelector(":scope > .soft")?.remove();
    list.prepend(el("li", { class: kind }, el("b", {}, `${num(time, 7)} s`), ` ${text}`));
    while (list.children.length > 200) list.lastChild.remove();
  };
  return { element: el("section", {}, el("h2", {}, "Events"),
    el("div", { class: "log", role: "log", "aria-label": "Events", tabindex: "0" }, list)), add };
}
