// Axes of a small plot on a canvas: ticks at round numbers, labels, and where values lie.

import { ink } from "page/colours";
import { drawnBySoftware } from "page/software";

export const MARGIN = { left: 58, right: 10, top: 6, bottom: 24 };
const NAME = 13; // pixels that the name of the y axis takes

export function roundTicks(low, high, most) {
  const raw = (high - low) / Math.max(1, most);
  const base = 10 ** Math.floor(Math.log10(raw || 1));
  const step = [1, 2, 5, 10].map((factor) => factor * base).find((one) => one >= raw * 0.999);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
  return found;
}

export function decadeTicks(low, high) {
  const found = [];
  const few = high / low < 50;
  for (let power = Math.floor(Math.log10(low)); 10 ** power <= high; power++) {
    for (const factor of few ? [1, 2, 5] : [1]) {
      const value = factor * 10 ** power;
      if (value >= low * 0.999 && value <= high * 1.001) found.push(value);
    }
  }
  return found;
}

export function written(value) {
  if (value === 0) return "0";
  const size = Math.abs(value);
  const short = Number(value.toPrecision(6));
  return (size >= 1e5 || size < 1e-3 ? short.toExponential().replace("+", "") : String(short)).replaceAll("-", "−");
}

// Calls `draw` when the place of a canvas has another size, or other colours.
export function followed(canvas, draw) {
  const place = canvas.parentElement;
  const again = () => {
    canvas.room = [place.clientWidth, place.clientHeight]; // asked for here, not at every drawing: it lays out the page
    draw();
  };
  new ResizeObserver(again).observe(place);
  place.addEventListener("dress", again);
}

// Gives a canvas the size of its place, at the screen's resolution.
export function sized(canvas) {
  const [width, height] = canvas.room || [0, 0];
  const ratio = Math.max(window.devicePixelRatio, 1.5);
  const [across, down] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== across || canvas.height !== down) [canvas.width, canvas.height] = [across, down];
  // The processor draws lines at once far sooner than as a graphics processor would.
  const context = canvas.getContext("2d", { willReadFrequently: drawnBySoftware });
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = "11px system-ui, sans-serif";
  return { context, width, height };
}

// A scale: value to pixel, linear or logarithmic.
export function scale(low, high, from, to, logarithmic) {
  const map = logarithmic ? Math.log10 : (value) => value;
  const factor = (to - from) / (map(high) - map(low) || 1);
  const at = (value) => from + (map(value) - map(low)) * factor;
  at.value = (pixel) => {
    const place = map(low) + (pixel - from) / factor;
    return logarithmic ? 10 ** place : place;
  };
  at.ticks = (most) => (logarithmic ? decadeTicks(low, high) : roundTicks(low, high, most));
  return at;
}

// Grid, numbers and names of both axes.
export function drawAxes(context, width, height, x, y, labelX, labelY) {
  const { left, right, top, bottom } = MARGIN;
  context.lineWidth = 1;
  context.strokeStyle = ink("--rule");
  context.fillStyle = ink("--soft");
  context.textAlign = "right";
  context.textBaseline = "middle";
  for (const value of y.ticks(Math.max(2, Math.floor((height - top - bottom) / 24)))) {
    line(context, left, y(value), width - right, y(value));
    context.fillText(written(value), left - 6, y(value), left - 6 - NAME); // squeezed to the room beside the name
  }
  context.textAlign = "center";
  context.textBaseline = "top";
  const room = width - right - context.measureText(labelX).width - 5;
  for (const value of x.ticks(Math.max(2, Math.floor((width - left - right) / 60)))) {
    line(context, x(value), top, x(value), height - bottom);
    const text = written(value);
    if (x(value) + 0.5 * context.measureText(text).width < room) context.fillText(text, x(value), height - bottom + 6);
  }
  context.textAlign = "right";
  context.fillText(labelX, width - right, height - bottom + 6);
  context.save();
  context.translate(NAME / 2, (top + height - bottom) / 2);
  context.rotate(-Math.PI / 2);
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(labelY, 0, 0, height - top);
  context.restore();
  context.strokeStyle = ink("--soft");
  context.strokeRect(left, top, width - left - right, height - top - bottom);
}

// Adds a curve to the path: of many points in one column of pixels the first, the ends of their span, and the last.
export function trace(context, xs, ys, x, y) {
  let [column, low, high, last, count] = [NaN, 0, 0, 0, 0];
  const leave = () => {
    if (count > 2) {
      context.lineTo(column, low);
      context.lineTo(column, high);
    }
    if (count > 1) context.lineTo(column, last);
  };
  for (let k = 0; k < xs.length; k++) {
    const [across, down] = [x(xs[k]), y(ys[k])];
    if (Math.abs(across - column) < 0.5) {
      if (down < low) low = down;
      if (down > high) high = down;
      last = down;
      count += 1;
      continue;
    }
    leave();
    context.lineTo(across, down);
    [column, low, high, last, count] = [across, down, down, down, 1];
  }
  leave();
}

export function line(context, x0, y0, x1, y1) {
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
}
