// Products and sums as `control/compiled/lanes.py` has them: matrices by columns, (from, to), added up column by column.

export function add(columns, x, result) {
  const rows = result.length;
  const fours = x.length - (x.length % 4);
  for (let m = 0, at = 0; m < fours; m += 4, at += 4 * rows) {
    const [p, q, r, s] = [x[m], x[m + 1], x[m + 2], x[m + 3]];
    for (let k = 0, one = at; k < rows; k++, one++) {
      result[k] = result[k] + columns[one] * p + columns[one + rows] * q + columns[one + 2 * rows] * r + columns[one + 3 * rows] * s;
    }
  }
  for (let m = fours; m < x.length; m++) {
    for (let k = 0; k < rows; k++) result[k] += columns[m * rows + k] * x[m];
  }
}

export function times(columns, x, result) {
  result.fill(0);
  add(columns, x, result);
}

// The same, past what is zero: few numbers of a command act at a time.
export function fill(columns, x, result) {
  result.fill(0);
  const rows = result.length;
  for (let m = 0; m < x.length; m++) {
    if (x[m] !== 0) for (let k = 0; k < rows; k++) result[k] += columns[m * rows + k] * x[m];
  }
}

// A product in one or two parts.
export function addThrough(columns, back, x, between, result) {
  if (!back.length) {
    if (columns.length) add(columns, x, result);
    return;
  }
  const middle = between.subarray(0, columns.length / x.length);
  times(columns, x, middle);
  add(back, middle, result);
}

// Transpose of a product's first part; of one that is whole already, nothing.
export function backOf(columns, count) {
  const width = columns.length / count;
  if (width === count) return new Float64Array(0);
  return Float64Array.from(columns, (_, at) => columns[(at % count) * width + Math.floor(at / count)]);
}

export function sum(x, y) {
  let found = 0;
  for (let i = 0; i < x.length; i++) found += x[i] * y[i];
  return found;
}

// Adds Y' stress.
export function addSlopes(first, second, stress, q, force) {
  for (let k = 0; k < stress.length; k++) {
    force[first[k]] += stress[k] * q[second[k]];
    force[second[k]] += stress[k] * q[first[k]];
  }
}

// Inverse of a matrix, by elimination with the largest pivot of a column.
export function inverse(matrix) {
  const n = Math.round(Math.sqrt(matrix.length));
  const rows = Array.from({ length: n }, (_, i) => {
    const row = new Float64Array(2 * n);
    row.set(matrix.subarray(n * i, n * i + n));
    row[n + i] = 1;
    return row;
  });
  for (let k = 0; k < n; k++) {
    let best = k;
    for (let i = k + 1; i < n; i++) if (Math.abs(rows[i][k]) > Math.abs(rows[best][k])) best = i;
    [rows[k], rows[best]] = [rows[best], rows[k]];
    const pivot = rows[k][k];
    for (let j = k; j < 2 * n; j++) rows[k][j] /= pivot;
    for (let i = 0; i < n; i++) {
      const factor = rows[i][k];
      if (i === k || factor === 0) continue;
      for (let j = k; j < 2 * n; j++) rows[i][j] -= factor * rows[k][j];
    }
  }
  const found = new Float64Array(n * n);
  rows.forEach((row, i) => found.set(row.subarray(n), n * i));
  return found;
}
