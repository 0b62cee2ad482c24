// DOM elements; text is never parsed as markup.

/** An element with attributes; children are nodes or texts. `on...` are listeners, false is skipped. */
export function el(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === false || value == null) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? "" : String(value));
  }
  element.append(...children.flat().filter((child) => child != null && child !== false));
  return element;
}

/** A table with a caption; cells are nodes or texts, the first of a row is its heading. */
export function table(caption, head, rows, texts = []) {
  const kind = (column) => (texts.includes(column) ? "text" : null);
  const heads = head.map((name, column) => el("th", { scope: "col", class: kind(column) }, name));
  const line = (row) => el("tr", {}, row.map((cell, column) =>
    column === 0 ? el("th", { scope: "row", class: kind(0) }, cell) : el("td", { class: kind(column) }, cell)));
  return el("div", { class: "table", tabindex: "0", role: "region", "aria-label": caption },
    el("table", {}, el("caption", {}, caption), el("thead", {}, el("tr", {}, heads)), el("tbody", {}, rows.map(line))));
}

/** A labelled list of choices. */
export function choice(label, options, chosen, changed) {
  const select = el("select", { onchange: () => changed(Number(select.value)) },
    options.map((name, place) => el("option", { value: place, selected: place === chosen }, name)));
  return el("label", {}, label, select);
}

export function details(summary, make, open = false) {
  const body = el("div");
  let made = false;
  const element = el("details", { open }, el("summary", {}, summary), body);
  const fill = () => {
    if (element.open && !made) {
      made = true;
      body.append(...[make()].flat());
    }
  };
  element.addEventListener("toggle", fill);
  fill();
  return element;
}

export function terms(list) {
  return el("dl", { class: "terms" }, list.flatMap(({ term, text }) => [el("dt", {}, term), el("dd", {}, text)]));
}

export function facts(list) {
  return el("dl", { class: "facts" }, list.map(([term, text]) => el("div", {}, el("dt", {}, term), el("dd", {}, text))));
}
