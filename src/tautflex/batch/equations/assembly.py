"""Reduced models of changed parameters for rotations about one line, assembled for one run [theory.md 10].

The stress fields of the reduced model stay as they are: with F its fields and U their duals (``U F`` is the projection
onto them), the third-degree force of changed parameters is ``Y' F' A F y``, ``A = U' C U``, which is the single run's
own where nothing has changed.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import ModuleType
from typing import Any

import numpy as np

from tautflex.motion.kinematics import unit_axis
from tautflex.reduction.polynomial.condensation import (
    CondensedModel,
    Factors,
    FrameMoments,
    condense,
    even,
    parts_by_kind,
    weigh_loads,
)
from tautflex.reduction.polynomial.fields import Fields
from tautflex.reduction.polynomial.model import ReducedModel

# Terms below this part of their kind are round-off of zeros that the structure has.
_ROUND_OFF = 1e-11
# Places of the Euler and the centrifugal term, and of the gyroscopic one with the first.
TURN, PULL = 0, 1


class Assembly:
    """What condensed models are weighed from: weights Z and loads are those of `FrameMoments.about_axis`.

    ``cubic`` and ``viscous`` are stress fields of the third-degree force and of the static derivatives' damping,
    ``loads`` factors of the inertial loads of each kind of element, None for none.
    """

    def __init__(
        self,
        rom: ReducedModel,
        axis: tuple[float, float, float],
        origin: tuple[float, float, float],
        cubic: Fields,
        viscous: Fields,
        loads: Mapping[str, float] | None,
    ) -> None:
        self._rom, self._cubic, self._viscous = rom, cubic, viscous
        line = unit_axis(axis), np.asarray(origin, dtype=float)
        moments = {k: FrameMoments.about_axis(part, *line) for k, part in rom.projection.inertia.items()}
        self._moments = weigh_loads(moments, loads)
        # Which terms are nothing, and which change with stiffness or density, is found from two generic changes.
        no_readings = np.zeros((len(self._rom.basis.derivatives), 0))
        others = {kind: 1.07 + 0.06 * i for i, kind in enumerate(sorted(self._rom.projection.elastic))}
        own, _ = self(Factors(), no_readings, {}, np)
        stiff, _ = self(Factors(1.13, 0.91, others), no_readings, {}, np)
        heavy, _ = self(Factors(density=others), no_readings, {}, np)

        def changes(other: CondensedModel) -> frozenset[str]:
            pairs = zip(own._fields, own, other, strict=True)
            return frozenset(name for name, a, b in pairs if np.abs(a - b).max(initial=0.0) > _ROUND_OFF * _largest(a))

        def nothing(name: str, place: int) -> bool:
            pairs = [getattr(c, name) for c in (own, stiff, heavy)]
            return all(_largest(pair[place]) <= _ROUND_OFF * _largest(pair) for pair in pairs)

        terms = [(name, place) for name in ("turning", "turning_derivatives") for place in (TURN, PULL)]
        self.absent = frozenset(term for term in terms if nothing(*term))
        self.by_stiffness, self.by_density = changes(stiff), changes(heavy)

    def __call__(
        self, factors: Factors, readings: Any, kinds: Mapping[str, tuple[Any, Any]], xp: ModuleType
    ) -> tuple[CondensedModel, tuple[Any, Any] | None]:
        """Condensed model of one run, as by `condense`, for readings of the static derivatives, shape (p, n).

        ``cubic`` and ``viscous`` are A of the forces ``Y' F' A F y``, see `Fields`; ``follow_quadratic`` and
        ``follow_load`` lead to the readings, shapes (n, m) and (2, n). With it what the ``kinds`` of a `DampingMatrix`
        add: damping of the coordinates (r, r), and A of that of the static derivatives; None where kinds are alike.
        """
        c = condense(self._rom.projection, self._moments, factors, xp)
        besides = None
        if kinds:
            parts = parts_by_kind(self._rom.projection, c, factors, xp)
            on_coordinates = sum(m * parts[kind].mass + s * parts[kind].stiffness for kind, (m, s) in kinds.items())
            on_derivatives = sum(s * parts[kind].viscous for kind, (_, s) in kinds.items())
            besides = on_coordinates, even(self._viscous.project(on_derivatives))
        condensed = c._replace(
            cubic=even(self._cubic.project(0.25 * c.cubic)),
            viscous=even(self._viscous.project(c.viscous)),
            follow_quadratic=readings.T @ c.follow_quadratic,
            follow_load=c.follow_load @ readings,
        )
        return condensed, besides


def _largest(array: Any) -> float:
    return float(np.abs(array).max(initial=0.0))
