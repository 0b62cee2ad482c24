// Text, tables and pictures that were written for this page.
import { el, table } from "./dom.js";

const BLOCKS = {
  text: (text) => el("p", { class: "prose" }, text),
  list: (items) => el("ul", { class: "prose" }, items.map((item) => el("li", {}, item))),
  code: (text) => el("pre", { tabindex: "0" }, el("code", {}, text)),
  table: ({ caption, header, rows }) => table(caption, header, rows.map((row) => header.map((_, column) => row[column] ?? ""))),
  // An image runs no scripts, whatever is in it.
  figure: ({ svg, caption }) => el("figure", { class: "drawn" },
    el("div", { class: "picture", tabindex: "0", role: "group", "aria-label": "Picture" },
      el("img", { src: `data:image/svg+xml,${encodeURIComponent(svg)}`, alt: caption })),
    el("figcaption", {}, caption)),
};

function idOf(place) {
  return `section-${place + 1}`;
}

export function sectionsOf(sections) {
  return sections.map(({ heading, blocks }, place) =>
    el("section", { id: idOf(place) }, el("h2", { tabindex: "-1" }, heading), blocks.map(({ kind, value }) => BLOCKS[kind](value))));
}

/** Buttons, because the address of the page chooses the view. */
export function contentsOf(sections) {
  if (sections.length < 2) return null;
  return el("nav", { "aria-label": "Sections", class: "contents" }, el("ol", {}, sections.map(({ heading }, place) =>
    el("li", {}, el("button", { type: "button", onclick: () => {
      const section = document.getElementById(idOf(place));
      section.scrollIntoView();
      section.querySelector("h2").focus({ preventScroll: true });
    } }, heading)))));
}
