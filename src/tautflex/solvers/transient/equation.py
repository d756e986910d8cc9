"""The equation of motion (49): its forces, the start of a run and what a jump of the rigid motion changes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tautflex.mechanics.dampings.rayleigh import Rayleigh
from tautflex.mechanics.loads.inputs import InputSet
from tautflex.mechanics.mass_damping import MassDamping
from tautflex.motion.coupling import Coupling
from tautflex.motion.kinematics import RigidMotion
from tautflex.solvers.linear.factorization import SymmetricFactorization
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.transient.status import Statistics

Array = NDArray[np.float64]


@dataclass
class MotionState:
    """State of the structure at one instant.

    Parameters
    ----------
    time
        [s].
    q, v, a
        Free unknowns, their velocities and accelerations, shape (size,).
    forces
        All forces but inertia at this instant, shape (size,); None until a method asks for them.
    jerk
        Difference quotient of the acceleration over the last step, shape (size,); None after a jump.
    internal
        Internal forces at this instant, shape (size,); None until a method asks for them.
    """

    time: float
    q: Array
    v: Array
    a: Array
    forces: Array | None = None
    jerk: Array | None = None
    internal: Array | None = None


@dataclass(frozen=True)
class MotionTerms:
    """Rotating-frame terms at one instant: G = M(velocity), K_T = M(displacement), Q_T = load."""

    key: tuple[float, ...]
    velocity: Array
    displacement: Array
    load: Array


@dataclass
class EquationOfMotion:
    """Forces of ``M a + P(q, v, t) = 0`` [paper (49)] for one run.

    Parameters
    ----------
    state
        Prestressed state.
    damping
        Damping model.
    coupling
        Switches of the rotating-frame terms.
    statistics
        Where the work is counted.
    inputs
        Forces, tensions and temperatures in time; None is none.
    """

    state: PrestressedState
    damping: Rayleigh
    coupling: Coupling
    statistics: Statistics = field(default_factory=Statistics)
    inputs: InputSet | None = None

    def __post_init__(self) -> None:
        self.system = self.state.system
        self.workspace = self.system.workspace()
        self.inertia = self.system.inertia
        self.damping_entries = self.damping.entries(self.inertia.mass_entries, self.state.tangent_entries)
        self.products = MassDamping(self.system.pattern, self.inertia.mass_entries, self.damping_entries)
        self._mass_factor = SymmetricFactorization(self.system.pattern)
        self._motion: RigidMotion | None = None
        self._terms = MotionTerms((), np.zeros((3, 3)), np.zeros((3, 3)), np.zeros(self.system.size))
        self.input_load = np.zeros(self.system.size)

    def motion_terms(self, motion: RigidMotion) -> MotionTerms:
        """Gyroscopic and K_T matrices and the load of a motion; kept while the motion does not change."""
        if motion is self._motion:
            return self._terms
        self._motion = motion
        key = (*motion.angular_velocity, *motion.angular_acceleration, *motion.origin_acceleration)
        if self._terms.key == key:
            return self._terms
        self._terms = MotionTerms(
            key,
            self.coupling.velocity_weight(motion),
            self.coupling.displacement_weight(motion),
            self.coupling.load(motion, self.inertia),
        )
        return self._terms

    def set_time(self, time: float, before: float = np.inf) -> None:
        """Apply the inputs of an instant; a jump at ``before`` is not met yet."""
        if self.inputs:
            instant = min(time, float(np.nextafter(before, -np.inf)))
            self.input_load = self.inputs.load(instant)
            self.workspace.change_initial_stress(self.inputs.stress(instant))

    def force(self, q: Array) -> Array:
        """Internal force above the reference."""
        self.statistics.force_evaluations += 1
        force, _ = self.workspace.force(q)
        force -= self.state.reference_force
        return force

    def average_force(self, start: Array, end: Array) -> Array:
        """Internal force above the reference, of the average stress between two states."""
        self.statistics.force_evaluations += 1
        force = self.workspace.average_force(start, end)
        force -= self.state.reference_force
        return force

    def frame_forces(self, q: Array, v: Array, terms: MotionTerms) -> Array:
        """Forces of damping and of the moving frame."""
        total = terms.load - self.input_load
        if self.products.damped:
            total += self.products.damping_product(v)
        if terms.velocity.any():
            total += self.inertia.apply(terms.velocity, v)
        if terms.displacement.any():
            total += self.inertia.apply(terms.displacement, q)
        return total

    def start(self, time: float, q: Array, v: Array, motion: RigidMotion) -> MotionState:
        """State with the acceleration that balances all forces at ``time``."""
        self.set_time(time)
        forces = self.force(q) + self.frame_forces(q, v, self.motion_terms(motion))
        return MotionState(time, q, v, self.mass_solve(-forces), forces)

    def jump(self, at: MotionState, before: RigidMotion, after: RigidMotion) -> MotionState:
        """Same position and velocity under another rigid motion; the acceleration takes up the jump of the forces.

        Only the change is solved for: re-computing the whole acceleration would throw the small imbalance that a
        collocation method leaves in the stiff directions into it.
        """
        self.set_time(at.time, at.time)
        old = self._all_forces(at, before)
        self.set_time(at.time)
        change = self._all_forces(at, after) - old
        if not change.any():
            return at
        forces = None if at.forces is None else at.forces + change
        return MotionState(at.time, at.q, at.v, at.a + self.mass_solve(-change), forces)

    def _all_forces(self, at: MotionState, motion: RigidMotion) -> Array:
        """Forces that may jump; the internal ones do where tension or temperature does."""
        total = self.frame_forces(at.q, at.v, self.motion_terms(motion))
        return total + self.force(at.q) if self.inputs else total

    def count(self, *factors: SymmetricFactorization) -> None:
        """Bring the counters of the mass factors and of others into the statistics."""
        every = (self._mass_factor, *factors)
        self.statistics.factorizations = sum(factor.factorizations for factor in every)
        self.statistics.back_substitutions = sum(factor.solves for factor in every)

    def mass_solve(self, right: Array) -> Array:
        """Solve with the consistent mass matrix, shape (size,)."""
        if not self._mass_factor.ready:
            self._mass_factor.factorize(self.inertia.mass_entries)
        return self._mass_factor.solve(right)
