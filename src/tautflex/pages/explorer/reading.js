// The plant as the page carries it, and whether this browser steps it as Python did.

import { carried, decoded, unpackMesh } from "page/data";
import { Film } from "page/film";
import { Loop } from "page/loop";

export function readPlant() {
  const data = carried();
  for (const part of [data.model, data.drives, data.sensing]) {
    for (const key of Object.keys(part)) part[key] = decoded(part[key]).values;
  }
  unpackMesh(data.mesh);
  const { values, scale, shape } = decoded(data.shapes);
  data.shapes = Float32Array.from(values, (value, k) => value * scale[k % shape[2]]);
  data.film = data.film && new Film(data.film);
  data.check.measured = decoded(data.check.measured).values;
  return data;
}

// Measurements at all intervals of a run from rest: gains, damping, numbers that are held, a slew, pushes.
export function trajectory(data, { gains, damping, held, turn, knocks, count }) {
  const loop = new Loop(data);
  Object.assign(loop.gains, gains);
  if (damping !== undefined) loop.damp(damping);
  for (const [number, value] of Object.entries(held || {})) loop.held[number] = value;
  loop.knocks = [...(knocks || [])];
  if (turn) loop.slew(turn);
  const measured = [Array.from(loop.measured)];
  for (let k = 0; k < count; k++) {
    for (let step = 0; step < data.steps; step++) loop.advance();
    measured.push(Array.from(loop.measured));
  }
  return measured;
}

// Largest difference from Python's run, as a part of each measurement's largest value, and of the film's stress.
export function deviation(data) {
  const found = trajectory(data, data.check).flat();
  const width = data.readings.length;
  const { measured } = data.check;
  let worst = data.film ? data.film.deviation() : 0;
  for (let n = 0; n < width; n++) {
    let [off, size] = [0, 0];
    for (let k = n; k < measured.length; k += width) {
      off = Math.max(off, Math.abs(found[k] - measured[k]));
      size = Math.max(size, Math.abs(measured[k]));
    }
    if (!(off <= worst * size)) worst = off / size;
  }
  return worst;
}
