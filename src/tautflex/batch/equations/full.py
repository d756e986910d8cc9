"""The full nonlinear model as pure functions: element blocks are data, so one expression per block does [theory.md 2].

Parameters weigh the blocks: factors of the tension along x and y multiply the initial stresses, factors of Young's
modulus and density those of a kind of element. Nominal natural modes, all of them, make the approximate inverse
``phi (phi' r / (mass + stiffness w^2))``, which serves every step size, damping and run.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, cached_property
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax.scipy.sparse.linalg import cg
from scipy.linalg import eigh

from tautflex.batch.equations.equation import EachRun, Forces, Sample, damping_kinds
from tautflex.batch.equations.inputs import BatchInputs
from tautflex.batch.equations.rate_history import Numbers, RateHistory, Spin
from tautflex.batch.gather import collect, gather_table, multiply, shared_rows
from tautflex.batch.library import jax
from tautflex.errors import UnsupportedError
from tautflex.mechanics.loads.inputs import InputSet
from tautflex.motion.coupling import Coupling
from tautflex.motion.kinematics import unit_axis
from tautflex.numeric import cross_matrix
from tautflex.reduction.on_basis import refuse_drifting, refuse_turning
from tautflex.reduction.polynomial.projection import prestress_fields
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.transient.probes import ProbeSet
from tautflex.structure.kinds import ByKind

Array = jax.Array
Axis = tuple[float, float, float]

# Unknowns beyond which the dense modes do not pay (a gigabyte, and minutes to find them).
_MOST_UNKNOWNS = 12_000


class FullPlant:
    """A prestressed state for batches; UnsupportedError for nonlinear laws, rigid freedom or too many unknowns."""

    side_by_side = False
    """Whether its equation is that of many runs, the last axis of every array, or that of one."""

    def __init__(self, state: PrestressedState) -> None:
        system = state.system
        laws = sorted({block.law.name for block in system.blocks if not block.is_elastic})
        if laws:
            raise UnsupportedError(
                f"law: expected elastic film and cables in a batch, got {', '.join(laws)}; run simulate one by one"
            )
        refuse_turning(state)
        refuse_drifting(state)
        if system.size > _MOST_UNKNOWNS:
            raise UnsupportedError(
                f"state: expected at most {_MOST_UNKNOWNS} unknowns in a batch of full models, got {system.size}; "
                "reduce(state) first"
            )
        self.state, self.size, self.pairs = state, system.size, 8
        self.kinds = system.kinds
        fields = prestress_fields(state)
        self.blocks, self.places = system.blocks, system.row_places
        self.stresses = [
            {name: field[index] for name, field in fields.items() if np.any(field[index])}
            for index in range(len(self.blocks))
        ]
        self.table = gather_table(np.concatenate([places.ravel() for places in self.places]), system.size)
        stiffness = system.pattern.matrix(state.tangent_entries).toarray()
        values, modes = eigh(stiffness, system.inertia.mass_matrix.toarray())
        self.frequencies, self.modes = jnp.asarray(values), jnp.asarray(modes)
        self._inertia = cache(lambda axis, origin: _Inertia(self, axis, origin))

    @cached_property
    def diagonals(self) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """``phi' M_e phi`` and ``phi' K_e phi`` of every mode, kind by kind of element."""
        phi, matrix = np.asarray(self.modes), self.state.system.pattern.symmetric_matrix
        parts = self.state.linear.by_kind
        return {kind: tuple(np.sum(phi * (matrix(one) @ phi), axis=0) for one in pair) for kind, pair in parts.items()}

    def equation(
        self,
        numbers: Numbers,
        each: EachRun,
        history: RateHistory,
        coupling: Coupling,
        probes: ProbeSet,
        inputs: BatchInputs,
    ) -> FullEquation:
        """Equation of one run; UnsupportedError for pressure, or where a parameter would change an input's stress."""
        if inputs.given.films:
            raise UnsupportedError(
                "inputs: expected forces that do not follow the motion in a batch of the full model, got Pressure; "
                "reduce(state) first, or simulate one by one"
            )
        changed = [name for name in numbers if name.startswith("youngs_modulus")]
        if inputs.given.columns and changed:
            raise UnsupportedError(
                f"parameters: expected none that changes what inputs of tension or temperature do, got "
                f"{', '.join(changed)}; simulate one by one"
            )
        return FullEquation(self, numbers, self._inertia(history.axis, history.origin), coupling, probes, inputs.given)


class _Inertia:
    """Matrices ``M(1), M(S), M(S^2)`` and loads of every kind of element for one axis; S turns about it."""

    def __init__(self, plant: FullPlant, axis: Axis, origin: Axis) -> None:
        system, spin = plant.state.system, cross_matrix(unit_axis(axis))
        matrices = []
        self.loads: dict[str, tuple[np.ndarray, ...]] = {}
        for kind in plant.kinds:
            operator = system.inertia_of(kind)
            turned = [operator.matrix(weight).tocsr() for weight in (spin, spin @ spin)]
            for matrix in turned:
                matrix.eliminate_zeros()
            matrices += [operator.mass_matrix, *turned]
            # The frame's origin is at -origin from the line.
            self.loads[kind] = tuple(operator.load(z, -z @ np.asarray(origin)) for z in (spin, spin @ spin))
        self.columns, values = shared_rows(matrices)
        self.values = {kind: tuple(values[3 * i : 3 * i + 3]) for i, kind in enumerate(plant.kinds)}


class FullEquation:
    """Equation (49) of one run, whose factors and damping may be traced."""

    def __init__(
        self,
        plant: FullPlant,
        numbers: Numbers,
        inertia: _Inertia,
        coupling: Coupling,
        probes: ProbeSet,
        inputs: InputSet,
    ) -> None:
        self._pattern, self._given = jnp.asarray(inputs.pattern), inputs.columns
        self.size, self._plant, self._coupling = plant.size, plant, coupling
        self._probes = jnp.asarray(probes.map.toarray())
        self._alpha, self._beta, self._weights, self._vectors = (
            jnp.asarray(numbers[f"damping.{name}"]) for name in ("mass", "stiffness", "coefficients", "vectors")
        )
        self._by_kind = damping_kinds(numbers, plant.kinds)
        x, y = numbers.get("tension_x", 1.0), numbers.get("tension_y", 1.0)
        tension = {"x": x, "y": y, "xy": jnp.sqrt(x * y)}
        self._stress = [
            sum((tension[name] * part for name, part in stress.items()), jnp.zeros(block.elasticity.shape[:2]))
            for block, stress in zip(plant.blocks, plant.stresses, strict=True)
        ]
        self._stiff = [block.elasticity * numbers.get(f"youngs_modulus.{block.kind}", 1.0) for block in plant.blocks]
        loads = coupling.load_by_kind or ByKind({}, coupling.load_factor)
        density = {kind: numbers.get(f"density.{kind}", 1.0) for kind in plant.kinds}
        self._columns = inertia.columns
        self._mass, self._turn, self._pull = (
            sum(density[kind] * inertia.values[kind][part] for kind in plant.kinds) for part in range(3)
        )
        self._euler_load, self._spin_load = (
            sum(density[kind] * loads[kind] * inertia.loads[kind][part] for kind in plant.kinds) for part in range(2)
        )
        if self._by_kind:
            self._besides = sum(density[kind] * inertia.values[kind][0] * m for kind, (m, _) in self._by_kind.items())
        self._mass_diagonal = jnp.where(self._columns == jnp.arange(self.size)[:, None], self._mass, 0.0).sum(axis=1)

    def _internal(self, q: Array, v: Array, u: Any) -> tuple[Array, Array, Array]:
        """Internal force above the reference, that of stiffness damping, and strain energy above the reference.

        Stresses of inputs with numbers u, shape (n,), are part of the elastic ones.
        """
        place, rate = jnp.append(q, 0.0), jnp.append(v, 0.0)
        elastic, viscous, energy = [], [], jnp.zeros(())
        plant = self._plant
        parts = zip(plant.blocks, plant.places, self._stress, self._stiff, strict=True)
        for number, (block, places, stress, stiff) in enumerate(parts):
            g = jnp.einsum("egd,ed->eg", block.gradient, place[places])
            slope = jnp.einsum("sij,ej->esi", block.quadratic, g)
            strain = g @ block.linear.T + 0.5 * jnp.einsum("esi,ei->es", slope, g)
            elastic_stress = jnp.einsum("est,et->es", stiff, strain)
            given = self._given[number] @ u if number in self._given and not isinstance(u, tuple) else 0.0
            added = elastic_stress + given
            # B' sigma less its value at zero unknowns.
            conjugate = added @ block.linear + jnp.einsum("esi,es->ei", slope, stress + added)
            change = jnp.einsum("egd,ed->eg", block.gradient, rate[places])
            material = jnp.einsum("est,et->es", stiff, change @ block.linear.T) @ block.linear
            resisting = self._beta * (material + jnp.einsum("es,sij,ej->ei", stress, block.quadratic, change))
            if block.kind in self._by_kind:
                resisting += self._by_kind[block.kind][1] * material
            volume = block.measure[:, None]
            elastic.append(jnp.einsum("egd,eg->ed", block.gradient, volume * conjugate).ravel())
            viscous.append(jnp.einsum("egd,eg->ed", block.gradient, volume * resisting).ravel())
            second_order = 0.5 * jnp.einsum("esi,ei->es", slope, g)
            energy += jnp.sum(volume * ((0.5 * elastic_stress + given) * strain + stress * second_order))
        elastic_force, viscous_force = (collect(jnp.concatenate(parts), plant.table) for parts in (elastic, viscous))
        return elastic_force, viscous_force, energy

    def _load(self, spin: Spin) -> Array:
        if self._coupling.load_factor == 0.0:
            return jnp.zeros(self.size)
        return spin.acceleration * self._euler_load + spin.square * self._spin_load

    def _turning(self, q: Array, v: Array, spin: Spin) -> Array:
        """Gyroscopic and K_T forces; both are one matrix times something."""
        c = self._coupling
        swing = 2.0 * spin.rate * v * float(c.gyroscopic) + spin.acceleration * q * float(c.euler)
        total = multiply(self._columns, self._turn, swing)
        if c.centrifugal:
            total += multiply(self._columns, self._pull, spin.square * q)
        return total

    def frame(self, q: Array, v: Array, spin: Spin) -> Array:
        """Part of the forces that jumps with the motion and the inputs, shape (n,)."""
        force = self._turning(q, v, spin) + self._load(spin)
        if isinstance(spin.inputs, tuple):
            return force
        still = jnp.zeros_like(v)
        stressed = self._internal(q, still, spin.inputs)[0] - self._internal(q, still, ())[0] if self._given else 0.0
        return force - self._pattern @ spin.inputs + stressed

    def predicted(self, q: Array, v: Array, spin: Spin) -> None:
        """Nothing is predicted."""

    def forces(self, q: Array, v: Array, spin: Spin, predicted: None) -> Forces:
        """All forces but inertia."""
        elastic, viscous, _ = self._internal(q, v, spin.inputs)
        load = self._load(spin)
        if not isinstance(spin.inputs, tuple):
            load = load - self._pattern @ spin.inputs
        total = elastic + viscous + self._alpha * self.mass(v) + self._turning(q, v, spin) + load
        if self._by_kind:
            total += multiply(self._columns, self._besides, v)
        if len(self._vectors):
            total += (self._weights * (self._vectors @ v)) @ self._vectors
        return Forces(total, jnp.linalg.norm(elastic), jnp.linalg.norm(load))

    def mass(self, a: Array) -> Array:
        """Mass times acceleration, shape (n,)."""
        return multiply(self._columns, self._mass, a)

    def mass_solve(self, force: Array) -> Array:
        """Acceleration of a force, shape (n,); conjugate gradients, because it is asked for rarely."""
        found, _ = cg(  # type: ignore[no-untyped-call]
            self.mass, force, tol=1e-14, maxiter=500, M=lambda r: r / self._mass_diagonal
        )
        return found

    def inverse(self, mass: Any, damping: Any, stiffness: Any) -> Callable[[Array], Array]:
        """Symmetric approximate inverse of ``mass M + damping C + stiffness K`` at the nominal reference."""
        phi, squares = self._plant.modes, self._plant.frequencies
        diagonal = mass + damping * self._alpha + (stiffness + damping * self._beta) * squares
        for kind, (on_mass, on_stiffness) in self._by_kind.items():
            own_mass, own_stiffness = self._plant.diagonals[kind]
            diagonal += damping * (on_mass * own_mass + on_stiffness * own_stiffness)
        if len(self._vectors):
            diagonal += damping * (self._weights @ (self._vectors @ phi) ** 2)
        return lambda r: phi @ ((r @ phi) / diagonal)

    def sample(self, q: Array, v: Array, spin: Spin, store: tuple[str, ...]) -> Sample:
        """What is stored of an instant."""
        looked = {"displacement": q, "velocity": v}
        found = {name: (self._probes @ part).reshape(-1, 3) for name, part in looked.items() if name in store}
        if "energy" in store:
            found["energy"] = jnp.stack([0.5 * v @ self.mass(v), self._internal(q, v, spin.inputs)[2]])
        return found
