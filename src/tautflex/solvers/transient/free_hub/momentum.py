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
def _moment_of(lever: Array) -> Array:
    """``int rho x y`` from ``lever_ab = int rho_a y_b``, shape (3,)."""
    return np.array([lever[1, 2] - lever[2, 1], lever[2, 0] - lever[0, 2], lever[0, 1] - lever[1, 0]])


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
def _forms(body: tuple[Any, ...], products: Array, q: Array, v: Array, a: Array) -> Array:
    """``int rho u_a y_b`` for y of the vectors q, v, a, shape (3, 3, 3), from the products of q."""
    first, line, which, forms = body[0], body[1], body[2], np.empty((3, 3, 3))
    for p in range(3):
        for r in range(3):
            e, f, g = 0.0, 0.0, 0.0
            for k in range(first[p + 3 * r], first[p + 3 * r + 1]):
                y, row = products[0, which[k]], line[k]
                e += q[row] * y
                f += v[row] * y
                g += a[row] * y
            forms[0, r, p], forms[1, r, p], forms[2, r, p] = e, f, g
    return forms


@jit
def _moments(body: tuple[Any, ...], q: Array, v: Array, a: Array) -> Array:
    """``int rho (1, x, y, z)_a y_b`` for y of the vectors q, v, a, shape (3, 4, 3)."""
    begin, place, moment, moments = body[6], body[7], body[8], np.empty((3, 4, 3))
    for p in range(3):
        for b in range(4):
            e, f, g = 0.0, 0.0, 0.0
            for k in range(begin[p], begin[p + 1]):
                c, row = moment[k, b], place[k]
                e += c * q[row]
                f += c * v[row]
                g += c * a[row]
            moments[0, b, p], moments[1, b, p], moments[2, b, p] = e, f, g
    return moments


@jit
def momenta_of(body: tuple[Any, ...], q: Array, v: Array, a: Array) -> Momenta:
    """Momenta of the structure at elastic unknowns, velocities and accelerations, each of shape (size,)."""
    products = _products(body, q, v)
    forms, moments = _forms(body, products, q, v, a), _moments(body, q, v, a)
    mixed, square = moments[0, 1:], forms[0]
    second = body[11] + mixed + mixed.T + 0.5 * (square + square.T)
    mass = np.zeros((6, 6))
    mass[3:, 3:] = body[12] - second
    x, y, z = body[10][0] + moments[0, 0, 0], body[10][1] + moments[0, 0, 1], body[10][2] + moments[0, 0, 2]
    for k in range(3):
        mass[k, k] = body[9]
        mass[3 + k, 3 + k] += second[0, 0] + second[1, 1] + second[2, 2]
    mass[5, 1] = mass[1, 5] = x
    mass[4, 2] = mass[2, 4] = -x
    mass[3, 2] = mass[2, 3] = y
    mass[5, 0] = mass[0, 5] = -y
    mass[4, 0] = mass[0, 4] = z
    mass[3, 1] = mass[1, 3] = -z
    flow, kick = moments[1, 1:] + forms[1], moments[2, 1:] + forms[2]
    relative, push = np.empty(6), np.empty(6)
    relative[:3], relative[3:] = moments[1, 0], _moment_of(flow)
    push[:3], push[3:] = moments[2, 0], _moment_of(kick)
    return Momenta(products, mass, relative, flow, push)


@jit
def add_frame_forces(
    body: tuple[Any, ...], products: Array, twist: Array, rates: Array, weight: float, forces: Array
) -> tuple[float, float]:
    """Add the forces of a frame with this twist and these rates to ``forces``, shape (size,).

    They are ``weight (M(2 S(w)) dq + M(Z) q + int rho N' (Z x + a0))`` with ``Z = S(dw) + S(w)^2``. Returns the norms
    of the part that does not depend on q, and of all the forces after it.
    """
    first, line, which, _, _, _, begin, place, moment, _, _, _, _, _ = body
    x, y, z = twist[3], twist[4], twist[5]
    turning = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    moving = np.array(
        [
            [-y * y - z * z, x * y - rates[5], x * z + rates[4]],
            [x * y + rates[5], -x * x - z * z, y * z - rates[3]],
            [x * z - rates[4], y * z + rates[3], -x * x - y * y],
        ]
    )
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
