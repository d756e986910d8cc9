// Sliders with a name and what they say, and choices.

import { written } from "page/axes";

function row(holder, name, className) {
  const label = holder.appendChild(Object.assign(document.createElement("label"), { className }));
  label.append(Object.assign(document.createElement("span"), { textContent: name }));
  return label;
}

export const short = (value, digits = 3) => written(Number(value.toPrecision(digits)));

// A slider between two values, by their logarithms if wanted; `said` makes words of a value, `set` takes it.
export function slider(holder, { name, low, high, value, logarithmic, said, set }) {
  const label = row(holder, name, "slider");
  const input = Object.assign(document.createElement("input"), { type: "range", min: "0", max: "1", step: "any" });
  const output = document.createElement("output");
  label.append(input, output);
  const at = (place) => (logarithmic ? low * (high / low) ** place : low + place * (high - low));
  const placeOf = (given) => (logarithmic ? Math.log(given / low) / Math.log(high / low) : (given - low) / (high - low));
  const put = (given) => {
    input.value = String(placeOf(given));
    output.textContent = said(given);
    set(given);
  };
  input.addEventListener("input", () => {
    // The start value has a place that is easy to find again.
    const near = Math.abs(Number(input.value) - placeOf(value)) < 0.015;
    const given = near ? value : at(Number(input.value));
    output.textContent = said(given);
    set(given);
  });
  put(value);
  return () => put(value);
}

export function choice(holder, { name, values, value, set }) {
  const label = row(holder, name, "choice");
  const select = label.appendChild(document.createElement("select"));
  for (const each of values) select.append(Object.assign(document.createElement("option"), { value: each, textContent: each }));
  select.addEventListener("input", () => set(select.value));
  const put = () => {
    select.value = value;
    set(value);
  };
  put();
  return put;
}

export function group(holder, title) {
  const element = holder.appendChild(document.createElement("fieldset"));
  element.append(Object.assign(document.createElement("legend"), { textContent: title }));
  return element;
}
