r"""Estimated time error of a run: local errors of all steps, summed up as they travel [theory.md 13].

A method of second order errs by ``c (w h)^3`` of its amplitude in a step, c its own (`error_constant`). For harmonic
motion that is ``c h^2`` times the change of the acceleration over the step, at the phases where that is largest; the
mean over all phases is 2/pi of it [Zienkiewicz & Xie, Earthq. Eng. Struct. Dyn. 20 (1991) 871]. Linear motion keeps an
error's size but for damping, so their sum bounds the error of the run; what the maneuver does between the ends of a
step that is long for it comes on top. Displacements are measured by the root of the sum of squares over all nodes.

Accelerations of waves that a step does not resolve say nothing about displacements: one back-substitution takes them
out (`Stepper.resolved`), at a sample of the steps, and the part that stays is used until the next. The same sample
gives the rate at which damping lets errors decay, that of the velocity.

Behind a jump of the forces waves that no step resolves make the change of the acceleration large, and of the error of
a step most belongs to them. Where damping takes them out within a few steps they do not travel: the part of a local
error that its own damping, measured in the sample, leaves after `_BRIEF` steps is summed up, and of the rest the
largest counts while it lasts. Samples that become rarer tell of times that are each longer than all before, so that
what a step resolves is taken from the last of them.

Motions that are close part exponentially where the structure hardens and little damping is left. How fast is not
known without a second run. Measured on films and antennas without damping (8 to 30 1/s at 20 to 30 Hz) it is not less
than a twentieth of the angular frequency of the velocity times the share of the energy that is not quadratic, less the
damping of the errors: where that would have multiplied an error by more than `PARTED` the run is said to have parted,
and its error is that of two motions that know nothing of each other.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np

from tautflex.mechanics.kernel import add_forces
from tautflex.mechanics.products import quadratic_form
from tautflex.motion.kinematics import Segment
from tautflex.numeric import Array, Indices, Places, jit
from tautflex.solvers.remembering import Remembering
from tautflex.solvers.transient.equation import EquationOfMotion
from tautflex.solvers.transient.state import MotionState

# Mean of |cos|, and what measured errors exceed the sum by where the frequency depends on the amplitude.
_MEAN, _SAFETY = 0.5 * np.pi, 1.5
# Steps between two samples at most, and what a sample forgets of those before.
_LONGEST, _MEMORY = 128, 0.8
# The same for what is resolved while samples become rarer.
_RARER = 0.2
# Steps after which what is left of a local error counts as one that stays.
_BRIEF = 3.0
# Growth of errors over angular frequency, and the exponent from which motions have parted.
GROWTH, PARTED = 0.05, 5.5
# Twice the largest displacement: that is how far two motions can be apart.
_APART = 2.0
# Stretches of a maneuver with fewer steps are looked at between the steps' ends, at so many instants.
_FEW_STEPS, _BETWEEN = 20, 8
# Motion across (w) sets the scale unless it is a smaller part of the whole than this.
_ACROSS = 1e-3
_NONE = np.zeros(0)
# Errors worth a warning.
NOTABLE = 0.05


@jit
def _travel(
    state: Array, brief: Array, local: float, time: float, size: float, decay: float, growth: float
) -> None:  # fmt: skip
    stays = np.exp(-_BRIEF * size * max(brief[1] - decay, 0.0))
    state[0] = state[0] * np.exp(-decay * size) + stays * local
    brief[0] = max(brief[0] * np.exp(-brief[1] * size), (1.0 - stays) * local)
    state[1] = max(state[1], state[0] + brief[0])
    state[2] = max(state[2] + growth * size, 0.0)
    state[3] = max(state[3], state[2])
    if local > state[4]:
        state[4], state[5] = local, time


@jit
def travelled(
    state: Array, brief: Array, local: Array, times: Array, size: float, decay: float, growth: float
) -> None:  # fmt: skip
    """Sum up local errors of steps of a size [s] that end at these times, with rates of decay and growth [1/s].

    ``state`` holds error, its largest value, exponent of the growth and its largest value, the largest local error and
    its time, the largest sums of squares of all displacements and of those across; ``brief`` the error that is soon
    gone and the rate [1/s] at which damping takes out local errors themselves.
    """
    for n in range(local.size):
        _travel(state, brief, local[n], times[n], size, decay, growth)


@jit
def _squares(measured: Array, q: Array, before: Array, after: Array) -> tuple[float, float, float]:
    """Sums of squares of all displacements, of those across, and of all changes of the acceleration."""
    place, across, change = 0.0, 0.0, 0.0
    for i in range(q.size):
        square, d = q[i] * q[i], after[i] - before[i]
        place += measured[0, i] * square
        across += measured[1, i] * square
        change += measured[0, i] * d * d
    return place, across, change


@jit
def _damped(start: Indices, column: Places, damping: Array, vectors: Array, coefficients: Array, x: Array) -> float:
    """``x' C x``."""
    found = quadratic_form(start, column, damping, x)
    for k in range(vectors.shape[0]):
        part = 0.0
        for i in range(x.size):
            part += vectors[k, i] * x[i]
        found += coefficients[k] * part * part
    return found


@jit
def _sum_of_squares(weights: Array, x: Array) -> float:
    total = 0.0
    for i in range(x.size):
        total += weights[i] * x[i] * x[i]
    return total


@jit
def is_sampled(when: Indices) -> bool:
    """Count a step; whether it is to be sampled."""
    when[0] -= 1
    return bool(when[0] < 0)


@jit
def _look(parts: Any, q: Array, v: Array, a: Array, change: Array, error: Array, size: float) -> None:
    """Sample a step of a size [s] from its end, the change of its acceleration and the part of it that is resolved.

    It tells what the step resolves, of damping and how far from quadratic the energy is. ``parts`` are those of a
    `TimeError`.
    """
    (_, brief, rates, measured), (when, pooled, squares), matrices, stiffness, (store, stresses, reference) = parts
    when[2] += 1
    # Uneven, so that no vibration keeps step with the samples.
    when[0] = int(when[1] * (0.75 + 0.5 * (0.618 * when[2] % 1.0)))
    memory = _MEMORY if when[1] == _LONGEST else _RARER
    when[1] = min(_LONGEST, 2 * when[1])
    start, column, mass, damping, vectors, coefficients = matrices
    raw, found = np.sqrt(_sum_of_squares(measured[0], change)), np.sqrt(_sum_of_squares(measured[0], error))
    velocity, acceleration = quadratic_form(start, column, mass, v), quadratic_form(start, column, mass, a)
    loss = _damped(start, column, damping, vectors, coefficients, v)
    for k in range(pooled.size):
        pooled[k] *= memory if k < 2 else _MEMORY
    pooled[0] += size * size * raw
    pooled[1] += size * size * found
    pooled[2] += velocity
    pooled[3] += acceleration
    squares[0] += acceleration
    squares[1] += velocity
    rates[0] = pooled[1] / pooled[0] if pooled[0] > 0.0 else 1.0
    if not velocity > 0.0:
        return
    if loss > 0.0:
        # Times are averaged, not rates: stiff waves that are gone at once say nothing about the error that stays.
        pooled[6] += 1.0
        pooled[7] += velocity / loss
        rates[1] = 0.5 * pooled[6] / pooled[7]
    fastest = GROWTH * np.sqrt(pooled[3] / pooled[2])
    lost = 0.5 * _damped(start, column, damping, vectors, coefficients, error)
    lost /= max(quadratic_form(start, column, mass, error), 1e-300)
    if lost < fastest:
        extended, energy = np.zeros(q.size + 1), 0.0
        for i in range(q.size):
            extended[i] = q[i]
            energy -= reference[i] * q[i]
        energy += add_forces(store, extended, extended, stresses, False, True, False)
        linear = 0.5 * quadratic_form(stiffness[0], stiffness[1], stiffness[2], q)
        pooled[4] += abs(energy - linear)
        pooled[5] += min(abs(energy), abs(linear))
        fastest *= pooled[4] / max(pooled[4] + pooled[5], 1e-300)
    rates[2], brief[1] = fastest - lost, max(lost, 0.0)


@jit
def see_step(parts: Any, q: Array, v: Array, a: Array, before: Array, error: Array, time: float, size: float) -> None:
    """Take in a step of a size [s] from its end and the acceleration at its start; ``error`` is for `_look`."""
    state, brief, rates, measured = parts[0]
    if error.size:
        _look(parts, q, v, a, a - before, error, size)
    place, across, change = _squares(measured, q, before, a)
    state[6], state[7] = max(state[6], place), max(state[7], across)
    _travel(state, brief, size * size * np.sqrt(change) * rates[0], time, size, rates[1], rates[2])


class ErrorSum(Remembering):
    """What all plants sum up."""

    MEMORY: ClassVar[tuple[str, ...]] = ("state", "brief", "missed", "_squares")

    def __init__(self) -> None:
        self.state, self.brief, self.missed = np.zeros(8), np.zeros(2), 0.0
        self._squares = np.zeros(2)

    def add(self, local: Array, times: Array, size: float, decay: float, growth: float) -> None:
        """Take in local errors over c of steps, see `travelled`."""
        travelled(self.state, self.brief, local, times, size, decay, growth)

    def add_speeds(self, acceleration: float, velocity: float) -> None:
        """Take in squares of accelerations and velocities in the mass norm."""
        self._squares += acceleration, velocity

    @property
    def frequency(self) -> float:
        """Angular frequency of the velocity [rad/s]."""
        return float(np.sqrt(self._squares[0] / self._squares[1])) if self._squares[1] > 0.0 else 0.0

    @property
    def parted(self) -> bool:
        """Whether close motions have parted."""
        return bool(self.state[3] > PARTED)

    def value(self, constant: float) -> float:
        """Estimated error over the largest displacement, for a method's constant c."""
        all_of_it, across = np.sqrt(self.state[6:])
        scale = max(float(across if across > _ACROSS * all_of_it else all_of_it), 1e-300)
        error = min(_SAFETY * _MEAN * constant * float(self.state[1]) / scale, _APART)
        return (_APART if self.parted and error > 0.0 else error) + self.missed / scale

    def warnings(self, error: float, step: float) -> list[str]:
        """Sentences about the error of a run with this time step [s]; empty if there is nothing to say."""
        if self.parted and error > 0.0:
            return [
                "close motions part exponentially in this run: the structure hardens and little damping is left, so "
                "that displacements after a few periods depend on the time step whatever its size; trust energies, "
                "spectra and averages, or add damping"
            ]
        if not error > NOTABLE:
            return []
        told = f"{error:.0%}" if error < 10.0 else "more than ten times"
        better = step * min(np.sqrt(0.5 * NOTABLE / error), 0.5)
        return [
            f"the time steps leave an estimated error of {told} of the largest displacement, most of it from about t = "
            f"{self.state[5]:.3g} s on; set time_step = {rounded_down(better):.2g} s or less"
        ]


def rounded_down(step: float) -> float:
    """Step [s] with two digits that is not above the given one."""
    unit = 10.0 ** (np.floor(np.log10(step)) - 1)
    return float(np.floor(step / unit * (1.0 + 1e-12)) * unit)


class TimeError(ErrorSum):
    """Follows the steps of a run of the full model.

    Parameters
    ----------
    equation
        Equation of motion.
    resolved
        Takes out of a vector what the last step did not resolve, see `Stepper.resolved`.
    """

    MEMORY = (*ErrorSum.MEMORY, "_when", "_pooled", "_rates")

    def __init__(self, equation: EquationOfMotion, resolved: Callable[[MotionState, Array], Array]) -> None:
        super().__init__()
        self._nodes, self._resolved = equation.system.model.nodes, resolved
        system, products = equation.system, equation.products
        places = system.place[system.model.translation_dofs]
        measured = np.zeros((2, system.size + 1))
        measured[0, places] = measured[1, places[:, 2]] = 1.0
        # The unknowns that count for all displacements and for those across (1, else 0), shape (2, size).
        self._measured = np.ascontiguousarray(measured[:, :-1])
        # Steps until the next sample, until the one after that at most, and samples so far.
        self._when = np.array([0, 1, 0])
        # Local errors as they are and resolved; v'Mv, a'Ma; energies that are not and that are quadratic; samples, and
        # their v'Mv / v'Cv [s].
        self._pooled = np.zeros(8)
        # Part of the local error that is resolved, decay and growth [1/s].
        self._rates = np.array([1.0, 0.0, 0.0])
        pattern, workspace = system.pattern, equation.workspace
        self._matrices: Any = (
            products.start, products.column, products.mass, products.damping, products.vectors, products.coefficients,
        )  # fmt: skip
        # Symmetric: columns are rows as well.
        entries = equation.state.tangent_entries
        self._stiffness: Any = pattern.column_start.astype(np.int64), pattern.rows.astype(np.uint32), entries
        self._elements: Any = workspace.store, workspace.stresses, equation.state.reference_force

    @property
    def parts(self) -> Any:
        """What `see_step` reads and writes."""
        sums = (self.state, self.brief, self._rates, self._measured), (self._when, self._pooled, self._squares)
        return *sums, self._matrices, self._stiffness, self._elements

    def step(self, at: MotionState, end: MotionState, segment: Segment) -> None:
        """See an accepted step."""
        size = end.time - at.time
        if at.jerk is None:
            self._when[:2] = 0, 1
        error = self._resolved(end, end.a - at.a) if is_sampled(self._when) else _NONE
        see_step(self.parts, end.q, end.v, end.a, at.a, error, end.time, size)
        self.missed += missed_between(self._nodes, at.time, size, segment)


def long_for(segment: Segment, size: float) -> bool:
    """Whether a stretch of the maneuver is so long that steps of a size [s] miss nothing of it."""
    return segment.end - segment.start > _FEW_STEPS * size


def missed_between(nodes: Array, start: float, size: float, segment: Segment) -> float:
    """Displacement that a short motion of the frame makes between the ends of a step, beside what they tell [m]."""
    if long_for(segment, size):
        return 0.0

    def push(time: float) -> Array:
        motion = segment.motion(time)
        return nodes @ (motion.euler + motion.centrifugal).T + motion.origin_acceleration

    first, last = push(start), push(start + size)
    shares = (np.arange(_BETWEEN) + 0.5) / _BETWEEN
    missed = [np.linalg.norm(push(start + s * size) - (1.0 - s) * first - s * last) for s in shares]
    return 0.25 * size * size * float(max(missed))
