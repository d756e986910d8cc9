// Curves of what happens now: the last seconds of a loop.

import { Plot } from "page/plot";

const WINDOW = 20; // [s]
const DEGREES = 180 / Math.PI;

export class Live {
  constructor(holder, loop) {
    this.loop = loop;
    this.time = [];
    this.columns = new Map();
    const { seen, torque, mesh } = loop.data;
    const read = (n, factor = 1) => () => factor * loop.measured[n];
    const angle = () => loop.reference(loop.time)[0];
    const panels = [
      ["Film", "w [mm]", mesh.probes.names.map((name, k) => [`w at ${name}`, read(seen.w[k], 1e3)])],
      ["Attitude", "angle [°]", [
        ["hub", read(seen.attitude, DEGREES)], ["to follow", () => DEGREES * angle(), 1],
      ]],
      ["Attitude error", "error [mrad]", [["error", () => 1e3 * (loop.measured[seen.attitude] - angle())]]],
      ["Torque of the wheel", "T [N m]", [["torque", () => loop.value[torque]]]],
    ];
    if (seen.rms !== undefined) panels[0][2].push(["rms off the plane", read(seen.rms, 1e3)]);
    if (loop.data.film) panels.splice(1, 0, ["Least tension of the film", "tension [N/m]", [["least", () => this.look()], ["zero", () => 0, 1]]]);
    this.plots = panels.filter(([, , lines]) => lines.length).map(([title, labelY, lines]) => {
      const drawn = lines.map(([name, value, dash], colour) => {
        const y = [];
        this.columns.set(y, value);
        return { name, x: this.time, y, colour, dash: dash || 0, key: true };
      });
      return new Plot(holder, { title, labelX: "t [s]", labelY, lines: drawn });
    });
    this.forget();
    this.note();
  }

  forget() {
    this.lowest = [Infinity, 0]; // smallest tension [N/m], and when
    this.pushed = []; // first and last instant of compression
  }

  // Looks at the film, and remembers since when and for how long it has been in compression.
  look() {
    const { film } = this.loop.data;
    const least = film.look(this.loop.z);
    if (least < this.lowest[0]) this.lowest = [least, this.loop.time];
    if (least < 0) this.pushed = [...this.pushed.slice(0, 1), this.loop.time];
    return least;
  }

  clear() {
    this.forget();
    this.time.length = 0;
    for (const y of this.columns.keys()) y.length = 0;
    this.note();
  }

  // Takes in what is measured now.
  note() {
    this.time.push(this.loop.time);
    for (const [y, value] of this.columns) y.push(value());
    if (this.time[0] >= this.loop.time - WINDOW) return;
    this.time.shift();
    for (const y of this.columns.keys()) y.shift();
  }

  // Draws all curves, or one panel after the other.
  draw(all) {
    const { time } = this.loop;
    this.next = ((this.next || 0) + 1) % this.plots.length;
    for (const plot of all ? this.plots : [this.plots[this.next]]) {
      plot.limits();
      plot.x = [Math.max(0, time - WINDOW), Math.max(time, 0.25 * WINDOW)];
      plot.shown = this.time[this.time.length - 1];
      plot.draw();
    }
  }
}
