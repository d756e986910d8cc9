// What pages have in common: their controls, light and dark, and how they print.

import { mixAnew } from "page/colours";

const ICONS = { play: "M3 1l13 8-13 8z", pause: "M3 1h4.5v16H3zM10.5 1H15v16h-4.5z" };
const GREATEST = 1e5; // factor that displacements are drawn with

export const element = (id) => document.getElementById(id);

// Writes a text where another one stands: the same one again would be laid out and painted again.
export function tell(where, text) {
  if (where.textContent !== text) where.textContent = text;
}

// Factor of a slider's place between 0 and 1, of two digits.
export function roundFactor(place) {
  const raw = GREATEST ** Number(place);
  const digit = 10 ** Math.floor(Math.log10(raw));
  return raw < 10 ? Number(raw.toPrecision(2)) : Math.round(raw / (digit / 10)) * (digit / 10);
}

export function placeOfFactor(factor) {
  return String(Math.log(factor) / Math.log(GREATEST));
}

export function showPlaying(button, playing) {
  const icon = playing ? ICONS.pause : ICONS.play;
  if (button.dataset.icon !== icon) button.innerHTML = `<svg viewBox="0 0 18 18" aria-hidden="true"><path d="${icon}"/></svg>`;
  button.dataset.icon = icon;
}

// A copy over a scene: what WebGL has just drawn is not yet on the page that is printed.
function still(canvas) {
  const copy = Object.assign(document.createElement("canvas"), { className: "still", width: canvas.width, height: canvas.height });
  copy.getContext("2d").drawImage(canvas, 0, 0);
  canvas.after(copy);
}

// Calls `dress` when the system turns light or dark, and around printing, which is light, of its own width, and complete.
export function watchLook(dress) {
  const dressed = () => {
    mixAnew();
    dress();
    document.querySelectorAll(".plot .canvas").forEach((place) => place.dispatchEvent(new Event("dress")));
  };
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", dressed);
  const root = document.documentElement;
  const folded = new Set();
  window.addEventListener("beforeprint", () => {
    root.dataset.theme = "light";
    root.classList.add("printing");
    for (const each of document.querySelectorAll("details:not([open])")) {
      folded.add(each);
      each.open = true;
    }
    dressed();
    document.querySelectorAll(".stage canvas").forEach(still);
  });
  window.addEventListener("afterprint", () => {
    delete root.dataset.theme;
    root.classList.remove("printing");
    for (const each of folded) each.open = false;
    folded.clear();
    document.querySelectorAll(".still").forEach((each) => each.remove());
    dressed();
  });
}
