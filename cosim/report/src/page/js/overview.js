// Overview of the campaign: the question, the verdict, the matrix.
import { choice, details, el, facts, table } from "./dom.js";
import { address, answerMore, estimate, measured, num, verdictMark, withUnit, worst } from "./format.js";
import { quantile } from "./distribution.js";
import { contentsOf, sectionsOf } from "./sections.js";
import { colour, onTheme } from "./theme.js";

/** A value that is not a finite number is the worst; it has no colour. */
function worstRun(cell, figure, { small_is_bad: small }) {
  const own = cell.figures[figure];
  return !own || own.infinite > 0 ? null : quantile(own.quantiles, small ? 0 : 1);
}

const STATISTICS = [
  ["median", (cell, figure) => cell.figures[figure]?.median.value],
  ["95th percentile", (cell, figure) => cell.figures[figure]?.percentile_95.value],
  ["worst run", worstRun],
  ["failed runs (%)", (cell) => (cell.runs ? (100 * cell.failed) / cell.runs : null)],
];

/** The state of the view, kept between views. */
export const chosen = { figure: null, statistic: 0 };

function sentence({ answer, answers: [pass, fail, open], expected, runs }) {
  const all = pass + fail + open;
  const counted = `Thresholds of all cells: ${pass} of ${all} pass, ${fail} fail, ${open} undecided`;
  const missing = runs < expected ? `; ${expected - runs} of ${expected} runs are not there yet` : "";
  return answer === "none" ? `The campaign has no thresholds${missing}.` : `${counted}${missing}.`;
}

function banner(campaign) {
  return el("div", { class: `banner ${campaign.answer}`, id: "verdict" }, verdictMark(campaign.answer), el("p", {}, sentence(campaign)));
}

function mix(part) {
  const parse = (text) => [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16));
  const [low, high] = [parse(colour("low")), parse(colour("high"))];
  const rgb = low.map((value, i) => Math.round(value + part * (high[i] - value)));
  const light = rgb.map((value) => value / 255).map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
  const luminance = 0.2126 * light[0] + 0.7152 * light[1] + 0.0722 * light[2];
  return [`rgb(${rgb.join(",")})`, luminance > 0.179 ? "#000000" : "#ffffff"];
}

function matrix(campaign) {
  const { cells, figures } = campaign;
  const figure = figures[chosen.figure];
  const value = (cell) => STATISTICS[chosen.statistic][1](cell, chosen.figure, figure ?? {});
  const unit = chosen.statistic === 3 ? "%" : figure?.unit ?? "";
  const known = cells.map(value).filter((v) => v != null);
  const [low, high] = [Math.min(...known), Math.max(...known)];
  // Values over several orders of magnitude are coloured by their logarithms.
  const logarithmic = low > 0 && high / low > 30;
  const part = (v) => (high > low ? (logarithmic ? Math.log(v / low) / Math.log(high / low) : (v - low) / (high - low)) : 0);
  const columns = [...new Set(cells.map((cell) => cell.column))];
  const rows = new Map();
  for (const cell of cells) {
    if (!rows.has(cell.row)) rows.set(cell.row, new Map());
    rows.get(cell.row).set(cell.column, cell);
  }
  const box = (cell) => {
    if (!cell) return el("td", {}, "");
    const v = value(cell);
    const answer = worst(cell.verdicts.map((verdict) => verdict.answer));
    const spoken = [`${cell.name}: ${num(v, 3)}`, answer !== "none" && answer].filter(Boolean).join(", ");
    const link = el("a", { href: address(cell.name), "aria-label": spoken }, el("span", {}, num(v, 3)), answer !== "none" && verdictMark(answer, false));
    const paint = () => {
      if (v == null) return;
      const [background, ink] = mix(part(v));
      link.style.background = background;
      link.style.color = ink;
      link.querySelectorAll(".verdict").forEach((mark) => (mark.style.color = ink));
    };
    paint();
    onTheme(link, paint);
    return el("td", {}, link);
  };
  const lines = [...rows].map(([name, own]) => el("tr", {}, el("th", { scope: "row" }, name), columns.map((column) => box(own.get(column)))));
  const body = el("tbody", {}, lines.slice(0, 100));
  const caption = figure ? `${STATISTICS[chosen.statistic][0]} of ${withUnit(figure.name, figure.unit && `(${figure.unit})`)}` : "Cells";
  const heat = el("table", { class: "heat", id: "matrix" }, el("caption", {}, caption),
    el("thead", {}, el("tr", {}, el("th", { scope: "col" }, el("span", { class: "hidden" }, "scenario")), columns.map((name) => el("th", { scope: "col" }, name)))), body);
  const rest = lines.length > 100 && el("button", { type: "button", onclick: (event) => {
    body.append(...lines.slice(100));
    event.target.remove();
  } }, `Show all ${lines.length} rows`);
  const scale = known.length > 0 && el("p", { class: "scale" }, withUnit(num(low, 3), unit), el("i"), `${withUnit(num(high, 3), unit)}${logarithmic ? ", logarithmic" : ""}`,
    el("span", {}, "✔ pass  ✘ fail  ? undecided"));
  return [el("div", { class: "table", tabindex: "0", role: "region", "aria-label": "Matrix of cells" }, heat), rest, scale];
}

export function thresholds(verdicts, withCell) {
  const row = (verdict) => {
    const cells = [verdictMark(verdict.answer), verdict.figure, verdict.threshold, `${verdict.kept} of ${verdict.runs}`, estimate(verdict.quantile, verdict.runs, verdict.threshold.includes(" at least ") ? "−∞" : "∞"), answerMore(verdict.answer)];
    return withCell ? [el("a", { href: address(verdict.cell) }, verdict.cell), ...cells] : cells;
  };
  const head = ["verdict", "figure", "threshold", "runs that meet it", "quantile [interval]", "what would decide"];
  const order = { fail: 0, undecided: 1, pass: 2 };
  const sorted = [...verdicts].sort((a, b) => order[worst([a.answer])] - order[worst([b.answer])]);
  return table("Thresholds", withCell ? ["cell", ...head] : head, sorted.slice(0, 500).map(row), withCell ? [0, 1, 2, 3, 6] : [0, 1, 2, 5]);
}

/** Differences between the alternatives, run by run. */
export function comparisons(compared, figures, title) {
  const unit = (name) => figures.find((figure) => figure.name === name)?.unit ?? "";
  const row = ({ cell, with: other, figure, pairs, difference }) => {
    const [low, high] = difference.interval;
    const word = low > 0 ? "greater" : high != null && high < 0 ? "smaller" : "not distinguishable";
    return [el("a", { href: address(other) }, other), el("a", { href: address(cell) }, cell), figure, String(pairs), measured(difference, pairs, unit(figure)), low == null || high == null ? "too few runs" : word];
  };
  return table(title, ["cell", "minus", "figure", "pairs", "median difference [95 %]", "it is"], compared.slice(0, 500).map(row), [0, 1, 2, 5]);
}

/** What is missing. */
export function notes(report) {
  if (report.notes.length === 0) return null;
  return el("section", { class: "notes", "aria-label": "What to know" }, el("strong", {}, "What to know"),
    el("ul", {}, report.notes.map((note) => el("li", {}, note))));
}

/** The first screen. */
export function overview(report) {
  const { campaign } = report;
  chosen.figure ??= campaign.main;
  const place = el("div");
  const refill = () => place.replaceChildren(...matrix(campaign).filter(Boolean));
  refill();
  const controls = el("div", { class: "controls" },
    campaign.figures.length > 0 && choice("Figure ", campaign.figures.map((figure) => figure.name), chosen.figure, (figure) => {
      chosen.figure = figure;
      refill();
    }),
    choice("Statistic ", STATISTICS.map(([name]) => name), chosen.statistic, (statistic) => {
      chosen.statistic = statistic;
      refill();
    }));
  const verdicts = campaign.cells.flatMap((cell) => cell.verdicts);
  const compared = campaign.cells.flatMap((cell) => cell.compared);
  const failures = campaign.cells.flatMap((cell) => cell.failures.map((failure) => ({ cell, ...failure })));
  return [
    el("h1", {}, report.title),
    report.question && el("p", { class: "question" }, report.question),
    banner(campaign),
    report.summary.map((text) => el("p", { class: "summary" }, text)),
    facts([["Runs", `${campaign.runs} of ${campaign.expected}`], ["Failed runs", String(campaign.failed)], ["Cells", String(campaign.cells.length)],
      ["Runs of each cell", String(campaign.seeds)]]),
    controls, place, notes(report), contentsOf(report.sections), sectionsOf(report.sections),
    verdicts.length > 0 && [el("h2", {}, "Verdicts"), thresholds(verdicts, true)],
    compared.length > 0 && [el("h2", {}, "Paired comparison"), comparisons(compared, campaign.figures, "Differences, run by run")],
    failures.length > 0 && [el("h2", {}, "Failed runs"), table("Failures by their reason", ["cell", "status", "runs", "reason"],
      failures.slice(0, 200).map(({ cell, status, count, reason }) => [el("a", { href: address(cell.name) }, cell.name), status, String(count), reason]), [0, 1, 3])],
    details("Figures of all cells", () => table("Figures", ["cell", "figure", "runs", "median [95 %]", "95th percentile [95 %]"],
      campaign.cells.slice(0, 1000).flatMap((cell) => cell.figures.map((figure, i) => [el("a", { href: address(cell.name) }, cell.name), campaign.figures[i].name,
        String(figure.runs), measured(figure.median, figure.runs, campaign.figures[i].unit), measured(figure.percentile_95, figure.runs, campaign.figures[i].unit)])), [0, 1])),
  ].flat(2).filter(Boolean);
}
