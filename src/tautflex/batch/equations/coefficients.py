"""Coefficients of a reduced model for rotations about one line, assembled for one run [theory.md 10].

As :func:`tautflex.reduction.polynomial.projection.assemble`,
with the moments about the line taken first and the stress fields of the
reduced model fixed: with F its fields and U their duals (``U F`` is the projection onto them), the third-degree force
of changed parameters is ``Y' F' A F y``, ``A = U' C U``, which is the single run's own where nothing has changed.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tautflex.mechanics.inertia import cross_matrix
from tautflex.motion.kinematics import unit_axis
from tautflex.reduction.polynomial.model import ReducedModel
from tautflex.reduction.polynomial.monomials import monomial_sizes
from tautflex.reduction.polynomial.projection import Factors, mixed_quadratic, weigh

Array = NDArray[np.float64]

# Terms below this part of their kind are round-off of zeros that the structure has.
_ROUND_OFF = 1e-11


class Coefficients(NamedTuple):
    """Of one run; r coordinates, m monomials, n readings. Pairs are of the matrices S and S^2 of the axis.

    Parameters
    ----------
    mass, linear
        Shape (r, r).
    quadratic
        Second-degree force per monomial, shape (r, m).
    cubic
        A of the third-degree force ``Y' F' A F y``, shape (k, k); see `Fields`.
    viscous
        The same of the companions' damping per unit of stiffness damping.
    turn, pull
        ``M(S)`` and ``M(S^2)`` of the coordinates, shape (r, r).
    companions_turn, companions_pull
        The same between companions (per monomial) and coordinates, shape (m, r).
    load
        Loads of the angular acceleration and of the squared rate on coordinates, then monomials, shape (2, r + m).
    follow
        Readings that follow each monomial, shape (n, m).
    held
        Readings that the loads hold off, shape (2, n).
    """

    mass: Any
    linear: Any
    quadratic: Any
    cubic: Any
    viscous: Any
    turn: Any
    pull: Any
    companions_turn: Any
    companions_pull: Any
    load: Any
    follow: Any
    held: Any


@dataclass(frozen=True)
class Fields:
    """Stress fields F of the reduced model, shape (k, m), and their duals U, shape (m, k).

    Where there are too many for two products with F to pay, ``shape`` is None: A is then ``F' U' C U F``, per monomial.
    """

    shape: Array | None
    dual: Array

    @classmethod
    def of(cls, fields: Array, amplitude: Array) -> Fields:
        """Fields from their factor, judged at the typical size of each coordinate."""
        count, monomials = fields.shape
        weighed = fields * monomial_sizes(amplitude) ** 2
        dual = np.zeros((monomials, 0))
        if count:
            dual = np.asarray(np.linalg.solve(weighed @ fields.T, weighed).T, dtype=np.float64)
        if count * (count + monomials) < monomials**2:
            return cls(fields, dual)
        return cls(None, np.eye(monomials) if count == monomials else dual @ fields)

    def project(self, matrix: Any) -> Any:
        """A of a matrix over monomials."""
        return self.dual.T @ matrix @ self.dual

    def full(self, matrix: Any) -> Any:
        """Matrix over monomials of A, shape (m, m)."""
        return matrix if self.shape is None else self.shape.T @ matrix @ self.shape


class Assembly:
    """What coefficients are weighed from.

    Parameters
    ----------
    rom
        Reduced model.
    axis, origin
        Line that the frame turns about.
    cubic, viscous
        Stress fields of the third-degree force and of the companions' damping.
    """

    def __init__(
        self,
        rom: ReducedModel,
        axis: tuple[float, float, float],
        origin: tuple[float, float, float],
        cubic: Fields,
        viscous: Fields,
    ) -> None:
        self._rom, self._cubic, self._viscous = rom, cubic, viscous
        spin = cross_matrix(unit_axis(axis))
        weights = (spin, spin @ spin)
        self._pair, self._load = {}, {}
        for kind, part in rom.pieces.inertia.items():
            pairs = [np.einsum("aapq->pq", part.pair), *(np.einsum("ab,abpq->pq", w, part.pair) for w in weights)]
            self._pair[kind] = np.stack(pairs)
            # The frame's origin is at -origin from the line.
            self._load[kind] = np.stack(
                [np.einsum("ab,abp->p", w, part.first) - (w @ np.asarray(origin)) @ part.zeroth for w in weights]
            )
        self._find_structure()

    def _find_structure(self) -> None:
        """Which terms are nothing, and which change with stiffness or density, from two generic changes."""
        no_readings = np.zeros((len(self._rom.basis.companions), 0))
        kinds = sorted(self._rom.pieces.elastic)
        others = {kind: 1.07 + 0.06 * i for i, kind in enumerate(kinds)}
        own = self(Factors(), no_readings, np)
        stiff = self(Factors(1.13, 0.91, others), no_readings, np)
        heavy = self(Factors(density=others), no_readings, np)

        def changes(other: Coefficients) -> frozenset[str]:
            pairs = zip(own._fields, own, other, strict=True)
            return frozenset(name for name, a, b in pairs if np.abs(a - b).max(initial=0.0) > _ROUND_OFF * _largest(a))

        def nothing(name: str, other: str) -> bool:
            both = [(getattr(c, name), getattr(c, other)) for c in (own, stiff, heavy)]
            return all(_largest(a) <= _ROUND_OFF * max(_largest(a), _largest(b)) for a, b in both)

        beside = {"turn": "pull", "companions_turn": "companions_pull"}
        couples = {**beside, **{b: a for a, b in beside.items()}}.items()
        self.absent = frozenset(name for name, other in couples if nothing(name, other))
        self.by_stiffness, self.by_density = changes(stiff), changes(heavy)

    def __call__(self, factors: Factors, companions: Any, xp: ModuleType) -> Coefficients:
        """Coefficients of one run.

        Parameters
        ----------
        factors
            Parameters, possibly traced.
        companions
            Readings of the companions, shape (p, n).
        xp
            numpy or jax.numpy.
        """
        pieces = self._rom.pieces
        r = pieces.kept
        stiffness, force, cubic = weigh(pieces, factors, xp)
        density = {kind: factors.density.get(kind, 1.0) for kind in pieces.inertia}
        pair = sum(density[kind] * part for kind, part in self._pair.items())
        load = sum(density[kind] * part for kind, part in self._load.items())
        k_pa, k_pp, h = stiffness[r:, :r], stiffness[r:, r:], force[r:]
        # One solution for everything the companions follow.
        follow = -xp.linalg.solve(k_pp, xp.concatenate([k_pa, h, load[:, r:].T], axis=1))
        d, e, held = follow[:, :r], follow[:, r:-2], follow[:, -2:].T
        # Coordinates move the companions along: V' = kept + D' companions.
        reach = xp.concatenate([xp.eye(r), d])
        moved = pair @ reach
        own, coupled = reach.T @ moved, e.T @ moved[1:, r:]
        condensed = h.T @ e
        return Coefficients(
            mass=_even(own[0], xp),
            linear=_even(stiffness[:r, :r] + k_pa.T @ d, xp),
            quadratic=force[:r] + mixed_quadratic(k_pa.T @ e, r, xp),
            cubic=_even(self._cubic.project(0.25 * cubic + condensed), xp),
            viscous=_even(self._viscous.project(-condensed), xp),
            turn=own[1],
            pull=own[2],
            companions_turn=coupled[0],
            companions_pull=coupled[1],
            load=xp.concatenate([load @ reach, load[:, r:] @ e], axis=1),
            follow=companions.T @ e,
            held=held @ companions,
        )


def _even(matrix: Any, xp: ModuleType) -> Any:
    return 0.5 * (matrix + xp.swapaxes(matrix, 0, 1))


def _largest(array: Any) -> float:
    return float(np.abs(array).max(initial=0.0))
