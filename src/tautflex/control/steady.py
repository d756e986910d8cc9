"""Steady state that a linear view is about: at rest, in a spin, under inputs that are held [control.md 3]."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.control.columns import InputColumns, by_name
from tautflex.errors import InputError, UnsupportedError
from tautflex.mechanics.loads.pressure import PressureLoad
from tautflex.motion.coupling import Coupling
from tautflex.motion.hub import FreeHub
from tautflex.motion.kinematics import AtRest, RigidMotion
from tautflex.numeric import Array, cross_matrix
from tautflex.reduction.on_basis import refuse_drifting
from tautflex.solvers.linear.eigenpairs import lowest_eigenpairs
from tautflex.solvers.linear.factorization import SymmetricFactorization
from tautflex.solvers.static.equilibrium import solve_static
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.transient.free_hub.momentum import Body, rigid_blocks


@dataclass(frozen=True, eq=False)
class SteadyState:
    """A structure in a steady state, and what small motion about it needs.

    Parameters
    ----------
    reference
        Its prestressed state at rest, which damping is made from.
    state
        The same, with the stresses of held inputs in its system.
    q
        Free unknowns of the steady state, shape (size,).
    motion, coupling
        Steady motion of the frame, and which of its terms count.
    hub
        Hub that is free, or None.
    films
        Pressures that are held.
    """

    reference: PrestressedState
    state: PrestressedState
    q: Array
    motion: RigidMotion
    coupling: Coupling
    hub: FreeHub | None
    films: Sequence[PressureLoad] = ()

    @cached_property
    def stiffness(self) -> Array:
        """``K_tan(q) + K_T`` in the pattern, less what turning film has of pressure, shape (entries,)."""
        system, weight = self.state.system, self.coupling.displacement_weight(self.motion)
        tangent = system.tangent(self.q)
        for film in self.films:
            tangent = tangent - film.stiffness(self.q)
        return tangent + system.inertia.entries(weight) if weight.any() else tangent

    def modes(self, count: int) -> Array:
        """Lowest modes, shape (count, size); those of a state at rest are found once for all that ask."""
        linear, system = self.reference.linear, self.state.system
        if self.state is self.reference and np.array_equal(self.stiffness, linear.stiffness_entries):
            return linear.modes(count)[1]
        return lowest_eigenpairs(system.pattern, self.stiffness, system.inertia.mass_entries, count)[1]

    @cached_property
    def _factor(self) -> SymmetricFactorization:
        factor = SymmetricFactorization(self.state.system.pattern)
        try:
            factor.factorize(self.stiffness)
        except np.linalg.LinAlgError:
            raise InputError(
                "state: expected a steady state with stiffness, got a singular one; hold the structure, or spin slower"
            ) from None
        return factor

    def solve(self, loads: Array) -> Array:
        """Static answers to loads, shape (size, n) each."""
        return np.array([self._factor.solve(np.ascontiguousarray(load)) for load in loads.T]).reshape(loads.T.shape).T

    def product(self, entries: Array, vectors: Array) -> Array:
        """Symmetric matrix of values in the pattern times vectors, shape (n, size)."""
        return np.asarray((self.state.system.pattern.symmetric_matrix(entries) @ vectors.T).T)

    @cached_property
    def directions(self) -> list[int]:
        """Free directions of the hub among x, y, z, rx, ry, rz: rotations, then translations."""
        if self.hub is None:
            return []
        axes = self.hub.axes
        turns = [3, 4, 5] if axes in ("free", "xyz") else [3 + "xyz".index(axes)]
        return turns + ([0, 1, 2] if axes == "free" else [])

    @property
    def axes(self) -> int:
        """Number of axes that the hub turns about."""
        return sum(direction >= 3 for direction in self.directions)

    @cached_property
    def blocks(self) -> tuple[Array, Array]:
        """Mass of the hub with the structure, and its coupling, in the free directions, (d, d) and (d, size)."""
        mass, coupling = rigid_blocks(tuple(Body.of(self.state.system.inertia, self.hub)), self.q)
        return mass[np.ix_(self.directions, self.directions)], coupling[self.directions]

    @property
    def spin(self) -> float:
        """Rate of a hub that turns about one axis [rad/s]."""
        return float(self.motion.angular_velocity[self.directions[0] - 3]) if self.hub is not None else 0.0

    @cached_property
    def swing(self) -> Array:
        """``d(w^2 load)/d(w^2)``: what a change of the rate of a hub of one axis pulls at, shape (size,)."""
        turn = cross_matrix(np.eye(3)[self.directions[0] - 3])
        inertia = self.state.system.inertia
        return inertia.load(turn @ turn) + inertia.apply(turn @ turn, self.q)


def steady_state(
    state: PrestressedState,
    effects: Sequence[InputColumns],
    values: Mapping[str, ArrayLike] | None,
    hub: FreeHub | None,
    motion: RigidMotion | None,
    coupling: Coupling | None,
) -> SteadyState:
    """Find the steady state under held inputs, shapes of `linearize`.

    Raises
    ------
    InputError
        If an argument contradicts another one.
    UnsupportedError
        If the structure can drift, or the spin is one about several axes of a free hub.
    """
    refuse_drifting(state)
    coupling = Coupling() if coupling is None else coupling
    checks.instance("coupling", coupling, Coupling, "an object such as Coupling()")
    if hub is not None and coupling != Coupling():
        raise InputError(f"coupling: expected all terms, whole, on a free hub, got {coupling!r}; leave coupling out")
    held = by_name("values", values, effects)
    system, load, stress = state.system, np.zeros(state.system.size), list(state.system.initial_stress)
    films = list[PressureLoad]()
    for effect in effects:
        if effect.name in held:
            u = held[effect.name]
            load -= effect.pattern @ u
            if effect.film is not None:
                films.append(effect.film.scaled(float(u[0])))
            for index, columns in effect.columns.items():
                stress[index] = stress[index] + columns @ u
    reference = state
    changed = any(new is not old for new, old in zip(stress, system.initial_stress, strict=True))
    if changed:
        state = replace(state, system=system.with_initial_stress(stress))
    moving = _motion(hub, motion)
    weight = coupling.displacement_weight(moving)
    load = load + coupling.load(moving, coupling.moments(system))
    q = np.zeros(system.size)
    pressure = films[0].scaled(sum(film.pressure for film in films)) if films else None
    if changed or load.any() or weight.any() or films:
        extra = system.inertia.entries(weight) if weight.any() else None
        q = solve_static(state, load, extra, pressure=pressure)
    return SteadyState(reference, state, q, moving, coupling, hub, films)


def _motion(hub: FreeHub | None, motion: RigidMotion | None) -> RigidMotion:
    example = "a steady motion, such as maneuver.start()"
    checks.instance("motion", motion, (RigidMotion, type(None)), example)
    still = AtRest().start()
    if hub is None:
        if motion is not None and motion.angular_acceleration.any():
            raise InputError("motion: expected a steady one, got an angular acceleration; give maneuver.start()")
        return motion or still
    if motion is not None:
        raise InputError("motion: expected none beside a hub, whose angular_velocity it is; leave motion out")
    spin = np.asarray(hub.angular_velocity, dtype=float)
    if not spin.any():
        return still
    if hub.axes not in ("x", "y", "z"):
        raise UnsupportedError(
            f"hub: expected one at rest, or of one axis, for a linear view, got a spin of {spin.tolist()} rad/s about "
            "free axes; set axes = 'x', 'y' or 'z', or prescribe the spin"
        )
    return RigidMotion(spin, np.zeros(3), np.zeros(3))
