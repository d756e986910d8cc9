"""The reduced model for many runs side by side: the run is the last axis of every array [theory.md 10]."""

from __future__ import annotations

from functools import cache, reduce
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import lax

from tautflex.batch.equations.assembly import Assembly
from tautflex.batch.equations.equation import EachRun, damping_kinds
from tautflex.batch.equations.hub import HubEquation
from tautflex.batch.equations.input_terms import InputTerms
from tautflex.batch.equations.inputs import BatchInputs
from tautflex.batch.equations.rate_history import Numbers, RateHistory
from tautflex.batch.equations.reduced_equation import Damping, ReducedEquation, Shared
from tautflex.batch.library import jax
from tautflex.batch.steps.products import Monomials, one_by_one
from tautflex.errors import UnsupportedError
from tautflex.mechanics.dampings.rayleigh import Rayleigh
from tautflex.motion.coupling import Coupling
from tautflex.reduction.inputs import ReducedInputs
from tautflex.reduction.polynomial.condensation import CondensedModel, Factors
from tautflex.reduction.polynomial.fields import Fields
from tautflex.reduction.polynomial.model import ReducedModel
from tautflex.solvers.transient.probes import ProbeSet

Array = jax.Array

# Beginnings of the names of numbers that change coefficients.
_STRUCTURE = ("tension", "youngs_modulus", "density", "damping.mass.", "damping.stiffness.")


class ReducedPlant:
    """A reduced model for batches."""

    side_by_side = True

    def __init__(self, rom: ReducedModel) -> None:
        self.rom, self.state, self.size, self.pairs = rom, rom.state, rom.size, 1
        self.kinds = tuple(rom.projection.elastic)
        # Second-degree forces of a flat structure are round-off.
        curved = rom.arrays(Rayleigh()).quadratic.size > 0
        cubic, viscous = (Fields.of(part, rom.basis.amplitude) for part in rom.fields)
        self.shared = Shared(rom.size, Monomials(rom.size), cubic, viscous, curved)
        self._assembly = cache(lambda axis, origin, loads: Assembly(rom, axis, origin, cubic, viscous, loads))
        self.of_inputs = cache(lambda inputs: ReducedInputs(rom, inputs.given))

    def equation(
        self,
        numbers: Numbers,
        each: EachRun,
        history: RateHistory,
        coupling: Coupling,
        probes: ProbeSet,
        inputs: BatchInputs,
    ) -> ReducedEquation:
        """Equation of all runs; UnsupportedError for parameters that change what inputs do."""
        assembly, basis = self._assembly(history.axis, history.origin, coupling.load_by_kind), self.rom.basis
        _refuse_restressed(inputs, numbers)
        # Forces act on what follows the monomials too: read like probes.
        looks = np.concatenate([probes.map @ basis.derivatives.T, inputs.given.force_at_rest.T @ basis.derivatives.T])
        readings = jnp.asarray(looks.T)

        def weigh(numbers: Numbers) -> tuple[Any, ...]:
            # Its fields are arrays of the library it was assembled with.
            c, besides = assembly(_factors(numbers, self.kinds), readings, damping_kinds(numbers, self.kinds), jnp)
            modes = _natural_modes(lax.stop_gradient(c.mass), lax.stop_gradient(c.linear))
            both = (self.shared.cubic, c.cubic), (self.shared.viscous, c.viscous)
            traces = [self.shared.monomials.trace(fields.full(a)) for fields, a in both]
            return c, besides, modes, (*traces, jnp.max(jnp.sum(jnp.abs(jnp.linalg.inv(c.mass)), axis=0)))

        differ = frozenset(name for name in each.differ if name.startswith(_STRUCTURE))
        if differ:
            own = {name: numbers[name] for name in sorted(differ)}
            weighed = one_by_one(lambda own: weigh({**numbers, **own}), own)
            c, besides, modes, bounds = jax.tree.map(lambda part: jnp.moveaxis(part, 0, -1), weighed)
            same = _same_for_all(assembly, differ)
            # In one order in every process: compiled code is found again by its text.
            c = c._replace(**{name: getattr(c, name)[..., 0] for name in sorted(same)})
        else:
            c, besides, modes, bounds = weigh(numbers)
            modes = modes[0], modes[1][:, None]
        alpha, beta = (jnp.asarray(numbers[f"damping.{name}"]) + jnp.zeros(each.runs) for name in ("mass", "stiffness"))
        most = reduce(
            jnp.maximum, [beta + jnp.asarray(s) for _, s in damping_kinds(numbers, self.kinds).values()], beta
        )
        weights = jnp.asarray(numbers["damping.coefficients"])
        weights = weights.T if "damping.coefficients" in each.differ else weights[:, None]
        vectors = numbers["damping.vectors"] @ basis.kept.T if len(weights) else jnp.zeros((0, self.size))
        kept = jnp.asarray(probes.map @ basis.kept.T)
        damping = Damping(alpha, beta, most, weights, vectors, besides)
        count = len(kept)
        acting = InputTerms.of(self.of_inputs(inputs), c.follow_quadratic[count:], probes) if inputs else None
        c = c._replace(follow_quadratic=c.follow_quadratic[:count], follow_load=c.follow_load[:, :count])
        parts = self.shared, c, damping, modes, bounds, coupling, assembly.absent, kept, acting
        if history.hub is None:
            return ReducedEquation(*parts)
        moment = self._moment(numbers, np.asarray(history.axis)) + jnp.zeros(each.runs)
        return HubEquation(*parts, moment, inputs.push(np.asarray(history.axis), basis.kept))

    def _moment(self, numbers: Numbers, axis: Any) -> Any:
        """Moment of inertia of hub and structure at rest about an axis through the origin [kg m^2]."""
        system = self.state.system

        def about(second: Any) -> Any:
            return np.trace(second) - axis @ second @ axis

        changes = [
            (numbers[f"density.{kind}"] - 1.0) * about(system.inertia_of(kind).second_moment)
            for kind in self.kinds
            if f"density.{kind}" in numbers
        ]
        return numbers["hub.inertia"] + about(system.inertia.second_moment) + sum(changes)


def _refuse_restressed(inputs: BatchInputs, numbers: Numbers) -> None:
    """Raise UnsupportedError where parameters would change what stresses of inputs do."""
    changed = [name for name in numbers if name.startswith(("tension", "youngs_modulus"))]
    if inputs.given.columns and changed:
        raise UnsupportedError(
            f"parameters: expected none that changes the stiffness beside inputs of tension or temperature, which act "
            f"through it, got {', '.join(changed)}; simulate one by one"
        )


def _factors(numbers: Numbers, kinds: tuple[str, ...]) -> Factors:
    def by_kind(name: str) -> dict[str, Any]:
        return {kind: numbers[f"{name}.{kind}"] for kind in kinds if f"{name}.{kind}" in numbers}

    return Factors(
        numbers.get("tension_x", 1.0), numbers.get("tension_y", 1.0), by_kind("youngs_modulus"), by_kind("density")
    )


def _same_for_all(assembly: Assembly, differ: frozenset[str]) -> frozenset[str]:
    """Names of the coefficients that do not differ from run to run."""
    # Readings were not part of the comparison; they follow the static derivatives.
    different = {"follow_linear", "follow_quadratic", "follow_load"}
    if any(not name.startswith("density") for name in differ):
        different |= assembly.by_stiffness
    if any(name.startswith("density") for name in differ):
        different |= assembly.by_density
    return frozenset(CondensedModel._fields) - different


def _natural_modes(mass: Array, stiffness: Array) -> tuple[Array, Array]:
    """Mass-normalised modes as columns and squares of their frequencies."""
    lower = jnp.linalg.cholesky(mass)
    half = jax.scipy.linalg.solve_triangular(lower, stiffness, lower=True)
    squares, turn = jnp.linalg.eigh(jax.scipy.linalg.solve_triangular(lower, half.T, lower=True))
    return jax.scipy.linalg.solve_triangular(lower.T, turn, lower=False), squares
