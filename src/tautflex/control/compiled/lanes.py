"""Products and sums of arrays whose last axis is the run; compiled. Each adds up in the same order for any number."""

from __future__ import annotations

from tautflex.numeric import Array, Indices, jit


@jit
def times(columns: Array, x: Array, result: Array) -> None:
    """Fill ``result`` with a matrix times x, shapes (from, to), (from, n) and (to, n)."""
    result[:] = 0.0
    add(columns, x, result)


@jit
def add(columns: Array, x: Array, result: Array) -> None:
    """Add a matrix times x; four columns at a time, one behind the other, save memory traffic."""
    count, rows, lanes = columns.shape[0], columns.shape[1], x.shape[1]
    fours = count // 4 * 4
    if lanes == 1:
        out = result.reshape(result.size)
        for m in range(0, fours, 4):
            p, q, r, s = x[m, 0], x[m + 1, 0], x[m + 2, 0], x[m + 3, 0]
            for k in range(rows):
                total = out[k] + columns[m, k] * p
                total = total + columns[m + 1, k] * q
                total = total + columns[m + 2, k] * r
                out[k] = total + columns[m + 3, k] * s
        for m in range(fours, count):
            p = x[m, 0]
            for k in range(rows):
                out[k] = out[k] + columns[m, k] * p
        return
    for m in range(0, fours, 4):
        for k in range(rows):
            p, q, r, s = columns[m, k], columns[m + 1, k], columns[m + 2, k], columns[m + 3, k]
            for n in range(lanes):
                total = result[k, n] + p * x[m, n]
                total = total + q * x[m + 1, n]
                total = total + r * x[m + 2, n]
                result[k, n] = total + s * x[m + 3, n]
    for m in range(fours, count):
        for k in range(rows):
            p = columns[m, k]
            for n in range(lanes):
                result[k, n] = result[k, n] + p * x[m, n]


@jit
def add_through(columns: Array, back: Array, x: Array, between: Array, result: Array) -> None:
    """Add a product in one or two parts, see `AxisModel`."""
    if back.shape[0]:
        between = between[: back.shape[0]]
        times(columns, x, between)
        add(back, between, result)
    else:
        add(columns, x, result)


@jit
def sum_of(x: Array, y: Array, result: Array) -> None:
    """Fill sums of products, shape (n,)."""
    result[:] = 0.0
    for i in range(x.shape[0]):
        for n in range(x.shape[1]):
            result[n] = result[n] + x[i, n] * y[i, n]


@jit
def add_slopes(first: Indices, second: Indices, stress: Array, q: Array, force: Array) -> None:
    """Add ``Y' stress``."""
    for k in range(first.size):
        i, j = first[k], second[k]
        for n in range(q.shape[1]):
            force[i, n] = force[i, n] + stress[k, n] * q[j, n]
        for n in range(q.shape[1]):
            force[j, n] = force[j, n] + stress[k, n] * q[i, n]


@jit
def monomials(first: Indices, second: Indices, q: Array, v: Array, y: Array, rates: Array) -> None:
    """Fill monomials and their rates."""
    for k in range(first.size):
        i, j = first[k], second[k]
        for n in range(q.shape[1]):
            y[k, n] = q[i, n] * q[j, n]
            rates[k, n] = q[i, n] * v[j, n] + v[i, n] * q[j, n]
