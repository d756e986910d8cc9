// A loop around a plant: drives, attitude control, what the hub is to follow, and what sensors read; an interval at a time
// as `control/compiled` has it.

import { Plant } from "page/plant";
import { Way } from "page/ways";

const STABLE = 1e-9; // an instant this close before a jump is behind it [s]

function clipped(value, low, high) {
  return Math.min(Math.max(value, low), high);
}

// To the nearest whole number, halves to the even one.
function whole(value) {
  const near = Math.round(value);
  return Math.abs(value - Math.trunc(value)) === 0.5 && near % 2 !== 0 ? near - 1 : near;
}

export class Loop {
  constructor(data) {
    this.data = data;
    this.plant = new Plant(data.model, data.step);
    this.count = data.drives.limit.length;
    // What sliders say: gains of the law, damping as a factor, numbers of the command that are held.
    this.gains = { ...data.gains };
    this.held = new Float64Array(this.count);
    this.measured = new Float64Array(data.readings.length);
    this.restart();
  }

  restart() {
    const numbers = () => new Float64Array(this.count);
    [this.target, this.output, this.value, this.stored, this.asked] = [numbers(), numbers(), numbers(), numbers(), numbers()];
    this.waiting = Array.from(this.data.drives.delay, (late) => new Float64Array(late));
    this.ways = [];
    this.knocks = [];
    this.hand = null;
    this.intervals = 0;
    this.steps = 0;
    this.plant.restart(this.value);
    this.read();
  }

  damp(factor) {
    this.plant.damp(factor);
    this.plant.balance();
  }

  get time() {
    return this.intervals * this.data.interval + this.steps * this.data.step;
  }

  // Turns from the next interval on.
  slew(turn) {
    this.ways.push(new Way(turn, (this.intervals + (this.steps ? 1 : 0)) * this.data.interval));
  }

  // Pushes a place of the film for a while: number of the force, force [N], seconds.
  knock(number, force, seconds) {
    this.knocks.push({ number, force, start: this.time, end: this.time + seconds });
  }

  // Angle, rate and acceleration that the hub is to follow.
  reference(time) {
    const found = [0, 0, 0];
    for (const way of this.ways) way.at(time + STABLE, time).forEach((part, k) => { found[k] += part; });
    return found;
  }

  // Begins an interval: what the law asks for, what drives make of it, and that acts.
  begin() {
    const { drives, torque, seen } = this.data;
    const time = this.intervals * this.data.interval;
    const [angle, rate, acceleration] = this.reference(time);
    const { stiffness, damping, inertia } = this.gains;
    const command = this.asked;
    command.set(this.held);
    for (const each of this.knocks) if (time >= each.start - STABLE && time < each.end - STABLE) command[each.number] += each.force;
    if (this.hand) command[this.hand.number] += this.hand.force;
    command[torque] = -stiffness * this.measured[seen.attitude] - damping * this.measured[seen.rate]
      + stiffness * angle + damping * rate + inertia * acceleration;
    let changed = false;
    for (let k = 0; k < this.count; k++) {
      let found = this.driven(k, command[k], drives);
      if (!drives.wheel[k]) found = Math.max(found, drives.lowest[k]);
      else if (drives.momentum[k] < Infinity) {
        const low = (this.stored[k] - drives.momentum[k]) / this.data.interval;
        const high = (this.stored[k] + drives.momentum[k]) / this.data.interval;
        found = clipped(found, Math.min(low, 0), Math.max(high, 0));
      }
      if (found - this.value[k] !== 0) changed = true;
      this.value[k] = found;
    }
    if (changed) this.plant.jump(this.value);
  }

  // What a drive makes of a command, see `Drive.act`.
  driven(k, command, { limit, rate, lag, resolution, decay }) {
    const { interval } = this.data;
    let asked = command;
    const queue = this.waiting[k];
    if (queue.length) {
      const turn = this.intervals % queue.length;
      [asked, queue[turn]] = [queue[turn], asked];
    }
    if (resolution[k] > 0) asked = resolution[k] * whole(asked / resolution[k]);
    asked = clipped(asked, -limit[k], limit[k]);
    const reach = rate[k] * interval;
    const target = this.target[k] + clipped(asked - this.target[k], -reach, reach);
    const left = this.output[k] - target;
    this.target[k] = this.output[k] = target;
    if (!(lag[k] > 0)) return target;
    this.output[k] = target + decay[k] * left;
    return target + ((left * lag[k]) / interval) * (1 - decay[k]);
  }

  // One step of the plant.
  advance() {
    if (this.steps === 0) this.begin();
    this.plant.advance();
    this.steps += 1;
    if (this.steps < this.data.steps) return;
    const { wheel } = this.data.drives;
    for (let k = 0; k < this.count; k++) if (wheel[k]) this.stored[k] -= this.value[k] * this.data.interval;
    this.steps = 0;
    this.intervals += 1;
    this.knocks = this.knocks.filter((each) => each.end > this.time);
    if (!this.plant.failed) this.read();
  }

  // Fills what sensors read, without noise, see `loop.exact`, and z, which they read it from.
  read() {
    const { look, speed, level, rotation, rate, rms, form } = this.data.sensing;
    const { plant, value } = this;
    const { first, second } = plant.model;
    const z = [...plant.q];
    const moving = [...plant.v];
    for (let k = 0; k < first.length; k++) {
      const [i, j] = [first[k], second[k]];
      z.push(plant.q[i] * plant.q[j]);
      moving.push(plant.q[i] * plant.v[j] + plant.v[i] * plant.q[j]);
    }
    z.push(...value, ...frame(plant, this.data.axis));
    this.z = z;
    const product = (matrix, row, x, width) => {
      let total = 0;
      for (let i = 0; i < x.length; i++) total += matrix[row * width + i] * x[i];
      return total;
    };
    for (let n = 0; n < level.length; n++) {
      this.measured[n] = level[n] + product(look, n, z, z.length) + product(speed, n, moving, moving.length)
        + rotation[n] * plant.angle + rate[n] * plant.rate;
    }
    const size = Math.round(Math.sqrt(form.length));
    let square = 0;
    for (let i = 0; i < size; i++) square += z[i] * product(form, i, z.slice(0, size), size);
    for (const n of rms) this.measured[n] += Math.sqrt(Math.max(square, 0));
  }
}

// S(dw) + S(w)^2 and the acceleration of the origin, which is at rest.
function frame(plant, axis) {
  const found = new Float64Array(12);
  const [j, k] = [(axis + 1) % 3, (axis + 2) % 3];
  for (const other of [j, k]) found[4 * other] = -plant.rate * plant.rate;
  found[3 * j + k] -= plant.acceleration;
  found[3 * k + j] += plant.acceleration;
  return found;
}
