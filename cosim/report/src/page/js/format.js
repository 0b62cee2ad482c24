// Numbers and verdicts as text.
import { el } from "./dom.js";

/** Four significant digits; a dash if it is not a number. */
export function num(value, digits = 4) {
  if (value == null || Number.isNaN(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text = size >= 1e6 || size < 1e-4
    ? Number(value.toPrecision(digits)).toExponential().replace("e+", "e")
    : String(Number(value.toPrecision(digits)));
  return text.replace("-", "−");
}

export function withUnit(text, unit) {
  return unit && unit !== "1" ? `${text} ${unit}` : text;
}

/** An estimate from this many runs, with its interval; `unknown` is what a run without a value counts as. */
export function estimate({ value, interval }, runs, unknown = "∞") {
  if (runs === 0) return "–";
  const end = (bound, otherwise) => (bound == null ? otherwise : num(bound));
  return `${value == null ? unknown : num(value)} [${end(interval[0], "−∞")}, ${end(interval[1], "∞")}]`;
}

/** An estimate with its unit. */
export function measured(of, runs, unit) {
  return runs === 0 ? "–" : withUnit(estimate(of, runs), unit);
}

const WORDS = { pass: ["✔", "pass"], fail: ["✘", "fail"], undecided: ["?", "undecided"], none: ["–", "no threshold"] };

/** The key of an answer, which is a word or the number of further runs that would decide. */
function answerKey(answer) {
  return typeof answer === "string" ? answer : "undecided";
}

export function verdictMark(answer, words = true) {
  const key = answerKey(answer);
  const [symbol, word] = WORDS[key];
  return el("span", { class: `verdict ${key}` }, el("span", { "aria-hidden": "true" }, symbol),
    el("span", { class: words ? null : "hidden" }, word));
}

/** What would decide an open answer. */
export function answerMore(answer) {
  if (typeof answer === "string") return "";
  const more = answer.undecided;
  return more == null ? "it is too close to the threshold" : `${more} more runs of the cell would decide`;
}

/** The worst of several answers. */
export function worst(answers) {
  const keys = answers.map(answerKey);
  return ["fail", "undecided", "pass"].find((key) => keys.includes(key)) ?? "none";
}

/** The address of a view of this page. */
export function address(cell, run) {
  const name = `#${encodeURIComponent(cell)}`;
  return run == null ? name : `${name}/${run}`;
}
