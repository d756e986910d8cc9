// Arrays of the page: base64 of typed arrays, little-endian, some with a scale of their last axis's entries.

const KINDS = {
  float64: Float64Array, float32: Float32Array, int16: Int16Array, uint8: Uint8Array, uint16: Uint16Array, uint32: Uint32Array,
};
const NOTHING = -32768;

export function decoded(given) {
  const text = atob(given.base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  const values = new KINDS[given.array](bytes.buffer);
  return { values, shape: given.shape, scale: given.scale };
}

// Numbers of a scaled array whose last axis has one entry.
export function numbers(given) {
  const { values, scale } = decoded(given);
  return Float32Array.from(values, (value) => (value === NOTHING ? NaN : value * scale[0]));
}

// What the page carries, as it was written.
export function carried() {
  const element = document.getElementById("data");
  const data = JSON.parse(element.textContent);
  element.textContent = "";
  return data;
}

export function unpackMesh(mesh) {
  for (const key of ["nodes", "triangles", "edges", "cables", "beams", "links", "held"]) mesh[key] = decoded(mesh[key]).values;
}

// Place of a value in a rising array: the entry before it and the part of the way to the next one.
export function placed(rising, value) {
  let low = 0;
  let high = rising.length - 1;
  if (high <= 0 || value <= rising[0]) return [0, 0];
  if (value >= rising[high]) return [high - 1, 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (rising[middle] <= value) low = middle;
    else high = middle;
  }
  return [low, (value - rising[low]) / (rising[high] - rising[low])];
}
