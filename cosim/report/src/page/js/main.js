// The address determines the view: overview, a cell, or a run of a cell.
import { details, el, terms } from "./dom.js";
import { cellView, runFacts } from "./cell.js";
import { address } from "./format.js";
import { notes, overview } from "./overview.js";
import { runView, traceFacts } from "./run.js";
import { sectionsOf } from "./sections.js";
import { startTheme, themeButton } from "./theme.js";

const REPORT = JSON.parse(document.getElementById("data").textContent);

function decoded(text) {
  try {
    return decodeURIComponent(text);
  } catch {
    return text;
  }
}

/** The cell and the run that an address names; mail and chat programs may have decoded the address. */
function parsed(hash, known) {
  const text = hash.replace(/^#/, "");
  const whole = decoded(text);
  for (const [, name, run] of [/^([^/]*)(?:\/(\d+))?$/.exec(text), [whole, whole], /^(.*)\/(\d+)$/.exec(whole)].filter(Boolean)) {
    const cell = known.find((other) => [name, decoded(name)].includes(other.name));
    if (cell) return { cell, run: run == null ? null : Number(run) };
  }
  return { name: whole };
}

/** Why a cell has no run with this number. */
function otherRun({ expected, seeds, cells }, cell, run) {
  if (run >= expected) return [`There is no run ${run}: the runs are 0 to ${expected - 1}.`];
  const place = run % (expected / seeds);
  if (place === cell.place) return null;
  const owner = cells.find((other) => other.place === place);
  return [`Run ${run} belongs to another cell`, owner ? [": ", el("a", { href: address(owner.name, run) }, owner.name)] : ", which is not on this page", "."].flat();
}

function view() {
  const { campaign, runs, title } = REPORT;
  const alone = runs[""];
  if (!campaign) return { path: [], parts: [el("h1", {}, title), notes(REPORT), sectionsOf(REPORT.sections), alone && [traceFacts(alone), runView(alone)]] };
  const { name, cell, run } = parsed(location.hash, campaign.cells);
  if (name === "") return { path: [], parts: overview(REPORT) };
  if (!cell) return { path: [], parts: [el("h1", {}, title), el("p", {}, `This report has no cell '${name}'. `, el("a", { href: "#" }, "All cells"))] };
  const path = [[title, "#"], [cell.name, address(cell.name)]];
  if (run == null) return { path, parts: cellView(REPORT, cell) };
  const wrong = otherRun(campaign, cell, run);
  if (wrong) return { path, parts: [el("h1", {}, cell.name), el("p", {}, wrong)] };
  const trace = runs[run];
  return {
    path: [...path, [`run ${run}`, address(cell.name, run)]],
    parts: [el("h1", {}, `Run ${run} of ${cell.name}`), trace && runView(trace), el("h2", {}, "What the run is"), runFacts(campaign, cell, run),
      trace?.notes.length > 0 && el("ul", { class: "small" }, trace.notes.map((note) => el("li", {}, note)))],
  };
}

function header(path) {
  const links = path.map(([text, href], place) =>
    el("li", {}, el("a", { href, "aria-current": place === path.length - 1 ? "page" : null }, text)));
  document.getElementById("top").replaceChildren(
    el("a", { class: "skip", href: "#view", onclick: (event) => {
      event.preventDefault();
      document.getElementById("view").focus();
    } }, "Skip to the content"),
    path.length > 0 ? el("nav", { "aria-label": "Where you are" }, el("ol", {}, links)) : el("p", { class: "brand" }, "cosim report"), themeButton());
}

function show(first) {
  const { path, parts } = view();
  header(path);
  const main = document.getElementById("view");
  main.replaceChildren(...parts.flat(3).filter(Boolean));
  document.title = path.length > 1 ? `${path.at(-1)[0]} – ${REPORT.title}` : REPORT.title;
  if (first) return;
  window.scrollTo(0, 0);
  main.focus({ preventScroll: true });
}

function end() {
  document.getElementById("end").append(...[
    el("h2", {}, "Method and provenance"), terms(REPORT.provenance),
    REPORT.method.length > 0 && details("Definitions", () => terms(REPORT.method)),
    REPORT.identity.length > 0 && details("Everything that decides the runs: files with their SHA-256", () => el("pre", { tabindex: "0" }, el("code", {}, REPORT.identity.join("\n")))),
  ].filter(Boolean));
}

/** On paper the end is open: it is what an audit needs. */
function openOnPaper() {
  let opened = [];
  window.addEventListener("beforeprint", () => {
    opened = [...document.querySelectorAll("#end details:not([open])")];
    for (const element of opened) {
      element.open = true;
      // Its own event comes too late.
      element.dispatchEvent(new Event("toggle"));
    }
  });
  window.addEventListener("afterprint", () => opened.forEach((element) => (element.open = false)));
}

startTheme();
openOnPaper();
window.addEventListener("hashchange", () => show(false));
show(true);
end();
