"""State of a plant from what is measured: at once where the sensors tell all of it, else by a Kalman filter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from tautflex.control.law import LawMatrices
from tautflex.control.linear import LinearPlant
from tautflex.control.riccati import kalman_filter
from tautflex.control.signals import LoopSpec, labelled
from tautflex.errors import InputError
from tautflex.numeric import Array

# Columns of the output matrix that are shorter than this part of the longest are not seen.
_SEEN = 1e-9


class Noise(NamedTuple):
    """What a filter is told: random accelerations of coordinates and hub, and noise of the measurement by name."""

    coordinates: float
    hub: float
    measurement: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Estimator:
    """State at a sample from measurement, last command and what was expected.

    Parameters
    ----------
    plant
        Plant in discrete time.
    gain
        ``x = expected + gain (y - C expected - D last command)``, shape (state, output). A plant that is held over
        an interval shows what follows its command at once with the *last* one.
    """

    plant: LinearPlant
    gain: Array

    def update(self, expected: Array, last: Array, measurement: Array) -> Array:
        """State at a sample, shape (state,)."""
        plant = self.plant
        return np.asarray(expected + self.gain @ (measurement - plant.level - plant.C @ expected - plant.D @ last))

    def expect(self, x: Array, command: Array) -> Array:
        """State at the next sample, shape (state,)."""
        return np.asarray(self.plant.A @ x + self.plant.B @ command)

    def with_gain(self, gain: Array, forward: Array) -> LawMatrices:
        """Matrices of ``u = -gain x + forward r``, r being the numbers of the reference, on expected x and last u."""
        plant, n = self.plant, len(self.plant.A)
        known = np.concatenate([np.eye(n) - self.gain @ plant.C, -self.gain @ plant.D], axis=1)
        fresh = np.concatenate([self.gain, np.zeros((n, forward.shape[1]))], axis=1)
        c = -gain @ known
        d = -gain @ fresh
        d[:, self.gain.shape[1] :] += forward
        return LawMatrices.of(
            np.concatenate([plant.A @ known + plant.B @ c, c]),
            np.concatenate([plant.A @ fresh + plant.B @ d, d]),
            c,
            d,
            plant.level,
        )


def model_for(law: str, spec: LoopSpec, modes: int | None) -> LinearPlant:
    """Continuous model of a loop with its lowest coordinates alone; None is all."""
    plant = spec.plant(law)
    return plant if modes is None else plant.truncated(modes)


def direct_estimator(plant: LinearPlant, interval: float) -> Estimator | None:
    """Estimator of measurements that tell the whole state at once (least squares); None if they do not.

    It takes drives and sensors as prompt.
    """
    scale = np.linalg.norm(plant.C, axis=0)
    if plant.C.shape[0] < plant.C.shape[1] or np.any(scale == 0.0):
        return None
    left, values, right = np.linalg.svd(plant.C / scale, full_matrices=False)
    if values[-1] <= _SEEN * values[0]:
        return None
    return Estimator(replace(plant, late=None).discretize(interval), (right.T / values @ left.T) / scale[:, None])


def kalman_estimator(plant: LinearPlant, spec: LoopSpec, noise: Noise) -> Estimator:
    """Estimator by the steady Kalman filter.

    Raises
    ------
    InputError
        If a measurement has no noise, or they do not tell enough.
    """
    sizes = spec.noise
    for k, value in labelled("measurement_noise", noise.measurement, plant.outputs, least=False).items():
        sizes[k] = value
    # A measurement that tells nothing needs no noise of its own.
    sizes[~plant.C.any(axis=1) & (sizes == 0.0)] = 1.0
    if not sizes.all():
        label = plant.outputs[int(np.argmin(sizes))]
        raise InputError(
            f"measurement_noise: expected a standard deviation > 0 of every measurement, got none of {label!r}; give "
            f"measurement_noise = {{{label!r}: 1e-6}}, or noise of its sensor"
        )
    half, axes = plant.half, plant.axes
    kicks = np.concatenate([np.full(axes, noise.hub), np.full(half - axes, noise.coordinates)]) * spec.interval
    discrete = plant.discretize(spec.interval)
    process = np.zeros(discrete.A.shape)
    process[half : 2 * half, half : 2 * half] = np.diag(kicks**2)
    return Estimator(discrete, kalman_filter(discrete, process, np.diag(sizes**2)).gain)


def any_estimator(plant: LinearPlant, spec: LoopSpec, noise: Noise) -> Estimator:
    """Estimator at once where that is possible, else a Kalman filter."""
    return direct_estimator(plant, spec.interval) or kalman_estimator(plant, spec, noise)


def steady_reference(plant: LinearPlant, known: LinearPlant, feedforward: bool) -> tuple[Array, Array]:
    """State and command that follow a reference, from its numbers: shapes (state, 3 axes) and (input, 3 axes).

    The state is that of ``known``, the plant in discrete time. What waits in drives is the command; what waits in
    sensors is what there was to see then.

    Under a steady angular acceleration the structure leans back as it does at rest under that load, and the commands
    turn it all; without feedforward they and it are zero.

    Raises
    ------
    InputError
        If the commands cannot turn the hub about all of its axes.
    """
    h, half = plant.axes, plant.half
    state, command = np.zeros((2 * half, 3 * h)), np.zeros((len(plant.inputs), 3 * h))
    state[np.arange(h), np.arange(h)] = 1.0
    state[half + np.arange(h), h + np.arange(h)] = 1.0
    if feedforward and h:
        eta, turn = plant.positions, half + np.arange(h)
        lean = -np.linalg.solve(plant.A[np.ix_(eta + half, eta)], plant.B[eta + half])
        reach = plant.B[turn] + plant.A[np.ix_(turn, eta)] @ lean
        push = np.linalg.pinv(reach)
        if not np.allclose(reach @ push, np.eye(h), atol=1e-6):
            raise InputError(
                "feedforward: expected commands that turn the hub about all of its axes, got some that do not; add a "
                "HubTorque, or set feedforward to false"
            )
        command[:, 2 * h :] = push
        state[np.ix_(eta, np.arange(2 * h, 3 * h))] = lean @ push
    seen, further = plant.C @ state + plant.D @ command, [state]
    for of_output, place, samples in known.carried:
        ago = samples * (known.interval or 0.0)
        before = np.kron([[1.0, -ago, 0.5 * ago**2], [0.0, 1.0, -ago], [0.0, 0.0, 1.0]], np.eye(h))
        further.append((seen[place] @ before if of_output else command[place])[None])
    return np.concatenate(further), command
