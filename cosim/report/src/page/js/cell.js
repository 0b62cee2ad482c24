// One cell: the distribution of its figures, their dependencies, comparisons, failures.
import { choice, el, facts, table } from "./dom.js";
import { address, answerMore, measured, num, verdictMark, withUnit, worst } from "./format.js";
import { boxes, labelled, scatter, shares } from "./distribution.js";
import { Clock } from "./clock.js";
import { timePlot, timeSlider, zoomButtons } from "./timeplot.js";
import { chosen, comparisons, thresholds } from "./overview.js";

/** The command that repeats a run. */
function replayCommand(campaign, run) {
  return el("pre", { class: "command", tabindex: "0" }, el("code", {}, `cosim replay ${campaign.folder_quoted} ${run} --output-file run${run}.csv`));
}

function go(cell, run) {
  window.location.hash = address(cell.name, run);
}

/** Cells of the same row: the alternatives that are compared. */
function siblings(campaign, cell) {
  return campaign.cells.filter((other) => other.row === cell.row);
}

function spread(campaign, cell, figure) {
  const { name, unit } = campaign.figures[figure];
  const alike = siblings(campaign, cell).slice(0, 12);
  const groups = alike.map((other) => ({ name: other.column, quantiles: other.figures[figure].quantiles, points: other.sample.figures[figure] }));
  return el("div", { class: "plots" },
    boxes(`${name}: box plot of ${cell.row}`, labelled(name, unit), groups, (group, place) => go(alike[group], alike[group].sample.run[place])),
    shares(`${name}: share of runs up to each value`, labelled(name, unit), groups));
}

function paired(campaign, cell, figure) {
  const others = siblings(campaign, cell).filter((other) => other !== cell);
  if (others.length === 0) return null;
  const { name, unit } = campaign.figures[figure];
  const replicate = (run) => Math.floor(run / (campaign.expected / campaign.seeds));
  const plots = others.slice(0, 4).map((other) => {
    const place = new Map(other.sample.run.map((run, i) => [replicate(run), i]));
    const pairs = cell.sample.run.map((run, i) => [other.sample.figures[figure][place.get(replicate(run))], cell.sample.figures[figure][i], run])
      .filter(([a, b]) => a != null && b != null);
    const better = pairs.filter(([a, b]) => b < a).length;
    return scatter({
      title: `${name}: ${cell.column} against ${other.column}`, x: labelled(other.column, unit), y: labelled(cell.column, unit),
      xs: pairs.map(([a]) => a), ys: pairs.map(([, b]) => b), equalLine: true, clicked: (i) => go(cell, pairs[i][2]),
      note: `Each point is a replicate; below the line ${cell.column} is smaller: in ${better} of ${pairs.length}.`,
    });
  });
  return el("div", { class: "plots" }, plots);
}

function sensitivity(campaign, cell, figure) {
  const { name, unit } = campaign.figures[figure];
  const varied = campaign.inputs.map((input, place) => ({ input, place, rho: cell.sensitivity[figure]?.[place] }))
    .filter(({ place }) => new Set(cell.sample.inputs[place]).size > 1);
  if (varied.length === 0) return null;
  varied.sort((a, b) => Math.abs(b.rho ?? 0) - Math.abs(a.rho ?? 0));
  const rows = varied.map(({ input, rho }) => {
    const bar = el("span", { class: "bar", "aria-hidden": "true" });
    bar.style.width = `${Math.abs(rho ?? 0) * 8}rem`;
    return [input.name, rho == null ? "–" : num(rho, 3), bar];
  });
  const place = el("div");
  const show = (i) => {
    const { input, place: column } = varied[i];
    const note = input.texts ? input.texts.map((text, number) => `${number} = ${text}`).join(", ") : "";
    place.replaceChildren(scatter({
      title: `${name} against ${input.name}`, x: labelled(input.name, input.unit), y: labelled(name, unit),
      xs: cell.sample.inputs[column], ys: cell.sample.figures[figure], clicked: (run) => go(cell, cell.sample.run[run]), note,
    }));
  };
  show(0);
  return el("div", { class: "plots" },
    el("div", {}, table("Rank correlation with dispersed parameters", ["parameter", "Spearman's ρ", "size"], rows, [0, 2]),
      varied.length > 1 && choice("Parameter ", varied.map(({ input }) => input.name), 0, show)), place);
}

/** A figure of these cells over `level`, a number of each; a line for each column of the matrix. */
function along(campaign, figure, factor, alike, level) {
  const { name, unit } = campaign.figures[figure];
  const lines = [...new Set(alike.map((other) => other.column))].map((column) => {
    const own = alike.filter((other) => other.column === column).sort((a, b) => level(a) - level(b));
    return { name: column, xs: own.map(level), ys: own.map((other) => other.figures[figure].median.value), high: own.map((other) => other.figures[figure].percentile_95.value) };
  });
  const input = campaign.inputs.find((known) => known.name === factor);
  return scatter({ title: `${name} along ${factor}`, x: labelled(factor, input?.unit), y: labelled(name, unit), lines, note: "Points: medians; dashed: 95th percentiles." });
}

/** A figure over the levels of a factor, for cells that otherwise have the same factors. */
function alongFactors(campaign, cell, figure) {
  const plots = campaign.levels.map((factor, place) => {
    const alike = campaign.cells.filter((other) => other.levels.every((level, i) => i === place || level === cell.levels[i]) && other.scenario === cell.scenario);
    const numeric = alike.every((other) => Number.isFinite(Number(other.levels[place])));
    if (!numeric || new Set(alike.map((other) => other.levels[place])).size < 2) return null;
    return along(campaign, figure, factor, alike, (other) => Number(other.levels[place]));
  });
  const known = [...plots, alongOutages(campaign, cell, figure)].filter(Boolean);
  return known.length ? el("div", { class: "plots" }, known) : null;
}

/** A figure over the length of the outage, for scenarios that differ only in when their faults act, and for those without faults. */
function alongOutages(campaign, cell, figure) {
  if (!cell.outage?.words) return null;
  const alike = campaign.cells.filter((other) => other.outage && ["", cell.outage.words].includes(other.outage.words) && other.levels.every((level, i) => level === cell.levels[i]));
  const lengths = new Set(alike.map((other) => other.outage.length).filter((length) => length > 0));
  // The last input is the length of the outage.
  return lengths.size < 2 ? null : along(campaign, figure, campaign.inputs.at(-1).name, alike, (other) => other.outage.length);
}

function consistency(campaign, cell) {
  const rows = cell.figures.map((figure, i) => [figure, campaign.figures[i]]).filter(([figure]) => figure.consistency).map(([figure, { name, what }]) => {
    const { freedom, low, high } = figure.consistency;
    const word = figure.mean > high ? "too sure of itself" : figure.mean < low ? "too cautious" : "consistent";
    return [name, what, String(freedom), num(figure.mean), `[${num(low)}, ${num(high)}]`, word];
  });
  return rows.length ? table("Consistency: means over the runs", ["figure", "of", "expected", "mean", "95 % of χ²", "the filter is"], rows, [0, 1, 5]) : null;
}

/** The faults of the cell, if they are the same in all its runs that are shown. */
function commonFaults(report, cell) {
  const own = cell.shown.map(({ run }) => report.runs[run]?.faults).filter(Boolean);
  return own.every((faults) => JSON.stringify(faults) === JSON.stringify(own[0])) ? own[0] ?? [] : [];
}

/** Means over the runs at each instant, with the band of a consistent filter. */
function meansOf({ figure, t, mean, low, high }) {
  return { title: `${figure}: mean over the runs`, unit: "1", t, lines: [{ name: "mean", role: "truth", v: mean },
    { name: "95 % of χ², low", role: "signal", v: low }, { name: "high", role: "signal", v: high }] };
}

/** Quantiles of the errors of all runs at each instant, and the deviation that the estimator claims. */
function errorsOf({ figure, t, quantiles, three_sigma: v }, { figures }) {
  const lines = ["5 % of the runs", "25 %", "median", "75 %", "95 %"].map((name, i) => ({ name, role: i === 2 ? "truth" : "edge", v: quantiles[i] }));
  const { unit } = figures.find(({ name }) => name === figure);
  return { title: `${figure}: errors of the runs`, unit, t, lines, fills: [[0, 4], [1, 3]], band: { name: "± 3 σ claimed, median", v } };
}

function overTime(report, cell) {
  const all = [...cell.over_time, ...cell.errors];
  if (all.length === 0) return null;
  const clock = new Clock(Math.min(...all.map(({ t }) => t[0])), Math.max(...all.map(({ t }) => t.at(-1))));
  const faults = commonFaults(report, cell);
  const plots = [...cell.over_time.map(meansOf), ...cell.errors.map((errors) => errorsOf(errors, report.campaign))];
  return [el("h2", {}, "Over time"), timeSlider(clock), zoomButtons(clock),
    el("div", { class: "plots" }, plots.map((plot) => timePlot({ steps: false, down: false, ...plot }, clock, faults)))];
}

/** A line for each run that matters: those that are shown in full, then the worst. */
function runs(campaign, cell, figure) {
  const { sample } = cell;
  const why = new Map(cell.shown.map((shown) => [shown.run, shown]));
  const { name: by, small_is_bad: small } = campaign.figures[figure] ?? {};
  const badness = (i) => (sample.figures[figure]?.[i] ?? (small ? -Infinity : Infinity)) * (small ? -1 : 1);
  const order = sample.run.map((run, i) => i).sort((a, b) => badness(b) - badness(a) || 0);
  const places = [...cell.shown.map((shown) => sample.run.indexOf(shown.run)).filter((i) => i >= 0), ...order.slice(0, 12)];
  const row = (i) => {
    const run = sample.run[i];
    const shown = why.get(run);
    const shownText = shown ? (shown.problem ? `${shown.why}; not shown: ${shown.problem}` : `${shown.why}, shown whole`) : "";
    return [el("a", { href: address(cell.name, run) }, `run ${run}`), ...sample.figures.map((values) => num(values[i])), shownText];
  };
  const head = ["run", ...campaign.figures.map(({ name, unit }) => withUnit(name, unit && unit !== "1" ? `(${unit})` : "")), "on this page"];
  // The points have the worst runs by the main figure only.
  const all = figure === campaign.main || sample.run.length === cell.runs - cell.failed;
  const caption = by == null ? "Runs" : `Runs: those shown whole, and the worst ${all ? "" : "of the points "}by ${by}`;
  return table(caption, head, [...new Set(places)].map(row), [0, head.length - 1]);
}

function failures(campaign, cell) {
  return cell.failures.map(({ status, reason, count, runs: first }) => [
    el("p", {}, el("strong", {}, `${count} ${count === 1 ? "run" : "runs"} ${status}: `), reason || "no reason is recorded"),
    el("p", { class: "small" }, "Runs ", first.flatMap((run, i) => [i > 0 && ", ", el("a", { href: address(cell.name, run) }, String(run))]), count > first.length ? " …" : ""),
    replayCommand(campaign, first[0]),
  ]);
}

/** A threshold, and what would decide it. */
function bounded({ figure, threshold, answer }) {
  const more = answerMore(answer);
  return `${figure}: ${threshold}${more && ` (${more})`}`;
}

export function cellView(report, cell) {
  const { campaign } = report;
  chosen.figure ??= campaign.main;
  const answer = worst(cell.verdicts.map((verdict) => verdict.answer));
  const place = el("div");
  const refill = () => {
    const figure = chosen.figure;
    const parts = campaign.figures.length > 0 && [
      el("h2", {}, "Distribution"), spread(campaign, cell, figure),
      siblings(campaign, cell).length > 1 && [el("h2", {}, "Paired comparison"), cell.compared.length > 0 && comparisons(cell.compared, campaign.figures, "Differences, run by run"), paired(campaign, cell, figure)],
      campaign.inputs.length > 0 && [el("h2", {}, "Sensitivity"), sensitivity(campaign, cell, figure) ?? el("p", { class: "soft" }, "No parameter differs between the runs of this cell, or there is no room for points."), alongFactors(campaign, cell, figure)]];
    place.replaceChildren(...[parts, el("h2", {}, "Runs"), runs(campaign, cell, figure)].flat(2).filter(Boolean));
  };
  refill();
  const figures = cell.figures.map((figure, i) => {
    const { name, what, unit } = campaign.figures[i];
    return [name, what, String(figure.runs), measured(figure.median, figure.runs, unit), measured(figure.percentile_95, figure.runs, unit), figure.infinite ? String(figure.infinite) : "0"];
  });
  return [
    el("h1", {}, cell.name, " "),
    el("p", { class: "banner " + answer }, verdictMark(answer), el("span", { class: "soft" }, cell.verdicts.map(bounded).join("; "))),
    facts([["Runs", String(cell.runs)], ["Failed runs", String(cell.failed)], ["Scenario", cell.row], ["Column", cell.column]]),
    cell.verdicts.length > 0 && thresholds(cell.verdicts, false),
    figures.length > 0 && table("Figures", ["figure", "what it is", "runs", "median [95 %]", "95th percentile [95 %]", "not finite"], figures, [0, 1]),
    consistency(campaign, cell),
    overTime(report, cell),
    cell.failures.length > 0 && [el("h2", {}, "Failed runs"), failures(campaign, cell)],
    campaign.figures.length > 1 && el("div", { class: "controls" }, choice("Figure ", campaign.figures.map((figure) => figure.name), chosen.figure, (figure) => {
      chosen.figure = figure;
      refill();
    })),
    place,
  ].flat(3).filter(Boolean);
}

/** Why a run is shown. */
const WHY = {
  worst: "This is the worst run of its cell.", median: "This is the median run of its cell.",
  between: "This run is between the worst and the best of its cell.", chosen: "This run was chosen for this page.",
};

/** The data of a run of a campaign. */
export function runFacts(campaign, cell, run) {
  const i = cell.sample.run.indexOf(run);
  const shown = cell.shown.find((other) => other.run === run);
  const failure = cell.failures.find((known) => known.runs.includes(run));
  const known = i < 0 ? [] : [
    ...campaign.figures.map(({ name, unit }, f) => [name, withUnit(num(cell.sample.figures[f][i]), unit)]),
    ...campaign.inputs.map(({ name, unit, texts }, p) => [name, texts ? texts[cell.sample.inputs[p][i]] ?? "–" : withUnit(num(cell.sample.inputs[p][i]), unit)])];
  return [
    facts([["Replicate", String(Math.floor(run / (campaign.expected / campaign.seeds)))], ...known]),
    shown && el("p", { class: "small" }, `${WHY[shown.why]} Digest of what its figures are from: `, el("code", {}, shown.digest)),
    shown?.problem && el("p", { class: "notes" }, `It cannot be shown whole: ${shown.problem}`),
    failure && el("p", { class: "notes" }, `It ${failure.status}: ${failure.reason}`),
    el("p", {}, "The command that makes it again, with every variable:"), replayCommand(campaign, run),
  ].filter(Boolean);
}
