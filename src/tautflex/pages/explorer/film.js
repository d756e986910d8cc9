// Stress of the film as a polynomial of the coordinates, see `pages/film_stress.py`: where it pushes, a real one wrinkles.

import { decoded } from "page/data";

export class Film {
  constructor(given) {
    const scaled = (array) => {
      const { values, scale, shape } = decoded(array);
      const width = shape[shape.length - 1];
      return Float64Array.from(values, (value, k) => value * scale[k % width]);
    };
    Object.assign(this, given);
    for (const key of ["level", "area", "element", "triangle"]) this[key] = decoded(given[key]).values;
    [this.fields, this.mix] = [scaled(given.fields), scaled(given.mix)];
    this.count = given.fields.shape[2];
    this.amounts = new Float64Array(this.count);
    this.pushes = new Uint8Array(this.elements + 1); // of every element that is watched, and of none
    this.check = { z: decoded(given.check.z).values, least: decoded(given.check.least).values };
  }

  // Looks at a motion z: smallest principal resultant [N/m], and part of the film's area where it is negative.
  look(z) {
    const { level, fields, mix, amounts, count, area, element, pushes } = this;
    for (let k = 0, at = 0; k < count; k++) {
      let amount = 0;
      for (let i = 0; i < z.length; i++, at++) amount += mix[at] * z[i];
      amounts[k] = amount;
    }
    const sum = (from) => {
      let found = level[from];
      for (let k = 0, at = count * from; k < count; k++, at++) found += fields[at] * amounts[k];
      return found;
    };
    pushes.fill(0);
    [this.least, this.share] = [Infinity, 0];
    for (let point = 0; point < area.length; point++) {
      const [xx, yy, xy] = [sum(3 * point), sum(3 * point + 1), sum(3 * point + 2)];
      const low = 0.5 * (xx + yy) - Math.hypot(0.5 * (xx - yy), xy);
      if (low < this.least) this.least = low;
      if (low >= 0) continue;
      pushes[element[point]] = 1;
      this.share += area[point];
    }
    return this.least;
  }

  // Largest difference from Python over some motions, as a part of the largest value.
  deviation() {
    const { z, least } = this.check;
    const size = z.length / least.length;
    const most = least.reduce((found, value) => Math.max(found, Math.abs(value)), 0);
    return Math.max(...Array.from(least, (value, n) => Math.abs(this.look(z.subarray(n * size, (n + 1) * size)) - value))) / most;
  }
}
