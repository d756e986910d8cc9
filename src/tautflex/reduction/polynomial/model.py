"""Reduced model: a few coordinates with exact polynomial forces in place of all unknowns [theory.md 10]."""

from __future__ import annotations

import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tautflex import checks
from tautflex.errors import UnsupportedError
from tautflex.mechanics.dampings.damping import Damping
from tautflex.mechanics.loads.inputs import InputSet, TimeInput
from tautflex.numeric import Array, within_arithmetic
from tautflex.reduction.bases.answers import with_answers
from tautflex.reduction.bases.modal_basis import ModalBasis
from tautflex.reduction.bases.vectors import Basis, BasisVectors
from tautflex.reduction.inputs import input_loads
from tautflex.reduction.marching.simulation import solve_reduced
from tautflex.reduction.on_basis import OnBasis, refuse_drifting, refuse_turning
from tautflex.reduction.polynomial.condensation import CondensedModel, Factors, KindParts, assemble, parts_by_kind
from tautflex.reduction.polynomial.fields import Fields
from tautflex.reduction.polynomial.forces import ReducedArrays
from tautflex.reduction.polynomial.monomials import WEAK_FIELD, monomial_sizes, pairs, stress_fields
from tautflex.reduction.polynomial.projection import Projection, project
from tautflex.solvers.static.prestress import PrestressedState, require_state
from tautflex.solvers.transient.problem import Progress, TransientProblem
from tautflex.solvers.transient.restart.keeper import Keeper
from tautflex.solvers.transient.status import Run

# Fields of the static derivatives' damping, a small force, may be coarser than those of the stiffness, so many times.
_COARSER = 100.0
# Coupling of coordinates and static derivatives below this part of what it couples is round-off of a flat reference.
_COUPLED = 1e-6
# Second-degree forces below this part of the linear ones are round-off of a flat reference.
_ROUND_OFF = 1e-9


@dataclass(frozen=True)
class ReducedModel(OnBasis):
    """Structure on a basis; `simulate` takes it in place of a prestressed state.

    Parameters
    ----------
    state
        The prestressed state that was reduced.
    basis
        Vectors: displacement = eta kept + (E y + load response) derivatives.
    projection
        Projected structure, in affine parts that parameters weigh.
    seconds
        What the reduction cost [s].
    weak_field
        Stress fields with less than this part of the strongest one's energy are left out.
    """

    state: PrestressedState
    basis: BasisVectors
    projection: Projection
    seconds: float
    weak_field: float = WEAK_FIELD

    @cached_property
    def coefficients(self) -> CondensedModel:
        """Equation of motion of the coordinates at the parameters of the state."""
        return assemble(self.projection)

    def weighed(self, factors: Mapping[str, float]) -> CondensedModel:
        """The same with the inertial load of each kind of element times its factor."""
        return assemble(self.projection, loads=factors)

    def arrays(self, damping: Damping) -> ReducedArrays:
        """Arrays for the compiled stepper under a damping model."""
        c = self.coefficients
        first, second = pairs(self.size)
        largest = float(np.abs(c.quadratic).max(initial=0.0) * self.basis.amplitude.max())
        curved = largest > _ROUND_OFF * float(np.abs(c.linear).max())
        fields, viscous = self.fields
        # Static derivatives have no mass here, so only the stiffness part of the damping acts on them.
        matrix = damping.of(self.state.linear)
        share = float(matrix.stiffness)
        parts = self.by_kind if matrix.kinds else {}
        own = matrix.projected(c.mass, c.linear, self.basis.kept, {kind: part[:2] for kind, part in parts.items()})
        if parts:
            total = share * c.viscous + sum(factor * parts[kind].viscous for kind, (_, factor) in matrix.kinds.items())
            viscous = Fields.of(viscous, self.basis.amplitude).root(total)
            self._refuse_curved(
                sum(factor * parts[kind].between for kind, (_, factor) in matrix.kinds.items()), own, total
            )
        else:
            viscous = np.sqrt(share) * viscous if share > 0.0 else viscous[:0]
        return ReducedArrays(
            first,
            second,
            c.mass,
            own,
            c.linear,
            np.ascontiguousarray(c.quadratic if curved else c.quadratic[:0]),
            fields,
            viscous,
            c.turning.reshape(3, 3, self.size, self.size),
            np.ascontiguousarray(c.turning_derivatives).reshape(3, 3, -1, self.size),
        )

    @cached_property
    def by_kind(self) -> dict[str, KindParts]:
        """What each kind of element adds to a damping by kind."""
        return parts_by_kind(self.projection, self.coefficients, Factors(), np)

    def _refuse_curved(self, between: Any, own: Array, viscous: Array) -> None:
        """Raise UnsupportedError if a damping by kind couples the coordinates to their static derivatives' rates."""
        amplitude = self.basis.amplitude
        size = monomial_sizes(amplitude)
        scale = np.sqrt(float((own.diagonal() * amplitude**2).max()) * float((viscous.diagonal() * size**2).max()))
        if float(np.abs(amplitude[:, None] * between * size).max(initial=0.0)) > _COUPLED * scale:
            raise UnsupportedError(
                "damping: expected one alpha and one beta for all kinds of element in a reduced model of a curved "
                "structure, got numbers by kind; simulate the full state, or use hyper_reduce"
            )

    @cached_property
    def fields(self) -> tuple[Array, Array]:
        """Stress fields of the third-degree force, and of the static derivatives' damping, shapes (k, m) and (l, m)."""
        c, amplitude = self.coefficients, self.basis.amplitude
        return (
            stress_fields(0.25 * c.cubic, amplitude, self.weak_field),
            stress_fields(c.viscous, amplitude, _COARSER * self.weak_field),
        )

    def solve(self, problem: TransientProblem, progress: Progress = None, keeper: Keeper | None = None) -> Run:
        """Answer a problem asked of it."""
        return solve_reduced(self, problem, progress, keeper)

    @property
    def memory(self) -> int:
        """Bytes of basis and projection."""
        arrays = [self.basis.kept, self.basis.derivatives]
        arrays += [*self.projection.stress.values(), *self.projection.elastic.values()]
        arrays += [array for part in self.projection.higher.values() for array in (part.quadratic, part.cubic)]
        arrays += [array for part in self.projection.inertia.values() for array in (part.pair, part.first, part.zeroth)]
        return sum(array.nbytes for array in arrays)

    def __repr__(self) -> str:
        return (
            f"ReducedModel({self.size} coordinates for {self.state.system.size} unknowns: {self.basis.description}; "
            f"{self.memory / 1e6:.3g} MB, made in {self.seconds:.3g} s)"
        )


@within_arithmetic()
def reduce(
    state: PrestressedState,
    basis: Basis | None = None,
    weak_field: float = WEAK_FIELD,
    inputs: Sequence[TimeInput] = (),
) -> ReducedModel:
    """Reduce a prestressed structure to a few coordinates.

    Parameters
    ----------
    state
        Prestressed state; laws must be elastic (for wrinkling film see `hyper_reduce`).
    basis
        `ModalBasis` (default: all transverse rigid accelerations), `PodBasis`, or another `Basis`.
    weak_field
        Stress fields with less than this part of the strongest one's energy are left out (of the static derivatives'
        damping, a hundred times as much); 0 keeps all.
    inputs
        Inputs of the runs to come: what answers up to eight numbers of tension and temperature, and what answers others
        too slowly to follow at once, becomes coordinates. Runs may have others, whose answers are instantaneous.

    Returns
    -------
    ReducedModel

    Raises
    ------
    InputError
        If ``basis`` is not a basis, ``weak_field`` is not in [0, 1e-2], or an input does not fit the structure.
    UnsupportedError
        If the structure has nonlinear laws or can drift away as a rigid body, or an input is not linear in few numbers.

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> rom = tf.reduce(state, tf.ModalBasis(directions=("rx",)))
    >>> run = tf.simulate(rom, tf.Stop(rate=0.6, duration=0.2), time_step=2e-3, end_time=0.5, probes={"A": (0.7, 0.4)})
    >>> run.status.value
    'completed'
    """
    began = clock.perf_counter()
    require_state(state)
    basis = ModalBasis() if basis is None else basis
    checks.instance("basis", basis, Basis, "an object such as ModalBasis(directions=('rx',))")
    checks.between("weak_field", weak_field, 0.0, 1e-2)
    laws = sorted({block.law.name for block in state.system.blocks if not block.is_elastic})
    if laws:
        raise UnsupportedError(
            f"law: expected elastic film and cables, whose forces are polynomials, got {', '.join(laws)}; use "
            "hyper_reduce(state, run), or law = 'elastic'"
        )
    refuse_turning(state)
    refuse_drifting(state)
    loads = input_loads(InputSet(state.system, inputs))
    vectors = basis.vectors(state)
    if inputs:
        vectors = with_answers(state, vectors, *loads)
    projection = project(state, vectors)
    return ReducedModel(state, vectors, projection, clock.perf_counter() - began, weak_field)
