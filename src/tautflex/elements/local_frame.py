r"""Local frame of a line whose ends turn by any angle: gradients as seen from it, and how forces come back.

With the total rotation vectors ``theta_1, theta_2`` of both ends, their unit quaternions ``q_1, q_2`` and the chord
``d = (1 + a, s_v, s_w)`` over the length, in the reference axes of the line, the local frame is the mean rotation
``R_m`` of ``q_m = (q_1 + q_2)/|q_1 + q_2|``, half way between both ends. From it one sees

    Gamma = R_m' d    and    kappa = log(R_1' R_2),

the strains of the geometrically exact beam at its middle [Simo, Comput. Methods Appl. Mech. Eng. 49 (1985) 55],
whichever way the line turns as a whole. The local gradients ``(|d| - 1, Gamma_2, Gamma_3, -kappa/2, kappa/2)`` stand in
the places of ``(a, s_v, s_w, theta_1, theta_2)``.

Unit quaternions are smooth in the total rotation vector, so are all of these as long as the ends turn by less than a
revolution relative to each other. A rotation vector of 2 pi itself is like one of zero, but that nothing turns it
sideways any more: across the axis of such a rotation nodes lose their stiffness, there and there only.
"""

from __future__ import annotations

from math import factorial

import numpy as np

from tautflex.numeric import Array, jit

GRADIENTS = 9
# sin(sqrt(t)/2)/sqrt(t) in powers of t, and 2 alpha/sin(alpha) in powers of 1 - cos(alpha), where closed forms cancel.
_SINE = np.array([0.5 * (-0.25) ** k / factorial(2 * k + 1) for k in range(7)])
_ANGLE = 2.0 * np.cumprod([1.0, *(k / (2.0 * k + 1.0) for k in range(1, 15))])
_SMALL_SQUARE, _SMALL_BEND = 0.25, 0.1


@jit
def _derivatives(coefficients: Array, x: float) -> tuple[float, float, float]:
    """Value and two derivatives of a polynomial."""
    value, slope, curve = 0.0, 0.0, 0.0
    for k in range(coefficients.size - 1, -1, -1):
        curve = curve * x + 2.0 * slope
        slope = slope * x + value
        value = value * x + coefficients[k]
    return value, slope, curve


@jit
def _sine(square: float) -> tuple[float, float, float, float]:
    """Cosine of half an angle, and ``sin(angle/2)/angle`` with two derivatives by the square of the angle."""
    angle = np.sqrt(square)
    cosine = np.cos(0.5 * angle)
    if square < _SMALL_SQUARE:
        s, s1, s2 = _derivatives(_SINE, square)
    else:
        s = np.sin(0.5 * angle) / angle
        s1 = (0.5 * cosine - s) / (2.0 * square)
        s2 = -(0.0625 * s + 1.5 * s1) / square
    return cosine, s, s1, s2


@jit
def _end(g: Array, e: int, row: int) -> tuple[float, float, float, float]:
    """Unit quaternion of the rotation vector of a line's end, whose rows begin here."""
    x, y, z = g[row, e], g[row + 1, e], g[row + 2, e]
    cosine, s, _, _ = _sine(x * x + y * y + z * z)
    return cosine, s * x, s * y, s * z


@jit
def _quaternion(x: float, y: float, z: float, q: Array, first: Array) -> None:
    """Unit quaternion of a rotation vector, shape (4,), and its derivatives, shape (4, 3)."""
    cosine, s, s1, _ = _sine(x * x + y * y + z * z)
    theta = (x, y, z)
    q[0] = cosine
    for i in range(3):
        q[1 + i] = s * theta[i]
        first[0, i] = -0.5 * q[1 + i]
        for j in range(3):
            first[1 + i, j] = 2.0 * s1 * theta[i] * theta[j]
        first[1 + i, i] += s


@jit
def _second(x: float, y: float, z: float, first: Array, second: Array) -> None:
    """Second derivatives of `_quaternion`, shape (4, 3, 3), from the first ones."""
    _, _, s1, s2 = _sine(x * x + y * y + z * z)
    theta = (x, y, z)
    for i in range(3):
        for j in range(3):
            same = 1.0 if i == j else 0.0
            second[0, i, j] = -0.5 * first[1 + i, j]
            for k in range(3):
                mixed = 4.0 * s2 * theta[i] * theta[j] * theta[k]
                mixed += 2.0 * s1 * same * theta[k]
                if i == k:
                    mixed += 2.0 * s1 * theta[j]
                if j == k:
                    mixed += 2.0 * s1 * theta[i]
                second[1 + i, j, k] = mixed


@jit
def _bend(p: float) -> tuple[float, float, float]:
    """``2 alpha/sin(alpha)`` of ``p = cos(alpha)`` and its derivatives by p."""
    if 1.0 - p < _SMALL_BEND:
        value, slope, curve = _derivatives(_ANGLE, 1.0 - p)
        return value, -slope, curve
    rest = 1.0 - p * p
    value = 2.0 * np.arccos(p) / np.sqrt(rest)
    slope = (p * value - 2.0) / rest
    return value, slope, (value + 3.0 * p * slope) / rest


@jit
def _dot(a: Array, b: Array) -> float:
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@jit
def _half_turn(s: Array, d: Array, n: Array, result: Array) -> float:
    """``Q s`` with ``1/2 s.Q s = d . |s|^2 R(s) n`` for a quaternion s of any length, and that number itself."""
    dn, ds, ns = _dot(d, n), _dot(d, s[1:]), _dot(n, s[1:])
    result[0] = s[0] * dn
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        across = n[j] * d[k] - n[k] * d[j]
        result[0] += s[1 + i] * across
        result[1 + i] = 2.0 * (d[i] * ns + n[i] * ds - s[1 + i] * dn + s[0] * across)
    result[0] *= 2.0
    return 0.5 * _dot(s, result)


@jit
def _difference(m: Array, q: Array, sign: float, result: Array) -> None:
    """Derivatives of ``m . vector part of q_1* q_2``: by q_1 from q_2 (``sign`` 1), by q_2 from q_1 (-1)."""
    result[0] = sign * _dot(m, q[1:])
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        result[1 + i] = sign * (m[j] * q[1 + k] - m[k] * q[1 + j] - m[i] * q[0])


@jit
def make_room() -> tuple[Array, Array, Array, Array]:
    """Buffers of one line: quaternions, their first and their second derivatives, numbers on the way."""
    return np.empty((3, 4)), np.empty((2, 4, 3)), np.empty((2, 4, 3, 3)), np.empty((12, 4))


@jit
def _see(g: Array, e: int, room: tuple[Array, Array, Array, Array]) -> tuple[float, Array]:
    """Quaternions of both ends and their sum; returns the cosine of half the angle between them, and the chord."""
    q, first, _, work = room
    _quaternion(g[3, e], g[4, e], g[5, e], q[0], first[0])
    _quaternion(g[6, e], g[7, e], g[8, e], q[1], first[1])
    for i in range(4):
        q[2, i] = q[0, i] + q[1, i]
    d = work[0, :3]
    d[0], d[1], d[2] = 1.0 + g[0, e], g[1, e], g[2, e]
    return _dot(q[0], q[1]), d


@jit
def to_local(g: Array, width: int, local: Array) -> None:
    """Local gradients of the first ``width`` lines from their gradients, shapes (9, pack); may be the same array."""
    for e in range(width):
        # Both ends and their sum s; R_m' d and the vector part of q_1* q_2 in numbers, which need no arrays.
        (a0, a1, a2, a3), (b0, b1, b2, b3) = _end(g, e, 3), _end(g, e, 6)
        s0, s1, s2, s3 = a0 + b0, a1 + b1, a2 + b2, a3 + b3
        p = a0 * b0 + a1 * b1 + a2 * b2 + a3 * b3
        x, y, z = 1.0 + g[0, e], g[1, e], g[2, e]
        share, half = 1.0 / (2.0 + 2.0 * p), 0.5 * _bend(p)[0]
        # |d| - 1 without the loss of a difference.
        stretch = g[0, e] * (2.0 + g[0, e]) + y * y + z * z
        local[0, e] = stretch / (np.sqrt(1.0 + stretch) + 1.0)
        square, along = s0 * s0 - (s1 * s1 + s2 * s2 + s3 * s3), s1 * x + s2 * y + s3 * z
        local[1, e] = share * (square * y + 2.0 * (s2 * along + s0 * (z * s1 - x * s3)))
        local[2, e] = share * (square * z + 2.0 * (s3 * along + s0 * (x * s2 - y * s1)))
        local[6, e] = half * (a0 * b1 - b0 * a1 - (a2 * b3 - a3 * b2))
        local[7, e] = half * (a0 * b2 - b0 * a2 - (a3 * b1 - a1 * b3))
        local[8, e] = half * (a0 * b3 - b0 * a3 - (a1 * b2 - a2 * b1))
        for i in range(3):
            local[3 + i, e] = -local[6 + i, e]


@jit
def _weighted_slope(w: Array, p: float, d: Array, room: tuple[Array, Array, Array, Array], result: Array) -> None:
    """Gradient of ``w . local gradients`` by the gradients of a line, shape (9,); leaves its parts in the room."""
    q, first, _, work = room
    n, m, qs, b1, b2, turned = work[1, :3], work[2, :3], work[3], work[4], work[5], work[6, :3]
    n[0], n[1], n[2] = 0.0, w[1], w[2]
    for i in range(3):
        m[i] = 0.5 * (w[6 + i] - w[3 + i])
    s = q[2]
    twice, share = _half_turn(s, d, n, qs), 1.0 / (2.0 + 2.0 * p)
    _difference(m, q[1], 1.0, b1)
    _difference(m, q[0], -1.0, b2)
    bend, bend1, bend2 = _bend(p)
    between = _dot(q[0], b1)
    share1, share2 = -2.0 * share * share, 8.0 * share * share * share
    c1, c2 = twice * share1 + between * bend1, twice * share2 + between * bend2
    # |s|^2 R(s) n
    square, along = s[0] * s[0] - _dot(s[1:], s[1:]), _dot(s[1:], n)
    length = np.sqrt(_dot(d, d))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        turned[i] = square * n[i] + 2.0 * (s[1 + i] * along + s[0] * (s[1 + j] * n[k] - s[1 + k] * n[j]))
        result[i] = share * turned[i] + w[0] * d[i] / length
        result[3 + i], result[6 + i] = 0.0, 0.0
    by1, by2 = work[7], work[8]
    for i in range(4):
        by1[i] = share * qs[i] + bend * b1[i] + c1 * q[1, i]
        by2[i] = share * qs[i] + bend * b2[i] + c1 * q[0, i]
        for j in range(3):
            result[3 + j] += by1[i] * first[0, i, j]
            result[6 + j] += by2[i] * first[1, i, j]
        # What the second derivatives need: slopes of F_q by the cosine p.
        work[9, i] = share1 * qs[i] + bend1 * b1[i]
        work[10, i] = share1 * qs[i] + bend1 * b2[i]
    work[11, 0], work[11, 1], work[11, 2], work[11, 3] = share, bend, c1, c2


@jit
def pull_back(g: Array, width: int, room: tuple[Array, Array, Array, Array], conjugate: Array) -> None:
    """Conjugates of local gradients, shape (9, pack), become those of the gradients ``g``, in place."""
    w, slope = np.empty(GRADIENTS), np.empty(GRADIENTS)
    for e in range(width):
        p, d = _see(g, e, room)
        w[:] = conjugate[:, e]
        _weighted_slope(w, p, d, room, slope)
        conjugate[:, e] = slope


@jit
def local_slopes(g: Array, e: int, room: tuple[Array, Array, Array, Array], slopes: Array) -> None:
    """Derivatives of the local gradients of one line by its gradients, shape (9, 9)."""
    p, d = _see(g, e, room)
    w = np.zeros(GRADIENTS)
    for row in range(6):
        w[:] = 0.0
        w[row] = 1.0
        _weighted_slope(w, p, d, room, slopes[row])
        if row >= 3:
            slopes[row + 3] = -slopes[row]


@jit
def _add_curvature(
    g: Array, e: int, room: tuple[Array, Array, Array, Array], w: Array, quaternion: Array, total: Array
) -> None:
    """Add the second derivatives of ``w . local gradients`` of one line to ``total``, shape (9, 9)."""
    q, first, second, work = room
    p, d = _see(g, e, room)
    for one in range(2):
        row = 3 + 3 * one
        _second(g[row, e], g[row + 1, e], g[row + 2, e], first[one], second[one])
    _weighted_slope(w, p, d, room, np.empty(GRADIENTS))
    n, m, turned, by1, by2, c1q, c2q = work[1, :3], work[2, :3], work[6, :3], work[7], work[8], work[9], work[10]
    share, bend, c1, c2 = work[11, 0], work[11, 1], work[11, 2], work[11, 3]
    length, s, dn = np.sqrt(_dot(d, d)), q[2], _dot(d, n)
    unit, column = np.empty(3), np.empty(4)
    for i in range(4):
        for j in range(4):
            if i == 0 and j == 0:
                both, mixed = 2.0 * dn, 0.0
            elif i == 0 or j == 0:
                k = max(i, j) - 1
                x, y = (k + 1) % 3, (k + 2) % 3
                both = 2.0 * (n[x] * d[y] - n[y] * d[x])
                mixed = m[k] if i == 0 else -m[k]
            else:
                k, o = i - 1, j - 1
                both = 2.0 * (d[k] * n[o] + n[k] * d[o])
                mixed = 0.0
                if k == o:
                    both -= 2.0 * dn
                elif o == (k + 1) % 3:
                    mixed = -m[3 - k - o]
                else:
                    mixed = m[3 - k - o]
            both *= share
            quaternion[i, j] = both + c1q[i] * q[1, j] + q[1, i] * c1q[j] + c2 * q[1, i] * q[1, j]
            quaternion[4 + i, 4 + j] = both + c2q[i] * q[0, j] + q[0, i] * c2q[j] + c2 * q[0, i] * q[0, j]
            cross = both + bend * mixed + c1q[i] * q[0, j] + q[1, i] * c2q[j] + c2 * q[1, i] * q[0, j]
            if i == j:
                cross += c1
            quaternion[i, 4 + j] = quaternion[4 + j, i] = cross
    for one in range(2):
        by = by1 if one == 0 else by2
        for other in range(2):
            for a in range(3):
                for i in range(4):
                    part = 0.0
                    for j in range(4):
                        part += quaternion[4 * one + i, 4 * other + j] * first[other, j, a]
                    for c in range(3):
                        total[3 + 3 * one + c, 3 + 3 * other + a] += first[one, i, c] * part
        for i in range(4):
            for a in range(3):
                for c in range(3):
                    total[3 + 3 * one + a, 3 + 3 * one + c] += by[i] * second[one, i, a, c]
    share1 = -2.0 * share * share
    for k in range(3):
        unit[:] = 0.0
        unit[k] = 1.0
        _half_turn(s, unit, n, column)
        for one in range(2):
            for a in range(3):
                part = 0.0
                for i in range(4):
                    part += (share * column[i] + share1 * turned[k] * q[1 - one, i]) * first[one, i, a]
                total[k, 3 + 3 * one + a] += part
                total[3 + 3 * one + a, k] += part
        for o in range(3):
            total[k, o] += w[0] * ((1.0 if k == o else 0.0) - d[k] * d[o] / (length * length)) / length


@jit
def turn_core(g: Array, width: int, room: tuple[Array, Array, Array, Array], conjugate: Array, core: Array) -> None:
    """Tangents by local gradients, shape (9, 9, pack), become those by gradients, ``J' core J + w . d2``, in place.

    ``conjugate`` holds the forces w conjugate to the local gradients, shape (9, pack).
    """
    slopes, half, own = np.empty((GRADIENTS, GRADIENTS)), np.empty((GRADIENTS, GRADIENTS)), np.empty(GRADIENTS)
    quaternion, total = np.empty((8, 8)), np.empty((GRADIENTS, GRADIENTS))
    for e in range(width):
        own[:] = conjugate[:, e]
        local_slopes(g, e, room, slopes)
        for i in range(GRADIENTS):
            for j in range(GRADIENTS):
                half[i, j] = 0.0
                for k in range(GRADIENTS):
                    half[i, j] += core[i, k, e] * slopes[k, j]
        for i in range(GRADIENTS):
            for j in range(GRADIENTS):
                total[i, j] = 0.0
                for k in range(GRADIENTS):
                    total[i, j] += slopes[k, i] * half[k, j]
        _add_curvature(g, e, room, own, quaternion, total)
        core[:, :, e] = total
