// Ways from rest to rest as `motion/profiles.py` has them, and input shapers as `motion/shaping.py`.

const TURN = 2 * Math.PI;

// Value, slope and curvature over the unit interval; where a curvature jumps, it is that behind the jump.
const SHAPES = {
  versine: (s) => [s - Math.sin(TURN * s) / TURN, 1 - Math.cos(TURN * s), TURN * Math.sin(TURN * s)],
  "minimum-jerk": (s) => [
    s ** 3 * (10 + s * (6 * s - 15)), 30 * s ** 2 * (1 - s) ** 2, 60 * s * (1 - s) * (1 - 2 * s),
  ],
  "bang-bang": (s, later) => (later < 0.5 ? [2 * s ** 2, 4 * s, 4] : [1 - 2 * (1 - s) ** 2, 4 * (1 - s), -4]),
};
export const PROFILES = Object.keys(SHAPES);
const ORDERS = { none: 0, ZV: 1, ZVD: 2 };
export const SHAPERS = Object.keys(ORDERS);

// Amplitudes and delays of a zero-vibration shaper [Singer & Seering 1990].
export function impulses(shaper, frequency, ratio) {
  const order = ORDERS[shaper];
  const root = Math.sqrt(1 - ratio ** 2);
  const decay = Math.exp((-Math.PI * ratio) / root);
  const halfPeriod = 0.5 / (frequency * root);
  const weights = Array.from({ length: order + 1 }, (_, k) => (k === 1 ? order : 1) * decay ** k);
  const total = weights.reduce((a, b) => a + b, 0);
  return weights.map((weight, k) => [weight / total, k * halfPeriod]);
}

export class Way {
  // Turns by an angle [rad] from a start on; every copy that a shaper makes lasts `duration` [s].
  constructor({ angle, duration, profile, shaper, frequency, ratio }, start) {
    Object.assign(this, { start, angle, duration, shape: SHAPES[profile], copies: impulses(shaper, frequency, ratio) });
  }

  get end() {
    return this.start + this.duration + this.copies[this.copies.length - 1][1];
  }

  // Angle, rate and acceleration at a time; `later` is an instant behind it, which decides on which side of a jump it is.
  at(later, time) {
    const { start, angle, duration, shape } = this;
    const found = [0, 0, 0];
    for (const [amplitude, delay] of this.copies) {
      const behind = later - start - delay;
      if (behind < 0) continue;
      if (behind >= duration) {
        found[0] += amplitude;
        continue;
      }
      const [value, slope, curvature] = shape((time - start - delay) / duration, behind / duration);
      found[0] += amplitude * value;
      found[1] += (amplitude * slope) / duration;
      found[2] += (amplitude * curvature) / duration / duration;
    }
    return found.map((part) => angle * part);
  }
}
