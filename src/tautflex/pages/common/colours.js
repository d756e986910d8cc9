// Colours of values: two-sided for displacements, rising for tensions, one by one for the film's states.

const TWO_SIDED = ["#2166ac", "#4393c3", "#92c5de", "#d1e5f0", "#f7f7f7", "#fddbc7", "#f4a582", "#d6604d", "#b2182b"];
const RISING = ["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725"];
export const STATES = [["taut", "#b8d4ea"], ["wrinkled", "#f0a23c"], ["slack", "#c2314c"]];

// Of a film that pushes, told apart from both sides.
export const PUSHED = "#ffd400";

const STEPS = 256;

function parts(hex) {
  return [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
}

function table(stops) {
  const found = new Uint8Array(3 * STEPS);
  const colours = stops.map(parts);
  for (let i = 0; i < STEPS; i++) {
    const place = (i / (STEPS - 1)) * (stops.length - 1);
    const low = Math.min(Math.floor(place), stops.length - 2);
    for (let c = 0; c < 3; c++) {
      found[3 * i + c] = colours[low][c] + (place - low) * (colours[low + 1][c] - colours[low][c]);
    }
  }
  return found;
}

export const twoSided = { table: Uint8Array.from([...table(TWO_SIDED), ...parts(PUSHED)]), beyond: STEPS, gradient: `linear-gradient(to right, ${TWO_SIDED.join(",")})` };
export const rising = { table: table(RISING), gradient: `linear-gradient(to right, ${RISING.join(",")})` };
export const states = Uint8Array.from(STATES.flatMap(([, hex]) => parts(hex)));

// Number of a value's colour in a table between limits.
export function colourOf(value, low, high) {
  const place = ((value - low) / (high - low || 1)) * (STEPS - 1);
  return place <= 0 ? 0 : place >= STEPS - 1 ? STEPS - 1 : Math.round(place);
}

const inks = new Map();

// A colour of the style sheet, looked up once.
export function ink(name) {
  if (!inks.has(name)) inks.set(name, getComputedStyle(document.documentElement).getPropertyValue(name).trim());
  return inks.get(name);
}

// The page has turned light or dark.
export function mixAnew() {
  inks.clear();
}
