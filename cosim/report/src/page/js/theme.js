// Light and dark: the system setting until the user chooses.
import { el } from "./dom.js";

const ROOT = document.documentElement;
const PREFERS = window.matchMedia("(prefers-color-scheme: dark)");
const REPAINTED = new Set();
let chosenTheme = null;

/** A colour of the style. */
export function colour(name) {
  return getComputedStyle(ROOT).getPropertyValue(`--${name}`).trim();
}

/** Calls back when colours change, for as long as the element is on the page. */
export function onTheme(element, repaint) {
  REPAINTED.add({ element, repaint });
}

function applyTheme(theme) {
  ROOT.dataset.theme = theme;
  for (const entry of REPAINTED) {
    if (entry.element.isConnected) entry.repaint();
    else REPAINTED.delete(entry);
  }
}

function currentTheme() {
  return chosenTheme ?? (PREFERS.matches ? "dark" : "light");
}

export function themeButton() {
  const label = () => (currentTheme() === "dark" ? "Light colours" : "Dark colours");
  const button = el("button", { type: "button", id: "theme", onclick: () => {
    chosenTheme = currentTheme() === "dark" ? "light" : "dark";
    applyTheme(chosenTheme);
    button.textContent = label();
  } }, label());
  return button;
}

export function startTheme() {
  ROOT.dataset.theme = currentTheme();
  PREFERS.addEventListener("change", () => applyTheme(currentTheme()));
  // Paper is white.
  window.addEventListener("beforeprint", () => applyTheme("light"));
  window.addEventListener("afterprint", () => applyTheme(currentTheme()));
}
