r"""Momenta of a hub with an elastic structure, and the forces of its frame [theory.md 9], compiled.

All components are in hub axes, moments about the floating frame's origin O. With rigid velocities (v0, w), elastic
unknowns q and rho = x + u,

    (p, h) = R(q) (v0, w) + B(q) dq,    R = [[m 1, -S(s)], [S(s), J]],    B = [int N; int S(rho) N],

where every block comes from the constant moments of the inertia operator. The rate of (p, h) gives

    R (a0, dw) = (F, T) - B ddq - (w x (w x s) + 2 w x Z dq,  w x J w + 2 (tr(D) 1 - D') w),   D_ab = int rho_a du_b,

and the elastic equation gains B' (a0, dw), which is Q_T and K_T of a prescribed motion written at once.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tautflex.mechanics.inertia import InertiaOperator
from tautflex.mechanics.products import inner
from tautflex.motion.hub import FreeHub
from tautflex.motion.triples import put, triple
from tautflex.numeric import Array, Indices, Places, jit


class Body(NamedTuple):
    """Constant moments of a structure and its hub; compiled code takes them as a plain tuple, which enters faster.

    Parameters
    ----------
    first, line, which
        Of the products ``int rho N_a' N_b``: first line of each pair (a, b), its row, and the product that it is.
    start, column, value
        The different products by rows: the three directions of a node that only moves share theirs.
    begin, place, moment
        For each direction a: unknowns that move along it, and ``int rho N_a' (1, x, y, z)`` of them.
    mass
        Of both [kg].
    center
        ``int rho x`` of both [kg m], shape (3,).
    second
        ``int rho x x'`` of the structure [kg m^2], shape (3, 3).
    tensor
        Inertia of the hub about O [kg m^2], shape (3, 3).
    freedom
        1 for rigid velocities that are free, 0 for held ones, shape (6,).
    """

    first: Indices
    line: Places
    which: Places
    start: Indices
    column: Places
    value: Array
    begin: Indices
    place: Places
    moment: Array
    mass: float
    center: Array
    second: Array
    tensor: Array
    freedom: Array

    @classmethod
    def of(cls, inertia: InertiaOperator, hub: FreeHub | None) -> Body:
        """Moments of a structure with this inertia on a hub; None: on one without mass."""
        weight, center, tensor, freedom = 0.0, np.zeros(3), np.zeros((3, 3)), np.ones(6)
        if hub is not None:
            weight, center = hub.mass, np.asarray(hub.center, dtype=float)
            tensor = hub.tensor + hub.offset_inertia
            freedom = hub.freedom
        moments = np.concatenate([inertia.zeroth_moment[:, None], inertia.first_moment], axis=1)
        places = [np.flatnonzero(np.any(moment != 0.0, axis=0)) for moment in moments]
        first, line, which, start, column, value = inertia.pairs[:6]
        return cls(
            first,
            line,
            which,
            start,
            column,
            value,
            np.cumsum([0, *(place.size for place in places)]),
            np.concatenate(places).astype(np.uint32),
            np.concatenate([moment[:, place].T for moment, place in zip(moments, places, strict=True)]),
            inertia.mass + weight,
            inertia.mass_moment + weight * center,
            inertia.second_moment,
            tensor,
            freedom,
        )


class Momenta(NamedTuple):
    """Momentum of a moving structure beside that of its rigid motion.

    Parameters
    ----------
    products
        ``int rho N_a' u_b`` and ``int rho N_a' du_b``, the different ones of all lines, shape (2, products).
    mass
        R(q), shape (6, 6).
    relative
        ``B dq``, shape (6,).
    flow
        D, shape (3, 3).
    push
        ``B ddq``, shape (6,).
    """

    products: Array
    mass: Array
    relative: Array
    flow: Array
    push: Array


@jit
def _products(body: tuple[Any, ...], q: Array, v: Array) -> Array:
    """The different products of two vectors, shape (2, products)."""
    start, column, value = body[3], body[4], body[5]
    products = np.empty((2, start.size - 1))
    for k in range(start.size - 1):
        y, z = 0.0, 0.0
        for entry in range(np.uint64(start[k]), np.uint64(start[k + 1])):
            y += value[entry] * q[column[entry]]
            z += value[entry] * v[column[entry]]
        products[0, k], products[1, k] = y, z
    return products


@jit
def _sums(body: tuple[Any, ...], products: Array, q: Array, v: Array, a: Array) -> Array:
    """``int rho (1, x + u)_b y_p`` for y of the vectors q, v, a, where of q itself half of u counts, shape (3, 4, 3).

    ``products`` are those of q.
    """
    first, line, which, begin, place, moment = body[0], body[1], body[2], body[6], body[7], body[8]
    sums = np.empty((3, 4, 3))
    for p in range(3):
        for b in range(4):
            e, f, g = 0.0, 0.0, 0.0
            for k in range(begin[p], begin[p + 1]):
                c, row = moment[k, b], place[k]
                e += c * q[row]
                f += c * v[row]
                g += c * a[row]
            if b > 0:
                half = 0.0
                for k in range(first[p + 3 * b - 3], first[p + 3 * b - 2]):
                    y, row = products[0, which[k]], line[k]
                    half += q[row] * y
                    f += v[row] * y
                    g += a[row] * y
                e += 0.5 * half
            sums[0, b, p], sums[1, b, p], sums[2, b, p] = e, f, g
    return sums


@jit
def _momentum_of(sums: Array, result: Array) -> None:
    """Fill in linear momentum ``int rho y`` and moment ``int rho (x + u) x y`` of the sums of y, shape (6,)."""
    for p in range(3):
        a, b = (p + 1) % 3, (p + 2) % 3
        result[p], result[3 + p] = sums[0, p], sums[1 + a, b] - sums[1 + b, a]


@jit
def momenta_of(body: tuple[Any, ...], q: Array, v: Array, a: Array) -> Momenta:
    """Momenta of the structure at elastic unknowns, velocities and accelerations, each of shape (size,)."""
    products = _products(body, q, v)
    sums = _sums(body, products, q, v, a)
    # One array for all: making one costs as much as filling it.
    room = np.zeros((8, 6))
    mass, relative, push, still = room[:6], room[6], room[7], sums[0]
    trace = body[11][0, 0] + body[11][1, 1] + body[11][2, 2] + 2.0 * (still[1, 0] + still[2, 1] + still[3, 2])
    for p in range(3):
        for r in range(3):
            mass[3 + p, 3 + r] = body[12][p, r] - (body[11][p, r] + still[1 + p, r] + still[1 + r, p])
        mass[p, p] = body[9]
        mass[3 + p, 3 + p] += trace
        # -S(s) above, S(s) below the diagonal.
        i, k, moment = (p + 1) % 3, (p + 2) % 3, body[10][p] + still[0, p]
        mass[i, 3 + k] = mass[3 + k, i] = moment
        mass[k, 3 + i] = mass[3 + i, k] = -moment
    _momentum_of(sums[1], relative)
    _momentum_of(sums[2], push)
    return Momenta(products, mass, relative, sums[1, 1:], push)


@jit
def _forms_of(twist: Array, rates: Array) -> Array:
    """``S(w)`` and ``S(dw) + S(w)^2``, shape (2, 3, 3)."""
    forms, (x, y, z), (a, b, c) = np.empty((2, 3, 3)), triple(twist, 3), triple(rates, 3)
    turning, moving = forms
    put(turning[0], 0, (0.0, -z, y))
    put(turning[1], 0, (z, 0.0, -x))
    put(turning[2], 0, (-y, x, 0.0))
    put(moving[0], 0, (-y * y - z * z, x * y - c, x * z + b))
    put(moving[1], 0, (x * y + c, -x * x - z * z, y * z - a))
    put(moving[2], 0, (x * z - b, y * z + a, -x * x - y * y))
    return forms


@jit
def add_frame_forces(
    body: tuple[Any, ...], products: Array, twist: Array, rates: Array, weight: float, forces: Array
) -> tuple[float, float]:
    """Add the forces of a frame with this twist and these rates to ``forces``, shape (size,).

    They are ``weight (M(2 S(w)) dq + M(Z) q + int rho N' (Z x + a0))`` with ``Z = S(dw) + S(w)^2``. Returns the norms
    of the part that does not depend on q, and of all the forces after it.
    """
    first, line, which, _, _, _, begin, place, moment, _, _, _, _, _ = body
    turning, moving = _forms_of(twist, rates)
    load = np.zeros(forces.size)
    for p in range(3):
        for r in range(3):
            c, d = weight * moving[p, r], 2.0 * weight * turning[p, r]
            if c != 0.0 or d != 0.0:
                for k in range(first[p + 3 * r], first[p + 3 * r + 1]):
                    forces[line[k]] += c * products[0, which[k]] + d * products[1, which[k]]
        a, b, c, d = weight * rates[p], weight * moving[p, 0], weight * moving[p, 1], weight * moving[p, 2]
        for k in range(begin[p], begin[p + 1]):
            load[place[k]] += a * moment[k, 0] + b * moment[k, 1] + c * moment[k, 2] + d * moment[k, 3]
    load_square, square = 0.0, 0.0
    for i in range(forces.size):
        forces[i] += load[i]
        load_square += load[i] * load[i]
        square += forces[i] * forces[i]
    return np.sqrt(load_square), np.sqrt(square)


@jit
def rigid_blocks(body: tuple[Any, ...], q: Array) -> tuple[Array, Array]:
    """R(q), shape (6, 6), and B(q), shape (6, size), whose rows are the forces of unit rates.

    Of a held velocity they are a row of the unit matrix and zeros.
    """
    still, rates, coupling = np.zeros(q.size), np.eye(6), np.zeros((6, q.size))
    momenta = momenta_of(body, q, still, still)
    for k in range(6):
        if body[13][k] > 0.0:
            add_frame_forces(body, momenta.products, np.zeros(6), rates[k], 1.0, coupling[k])
    return held_apart(momenta.mass, body[13]), coupling


@jit
def held_apart(mass: Array, freedom: Array) -> Array:
    """The mass (6, 6) with rows and columns of held velocities as in the unit matrix."""
    result = mass.copy()
    for i in range(6):
        for k in range(6):
            if freedom[i] == 0.0 or freedom[k] == 0.0:
                result[i, k] = 1.0 if i == k else 0.0
    return result


@jit
def carried_energy(body: tuple[Any, ...], q: Array, v: Array, twist: Array) -> float:
    """Kinetic energy in the inertial frame beside that of the elastic motion, ``twist . (R twist / 2 + B dq)`` [J]."""
    momenta, energy = momenta_of(body, q, v, v), 0.0
    for k in range(6):
        energy += twist[k] * (0.5 * inner(momenta.mass[k], twist) + momenta.relative[k])
    return energy
