"""Supports that move in a run: where they are, and what the structure feels of it beside its strains."""

from __future__ import annotations

import numpy as np

from tautflex.mechanics.dampings.damping import LinearStructure
from tautflex.mechanics.dampings.matrix import DampingMatrix
from tautflex.mechanics.loads.inputs import InputSet
from tautflex.mechanics.springs import damper_rates
from tautflex.mechanics.workspace import Workspace
from tautflex.numeric import Array
from tautflex.solvers.linear.factorization import SymmetricFactorization
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.transient.accuracy.books import DAMPING, FRAME
from tautflex.solvers.transient.state import MotionState, MotionTerms


class MovedSupports:
    """All supports that move in a run, at the instant that is set.

    Elements see them where they are. Mass and damping couple them to the free unknowns, ``M_fs s'' + C_fs s'``, and
    the forces of a frame that turns do, ``M(Z)_fs``.

    Parameters
    ----------
    state
        Prestressed state.
    matrix
        Damping of the free unknowns.
    inputs
        What moves them.

    Attributes
    ----------
    system
        The structure with n moved unknowns behind the free ones.
    workspace
        Forces and tangents on the free ones, with elements that see the moved ones.
    rate
        Velocities of the moved unknowns at the instant, shape (n,).
    """

    def __init__(self, state: PrestressedState, matrix: DampingMatrix, inputs: InputSet) -> None:
        free, self.system, supports = state.system, inputs.whole, inputs.moved
        system, dofs = self.system, self.system.moved
        self._courses = [each.course for each in supports]
        self._shares = np.zeros((len(dofs), len(supports)))
        for column, each in enumerate(supports):
            self._shares[np.searchsorted(dofs, each.dofs), column] += each.shares
        self.workspace = Workspace(system.store, system.initial_stress, free.pattern, free.upper_slots, len(dofs))
        self.rate = np.zeros(len(dofs))
        tangent = system.tangent(np.zeros(system.size))
        # Of s alone: forces on all unknowns per number.
        unit = np.concatenate([np.zeros((free.size, len(supports))), self._shares])
        stiffness = (system.pattern.symmetric_matrix(tangent) @ unit)[: free.size]
        self._mass = system.inertia.mass_matrix @ unit
        damping = LinearStructure(system, tangent, state.linear.modes).entries(matrix)
        self._damping = system.pattern.symmetric_matrix(damping) @ unit
        own = matrix.rank - len(free.dampers[1])
        if matrix.rank:
            rates = (system.expansion.T @ damper_rates(system.model)[0].T).T @ unit
            if own:
                factor = SymmetricFactorization(free.pattern)
                factor.factorize(state.tangent_entries)
                answers = np.array([factor.solve(column) for column in stiffness.T]).T
                rates = np.concatenate([matrix.vectors[:own] @ answers, rates])
            weighed = matrix.coefficients[:, None] * rates
            self._damping[: free.size] += matrix.vectors.T @ weighed
            self._resisting = self._shares.T @ self._damping[free.size :] + rates.T @ weighed
        else:
            self._resisting = self._shares.T @ self._damping[free.size :]
        self._now, self._size = np.zeros((3, len(supports))), free.size

    def set_time(self, time: float) -> None:
        """Bring the supports where they are at an instant [s]."""
        self._now = np.array([course(time) for course in self._courses]).T
        self.workspace.held[:], self.rate[:] = self._shares @ self._now[0], self._shares @ self._now[1]

    def load(self, terms: MotionTerms) -> Array:
        """Forces of inertia, damping and the turning frame on the free unknowns, left-hand side, shape (size,)."""
        _, velocity, acceleration = self._now
        force = (self._mass @ acceleration + self._damping @ velocity)[: self._size]
        still = np.zeros(self._size)
        for weight, moved in ((terms.velocity, self.rate), (terms.displacement, self.workspace.held)):
            if weight.any():
                force += self.system.inertia.apply(weight, np.concatenate([still, moved]))[: self._size]
        return force

    def keep_books(self, work: Array, at: MotionState, end: MotionState) -> None:
        """Add to the work of a step, whose end is set, what dampers take of the supports' motion.

        It follows the books' rule for ``v' C_ff v``: what moves as a whole leaves nothing.
        """
        moved, size = end.q - at.q, end.time - at.time
        went = self._now[0] - np.array([course(at.time)[0] for course in self._courses])
        v, rate, own = moved / size, went / size, self._damping[: self._size]
        if not at.books.own.size:  # behind a jump the forces of the step's equilibrium stand for the whole step
            instant = end.time + end.books.late
            v, rate = end.v, np.array([course(instant)[1] for course in self._courses])
        taken = float(moved @ own @ rate + (v @ own + self._resisting @ rate) @ went)
        work[DAMPING] += taken
        work[FRAME] -= taken

    def whole(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Displacements and velocities of free and moved unknowns, shapes (size + n,)."""
        return np.concatenate([q, self.workspace.held]), np.concatenate([v, self.rate])

    def translations(self, q: Array) -> Array:
        """Displacement of all nodes [m], shape (node, 3)."""
        return self.system.translations(np.concatenate([q, self.workspace.held]))

    def kinetic_energy(self, v: Array) -> float:
        """Of the motion relative to the floating frame, that of the supports too [J]."""
        moving = np.concatenate([v, self.rate])
        return 0.5 * float(moving @ (self.system.inertia.mass_matrix @ moving))
