// A reduced model on a hub that turns about one axis, by central differences: the steps of `control/compiled/axis_steps.py`
// for one run, in the same order of operations.

import { add, addSlopes, addThrough, backOf, fill, inverse, sum, times } from "page/products";

const MARGIN = 1 + 1e-9;

export class Plant {
  // model: constants as of `AxisModel`, matrices by columns; step [s]; damping: factor of the model's own.
  constructor(model, step) {
    this.model = model;
    this.step = step;
    const r = model.reach.length;
    const m = model.first.length;
    this.size = r;
    const onQ = () => new Float64Array(r);
    for (const name of ["q", "v", "a", "forces", "coupling", "load", "arms"]) this[name] = onQ();
    this.stress = new Float64Array(m);
    // A product of fields in one part is square.
    this.fieldsBack = backOf(model.fields, m);
    // Space of a step.
    this.space = { half: onQ(), q: onQ(), v: onQ(), known: onQ(), free: onQ(), pulls: onQ(), solved: onQ(), pulled: onQ(),
      parts: onQ(), coupling: onQ(), spun: onQ(), span: onQ(), frame: onQ(), onQ: onQ(), y: new Float64Array(m),
      rates: new Float64Array(m), stress: new Float64Array(m), onY: new Float64Array(m),
      slope: new Float64Array(model.turned.length), between: new Float64Array(m) };
    this.damp(1);
    this.restart(new Float64Array(model.load.length / r - 1));
  }

  // Sets the damping to so many times the model's own.
  damp(factor) {
    const { model, step } = this;
    const root = model.viscous.length === model.first.length ** 2 ? factor : Math.sqrt(factor);
    this.damping = model.damping.map((entry) => factor * entry);
    this.viscous = model.viscous.map((entry) => root * entry);
    this.viscousBack = backOf(this.viscous, model.first.length);
    this.inverse = inverse(model.mass.map((entry, k) => entry + 0.5 * step * this.damping[k]));
    this.factor = factor;
  }

  // Begins at rest under what acts.
  restart(value) {
    for (const part of [this.q, this.v, this.a]) part.fill(0);
    this.angle = this.rate = this.acceleration = this.momentum = this.torque = 0;
    this.failed = false;
    this.give(value);
    this.balance();
  }

  // What acts: what does so without commands, and so many units of each number.
  give(value) {
    const { load, stress, torque, arms } = this.model;
    const whole = [1, ...value];
    fill(load, whole, this.load);
    fill(stress, whole, this.stress);
    this.push = 0;
    for (let k = 0; k < whole.length; k++) this.push += torque[k] * whole[k];
    fill(arms, whole, this.arms);
  }

  // Fills forces and the hub's inertia at coordinates and rates in the space; returns inertia and torque.
  place() {
    const { model: c, space: s, size: r } = this;
    const { q, v, y, rates, stress, parts, coupling, pulls, slope } = s;
    for (let k = 0; k < y.length; k++) {
      const i = c.first[k];
      const j = c.second[k];
      y[k] = q[i] * q[j];
      rates[k] = q[i] * v[j] + v[i] * q[j];
    }
    stress.set(this.stress);
    addThrough(c.fields, this.fieldsBack, y, s.between, stress);
    addThrough(this.viscous, this.viscousBack, rates, s.between, stress);
    times(c.linear, q, parts);
    if (c.quadratic.length) add(c.quadratic, y, parts);
    addSlopes(c.first, c.second, stress, q, parts);
    coupling.set(c.reach);
    pulls.set(c.pull);
    if (c.spin.length) add(c.spin, q, coupling);
    if (c.turned.length) {
      slope.set(c.turned);
      add(c.turning, q, slope);
      for (let i = 0; i < r; i++) {
        for (let j = 0; j < r; j++) coupling[i] += 0.5 * (c.turned[r * i + j] + slope[r * i + j]) * q[j];
      }
    }
    if (c.pull_slope.length) add(c.pull_slope, q, pulls);
    let inertia = c.inertia[0];
    let push = 0;
    if (c.square_follow.length) {
      times(c.square_follow, y, s.onQ);
      times(c.square_through, q, s.onY);
      addSlopes(c.first, c.second, s.onY, q, pulls);
      for (let i = 0; i < r; i++) {
        pulls[i] += s.onQ[i];
        inertia += s.onQ[i] * q[i];
      }
    }
    for (let i = 0; i < r; i++) {
      inertia -= (pulls[i] + c.pull[i]) * q[i];
      push += this.arms[i] * q[i];
    }
    return [inertia, push + this.push];
  }

  // Fills w (D - D') v, the Coriolis forces of the monomials.
  coriolis(v, rate) {
    const { size: r } = this;
    const { slope, frame } = this.space;
    frame.fill(0);
    if (!slope.length) return;
    for (let i = 0; i < r; i++) {
      for (let j = 0; j < r; j++) frame[i] += (slope[r * i + j] - slope[r * j + i]) * v[j];
      frame[i] = rate * frame[i];
    }
  }

  // v' D v, what the monomials' curvature adds to the rate of a momentum.
  bend(v) {
    const { size: r } = this;
    const { slope } = this.space;
    let found = 0;
    if (slope.length) for (let i = 0; i < r; i++) for (let j = 0; j < r; j++) found += slope[r * i + j] * v[j] * v[i];
    return found;
  }

  // One step; a plant that is not stable at it fails, and stays.
  advance() {
    if (this.failed) return;
    const { model: c, space: s, size: r, step, inverse: solve } = this;
    const { half, q, v, known, free, pulls, solved, pulled, parts, coupling, spun, span, frame } = s;
    for (let i = 0; i < r; i++) {
      half[i] = this.v[i] + 0.5 * step * this.a[i];
      q[i] = this.q[i] + step * half[i];
      v[i] = half[i] + 0.5 * step * this.a[i];
    }
    const [inertia, push] = this.place();
    // Stiffness that this very step has felt, against what central differences can follow.
    times(c.mass, half, s.onQ);
    const along = sum(coupling, half);
    let felt = 0;
    let moving = 0;
    for (let i = 0; i < r; i++) {
      felt += half[i] * (parts[i] - this.forces[i]);
      moving += half[i] * s.onQ[i];
    }
    moving -= (along * along) / inertia;
    let rate = this.rate + step * this.acceleration;
    const momentum = this.momentum + 0.5 * step * (this.torque + push);
    this.coriolis(v, rate);
    times(this.damping, half, known);
    for (let i = 0; i < r; i++) known[i] += parts[i] + this.load[i] + frame[i];
    times(solve, known, frame);
    times(solve, pulls, pulled);
    times(solve, coupling, solved);
    const share = sum(coupling, solved);
    span.fill(0);
    let acceleration = 0;
    for (let pass = 0; pass < 2; pass++) {
      if (c.spin.length) {
        times(c.spin, v, spun);
        times(solve, spun, span);
      }
      rate = (momentum - sum(coupling, v)) / inertia;
      let left = push + 2 * sum(pulls, v) * rate - this.bend(v);
      for (let i = 0; i < r; i++) {
        free[i] = -(frame[i] + rate * (rate * pulled[i] + 2 * span[i]));
        left -= coupling[i] * free[i];
      }
      acceleration = left / (inertia - share);
      for (let i = 0; i < r; i++) {
        free[i] -= acceleration * solved[i];
        v[i] = half[i] + 0.5 * step * free[i];
      }
    }
    if (!(step * felt <= 4 * moving * MARGIN + 1e-300)) {
      this.failed = true;
      return;
    }
    rate = (momentum - sum(coupling, v)) / inertia;
    this.angle += 0.5 * step * (this.rate + rate);
    Object.assign(this, { rate, acceleration, momentum, torque: push, inertia });
    for (const [own, found] of [[this.q, q], [this.v, v], [this.a, free], [this.forces, parts], [this.coupling, coupling]]) {
      own.set(found);
    }
  }

  // Momentum and accelerations of coordinates, rates and hub.
  balance() {
    const { model: c, space: s, size: r, rate } = this;
    const { v, known, free, pulls, solved, parts, coupling, span, frame } = s;
    s.q.set(this.q);
    v.set(this.v);
    span.fill(0);
    const [inertia, push] = this.place();
    this.coriolis(v, rate);
    if (c.spin.length) add(c.spin, v, span);
    times(this.damping, v, known);
    for (let i = 0; i < r; i++) known[i] += parts[i] + this.load[i] + frame[i] + rate * (rate * pulls[i] + 2 * span[i]);
    times(c.still, known, free);
    times(c.still, coupling, solved);
    const found = push + 2 * sum(pulls, v) * rate - this.bend(v) + sum(coupling, free);
    this.acceleration = found / (inertia - sum(coupling, solved));
    this.torque = push;
    this.momentum = inertia * rate + sum(coupling, v);
    this.inertia = inertia;
    for (let i = 0; i < r; i++) this.a[i] = -free[i] - this.acceleration * solved[i];
    this.forces.set(parts);
    this.coupling.set(coupling);
  }

  // Lets what acts jump; accelerations take up the change.
  jump(value) {
    const { model: c, space: s, size: r, q, coupling } = this;
    const { known: change, free, solved, onQ: arms, stress, parts: inside } = s;
    for (let i = 0; i < r; i++) {
      change[i] = -this.load[i];
      arms[i] = -this.arms[i];
      inside[i] = 0;
    }
    for (let k = 0; k < stress.length; k++) stress[k] = -this.stress[k];
    let push = -this.push;
    this.give(value);
    for (let k = 0; k < stress.length; k++) stress[k] += this.stress[k];
    addSlopes(c.first, c.second, stress, q, inside);
    push += this.push;
    for (let i = 0; i < r; i++) {
      change[i] += this.load[i] + inside[i];
      push += (arms[i] + this.arms[i]) * q[i];
    }
    times(c.still, change, free);
    times(c.still, coupling, solved);
    this.torque += push;
    const more = (push + sum(coupling, free)) / (this.inertia - sum(coupling, solved));
    this.acceleration += more;
    for (let i = 0; i < r; i++) {
      this.a[i] = this.a[i] - free[i] - more * solved[i];
      this.forces[i] += inside[i];
    }
  }
}
